//! What the ledger costs, against tracing in the same run: its records, its scan, its repair.
//!
//! `cargo run --release -p lightmend-photon --example ledger -- SCENE OBJECT [PHOTONS]`: the object is moved by 0.2 m along x and back.
//! Medians of nine scans and repairs. Only the ratios carry over to another machine or moment.

use lightmend_photon::{
    body::TreePreset,
    halton::Scrambling,
    ledger::LedgerSolution,
    path::FirstHits,
    pool::Pool,
    solution::{Solution, Work},
    world::World,
};
use lightmend_scene::{Configuration, Edit, Scene};
use std::{error::Error, sync::Arc, time::Instant};

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let mut arguments = std::env::args().skip(1);
    let usage = "which scene, and which object? --example ledger -- SCENE OBJECT [PHOTONS]";
    let (scene, object) = (arguments.next().ok_or(usage)?, arguments.next().ok_or(usage)?);
    let photons = arguments.next().map_or(Ok(1_152_000), |n| n.parse())?;
    let (scene, _) = Scene::read(scene.as_ref())?;
    let home = Configuration::initial(&scene);
    let to = home.object(home.object_id(&object)?).pose.position + glam::DVec3::X * 0.2;
    let moved = home.apply(&Edit::Move { object: object.clone(), to })?;
    let world = Arc::new(World::new(&home, TreePreset::default()));
    let worlds = [Arc::new(world.moved_to(&moved)), world.clone()];
    let pool = Pool::new(photons, 288, 16, Scrambling::Seed(1))?;
    let millions = photons as f64 / 1e6;

    for threads in [1, 2] {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build()?.install(|| -> Result<(), Box<dyn Error + Send + Sync>> {
            let start = Instant::now();
            Solution::shoot(pool, world.clone(), FirstHits::AsLampsSay, &mut |_, _| true).ok_or("too few photons")?;
            let plain = start.elapsed().as_secs_f64();
            let start = Instant::now();
            let begun = LedgerSolution::shoot(pool, world.clone(), FirstHits::AsLampsSay, u64::MAX, &mut |_, _| true);
            let mut ledger = begun?;
            let kept = start.elapsed().as_secs_f64();
            let (each, hits) = (ledger.bytes() as f64 / photons as f64, ledger.entries() as f64 / photons as f64);
            println!("{threads} threads: shot in {plain:.2} s, with its ledger in {kept:.2} s; {each:.1} bytes, {hits:.2} hits a photon");
            let (mut scans, mut repairs) = (Vec::new(), Vec::new());
            for round in 0..9 {
                ledger.change(worlds[round % 2].clone())?;
                let start = Instant::now();
                ledger.scan(usize::MAX);
                scans.push(start.elapsed().as_secs_f64() * 1e3 / millions);
                let marked = ledger.outstanding_photons();
                let start = Instant::now();
                let (mut work, mut replayed) = (Work::default(), 0);
                while let Some(mended) = ledger.repair_next() {
                    work += mended.work;
                    replayed += mended.replayed;
                }
                repairs.push((start.elapsed().as_secs_f64(), marked, work, replayed));
            }
            scans.sort_by(f64::total_cmp);
            repairs.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (seconds, marked, work, replayed) = repairs[repairs.len() / 2];
            println!(
                "  {object}: scan {:.2} ms per million photons ({:.2} % of shooting); repair {:.1} ms: {marked} marked, {} wrong, \
                 {replayed} hits replayed, {} rays",
                scans[4],
                scans[4] * millions / plain / 10.0,
                seconds * 1e3,
                work.photons,
                work.rays,
            );
            Ok(())
        })?;
    }
    Ok(())
}
