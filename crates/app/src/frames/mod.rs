//! `lightmend frames`: scripted moves drawn frame by frame, without a window.
//!
//! Frame *k* shows time *k* / fps: what stands where and its direct light then, and the indirect light after exactly *k* × `--work` rays
//! of repair. An edit is seen in the first frame that is not before it, and repaired from that frame on. Work that finds nothing to
//! repair is not saved up.

mod exr;
mod film;
mod light;
mod sheet;
mod show;

use crate::{
    Common, PoolArguments,
    failure::Failure,
    output::{self, say},
    picture, progress,
};
use light::IndirectLight;
use lightmend_photon::{
    body::TreePreset, irradiance::Scale, path::FirstHits, solution::Solution, visible::Frustum, world::World,
};
use lightmend_raster::{Device, RasterError, Renderer, Settings, Times};
use lightmend_scene::{Configuration, Edit, Moves, Scene, SceneError, View, unknown};
use serde_json::{Value, json};
use show::{Range, Show};
use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Instant,
};

#[derive(clap::Args)]
pub struct Arguments {
    /// Scene file
    scene: PathBuf,
    /// Moves file, with camera keys if the camera moves; without it one picture is drawn for each of the scene's cameras
    #[arg(long, value_name = "MOVES")]
    script: Option<PathBuf>,
    /// Folder for frame_00000.png and so on, contact.png, summary.json, and film.mp4 if ffmpeg is installed
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    size: [u32; 2],
    /// Draw every N-th frame only; the light is the same
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    every: u64,
    /// Write an EXR beside each PNG: linear radiance, its direct and indirect parts, and a mask for each lamp
    #[arg(long)]
    exr: bool,
    /// Rays traced for repair from one frame to the next. More: light follows sooner
    #[arg(long, value_name = "N", default_value_t = 200_000, value_parser = clap::value_parser!(u64).range(1..))]
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
    #[arg(long, value_name = "EV", allow_negative_numbers = true)]
    exposure: Option<f32>,
    /// Samples along each side of a pixel, 1 to 4. More: smoother edges of objects and shadows, at 4 to 16 times the time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=4))]
    aa: u32,
    #[command(flatten)]
    pool: PoolArguments,
    #[command(flatten)]
    common: Common,
}

/// "1280x720".
fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once(['x', 'X']).map(|(w, h)| (w.parse(), h.parse()));
    match sides {
        Some((Ok(width), Ok(height))) if width > 0 && height > 0 => Ok([width, height]),
        _ => Err("width and height in pixels, both above 0, like 1280x720".into()),
    }
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

/// What was drawn.
struct Drawn {
    frame: u64,
    time: f64,
    file: String,
    stale_groups: usize,
    rays: u64,
    exposure: Option<f32>,
    /// Of its passes, and of the whole frame without reading and writing the picture; milliseconds.
    times: (Times, f64),
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
    if moves.is_none() && scene.cameras.is_empty() {
        return Err(SceneError::content(&scene.path, "there is no camera: add one, or give a --script with camera keys").into());
    }
    let out = output::folder(&arguments.out, &["summary.json".to_owned(), sheet::FILE.to_owned(), film::FILE.to_owned()])?;
    let mut renderer = Renderer::new(Arc::new(Device::headless()?))?;
    if common.talks() {
        say(&format!("drawing on {}", renderer.device().name));
    }

    let start = Configuration::initial(&scene);
    let mut painter = Painter {
        settings: arguments.show.settings(arguments.size, arguments.aa, arguments.range, arguments.exposure),
        arguments,
        out: &out,
        light: IndirectLight::default(),
        drained: None,
        warned_inside: false,
        sheet: sheet::ContactSheet::default(),
        film: None,
        drawn: Vec::new(),
    };
    // A size that the driver refuses is told before the photons are shot.
    renderer.show(&start)?;
    let looked_through = |at: f64| {
        let key = moves.as_ref().and_then(|m| m.camera(at)).or(chosen);
        key.or_else(|| scene.cameras.first().map(|c| c.1))
    };
    let first =
        looked_through(0.0).ok_or_else(|| SceneError::content(&scene.path, "there is no camera: add one to scene or script"))?;
    renderer.draw(&first, &painter.settings)?;

    let mut world = Arc::new(World::new(&start, TreePreset::default()));
    let bar = progress::bar(pool.photons(), "initial light", common.quiet);
    let solution = Solution::shoot(pool, world.clone(), FirstHits::AsLampsSay, &mut |photons, _| {
        bar.set_position(photons);
        !progress::interrupted()
    });
    bar.finish_and_clear();
    let solution = solution.filter(|s| s.pool().photons() == pool.photons());
    let mut solution =
        solution.ok_or_else(|| Failure::failed("interrupted before the initial light was done; no frame was drawn"))?;

    let Some(moves) = &moves else {
        let names = picture::file_names(&scene);
        let views = names.iter().zip(&scene.cameras).filter(|(_, (name, _))| arguments.camera.as_ref().is_none_or(|c| c == name));
        for (number, (file, (_, view))) in (0..).zip(views) {
            painter.paint(&mut renderer, &solution, view, Moment { frame: number, time: 0.0, rays: 0 }, file.clone())?;
            if progress::interrupted() {
                break;
            }
        }
        return painter.finish(&scene, &renderer, None, solution.pool().photons());
    };

    let steps = timeline(moves, &start)?;
    let last = steps.last().map_or(0.0, |(at, _)| *at).max(moves.cameras.last().map_or(0.0, |key| key.at));
    let last_frame = (last * moves.fps - 1e-9).ceil().max(0.0) as u64;
    painter.film = film::Film::start(&out, moves.fps / arguments.every as f64, arguments.size);
    let mut steps = steps.into_iter().peekable();
    let mut configuration = start;
    let mut rays = 0;
    let bar = progress::bar(last_frame + 1, "frames", common.quiet);
    for frame in 0..=last_frame + MOST_FRAMES {
        let time = frame as f64 / moves.fps;
        let view = looked_through(time).unwrap_or(first);
        let due = frame * arguments.work;
        if frame > 0 {
            solution.look(Some(Frustum::new(&view, scene.up, f64::from(arguments.size[0]) / f64::from(arguments.size[1]))));
            rays += solution.repair_round(due.saturating_sub(rays)).rays;
        }
        if solution.stale_groups() == 0 {
            rays = rays.max(due);
        }
        let mut changed = false;
        while let Some((_, edit)) = steps.next_if(|(at, _)| *at <= time + 1e-9) {
            configuration = configuration.apply(&edit)?;
            changed = true;
        }
        if changed {
            world = Arc::new(world.moved_to(&configuration));
            solution.change(world.clone());
            renderer.show(&configuration)?;
        }
        if frame % arguments.every == 0 {
            let moment = Moment { frame, time, rays };
            painter.paint(&mut renderer, &solution, &view, moment, format!("frame_{frame:05}.png"))?;
        }
        bar.set_position(frame);
        let over = frame >= last_frame && steps.peek().is_none() && solution.stale_groups() == 0;
        // The last frame that is drawn is exact.
        if (over && frame % arguments.every == 0) || progress::interrupted() {
            break;
        }
    }
    bar.finish_and_clear();
    painter.finish(&scene, &renderer, Some(moves.fps), solution.pool().photons())
}

fn camera_called(scene: &Scene, name: &str) -> Result<View, Failure> {
    let found = scene.cameras.iter().find(|(known, _)| known == name).map(|(_, view)| *view);
    found.ok_or_else(|| {
        Failure::input(format!("--camera: {}", unknown("camera", name, scene.cameras.iter().map(|(n, _)| n.as_str()))))
    })
}

/// All edits with their times, drags step by step, in order.
fn timeline(moves: &Moves, start: &Configuration) -> Result<Vec<(f64, Edit)>, Failure> {
    let mut configuration = start.clone();
    let mut steps = Vec::new();
    for timed in &moves.edits {
        let parts = timed.edit.steps(&configuration)?;
        steps.extend(parts.into_iter().map(|(after, edit)| (timed.at + after, edit)));
        configuration = configuration.apply(&timed.edit)?;
    }
    steps.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(steps)
}

/// When a frame is.
#[derive(Clone, Copy)]
struct Moment {
    frame: u64,
    /// Seconds.
    time: f64,
    /// Of repair, so far.
    rays: u64,
}

/// Draws frames and keeps account of them.
struct Painter<'a> {
    arguments: &'a Arguments,
    settings: Settings,
    out: &'a Path,
    light: IndirectLight,
    /// What the light will be, for `--show stale`.
    drained: Option<Solution>,
    warned_inside: bool,
    sheet: sheet::ContactSheet,
    film: Option<film::Film>,
    drawn: Vec<Drawn>,
}

impl Painter<'_> {
    fn paint(
        &mut self,
        renderer: &mut Renderer,
        solution: &Solution,
        view: &View,
        moment: Moment,
        file: String,
    ) -> Result<(), Failure> {
        let kept = |number: usize, out: &Path| format!("{number} finished frames are kept in {}", out.display());
        let result = self.draw(renderer, solution, view, moment, file);
        result.map_err(|failure| match self.drawn.len() {
            0 => failure,
            number => failure.with(&kept(number, self.out)),
        })
    }

    fn draw(
        &mut self,
        renderer: &mut Renderer,
        solution: &Solution,
        view: &View,
        moment: Moment,
        file: String,
    ) -> Result<(), Failure> {
        let common = &self.arguments.common;
        let configuration = solution.world().configuration();
        let start = Instant::now();
        let scale = Scale::new(solution.world(), solution.pool().photons());
        let indirect = match self.arguments.show {
            Show::Elements => Vec::new(),
            Show::Stale => {
                self.drain(solution);
                let right = self.drained.as_ref().map_or(solution.buckets(), |drained| drained.buckets());
                self.light.outstanding(configuration, solution.buckets(), right, &scale)
            }
            _ => self.light.read(configuration, solution.buckets(), &scale),
        };
        renderer.light(&indirect)?;
        renderer.draw(view, &self.settings)?;
        let times = renderer.finish()?;
        let took = start.elapsed().as_secs_f64() * 1000.0;
        if let Some(settings) =
            self.arguments
                .show
                .ranged(&self.settings, self.drawn.is_empty() && self.arguments.range.is_none(), || renderer.samples())?
        {
            self.settings = settings;
            renderer.draw(view, &self.settings)?;
        }
        if !self.warned_inside
            && let Some(object) = renderer.inside(view)
        {
            self.warned_inside = true;
            if !common.quiet {
                eprintln!(
                    "warning: at {:.2} s the camera is inside of '{object}': it sees its inside, which no light reaches",
                    moment.time
                );
            }
        }
        for warning in renderer.warnings() {
            if !common.quiet {
                eprintln!("warning: {warning}");
            }
        }
        let pixels = renderer.picture()?.into_flattened();
        let [width, height] = self.arguments.size;
        let picture =
            image::RgbImage::from_raw(width, height, pixels).ok_or_else(|| Failure::failed("the picture has no pixels"))?;
        let picture = sheet::with_legend(picture, self.arguments.show, &self.settings)?;
        output::png(&self.out.join(&file), &picture)?;
        if self.arguments.exr {
            let path = self.out.join(&file).with_extension("exr");
            exr::write(&path, renderer, view, &self.settings, configuration)?;
        }
        self.sheet.add(&picture, format!("{:.2} s", moment.time));
        if let Some(film) = &mut self.film {
            film.add(&picture);
        }
        let photograph = self.arguments.show == Show::Radiance && self.arguments.exposure.is_none();
        let exposure = if photograph { Some(renderer.exposure()?) } else { None };
        let Moment { frame, time, rays } = moment;
        self.drawn.push(Drawn { frame, time, file, stale_groups: solution.stale_groups(), rays, exposure, times: (times, took) });
        Ok(())
    }

    /// Brings a copy of the solution to its end, unless that was done already for this configuration.
    fn drain(&mut self, solution: &Solution) {
        let known = self.drained.as_ref().is_some_and(|d| Arc::ptr_eq(d.world(), solution.world()));
        if !known {
            let mut drained = solution.clone();
            while drained.repair_next().is_some() {}
            self.drained = Some(drained);
        }
    }

    fn finish(mut self, scene: &Scene, renderer: &Renderer, fps: Option<f64>, photons: u64) -> Result<(), Failure> {
        let common = &self.arguments.common;
        let film = self.film.take().map(|film| film.finish(self.out)).transpose()?.flatten();
        let contact = self.sheet.write(self.out)?;
        let [width, height] = self.arguments.size;
        let summary = json!({
            "scene": scene.name, "driver": renderer.device().name, "width": width, "height": height, "samples": self.arguments.aa * self.arguments.aa,
            "photons": photons, "work": self.arguments.work, "fps": fps, "threads": rayon::current_num_threads(),
            "triangles": scene.triangles(), "cells": scene.cells(), "interrupted": progress::interrupted(),
            "contact_sheet": contact, "film": film, "milliseconds": milliseconds(&self.drawn),
            "frames": self.drawn.iter().map(frame_json).collect::<Vec<_>>(),
        });
        output::json(Some(&self.out.join("summary.json")), &summary, common.json)?;
        if common.talks() {
            let more = match (&film, fps) {
                (Some(film), _) => format!(", {}", self.out.join(film).display()),
                (None, Some(_)) => " (no film: ffmpeg is not installed)".to_owned(),
                (None, None) => String::new(),
            };
            say(&format!("{} frames: {}{more}", self.drawn.len(), self.out.join("*.png").display()));
        }
        if progress::interrupted() {
            return Err(Failure::failed(format!(
                "interrupted; {} finished frames are kept in {}",
                self.drawn.len(),
                self.out.display()
            )));
        }
        Ok(())
    }
}

fn frame_json(drawn: &Drawn) -> Value {
    json!({
        "frame": drawn.frame, "time": drawn.time, "file": drawn.file, "stale_groups": drawn.stale_groups, "exact": drawn.stale_groups == 0,
        "rays": drawn.rays, "exposure": drawn.exposure,
    })
}

/// Medians over the frames; the whole includes reading the buckets and drawing, but not reading back and writing the picture.
fn milliseconds(drawn: &[Drawn]) -> Value {
    let median = |of: &dyn Fn(&Drawn) -> f64| {
        let mut values: Vec<f64> = drawn.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied()
    };
    json!({
        "preparation": median(&|d| d.times.0.preparation), "prepass": median(&|d| d.times.0.prepass),
        "shadows": median(&|d| d.times.0.shadows), "composition": median(&|d| d.times.0.composition),
        "exposure": median(&|d| d.times.0.exposure), "tone": median(&|d| d.times.0.tone), "frame": median(&|d| d.times.1),
    })
}
