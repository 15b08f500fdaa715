//! What looking costs: the item buffer, the order by it, and foreseeing what a repair will still bring.
//!
//! `cargo run --release -p lightmend-photon --example looking -- SCENE MOVES [PHOTONS] [ROUNDS]`: after the first edit of the script, from the scene's first camera,
//! milliseconds by the clock and of the processor, and against the whole repair; medians of ROUNDS (5) in turn. Threads by
//! `RAYON_NUM_THREADS`. Only ratios carry over to another machine or moment.

#[path = "support/times.rs"]
mod times;

use lightmend_photon::{
    body::TreePreset, halton::Scrambling, ledger::LedgerSolution, path::FirstHits, pool::Pool, visible::Visible, world::World,
};
use lightmend_scene::{Configuration, Moves, Scene};
use std::{error::Error, sync::Arc};
use times::{median, timed};

const NAMES: [&str; 6] = ["repair", "repair, watched", "item buffer", "order by it", "pending", "drawn light"];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, moves, numbers @ ..] = arguments.as_slice() else {
        return Err("usage: looking SCENE MOVES [PHOTONS] [ROUNDS]".into());
    };
    let photons = numbers.first().map_or(Ok(1_152_000), |n| n.parse())?;
    let rounds: usize = numbers.get(1).map_or(Ok(5), |n| n.parse())?;
    let (scene, _) = Scene::read(scene.as_ref())?;
    let view = scene.cameras.first().ok_or("a scene without a camera")?.1;
    let (moves, _) = Moves::read(moves.as_ref(), &scene)?;
    let edit = &moves.edits.first().ok_or("no edit")?.edit;
    let before = Arc::new(World::new(&Configuration::initial(&scene), TreePreset::default()));
    let after = Arc::new(before.moved_to(&before.configuration().apply(edit)?));
    let pool = Pool::new(photons, 288, 16, Scrambling::Seed(1))?;
    let drained = LedgerSolution::shoot(pool, before, FirstHits::AsLampsSay, u64::MAX, &mut |_, _| true)?;
    let mut all: [[Vec<f64>; 2]; 6] = Default::default();
    for _ in 0..rounds {
        let mut times = [[0.0; 2]; 6];
        for watched in [false, true] {
            let mut ledger = drained.clone();
            ledger.change(after.clone())?;
            ledger.scan(usize::MAX);
            if watched {
                let (time, visible) = timed(|| Visible::new(&after, &view));
                times[2] = time;
                let (time, ()) = timed(|| ledger.look(&visible.importance(&after)));
                times[3] = time;
                ledger.watch();
                let marked = ledger.outstanding_photons();
                let (time, ()) =
                    timed(|| while ledger.outstanding_photons() > marked / 4 && ledger.repair_next().unwrap().is_some() {});
                times[1] = time;
                let (time, pending) = timed(|| ledger.pending());
                times[4] = time;
                let pending = pending.ok_or("it is watched")?;
                times[5] = timed(|| pending.draw(ledger.buckets(), |_| true)).0;
            }
            let (rest, ()) = timed(|| while ledger.repair_next().unwrap().is_some() {});
            let whole = &mut times[usize::from(watched)];
            *whole = [whole[0] + rest[0], whole[1] + rest[1]];
        }
        for (all, time) in all.iter_mut().zip(times) {
            all.iter_mut().zip(time).for_each(|(all, one)| all.push(one * 1e3));
        }
    }
    let medians = all.map(|times| times.map(median));
    println!("{} threads\tclock ms\tprocessor ms\tprocessor ÷ repair's", rayon::current_num_threads());
    for (name, [clock, processor]) in NAMES.iter().zip(medians) {
        println!("{name}\t{clock:.2}\t{processor:.2}\t{:.3}", processor / medians[0][1]);
    }
    Ok(())
}
