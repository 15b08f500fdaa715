//! How the error of raw irradiance falls with photons, and whether the spread over copies of the sequence tells it.
//!
//! `cargo run --release -p lightmend-photon --example error -- SCENE [REFERENCE_PHOTONS]`. The reference is two solutions of other
//! scrambles, half of the photons each: their difference tells the reference's own error, which is taken out. Error: nRMSE of
//! indirect irradiance, area-weighted over all element sides, three channels together.

use lightmend_photon::{
    body::TreePreset,
    bucket::Buckets,
    halton::Scrambling,
    irradiance::Scale,
    path::{FirstHits, Rules, trace},
    pool::{PhotonIndex, Pool},
    record::Outcome,
    solution::Solution,
    world::World,
};
use lightmend_scene::{Configuration, Scene};
use rayon::prelude::*;
use std::{error::Error, sync::Arc};

/// Copies of the sequence whose spread is judged.
const COPIES: u32 = 16;

/// Indirect irradiance of every element side: lux per channel and area in m².
type Field = Vec<([f64; 3], f64)>;

fn field(world: &World, buckets: &Buckets, photons: u64) -> Field {
    let scale = Scale::new(world, photons);
    let mut field = Field::new();
    for (id, object) in world.configuration().objects() {
        for cell in 0..object.lattice.cells() {
            for side in 0..2 {
                let area = object.lattice.area(cell);
                field.push((scale.irradiance(buckets, id, cell, side, area).value.to_array(), area));
            }
        }
    }
    field
}

fn weighted(field: &Field, value: impl Fn(usize) -> [f64; 3]) -> f64 {
    field.iter().enumerate().map(|(n, (_, area))| area * value(n).iter().map(|v| v * v).sum::<f64>()).sum()
}

fn difference(a: &Field, b: &Field) -> f64 {
    weighted(a, |n| std::array::from_fn(|c| a[n].0[c] - b[n].0[c])).sqrt()
}

fn shoot(world: &Arc<World>, photons: u64, seed: u64, copies: u32) -> Result<Solution, Box<dyn Error>> {
    let pool = Pool::new(photons, 288, 16, Scrambling::Seed(seed))?.in_copies(copies)?;
    Solution::shoot(pool, world.clone(), FirstHits::Never, &mut |_, _| true).ok_or("no solution".into())
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("usage: error SCENE [REFERENCE_PHOTONS]")?;
    let reference_photons: u64 = arguments.next().map_or(Ok(100_000_000), |n| n.parse())?;
    let (scene, _) = Scene::read(path.as_ref())?;
    let world = Arc::new(World::new(&Configuration::initial(&scene), TreePreset::default()));
    println!("{}: {} elements, {} threads", scene.name, scene.cells(), rayon::current_num_threads());

    let half = reference_photons / 2;
    let halves = [101, 202].map(|seed| shoot(&world, half, seed, 1).map(|s| field(&world, s.buckets(), half)));
    let [a, b] = halves;
    let (a, b) = (a?, b?);
    let reference: Field = a.iter().zip(&b).map(|(x, y)| (std::array::from_fn(|c| (x.0[c] + y.0[c]) / 2.0), x.1)).collect();
    let level = weighted(&reference, |n| reference[n].0).sqrt();
    // The halves' errors are independent: their mean errs by half of their difference.
    let own = difference(&a, &b) / 2.0 / level;
    println!("reference: {reference_photons} photons of other scrambles, its own nRMSE {:.4}", own);

    let mut points = Vec::new();
    for photons in [1_000_000u64, 4_000_000, 16_000_000] {
        let solution = shoot(&world, photons, 1, COPIES)?;
        let all = difference(&field(&world, solution.buckets(), photons), &reference) / level;
        let error = (all * all - own * own).max(0.0).sqrt();
        println!("{photons} photons: nRMSE {error:.4} ({all:.4} with the reference's)");
        points.push(((photons as f64).ln(), error.ln()));
    }
    let slope = (points[2].1 - points[0].1) / (points[2].0 - points[0].0);
    println!("slope of log error over log photons: {slope:.3}");

    spread(&world, &reference)?;
    Ok(())
}

/// Shoots each copy by itself: how often the reference, of far more photons, lies within one standard error of the copies' mean.
fn spread(world: &Arc<World>, reference: &Field) -> Result<(), Box<dyn Error>> {
    let photons = 4_000_000u64;
    let pool = Pool::new(photons, 288, 16, Scrambling::Seed(1))?.in_copies(COPIES)?;
    let rules = Rules { sequence: pool.sequence(), first_hits: FirstHits::Never };
    let copies: Vec<(Field, Vec<i64>)> = (0..u64::from(COPIES))
        .into_par_iter()
        .map(|copy| {
            let mut buckets = Buckets::new(world.configuration());
            for class in 0..288 {
                let mut outcome = Outcome::new(world.configuration().lamp_slots(), false);
                for point in (class..photons / u64::from(COPIES)).step_by(288) {
                    trace(&rules, world, PhotonIndex(point * u64::from(COPIES) + copy), &mut outcome);
                }
                buckets.add(&outcome.deposits);
            }
            let scale = Scale::new(world, photons / u64::from(COPIES));
            let mut hits = Vec::new();
            for (id, object) in world.configuration().objects() {
                for cell in 0..object.lattice.cells() {
                    hits.extend((0..2).map(|side| scale.irradiance(&buckets, id, cell, side, 1.0).hits));
                }
            }
            (field(world, &buckets, photons / u64::from(COPIES)), hits)
        })
        .collect();
    let elements = reference.len();
    let (mut within, mut counted) = (0u64, 0u64);
    for n in 0..elements {
        if copies.iter().map(|(_, hits)| hits[n]).sum::<i64>() < 30 {
            continue;
        }
        let luminance = |value: &[f64; 3]| 0.2126 * value[0] + 0.7152 * value[1] + 0.0722 * value[2];
        let values: Vec<f64> = copies.iter().map(|(field, _)| luminance(&field[n].0)).collect();
        let mean = values.iter().sum::<f64>() / f64::from(COPIES);
        let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / f64::from(COPIES - 1) / f64::from(COPIES);
        counted += 1;
        within += u64::from((mean - luminance(&reference[n].0)).abs() <= variance.sqrt());
    }
    let share = within as f64 / counted as f64 * 100.0;
    println!("{photons} photons in {COPIES} copies: {counted} of {elements} element sides with at least 30 hits");
    println!("within one standard error of the spread: {share:.1} %");
    Ok(())
}
