//! `lightmend solve`: shoot a pool and write what it lit.

use crate::{
    Common, PoolArguments,
    failure::Failure,
    output::{self, say},
    picture, progress,
};
use lightmend_photon::{
    body::TreePreset,
    bucket::Full,
    irradiance::Scale,
    path::FirstHits,
    pool::Pool,
    reconstruction::{Reconstruction, Shapes},
    saved::Saved,
    shooting::Shooting,
    solution::Solution,
    world::World,
};
use lightmend_scene::{Configuration, SceneError};
use serde_json::json;
use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Instant,
};

#[derive(clap::Args)]
pub struct Arguments {
    /// Scene file
    scene: PathBuf,
    #[command(flatten)]
    pool: PoolArguments,
    /// Shoot for so many seconds instead of a number of photons
    #[arg(long, value_name = "S", conflicts_with = "photons", allow_negative_numbers = true)]
    seconds: Option<f64>,
    /// Shoot until the estimated median relative error of the reconstructed light is at most this, for example 0.01
    #[arg(long, value_name = "E", conflicts_with_all = ["photons", "seconds"], allow_negative_numbers = true)]
    error: Option<f64>,
    /// Write the integer buckets, one line per object, cell, side and lamp
    #[arg(long, value_name = "FILE")]
    dump: Option<PathBuf>,
    /// Write summary.json, solution.light (see --resume) and a picture per camera into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Go on from a solution.light that was written for this scene, as if it had never been interrupted
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

/// The file that --resume goes on from.
const SOLUTION: &str = "solution.light";

/// Photons between two looks at the error, at least.
const LEAST_MORE: u64 = Shooting::SLAB / 4;

/// Photons of a run that ends by the clock or by its error: as many as there are indices.
const AS_MANY_AS_IT_TAKES: u64 = lightmend_photon::halton::INDEX_LIMIT;

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let common = &arguments.common;
    common.set_up()?;
    let scene = common.read_scene(&arguments.scene)?;
    let photons = match arguments.seconds {
        None if arguments.error.is_some() => AS_MANY_AS_IT_TAKES,
        None => arguments.pool.pool(&scene)?.photons(),
        Some(seconds) if seconds.is_finite() && seconds > 0.0 => AS_MANY_AS_IT_TAKES,
        Some(seconds) => return Err(Failure::input(format!("--seconds {seconds}: must be positive"))),
    };
    if let Some(error) = arguments.error.filter(|e| !(e.is_finite() && *e > 0.0)) {
        return Err(Failure::input(format!("--error {error}: must be positive, for example 0.01")));
    }
    // Nothing is repaired here, so the fewest pilots do, and a run that ends early keeps what it shot.
    let smallest = arguments.pool.smallest(&scene)?;
    let pool = smallest.grown(photons);
    arguments.dump.as_deref().map_or(Ok(()), output::file)?;
    let pictures = picture::file_names(&scene, &[]);
    let files = [&["summary.json".to_owned(), SOLUTION.to_owned()], &pictures[..]].concat();
    let out = arguments.out.as_deref().map(|out| output::folder(out, &files)).transpose()?;

    let configuration = Configuration::initial(&scene);
    let saved = arguments.resume.as_deref().map(|path| read_saved(path, &configuration, &pool)).transpose()?;
    let start = Instant::now();
    let world = Arc::new(World::new(&configuration, TreePreset::default()));
    let built = start.elapsed().as_secs_f64();
    let bar = progress::bar(arguments.seconds.map_or(pool.photons(), |s| (s * 1000.0) as u64), "shooting photons", common.quiet);
    let before = saved.as_ref().map_or(0, |s| s.photons);
    let start = Instant::now();
    let mut rays = 0;
    let mut progress = |photons, new_rays| {
        rays += new_rays;
        let elapsed = start.elapsed().as_secs_f64();
        bar.set_position(arguments.seconds.map_or(photons, |_| (elapsed * 1000.0) as u64));
        !progress::interrupted() && arguments.seconds.is_none_or(|s| elapsed < s)
    };
    let first = if arguments.error.is_some() { smallest.grown(before.max(LEAST_MORE)) } else { pool };
    let solution = match saved {
        None => Solution::shoot(first, world, FirstHits::AsLampsSay, &mut progress),
        Some(saved) => Solution::resume(first, world, saved, &mut progress),
    };
    let Some(mut solution) = solution else {
        return Err(Failure::failed("interrupted before there were enough photons to keep"));
    };
    let shapes = Shapes::of(&configuration);
    let mut median_error = median_error(&shapes, &solution);
    while let Some(wanted) = arguments.error.filter(|wanted| median_error > *wanted && !progress::interrupted()) {
        let shot = solution.pool().photons();
        // A sixteenth more takes away 3 % of the error.
        let more = (shot / 16).clamp(LEAST_MORE, 16 * LEAST_MORE).min(pool.photons() - shot);
        let Some(work) = solution.grow(more).filter(|work| work.photons > 0) else { break };
        rays += work.rays;
        median_error = self::median_error(&shapes, &solution);
        bar.set_length(((shot + more) as f64 * (median_error / wanted).powi(2).max(1.0)) as u64);
        bar.set_position(shot + more);
    }
    bar.finish_and_clear();
    let seconds = start.elapsed().as_secs_f64();
    let photons = solution.pool().photons();

    let buckets = solution.buckets();
    if let Some(path) = &arguments.dump {
        output::write(path, |file| buckets.dump(solution.world().configuration(), file))?;
    }
    let tallies = solution.tallies();
    let total = |f: fn(&lightmend_photon::record::Tally) -> i64| tallies.iter().map(f).sum::<i64>();
    let threads = rayon::current_num_threads();
    let summary = json!({
        "scene": scene.name, "photons": photons, "resumed_from": before, "threads": threads, "rays": rays, "seconds": seconds, "tree_seconds": built,
        "triangles": scene.triangles(), "cells": scene.cells(),
        "absorbed": total(|t| t.absorbed), "escaped": total(|t| t.escaped), "cut": total(|t| t.cut),
    "median_error": median_error,
        "lit_buckets": buckets.lit().count(), "bucket_bytes": buckets.bytes(), "interrupted": progress::interrupted(),
    });
    output::json(out.as_ref().map(|o| o.join("summary.json")).as_deref(), &summary, common.json)?;
    if common.talks() {
        say(&format!(
            "{}: {photons} photons, {rays} rays ({:.2} a photon) in {seconds:.2} s on {threads} threads: {:.2} Mrays/s",
            scene.name,
            rays as f64 / (photons - before).max(1) as f64,
            rays as f64 / seconds / 1e6
        ));
        say(&format!("estimated median error of the reconstructed light: {:.2} %", 100.0 * median_error));
        say(&format!("absorbed {}, escaped {}, cut {}", total(|t| t.absorbed), total(|t| t.escaped), total(|t| t.cut)));
    }
    if let Some(out) = out {
        if let Some(saved) = solution.to_saved() {
            output::write(&out.join(SOLUTION), |file| saved.write(solution.world().configuration(), file))?;
        }
        let scale = Scale::new(solution.world(), photons);
        for (name, (_, view)) in pictures.iter().zip(&scene.cameras) {
            let path = out.join(name);
            picture::write(&path, solution.world(), buckets, &scale, view)?;
            if common.talks() {
                say(&format!("picture: {}", path.display()));
            }
        }
    }
    if progress::interrupted() {
        return Err(Failure::failed(format!("interrupted; {photons} photons were kept")));
    }
    if solution.is_full() && photons < pool.photons() {
        return Err(Failure::from(Full).with(&format!("{photons} were kept")));
    }
    Ok(())
}

fn median_error(shapes: &Shapes, solution: &Solution) -> f64 {
    let (world, scale) = (solution.world(), Scale::new(solution.world(), solution.pool().photons()));
    let configuration = world.configuration();
    Reconstruction::new(shapes, configuration, solution.buckets(), &scale, configuration.lamp_slots()).median_error()
}

/// A saved solution that fits the scene and the pool.
fn read_saved(path: &Path, configuration: &Configuration, pool: &Pool) -> Result<Saved, Failure> {
    let bytes = std::fs::read(path).map_err(|e| SceneError::read(path, e))?;
    let saved = Saved::read(&bytes, configuration).map_err(|e| SceneError::content(path, e))?;
    let sequence = (saved.scrambling, saved.copies, saved.first_hits);
    if sequence != (pool.scrambling, pool.copies_and_groups(), FirstHits::AsLampsSay) {
        return Err(SceneError::content(path, "it was shot with another --scramble or --copies; give that one").into());
    }
    if saved.photons > pool.photons() {
        let what = format!("it has {} photons already; ask for more with --photons", saved.photons);
        return Err(SceneError::content(path, what).into());
    }
    Ok(saved)
}
