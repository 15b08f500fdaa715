//! Draws frames, writes what belongs to each, and keeps account of them.

use super::{Arguments, exr, film, sheet, show::Show};
use crate::{
    failure::Failure,
    indirect::IndirectLight,
    output::{self, say},
    progress,
};
use lightmend_photon::{irradiance::Scale, solution::Solution};
use lightmend_raster::{Renderer, Settings, Times};
use lightmend_scene::{Scene, View};
use serde_json::{Value, json};
use std::{path::Path, sync::Arc, time::Instant};

/// When a frame is.
#[derive(Clone, Copy)]
pub struct Moment {
    pub frame: u64,
    /// Seconds.
    pub time: f64,
    /// Of repair, so far.
    pub rays: u64,
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

/// Draws frames and keeps account of them.
pub struct Painter<'a> {
    pub arguments: &'a Arguments,
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

impl<'a> Painter<'a> {
    /// Nothing is drawn yet.
    pub fn new(arguments: &'a Arguments, settings: Settings, out: &'a Path) -> Painter<'a> {
        Painter {
            arguments,
            settings,
            out,
            light: IndirectLight::default(),
            drained: None,
            warned_inside: false,
            sheet: sheet::ContactSheet::default(),
            film: None,
            drawn: Vec::new(),
        }
    }

    /// From now on frames go into a film too, if ffmpeg is installed.
    pub fn film(&mut self, fps: f64) {
        self.film = film::Film::start(self.out, fps);
    }

    /// A picture for each camera.
    pub fn paint_cameras(
        &mut self,
        renderer: &mut Renderer,
        solution: &Solution,
        views: impl Iterator<Item = (String, View)>,
    ) -> Result<(), Failure> {
        for (number, (file, view)) in (0..).zip(views) {
            self.paint(renderer, solution, &view, Moment { frame: number, time: 0.0, rays: 0 }, file)?;
            if progress::interrupted() {
                break;
            }
        }
        Ok(())
    }

    /// A frame and its files.
    pub fn paint(
        &mut self,
        renderer: &mut Renderer,
        solution: &Solution,
        view: &View,
        moment: Moment,
        file: String,
    ) -> Result<(), Failure> {
        let result = self.draw(renderer, solution, view, moment, file);
        result.map_err(|failure| match self.drawn.len() {
            0 => failure,
            _ => failure.with(&self.kept()),
        })
    }

    /// "3 finished frames are kept in out".
    fn kept(&self) -> String {
        let finished = match self.drawn.len() {
            1 => "1 finished frame is".to_owned(),
            number => format!("{number} finished frames are"),
        };
        format!("{finished} kept in {}", self.out.display())
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
        // A frame is known by its time, a camera's picture by its name.
        let is_frame = file == super::frame_file(moment.frame);
        let label = if is_frame { format!("{:.2} s", moment.time) } else { file.trim_end_matches(".png").to_owned() };
        let start = Instant::now();
        let scale = Scale::new(solution.world(), solution.pool().photons());
        let indirect = match self.arguments.show {
            Show::Elements => Vec::new(),
            Show::Stale => {
                self.drain(solution)?;
                let right = self.drained.as_ref().map_or(solution.buckets(), |drained| drained.buckets());
                self.light.outstanding(configuration, (solution.buckets(), &scale), (right, &scale), configuration.lamp_slots())
            }
            _ => self.light.read(configuration, solution.buckets(), &scale, configuration.lamp_slots()),
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
                let when = if is_frame { format!("at {label}") } else { format!("in {file}") };
                eprintln!("warning: {when} the camera is inside of '{object}': it sees its inside, which no light reaches");
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
        self.sheet.add(&picture, label);
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
    fn drain(&mut self, solution: &Solution) -> Result<(), Failure> {
        let known = self.drained.as_ref().is_some_and(|d| Arc::ptr_eq(d.world(), solution.world()));
        if !known {
            let mut drained = solution.clone();
            while drained.repair_next()?.is_some() {}
            self.drained = Some(drained);
        }
        Ok(())
    }

    /// Ends the film and writes the contact sheet and the summary of what was drawn, even if that was not all.
    pub fn finish(
        mut self,
        scene: &Scene,
        renderer: &Renderer,
        fps: Option<f64>,
        photons: u64,
        result: Result<(), Failure>,
    ) -> Result<(), Failure> {
        let film = self.film.take();
        let ffmpeg = film.is_some();
        let film = film.map(|film| film.finish(self.out, self.arguments.common.quiet)).transpose().map(Option::flatten);
        // Without any frame there is nothing to account for.
        let failed = result.as_ref().err().map(Failure::to_string);
        let accounts = match (&failed, self.drawn.len()) {
            (Some(_), 0) => Ok(None),
            _ => film.and_then(|film| self.account(scene, renderer, fps, photons, film, failed).map(|()| film)),
        };
        let film = result.and(accounts)?;
        if self.arguments.common.talks() {
            let more = match (film, fps) {
                (Some(film), _) => format!(", {}", self.out.join(film).display()),
                (None, Some(_)) if !ffmpeg => " (no film: ffmpeg is not installed)".to_owned(),
                (None, _) => String::new(),
            };
            let number = self.drawn.len();
            let plural = if number == 1 { "" } else { "s" };
            say(&format!("{number} frame{plural}: {}{more}", self.out.join("*.png").display()));
        }
        if progress::interrupted() {
            return Err(Failure::failed(format!("interrupted; {}", self.kept())));
        }
        Ok(())
    }

    /// Writes the contact sheet and the summary.
    fn account(
        &self,
        scene: &Scene,
        renderer: &Renderer,
        fps: Option<f64>,
        photons: u64,
        film: Option<&str>,
        failed: Option<String>,
    ) -> Result<(), Failure> {
        let contact = self.sheet.write(self.out)?;
        let [width, height] = self.arguments.size;
        let summary = json!({
            "scene": scene.name, "driver": renderer.device().name, "width": width, "height": height, "samples": self.arguments.aa * self.arguments.aa,
            "photons": photons, "work": self.arguments.work, "fps": fps, "threads": rayon::current_num_threads(),
            "triangles": scene.triangles(), "cells": scene.cells(), "interrupted": progress::interrupted(), "failed": failed,
            "contact_sheet": contact, "film": film, "milliseconds": milliseconds(&self.drawn),
            "frames": self.drawn.iter().map(frame_json).collect::<Vec<_>>(),
        });
        output::json(Some(&self.out.join("summary.json")), &summary, self.arguments.common.json)
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
