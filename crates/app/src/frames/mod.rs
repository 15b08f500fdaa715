//! `lightmend frames`: scripted moves drawn frame by frame, without a window.
//!
//! Frame *k* shows time *k* / fps: what stands where and its direct light then, and the indirect light after exactly *k* × `--work` rays
//! of repair. An edit is seen in the first frame that is not before it, and repaired from that frame on. Work that finds nothing to
//! repair is not saved up.

mod earlier;
pub mod exr;
mod film;
mod painter;
mod sheet;
mod show;

use crate::{
    Common, PoolArguments,
    failure::Failure,
    output::{self, say},
    picture, progress,
};
use lightmend_photon::{body::TreePreset, importance::Gaze, path::FirstHits, solution::Solution, visible::Frustum, world::World};
use lightmend_raster::{Device, RasterError, Renderer};
use lightmend_scene::{Configuration, Edit, Moves, Scene, SceneError, View, unknown};
use painter::{Moment, Painter};
#[cfg(feature = "window")]
pub use sheet::with_legend;
pub use show::{Range, Show};
use std::{path::PathBuf, sync::Arc};

#[derive(clap::Args)]
pub struct Arguments {
    /// Scene file
    scene: PathBuf,
    /// Moves file, with camera keys if the camera moves; without it one picture is drawn for each of the scene's cameras
    #[arg(long, value_name = "MOVES")]
    script: Option<PathBuf>,
    /// Folder for frame_00000.png and so on, contact.png, summary.json, and film.mp4 if ffmpeg is installed. Frames, sheet and film
    /// that an earlier run left there are removed
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    size: [u32; 2],
    /// Draw every N-th frame only; the light is the same
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true, value_parser = parse_count)]
    every: u64,
    /// Write an EXR beside each PNG: linear radiance, its direct and indirect parts, and a mask for each lamp
    #[arg(long)]
    exr: bool,
    /// Rays traced for repair from one frame to the next. More: light follows sooner
    #[arg(long, value_name = "N", default_value_t = 200_000, allow_negative_numbers = true, value_parser = parse_count)]
    work: u64,
    /// Camera of the scene to look through where the script has no camera keys; the first by default
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// What is drawn: radiance is what a camera sees, all others are false colours
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = Show::Radiance)]
    show: Show,
    /// Values of the first and the last false colour; by default from what the first frame shows
    #[arg(long, value_name = "LOW,HIGH", value_parser = Range::parse, allow_hyphen_values = true)]
    range: Option<Range>,
    /// Exposure value at ISO 100 (EV100); by default the logarithmic mean of each frame becomes middle grey
    #[arg(long, value_name = "EV", allow_negative_numbers = true, value_parser = parse_exposure)]
    exposure: Option<f32>,
    /// Samples along each side of a pixel, 1 to 4. More: smoother edges of objects and shadows, at 4 to 16 times the time
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=4))]
    aa: u32,
    #[command(flatten)]
    pool: PoolArguments,
    #[command(flatten)]
    common: Common,
}

/// "1280x720".
pub fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once(['x', 'X']).map(|(w, h)| (w.parse(), h.parse()));
    match sides {
        Some((Ok(width), Ok(height))) if width > 0 && height > 0 => Ok([width, height]),
        _ => Err("width and height in pixels, both above 0, like 1280x720".into()),
    }
}

/// A number of stops that pictures of anything may need: starlight is near -6, the sun near 35.
fn parse_exposure(text: &str) -> Result<f32, String> {
    let stops = text.parse().ok().filter(|ev| (-50.0..=50.0).contains(ev));
    stops.ok_or_else(|| "a number from -50 to 50".into())
}

/// Rays, or frames; more than this is a slip of the keyboard.
fn parse_count(text: &str) -> Result<u64, String> {
    let count = text.parse().ok().filter(|n| (1..=1_000_000_000_000).contains(n));
    count.ok_or_else(|| "a whole number from 1 to 1,000,000,000,000".into())
}

/// Frames after the last edit and camera key that are drawn at most while the light is not exact yet.
const MOST_FRAMES: u64 = 1000;

impl From<RasterError> for Failure {
    fn from(error: RasterError) -> Failure {
        match error {
            RasterError::Size { .. } => Failure::input(format!("--size: {error}")),
            _ => Failure::failed(error),
        }
    }
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let common = &arguments.common;
    common.set_up()?;
    let scene = common.read_scene(&arguments.scene)?;
    let moves = match &arguments.script {
        Some(path) => {
            let (moves, warnings) = Moves::read(path, &scene)?;
            common.warn(&warnings);
            Some(moves)
        }
        None => None,
    };
    let pool = arguments.pool.pool(&scene)?;
    let chosen = arguments.camera.as_deref().map(|name| camera_called(&scene, name)).transpose()?;
    let looked_through = |at: f64| {
        let key = moves.as_ref().and_then(|m| m.camera(at)).or(chosen);
        key.or_else(|| scene.cameras.first().map(|c| c.1))
    };
    let no_camera = "there is no camera: add one, or give a --script with camera keys";
    let first = looked_through(0.0).ok_or_else(|| SceneError::content(&scene.path, no_camera))?;
    arguments.show.check(arguments.range.is_some(), arguments.exposure.is_some())?;

    // A driver, or a size that it refuses, is told before anything is made and before the photons are shot.
    let mut renderer = Renderer::new(Arc::new(Device::headless()?))?;
    let settings = arguments.show.settings(arguments.size, arguments.aa, arguments.range, arguments.exposure);
    let start = Configuration::initial(&scene);
    renderer.show(&start)?;
    renderer.draw(&first, &settings)?;
    let pictures = match moves {
        Some(_) => vec![frame_file(0)],
        None => picture::file_names(&scene, &[sheet::FILE]),
    };
    let others = ["summary.json", sheet::FILE, film::FILE].map(str::to_owned);
    let out = output::folder(&arguments.out, &[&pictures[..], &others].concat())?;
    if common.talks() {
        say(&format!("drawing on {}", renderer.device().name));
    }
    let mut painter = Painter::new(arguments, settings, &out);
    let world = Arc::new(World::new(&start, TreePreset::default()));
    let bar = progress::bar(pool.photons(), "initial light", common.quiet);
    let solution = Solution::shoot(pool, world, FirstHits::AsLampsSay, &mut |photons, _| {
        bar.set_position(photons);
        !progress::interrupted()
    });
    bar.finish_and_clear();
    let solution = solution.filter(|s| s.pool().photons() == pool.photons());
    let mut solution =
        solution.ok_or_else(|| Failure::failed("interrupted before the initial light was done; no frame was drawn"))?;

    earlier::clear(&out);
    let result = match &moves {
        None => {
            let views = pictures.into_iter().zip(&scene.cameras);
            let asked = views.filter(|(_, (name, _))| arguments.camera.as_ref().is_none_or(|c| c == name));
            painter.paint_cameras(&mut renderer, &solution, asked.map(|(file, (_, view))| (file, *view)))
        }
        Some(moves) => {
            painter.film(moves.fps / arguments.every as f64);
            play(&mut painter, &mut renderer, &mut solution, moves, |at| looked_through(at).unwrap_or(first))
        }
    };
    painter.finish(&scene, &renderer, moves.map(|m| m.fps), solution.pool().photons(), result)
}

fn camera_called(scene: &Scene, name: &str) -> Result<View, Failure> {
    let found = scene.cameras.iter().find(|(known, _)| known == name).map(|(_, view)| *view);
    found.ok_or_else(|| {
        Failure::input(format!("--camera: {}", unknown("camera", name, scene.cameras.iter().map(|(n, _)| n.as_str()))))
    })
}

/// Name of a frame's picture.
fn frame_file(frame: u64) -> String {
    format!("frame_{frame:05}.png")
}

/// The frames of a script, until the last edit and camera key are over and the light is exact.
fn play(
    painter: &mut Painter,
    renderer: &mut Renderer,
    solution: &mut Solution,
    moves: &Moves,
    looked_through: impl Fn(f64) -> View,
) -> Result<(), Failure> {
    let &Arguments { work, every, size: [width, height], common, .. } = painter.arguments;
    let mut configuration = solution.world().configuration().clone();
    let up = configuration.scene().up;
    let steps: Vec<(f64, Edit)> = moves.timeline(&configuration)?;
    let last = steps.last().map_or(0.0, |(at, _)| *at).max(moves.cameras.last().map_or(0.0, |key| key.at));
    let last_frame = (last * moves.fps - 1e-9).ceil().max(0.0) as u64;
    let mut steps = steps.into_iter().peekable();
    // Rays that were traced, and those that found nothing to repair.
    let (mut rays, mut unused) = (0, 0);
    let bar = progress::bar(last_frame.saturating_add(1), "frames", common.quiet);
    for frame in 0..=last_frame.saturating_add(MOST_FRAMES) {
        let time = frame as f64 / moves.fps;
        let view = looked_through(time);
        let due = frame.saturating_mul(work);
        if frame > 0 {
            solution.look(Some(Gaze::Frustum(Frustum::new(&view, up, f64::from(width) / f64::from(height)))));
            // Group by group, so that Ctrl-C need not wait for a long round.
            while rays + unused < due && solution.stale_groups() > 0 && !progress::interrupted() {
                rays += solution.repair_round(1)?.rays;
            }
        }
        if solution.stale_groups() == 0 {
            unused = unused.max(due.saturating_sub(rays));
        }
        if progress::interrupted() {
            break;
        }
        let mut changed = false;
        while let Some((_, edit)) = steps.next_if(|(at, _)| *at <= time + 1e-9) {
            configuration = configuration.apply(&edit)?;
            changed = true;
        }
        if changed {
            solution.change(Arc::new(solution.world().moved_to(&configuration)));
            renderer.show(&configuration)?;
        }
        if frame % every == 0 {
            painter.paint(renderer, solution, &view, Moment { frame, time, rays }, frame_file(frame))?;
        }
        bar.set_position(frame);
        let over = frame >= last_frame && steps.peek().is_none() && solution.stale_groups() == 0;
        // The last frame that is drawn is exact.
        if over && frame % every == 0 {
            break;
        }
    }
    bar.finish_and_clear();
    if solution.stale_groups() > 0 && !progress::interrupted() && !common.quiet {
        eprintln!("warning: {MOST_FRAMES} frames after the end of the script the light is not exact yet; give it more --work");
    }
    Ok(())
}
