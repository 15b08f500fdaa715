//! How the error of raw irradiance falls with photons, and whether the spread over copies of the sequence tells it.
//!
//! `cargo run --release -p lightmend-photon --example error -- SCENE [REFERENCE_PHOTONS]`. Error: nRMSE of indirect irradiance against
//! `lightmend_photon::accuracy::Reference`, which says what that is.

use lightmend_photon::{
    accuracy::Reference,
    body::TreePreset,
    bucket::Buckets,
    field::Field,
    halton::Scrambling,
    irradiance::Scale,
    path::{FirstHits, Rules, trace},
    pool::{PhotonIndex, Pool},
    record::Outcome,
    solution::Solution,
    world::World,
};
use lightmend_scene::{Configuration, Scene, luminance};
use rayon::prelude::*;
use std::{error::Error, sync::Arc};

/// Copies of the sequence whose spread is judged.
const COPIES: u32 = 16;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("usage: error SCENE [REFERENCE_PHOTONS]")?;
    let reference_photons: u64 = arguments.next().map_or(Ok(100_000_000), |n| n.parse())?;
    let (scene, _) = Scene::read(path.as_ref())?;
    let world = Arc::new(World::new(&Configuration::initial(&scene), TreePreset::default()));
    println!("{}: {} elements, {} threads", scene.name, scene.cells(), rayon::current_num_threads());

    let pool = |photons| Pool::new(photons, 288, 16, Scrambling::Seed(1)).and_then(|pool| pool.in_copies(COPIES));
    let reference = Reference::shoot(&world, &pool(4_000_000)?, reference_photons, FirstHits::Never, &mut |_| true)?;
    let reference = reference.ok_or("no reference")?;
    println!("reference: {} photons of other scrambles, its own nRMSE {:.4}", reference.photons, reference.own.nrmse);

    let mut points = Vec::new();
    for photons in [1_000_000u64, 4_000_000, 16_000_000] {
        let solution = Solution::shoot(pool(photons)?, world.clone(), FirstHits::Never, &mut |_, _| true).ok_or("no solution")?;
        let error = reference.measure(&Field::raw(&world, solution.buckets(), &Scale::new(&world, photons))).nrmse;
        println!("{photons} photons: nRMSE {error:.4}");
        points.push(((photons as f64).ln(), error.ln()));
    }
    let slope = (points[2].1 - points[0].1) / (points[2].0 - points[0].0);
    println!("slope of log error over log photons: {slope:.3}");

    spread(&world, &reference.field, &pool(4_000_000)?);
    Ok(())
}

/// Shoots each copy by itself: how often the reference, of far more photons, lies within one standard error of the copies' mean.
fn spread(world: &Arc<World>, reference: &Field, pool: &Pool) {
    let photons = pool.photons();
    let rules = Rules { sequence: pool.sequence(), first_hits: FirstHits::Never };
    let copies: Vec<Field> = (0..u64::from(COPIES))
        .into_par_iter()
        .map(|copy| {
            let mut buckets = Buckets::new(world.configuration());
            for class in 0..288 {
                let mut outcome = Outcome::new(world.configuration().lamp_slots(), false);
                for point in (class..photons / u64::from(COPIES)).step_by(288) {
                    trace(&rules, world, PhotonIndex(point * u64::from(COPIES) + copy), &mut outcome);
                }
                buckets.add(&outcome.deposits).unwrap();
            }
            let scale = Scale::new(world, photons / u64::from(COPIES));
            Field::raw(world, &buckets, &scale)
        })
        .collect();
    let elements = reference.sides().len();
    let (mut within, mut counted) = (0u64, 0u64);
    for n in 0..elements {
        if copies.iter().map(|field| field.sides()[n].hits).sum::<i64>() < 30 {
            continue;
        }
        let values: Vec<f64> = copies.iter().map(|field| luminance(field.sides()[n].irradiance)).collect();
        let mean = values.iter().sum::<f64>() / f64::from(COPIES);
        let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / f64::from(COPIES - 1) / f64::from(COPIES);
        counted += 1;
        within += u64::from((mean - luminance(reference.sides()[n].irradiance)).abs() <= variance.sqrt());
    }
    let share = within as f64 / counted as f64 * 100.0;
    println!("{photons} photons in {COPIES} copies: {counted} of {elements} element sides with at least 30 hits");
    println!("within one standard error of the spread: {share:.1} %");
}
