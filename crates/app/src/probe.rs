//! `lightmend probe`: irradiance at points of surfaces.

use crate::{
    Common, PoolArguments,
    failure::Failure,
    output::{self, say},
    points::{self, Files, Light, Points},
    progress,
};
use lightmend_photon::{
    body::TreePreset,
    gather::Gather,
    irradiance::{Irradiance, Scale},
    path::FirstHits,
    probe::{Place, direct},
    reconstruction::{Reconstruction, Shapes},
    solution::Solution,
    world::World,
};
use lightmend_scene::Configuration;
use rayon::prelude::*;
use std::sync::Arc;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    files: Files,
    #[command(flatten)]
    pool: PoolArguments,
    /// Rays per point that gather the photons' light. More: less noise (half for four times as many), longer work
    #[arg(long, value_name = "N", default_value_t = 4096, allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    rays: u32,
    #[command(flatten)]
    common: Common,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { files, common, .. } = arguments;
    common.set_up()?;
    let points = Points::read(&files.points)?;
    let scene = common.read_scene(&files.scene)?;
    let pool = arguments.pool.pool(&scene)?;
    output::file(&files.out)?;
    let world = Arc::new(World::new(&Configuration::initial(&scene), TreePreset::default()));
    let places = points.locate(&world)?;
    let bar = progress::bar(pool.photons(), "shooting photons", common.quiet);
    // Buckets of indirect light alone: the direct part is computed at the points.
    let solution = Solution::shoot(pool, world.clone(), FirstHits::Never, &mut |photons, _| {
        bar.set_position(photons);
        !progress::interrupted()
    });
    bar.finish_and_clear();
    let solution = solution.ok_or_else(|| Failure::failed("interrupted before there were enough photons to keep"))?;
    let photons = solution.pool().photons();
    let (configuration, scale) = (world.configuration(), Scale::new(&world, photons));
    let shapes = Shapes::of(configuration);
    let light = Reconstruction::new(&shapes, configuration, solution.buckets(), &scale, configuration.lamp_slots());
    let gather = Gather { world: &world, light: &light, buckets: solution.buckets(), scale: &scale, rays: arguments.rays };
    // Interrupted already: the photons are fewer, the points all the same.
    let before = progress::interrupted();
    let bar = progress::bar(places.len() as u64, "gathering at points", common.quiet);
    let at = |(number, place): (usize, &Place)| {
        if progress::interrupted() && !before {
            return None;
        }
        let Irradiance { value, standard_error, .. } = gather.at(place, number);
        bar.inc(1);
        Some((*place, Light { direct: direct(&world, place.point, place.normal), indirect: value, standard_error }))
    };
    let lit: Vec<(Place, Light)> = places.par_iter().enumerate().filter_map(at).collect();
    bar.finish_and_clear();
    if lit.is_empty() && !places.is_empty() {
        return Err(Failure::failed("interrupted before any point was gathered"));
    }
    let read = lit.len();
    output::write(&files.out, |file| points::write(file, scene.file.origin, lit))?;
    if common.json {
        output::json(None, &serde_json::json!({ "points": read, "photons": photons, "out": files.out }), true)?;
    } else if common.talks() {
        say(&format!("{read} points read from {photons} photons: {}", files.out.display()));
    }
    if progress::interrupted() {
        return Err(Failure::failed(format!("interrupted; {photons} photons and {read} of {} points were kept", places.len())));
    }
    Ok(())
}
