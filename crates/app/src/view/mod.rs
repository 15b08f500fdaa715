//! `lightmend view`: a window in which a person walks about and rearranges the room, while its light mends.
//!
//! The flow of a frame: [`window`] takes what mouse and keys did; [`desk`] lets [`viewport`], [`panels`] and [`commands`] act on the
//! [`session`], which edits the scene ([`history`], [`placement`]) and tells the solver; [`window`] draws what stands now with the light
//! that [`light`] has read so far, as finely as [`governor`] finds fitting.

mod autosave;
mod commands;
#[cfg(test)]
mod corpus_tests;
mod desk;
mod dialogs;
mod furnish;
mod governor;
mod history;
mod light;
mod messages;
mod navigation;
mod overlay;
mod panels;
mod pick;
mod placement;
mod playback;
mod recovery;
mod report;
mod session;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod trial;
mod viewport;
mod window;

use crate::{
    Common, PoolArguments,
    failure::Failure,
    frames::{Show, parse_size},
    output::{self, say},
    progress,
};
use desk::Desk;
use egui_winit::winit::event_loop::EventLoop;
use lightmend_photon::solver::Controls;
use session::{Session, Start};
use std::path::PathBuf;
use window::{App, Wake};

#[derive(clap::Args)]
pub struct Arguments {
    /// Scene file
    scene: PathBuf,
    /// Moves file to play once the window is open
    #[arg(long, value_name = "MOVES")]
    script: Option<PathBuf>,
    /// Moves file to write at the end: everything that was done, for frames, replay and apply
    #[arg(long, value_name = "MOVES")]
    record: Option<PathBuf>,
    /// Size of the window, points
    #[arg(long, value_name = "WxH", default_value = "1280x800", value_parser = parse_size)]
    size: [u32; 2],
    /// Frames per second while something moves. More: smoother and coarser; fewer: finer, and light is right sooner
    #[arg(long, value_name = "N", default_value_t = 20.0, value_parser = parse_fps)]
    fps: f64,
    /// What is drawn at first; F2 to F6 change it
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = Show::Radiance)]
    show: Show,
    /// Once the light is right the pool grows until the estimated median error of indirect light is no more than this; 0.01 unless
    /// --photons says how many there are to be. A fourth of the error takes 16 times the photons
    #[arg(long, value_name = "SHARE", value_parser = parse_error)]
    error: Option<f64>,
    /// Memory for the records of photons' paths, some 27 bytes each: 500M, 2G. The pool stops growing when they are full; if they
    /// cannot hold it at all, wrong photons are searched for instead of looked up. 0: always searched for
    #[arg(long, value_name = "BYTES", default_value = "1G", value_parser = parse_bytes)]
    memory: u64,
    /// File for every bucket at the end, once the light is exact, as by solve
    #[arg(long, value_name = "FILE")]
    dump: Option<PathBuf>,
    /// File for what the session was like: frame times, photons per second, how soon the light was right; JSON
    #[arg(long, value_name = "FILE")]
    summary: Option<PathBuf>,
    #[command(flatten)]
    pool: PoolArguments,
    #[command(flatten)]
    common: Common,
}

/// The error that the pool grows to unless something else is asked for: nobody sees it.
const FINE: f64 = 0.01;

/// Frames per second that mean something.
fn parse_fps(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|fps| (1.0..=240.0).contains(fps)).ok_or_else(|| "a number from 1 to 240".into())
}

/// An error that light can be asked for.
fn parse_error(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|error| *error > 0.0 && *error < 1.0).ok_or_else(|| "a number between 0 and 1, 0.01 for 1 %".into())
}

/// A number of bytes, with k, M or G for powers of 1024.
fn parse_bytes(text: &str) -> Result<u64, String> {
    let (number, factor) = match text.char_indices().last() {
        Some((end, 'k' | 'K')) => (&text[..end], 1u64 << 10),
        Some((end, 'M')) => (&text[..end], 1 << 20),
        Some((end, 'G')) => (&text[..end], 1 << 30),
        _ => (text, 1),
    };
    let bytes = number.parse::<u64>().ok().and_then(|number| number.checked_mul(factor));
    bytes.ok_or_else(|| "a number of bytes: 500M, 2G".into())
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let common = &arguments.common;
    common.set_up()?;
    let scene = common.read_scene(&arguments.scene)?;
    let pool = arguments.pool.pool(&scene)?;
    for file in [&arguments.record, &arguments.dump, &arguments.summary].into_iter().flatten() {
        output::file(file)?;
    }
    let no_window = |e: &dyn std::fmt::Display| {
        Failure::failed(format!("no window can be opened: {e}; `lightmend frames` draws without one"))
    };
    let event_loop = EventLoop::<Wake>::with_user_event().build().map_err(|e| no_window(&e))?;
    let error = arguments.error.or(arguments.pool.photons.is_none().then_some(FINE));
    let controls = Controls { error, ..Controls::default() };
    let start = Start { pool, ledger_bytes: arguments.memory, threads: rayon::current_num_threads(), controls };
    let proxy = event_loop.create_proxy();
    let wake = {
        let proxy = proxy.clone();
        // The loop may be over by then: nobody needs to be woken any more.
        move || {
            let _ = proxy.send_event(Wake);
        }
    };
    let mut session = Session::start(scene, arguments.scene.clone(), start, wake)?;
    session.record = arguments.record.clone();
    if let Some(script) = &arguments.script {
        session.play(script)?;
    }
    let desk = Desk::new(session, arguments.show, arguments.fps);
    let mut app = App::new(desk, start, arguments.pool, arguments.size, proxy);
    let ran = event_loop.run_app(&mut app).map_err(|e| no_window(&e));
    // What was done is written, whatever became of the window.
    let finished = finish(arguments, app);
    ran.and(finished)
}

/// What is written at the end.
fn finish(arguments: &Arguments, mut app: App) -> Result<(), Failure> {
    let common = &arguments.common;
    let session = &mut app.desk.session;
    if let Some(record) = &session.record.clone() {
        session.write_recording(record)?;
        if common.talks() {
            say(&format!("what was done: {}", record.display()));
        }
    }
    if let (Some(dump), None) = (&arguments.dump, &app.failure) {
        dump_exact(&app.desk.session, dump, common)?;
    }
    let summary = app.report.json(&app.desk);
    if arguments.summary.is_some() || common.json {
        output::json(arguments.summary.as_deref(), &summary, common.json)?;
    }
    app.failure.map_or(Ok(()), Err)
}

/// Repairs what is left, and writes every bucket.
fn dump_exact(session: &Session, path: &std::path::Path, common: &Common) -> Result<(), Failure> {
    let mut controls = session.solver.controls();
    controls.paused = false;
    session.solver.control(controls);
    let mut bar = None;
    loop {
        let snapshot = session.solver.snapshot();
        if let Some(snapshot) = &snapshot {
            if session.is_exact(snapshot) {
                return output::write(path, |file| snapshot.buckets.dump(&session.configuration, file));
            }
            let bar = bar.get_or_insert_with(|| progress::bar(snapshot.pool_photons, "repairing the light", common.quiet));
            bar.set_position(snapshot.pool_photons - snapshot.outstanding_photons);
        }
        if progress::interrupted() {
            return Err(Failure::failed("interrupted before the light was exact; no buckets were written"));
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
}
