//! What can change: an immutable state of the scene, and the edits that lead from one to the next.

use crate::{FARTHEST, Motion, Pose, Scene, SceneError, within_reach};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// One change of the scene. It states the new pose absolutely (relative to the carrier of what rides), never an increment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Edit {
    /// Put an object at a position, metres.
    Move {
        /// Its name.
        object: String,
        /// Metres.
        to: DVec3,
    },
    /// Turn an object to a rotation, degrees about x, y, z.
    Turn {
        /// Its name.
        object: String,
        /// Degrees.
        to: DVec3,
    },
}

/// The state of everything that edits can change. Immutable; a clone costs a pointer.
#[derive(Debug, Clone)]
pub struct Configuration {
    scene: Arc<Scene>,
    state: Arc<State>,
}

#[derive(Debug, Clone, PartialEq)]
struct State {
    objects: Vec<Pose>,
    lamps: Vec<Pose>,
}

impl PartialEq for Configuration {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.scene, &other.scene) && (Arc::ptr_eq(&self.state, &other.state) || self.state == other.state)
    }
}

impl Configuration {
    /// The scene as its file states it.
    pub fn initial(scene: &Arc<Scene>) -> Configuration {
        let objects = scene.objects.iter().map(|o| o.pose).collect();
        let lamps = scene.lamps.iter().map(|l| l.pose).collect();
        Configuration { scene: scene.clone(), state: Arc::new(State { objects, lamps }) }
    }

    /// The scene whose state this is.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// The configuration after an edit.
    pub fn apply(&self, edit: &Edit) -> Result<Configuration, SceneError> {
        let (Edit::Move { object, to } | Edit::Turn { object, to }) = edit;
        let id = self.scene.object(object)?;
        if !self.scene.objects[id].movable {
            return Err(SceneError::Edit(format!("object '{object}' is fixed; give it `movable: true` in the scene file")));
        }
        let possible = match edit {
            Edit::Move { .. } => within_reach(*to),
            Edit::Turn { .. } => to.is_finite(),
        };
        if !possible {
            let what =
                format!("object '{object}' cannot go to {to}: not a number, or farther than {FARTHEST:e} m from the origin");
            return Err(SceneError::Edit(what));
        }
        let mut state = State::clone(&self.state);
        match edit {
            Edit::Move { .. } => state.objects[id].position = *to,
            Edit::Turn { .. } => state.objects[id].rotation = *to,
        }
        Ok(Configuration { scene: self.scene.clone(), state: Arc::new(state) })
    }

    /// The pose of object `id`, relative to its carrier.
    pub fn pose(&self, id: usize) -> Pose {
        self.state.objects[id]
    }

    /// Where every object is in the world.
    pub fn object_motions(&self) -> Vec<Motion> {
        (0..self.scene.objects.len()).map(|id| self.object_motion(id)).collect()
    }

    /// Where object `id` is in the world.
    pub fn object_motion(&self, id: usize) -> Motion {
        self.carried(self.state.objects[id], self.scene.objects[id].carrier)
    }

    /// Where lamp `id` is in the world.
    pub fn lamp_motion(&self, id: usize) -> Motion {
        self.carried(self.state.lamps[id], self.scene.lamps[id].carrier)
    }

    fn carried(&self, pose: Pose, mut carrier: Option<usize>) -> Motion {
        let mut motion = pose.motion();
        // The scene's loader made sure that carriers form no ring.
        while let Some(id) = carrier {
            motion = motion.carried_by(&self.state.objects[id].motion());
            carrier = self.scene.objects[id].carrier;
        }
        motion
    }
}

impl Configuration {
    /// The scene file that says this state: the one that was read, with the poses of now.
    pub fn to_file(&self) -> crate::format::SceneFile {
        let mut file = self.scene.file.clone();
        for entry in &mut file.objects {
            if let Ok(id) = self.scene.object(&entry.name) {
                (entry.position, entry.rotation) = (self.state.objects[id].position, self.state.objects[id].rotation);
            }
        }
        file
    }
}
