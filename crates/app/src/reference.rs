//! `lightmend reference`: irradiance at points of surfaces by path tracing, to hold the photons against.

use crate::{
    Common,
    failure::Failure,
    output::{self, say},
    points::{self, Files, Light, Points},
    progress,
};
use lightmend_photon::{
    body::TreePreset,
    probe::direct,
    reference::{PathTracer, Plan},
    world::World,
};
use lightmend_scene::Configuration;

#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    files: Files,
    /// Paths per point, 32,768 by default; at least 32, one for each batch whose scatter gives the standard errors. More: less noise
    /// (half for four times as many). With --error the most per point, 4,194,304 by default
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u64).range(1..=1 << 40))]
    paths: Option<u64>,
    /// Go on at each point until the standard error of its indirect illuminance is at most this share of it, 0.01 for 1 %. Stopping by
    /// what was found favours low values where light is rare: for an unbiased result give --paths alone
    #[arg(long, value_name = "E", allow_negative_numbers = true, value_parser = parse_share)]
    error: Option<f64>,
    /// Seed of the random numbers: results of different seeds are independent
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    common: Common,
}

impl Arguments {
    fn plan(&self) -> Plan {
        match self.error {
            None => Plan::of_paths(self.paths.unwrap_or(1 << 15), self.seed),
            Some(error) => Plan::to_error(error, self.paths.unwrap_or(1 << 22), self.seed),
        }
    }
}

fn parse_share(text: &str) -> Result<f64, String> {
    let share: f64 = text.parse().map_err(|_| "not a number")?;
    if share > 0.0 && share < 1.0 { Ok(share) } else { Err("must be between 0 and 1".into()) }
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { files, common, .. } = arguments;
    common.set_up()?;
    let points = Points::read(&files.points)?;
    let scene = common.read_scene(&files.scene)?;
    output::file(&files.out)?;
    let world = World::new(&Configuration::initial(&scene), TreePreset::default());
    let places = points.locate(&world)?;
    let plan = arguments.plan();
    let mut reference = PathTracer::new(&world, places.iter().map(|place| (place.point, place.normal)).collect(), plan);
    let bar = progress::bar(0, "tracing paths", common.quiet);
    while reference.paths_ahead() > 0 {
        bar.inc_length(reference.paths_ahead());
        reference.round(&|paths| {
            bar.inc(paths);
            !progress::interrupted()
        });
    }
    bar.finish_and_clear();
    // After Ctrl-C some points may have too few batches for a standard error: those are left out.
    let known: Vec<_> = places.iter().zip(reference.estimates()).filter(|(_, estimate)| estimate.is_known()).collect();
    if known.is_empty() && !places.is_empty() {
        return Err(Failure::failed("interrupted before any point had enough paths to keep"));
    }
    let lit = known.iter().map(|(place, estimate)| {
        let direct = direct(&world, place.point, place.normal);
        (**place, Light { direct, indirect: estimate.value(), standard_error: estimate.standard_error() })
    });
    output::write(&files.out, |file| points::write(file, scene.file.origin, lit))?;

    let mut errors: Vec<f64> = known.iter().map(|(_, estimate)| estimate.relative_error()).collect();
    errors.sort_by(f64::total_cmp);
    let (median, worst) = (errors.get(errors.len() / 2).copied().unwrap_or(0.0), errors.last().copied().unwrap_or(0.0));
    let missed = errors.iter().filter(|error| plan.error.is_some_and(|wanted| **error > wanted)).count();
    let paths = known.iter().map(|(_, estimate)| u64::from(estimate.batches())).sum::<u64>() * plan.paths_in_batch();
    if common.json {
        let summary = serde_json::json!({
            "points": known.len(), "paths": paths, "median_relative_error": median, "worst_relative_error": worst,
            "missed": missed, "out": files.out,
        });
        output::json(None, &summary, true)?;
    } else if common.talks() {
        let [median, worst] = [median, worst].map(|share| 100.0 * share);
        say(&format!(
            "{} points, {paths} paths, standard error {median:.2} % (median), {worst:.2} % (worst): {}",
            known.len(),
            files.out.display()
        ));
        if missed > 0 {
            say(&format!("{missed} points are less sure than was asked for: raise --paths"));
        }
    }
    if progress::interrupted() {
        return Err(Failure::failed(format!("interrupted; {} of {} points were kept", known.len(), places.len())));
    }
    Ok(())
}
