//! `lightmend`: interactive global illumination for rooms that people rearrange.
//!
//! One file per subcommand; this one reads the arguments, sets up threads and turns failures into one line and an exit status:
//! 0 done, 1 failed, 2 bad input or arguments.

mod apply;
mod check;
mod failure;
mod figure;
mod frames;
mod import;
mod indirect;
mod masking;
mod onlooker;
mod output;
mod picture;
mod points;
mod probe;
mod progress;
mod reference;
mod replay;
mod report;
mod solve;
#[cfg(feature = "window")]
mod view;

use clap::{Args, Parser, Subcommand};
use failure::Failure;
use lightmend_photon::{
    halton::Scrambling,
    pool::{Pool, PoolError},
};
use lightmend_scene::{Scene, Warning};
use std::{path::Path, process::ExitCode, sync::Arc};

/// Interactive global illumination for rooms that people rearrange.
#[derive(Parser)]
#[command(version, about)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Walk about in a window and rearrange the room
    #[cfg(feature = "window")]
    View(view::Arguments),
    /// Shoot a pool of photons and write what it lit
    Solve(solve::Arguments),
    /// Write the scene as it is after scripted moves
    Apply(apply::Arguments),
    /// Draw scripted moves frame by frame, without a window
    Frames(frames::Arguments),
    /// Repair the light after scripted moves, in several orders, and compare their work
    Replay(replay::Arguments),
    /// Measure speed against error, from the cold start and after every edit, and write it as one page
    Report(report::Arguments),
    /// Read irradiance at points of surfaces
    Probe(probe::Arguments),
    /// Path-trace irradiance at points of surfaces, without photons: what `probe` is held against
    Reference(reference::Arguments),
    /// Say what is in a scene and what is wrong with it
    Check(check::Arguments),
    /// Make a scene file of OBJ models
    Import(import::Arguments),
}

/// What every command takes.
#[derive(Args, Clone, Copy)]
struct Common {
    /// Threads to trace with; all cores by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Say nothing but errors
    #[arg(long)]
    quiet: bool,
    /// Print the summary as JSON, and nothing else, on standard output
    #[arg(long)]
    json: bool,
}

impl Common {
    /// Whether to talk on standard output.
    fn talks(&self) -> bool {
        !self.quiet && !self.json
    }

    fn set_up(&self) -> Result<(), Failure> {
        let threads = self.threads.map_or(0, usize::from);
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build_global()
            .map_err(|e| Failure::failed(format!("threads cannot be started: {e}")))?;
        progress::listen_for_interrupt()
    }

    fn read_scene(&self, path: &Path) -> Result<Arc<Scene>, Failure> {
        let (scene, warnings) = Scene::read(path)?;
        self.warn(&warnings);
        Ok(scene)
    }

    fn warn(&self, warnings: &[Warning]) {
        if !self.quiet {
            for warning in warnings {
                eprintln!("warning: {warning}");
            }
        }
    }
}

/// How large a pool is and how its sequence is scrambled.
#[derive(Args, Clone, Copy)]
struct PoolArguments {
    /// Photons in the pool, 1,152,000 by default. More: less noise (half for four times as many), longer work
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    photons: Option<u64>,
    /// Groups that the pool is split into (the seed's Ng), best a product of powers of 2, 3, 5, 7; by default 2^3 3^2 for one lamp
    /// and twice as many for twice the lamps
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    ng: Option<u32>,
    /// Photons per pilot photon (the seed's R)
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..))]
    r: u32,
    /// Seed of the sequence's digit permutations; 0 is the plain Halton sequence
    #[arg(long, value_name = "N", default_value_t = 1)]
    scramble: u64,
    /// Copies of the sequence, each with permutations of its own: 1, 2, 4, … 64
    #[arg(long, value_name = "M", default_value_t = 1)]
    copies: u32,
}

/// The seed's pool for its ROOM.
const DEFAULT_PHOTONS: u64 = 1_152_000;

impl PoolArguments {
    /// N_g: the seed's (§7) for so many lamps, at most 4,608 for small pools' sake, unless it is given.
    fn groups(&self, scene: &Scene) -> u32 {
        self.ng.unwrap_or_else(|| 72 * (scene.lamps.len().clamp(1, 64).next_power_of_two() as u32))
    }

    fn pool(&self, scene: &Scene) -> Result<Pool, Failure> {
        let scrambling = if self.scramble == 0 { Scrambling::None } else { Scrambling::Seed(self.scramble) };
        Pool::new(self.photons.unwrap_or(DEFAULT_PHOTONS), self.groups(scene), self.r, scrambling)
            .and_then(|pool| pool.in_copies(self.copies))
            .map_err(|e| {
                let argument = if matches!(e, PoolError::Copies(_)) { "--copies" } else { "--photons" };
                Failure::input(format!("{argument}: {e}"))
            })
    }

    /// The smallest pool of these groups: one pilot in each. It can grow to any size, and any of its prefixes can be kept.
    fn smallest(self, scene: &Scene) -> Result<Pool, Failure> {
        PoolArguments { photons: Some(u64::from(self.groups(scene)) * u64::from(self.r) * u64::from(self.copies)), ..self }
            .pool(scene)
    }
}

/// Mesa's drivers look for a Wayland compositor on the way to any device and complain on standard error where this variable is not
/// set, as in containers and in CI, although nothing here needs one.
#[allow(unsafe_code)]
fn keep_drivers_quiet() {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: called first in `main`, before any other thread exists that could read the environment.
        unsafe { std::env::set_var("XDG_RUNTIME_DIR", std::env::temp_dir()) };
    }
}

fn main() -> ExitCode {
    keep_drivers_quiet();
    let result = Arguments::try_parse().map_err(Failure::arguments).and_then(|arguments| match arguments.command {
        #[cfg(feature = "window")]
        Command::View(arguments) => view::run(&arguments),
        Command::Solve(arguments) => solve::run(&arguments),
        Command::Apply(arguments) => apply::run(&arguments),
        Command::Frames(arguments) => frames::run(&arguments),
        Command::Replay(arguments) => replay::run(&arguments),
        Command::Report(arguments) => report::run(&arguments),
        Command::Probe(arguments) => probe::run(&arguments),
        Command::Reference(arguments) => reference::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Import(arguments) => import::run(&arguments),
    });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("lightmend: {failure}");
            ExitCode::from(failure.status())
        }
    }
}
