//! A drag step by step: how much of the change is outstanding at each frame, as the camera sees it.

use super::{Chapter, OrderArgument, orders_of};
use crate::{
    failure::Failure,
    figure::{Axes, Curve, Panel},
    progress,
};
use lightmend_photon::{
    drag::{Frame, Play},
    ledger::LedgerSolution,
    recovery::Order,
    solution::Solution,
    visible::{Frustum, Visible},
    world::World,
};
use lightmend_scene::{Moves, TimedEdit};
use serde_json::{Map, Value, json};
use std::{io::Write, sync::Arc};

/// The courses of a drag, by order.
pub type Drag = Vec<(&'static str, Vec<Frame>)>;

/// Frames after which a drag that is still not exact is left: ten times the seed's perceivable recovery at 25 frames a second.
const MOST_FRAMES: usize = 1000;

/// Plays an edit's steps from `start` to `end`; `None` if there is no camera or the run was interrupted.
pub fn play(
    moves: &Moves,
    timed: &TimedEdit,
    start: &Solution,
    ledger: Option<&LedgerSolution>,
    end: &Solution,
    work: u64,
    orders: &[OrderArgument],
    quiet: bool,
) -> Result<Option<Drag>, Failure> {
    let before = start.world().configuration();
    let first = || before.scene().cameras.first().map(|c| c.1);
    let Some(view) = moves.camera(timed.at).or_else(first) else { return Ok(None) };
    let mut configuration = before.clone();
    let mut world = start.world().clone();
    let mut steps: Vec<(f64, Arc<World>)> = Vec::new();
    let edits = timed.edit.steps(before)?;
    let first = edits.first().map_or(0.0, |(at, _)| *at);
    for (at, edit) in &edits {
        configuration = configuration.apply(edit)?;
        world = Arc::new(world.moved_to(&configuration));
        // The first step is what the person sees when the drag begins.
        steps.push((at - first, world.clone()));
    }
    let visible = Visible::new(end.world(), &view);
    let frustum = Some(Frustum::new(&view, before.scene().up, 4.0 / 3.0));
    let play = Play { start, steps: &steps, end, visible: &visible, frustum, fps: moves.fps, work };
    let mut drag = Drag::new();
    for (order, name) in orders_of(orders, ledger).filter(|(order, _)| !matches!(order, Order::Oracle)) {
        let bar = progress::bar(0, &format!("drag, {name}"), quiet);
        let frames = play.run(order, MOST_FRAMES, &mut |frame| {
            bar.set_position(frame as u64);
            !progress::interrupted()
        });
        bar.finish_and_clear();
        let Some(frames) = frames else { return Ok(None) };
        drag.push((name, frames));
    }
    Ok(Some(drag))
}

/// Per order: frames until exact, and what was outstanding at the end of the drag and on average until exact.
pub fn json(drag: &Drag, last_step: f64) -> Value {
    let orders: Map<String, Value> = drag
        .iter()
        .map(|(name, frames)| {
            let at_end = frames.iter().find(|f| f.time >= last_step).or(frames.last());
            let settled = frames.iter().find(|f| f.time >= last_step && f.outstanding <= 0.05);
            let value = json!({
                "outstanding_at_end_of_drag": at_end.map(|f| f.outstanding),
                "seconds_from_end_of_drag_to_5_percent": settled.map(|f| f.time - last_step),
                "frames_to_exact": frames.last().filter(|f| f.outstanding == 0.0).map(|_| frames.len() - 1),
            });
            (name.to_string(), value)
        })
        .collect();
    Value::Object(orders)
}

/// The figure's panel.
pub fn panel(scene: &str, chapter: &Chapter, drag: &Drag, work: u64) -> Panel {
    let points = |frames: &[Frame]| frames.iter().map(|f| (f.time, f.outstanding * 100.0)).collect();
    Panel {
        title: format!("{scene}, {}, {work} rays a frame", chapter.title),
        across: "seconds since the drag began".into(),
        upwards: "outstanding change in the picture, %".into(),
        axes: Axes::Linear,
        curves: drag.iter().map(|(name, frames)| Curve { name, points: points(frames) }).collect(),
    }
}

/// drag.csv: a line per edit, order and frame.
pub fn write_csv(out: &mut impl Write, chapters: &[Chapter]) -> std::io::Result<()> {
    writeln!(out, "edit,order,time,rays,outstanding")?;
    for (number, chapter) in chapters.iter().enumerate() {
        for (name, frames) in chapter.drag.iter().flatten() {
            for f in frames {
                writeln!(out, "{number},{name},{:.4},{},{:.6}", f.time, f.rays, f.outstanding)?;
            }
        }
    }
    Ok(())
}
