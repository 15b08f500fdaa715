//! What stands where, on the device: triangles for the prepass, for shading and for shadow volumes, materials, textures, and the
//! indirect light at their lattice points. What did not move or change is left as it is.

use crate::{
    bounds::Bounds,
    device::{Device, RasterError},
    frame::NONE,
    irradiance::{Indirect, Irradiance},
    table::Table,
    textures::Textures,
    volume::Caster,
    welded::Welded,
};
use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use lightmend_scene::{Configuration, Material, Mesh, Motion, Object};
use rayon::prelude::*;
use std::{ops::Range, sync::Arc};
use wgpu::TextureFormat;

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
    /// Whether anything of it has a texture.
    pub textured: bool,
    /// Whether only fronts of it are seen from outside.
    pub outwards: bool,
    /// Its surface in the world, in parts that cast shadows each for itself.
    pub casters: Vec<Caster>,
    /// The first vertex of the shadow volumes of each of them.
    pub firsts: Vec<u32>,
    /// About all of them.
    pub bounds: Bounds,
    /// Changes when it moves.
    pub version: u64,
    /// Its vertices in the prepass.
    pub vertices: Range<u32>,
    object: Object,
    motion: Motion,
    first_triangle: u32,
    first_material: u32,
}

impl Thing {
    fn prepass_vertices(&self) -> Vec<PrepassVertex> {
        let vertices = self.casters.iter().flat_map(|caster| {
            caster.welded.faces.iter().flat_map(|face| {
                let triangle = self.first_triangle + face.source;
                face.corners.map(|v| PrepassVertex { position: caster.positions[v as usize].as_vec3().to_array(), triangle })
            })
        });
        vertices.collect()
    }

    fn volume_vertices(&self) -> Vec<[f32; 4]> {
        let pair = |p: &DVec3| {
            let [x, y, z] = p.as_vec3().to_array();
            [[x, y, z, 1.0], [x, y, z, 0.0]]
        };
        self.casters.iter().flat_map(|caster| &caster.positions).flat_map(pair).collect()
    }

    /// `lit` is the first irradiance of the front and of the back.
    fn triangles(&self, lit: [u32; 2]) -> Vec<GpuTriangle> {
        let (mesh, lattice) = (&self.object.mesh, &self.object.lattice);
        let corners: Vec<Vec3> = mesh.positions.iter().map(|p| self.motion.point(*p).as_vec3()).collect();
        let mut points = 0;
        let triangle = |t: usize| {
            let [a, b, c] = mesh.triangles[t].map(|i| corners[i as usize]);
            let [da, db, dc] = [a, b, c].map(|v| v.as_dvec3());
            // In f64, so that slivers have a normal: the same as the photons'.
            let normal = (db - da).cross(dc - da).normalize_or_zero().as_vec3();
            let [front, back] = lit.map(|first| if first == NONE { NONE } else { first + points });
            points += lattice.points_in(t);
            GpuTriangle {
                a: a.to_array(),
                material: self.first_material + u32::from(mesh.material_of[t]),
                b: b.to_array(),
                divisions: lattice.divisions(t),
                c: c.to_array(),
                front,
                normal: normal.to_array(),
                back,
            }
        };
        (0..mesh.triangles.len()).map(triangle).collect()
    }
}

/// All that stands.
pub struct Geometry {
    /// In order of their numbers.
    pub things: Vec<Thing>,
    /// Number of the first source triangle of each thing, and one past the last.
    pub firsts: Vec<u32>,
    welded: Vec<(Arc<Mesh>, Parts)>,
    /// Vertices of the prepass.
    pub prepass: wgpu::Buffer,
    /// Vertices of shadow volumes, in pairs.
    pub volume: wgpu::Buffer,
    /// Source triangles.
    pub triangles: Table,
    /// Materials of all things.
    pub materials: Table,
    /// Texture coordinates of the triangles' corners; next to nothing without textures.
    pub uvs: Table,
    /// Where textures lie.
    pub texture_entries: Table,
    /// Texels.
    pub texels: Table,
    textures: Textures,
    /// Indirect light.
    pub irradiance: Irradiance,
    /// First lattice point of each side of each thing, where it is lit.
    lit: Vec<[u32; 2]>,
    /// Of the last thing that moved.
    version: u64,
    /// What could not be done as the files say.
    pub warnings: Vec<String>,
}

/// Of all textures together: 256 MB.
const MOST_TEXELS: usize = 1 << 26;

const VERTEX: wgpu::BufferUsages = wgpu::BufferUsages::VERTEX;

/// Diagonal of the boxes of casters, as a share of the scene's reach. Smaller: shadows are drawn in smaller parts of the picture, in more
/// pieces.
const PART: f64 = 1.0 / 2.0;

/// A mesh in parts.
#[derive(Clone)]
struct Parts {
    parts: Arc<[Arc<Welded>]>,
    /// See [`Welded::outwards`].
    outwards: bool,
}

/// Parts where they stand.
fn casters(parts: &[Arc<Welded>], motion: &Motion) -> Vec<Caster> {
    let place = |p: &DVec3| motion.point(*p).as_vec3().as_dvec3();
    parts.iter().map(|part| Caster::new(part.clone(), part.positions.iter().map(place).collect())).collect()
}

fn about(casters: &[Caster]) -> Bounds {
    Bounds::about(casters.iter().flat_map(|caster| [caster.bounds.low, caster.bounds.high]))
}

impl Geometry {
    /// Nothing yet.
    pub fn new(device: &Device) -> Result<Geometry, RasterError> {
        Ok(Geometry {
            things: Vec::new(),
            firsts: vec![0],
            welded: Vec::new(),
            prepass: device.buffer("vertices", 0, VERTEX)?,
            volume: device.buffer("vertices of shadow volumes", 0, VERTEX)?,
            triangles: Table::new(device, "triangles", 0, TextureFormat::Rgba32Uint)?,
            materials: Table::new(device, "materials", 0, TextureFormat::Rgba32Uint)?,
            uvs: Table::new(device, "texture coordinates", 0, TextureFormat::Rg32Float)?,
            texture_entries: Table::new(device, "textures", 0, TextureFormat::Rgba32Uint)?,
            texels: Table::new(device, "texels", 0, TextureFormat::R32Uint)?,
            textures: Textures::default(),
            irradiance: Irradiance::new(device)?,
            lit: Vec::new(),
            version: 0,
            warnings: Vec::new(),
        })
    }

    /// From now on the objects of `configuration` stand here.
    pub fn show(&mut self, device: &Device, configuration: &Configuration) -> Result<(), RasterError> {
        let present: Vec<(usize, &Object)> = configuration.objects().collect();
        let same = |(thing, (id, object)): (&Thing, &(usize, &Object))| {
            thing.id == *id && Arc::ptr_eq(&thing.object.mesh, &object.mesh) && thing.hidden == object.hidden_from_camera
        };
        if self.things.len() != present.len() || !self.things.iter().zip(&present).all(same) {
            return self.rebuild(device, configuration, &present);
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
        if repainted { self.paint(device, false) } else { Ok(()) }
    }

    /// The parts of each object's mesh; `size` is the diagonal of their boxes that suffices.
    fn weld(&mut self, present: &[(usize, &Object)], size: f64) -> Vec<Parts> {
        self.welded.retain(|(mesh, _)| present.iter().any(|(_, object)| Arc::ptr_eq(&object.mesh, mesh)));
        let known = |welded: &[(Arc<Mesh>, Parts)], mesh: &Arc<Mesh>| {
            welded.iter().find(|(m, _)| Arc::ptr_eq(m, mesh)).map(|(_, parts)| parts.clone())
        };
        let mut new: Vec<Arc<Mesh>> = Vec::new();
        for (_, object) in present {
            if known(&self.welded, &object.mesh).is_none() && !new.iter().any(|m| Arc::ptr_eq(m, &object.mesh)) {
                new.push(object.mesh.clone());
            }
        }
        let parts = |mesh: &Arc<Mesh>| {
            let welded = Welded::new(mesh);
            Parts { parts: welded.parts(size).into_iter().map(Arc::new).collect(), outwards: welded.outwards() }
        };
        let welded: Vec<_> = new.par_iter().map(|mesh| (mesh.clone(), parts(mesh))).collect();
        self.welded.extend(welded);
        present.iter().filter_map(|(_, object)| known(&self.welded, &object.mesh)).collect()
    }

    fn rebuild(
        &mut self,
        device: &Device,
        configuration: &Configuration,
        present: &[(usize, &Object)],
    ) -> Result<(), RasterError> {
        let shapes = self.weld(present, configuration.reach() * PART);
        let (mut vertices, mut pairs, mut triangles, mut materials) = (0u32, 0u32, 0u32, 0u32);
        self.firsts = vec![0];
        // What stays keeps its light until there is a new one.
        let stays = |id: usize, object: &Object| {
            let known = self.things.iter().position(|t| t.id == id && Arc::ptr_eq(&t.object.mesh, &object.mesh));
            known.map_or([NONE; 2], |number| self.lit[number])
        };
        self.lit = present.iter().map(|(id, object)| stays(*id, object)).collect();
        self.things = present
            .iter()
            .zip(shapes)
            .map(|((id, object), parts)| {
                self.version += 1;
                let motion = configuration.object_motion(*id);
                let casters = casters(&parts.parts, &motion);
                let faces: usize = parts.parts.iter().map(|part| part.faces.len()).sum();
                let firsts = casters.iter().map(|caster| {
                    pairs += caster.positions.len() as u32;
                    pairs - caster.positions.len() as u32
                });
                let thing = Thing {
                    firsts: firsts.collect(),
                    bounds: about(&casters),
                    id: *id,
                    name: object.name.clone(),
                    hidden: object.hidden_from_camera,
                    textured: false,
                    outwards: parts.outwards,
                    version: self.version,
                    vertices: vertices..vertices + 3 * faces as u32,
                    object: (*object).clone(),
                    motion,
                    first_triangle: triangles,
                    first_material: materials,
                    casters,
                };
                vertices = thing.vertices.end;
                triangles += object.mesh.triangles.len() as u32;
                materials += object.materials.len() as u32;
                self.firsts.push(triangles);
                thing
            })
            .collect();
        let bytes = |count: u32, size: usize| u64::from(count) * size as u64;
        self.prepass = device.buffer("vertices", bytes(vertices, size_of::<PrepassVertex>()), VERTEX)?;
        self.volume = device.buffer("vertices of shadow volumes", bytes(2 * pairs, 16), VERTEX)?;
        self.triangles = Table::new(device, "triangles", 4 * u64::from(triangles), TextureFormat::Rgba32Uint)?;
        let things = &self.things;
        let all: Vec<PrepassVertex> = things.iter().flat_map(Thing::prepass_vertices).collect();
        device.queue.write_buffer(&self.prepass, 0, bytemuck::cast_slice(&all));
        let all: Vec<[f32; 4]> = things.iter().flat_map(Thing::volume_vertices).collect();
        device.queue.write_buffer(&self.volume, 0, bytemuck::cast_slice(&all));
        let all: Vec<GpuTriangle> = things.iter().zip(&self.lit).flat_map(|(thing, lit)| thing.triangles(*lit)).collect();
        self.triangles.write(device, 0, bytemuck::cast_slice(&all));
        self.paint(device, true)
    }

    /// Writes all materials; textures only if there are others than before, their coordinates also if the triangles are others.
    fn paint(&mut self, device: &Device, other_triangles: bool) -> Result<(), RasterError> {
        let materials = self.things.iter().flat_map(|thing| thing.object.materials.iter());
        let used = Textures::used(materials.clone().filter_map(|m| m.texture.as_ref()));
        let other_textures = !self.textures.are(&used);
        if other_textures {
            let (textures, texels) = Textures::new(used, MOST_TEXELS);
            if textures.halvings > 0 {
                self.warnings.push("the textures have more than 2^26 texels together: the last ones are drawn coarser".into());
            }
            self.texture_entries = Table::filled(device, "textures", &textures.entries, TextureFormat::Rgba32Uint)?;
            self.texels = Table::filled(device, "texels", &texels, TextureFormat::R32Uint)?;
            self.textures = textures;
        }
        let gpu = |m: &Arc<Material>| GpuMaterial {
            reflectance: m.reflectance.to_array(),
            texture: m.texture.as_ref().map_or(NONE, |texture| self.textures.number(texture)),
        };
        let materials: Vec<GpuMaterial> = materials.map(gpu).collect();
        self.materials = Table::filled(device, "materials", &materials, TextureFormat::Rgba32Uint)?;
        for thing in &mut self.things {
            thing.textured = thing.object.materials.iter().any(|m| m.texture.is_some());
        }
        if (other_textures || other_triangles) && !self.textures.entries.is_empty() {
            let corners = self.things.iter().flat_map(|thing| {
                let mesh = &thing.object.mesh;
                (0..mesh.triangles.len())
                    .flat_map(|t| mesh.uvs.get(t).copied().unwrap_or_default().map(|uv| uv.as_vec2().to_array()))
            });
            let corners: Vec<[f32; 2]> = corners.collect();
            self.uvs = Table::filled(device, "texture coordinates", &corners, TextureFormat::Rg32Float)?;
        }
        Ok(())
    }

    /// Puts a thing where it now stands.
    fn place(&mut self, device: &Device, number: usize, motion: Motion) {
        self.version += 1;
        let thing = &mut self.things[number];
        let parts: Vec<_> = thing.casters.iter().map(|caster| caster.welded.clone()).collect();
        thing.casters = casters(&parts, &motion);
        thing.bounds = about(&thing.casters);
        (thing.motion, thing.version) = (motion, self.version);
        let thing = &self.things[number];
        let offset = u64::from(thing.vertices.start) * size_of::<PrepassVertex>() as u64;
        device.queue.write_buffer(&self.prepass, offset, bytemuck::cast_slice(&thing.prepass_vertices()));
        let offset = u64::from(thing.firsts.first().copied().unwrap_or(0)) * 32;
        device.queue.write_buffer(&self.volume, offset, bytemuck::cast_slice(&thing.volume_vertices()));
        self.write_triangles(device, number);
    }

    fn write_triangles(&self, device: &Device, number: usize) {
        let thing = &self.things[number];
        let triangles = thing.triangles(self.lit[number]);
        self.triangles.write(device, 4 * u64::from(thing.first_triangle), bytemuck::cast_slice(&triangles));
    }

    /// From now on this indirect light is drawn. Sides that have none cost nothing, and those whose light did not change next to nothing.
    pub fn light(&mut self, device: &Device, indirect: &Indirect) -> Result<(), RasterError> {
        self.irradiance.write(device, self.things.iter().map(|thing| thing.id), indirect)?;
        for number in 0..self.things.len() {
            let places = self.irradiance.places(self.things[number].id);
            if self.lit[number] != places {
                self.lit[number] = places;
                self.write_triangles(device, number);
            }
        }
        Ok(())
    }

    /// An object, if it stands there, and the numbers of its triangles among all.
    pub fn thing(&self, object: usize) -> Option<(&Thing, Range<u32>)> {
        let number = self.things.iter().position(|thing| thing.id == object)?;
        Some((&self.things[number], self.firsts[number]..self.firsts[number + 1]))
    }

    /// The object and its triangle that number `triangle` among all is.
    pub fn source(&self, triangle: u32) -> (usize, usize) {
        let number = self.firsts.partition_point(|first| *first <= triangle) - 1;
        (self.things[number].id, (triangle - self.firsts[number]) as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lightmend_scene::{Edit, Scene};
    use std::path::Path;

    #[test]
    fn textures_are_made_once() {
        let room = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/room/room.ron");
        let scene = Scene::read(&room).unwrap().0;
        let before = Configuration::initial(&scene);
        let device = Device::headless().unwrap();
        let mut geometry = Geometry::new(&device).unwrap();
        let mut shown = |configuration: &Configuration| {
            geometry.show(&device, configuration).unwrap();
            let views = [&geometry.texels, &geometry.texture_entries, &geometry.uvs, &geometry.materials];
            views.map(|table| table.view.clone())
        };
        let first = shown(&before);
        let material = scene.objects[0].materials[0].name.clone();
        let to = DVec3::new(0.1, 0.2, 0.3);
        let repainted = before.apply(&Edit::Reflect { material, to }).unwrap();
        let second = shown(&repainted);
        assert!(first[..3] == second[..3] && first[3] != second[3]);
        // Other triangles have other coordinates.
        let third = shown(&repainted.apply(&Edit::Remove { object: "wardrobe".into() }).unwrap());
        assert!(first[..2] == third[..2] && first[2] != third[2]);
    }
}
