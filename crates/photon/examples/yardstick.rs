//! How fast photons are traced beside Embree: the same triangles, lamps and reflectance, in turn in one run.
//!
//! `cargo run --release -p lightmend-photon --example yardstick -- EMBREE_PHOTON SCENE [PHOTONS] [ROUNDS]`
//!
//! `EMBREE_PHOTON` is a program that traces diffuse photons through an OBJ file by Embree. It gets `FILE --photons N --threads T
//! --mode 1|8 --albedo A --deposit --repeat 1`, reads lamps from lines `# light x y z`, and prints `rays=…`, `hits=…`, `checksum=…` (the
//! sum of the numbers of the triangles met) and `… Mrays/s`. Rates of both sides include random numbers, sampling and deposits.
//!
//! "alike": every surface reflects 0.5, every lamp shines alike in all directions. "as it is": the scene with its materials, textures
//! and diagrams; Embree's photons then have the reflectance that makes their paths as long, and still no diagrams. "same photons": ours
//! with Embree's hash in place of Halton, index order and one ray at a time; hits and checksum show that the paths are the same.

#[path = "support/times.rs"]
mod times;

use lightmend_photon::{
    body::TreePreset,
    halton::Scrambling,
    path::FirstHits,
    pool::Pool,
    sampling::orthonormal,
    solution::Solution,
    triangle::{Hit, Ray},
    world::World,
};
use lightmend_scene::{Configuration, Edit, Scene};
use rayon::prelude::*;
use std::{
    collections::BTreeSet,
    error::Error,
    fs::File,
    io::{BufWriter, Write},
    path::Path,
    process::Command,
    sync::Arc,
};
use times::{Seconds, median, timed};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// The same objects, all reflecting one half, under lamps that shine alike in all directions.
fn alike(mut configuration: Configuration) -> Result<Configuration> {
    let materials: BTreeSet<String> = configuration.materials().map(|material| material.name.clone()).collect();
    for material in materials {
        configuration = configuration.apply(&Edit::Texture { material: material.clone(), texture: None })?;
        configuration = configuration.apply(&Edit::Reflect { material, to: glam::DVec3::splat(0.5) })?;
    }
    let lamps: Vec<String> = configuration.lamps().map(|(_, lamp)| lamp.name.clone()).collect();
    for lamp in lamps {
        configuration = configuration.apply(&Edit::Relamp { lamp, photometry: None, intensity: Some(glam::DVec3::ONE) })?;
    }
    Ok(configuration)
}

/// All triangles and lamps as an OBJ file; where each object's triangles begin in it.
fn export(world: &World, path: &Path) -> Result<Vec<u64>> {
    let mut file = BufWriter::new(File::create(path)?);
    for (id, _) in world.configuration().lamps() {
        let p = world.lamps()[id].position;
        writeln!(file, "# light {} {} {}", p.x, p.y, p.z)?;
    }
    let (mut first, mut triangles) = (vec![0; world.configuration().object_slots()], 0u64);
    for (id, object) in world.configuration().objects() {
        first[id] = triangles;
        let motion = world.configuration().object_motion(id);
        for corners in &object.mesh.triangles {
            let mut points = corners.iter().map(|corner| motion.point(object.mesh.positions[*corner as usize]).as_vec3());
            points.try_for_each(|p| writeln!(file, "v {:?} {:?} {:?}", p.x, p.y, p.z))?;
            writeln!(file, "f -3 -2 -1")?;
            triangles += 1;
        }
    }
    Ok(first)
}

/// Millions of rays a second.
#[derive(Debug, Clone, Copy, Default)]
struct Rate {
    wall: f64,
    processor: f64,
}

impl Rate {
    fn of(rays: u64, seconds: Seconds) -> Rate {
        let [wall, processor] = seconds.map(|s| rays as f64 / s / 1e6);
        Rate { wall, processor }
    }
}

/// What one run of either side says.
#[derive(Debug, Clone, Copy, Default)]
struct Run {
    rate: Rate,
    rays: u64,
    hits: u64,
    checksum: u64,
}

fn embree(program: &str, obj: &Path, mode: &str, photons: u64, threads: usize, reflectance: f64) -> Result<Run> {
    let numbers = ["--photons", &photons.to_string(), "--threads", &threads.to_string(), "--albedo", &reflectance.to_string()];
    let output = Command::new(program).arg(obj).args(numbers).args(["--mode", mode, "--deposit", "--repeat", "1"]).output()?;
    let text = String::from_utf8(output.stdout)?;
    let number = |name: &str| text.split_whitespace().find_map(|word| word.strip_prefix(name)?.parse().ok());
    let rate = |after: &str| text.split(after).nth(1).and_then(|rest| rest.split_whitespace().next()?.parse().ok());
    let said = || format!("{program} said: {text}{}", String::from_utf8_lossy(&output.stderr));
    let [rays, hits, checksum] = ["rays=", "hits=", "checksum="].map(number);
    Ok(Run {
        rate: Rate { wall: rate("Mpaths/s").ok_or_else(said)?, processor: rate(" Mpaths ").ok_or_else(said)? },
        rays: rays.ok_or_else(said)?,
        hits: hits.ok_or_else(said)?,
        checksum: checksum.ok_or_else(said)?,
    })
}

fn ours(world: &Arc<World>, photons: u64) -> Result<Run> {
    let pool = Pool::new(photons, 288, 16, Scrambling::Seed(1))?;
    let mut rays = 0;
    let mut count = |_, more| {
        rays += more;
        true
    };
    let (seconds, shot) = timed(|| Solution::shoot(pool, world.clone(), FirstHits::Always, &mut count));
    shot.ok_or("nothing was shot")?;
    Ok(Run { rate: Rate::of(rays, seconds), rays, ..Run::default() })
}

/// Two numbers in [0, 1) for a photon and a segment of its path: splitmix64.
fn hashed(photon: u64, segment: u64) -> [f32; 2] {
    let z = (photon * 64 + segment).wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    let z = z ^ (z >> 31);
    [(z >> 40) as u32, z as u32 >> 8].map(|n| n as f32 / (1 << 24) as f32)
}

const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;
const TURN: f32 = std::f32::consts::TAU;

/// Embree's photons through our trees.
fn same_photons(world: &World, first: &[u64], photons: u64) -> Run {
    let lamps: Vec<_> = world.configuration().lamps().map(|(id, _)| world.lamps()[id].position.as_vec3()).collect();
    let follow = |photon: u64, run: &mut Run, deposits: &mut [f32]| {
        let [u, v] = hashed(photon, 0);
        let scaled = u * lamps.len() as f32;
        let lamp = (scaled as usize).min(lamps.len() - 1);
        let (z, azimuth) = (1.0 - 2.0 * v, TURN * (scaled - lamp as f32).min(BELOW_ONE));
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let (mut origin, mut direction) = (lamps[lamp], glam::vec3(radius * azimuth.cos(), radius * azimuth.sin(), z));
        for segment in 1.. {
            run.rays += 1;
            let Some(Hit { distance, triangle, .. }) = world.nearest(&Ray::new(origin, direction, None, 0.0)) else { return };
            let number = first[triangle.object()] + triangle.in_mesh() as u64;
            run.hits += 1;
            run.checksum += number;
            deposits[number as usize] += 1.0;
            let [u, v] = hashed(photon, segment);
            if u >= 0.5 {
                return;
            }
            let (u, azimuth) = ((u / 0.5).min(BELOW_ONE), TURN * v);
            let normal = if triangle.normal.dot(direction) > 0.0 { -triangle.normal } else { triangle.normal };
            let ((a, b), radius) = (orthonormal(normal), u.sqrt());
            let met = origin + direction * distance;
            direction = a * (radius * azimuth.cos()) + b * (radius * azimuth.sin()) + normal * (1.0 - u).max(0.0).sqrt();
            origin = met + normal * 1e-4;
        }
    };
    let triangles = world.configuration().objects().map(|(_, object)| object.mesh.triangles.len()).sum();
    let trace = || {
        (0..photons.div_ceil(4096))
            .into_par_iter()
            .fold(
                || (Run::default(), vec![0.0; triangles]),
                |(mut run, mut deposits), chunk| {
                    (chunk * 4096..photons.min((chunk + 1) * 4096)).for_each(|photon| follow(photon, &mut run, &mut deposits));
                    (run, deposits)
                },
            )
            .map(|(run, _)| run)
            .reduce(Run::default, |a, b| Run {
                rate: Rate::default(),
                rays: a.rays + b.rays,
                hits: a.hits + b.hits,
                checksum: a.checksum + b.checksum,
            })
    };
    let (seconds, run) = timed(trace);
    Run { rate: Rate::of(run.rays, seconds), ..run }
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [program, scene, numbers @ ..] = &arguments[..] else {
        return Err("usage: yardstick EMBREE_PHOTON SCENE [PHOTONS] [ROUNDS]".into());
    };
    let number = |n: usize, default| numbers.get(n).map_or(Ok(default), |n| n.parse());
    let (photons, rounds) = (number(0, 1_152_000)?, number(1, 5)?);
    let (scene, _) = Scene::read(scene.as_ref())?;
    let as_it_is = Configuration::initial(&scene);
    let worlds = [alike(as_it_is.clone())?, as_it_is].map(|c| Arc::new(World::new(&c, TreePreset::default())));
    let obj = std::env::temp_dir().join(format!("yardstick-{}.obj", std::process::id()));
    let first = export(&worlds[0], &obj)?;
    println!(
        "{}: {} triangles, {photons} photons, {rounds} rounds; medians of Mrays/s and of ratios",
        scene.name,
        scene.triangles()
    );
    let as_long = 1.0 - photons as f64 / ours(&worlds[1], photons)?.rays as f64;
    let kinds = [("alike", &worlds[0], 0.5), ("as it is", &worlds[1], as_long)];
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        for (kind, world, reflectance) in kinds {
            let (mut all, mut long) = ([const { Vec::new() }; 4], [0.0; 2]);
            for _ in 0..rounds {
                let own = pool.install(|| ours(world, photons).map_err(|e| e.to_string()))?;
                let eight = embree(program, &obj, "8", photons, threads, reflectance)?;
                let one = embree(program, &obj, "1", photons, threads, reflectance)?;
                long = [own, eight].map(|run| run.rays as f64 / photons as f64);
                let mut runs = vec![own, one, eight];
                if kind == "alike" {
                    let same = pool.install(|| same_photons(world, &first, photons));
                    let [hits, checksum] = [[same.hits, eight.hits], [same.checksum, eight.checksum]];
                    if hits[0].abs_diff(hits[1]) * 1000 > hits[1] || checksum[0].abs_diff(checksum[1]) * 1000 > checksum[1] {
                        return Err(format!("other photons: {hits:?} hits, checksums {checksum:?}").into());
                    }
                    runs.push(same);
                }
                all.iter_mut().zip(runs).for_each(|(rates, run)| rates.push(run.rate));
            }
            let sides = ["ours", "intersect1", "intersect8", "same photons"];
            println!("{threads} threads, {kind}: rays a photon {:.3}, Embree's {:.3}", long[0], long[1]);
            for (rates, side) in all.iter().zip(sides).filter(|(rates, _)| !rates.is_empty()) {
                let median_of = |rate: fn(&Rate) -> f64| median(rates.iter().map(rate).collect());
                let over = |other: usize, rate: fn(&Rate) -> f64| {
                    median(rates.iter().zip(&all[other]).map(|(a, b)| rate(a) / rate(b)).collect())
                };
                let wall: fn(&Rate) -> f64 = |rate| rate.wall;
                let processor: fn(&Rate) -> f64 = |rate| rate.processor;
                println!(
                    "  {side:12} {:6.2} = {:.2} x intersect1 = {:.2} x intersect8; a processor second {:6.2} = {:.2} = {:.2}",
                    median_of(wall),
                    over(1, wall),
                    over(2, wall),
                    median_of(processor),
                    over(1, processor),
                    over(2, processor)
                );
            }
        }
    }
    std::fs::remove_file(obj)?;
    Ok(())
}
