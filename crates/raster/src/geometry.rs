//! What stands where, on the device: triangles for the prepass, for shading and for shadow volumes, materials, textures, and the
//! indirect light at their lattice points. What did not move or change is left as it is.

use crate::{
    device::{Device, RasterError},
    frame::NONE,
    textures::Textures,
    volume::Caster,
    welded::Welded,
};
use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use lightmend_scene::{Configuration, Lattice, Mesh, Motion, Object};
use rayon::prelude::*;
use std::{ops::Range, sync::Arc};

/// A corner of a triangle that is drawn.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct PrepassVertex {
    position: [f32; 3],
    /// Number of the source triangle among all.
    triangle: u32,
}

/// A source triangle as it is shaded. Twin of `Triangle` in `composition.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct GpuTriangle {
    a: [f32; 3],
    material: u32,
    b: [f32; 3],
    divisions: u32,
    c: [f32; 3],
    front: u32,
    normal: [f32; 3],
    back: u32,
}

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct GpuMaterial {
    reflectance: [f32; 3],
    texture: u32,
}

/// An object and where it lies in the buffers.
pub struct Thing {
    /// Its number in the configuration.
    pub id: usize,
    /// Its name.
    pub name: String,
    /// Cameras look through it.
    pub hidden: bool,
    /// Its surface in the world.
    pub caster: Caster,
    /// Changes when it moves.
    pub version: u64,
    /// Its vertices in the prepass.
    pub vertices: Range<u32>,
    /// The first vertex of its shadow volumes.
    pub first_vertex: u32,
    object: Object,
    motion: Motion,
    first_triangle: u32,
    first_material: u32,
}

/// Indirect light: per object by number and side (front, back), lux per linear Rec. 709 channel at the lattice points in order;
/// nothing where no light ever came.
pub type Indirect = Vec<[Option<Vec<[f32; 3]>>; 2]>;

/// All that stands.
pub struct Geometry {
    /// In order of their numbers.
    pub things: Vec<Thing>,
    /// Number of the first source triangle of each thing, and one past the last.
    pub firsts: Vec<u32>,
    welded: Vec<(Arc<Mesh>, Arc<Welded>)>,
    textures: Textures,
    /// Vertices of the prepass.
    pub prepass: wgpu::Buffer,
    /// Vertices of shadow volumes, in pairs.
    pub volume: wgpu::Buffer,
    /// Source triangles.
    pub triangles: wgpu::Buffer,
    /// Materials of all things.
    pub materials: wgpu::Buffer,
    /// Texture coordinates of the triangles' corners; next to nothing without textures.
    pub uvs: wgpu::Buffer,
    /// Where textures lie.
    pub texture_entries: wgpu::Buffer,
    /// Texels.
    pub texels: wgpu::Buffer,
    /// Indirect light.
    pub irradiance: wgpu::Buffer,
    /// First lattice point of each side of each thing, where it is lit.
    lit: Vec<[u32; 2]>,
    /// Of the last thing that moved.
    version: u64,
    /// What could not be done as the files say.
    pub warnings: Vec<String>,
}

const STORAGE: wgpu::BufferUsages = wgpu::BufferUsages::STORAGE;
const VERTEX: wgpu::BufferUsages = wgpu::BufferUsages::VERTEX;

fn points_in(lattice: &Lattice, t: usize) -> u32 {
    let n = lattice.divisions(t);
    (n + 1) * (n + 2) / 2
}

fn world_positions(positions: &[DVec3], motion: &Motion) -> Vec<DVec3> {
    positions.iter().map(|p| motion.point(*p).as_vec3().as_dvec3()).collect()
}

impl Geometry {
    /// Nothing yet.
    pub fn new(device: &Device) -> Result<Geometry, RasterError> {
        Ok(Geometry {
            things: Vec::new(),
            firsts: vec![0],
            welded: Vec::new(),
            textures: Textures::default(),
            prepass: device.buffer("vertices", 0, VERTEX)?,
            volume: device.buffer("vertices of shadow volumes", 0, VERTEX)?,
            triangles: device.buffer("triangles", 0, STORAGE)?,
            materials: device.buffer("materials", 0, STORAGE)?,
            uvs: device.buffer("texture coordinates", 0, STORAGE)?,
            texture_entries: device.buffer("textures", 0, STORAGE)?,
            texels: device.buffer("texels", 0, STORAGE)?,
            irradiance: device.buffer("indirect light", 0, STORAGE)?,
            lit: Vec::new(),
            version: 0,
            warnings: Vec::new(),
        })
    }

    /// Whether anything has a texture.
    pub fn textured(&self) -> bool {
        !self.textures.entries.is_empty()
    }

    /// From now on the objects of `configuration` stand here. Returns whether buffers were replaced.
    pub fn show(&mut self, device: &Device, configuration: &Configuration) -> Result<bool, RasterError> {
        let present: Vec<(usize, &Object)> = configuration.objects().collect();
        let same = |(thing, (id, object)): (&Thing, &(usize, &Object))| {
            thing.id == *id && Arc::ptr_eq(&thing.object.mesh, &object.mesh) && thing.hidden == object.hidden_from_camera
        };
        if self.things.len() != present.len() || !self.things.iter().zip(&present).all(same) {
            self.rebuild(device, configuration, &present)?;
            return Ok(true);
        }
        let mut repainted = false;
        for number in 0..self.things.len() {
            let (id, object) = present[number];
            let motion = configuration.object_motion(id);
            if motion != self.things[number].motion {
                self.place(device, number, motion);
            }
            let painted = |(a, b): (&Arc<_>, &Arc<_>)| !Arc::ptr_eq(a, b);
            repainted |= self.things[number].object.materials.iter().zip(&object.materials).any(painted);
            self.things[number].object = object.clone();
        }
        if repainted {
            self.paint(device)?;
        }
        Ok(repainted)
    }

    fn weld(&mut self, present: &[(usize, &Object)]) -> Vec<Arc<Welded>> {
        self.welded.retain(|(mesh, _)| present.iter().any(|(_, object)| Arc::ptr_eq(&object.mesh, mesh)));
        let known = |welded: &[(Arc<Mesh>, Arc<Welded>)], mesh: &Arc<Mesh>| {
            welded.iter().find(|(m, _)| Arc::ptr_eq(m, mesh)).map(|(_, w)| w.clone())
        };
        let mut new: Vec<Arc<Mesh>> = Vec::new();
        for (_, object) in present {
            if known(&self.welded, &object.mesh).is_none() && !new.iter().any(|m| Arc::ptr_eq(m, &object.mesh)) {
                new.push(object.mesh.clone());
            }
        }
        let welded: Vec<_> = new.par_iter().map(|mesh| (mesh.clone(), Arc::new(Welded::new(mesh)))).collect();
        self.welded.extend(welded);
        present.iter().filter_map(|(_, object)| known(&self.welded, &object.mesh)).collect()
    }

    fn rebuild(&mut self, device: &Device, configuration: &Configuration, present: &[(usize, &Object)]) -> Result<(), RasterError> {
        let shapes = self.weld(present);
        let (mut vertices, mut pairs, mut triangles, mut materials) = (0u32, 0u32, 0u32, 0u32);
        self.firsts = vec![0];
        self.things = present
            .iter()
            .zip(shapes)
            .map(|((id, object), welded)| {
                self.version += 1;
                let motion = configuration.object_motion(*id);
                let positions = world_positions(&welded.positions, &motion);
                let thing = Thing {
                    id: *id,
                    name: object.name.clone(),
                    hidden: object.hidden_from_camera,
                    version: self.version,
                    vertices: vertices..vertices + 3 * welded.faces.len() as u32,
                    first_vertex: pairs,
                    object: (*object).clone(),
                    motion,
                    first_triangle: triangles,
                    first_material: materials,
                    caster: Caster::new(welded, positions),
                };
                vertices = thing.vertices.end;
                pairs += thing.caster.positions.len() as u32;
                triangles += object.mesh.triangles.len() as u32;
                materials += object.materials.len() as u32;
                self.firsts.push(triangles);
                thing
            })
            .collect();
        let bytes = |count: u32, size: usize| u64::from(count) * size as u64;
        self.prepass = device.buffer("vertices", bytes(vertices, size_of::<PrepassVertex>()), VERTEX)?;
        self.volume = device.buffer("vertices of shadow volumes", bytes(2 * pairs, 16), VERTEX)?;
        self.triangles = device.buffer("triangles", bytes(triangles, size_of::<GpuTriangle>()), STORAGE)?;
        self.lit = vec![[NONE; 2]; self.things.len()];
        self.paint(device)?;
        for number in 0..self.things.len() {
            self.place(device, number, self.things[number].motion);
        }
        Ok(())
    }

    /// Writes all materials and textures.
    fn paint(&mut self, device: &Device) -> Result<(), RasterError> {
        let most = (device.device.limits().max_storage_buffer_binding_size / 4) as usize;
        let mut textures = Textures::default();
        let mut materials: Vec<GpuMaterial> = Vec::new();
        for thing in &self.things {
            materials.extend(thing.object.materials.iter().map(|m| GpuMaterial {
                reflectance: m.reflectance.to_array(),
                texture: textures.maybe(&m.texture, most),
            }));
        }
        if textures.halvings > 0 {
            self.warnings.push("the textures are more than the driver can hold: the largest are drawn coarser".into());
        }
        self.materials = device.filled("materials", bytemuck::cast_slice(&materials), STORAGE)?;
        if !textures.entries.is_empty() {
            let corners = self.things.iter().flat_map(|thing| {
                let mesh = &thing.object.mesh;
                (0..mesh.triangles.len()).flat_map(|t| mesh.uvs.get(t).copied().unwrap_or_default().map(|uv| uv.as_vec2().to_array()))
            });
            let corners: Vec<[f32; 2]> = corners.collect();
            self.uvs = device.filled("texture coordinates", bytemuck::cast_slice(&corners), STORAGE)?;
            self.texture_entries = device.filled("textures", bytemuck::cast_slice(&textures.entries), STORAGE)?;
            self.texels = device.filled("texels", bytemuck::cast_slice(&textures.texels), STORAGE)?;
        }
        textures.texels = Vec::new();
        self.textures = textures;
        Ok(())
    }

    /// Puts a thing where it now stands.
    fn place(&mut self, device: &Device, number: usize, motion: Motion) {
        let thing = &mut self.things[number];
        let moved = thing.motion != motion;
        if moved {
            let positions = world_positions(&thing.caster.welded.positions, &motion);
            thing.caster = Caster::new(thing.caster.welded.clone(), positions);
            thing.motion = motion;
            self.version += 1;
            thing.version = self.version;
        }
        let caster = &thing.caster;
        let corner = |v: u32| caster.positions[v as usize].as_vec3().to_array();
        let vertices: Vec<PrepassVertex> = caster
            .welded
            .faces
            .iter()
            .flat_map(|face| {
                let triangle = thing.first_triangle + face.source;
                face.corners.map(|v| PrepassVertex { position: corner(v), triangle })
            })
            .collect();
        let offset = u64::from(thing.vertices.start) * size_of::<PrepassVertex>() as u64;
        device.queue.write_buffer(&self.prepass, offset, bytemuck::cast_slice(&vertices));
        let pairs: Vec<[f32; 4]> = caster
            .positions
            .iter()
            .flat_map(|p| {
                let [x, y, z] = p.as_vec3().to_array();
                [[x, y, z, 1.0], [x, y, z, 0.0]]
            })
            .collect();
        device.queue.write_buffer(&self.volume, u64::from(thing.first_vertex) * 32, bytemuck::cast_slice(&pairs));
        self.write_triangles(device, number);
    }

    fn write_triangles(&self, device: &Device, number: usize) {
        let thing = &self.things[number];
        let (mesh, lattice) = (&thing.object.mesh, &thing.object.lattice);
        let corners: Vec<Vec3> = mesh.positions.iter().map(|p| thing.motion.point(*p).as_vec3()).collect();
        let mut points = 0;
        let triangles: Vec<GpuTriangle> = (0..mesh.triangles.len())
            .map(|t| {
                let [a, b, c] = mesh.triangles[t].map(|i| corners[i as usize]);
                let [da, db, dc] = [a, b, c].map(|v| v.as_dvec3());
                let normal = (db - da).cross(dc - da).normalize_or_zero().as_vec3();
                let [front, back] = self.lit[number].map(|first| if first == NONE { NONE } else { first + points });
                points += points_in(lattice, t);
                GpuTriangle {
                    a: a.to_array(),
                    material: thing.first_material + u32::from(mesh.material_of[t]),
                    b: b.to_array(),
                    divisions: lattice.divisions(t),
                    c: c.to_array(),
                    front,
                    normal: normal.to_array(),
                    back,
                }
            })
            .collect();
        let offset = u64::from(thing.first_triangle) * size_of::<GpuTriangle>() as u64;
        device.queue.write_buffer(&self.triangles, offset, bytemuck::cast_slice(&triangles));
    }

    /// From now on this indirect light is drawn. Sides that have none cost nothing. Returns whether buffers were replaced.
    pub fn light(&mut self, device: &Device, indirect: &Indirect) -> Result<bool, RasterError> {
        let mut next = 0u32;
        let mut replaced = false;
        let sides = |id: usize| indirect.get(id).map_or([None, None], |sides| sides.each_ref().map(Option::as_ref));
        let places: Vec<[u32; 2]> = self
            .things
            .iter()
            .map(|thing| {
                sides(thing.id).map(|points| {
                    points.map_or(NONE, |points| {
                        next += points.len() as u32;
                        next - points.len() as u32
                    })
                })
            })
            .collect();
        if u64::from(next) * 12 > self.irradiance.size() {
            self.irradiance = device.buffer("indirect light", u64::from(next) * 12, STORAGE)?;
            replaced = true;
        }
        for number in 0..self.things.len() {
            for (points, first) in sides(self.things[number].id).into_iter().zip(places[number]) {
                if let Some(points) = points {
                    device.queue.write_buffer(&self.irradiance, u64::from(first) * 12, bytemuck::cast_slice(points));
                }
            }
            if self.lit[number] != places[number] {
                self.lit[number] = places[number];
                self.write_triangles(device, number);
            }
        }
        Ok(replaced)
    }

    /// The object and its triangle that number `triangle` among all is.
    pub fn source(&self, triangle: u32) -> (usize, usize) {
        let number = self.firsts.partition_point(|first| *first <= triangle) - 1;
        (self.things[number].id, (triangle - self.firsts[number]) as usize)
    }
}
