//! The irradiance of every element side of a scene, to be compared with another ([`crate::accuracy`]).

use crate::{bucket::Buckets, irradiance::Scale, reconstruction::Reconstruction, world::World};
use glam::DVec3;
use rayon::prelude::*;

/// One side of one mesh element.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Side {
    /// Irradiance, lux per linear Rec. 709 channel.
    pub irradiance: DVec3,
    /// Of the element, m².
    pub area: f64,
    /// Photon hits that it stems from.
    pub hits: i64,
}

/// Irradiance of every element side, in the order of object number, cell and side (0: front, 1: back).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Field {
    sides: Vec<Side>,
    /// By object number, where its sides begin.
    first: Vec<usize>,
}

impl Field {
    /// The raw buckets: what arrived at each side ÷ its area.
    pub fn raw(world: &World, buckets: &Buckets, scale: &Scale) -> Field {
        Field::read(world, |object, cell, side| {
            let area = world.object(object).lattice.area(cell);
            let light = scale.irradiance(buckets, object, cell, side, area);
            Side { irradiance: light.value, area, hits: light.hits }
        })
    }

    /// What a reconstruction makes of the buckets; hits are not counted.
    pub fn reconstructed(world: &World, light: &Reconstruction) -> Field {
        Field::read(world, |object, cell, side| {
            let area = world.object(object).lattice.area(cell);
            Side { irradiance: light.cell(object, cell, side).value, area, hits: 0 }
        })
    }

    /// Of the objects of `world`; `side` gets the numbers of an object, a cell and a side.
    pub fn read(world: &World, side: impl Fn(usize, u32, usize) -> Side + Sync) -> Field {
        let configuration = world.configuration();
        let mut field = Field { sides: Vec::new(), first: vec![0; configuration.object_slots()] };
        for (id, object) in configuration.objects() {
            field.first[id] = field.sides.len();
            field.sides.par_extend((0..2 * object.lattice.cells()).into_par_iter().map(|n| side(id, n / 2, (n % 2) as usize)));
        }
        field
    }

    /// All sides, in order.
    pub fn sides(&self) -> &[Side] {
        &self.sides
    }

    /// One side of a cell of an object that is there.
    pub fn side(&self, object: usize, cell: u32, side: usize) -> &Side {
        &self.sides[self.first[object] + 2 * cell as usize + side]
    }

    /// The mean of two fields of one scene that stem from equally many photons.
    pub fn mean(&self, other: &Field) -> Field {
        self.with(other, |a, b| Side { irradiance: (a.irradiance + b.irradiance) / 2.0, area: a.area, hits: a.hits + b.hits })
    }

    /// This field off by half of the difference of two others: what the mean of those two errs by, if they err independently.
    pub fn off_by_half(&self, a: &Field, b: &Field) -> Field {
        let half = a.with(b, |a, b| Side { irradiance: (a.irradiance - b.irradiance) / 2.0, ..*a });
        self.with(&half, |side, half| Side { irradiance: side.irradiance + half.irradiance, ..*side })
    }

    fn with(&self, other: &Field, join: impl Fn(&Side, &Side) -> Side) -> Field {
        let sides = self.sides.iter().zip(&other.sides).map(|(a, b)| join(a, b)).collect();
        Field { sides, first: self.first.clone() }
    }

    #[cfg(test)]
    pub(crate) fn of(sides: Vec<Side>) -> Field {
        Field { sides, first: vec![0] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{body::TreePreset, halton::Scrambling, path::FirstHits, pool::Pool, solution::Solution};
    use lightmend_scene::{Configuration, Scene};
    use std::{path::Path, sync::Arc};

    #[test]
    fn raw_holds_all_light_where_it_belongs() {
        let cornell = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell/cornell.ron");
        let world = Arc::new(World::new(&Configuration::initial(&Scene::read(&cornell).unwrap().0), TreePreset::default()));
        let pool = Pool::new(20_000, 72, 16, Scrambling::Seed(1)).unwrap();
        let solution = Solution::shoot(pool, world.clone(), FirstHits::Never, &mut |_, _| true).unwrap();
        let scale = Scale::new(&world, 20_000);
        let field = Field::raw(&world, solution.buckets(), &scale);
        assert_eq!(field.sides().len() as u64, 2 * world.configuration().scene().cells());
        assert!(solution.buckets().lit().count() > 1000);
        let mut hits = 0;
        for (at, bucket) in solution.buckets().lit() {
            let side = field.side(at.object as usize, at.cell, usize::from(at.side));
            // One lamp: a bucket is a side.
            assert_eq!(side.hits, bucket.hits);
            let flux = DVec3::from_array(bucket.energy.map(|e| e as f64)) * scale.lumens(0);
            assert!((side.irradiance * side.area - flux).length() <= 1e-12 * flux.length());
            hits += bucket.hits;
        }
        assert_eq!(field.sides().iter().map(|s| s.hits).sum::<i64>(), hits);
    }

    #[test]
    fn half_of_the_difference() {
        let one = |irradiance: f64| Field::of(vec![Side { irradiance: DVec3::splat(irradiance), area: 2.0, hits: 3 }]);
        let (a, b) = (one(4.0), one(1.0));
        let mean = a.mean(&b);
        assert_eq!(mean.sides()[0], Side { irradiance: DVec3::splat(2.5), area: 2.0, hits: 6 });
        assert_eq!(mean.off_by_half(&a, &b).sides()[0].irradiance, DVec3::splat(4.0));
    }
}
