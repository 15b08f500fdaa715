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
    irradiance::Scale,
    path::FirstHits,
    probe::read,
    reconstruction::{Reconstruction, Shapes},
    solution::Solution,
    world::World,
};
use lightmend_scene::Configuration;
use std::sync::Arc;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    files: Files,
    #[command(flatten)]
    pool: PoolArguments,
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
    let indirect = Reconstruction::new(&shapes, configuration, solution.buckets(), &scale, configuration.lamp_slots());
    let readings = places.iter().map(|place| (place, Light::from(read(&world, &indirect, place))));
    output::write(&files.out, |file| points::write(file, readings))?;
    if common.json {
        output::json(None, &serde_json::json!({ "points": places.len(), "photons": photons, "out": files.out }), true)?;
    } else if common.talks() {
        say(&format!("{} points read from {photons} photons: {}", places.len(), files.out.display()));
    }
    if progress::interrupted() { Err(Failure::failed(format!("interrupted; {photons} photons were kept"))) } else { Ok(()) }
}
