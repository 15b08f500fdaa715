//! Camera and lamps as all shaders see them. Twin of `frame.wgsl`.

use crate::{
    camera::Camera,
    device::{Device, RasterError},
    goniometric::{CubeMap, FINEST},
    table::Table,
};
use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DVec3};
use lightmend_scene::{Configuration, Direct, Photometry, lamp_rotation};
use std::sync::Arc;

/// Stands for "no map", "no texture", "no light" in what shaders read.
pub const NONE: u32 = u32::MAX;

/// The camera.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Frame {
    eye: [f32; 3],
    near: f32,
    across: [f32; 3],
    width: f32,
    upwards: [f32; 3],
    height: f32,
    forward: [f32; 3],
    lamps: u32,
    right: [f32; 3],
    parts: u32,
    above: [f32; 3],
    unused: f32,
}

fn single(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

impl Frame {
    /// A camera's picture of `size` pixels, with so many lamps and these parts of the light.
    pub fn new(camera: &Camera, size: [u32; 2], lamps: u32, parts: u32) -> Frame {
        Frame {
            eye: single(camera.eye),
            near: camera.near as f32,
            across: single(camera.right / camera.right.length_squared()),
            width: size[0] as f32,
            upwards: single(camera.above / camera.above.length_squared()),
            height: size[1] as f32,
            forward: single(camera.forward),
            lamps,
            right: single(camera.right),
            parts,
            above: single(camera.above),
            unused: 0.0,
        }
    }
}

/// A lamp.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct GpuLamp {
    position: [f32; 3],
    map: u32,
    intensity: [f32; 3],
    intervals: u32,
    x: [f32; 3],
    last: f32,
    y: [f32; 3],
    first: f32,
    z: [f32; 3],
    unused: f32,
}

/// A lamp whose direct light is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrawnLamp {
    /// Its number in the configuration.
    pub id: usize,
    /// Metres.
    pub position: DVec3,
    /// From its axes to the world.
    rotation: DMat3,
    intensity: DVec3,
}

/// The lamps that are drawn, and their cube maps, each diagram once.
pub struct Lamps {
    /// In order of their names: the order of masks' channels.
    pub drawn: Vec<DrawnLamp>,
    maps: Vec<(Arc<Photometry>, CubeMap, u32)>,
    /// The drawn lamps as shaders see them.
    pub buffer: wgpu::Buffer,
    /// Candela.
    pub cube_maps: Table,
    /// What could not be done as the files say.
    pub warnings: Vec<String>,
}

const SAMPLES: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// Lamps that can be drawn; the same in `frame.wgsl`. They fit the uniform buffer that every driver has.
const MOST_LAMPS: usize = 640;

/// Makes the finest maps coarser until all together have no more than `most` samples.
fn coarsen(maps: &mut [(Arc<Photometry>, CubeMap, u32)], most: u64) {
    let mut finest = FINEST;
    while finest > 1 && maps.iter().map(|(_, map, _)| map.candela.len() as u64).sum::<u64>() > most {
        finest /= 2;
        for (photometry, map, _) in maps.iter_mut().filter(|(_, map, _)| map.intervals > finest) {
            *map = CubeMap::new(photometry, finest);
        }
    }
}

impl Lamps {
    /// None yet.
    pub fn new(device: &Device) -> Result<Lamps, RasterError> {
        let buffer = device.buffer("lamps", (MOST_LAMPS * size_of::<GpuLamp>()) as u64, wgpu::BufferUsages::UNIFORM)?;
        let cube_maps = Table::new(device, "cube maps", 0, SAMPLES)?;
        Ok(Lamps { drawn: Vec::new(), maps: Vec::new(), buffer, cube_maps, warnings: Vec::new() })
    }

    /// Whether any of them shines by a diagram.
    pub fn goniometric(&self) -> bool {
        !self.maps.is_empty()
    }

    /// From now on those of `configuration` that are lit and that the rasteriser draws.
    pub fn show(&mut self, device: &Device, configuration: &Configuration) -> Result<(), RasterError> {
        let drawn = configuration.lamps().filter(|(_, lamp)| lamp.lit && lamp.direct == Direct::Rasteriser);
        let mut drawn: Vec<_> = drawn.collect();
        drawn.sort_by(|a, b| a.1.name.cmp(&b.1.name));
        if drawn.len() > MOST_LAMPS {
            return Err(RasterError::Lamps { lamps: drawn.len(), most: MOST_LAMPS });
        }
        let photometry = |id: usize| configuration.lamp(id).photometry.as_ref();
        self.drawn = drawn
            .iter()
            .map(|(id, lamp)| {
                let motion = configuration.lamp_motion(*id);
                let rotation = lamp_rotation(configuration.scene().up, &motion);
                // The photons leave from the same point, rounded to single precision.
                let position = motion.translation.as_vec3().as_dvec3();
                DrawnLamp { id: *id, position, rotation, intensity: lamp.intensity }
            })
            .collect();
        let in_use = |known: &Arc<Photometry>| drawn.iter().any(|(id, _)| photometry(*id).is_some_and(|p| Arc::ptr_eq(p, known)));
        let unused = self.maps.iter().any(|(known, ..)| !in_use(known));
        let mut new: Vec<(&str, Arc<Photometry>)> = Vec::new();
        for (id, lamp) in &drawn {
            if let Some(photometry) = photometry(*id)
                && !self.maps.iter().any(|(known, ..)| Arc::ptr_eq(known, photometry))
            {
                self.maps.push((photometry.clone(), CubeMap::new(photometry, FINEST), NONE));
                new.push((&lamp.name, photometry.clone()));
            }
        }
        if !new.is_empty() || unused {
            self.maps.retain(|(known, ..)| in_use(known));
            coarsen(&mut self.maps, Table::most(device));
            let mut samples: Vec<[f32; 4]> = Vec::new();
            for (_, map, first) in &mut self.maps {
                *first = samples.len() as u32;
                // With its neighbours each is one texel to look up instead of four; past an edge nothing is ever looked up.
                let side = map.intervals as usize + 1;
                let at = |k: usize| map.candela.get(k).copied().unwrap_or(0.0);
                samples.extend((0..map.candela.len()).map(|k| [k, k + 1, k + side, k + side + 1].map(at)));
            }
            self.cube_maps = Table::filled(device, "cube maps", &samples, SAMPLES)?;
        }
        for (name, photometry) in &new {
            let map = self.maps.iter().find(|(known, map, _)| Arc::ptr_eq(known, photometry) && map.bad());
            self.warnings.extend(map.map(|(_, map, _)| {
                let error = map.error * 100.0;
                format!("lamp '{name}': its beam is narrower than a cube map can hold; its direct light is off by up to {error:.1} % of its peak")
            }));
        }
        let gpu: Vec<GpuLamp> = self
            .drawn
            .iter()
            .map(|lamp| {
                let map = photometry(lamp.id).and_then(|p| self.maps.iter().find(|(known, ..)| Arc::ptr_eq(known, p)));
                let [x, y, z] = [lamp.rotation.x_axis, lamp.rotation.y_axis, lamp.rotation.z_axis].map(single);
                GpuLamp {
                    position: single(lamp.position),
                    map: map.map_or(NONE, |(_, _, first)| *first),
                    intensity: single(lamp.intensity),
                    intervals: map.map_or(0, |(_, map, _)| map.intervals),
                    x,
                    last: map.map_or(0.0, |(_, map, _)| map.measured[0]),
                    y,
                    first: map.map_or(0.0, |(_, map, _)| map.measured[1]),
                    z,
                    unused: 0.0,
                }
            })
            .collect();
        device.queue.write_buffer(&self.buffer, 0, bytemuck::cast_slice(&gpu));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn maps_become_coarser_where_they_would_not_fit() {
        let map = |text: &str| {
            let photometry = Arc::new(Photometry::parse(text.as_bytes(), Path::new("test.ies")).unwrap().0);
            let map = CubeMap::new(&photometry, 128);
            (photometry, map, NONE)
        };
        let spot = map("TILT=NONE\n1 -1 1 6 1 1 1 0 0 0\n1 1 0\n0 4 8 12 20 90\n0\n1000 800 300 50 0 0\n");
        let even = map("TILT=NONE\n1 -1 1 2 1 1 1 0 0 0\n1 1 0\n0 180\n0\n7 7\n");
        let mut maps = [spot.clone(), even.clone()];
        coarsen(&mut maps, 200_000);
        assert_eq!(maps, [spot, even.clone()]);
        coarsen(&mut maps, 10_000);
        assert_eq!((maps[0].1.intervals, &maps[1]), (32, &even));
        assert!(maps[0].1.bad());
    }
}
