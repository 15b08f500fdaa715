//! A script that plays in the window, by the clock.

use lightmend_scene::{Configuration, Edit, Moves, SceneError, View};
use std::{collections::VecDeque, time::Instant};

/// A script under way.
pub struct Playback {
    /// For the menu and for undo.
    pub title: String,
    moves: Moves,
    steps: VecDeque<(f64, Edit)>,
    began: Instant,
    /// When the last edit and camera key are over, seconds.
    end: f64,
}

impl Playback {
    /// Begins now, on `configuration`.
    pub fn new(title: String, moves: Moves, configuration: &Configuration) -> Result<Playback, SceneError> {
        let steps = VecDeque::from(moves.timeline(configuration)?);
        let last_key = moves.cameras.last().map_or(0.0, |key| key.at);
        let end = steps.back().map_or(0.0, |(at, _)| *at).max(last_key);
        Ok(Playback { title, moves, steps, began: Instant::now(), end })
    }

    /// What was due since the last call, of a row of moves of one object only the last; and where the camera is, if the script says.
    pub fn due(&mut self) -> (Vec<Edit>, Option<View>) {
        let now = self.began.elapsed().as_secs_f64();
        let mut due: Vec<Edit> = Vec::new();
        while let Some((_, edit)) = self.steps.pop_front_if(|(at, _)| *at <= now) {
            match (due.last_mut(), &edit) {
                (Some(Edit::Move { object, to }), Edit::Move { object: same, to: later }) if object == same => *to = *later,
                _ => due.push(edit),
            }
        }
        (due, self.moves.camera(now))
    }

    /// Share of it that was played.
    pub fn progress(&self) -> f32 {
        (self.began.elapsed().as_secs_f64() / self.end.max(1e-9)).min(1.0) as f32
    }

    /// Whether nothing is left.
    pub fn is_over(&self) -> bool {
        self.steps.is_empty() && self.began.elapsed().as_secs_f64() > self.end
    }
}
