//! What cameras see of a recovery: visible error, FLIP and pixels in which the error could be noticed, against work, for every way to tell what matters.
//!
//! An error could be noticed in a pixel if its luminance is off by more than the step that is just seen on a plain surface
//! (Ward Larson et al. 1997) times the threshold elevation of the texture there. The eye is taken to be adapted to the indirect light of
//! the pixel alone: direct light, which is not in the buckets, would only hide more. The light is complete for the eye when that is
//! so in no more than [`TOLERATED`] of the pixels, and stays so.

use super::{Chapter, OrderArgument};
use crate::{failure::Failure, masking::Maskings, output::say, progress};
use lightmend_perception::{compare, threshold_step};
use lightmend_photon::{
    bucket::Buckets,
    course::Course,
    importance::Gaze,
    irradiance::Scale,
    ledger::LedgerSolution,
    solution::Solution,
    visible::{Frustum, Visible},
};
use lightmend_scene::{View, luminance};
use serde_json::{Value, json};
use std::{
    io::Write,
    sync::Arc,
    time::{Duration, Instant},
};

/// Share of the picture's pixels in which an error may be noticed that counts as none.
const TOLERATED: f64 = 1e-3;

/// From one look to the next so much more work is done.
const SPACING: f64 = 1.1;

/// What a camera saw of an order that went by a way to tell what matters.
pub struct Sight {
    camera: String,
    order: &'static str,
    gaze: &'static str,
    moments: Vec<Moment>,
}

/// A look at a recovery.
struct Moment {
    rays: u64,
    seconds: f64,
    /// Visible error ÷ that at the edit.
    visible: f64,
    /// Mean FLIP of pictures of the indirect light.
    flip: f64,
    /// Share of the pixels in which the error could be noticed.
    noticed: f64,
}

impl Sight {
    /// Mean over the work until exact.
    fn area(&self, of: fn(&Moment) -> f64) -> f64 {
        let whole = self.moments.last().map_or(0, |m| m.rays).max(1) as f64;
        self.moments.windows(2).map(|m| (m[1].rays - m[0].rays) as f64 * (of(&m[0]) + of(&m[1])) / 2.0).sum::<f64>() / whole
    }

    /// From when on the light is complete for the eye.
    fn complete(&self) -> Option<&Moment> {
        let last = self.moments.iter().rposition(|m| m.noticed > TOLERATED);
        self.moments.get(last.map_or(0, |last| last + 1))
    }
}

/// What a camera sees of the drained light.
struct Eye<'a> {
    visible: &'a Visible,
    scale: &'a Scale,
    right: Vec<[f32; 3]>,
    luminances: Vec<f64>,
    /// Steps of luminance that can be noticed, by what is seen.
    thresholds: Vec<f64>,
    exposure: f32,
    picture: image::RgbImage,
}

impl<'a> Eye<'a> {
    fn new(visible: &'a Visible, scale: &'a Scale, drained: &Buckets, elevations: &[f64]) -> Eye<'a> {
        let right = visible.values(drained, scale);
        let mut eye = Eye {
            visible,
            scale,
            luminances: luminances(visible, &right),
            thresholds: Vec::new(),
            exposure: 1.0,
            picture: image::RgbImage::default(),
            right,
        };
        eye.thresholds = eye.luminances.iter().zip(elevations).map(|(l, elevation)| threshold_step(*l) * elevation).collect();
        // A tenth of the picture is brighter than white.
        let mut sorted = eye.luminances.clone();
        sorted.sort_by(f64::total_cmp);
        let high = sorted.get(sorted.len() * 9 / 10).copied().unwrap_or(1.0);
        eye.exposure = (1.0 / high.max(1e-9)) as f32;
        eye.picture = eye.draw(&eye.right);
        eye
    }

    fn draw(&self, values: &[[f32; 3]]) -> image::RgbImage {
        let radiance = self.visible.radiance(values);
        let (width, height, pixels) = self.visible.picture();
        let byte = |v: f32| ((v * self.exposure).clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0).round() as u8;
        let bytes: Vec<u8> = pixels.flat_map(|seen| seen.map_or([0; 3], |seen| radiance[seen].to_array().map(byte))).collect();
        image::RgbImage::from_raw(width, height, bytes).unwrap_or_default()
    }

    /// Visible error, FLIP and the share of pixels in which the error could be noticed.
    fn look(&self, light: &Buckets) -> Result<(f64, f64, f64), Failure> {
        let values = self.visible.values(light, self.scale);
        let flip = compare(&self.picture, &self.draw(&values)).map_err(Failure::failed)?.mean;
        let now = luminances(self.visible, &values);
        let noticed = |seen: usize| (now[seen] - self.luminances[seen]).abs() > self.thresholds[seen];
        let (width, height, pixels) = self.visible.picture();
        let count = pixels.flatten().filter(|seen| noticed(*seen)).count();
        Ok((self.visible.difference(&values, &self.right), flip, count as f64 / f64::from(width * height)))
    }
}

fn luminances(visible: &Visible, values: &[[f32; 3]]) -> Vec<f64> {
    visible.radiance(values).iter().map(|radiance| luminance(radiance.as_dvec3())).collect()
}

/// Follows the recovery from `start` to the light of `end`, once for each camera, order and way to tell what matters. Empty if interrupted.
pub fn follow(
    maskings: &mut Maskings,
    start: &Solution,
    ledger: Option<&LedgerSolution>,
    end: &Solution,
    orders: &[OrderArgument],
    quiet: bool,
) -> Result<Vec<Sight>, Failure> {
    let world = start.world().moved_to(end.world().configuration());
    let world = Arc::new(world);
    let configuration = world.configuration();
    let scale = Scale::new(&world, end.pool().photons());
    let mut sights = Vec::new();
    for (camera, view) in &configuration.scene().cameras {
        let visible = Visible::new(&world, view);
        let mut elevation = |object: usize, t, footprint| maskings.elevation(configuration.object(object), t, footprint);
        let elevations: Vec<f64> = visible.seen().map(|s| elevation(s.object, s.triangle, s.footprint)).collect();
        let eye = Eye::new(&visible, &scale, end.buckets(), &elevations);
        let sides = Gaze::Sides(visible.importance(&world, |_| 1.0).into());
        let masked_sides = Gaze::Sides(visible.importance(&world, |s| elevation(s.object, s.triangle, s.footprint)).into());
        let gazes = gazes(maskings, configuration, view, sides, masked_sides);
        for order in orders {
            for (name, gaze) in &gazes {
                let course = match order {
                    // Hits in the frustum were worse for a ledger than no order.
                    OrderArgument::Ledger if name.starts_with('V') => None,
                    OrderArgument::Ledger => ledger.map(Course::ledger),
                    OrderArgument::Stateless => Some(Course::stateless(start)),
                    OrderArgument::Random | OrderArgument::Oracle | OrderArgument::Restart => None,
                };
                let Some(mut course) = course else { continue };
                let order = if matches!(order, OrderArgument::Ledger) { "ledger" } else { "stateless" };
                let bar = progress::bar(1000, &format!("{camera}, {order}, {name}"), quiet);
                let moments = watch(&mut course, gaze.as_ref(), &world, &eye, &bar)?;
                bar.finish_and_clear();
                if progress::interrupted() {
                    return Ok(Vec::new());
                }
                sights.push(Sight { camera: camera.clone(), order, gaze: name, moments });
            }
        }
    }
    Ok(sights)
}

/// The ways to tell what matters.
fn gazes(
    maskings: &mut Maskings,
    configuration: &lightmend_scene::Configuration,
    view: &View,
    sides: Gaze,
    masked_sides: Gaze,
) -> Vec<(&'static str, Option<Gaze>)> {
    let frustum = Frustum::new(view, configuration.scene().up, 4.0 / 3.0);
    let unmasked = Arc::new(maskings.unmasked(configuration, view));
    vec![
        ("P", None),
        ("V", Some(Gaze::Frustum(frustum))),
        ("V 1/Te", Some(Gaze::Masked(frustum, unmasked))),
        ("items", Some(sides)),
        ("items 1/Te", Some(masked_sides)),
    ]
}

fn watch(
    course: &mut Course,
    gaze: Option<&Gaze>,
    world: &Arc<lightmend_photon::world::World>,
    eye: &Eye,
    bar: &indicatif::ProgressBar,
) -> Result<Vec<Moment>, Failure> {
    let refused = |e| Failure::failed(format!("the ledger has no room for it: {e}"));
    let start = Instant::now();
    course.change(world.clone()).map_err(refused)?;
    if let Some(gaze) = gaze {
        course.look(gaze);
    }
    let mut clock: Duration = start.elapsed();
    let (first, flip, noticed) = eye.look(course.light())?;
    let share = |visible: f64| if first > 0.0 { visible / first } else { 0.0 };
    let mut moments = vec![Moment { rays: 0, seconds: 0.0, visible: share(first), flip, noticed }];
    let (mut rays, mut next) = (0, 1.0);
    loop {
        let start = Instant::now();
        let step = course.step().map_err(refused)?;
        clock += start.elapsed();
        let done = step.is_none();
        rays += step.map_or(0, |step| step.work.rays);
        if done || rays as f64 >= next {
            let (visible, flip, noticed) = eye.look(course.light())?;
            moments.push(Moment { rays, seconds: clock.as_secs_f64(), visible: share(visible), flip, noticed });
            next = rays as f64 * SPACING;
            bar.set_position((course.share() * 1000.0) as u64);
        }
        if done || progress::interrupted() {
            return Ok(moments);
        }
    }
}

/// A line for each camera, order and way to tell what matters.
pub fn print(sights: &[Sight]) {
    if sights.is_empty() {
        return;
    }
    say(&format!(
        "{:<16} {:<10} {:<11} {:>8} {:>8} {:>9}  {:>18}  {:>16}",
        "camera", "order", "by", "visible", "FLIP", "noticed", "eye / exact, rays", "seconds"
    ));
    for sight in sights {
        let (eye, exact) = (sight.complete(), sight.moments.last());
        let rays = |m: Option<&Moment>| m.map_or(0, |m| m.rays);
        let seconds = |m: Option<&Moment>| m.map_or(0.0, |m| m.seconds);
        say(&format!(
            "{:<16} {:<10} {:<11} {:>8.4} {:>8.5} {:>8.3}%  {:>8} /{:>8}  {:>7.3} /{:>7.3}",
            sight.camera,
            sight.order,
            sight.gaze,
            sight.area(|m| m.visible),
            sight.area(|m| m.flip),
            sight.area(|m| m.noticed) * 100.0,
            rays(eye),
            rays(exact),
            seconds(eye),
            seconds(exact)
        ));
    }
}

/// Areas under the curves, and when the light was complete for the eye and exact.
pub fn json(sights: &[Sight]) -> Value {
    let moment = |m: &Moment| json!({ "rays": m.rays, "seconds": m.seconds });
    sights
        .iter()
        .map(|sight| {
            json!({
                "camera": sight.camera, "order": sight.order, "by": sight.gaze,
                "area_visible_error": sight.area(|m| m.visible), "area_flip": sight.area(|m| m.flip),
                "area_noticed": sight.area(|m| m.noticed),
                "complete_for_the_eye": sight.complete().map(moment), "exact": sight.moments.last().map(moment),
            })
        })
        .collect()
}

/// views.csv: a line per look.
pub fn write_csv(out: &mut impl Write, chapters: &[Chapter]) -> std::io::Result<()> {
    writeln!(out, "edit,camera,order,by,rays,seconds,visible_error,flip,noticed")?;
    for (number, chapter) in chapters.iter().enumerate() {
        for Sight { camera, order, gaze, moments } in &chapter.views {
            for Moment { rays, seconds, visible, flip, noticed } in moments {
                writeln!(out, "{number},{camera},{order},{gaze},{rays},{seconds:.6},{visible:.6},{flip:.6},{noticed:.6}")?;
            }
        }
    }
    Ok(())
}
