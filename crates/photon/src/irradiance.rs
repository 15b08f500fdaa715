//! Reading the buckets: irradiance of mesh elements, with its standard error.
//!
//! Irradiance = Σ over lamps of energy / 2²⁴ · Φ / (N · p) / area. Division by the pool, the lamp's chance and its flux happen here
//! and nowhere else, so that dimming, switching and recolouring a lamp re-trace nothing.

use crate::{
    bucket::{Buckets, ENERGY_BITS},
    world::World,
};
use glam::DVec3;

/// Irradiance of one side of one element.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Irradiance {
    /// Lux per linear Rec. 709 channel.
    pub value: DVec3,
    /// Standard error, as if photon hits were independent (Poisson). Where nothing was hit it is what one photon would have brought.
    pub standard_error: DVec3,
    /// Photon hits that it stems from.
    pub hits: i64,
}

impl Irradiance {
    /// Adds light that has arrived independently.
    pub fn add(&mut self, other: &Irradiance) {
        self.value += other.value;
        let variance = self.standard_error * self.standard_error + other.standard_error * other.standard_error;
        self.standard_error = DVec3::from_array(variance.to_array().map(f64::sqrt));
        self.hits += other.hits;
    }
}

/// What a bucket's energy is worth, in lumens per unit of energy, per lamp and channel.
#[derive(Debug, Clone)]
pub struct Scale {
    lumens: Vec<DVec3>,
}

impl Scale {
    /// For a pool of which `photons` have been shot at `world`.
    pub fn new(world: &World, photons: u64) -> Scale {
        let unit = 1.0 / (1u64 << ENERGY_BITS) as f64 / photons.max(1) as f64;
        let configuration = world.configuration();
        let mut lumens = vec![DVec3::ZERO; configuration.lamp_slots()];
        for (id, lamp) in configuration.lamps() {
            lumens[id] = lamp.flux() * (unit / world.choice().chance(id));
        }
        Scale { lumens }
    }

    /// Lumens per unit of energy of lamp `lamp`.
    pub fn lumens(&self, lamp: usize) -> DVec3 {
        self.lumens[lamp]
    }

    /// Irradiance of one side of a cell of `area` m².
    pub fn irradiance(&self, buckets: &Buckets, object: usize, cell: u32, side: usize, area: f64) -> Irradiance {
        let mut sum = Irradiance::default();
        let mut variance = DVec3::ZERO;
        for (lamp, lumens) in self.lumens.iter().enumerate() {
            let Some(page) = buckets.get(object, side, lamp) else { continue };
            let bucket = page[cell as usize];
            if bucket.hits == 0 {
                continue;
            }
            let value = DVec3::from_array(bucket.energy.map(|e| e as f64)) * *lumens / area;
            sum.value += value;
            sum.hits += bucket.hits;
            variance += value * value / bucket.hits as f64;
        }
        sum.standard_error = if sum.hits == 0 {
            let unit = (1u64 << ENERGY_BITS) as f64;
            self.lumens.iter().fold(DVec3::ZERO, |most, lumens| most.max(*lumens)) * unit / area
        } else {
            DVec3::from_array(variance.to_array().map(f64::sqrt))
        };
        sum
    }
}
