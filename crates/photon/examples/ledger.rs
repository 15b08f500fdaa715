//! What the ledger costs, against shooting the same photons in the same run.
//!
//! `cargo run --release -p lightmend-photon --example ledger -- SCENE MOVES [PHOTONS] [ROUNDS]` goes through the edits of a script: scan and
//! repair of each against a restart. With `sizes` instead of MOVES, everything movable is moved by 0.2 m along x, one by one, and
//! scanned for. Medians of ROUNDS (5) in turn, of
//! processor time and by the clock; threads by `RAYON_NUM_THREADS`. Only ratios carry over to another machine or moment.

#[path = "support/times.rs"]
mod times;

use lightmend_photon::{
    body::TreePreset, halton::Scrambling, ledger::LedgerSolution, path::FirstHits, pool::Pool, shooting::Work,
    solution::Solution, world::World,
};
use lightmend_scene::{Configuration, Edit, Moves, Scene};
use std::{error::Error, sync::Arc};
use times::{median, timed};

type Fallible<T> = Result<T, Box<dyn Error + Send + Sync>>;

const FIRST_HITS: FirstHits = FirstHits::AsLampsSay;

fn main() -> Fallible<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, moves, numbers @ ..] = arguments.as_slice() else {
        return Err("usage: ledger SCENE MOVES|sizes [PHOTONS] [ROUNDS]".into());
    };
    let photons = numbers.first().map_or(Ok(1_152_000), |n| n.parse())?;
    let rounds = numbers.get(1).map_or(Ok(5), |n| n.parse())?;
    let (scene, _) = Scene::read(scene.as_ref())?;
    let world = Arc::new(World::new(&Configuration::initial(&scene), TreePreset::default()));
    let pool = Pool::new(photons, 288, 16, Scrambling::Seed(1))?;
    let (plain, shot) = timed(|| shoot(pool, &world));
    let (kept, ledger) = timed(|| LedgerSolution::shoot(pool, world, FIRST_HITS, u64::MAX, &mut |_, _| true));
    drop(shot?);
    let ledger = ledger?;
    println!(
        "{} threads; shot in {:.2} s of the processor, with its ledger in {:.2} s; {:.1} bytes, {:.2} hits a photon",
        rayon::current_num_threads(),
        plain[1],
        kept[1],
        ledger.bytes() as f64 / photons as f64,
        ledger.entries() as f64 / photons as f64
    );
    if moves == "sizes" {
        sizes(ledger, pool, rounds)
    } else {
        script(ledger, pool, &Moves::read(moves.as_ref(), &scene)?.0, rounds)
    }
}

/// A solution from nothing, and its rays.
fn shoot(pool: Pool, world: &Arc<World>) -> Fallible<(Solution, u64)> {
    let mut rays = 0;
    let solution = Solution::shoot(pool, world.clone(), FIRST_HITS, &mut |_, more| {
        rays += more;
        true
    });
    Ok((solution.ok_or("too few photons")?, rays))
}

/// Repairs all that is marked: work and replayed hits.
fn drain(ledger: &mut LedgerSolution) -> (Work, u64) {
    let (mut work, mut replayed) = (Work::default(), 0);
    while let Some(mended) = ledger.repair_next().unwrap() {
        work += mended.work;
        replayed += mended.replayed;
    }
    (work, replayed)
}

/// Each edit of a script: the ledger goes there and back, and a new solution is shot there, in turn.
fn script(mut ledger: LedgerSolution, pool: Pool, moves: &Moves, rounds: usize) -> Fallible<()> {
    println!(
        "edit\tmarked\twrong\thits replayed\trays ÷ restart's\tprocessor: scan ms\trepair ms\trestart ms\tscan ÷ restart\trepair ÷ restart\t\
         ÷ share of rays\tclock: scan ÷ restart\trepair ÷ restart\t÷ share of rays"
    );
    for (number, timed_edit) in moves.edits.iter().enumerate() {
        let before = ledger.world().clone();
        let after = Arc::new(before.moved_to(&before.configuration().apply(&timed_edit.edit)?));
        let mut seconds: [[Vec<f64>; 5]; 2] = Default::default();
        let (mut marked, mut work, mut replayed, mut rays) = (0, Work::default(), 0, 0);
        for round in 0..rounds {
            if round > 0 {
                ledger.change(before.clone())?;
                ledger.scan(usize::MAX);
                drain(&mut ledger);
            }
            let (changing, changed) = timed(|| ledger.change(after.clone()));
            changed?;
            let (scan, _) = timed(|| ledger.scan(usize::MAX));
            marked = ledger.outstanding_photons();
            let (repair, done) = timed(|| drain(&mut ledger));
            (work, replayed) = done;
            let (restart, fresh) = timed(|| shoot(pool, &after));
            let fresh = fresh?;
            rays = fresh.1;
            if !ledger.to_solution().is_some_and(|solution| solution.equals(&fresh.0)) {
                return Err(format!("edit {number}: the light is not that of a restart").into());
            }
            for (k, seconds) in seconds.iter_mut().enumerate() {
                let (scan, repair, restart) = (scan[k], changing[k] + repair[k], restart[k]);
                let all = [scan, repair, restart, scan / restart, repair / restart];
                seconds.iter_mut().zip(all).for_each(|(all, one)| all.push(one));
            }
        }
        let [clock, processor] = seconds.map(|seconds| seconds.map(median));
        let share = work.rays as f64 / rays as f64;
        let [scan, repair, restart] = [0, 1, 2].map(|n| processor[n] * 1e3);
        print!("{number}\t{marked}\t{}\t{replayed}\t{share:.4}\t{scan:.2}\t{repair:.2}\t{restart:.0}", work.photons);
        for [.., scan, repair] in [processor, clock] {
            print!("\t{scan:.4}\t{repair:.4}\t{:.2}", repair / share);
        }
        println!();
    }
    Ok(())
}

/// Scans for movers of all sizes, then for all at once.
fn sizes(mut ledger: LedgerSolution, pool: Pool, rounds: usize) -> Fallible<()> {
    let home = ledger.world().clone();
    let configuration = home.configuration();
    let movers: Vec<usize> =
        configuration.objects().filter(|(_, o)| o.movable && o.carrier.is_none()).map(|(id, _)| id).collect();
    let alone = movers.iter().map(|id| vec![*id]);
    let mut rows = Vec::new();
    for ids in alone.chain([movers.clone()]) {
        let mut moved = configuration.clone();
        for id in &ids {
            let object = configuration.object(*id);
            moved = moved.apply(&Edit::Move { object: object.name.clone(), to: object.pose.position + glam::DVec3::X * 0.2 })?;
        }
        let away = Arc::new(home.moved_to(&moved));
        let crowd = home.difference(&away).phantoms;
        let corners = home
            .phantoms(&crowd)
            .bounds()
            .fold(None, |all: Option<[glam::Vec3; 2]>, [l, h]| Some(all.map_or([l, h], |[low, high]| [low.min(l), high.max(h)])));
        let [low, high] = corners.ok_or("nothing moves")?;
        let (mut scans, mut shares, mut marked) = (Vec::new(), Vec::new(), 0);
        for _ in 0..rounds {
            ledger.change(away.clone())?;
            let (scan, _) = timed(|| ledger.scan(usize::MAX));
            let (restart, _) = timed(|| shoot(pool, &home));
            scans.push(scan[1]);
            shares.push(scan[1] / restart[1]);
            marked = ledger.outstanding_photons();
            ledger.change(home.clone())?;
            ledger.scan(usize::MAX);
            drain(&mut ledger);
        }
        let name = if ids.len() == 1 { configuration.object(ids[0]).name.as_str() } else { "all of them" };
        rows.push(((high - low).length(), name, crowd.len(), marked, median(scans), median(shares)));
    }
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    println!("mover\tdiagonal m\tboxes\tmarked of a million\tscan, ms a million\tscan ÷ restart");
    let millions = ledger.photons() as f64 / 1e6;
    for (size, name, boxes, marked, scan, share) in rows {
        println!("{name}\t{size:.2}\t{boxes}\t{:.0}\t{:.2}\t{share:.4}", marked as f64 / millions, scan * 1e3 / millions);
    }
    Ok(())
}
