//! Scripted moves: timed edits and camera keys.

use crate::{Configuration, Edit, Scene, SceneError, View, format::read_ron};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::{path::Path, sync::Arc};

/// A moves file, checked against its scene. Edits are in order of time.
#[derive(Debug, Clone, PartialEq)]
pub struct Moves {
    /// Frames per second of playback.
    pub fps: f64,
    /// What happens.
    pub edits: Vec<TimedEdit>,
    /// Where the camera is.
    pub cameras: Vec<CameraKey>,
}

/// An edit and its time, seconds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimedEdit {
    /// Seconds from the start.
    pub at: f64,
    /// What changes.
    pub edit: ScriptedEdit,
}

/// What a moves file can say.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum ScriptedEdit {
    /// As [`Edit::Move`].
    Move {
        /// Its name.
        object: String,
        /// Metres.
        to: DVec3,
    },
    /// As [`Edit::Turn`].
    Turn {
        /// Its name.
        object: String,
        /// Degrees.
        to: DVec3,
    },
    /// Slide an object from where it is in a straight line.
    Drag {
        /// Its name.
        object: String,
        /// Metres.
        to: DVec3,
        /// Longest step, metres.
        step: f64,
        /// How long the drag takes.
        seconds: f64,
    },
}

/// A camera at a time, seconds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraKey {
    /// Seconds from the start.
    pub at: f64,
    /// Metres.
    pub eye: DVec3,
    /// Metres.
    pub target: DVec3,
    /// Vertical, degrees.
    pub fov: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct MovesFile {
    #[serde(default = "default_fps")]
    fps: f64,
    edits: Vec<TimedEdit>,
    #[serde(default)]
    cameras: Vec<CameraKey>,
}

fn default_fps() -> f64 {
    25.0
}

impl ScriptedEdit {
    /// The name of what it changes.
    pub fn object(&self) -> &str {
        let (Self::Move { object, .. } | Self::Turn { object, .. } | Self::Drag { object, .. }) = self;
        object
    }

    /// The edit to its last pose.
    pub fn last(&self) -> Edit {
        match self.clone() {
            Self::Move { object, to } | Self::Drag { object, to, .. } => Edit::Move { object, to },
            Self::Turn { object, to } => Edit::Turn { object, to },
        }
    }

    /// All its steps from `configuration` on, with seconds after its start. Every position is computed from the two ends alone.
    pub fn steps(&self, configuration: &Configuration) -> Result<Vec<(f64, Edit)>, SceneError> {
        let Self::Drag { object, to, step, seconds } = self else {
            return Ok(vec![(0.0, self.last())]);
        };
        let from = configuration.pose(configuration.scene().object(object)?).position;
        let count = ((from.distance(*to) / step) - 1e-9).ceil().max(1.0) as u32;
        Ok((1..=count)
            .map(|k| {
                let share = f64::from(k) / f64::from(count);
                let to = if k == count { *to } else { from + (*to - from) * share };
                (seconds * share, Edit::Move { object: object.clone(), to })
            })
            .collect())
    }
}

impl Moves {
    /// Reads a moves file and tries every edit on the scene.
    pub fn read(path: &Path, scene: &Arc<Scene>) -> Result<Moves, SceneError> {
        let file: MovesFile = read_ron(path)?;
        let mut moves = Moves { fps: file.fps, edits: file.edits, cameras: file.cameras };
        moves.check(scene).map_err(|what| SceneError::content(path, what))?;
        moves.edits.sort_by(|a, b| a.at.total_cmp(&b.at));
        moves.cameras.sort_by(|a, b| a.at.total_cmp(&b.at));
        Ok(moves)
    }

    fn check(&self, scene: &Arc<Scene>) -> Result<(), String> {
        if !(self.fps.is_finite() && self.fps > 0.0) {
            return Err(format!("fps is {}; it must be positive", self.fps));
        }
        let configuration = Configuration::initial(scene);
        for (number, timed) in self.edits.iter().enumerate() {
            let place = |what: String| format!("edit {number} (at {} s): {what}", timed.at);
            if !(timed.at.is_finite() && timed.at >= 0.0) {
                return Err(place("its time must be a number of seconds, not below 0".into()));
            }
            if let ScriptedEdit::Drag { step, seconds, .. } = &timed.edit
                && !(step.is_finite() && *step > 0.0 && seconds.is_finite() && *seconds >= 0.0)
            {
                return Err(place("a drag needs a positive step and seconds not below 0".into()));
            }
            configuration.apply(&timed.edit.last()).map_err(|e| place(e.to_string()))?;
        }
        for (number, key) in self.cameras.iter().enumerate() {
            let view = View { eye: key.eye, target: key.target, fov: key.fov };
            if let Some(fault) = view.fault() {
                return Err(format!("camera key {number}: {fault}"));
            }
            if !(key.at.is_finite() && key.at >= 0.0) {
                return Err(format!("camera key {number}: its time must be a number of seconds, not below 0"));
            }
        }
        Ok(())
    }
}
