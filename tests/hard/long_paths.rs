//! 1. Long paths: bright closed spaces, high dimensions, the limit of a path, energy below the quantum, the largest bucket.

use crate::sound::{self, Space};
use glam::{DVec3, Vec3};
use lightmend_photon::{
    bucket::{ENERGY_BITS, energy},
    halton::{DIMENSIONS, Scrambling, Sequence},
    path::{FirstHits, LONGEST_PATH},
    pool::Pool,
    solution::Solution,
};
use lightmend_scene::{Scene, format::MaterialEntry};
use lightmend_tests::{Builder, count, pool, shoot, sphere, table::Row, world};
use rayon::prelude::*;
use std::{
    fmt::{self, Display, Formatter},
    ops::Add,
    sync::Arc,
};

const UNIT: f64 = (1u64 << ENERGY_BITS) as f64;

/// A closed space of one reflectance, a lamp in it off its middle.
fn space(shape: &str, reflectance: DVec3) -> Arc<Scene> {
    let mut builder = match shape {
        "sphere" => {
            let (points, triangles) = sphere(3);
            Builder::default().object(shape, 0.5, points, triangles).lamp([0.5, 0.2, -0.3], 100.0)
        }
        _ => Builder::default().cuboid(shape, 0.5, [0.0; 3], [4.0, 3.0, 2.5], true).lamp([1.0, 1.2, 2.1], 100.0),
    };
    builder.file.materials.insert(format!("of {shape}"), MaterialEntry { reflectance, texture: None });
    builder.build(&[])
}

/// What photons leave in a closed space: how often they hit something, and their energy per channel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Left {
    /// On all surfaces.
    pub hits: i64,
    /// 2⁻²⁴ of a photon.
    energy: [i64; 3],
    /// Paths that only the limit ends.
    cut: i64,
}

impl Display for Left {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let Left { hits, energy: [red, green, blue], cut } = self;
        write!(f, "{hits}; {red}, {green}, {blue}; {cut}")
    }
}

impl Add for Left {
    type Output = Left;

    fn add(self, more: Left) -> Left {
        let energy = std::array::from_fn(|c| self.energy[c] + more.energy[c]);
        Left { hits: self.hits + more.hits, energy, cut: self.cut + more.cut }
    }
}

/// What was counted.
fn shot(solution: &Solution) -> Left {
    let cut = solution.tallies().iter().map(|tally| tally.cut).sum();
    let buckets = solution.buckets().lit().map(|(_, bucket)| Left { hits: bucket.hits, energy: bucket.energy, cut: 0 });
    buckets.fold(Left { cut, ..Left::default() }, Add::add)
}

/// How often a photon survives in a space of one reflectance: its random numbers alone decide, wherever it flies.
fn survivals(sequence: &Sequence, photon: u64, survival: f64) -> u32 {
    let dies = |hit: &u32| sequence.value(photon, 2 + 2 * *hit as usize) >= survival;
    (0..LONGEST_PATH - 1).find(dies).unwrap_or(LONGEST_PATH - 1)
}

/// What the photons of a pool must leave in such a space, from their random numbers alone.
pub fn foretold(pool: &Pool, reflectance: DVec3) -> Left {
    let (sequence, held) = (pool.sequence(), reflectance.as_vec3());
    let survival = f64::from(held.max_element());
    // After so many survivals.
    let mut throughput = Vec3::ONE;
    let sums: Vec<[i64; 3]> = (0..LONGEST_PATH)
        .scan([0; 3], |sum, _| {
            let energy = energy(throughput);
            *sum = std::array::from_fn(|c| sum[c] + i64::from(energy[c]));
            throughput *= held / held.max_element();
            Some(*sum)
        })
        .collect();
    let last = 2 * LONGEST_PATH as usize;
    let of = |photon: u64| {
        let survived = survivals(&sequence, photon, survival);
        // The limit ends what would survive the last hit too.
        let cut = survived == LONGEST_PATH - 1 && sequence.value(photon, last) < survival;
        Left { hits: i64::from(survived) + 1, energy: sums[survived as usize], cut: i64::from(cut) }
    };
    (0..pool.photons()).into_par_iter().map(of).reduce(Left::default, Add::add)
}

/// The exact row of a space, and what was shot there.
fn exact(case: &str, shape: &str, reflectance: DVec3, pool: Pool) -> (Row, Left) {
    let left = shot(&shoot(pool, &world(&space(shape, reflectance)), FirstHits::Always));
    let quantity = "hits; their energy, 2⁻²⁴ photons (red, green, blue); paths cut";
    let source = "the photons' random numbers alone: they decide who survives, wherever they fly";
    (Row::exactly(case, quantity, foretold(&pool, reflectance), source, left), left)
}

pub fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    // The box of 0.9 is the largest pool: a billion hits in twelve buckets.
    for (shape, reflectance, photons) in [
        ("sphere", 0.9, count(100_000, 2_000_000)),
        ("sphere", 0.99, count(10_000, 200_000)),
        ("sphere", 0.999, count(4_608, 20_000)),
        ("box", 0.9, count(100_000, 100_000_000)),
        ("box", 0.99, count(10_000, 200_000)),
        ("box", 0.999, count(4_608, 20_000)),
    ] {
        let case = format!("{shape} of reflectance {reflectance}, {photons} photons");
        rows.push(exact(&case, shape, DVec3::splat(reflectance), pool(photons)).0);
    }
    for (reflectance, photons) in [(0.9, sound::photons()), (0.99, count(4_608, 20_000))] {
        let scene = space("box", DVec3::splat(reflectance));
        let configuration = lightmend_scene::Configuration::initial(&scene);
        rows.push(sound::of(
            &format!("box of reflectance {reflectance}, soundness"),
            &configuration,
            Space::Closed,
            pool(photons),
        ));
    }
    rows.extend(numbers());
    rows.extend(limit());
    rows.extend(quantum());
    rows.extend(dimensions());
    rows
}

/// The random numbers against the closed form of how long paths are.
fn numbers() -> Vec<Row> {
    let mut rows = Vec::new();
    for (name, scrambling) in [("plain", Scrambling::None), ("scrambled", Scrambling::Seed(1))] {
        let sequence = Sequence::new(scrambling);
        for (reflectance, photons) in [
            (0.9, count(1_000_000, 20_000_000)),
            (0.99, count(200_000, 4_000_000)),
            (0.999, count(160_000, 400_000)),
            (0.99999, count(4_608, 20_000)),
        ] {
            // As it is held: single precision.
            let rho = f64::from(reflectance as f32);
            let sum: u64 = (0..photons).into_par_iter().map(|photon| u64::from(survivals(&sequence, photon, rho))).sum();
            let [mean, error] = longest(rho);
            rows.push(Row::near(
                &format!("{name} sequence, reflectance {reflectance}, {photons} photons"),
                "survivals a photon",
                mean,
                "(ρ − ρ^65536) / (1 − ρ); 4 standard errors",
                sum as f64 / photons as f64,
                4.0 * error / (photons as f64).sqrt(),
            ));
        }
    }
    rows
}

/// How often a photon survives on average before the limit ends its path, and the standard deviation as a share of it.
fn longest(rho: f64) -> [f64; 2] {
    let mean = (rho - rho.powf(f64::from(LONGEST_PATH))) / (1.0 - rho);
    // E[K²] of a geometric K that ends at the limit, by summation of survival: Σ (2k + 1) P(K > k).
    let square: f64 = (0..LONGEST_PATH - 1).map(|k| (2.0 * f64::from(k) + 1.0) * rho.powi(k as i32 + 1)).sum();
    [mean, (square - mean * mean).sqrt() / mean]
}

/// Paths that only the limit ends.
fn limit() -> Vec<Row> {
    let longest = i64::from(LONGEST_PATH);
    let few = |photons| Pool::new(photons, 8, 1, Scrambling::Seed(1)).unwrap();
    let mirror = shot(&shoot(few(64), &world(&space("box", DVec3::ONE)), FirstHits::Always));
    let all = 64 * longest;
    let whole = Left { hits: all, energy: [all << ENERGY_BITS; 3], cut: 64 };
    let quantity = "hits; their energy, 2⁻²⁴ photons (red, green, blue); paths cut";
    let mut rows =
        vec![Row::exactly("box of reflectance 1, 64 photons", quantity, whole, "64 · 65,536: nothing absorbs", mirror)];
    let photons = count(144, 1_000);
    let case = format!("box of reflectance 0.99999, {photons} photons");
    let (row, left) = exact(&case, "box", DVec3::splat(0.99999), few(photons));
    rows.push(row);
    let rho = f64::from(0.99999f32);
    let hits = left.hits as f64 / photons as f64;
    let bias = Row::near(&case, "hits a photon", 1.0 / (1.0 - rho), "1 / (1 − ρ), as if paths had no limit", hits, 0.01);
    let why = "a path ends after 65,536 hits. The light lost is ρ^65536: 52 % here, 0.14 % at 0.9999, 10⁻²⁸ at 0.999; no paint exceeds 0.98";
    let [mean, error] = self::longest(rho);
    let expected = (hits / (mean + 1.0) - 1.0).abs() < 4.0 * error / (photons as f64).sqrt();
    rows.push(bias.documented(why, expected));
    rows
}

/// Channels that die out long before the photon does.
fn quantum() -> Vec<Row> {
    let photons = count(100_000, 2_000_000);
    let reflectance = DVec3::new(0.9, 0.45, 0.0009);
    let case = "box of reflectance (0.9, 0.45, 0.0009)";
    let (row, left) = exact(case, "box", reflectance, pool(photons));
    let energy = DVec3::from_array(left.energy.map(|e| e as f64 / UNIT));
    let hits = left.hits as f64;
    let closed = |rho: f64| rho / (1.0 - rho);
    let held = reflectance.as_vec3().as_dvec3();
    let mut rows = vec![row];
    for (c, channel) in ["red", "green", "blue"].into_iter().enumerate() {
        let (right, top) = (closed(held[c]), held.x);
        let got = energy[c] / photons as f64 - 1.0;
        // A path survives with ρ of red, and carries (ρ / ρ red)^k: the variance of Σ r^k over a geometric number of terms.
        let r = held[c] / top;
        let square = top * r * r * (1.0 + top * r) / ((1.0 - top * r) * (1.0 - top * r * r));
        let error = (square - right * right).max(0.0).sqrt() / right / (photons as f64).sqrt();
        let source = "ρ / (1 − ρ) of the channel; 4 standard errors and half a quantum a hit";
        let quantum = 0.5 / UNIT * hits / photons as f64 / right;
        rows.push(Row::near(case, &format!("{channel}, indirect ÷ direct"), right, source, got, 4.0 * error + quantum));
    }
    let most = 0.5 / UNIT * hits / photons as f64 / closed(held.z);
    let bound = "half a quantum (2⁻²⁵) a hit, ÷ blue's indirect light";
    rows.push(Row::at_most(case, "what rounding can add to or take from blue, at most", bound, most, 1e-3));
    rows
}

/// Pairs of the last dimensions of the sequence, whose bases are 307 and 311: the plain sequence starts along lines.
fn dimensions() -> Vec<Row> {
    let points = count(100_000, 10_000_000);
    let [a, b] = [DIMENSIONS - 2, DIMENSIONS - 1];
    let mut rows = Vec::new();
    for (name, scrambling) in [("plain", Scrambling::None), ("scrambled", Scrambling::Seed(1))] {
        let sequence = Sequence::new(scrambling);
        let inside = (0..points).filter(|i| sequence.value(*i, a) + sequence.value(*i, b) < 0.5).count();
        let got = inside as f64 / points as f64;
        // The standard error of as many random points: √(p (1 − p) / N).
        let tolerance = 4.0 * (0.125f64 * 0.875 / points as f64).sqrt() / 0.125;
        let case = format!("dimensions {a} and {b}, {name} sequence");
        rows.push(Row::near(
            &case,
            "share of points with u + v < ½",
            0.125,
            "area of the triangle; 4 errors of random points",
            got,
            tolerance,
        ));
    }
    rows
}
