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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use proptest::{
        prelude::*,
        test_runner::{RngAlgorithm, TestRng, TestRunner},
    };
    use std::sync::Arc;

    fn room() -> Arc<Scene> {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/room/room.ron");
        Scene::read(&path).unwrap().0
    }

    /// A session: what is there, and the recording of how it came to be so.
    struct Session {
        configuration: Configuration,
        recording: Recording,
    }

    impl Session {
        fn new(scene: &Arc<Scene>) -> Session {
            Session { configuration: Configuration::initial(scene), recording: Recording::new(25.0) }
        }

        fn drag(&mut self, at: f64, object: &str, to: DVec3) {
            self.recording.drag(at, object, to, &self.configuration);
            self.configuration = self.configuration.apply(&Edit::Move { object: object.into(), to }).unwrap();
        }

        fn edit(&mut self, at: f64, edit: Edit) {
            self.recording.edit(at, &edit, &self.configuration);
            self.configuration = self.configuration.apply(&edit).unwrap();
        }

        /// The script, written and read, leads where the session led, at once and step by step.
        fn checked(&self) -> Moves {
            let (moves, scene) = (self.recording.moves(), self.configuration.scene());
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("moves.ron");
            moves.write(&path, scene).unwrap();
            assert_eq!(Moves::read(&path, scene).unwrap().0, moves);
            let start = Configuration::initial(scene);
            let all = moves.edits.iter().fold(start.clone(), |at, timed| at.apply(&timed.edit).unwrap());
            assert!(all == self.configuration);
            let steps = moves.timeline(&start).unwrap();
            assert!(steps.iter().fold(start, |at, (_, edit)| at.apply(edit).unwrap()) == self.configuration);
            moves
        }
    }

    #[test]
    fn a_straight_drag_is_one_edit_and_a_corner_makes_two() {
        let mut session = Session::new(&room());
        let from = session.configuration.object(session.configuration.object_id("table").unwrap()).pose.position;
        for k in 1..=25 {
            session.drag(1.0 + f64::from(k) / 25.0, "table", from + DVec3::X * (0.02 * f64::from(k)));
        }
        let moves = session.checked();
        let [TimedEdit { at, edit: Edit::Drag { step, seconds, .. } }] = &moves.edits[..] else { panic!("{moves:?}") };
        assert!(*at == 1.0 && *seconds == 1.0 && (*step - 0.02).abs() < 1e-12, "{moves:?}");
        for k in 1..=50 {
            session.drag(2.0 + f64::from(k) / 50.0, "table", from + DVec3::new(0.5, 0.01 * f64::from(k), 0.0));
        }
        assert_eq!(session.checked().edits.len(), 2);
        // A pause, and on.
        session.drag(7.0, "table", from + DVec3::new(0.5, 0.51, 0.0));
        session.drag(7.5, "table", from + DVec3::new(0.5, 1.0, 0.0));
        let moves = session.checked();
        assert!(moves.edits.len() <= 4 && moves.edits[2].at > 6.9, "{moves:?}");
    }

    #[test]
    fn a_curved_drag_takes_few_edits_and_stays_near() {
        let mut session = Session::new(&room());
        let from = session.configuration.object(session.configuration.object_id("table").unwrap()).pose.position;
        let way = |at: f64| from + DVec3::new((at * at / 4.0).sin(), 1.0 - (at * at / 4.0).cos(), 0.0);
        let times: Vec<f64> = (1..=200).map(|k| f64::from(k) / 40.0).collect();
        times.iter().for_each(|at| session.drag(*at, "table", way(*at)));
        let moves = session.checked();
        assert!((10..60).contains(&moves.edits.len()), "{}", moves.edits.len());
        let mut start = from;
        for TimedEdit { at, edit } in &moves.edits {
            let Edit::Drag { to, step, seconds, .. } = edit else { panic!("{edit:?}") };
            let steps = (start.distance(*to) / step).ceil();
            assert!((steps - seconds * 25.0).abs() < 1.5 || *step == SHORTEST_STEP, "a step a frame: {edit:?}");
            for time in times.iter().filter(|time| (*at..=at + seconds).contains(*time)) {
                let off = start.lerp(*to, (time - at) / seconds).distance(way(*time));
                assert!(off < 1.01 * TOLERANCE, "{off} at {time}");
            }
            start = *to;
        }
    }

    #[test]
    fn what_changes_nothing_is_left_out() {
        let mut session = Session::new(&room());
        session.edit(0.0, Edit::Switch { lamp: "pendant".into(), on: true });
        assert_eq!(session.checked().edits, []);
        session.edit(0.0, Edit::Switch { lamp: "pendant".into(), on: false });
        assert_eq!(session.checked().edits.len(), 1);
    }

    #[test]
    fn random_sessions_are_made_again_to_the_bit() {
        let scene = room();
        let config = ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() };
        let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
        let step = (0u8..8, any::<bool>(), prop::array::uniform3(-0.03f64..0.03), 0.0f64..0.06);
        runner
            .run(&prop::collection::vec(step, 1..150), |steps| {
                let (mut session, mut at) = (Session::new(&scene), 0.0);
                let (mut object, mut velocity) = ("cup west", DVec3::ZERO);
                for (kind, other, by, after) in steps {
                    let by = DVec3::from_array(by);
                    at += after;
                    let id = session.configuration.object_id(object).unwrap();
                    let pose = session.configuration.object(id).pose;
                    match kind {
                        0 if other => object = if object == "table" { "cup west" } else { "table" },
                        1 if other => session.edit(at, Edit::Turn { object: object.into(), to: pose.rotation + by * 100.0 }),
                        2 if other => at += 3.0,
                        3 if other => session.edit(at, Edit::Switch { lamp: "washer".into(), on: by.x > 0.0 }),
                        4 if other => velocity = by,
                        5 if other => {
                            let on = (by.x > 0.0).then(|| "sofa".to_owned());
                            session.edit(at, Edit::Put { object: "cup west".into(), on, to: by, rotation: by });
                        }
                        _ => {
                            velocity += by * 0.05;
                            session.drag(at, object, pose.position + velocity);
                        }
                    }
                }
                session.checked();
                Ok(())
            })
            .unwrap();
    }

    #[test]
    fn a_walk_takes_few_keys_and_stays_near() {
        let mut recording = Recording::new(25.0);
        let view = |at: f64| {
            // Along a wall, a pause of five seconds, around a corner while zooming; with a hand that is not quite steady.
            let shake = 0.001 * DVec3::new((at * 50.0).sin(), (at * 31.0).cos(), 0.0);
            let way = at.min(4.0) + (at - 9.0).max(0.0);
            let turn = (way - 4.0).max(0.0) * 0.5;
            let eye = DVec3::new(way.min(4.0) + turn.sin(), turn.cos(), 1.6);
            let shake = if (4.0..9.0).contains(&at) { DVec3::ZERO } else { shake };
            View { eye: eye + shake, target: eye + 3.0 * DVec3::new(turn.cos(), -turn.sin(), 0.0), fov: 60.0 + 5.0 * turn }
        };
        let times: Vec<f64> = (0..1800).map(|k| 0.5 + f64::from(k) / 125.0).collect();
        times.iter().for_each(|at| recording.camera(*at, view(*at)));
        recording.camera(20.0, View { eye: DVec3::ONE, target: DVec3::ONE, fov: 60.0 });
        let moves = recording.moves();
        assert_eq!(moves.cameras[0].at, 0.5);
        assert!(moves.cameras.len() < 40, "{}", moves.cameras.len());
        for at in &times {
            let seen = moves.camera(*at).unwrap();
            let error = view_error([&seen, &seen], 0.0, &view(*at));
            // Half a millisecond at 1 m/s is a tenth of the tolerance.
            assert!(error < 1.25, "{error} at {at}");
        }
        let mut still = Recording::new(25.0);
        (0..5000).for_each(|k| still.camera(f64::from(k) / 60.0, view(4.5)));
        assert_eq!(still.moves().cameras.len(), 2);
        assert!(still.views.len() == 2, "a pause takes no memory");
    }
}
