//! One point, measured: shooting without and with the ledger, then edits taken up, scanned and repaired.

use crate::{
    point::{Grown, Point},
    process::{Times, memory},
    scenes,
    times::median,
};
use lightmend_photon::{
    body::TreePreset,
    bucket::{Address, Bucket, Buckets, Full},
    halton::Scrambling,
    ledger::LedgerSolution,
    path::FirstHits,
    pool::Pool,
    shooting::Work,
    solution::Solution,
    world::World,
};
use lightmend_scene::Configuration;
use std::{error::Error, path::Path, sync::Arc};

/// Of the whole process: a pool that would need more is refused, and a process that did is told at the end.
pub const BUDGET: f64 = 5e9;

/// Columns with their values; seconds and bytes.
pub type Row = Vec<(String, f64)>;

/// Slices of a scan, one a frame.
const SLICES: usize = 20;

/// Measures a point.
pub fn measure(point: &Point, scenes: &Path, out: &Path) -> Result<Row, Box<dyn Error>> {
    let mut row = Row::new();
    let mut put = |column: &str, value: f64| row.push((column.into(), value));
    let scene = scenes::make(point, scenes, out)?;
    let home = Configuration::initial(&scene);
    let movables = home.objects().filter(|(_, object)| object.dynamic).count();
    put("photons", point.photons as f64);
    put("elements", scene.cells() as f64);
    put("triangles", scene.triangles() as f64);
    put("movables", if let Grown::Movables(n) = point.grown { n } else { movables } as f64);

    let resident = memory("VmRSS")?;
    let mut building = Times::default();
    let world = Arc::new(building.run(|| World::new(&home, TreePreset::default())));
    put("trees s", building.wall());
    put("trees processor s", building.processor());
    put("trees bytes", memory("VmRSS")? - resident);

    let pool = Pool::new(point.photons, 288, 16, Scrambling::Seed(1))?;
    let rounds = (16_000_000 / point.photons).clamp(1, 5);
    let (mut plain, mut kept, mut ledger) = (Times::default(), Times::default(), None);
    for round in 0..rounds {
        drop(ledger.take());
        let shoot = || Solution::shoot(pool, world.clone(), FirstHits::AsLampsSay, &mut |_, _| true);
        let solution = plain.run(shoot).ok_or("too few photons")?;
        let light = hash(solution.buckets());
        if round == 0 {
            put("plain peak bytes", memory("VmHWM")?);
            put("buckets bytes", solution.buckets().bytes() as f64);
        }
        // Not kept beside the ledger: the peak is to be the ledger's own.
        drop(solution);
        let limit = BUDGET as u64;
        let begun = kept.run(|| LedgerSolution::shoot(pool, world.clone(), FirstHits::AsLampsSay, limit, &mut |_, _| true))?;
        if hash(begun.buckets()) != light {
            return Err("the ledger's light is not the solution's".into());
        }
        ledger = Some(begun);
    }
    let mut ledger = ledger.ok_or("no rounds")?;
    put("plain s", plain.wall());
    put("plain processor s", plain.processor());
    put("ledger s", kept.wall());
    put("ledger processor s", kept.processor());
    put("ledger bytes", ledger.bytes() as f64);
    put("shot peak bytes", memory("VmHWM")?);
    put("hits", ledger.entries() as f64);

    let rounds = if point.photons > 50_000_000 { 2 } else { 6 };
    for (name, moved) in scenes::edits(point, &home)? {
        for (column, value) in edit(&mut ledger, &[moved, home.clone()], rounds)? {
            put(&format!("{name} {column}"), value);
        }
    }
    put("peak bytes", memory("VmHWM")?);
    Ok(row)
}

/// Of all light, to the bit.
fn hash(buckets: &Buckets) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    for (Address { object, cell, side, lamp }, Bucket { energy, hits }) in buckets.lit() {
        [object, cell, u32::from(side), u32::from(lamp)].iter().for_each(|n| _ = hasher.update(&n.to_le_bytes()));
        energy.iter().chain([&hits]).for_each(|n| _ = hasher.update(&n.to_le_bytes()));
    }
    hasher.finalize()
}

/// An edit there and back: what each of its steps takes, seconds.
fn edit(ledger: &mut LedgerSolution, configurations: &[Configuration; 2], rounds: usize) -> Result<Row, Box<dyn Error>> {
    let [mut moving, mut changing, mut slicing, mut scanning] = std::array::from_fn(|_| Times::default());
    let [mut asking, mut stepping, mut repairing] = std::array::from_fn(|_| Times::default());
    let slice = ledger.photons().div_ceil(256 * SLICES as u64) as usize;
    let (mut marks, mut rays, mut parted) = (Vec::new(), Vec::new(), Vec::new());
    for round in 0..rounds {
        let world = moving.run(|| Arc::new(ledger.world().moved_to(&configurations[round % 2])));
        changing.run(|| ledger.change(world))?;
        slicing.run(|| ledger.scan(slice));
        scanning.run(|| ledger.scan(usize::MAX));
        let marked = asking.run(|| (ledger.is_exact(), ledger.outstanding_photons())).1;
        let mut work = Work::default();
        stepping.run(|| ledger.repair_next().map(|next| next.iter().for_each(|mended| work += mended.work)))?;
        repairing.run(|| {
            while let Some(mended) = ledger.repair_next()? {
                work += mended.work;
            }
            Ok::<(), Full>(())
        })?;
        marks.push(marked as f64);
        rays.push(work.rays as f64);
        parted.push(work.photons as f64);
    }
    // A frame takes up an edit, scans a slice, asks how far it is and repairs a step.
    let frame = [&moving, &changing, &slicing, &asking, &stepping];
    let mut row = vec![("marked".into(), median(marks)), ("wrong".into(), median(parted)), ("rays".into(), median(rays))];
    let steps: [(&str, &[&Times]); 7] = [
        ("moved", &[&moving]),
        ("change", &[&changing]),
        ("scan", &[&slicing, &scanning]),
        ("ask", &[&asking]),
        ("step", &[&stepping]),
        ("repair", &[&stepping, &repairing]),
        ("frame", &frame),
    ];
    for (name, times) in steps {
        row.push((format!("{name} s"), times.iter().map(|t| t.wall()).sum()));
        row.push((format!("{name} processor s"), times.iter().map(|t| t.processor()).sum()));
    }
    Ok(row)
}
