//! What cameras see of a recovery: visible error, FLIP and pixels in which the error could be noticed, against work, for every way to tell what matters.
//!
//! Visible error and FLIP are of the raw buckets; what could be noticed is of the light as frames show it ([`crate::onlooker`]), held against the drained
//! light, and beside it what was foreseen without that. The light is complete for the eye when it is so and stays so.

use super::{Chapter, OrderArgument};
use crate::{
    failure::Failure,
    figure::{Axes, Curve, Panel},
    indirect::IndirectLight,
    masking::Maskings,
    onlooker::{Onlooker, TOLERATED, TOLERATED_FORESEEN},
    output::say,
    progress,
};
use lightmend_perception::compare;
use lightmend_photon::{
    bucket::Buckets, course::Course, importance::Gaze, irradiance::Scale, ledger::LedgerSolution, solution::Solution,
    visible::Frustum, world::World,
};
use serde_json::{Value, json};
use std::{
    io::Write,
    sync::Arc,
    time::{Duration, Instant},
};

/// From one look to the next so much more work is done.
const SPACING: f64 = 1.1;

/// But no more than this share of all work.
const CLOSEST: f64 = 0.02;

/// A way to tell what matters to a camera.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Way {
    /// Nothing: by P alone, or shuffled.
    P,
    /// Hits in the frustum.
    V,
    /// The same ÷ T_e.
    VMasked,
    /// The item buffer.
    Items,
}

impl Way {
    fn name(self) -> &'static str {
        match self {
            Way::P => "P",
            Way::V => "V",
            Way::VMasked => "V 1/Te",
            Way::Items => "items",
        }
    }
}

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
    /// The same as foreseen without the drained light, where the order can.
    foreseen: Option<f64>,
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

    /// When that was foreseen, at this look and the one before, if it was before the light was exact.
    fn foreseen(&self) -> Option<&Moment> {
        let foresees = |m: &Moment| m.foreseen.is_some_and(|share| share <= TOLERATED_FORESEEN);
        let exact = self.moments.last()?.rays;
        self.moments.windows(2).find(|m| m.iter().all(foresees) && m[1].rays < exact).map(|m| &m[1])
    }
}

/// What a camera sees of the drained light.
struct Eye<'a> {
    onlooker: &'a Onlooker,
    world: &'a World,
    scale: &'a Scale,
    right: Vec<[f32; 3]>,
    /// As it is shown.
    luminances: Vec<f64>,
    exposure: f32,
    picture: image::RgbImage,
}

impl<'a> Eye<'a> {
    fn new(onlooker: &'a Onlooker, world: &'a World, scale: &'a Scale, drained: &Buckets, reader: &mut IndirectLight) -> Eye<'a> {
        let right = onlooker.visible().values(drained, scale);
        // A tenth of the picture is brighter than white.
        let mut sorted = onlooker.luminances(&right);
        sorted.sort_by(f64::total_cmp);
        let high = sorted.get(sorted.len() * 9 / 10).copied().unwrap_or(1.0);
        let exposure = (1.0 / high.max(1e-9)) as f32;
        let luminances = onlooker.shown(reader, world.configuration(), drained, scale);
        let mut eye = Eye { onlooker, world, scale, right, luminances, exposure, picture: image::RgbImage::default() };
        eye.picture = eye.draw(&eye.right);
        eye
    }

    fn draw(&self, values: &[[f32; 3]]) -> image::RgbImage {
        let radiance = self.onlooker.visible().radiance(values);
        let (width, height, pixels) = self.onlooker.visible().picture();
        let byte = |v: f32| ((v * self.exposure).clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0).round() as u8;
        let bytes: Vec<u8> = pixels.flat_map(|seen| seen.map_or([0; 3], |seen| radiance[seen].to_array().map(byte))).collect();
        image::RgbImage::from_raw(width, height, bytes).unwrap_or_default()
    }

    /// After so many rays and seconds; the visible error is not divided by the first one yet.
    fn look(&self, course: &Course, reader: &mut IndirectLight, rays: u64, clock: Duration) -> Result<Moment, Failure> {
        let (light, configuration) = (course.light(), self.world.configuration());
        let visible = self.onlooker.visible();
        let values = visible.values(light, self.scale);
        let flip = compare(&self.picture, &self.draw(&values)).map_err(Failure::failed)?.mean;
        let now = self.onlooker.shown(reader, configuration, light, self.scale);
        let pending = course.pending();
        let foreseen =
            pending.and_then(|pending| self.onlooker.foreseen(reader, configuration, (light, &now, &pending), self.scale));
        Ok(Moment {
            rays,
            seconds: clock.as_secs_f64(),
            visible: visible.difference(&values, &self.right),
            flip,
            noticed: self.onlooker.noticed(&now, &self.luminances),
            foreseen,
        })
    }
}

/// Follows the recovery from `start` to the light of `end`, once for each camera, order and way to tell what matters. Empty if interrupted.
pub fn follow(
    maskings: &mut Maskings,
    start: &Solution,
    ledger: Option<&LedgerSolution>,
    end: &Solution,
    orders: &[OrderArgument],
    ways: &[Way],
    quiet: bool,
) -> Result<Vec<Sight>, Failure> {
    let world = start.world().moved_to(end.world().configuration());
    let world = Arc::new(world);
    let configuration = world.configuration();
    let scale = Scale::new(&world, end.pool().photons());
    let mut sights = Vec::new();
    let mut reader = IndirectLight::default();
    for (camera, view) in &configuration.scene().cameras {
        let onlooker = Onlooker::new(&world, view, maskings);
        let eye = Eye::new(&onlooker, &world, &scale, end.buckets(), &mut reader);
        for order in orders {
            for way in ways {
                let course = match order {
                    // Hits in the frustum were worse for a ledger than no order, and the item buffer no better for groups.
                    OrderArgument::Ledger if matches!(way, Way::V | Way::VMasked) => None,
                    OrderArgument::Stateless if matches!(way, Way::Items) => None,
                    OrderArgument::Ledger => ledger.map(Course::ledger),
                    OrderArgument::Stateless => Some(Course::stateless(start)),
                    OrderArgument::Random | OrderArgument::Oracle | OrderArgument::Restart => None,
                };
                let Some(mut course) = course else { continue };
                let order = if matches!(order, OrderArgument::Ledger) { "ledger" } else { "stateless" };
                let name = way.name();
                let frustum = Frustum::new(view, configuration.scene().up, 4.0 / 3.0);
                let mut unmasked = || Arc::new(maskings.unmasked(configuration, view));
                let look = |course: &mut Course| match way {
                    Way::P => {}
                    Way::V => course.look(Gaze::Frustum(frustum)),
                    Way::VMasked => course.look(Gaze::Masked(frustum, unmasked())),
                    Way::Items => course.look_at(&onlooker.visible().importance(&world)),
                };
                let bar = progress::bar(1000, &format!("{camera}, {order}, {name}"), quiet);
                let moments = watch(&mut course, look, &world, &eye, &mut reader, &bar)?;
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

fn watch(
    course: &mut Course,
    look: impl FnOnce(&mut Course),
    world: &Arc<World>,
    eye: &Eye,
    reader: &mut IndirectLight,
    bar: &indicatif::ProgressBar,
) -> Result<Vec<Moment>, Failure> {
    let refused = |e| Failure::failed(format!("the ledger has no room for it: {e}"));
    let start = Instant::now();
    course.change(world.clone()).map_err(refused)?;
    course.watch();
    look(course);
    let mut clock: Duration = start.elapsed();
    let mut moments = vec![eye.look(course, reader, 0, Duration::ZERO)?];
    let (mut rays, mut next) = (0, 1.0);
    loop {
        let start = Instant::now();
        let step = course.step().map_err(refused)?;
        clock += start.elapsed();
        let done = step.is_none();
        rays += step.map_or(0, |step| step.work.rays);
        if done || rays as f64 >= next {
            moments.push(eye.look(course, reader, rays, clock)?);
            let whole = rays as f64 / course.share();
            next = (rays as f64 * SPACING).min(rays as f64 + CLOSEST * whole);
            bar.set_position((course.share() * 1000.0) as u64);
        }
        if done || progress::interrupted() {
            let first = moments[0].visible;
            moments.iter_mut().for_each(|m| m.visible = if first > 0.0 { m.visible / first } else { 0.0 });
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
        "{:<16} {:<10} {:<11} {:>8} {:>8} {:>9}  {:>29}  {:>25}",
        "camera", "order", "by", "visible", "FLIP", "noticed", "eye / foreseen / exact, rays", "seconds"
    ));
    for sight in sights {
        let (eye, exact) = (sight.complete(), sight.moments.last());
        let foreseen = sight.foreseen().or(exact);
        let rays = |m: Option<&Moment>| m.map_or(0, |m| m.rays);
        let seconds = |m: Option<&Moment>| m.map_or(0.0, |m| m.seconds);
        say(&format!(
            "{:<16} {:<10} {:<11} {:>8.4} {:>8.5} {:>8.3}%  {:>8} /{:>8} /{:>8}  {:>7.3} /{:>7.3} /{:>7.3}",
            sight.camera,
            sight.order,
            sight.gaze,
            sight.area(|m| m.visible),
            sight.area(|m| m.flip),
            sight.area(|m| m.noticed) * 100.0,
            rays(eye),
            rays(foreseen),
            rays(exact),
            seconds(eye),
            seconds(foreseen),
            seconds(exact)
        ));
    }
}

/// Areas under the curves, and when the light was complete for the eye and exact.
pub fn json(sights: &[Sight]) -> Value {
    let moment = |m: &Moment| json!({ "rays": m.rays, "seconds": m.seconds, "noticed": m.noticed });
    sights
        .iter()
        .map(|sight| {
            json!({
                "camera": sight.camera, "order": sight.order, "by": sight.gaze,
                "area_visible_error": sight.area(|m| m.visible), "area_flip": sight.area(|m| m.flip),
                "area_noticed": sight.area(|m| m.noticed),
                "complete_for_the_eye": sight.complete().map(moment), "foreseen": sight.foreseen().map(moment), "exact": sight.moments.last().map(moment),
            })
        })
        .collect()
}

/// The figure's panels: pixels in which the error could be noticed, a panel for each camera and order.
pub fn panels(chapter: &Chapter) -> Vec<Panel> {
    let curve = |sight: &Sight, name, of: fn(&Moment) -> Option<f64>| {
        let whole = sight.moments.last().map_or(0, |m| m.rays).max(1) as f64;
        let point = |m: &Moment| Some((m.rays as f64 / whole * 100.0, of(m)? * 100.0));
        Curve { name, points: sight.moments.iter().filter_map(point).collect() }
    };
    let panel = |sights: &[Sight]| {
        let mut curves: Vec<Curve> = sights.iter().map(|sight| curve(sight, sight.gaze, |m| Some(m.noticed))).collect();
        let foresees = sights.iter().find(|sight| sight.gaze == Way::Items.name() && sight.order == "ledger");
        curves.extend(foresees.map(|sight| curve(sight, "foreseen, items", |m| m.foreseen)));
        Panel {
            title: format!("{}, from {}, {}", chapter.title, sights[0].camera, sights[0].order),
            across: "rays, % of those until exact".into(),
            upwards: "pixels in which the error could be noticed, %".into(),
            axes: Axes::Linear,
            curves,
        }
    };
    chapter.views.chunk_by(|a, b| (&a.camera, a.order) == (&b.camera, b.order)).map(panel).collect()
}

/// views.csv: a line per look.
pub fn write_csv(out: &mut impl Write, chapters: &[Chapter]) -> std::io::Result<()> {
    writeln!(out, "edit,camera,order,by,rays,seconds,visible_error,flip,noticed,foreseen")?;
    for (number, chapter) in chapters.iter().enumerate() {
        for Sight { camera, order, gaze, moments } in &chapter.views {
            for Moment { rays, seconds, visible, flip, noticed, foreseen } in moments {
                let foreseen = foreseen.map_or_else(String::new, |share| format!("{share:.6}"));
                writeln!(
                    out,
                    "{number},{camera},{order},{gaze},{rays},{seconds:.6},{visible:.6},{flip:.6},{noticed:.6},{foreseen}"
                )?;
            }
        }
    }
    Ok(())
}
