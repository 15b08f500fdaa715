//! 1. Long paths: bright closed spaces, high dimensions, the limit of a path, energy below the quantum, the largest bucket.

use crate::{
    sound::{self, Space},
    table::Row,
};
use glam::DVec3;
use lightmend_photon::{
    bucket::ENERGY_BITS,
    halton::{DIMENSIONS, Scrambling, Sequence},
    path::{FirstHits, LONGEST_PATH},
    pool::Pool,
    solution::Solution,
};
use lightmend_scene::{Scene, format::MaterialEntry};
use lightmend_tests::{Builder, count, pool, shoot, sphere, world};
use std::sync::Arc;

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

/// Energy of all deposits per channel, in photons, and hits.
fn deposits(solution: &Solution) -> (DVec3, f64) {
    let sum = solution.buckets().lit().fold(([0i64; 3], 0), |(energy, hits), (_, bucket)| {
        (std::array::from_fn(|c| energy[c] + bucket.energy[c]), hits + bucket.hits)
    });
    (DVec3::from_array(sum.0.map(|e| e as f64 / UNIT)), sum.1 as f64)
}

/// Of a space that reflects grey light: what all surfaces receive beside direct light, as a multiple of it.
fn indirect(solution: &Solution, photons: u64) -> f64 {
    let (energy, _) = deposits(solution);
    energy.x / photons as f64 - 1.0
}

pub fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    for shape in ["sphere", "box"] {
        for (reflectance, photons) in
            [(0.9, count(100_000, 20_000_000)), (0.99, count(10_000, 2_000_000)), (0.999, count(4_608, 200_000))]
        {
            let scene = space(shape, DVec3::splat(reflectance));
            let solution = shoot(pool(photons), &world(&scene), FirstHits::Always);
            // As it is held: single precision.
            let held = f64::from(reflectance as f32);
            // The hits of a path are geometrically distributed: their standard deviation is √ρ / (1 − ρ).
            let tolerance = 4.0 / (held * photons as f64).sqrt();
            let case = format!("{shape} of reflectance {reflectance}");
            let (right, source) = (held / (1.0 - held), "ρ / (1 − ρ); 4 standard errors");
            rows.push(Row::near(&case, "indirect ÷ direct flux", right, source, indirect(&solution, photons), tolerance));
            let lost: i64 = solution.tallies().iter().map(|t| t.escaped + t.cut).sum();
            rows.push(Row::exactly(&case, "photons escaped or cut", 0, "closed; ρ^65536 < 10⁻²⁸", lost));
        }
    }
    for (reflectance, photons) in [(0.9, sound::photons()), (0.99, count(4_608, 100_000))] {
        let scene = space("box", DVec3::splat(reflectance));
        let configuration = lightmend_scene::Configuration::initial(&scene);
        rows.push(sound::of(
            &format!("box of reflectance {reflectance}, soundness"),
            &configuration,
            Space::Closed,
            pool(photons),
        ));
    }
    rows.extend(limit());
    rows.extend(quantum());
    rows.extend(dimensions());
    rows
}

/// Paths that only the limit ends.
fn limit() -> Vec<Row> {
    let longest = f64::from(LONGEST_PATH);
    let mirror = shoot(Pool::new(64, 8, 1, Scrambling::Seed(1)).unwrap(), &world(&space("box", DVec3::ONE)), FirstHits::Always);
    let cut: i64 = mirror.tallies().iter().map(|t| t.cut).sum();
    let (energy, hits) = deposits(&mirror);
    let case = "box of reflectance 1, 64 photons";
    let mut rows = vec![
        Row::exactly(case, "photons cut after 65,536 hits", 64, "nothing absorbs", cut),
        Row::exactly(case, "hits", 64.0 * longest, "64 · 65,536", hits),
        Row::exactly(case, "energy of the hits, photons", 64.0 * longest, "64 · 65,536", energy.x),
    ];
    let photons = count(144, 20_000);
    let rho = f64::from(0.99999f32);
    let near_one = space("box", DVec3::splat(0.99999));
    let solution = shoot(Pool::new(photons, 72, 1, Scrambling::Seed(1)).unwrap(), &world(&near_one), FirstHits::Always);
    let hits = deposits(&solution).1 / photons as f64;
    let case = "box of reflectance 0.99999";
    let reached = rho.powf(longest);
    let mean = (1.0 - reached) / (1.0 - rho);
    // E[min(K, L)²] of a geometric K, by summation of survival: Σ (2k + 1) ρ^k.
    let square = (0..LONGEST_PATH).map(|k| (2.0 * f64::from(k) + 1.0) * rho.powf(f64::from(k))).sum::<f64>();
    let error = (square - mean * mean).sqrt() / mean / (photons as f64).sqrt();
    rows.push(Row::near(case, "hits a photon", mean, "(1 − ρ^65536) / (1 − ρ); 4 standard errors", hits, 4.0 * error));
    let bias = Row::near(case, "hits a photon", 1.0 / (1.0 - rho), "1 / (1 − ρ), as if paths had no limit", hits, 0.01);
    let why = "a path ends after 65,536 hits. The light lost is ρ^65536: 52 % here, 0.14 % at 0.9999, 10⁻²⁸ at 0.999; no paint exceeds 0.98";
    rows.push(bias.documented(why, (hits * (1.0 - rho) - 0.481).abs() < 0.1));
    rows
}

/// Channels that die out long before the photon does.
fn quantum() -> Vec<Row> {
    let photons = count(100_000, 10_000_000);
    let reflectance = DVec3::new(0.9, 0.45, 0.0009);
    let solution = shoot(pool(photons), &world(&space("box", reflectance)), FirstHits::Always);
    let (energy, hits) = deposits(&solution);
    let case = "box of reflectance (0.9, 0.45, 0.0009)";
    let closed = |rho: f64| rho / (1.0 - rho);
    let held = reflectance.as_vec3().as_dvec3();
    let mut rows = Vec::new();
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
    let rho = f64::from(0.9f32);
    let photons = count(100_000, 10_000_000);
    let plain = Pool::new(photons, 288, 16, Scrambling::None).unwrap();
    let solution = shoot(plain, &world(&space("sphere", DVec3::splat(0.9))), FirstHits::Always);
    let tolerance = 4.0 / (rho * photons as f64).sqrt();
    let source = "ρ / (1 − ρ); 4 standard errors of random points";
    rows.push(Row::near(
        "sphere of reflectance 0.9, plain sequence",
        "indirect ÷ direct flux",
        rho / (1.0 - rho),
        source,
        indirect(&solution, photons),
        tolerance,
    ));
    rows
}
