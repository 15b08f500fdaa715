//! A script that plays in the window, by the clock.

use lightmend_scene::{Configuration, Edit, Moves, SceneError, View};
use std::{collections::VecDeque, time::Instant};

/// A script under way.
pub struct Playback {
    /// For the menu and for undo.
    pub title: String,
    moves: Moves,
    steps: VecDeque<(f64, Edit)>,
    /// The first time that anything was asked for: when a window opened, not while it was opening.
    began: Option<Instant>,
    /// When the last edit and camera key are over, seconds.
    end: f64,
}

impl Playback {
    /// Begins with the first call of [`due`](Self::due), on `configuration`.
    pub fn new(title: String, moves: Moves, configuration: &Configuration) -> Result<Playback, SceneError> {
        let steps = VecDeque::from(moves.timeline(configuration)?);
        let last_key = moves.cameras.last().map_or(0.0, |key| key.at);
        let end = steps.back().map_or(0.0, |(at, _)| *at).max(last_key);
        Ok(Playback { title, moves, steps, began: None, end })
    }

    /// What was due since the last call, of a row of moves of one object only the last; and where the camera is, if the script says.
    pub fn due(&mut self) -> (Vec<Edit>, Option<View>) {
        self.began.get_or_insert_with(Instant::now);
        let now = self.now();
        let mut due: Vec<Edit> = Vec::new();
        while let Some((_, edit)) = self.steps.pop_front_if(|(at, _)| *at <= now) {
            match (due.last_mut(), &edit) {
                (Some(Edit::Move { object, to }), Edit::Move { object: same, to: later }) if object == same => *to = *later,
                _ => due.push(edit),
            }
        }
        (due, self.moves.camera(now))
    }

    fn now(&self) -> f64 {
        self.began.map_or(0.0, |began| began.elapsed().as_secs_f64())
    }

    /// Share of it that was played.
    pub fn progress(&self) -> f32 {
        (self.now() / self.end.max(1e-9)).min(1.0) as f32
    }

    /// Whether nothing is left.
    pub fn is_over(&self) -> bool {
        self.steps.is_empty() && self.now() > self.end
    }
}
