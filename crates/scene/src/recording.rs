//! What a person does, as a script: every edit with its time, and of dragging and walking no more than it takes to see it again.
//!
//! Paths are simplified as in Douglas and Peucker, *Algorithms for the reduction of the number of points required to represent a
//! digitized line or its caricature*, 1973, with time as the parameter: what is left out is within a tolerance of where a straight,
//! uniform motion is at that time.

use crate::{CameraKey, Configuration, Edit, Moves, TimedEdit, View, edit::MOST_STEPS};
use glam::DVec3;

/// How far a recorded path may lie from what was done, metres; for a camera's target, of each metre between it and the eye.
/// Higher: fewer pieces, and corners are cut. 5 mm is a pixel at 3 m and 600 lines.
const TOLERANCE: f64 = 0.005;

/// The same for the angle of view, degrees.
const FOV_TOLERANCE: f64 = 0.1;

/// Shortest step of a drag, metres: shorter ones would be repaired, but not seen.
const SHORTEST_STEP: f64 = 0.001;

/// Who does not move for so long stood still, seconds; less may be a slow frame.
const STILL: f64 = 0.25;

/// Samples that are held before they are simplified; more of them, fewer keys of a long walk.
const MOST_SAMPLES: usize = 1024;

/// A time in the file, milliseconds.
type Milliseconds = u64;

/// Edits and camera of a session. Times are seconds since it began and never go back; the script has them in milliseconds.
#[derive(Debug, Clone)]
pub struct Recording {
    fps: f64,
    edits: Vec<TimedEdit>,
    /// The time of the last edit or step.
    last: Milliseconds,
    drag: Option<Path>,
    /// Camera keys that are decided.
    keys: Vec<(Milliseconds, View)>,
    /// Camera samples since.
    views: Vec<(Milliseconds, View)>,
}

/// An object under way: where it was when.
#[derive(Debug, Clone)]
struct Path {
    object: String,
    samples: Vec<(Milliseconds, DVec3)>,
}

impl Recording {
    /// For playback with `fps` frames per second: what is dragged goes a step a frame.
    pub fn new(fps: f64) -> Recording {
        Recording { fps, edits: Vec::new(), last: 0, drag: None, keys: Vec::new(), views: Vec::new() }
    }

    /// Where the camera is at a time. A view that cannot be drawn is left out.
    pub fn camera(&mut self, at: f64, view: View) {
        if view.fault().is_some() {
            return;
        }
        let at = milliseconds(at).max(self.views.last().map_or(0, |(last, _)| *last));
        // While it stands still, the second of two samples is put off.
        let still = matches!(self.views[..], [.., (_, a), (_, b)] if a == b && b == view);
        let again = self.views.last().is_some_and(|(last, _)| *last == at);
        if still || again {
            self.views.pop();
        }
        self.views.push((at, view));
        if self.views.len() >= MOST_SAMPLES {
            let kept = simplified(&self.views, view_error);
            let start = self.views.split_off(self.views.len() - 1);
            self.keys.extend(kept[..kept.len() - 1].iter().map(|k| self.views[*k]));
            self.views = start;
        }
    }

    /// An edit of the configuration `before`. One that changes nothing is left out.
    pub fn edit(&mut self, at: f64, edit: &Edit, before: &Configuration) {
        if changes_nothing(edit, before) {
            return;
        }
        self.end_drag();
        self.last = milliseconds(at).max(self.last);
        self.edits.push(TimedEdit { at: seconds(self.last), edit: edit.clone() });
    }

    /// A step of a continuous drag: the object is moved to `to`; `before` is the configuration before this step.
    pub fn drag(&mut self, at: f64, object: &str, to: DVec3, before: &Configuration) {
        let Ok(id) = before.object_id(object) else {
            // Whoever reads the file is told that there is no such object.
            return self.edit(at, &Edit::Move { object: object.to_owned(), to }, before);
        };
        if self.drag.as_ref().is_none_or(|path| path.object != object) {
            self.end_drag();
        }
        let frame = milliseconds(1.0 / self.fps);
        let (at, from) = (milliseconds(at).max(self.last), before.object(id).pose.position);
        // The first step, and the first after a pause, began a frame earlier where the object was.
        let began = at.saturating_sub(frame).max(self.last);
        let path = self.drag.get_or_insert_with(|| Path { object: object.to_owned(), samples: vec![(began, from)] });
        if path.samples.len() > 1 {
            if began - self.last > milliseconds(STILL) {
                path.samples.push((began, from));
            }
            // Of several steps in a millisecond the last one counts.
            path.samples.pop_if(|(last, _)| *last == at);
        }
        path.samples.push((at, to));
        self.last = at;
    }

    /// All of it until now.
    pub fn moves(&self) -> Moves {
        let mut done = self.clone();
        done.end_drag();
        let kept = simplified(&done.views, view_error);
        done.keys.extend(kept.iter().map(|k| done.views[*k]));
        let key = |(at, View { eye, target, fov }): &(Milliseconds, View)| CameraKey {
            at: seconds(*at),
            eye: *eye,
            target: *target,
            fov: *fov,
        };
        Moves { fps: done.fps, edits: done.edits, cameras: done.keys.iter().map(key).collect() }
    }

    /// The pieces of the drag under way.
    fn end_drag(&mut self) {
        let Some(Path { object, samples }) = self.drag.take() else { return };
        let kept = simplified(&samples, |[a, b], share, p| a.lerp(*b, share).distance(*p) / TOLERANCE);
        for ends in kept.windows(2) {
            let [(start, from), (end, to)] = [samples[ends[0]], samples[ends[1]]];
            if from.to_array().map(f64::to_bits) == to.to_array().map(f64::to_bits) {
                continue;
            }
            let (object, seconds_long) = (object.clone(), seconds(end - start));
            let edit = if end == start {
                Edit::Move { object, to }
            } else {
                let (distance, frames) = (from.distance(to), (seconds_long * self.fps).min(MOST_STEPS - 1.0));
                Edit::Drag { object, to, step: (distance / frames).max(SHORTEST_STEP), seconds: seconds_long }
            };
            self.edits.push(TimedEdit { at: seconds(start), edit });
        }
    }
}

fn milliseconds(seconds: f64) -> Milliseconds {
    (seconds * 1000.0).round() as Milliseconds
}

fn seconds(at: Milliseconds) -> f64 {
    at as f64 / 1000.0
}

/// Edits that read files are taken to change something.
fn changes_nothing(edit: &Edit, before: &Configuration) -> bool {
    let stated = matches!(
        edit,
        Edit::Move { .. }
            | Edit::Turn { .. }
            | Edit::Put { .. }
            | Edit::Reflect { .. }
            | Edit::MoveLamp { .. }
            | Edit::TurnLamp { .. }
            | Edit::Light { .. }
            | Edit::Switch { .. }
    );
    stated && before.apply(edit).is_ok_and(|after| after == *before)
}

/// How far a view is from the one between two others, in tolerances.
fn view_error([a, b]: [&View; 2], share: f64, view: &View) -> f64 {
    let eye = a.eye.lerp(b.eye, share).distance(view.eye) / TOLERANCE;
    let target = a.target.lerp(b.target, share).distance(view.target) / (TOLERANCE * view.eye.distance(view.target));
    let fov = (a.fov + (b.fov - a.fov) * share - view.fov).abs() / FOV_TOLERANCE;
    eye.max(target).max(fov)
}

/// Which samples suffice: where those between them would be, in uniform motion, is at most one `error` from where they are.
fn simplified<T>(samples: &[(Milliseconds, T)], error: impl Fn([&T; 2], f64, &T) -> f64) -> Vec<usize> {
    if samples.len() < 2 {
        return (0..samples.len()).collect();
    }
    let mut kept = vec![0, samples.len() - 1];
    // Pieces that are not looked at yet.
    let mut open = vec![(0, samples.len() - 1)];
    while let Some((first, last)) = open.pop() {
        let [(start, a), (end, b)] = [&samples[first], &samples[last]];
        let errors = (first + 1..last).map(|k| {
            let (at, sample) = &samples[k];
            let share = if end > start { (at - start) as f64 / (end - start) as f64 } else { 0.0 };
            (k, error([a, b], share, sample))
        });
        let worst = errors.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, error)| *error > 1.0);
        if let Some((middle, _)) = worst {
            kept.push(middle);
            open.extend([(first, middle), (middle, last)]);
        }
    }
    kept.sort_unstable();
    kept
}
