//! Whether photons are neither lost nor made: what surfaces absorb, what escapes and what is cut is what was emitted.
//!
//! Roulette takes whole photons, so that what surfaces absorb of the light that meets them, Σ (1 − ρ) · incident, equals what was
//! emitted only on average; the photons' own scatter says how closely. Their number and their deposits balance exactly.

use crate::{
    bucket::{Buckets, energy},
    path::{End, Record, Rules, reflectance, trace},
    pool::PhotonIndex,
    triangle::Hit,
    world::World,
};
use glam::Vec3;
use rayon::prelude::*;

/// What became of a pool's photons.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Balance {
    /// Photons.
    pub photons: u64,
    /// Photons that a surface took.
    pub absorbed: u64,
    /// Photons that met nothing.
    pub escaped: u64,
    /// Photons whose path was cut.
    pub cut: u64,
    /// Σ (1 − ρ) · incident over all hits, first ones too, plus what escaped or was cut, per photon and channel: 1 on average.
    pub mean: [f64; 3],
    /// Standard error of `mean`, as if photons were independent.
    pub standard_error: [f64; 3],
    /// What all hits that count deposit, per channel, in units of 2⁻²⁴ of a photon.
    pub deposited: [i64; 3],
    /// Hits that count.
    pub hits: i64,
}

/// Photons that one task traces.
const TASK: u64 = 4096;

impl Balance {
    /// Traces the first `photons` of a sequence, one by one, apart from how solutions are shot and repaired.
    pub fn trace(rules: &Rules, world: &World, photons: u64) -> Balance {
        let tasks: Vec<Sums> = (0..photons.div_ceil(TASK))
            .into_par_iter()
            .map(|task| {
                let mut sums = Sums::default();
                for index in task * TASK..photons.min((task + 1) * TASK) {
                    sums.photon = Vec3::ZERO;
                    trace(rules, world, PhotonIndex(index), &mut sums);
                    for c in 0..3 {
                        let off = f64::from(sums.photon[c]) - 1.0;
                        sums.off[c] += off;
                        sums.squares[c] += off * off;
                    }
                }
                sums
            })
            .collect();
        let mut all = Balance { photons, ..Balance::default() };
        let (mut off, mut squares) = ([0.0; 3], [0.0; 3]);
        for sums in &tasks {
            let [absorbed, escaped, cut] = sums.ends;
            all.absorbed += absorbed;
            all.escaped += escaped;
            all.cut += cut;
            all.hits += sums.hits;
            for c in 0..3 {
                all.deposited[c] += sums.deposited[c];
                off[c] += sums.off[c];
                squares[c] += sums.squares[c];
            }
        }
        let n = photons.max(1) as f64;
        all.mean = off.map(|off| 1.0 + off / n);
        all.standard_error = squares.map(|squares| squares.sqrt() / n);
        all
    }

    /// Whether buckets hold exactly what these photons deposit.
    pub fn is_held_by(&self, buckets: &Buckets) -> bool {
        let (mut energy, mut hits) = ([0; 3], 0);
        for (_, bucket) in buckets.lit() {
            energy.iter_mut().zip(bucket.energy).for_each(|(sum, energy)| *sum += energy);
            hits += bucket.hits;
        }
        (energy, hits) == (self.deposited, self.hits)
    }

    /// Whether as many photons ended as were emitted.
    pub fn is_whole(&self) -> bool {
        self.absorbed + self.escaped + self.cut == self.photons
    }
}

#[derive(Default)]
struct Sums {
    /// Of the photon under way: what surfaces absorb on average, and what is lost.
    photon: Vec3,
    off: [f64; 3],
    squares: [f64; 3],
    /// Absorbed, escaped, cut.
    ends: [u64; 3],
    deposited: [i64; 3],
    hits: i64,
}

impl Record for Sums {
    fn hit(&mut self, hit: &Hit, _: u8, throughput: Vec3, _: u16, deposits: bool, world: &World) {
        self.photon += throughput * (Vec3::ONE - reflectance(world, hit));
        if deposits {
            self.deposited.iter_mut().zip(energy(throughput)).for_each(|(sum, energy)| *sum += i64::from(energy));
            self.hits += 1;
        }
    }

    fn end(&mut self, end: End, throughput: Vec3, _: u16) {
        let [absorbed, escaped, cut] = &mut self.ends;
        *match end {
            End::Absorbed => absorbed,
            End::Escaped => escaped,
            End::Cut => cut,
        } += 1;
        if end != End::Absorbed {
            self.photon += throughput;
        }
    }

    fn ray(&mut self) {}
}
