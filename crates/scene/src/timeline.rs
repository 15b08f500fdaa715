//! What happens when: the edits of a script, drags step by step.

use crate::{Configuration, Edit, Moves, SceneError};

impl Moves {
    /// All edits with their times, in order, from the configuration that they begin with. A drag ends where a later edit takes its
    /// object elsewhere or away, so that the last of them leaves the scene as the edits themselves do.
    pub fn timeline(&self, start: &Configuration) -> Result<Vec<(f64, Edit)>, SceneError> {
        let mut configuration = start.clone();
        let mut steps: Vec<(f64, Edit)> = Vec::new();
        // Objects under way, and which steps take them there.
        let mut drags: Vec<(&str, std::ops::Range<usize>)> = Vec::new();
        for timed in &self.edits {
            let parts = timed.edit.steps(&configuration)?;
            configuration = configuration.apply(&timed.edit)?;
            let placed = match &timed.edit {
                Edit::Move { object, .. } | Edit::Drag { object, .. } | Edit::Put { object, .. } => Some(object.as_str()),
                _ => None,
            };
            drags.retain(|(object, of_drag)| {
                let goes_on = placed != Some(*object) && configuration.object_id(object).is_ok();
                let late = steps[of_drag.clone()].iter_mut().filter(|(at, _)| !goes_on && *at >= timed.at);
                late.for_each(|(at, _)| *at = f64::INFINITY);
                goes_on
            });
            let first = steps.len();
            steps.extend(parts.into_iter().map(|(after, edit)| (timed.at + after, edit)));
            if let Edit::Drag { object, .. } = &timed.edit {
                drags.push((object, first..steps.len()));
            }
        }
        steps.retain(|(at, _)| at.is_finite());
        steps.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(steps)
    }
}

#[cfg(test)]
mod tests {
    use crate::{Configuration, Edit, Moves, Scene, TimedEdit};
    use glam::DVec3;

    fn room() -> Configuration {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/room/room.ron");
        Configuration::initial(&Scene::read(&path).unwrap().0)
    }

    fn drag(object: &str, x: f64) -> Edit {
        Edit::Drag { object: object.into(), to: DVec3::X * x, step: 0.1, seconds: 1.0 }
    }

    /// The steps of a script, which lead where its edits lead.
    fn steps(edits: Vec<(f64, Edit)>) -> Vec<(f64, Edit)> {
        let start = room();
        let moves =
            Moves { fps: 25.0, edits: edits.into_iter().map(|(at, edit)| TimedEdit { at, edit }).collect(), cameras: vec![] };
        let steps = moves.timeline(&start).unwrap();
        assert!(steps.is_sorted_by_key(|(at, _)| *at));
        let end = steps.iter().fold(start.clone(), |at, (_, edit)| at.apply(edit).unwrap());
        assert!(end == moves.edits.iter().fold(start, |at, timed| at.apply(&timed.edit).unwrap()));
        steps
    }

    #[test]
    fn a_drag_goes_step_by_step_until_something_else_takes_its_object() {
        let turn = Edit::Turn { object: "pouf".into(), to: DVec3::Z };
        let whole = steps(vec![(1.0, drag("pouf", 1.0)), (1.5, turn)]);
        assert!(whole.len() > 30 && whole.last().unwrap().0 == 2.0, "turning it does not end a drag");
        for end in [
            Edit::Move { object: "pouf".into(), to: DVec3::Y },
            Edit::Put { object: "pouf".into(), on: Some("table".into()), to: DVec3::Z, rotation: DVec3::ZERO },
            Edit::Remove { object: "pouf".into() },
        ] {
            let steps = steps(vec![(1.0, drag("pouf", 1.0)), (1.5, end.clone())]);
            assert!(steps.len() < whole.len() && *steps.last().unwrap() == (1.5, end));
        }
    }

    #[test]
    fn two_drags_run_at_a_time() {
        let steps = steps(vec![(0.0, drag("pouf", 1.0)), (0.5, drag("sofa", 1.0)), (0.75, drag("pouf", 2.0))]);
        let is_of = |edit: &Edit, name: &str| matches!(edit, Edit::Move { object, .. } if object == name);
        let end = |name: &str| steps.iter().rfind(|(_, edit)| is_of(edit, name)).map(|(at, _)| *at);
        assert_eq!([end("sofa"), end("pouf")], [Some(1.5), Some(1.75)]);
    }
}
