//! A drag by the clock: what the camera sees is wrong while a person drags and after, for the background solver with a ledger, without
//! one, and starting over at every step.
//!
//! `cargo run --release -p lightmend-photon --example drag -- SCENE MOVES [PHOTONS] [OUT]`: steps of the script come at their times
//! whatever the solver is at. Twenty times a second the newest light is compared with the drained light of the pose that stands then:
//! RMS over the camera's pixels of the difference of irradiance, over the RMS of the drained light. The ledger's light is compared as it
//! is shown, with what is expected of the repair, and as it is. Writes `drag.svg`, `drag.png` and
//! `drag.tsv` into OUT (`out`). Threads: all cores; nothing is drawn meanwhile.

#[path = "support/chart.rs"]
mod chart;
#[path = "support/picture.rs"]
#[allow(dead_code, reason = "shared, with more colours")]
mod picture;

use chart::{Curve, Panel, Panels, Stroke};
use lightmend_photon::{
    body::TreePreset,
    bucket::Buckets,
    halton::Scrambling,
    ledger::LedgerSolution,
    path::FirstHits,
    pool::Pool,
    solver::{Controls, Settings, Solver},
    visible::Visible,
    world::World,
};
use lightmend_scene::{Configuration, Moves, Scene};
use picture::{BLUE, GREEN, RED};
use std::{
    error::Error,
    fmt::Write,
    path::Path,
    sync::Arc,
    time::{Duration, Instant},
};

type Fallible<T> = Result<T, Box<dyn Error>>;

/// A pose of the drag.
struct Step {
    at: f64,
    configuration: Configuration,
    /// What the camera sees of it, and how bright that is once it is drained.
    visible: Visible,
    drained: Vec<[f32; 3]>,
}

/// How it is repaired.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    Ledger,
    Stateless,
    Restart,
}

const WAYS: [(Way, &str, plotters::style::RGBColor, Stroke); 3] = [
    (Way::Ledger, "ledger", BLUE, Stroke::Solid),
    (Way::Stateless, "stateless", GREEN, Stroke::Solid),
    (Way::Restart, "restart", RED, Stroke::Dotted),
];

/// Looks a second.
const LOOKS: f64 = 20.0;

/// Nobody waits longer for a curve to end, seconds.
const LONGEST: f64 = 90.0;

fn main() -> Fallible<()> {
    let mut arguments = std::env::args().skip(1);
    let usage = "which scene, and which moves? --example drag -- SCENE MOVES [PHOTONS] [OUT]";
    let (scene, moves) = (arguments.next().ok_or(usage)?, arguments.next().ok_or(usage)?);
    let photons = arguments.next().map_or(Ok(20_000_000), |n| n.parse())?;
    let out = arguments.next().unwrap_or_else(|| "out".into());
    let (scene, _) = Scene::read(scene.as_ref())?;
    let (moves, _) = Moves::read(moves.as_ref(), &scene)?;
    let pool = Pool::new(photons, 288, 16, Scrambling::Seed(1))?;
    let (start, steps) = poses(&scene, &moves, pool)?;
    let whole = error(&steps[steps.len() - 1], &start);
    println!("{}: {} steps, {photons} photons; the change is {:.2} % of what is seen", scene.name, steps.len(), 100.0 * whole);

    let end = steps[steps.len() - 1].at;
    let mut curves = Vec::new();
    let mut table = String::from("way\tseconds\tvisible_error\n");
    for (way, name, colour, stroke) in WAYS {
        let looks = play(&scene, &steps, pool, way)?;
        let as_it_is = (way == Way::Ledger).then_some((1, "ledger, as it is", Stroke::Dashed));
        for (which, name, stroke) in [(0, name, stroke)].into_iter().chain(as_it_is) {
            let points: Vec<(f64, f64)> = looks.iter().map(|(at, errors)| (*at, errors[which])).collect();
            let dragging = points.iter().filter(|(at, _)| *at <= end);
            let mean = dragging.clone().map(|(_, error)| error).sum::<f64>() / dragging.count().max(1) as f64;
            let until =
                |share: f64| points.iter().rposition(|(_, error)| *error > share * whole).map_or(0.0, |n| points[n].0 - end);
            println!(
                "{name}: outstanding on average while dragged {:.1} % of the whole change; after release {}exact after {:.2} s",
                100.0 * mean / whole,
                [20, 10, 5]
                    .map(|percent| format!("{percent} % after {:.2} s, ", until(f64::from(percent) / 100.0).max(0.0)))
                    .concat(),
                points.last().map_or(0.0, |(at, _)| at - end)
            );
            for (at, error) in &points {
                writeln!(table, "{name}\t{at:.3}\t{error:.6}")?;
            }
            let points = points.into_iter().map(|(at, error)| (at, 100.0 * error / whole)).collect();
            curves.push(Curve { name: name.into(), colour, stroke, points });
        }
    }
    let panel = Panel {
        title: format!("{}, dragged for {:.1} s, {photons} photons", scene.name, end),
        across: "seconds".into(),
        upwards: "outstanding, % of the change".into(),
        curves,
    };
    let out = Path::new(&out);
    std::fs::create_dir_all(out)?;
    std::fs::write(out.join("drag.tsv"), table)?;
    picture::write(out, "drag", &Panels { columns: 1, panels: vec![panel] })
}

/// Visible error of `light`, values of what is seen at a step, against its drained light.
fn error(step: &Step, values: &[[f32; 3]]) -> f64 {
    step.visible.difference(values, &step.drained)
}

/// The drained light of every pose; first what the last pose's camera sees of the light before the drag.
fn poses(scene: &Arc<Scene>, moves: &Moves, pool: Pool) -> Fallible<(Vec<[f32; 3]>, Vec<Step>)> {
    let (_, view) = scene.cameras.first().ok_or("the scene has no camera")?;
    let mut configuration = Configuration::initial(scene);
    let world = Arc::new(World::new(&configuration, TreePreset::default()));
    let mut ledger = LedgerSolution::shoot(pool, world, FirstHits::AsLampsSay, u64::MAX, &mut |_, _| true)?;
    let values = |visible: &Visible, buckets: &Buckets, world: &World| {
        visible.values(buckets, &lightmend_photon::irradiance::Scale::new(world, pool.photons()))
    };
    let before = (ledger.buckets().clone(), ledger.world().clone());
    let mut steps = Vec::new();
    for timed in &moves.edits {
        for (after, edit) in timed.edit.steps(&configuration)? {
            configuration = configuration.apply(&edit)?;
            ledger.change(Arc::new(ledger.world().moved_to(&configuration)))?;
            while ledger.repair_next()?.is_some() {}
            let visible = Visible::new(ledger.world(), view);
            let drained = values(&visible, ledger.buckets(), ledger.world());
            steps.push(Step { at: timed.at + after, configuration: configuration.clone(), visible, drained });
        }
    }
    let last = steps.last().ok_or("nothing moves")?;
    Ok((values(&last.visible, &before.0, &before.1), steps))
}

/// Plays the steps by the clock: seconds and visible error, of the light as it is shown and as it is, until it is exact.
fn play(scene: &Arc<Scene>, steps: &[Step], pool: Pool, way: Way) -> Fallible<Vec<(f64, [f64; 2])>> {
    let settings = Settings {
        pool,
        first_hits: FirstHits::AsLampsSay,
        ledger_bytes: if way == Way::Ledger { u64::MAX } else { 0 },
        threads: std::thread::available_parallelism()?.get(),
        courteous: false,
        controls: Controls::default(),
    };
    let solver = Solver::start(Configuration::initial(scene), settings)?;
    let (_, view) = scene.cameras.first().ok_or("the scene has no camera")?;
    solver.look(*view);
    solver.wait_until_exact();
    let began = Instant::now();
    let (mut points, mut next, mut edits) = (Vec::new(), 0, 0);
    for look in 1.. {
        let at = f64::from(look) / LOOKS;
        while let Some(step) = steps.get(next).filter(|step| step.at <= at) {
            std::thread::sleep(Duration::from_secs_f64(step.at).saturating_sub(began.elapsed()));
            edits = solver.edit(step.configuration.clone());
            if way == Way::Restart {
                edits = solver.start_over();
            }
            next += 1;
        }
        std::thread::sleep(Duration::from_secs_f64(at).saturating_sub(began.elapsed()));
        let Some(light) = solver.snapshot() else { continue };
        let step = &steps[next.max(1) - 1];
        let at_once = began.elapsed().as_secs_f64();
        let error = |buckets: &Buckets| error(step, &step.visible.values(buckets, &light.scale));
        points.push((at_once, [error(&light.expected()), error(&light.buckets)]));
        if (next == steps.len() && light.exact && light.edits >= edits) || at > LONGEST {
            break;
        }
    }
    Ok(points)
}
