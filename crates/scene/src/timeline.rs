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
