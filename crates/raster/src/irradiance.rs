//! Indirect light at the lattice points of all sides, on the device. Only sides whose light changed are written, neighbours together.

use crate::{
    device::{Device, RasterError},
    frame::NONE,
    table::Table,
};
use std::sync::Arc;

/// Indirect light: per object by number and side (front, back), lux per linear Rec. 709 channel at the lattice points in order, the
/// fourth number unused ([`side_light`] makes it); nothing where no light ever came. What is the same `Arc` as before did not change.
pub type Indirect = Vec<[Option<Arc<[[f32; 4]]>>; 2]>;

/// The light of one side of an object, from lux per linear Rec. 709 channel at its lattice points.
pub fn side_light(points: &[[f32; 3]]) -> Arc<[[f32; 4]]> {
    points.iter().map(|[r, g, b]| [*r, *g, *b, 0.0]).collect()
}

/// A lit side and where it lies.
struct Side {
    object: usize,
    side: usize,
    first: u32,
    /// What was written last.
    points: Arc<[[f32; 4]]>,
}

/// The light of all sides that have some.
pub struct Irradiance {
    /// Lux per channel, one entry a lattice point.
    pub table: Table,
    /// In their order in the table.
    sides: Vec<Side>,
    uploaded: u64,
}

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

impl Irradiance {
    /// None yet.
    pub fn new(device: &Device) -> Result<Irradiance, RasterError> {
        Ok(Irradiance { table: Table::new(device, "indirect light", 0, FORMAT)?, sides: Vec::new(), uploaded: 0 })
    }

    /// From now on this is the light of `objects`. Places stay as they are while the same sides are lit at as many points.
    pub fn write(
        &mut self,
        device: &Device,
        objects: impl Iterator<Item = usize>,
        indirect: &Indirect,
    ) -> Result<(), RasterError> {
        let mut end = 0;
        let mut lit: Vec<Side> = Vec::new();
        for object in objects {
            for (side, points) in indirect.get(object).into_iter().flatten().enumerate() {
                if let Some(points) = points {
                    lit.push(Side { object, side, first: end as u32, points: points.clone() });
                    end += points.len() as u64;
                }
            }
        }
        let place = |s: &Side| (s.object, s.side, s.points.len());
        let same_places = lit.iter().map(place).eq(self.sides.iter().map(place));
        if end > self.table.entries() {
            self.table = Table::new(device, "indirect light", end, FORMAT)?;
        }
        let old = std::mem::replace(&mut self.sides, lit);
        let changed = |n: usize| !same_places || !Arc::ptr_eq(&self.sides[n].points, &old[n].points);
        self.uploaded = 0;
        let mut n = 0;
        while n < self.sides.len() {
            let run = self.sides[n..].iter().enumerate().take_while(|(k, _)| changed(n + k)).count();
            match &self.sides[n..n + run] {
                [] => n += 1,
                [one] => self.uploaded += write(&self.table, device, one.first, &one.points),
                [first, ..] => {
                    let points: Vec<[f32; 4]> = self.sides[n..n + run].iter().flat_map(|s| s.points.iter().copied()).collect();
                    self.uploaded += write(&self.table, device, first.first, &points);
                }
            }
            n += run;
        }
        Ok(())
    }

    /// The first entries of the front and of the back of an object.
    pub fn places(&self, object: usize) -> [u32; 2] {
        // Sides are in the order of objects.
        let first = self.sides.partition_point(|s| s.object < object);
        let mut places = [NONE; 2];
        for side in self.sides[first..].iter().take_while(|s| s.object == object) {
            places[side.side] = side.first;
        }
        places
    }

    /// How many bytes the last light has cost.
    pub fn uploaded_bytes(&self) -> u64 {
        self.uploaded
    }
}

/// Writes entries from number `first` on; how many bytes they are.
fn write(table: &Table, device: &Device, first: u32, points: &[[f32; 4]]) -> u64 {
    table.write(device, u64::from(first), bytemuck::cast_slice(points));
    size_of_val(points) as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Look, Parts, Renderer, Settings};
    use lightmend_scene::{Configuration, Edit, LatticePoints, Scene};
    use std::path::Path;

    /// Another light for each side.
    fn light(configuration: &Configuration, lux: f32) -> Indirect {
        let side = |id: usize, side: usize| {
            let object = configuration.object(id);
            let points = LatticePoints::new(&object.mesh, &object.lattice).count();
            side_light(&vec![[lux + id as f32, lux, 2.0 * lux + side as f32]; points as usize])
        };
        let sides = |id| [0, 1].map(|s| configuration.has_object(id).then(|| side(id, s)));
        (0..configuration.object_slots()).map(sides).collect()
    }

    fn bytes<'a>(sides: impl Iterator<Item = &'a [Option<Arc<[[f32; 4]]>>; 2]>) -> u64 {
        sides.flatten().flatten().map(|points| 16 * points.len() as u64).sum()
    }

    #[test]
    fn only_light_that_changed_is_written() {
        let room = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/room/room.ron");
        let scene = Scene::read(&room).unwrap().0;
        let configuration = Configuration::initial(&scene);
        let device = Arc::new(Device::headless().unwrap());
        let settings = Settings { width: 64, height: 48, grid: 1, parts: Parts::INDIRECT_IRRADIANCE, look: Look::Plain };
        let see = |renderer: &mut Renderer| {
            renderer.draw(&scene.cameras[0].1, &settings).unwrap();
            renderer.samples().unwrap()
        };
        // What one sees that knows of nothing before.
        let fresh = |configuration: &Configuration, indirect: &Indirect| {
            let mut renderer = Renderer::new(device.clone()).unwrap();
            renderer.show(configuration).unwrap();
            renderer.light(indirect).unwrap();
            see(&mut renderer)
        };
        let mut renderer = Renderer::new(device.clone()).unwrap();
        renderer.show(&configuration).unwrap();
        let mut indirect = light(&configuration, 50.0);
        for wanted in [bytes(indirect.iter()), 0] {
            renderer.light(&indirect).unwrap();
            assert_eq!(renderer.uploaded_bytes(), wanted);
            assert!(see(&mut renderer) == fresh(&configuration, &indirect));
        }

        // One object's light, and that of two neighbours and of one side of a third.
        let table = configuration.object_id("table").unwrap();
        let other = light(&configuration, 90.0);
        for (changed, odd) in [(vec![table], None), (vec![0, 1], Some(5))] {
            let before = see(&mut renderer);
            changed.iter().for_each(|id| indirect[*id] = other[*id].clone());
            let mut wanted = bytes(changed.iter().map(|id| &indirect[*id]));
            if let Some(id) = odd {
                indirect[id][1] = other[id][1].clone();
                wanted += bytes([[None, indirect[id][1].clone()]].iter());
            }
            renderer.light(&indirect).unwrap();
            assert_eq!(renderer.uploaded_bytes(), wanted);
            let after = see(&mut renderer);
            assert!(before != after && after == fresh(&configuration, &indirect));
        }

        // An object that goes, comes back, and is joined by another; what stays keeps its light until there is a new one.
        let removed = configuration.apply(&Edit::Remove { object: "wardrobe".into() }).unwrap();
        let to = glam::DVec3::new(2.0, 2.5, 0.0);
        let copy = Edit::Duplicate { object: "wardrobe".into(), name: "another".into(), to };
        for configuration in [removed, configuration.clone(), configuration.apply(&copy).unwrap()] {
            indirect.resize(configuration.object_slots(), [None, None]);
            let known: Indirect = indirect.clone();
            renderer.show(&configuration).unwrap();
            let kept = see(&mut renderer);
            for (id, sides) in light(&configuration, 70.0).into_iter().enumerate() {
                let stays = configuration.has_object(id) && known[id][0].is_some();
                indirect[id] = if stays { known[id].clone() } else { sides };
            }
            renderer.light(&indirect).unwrap();
            assert_eq!(renderer.uploaded_bytes(), bytes(indirect.iter()), "others are lit: all is laid out anew");
            let now = see(&mut renderer);
            assert!(now == fresh(&configuration, &indirect));
            let seen = renderer.seen().unwrap();
            let stays = |id: usize| known[id][0].is_some();
            let dark = |rgb: &[f32; 4]| rgb[..3] == [0.0; 3];
            let right = kept
                .iter()
                .zip(&now)
                .zip(seen)
                .all(|((kept, now), seen)| seen.is_none_or(|(id, _)| if stays(id) { kept == now } else { dark(kept) }));
            assert!(right);
        }
    }
}
