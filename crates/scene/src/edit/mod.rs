//! The edits: one change of the scene each, stated absolutely, never as an increment. [`Configuration::apply`] makes it;
//! [`Edit::inverse`] says how it is undone.

mod apply;
mod inverse;
#[cfg(test)]
mod inverse_tests;
mod state;

use crate::{
    Configuration, SceneError,
    format::{LampEntry, ObjectEntry, relocate},
};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// One change of the scene. Poses are relative to the carrier of what rides.
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
    /// Slide an object from where it is in a straight line. As an edit it is the move to the end; a player goes step by step.
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
    /// Put a movable object on another one, or on none, at a pose relative to it.
    Put {
        /// Its name.
        object: String,
        /// What carries it from now on.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        on: Option<String>,
        /// Metres.
        to: DVec3,
        /// Degrees about x, y, z.
        rotation: DVec3,
    },
    /// Make an object of one of the scene's materials, or of those that its mesh names.
    Paint {
        /// Its name.
        object: String,
        /// The material's name; without it, the mesh's own materials.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        material: Option<String>,
    },
    /// Give a material another image, or none, wherever it is used.
    Texture {
        /// Its name.
        material: String,
        /// PNG or JPEG, relative to the scene's folder.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        texture: Option<String>,
    },
    /// Add a material, which nothing is made of yet.
    AddMaterial {
        /// Its name.
        name: String,
        /// Reflectance per linear Rec. 709 channel, 0 to 1.
        reflectance: DVec3,
        /// PNG or JPEG, relative to the scene's folder; multiplies the reflectance.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        texture: Option<String>,
    },
    /// Forget a material that nothing is made of.
    RemoveMaterial {
        /// Its name.
        material: String,
    },
    /// Change a material wherever it is used.
    Reflect {
        /// Its name.
        material: String,
        /// Reflectance per linear Rec. 709 channel, 0 to 1.
        to: DVec3,
    },
    /// Add an object.
    Add(
        /// As in a scene file.
        ObjectEntry,
    ),
    /// Add a copy of an object.
    Duplicate {
        /// What is copied.
        object: String,
        /// The copy's name.
        name: String,
        /// The copy's position, metres.
        to: DVec3,
    },
    /// Take an object away, and what rides on it.
    Remove {
        /// Its name.
        object: String,
    },
    /// Put a lamp at a position, metres.
    MoveLamp {
        /// Its name.
        lamp: String,
        /// Metres.
        to: DVec3,
    },
    /// Turn a lamp to a rotation, degrees about x, y, z.
    TurnLamp {
        /// Its name.
        lamp: String,
        /// Degrees.
        to: DVec3,
    },
    /// Dim or recolour a lamp: nothing is re-traced.
    Light {
        /// Its name.
        lamp: String,
        /// Candela per channel, or the factor of its photometric file's.
        intensity: DVec3,
    },
    /// Switch a lamp on or off: nothing is re-traced.
    Switch {
        /// Its name.
        lamp: String,
        /// On, or off.
        on: bool,
    },
    /// Let a lamp shine as another photometric file says, or in all directions alike. As its share of the photons may change, all
    /// photons may become wrong.
    Relamp {
        /// Its name.
        lamp: String,
        /// LM-63 file, relative to the scene's folder; without it, the same in all directions.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        photometry: Option<String>,
        /// Candela per channel, or the factor of the file's, also as what its share of the photons follows; as they are by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        intensity: Option<DVec3>,
    },
    /// Add a lamp. As the shares of all lamps change, all photons may become wrong.
    AddLamp(
        /// As in a scene file.
        LampEntry,
    ),
    /// Add a copy of a lamp; as [`Edit::AddLamp`].
    DuplicateLamp {
        /// What is copied.
        lamp: String,
        /// The copy's name.
        name: String,
        /// The copy's position, metres.
        to: DVec3,
    },
    /// Take a lamp away; as [`Edit::AddLamp`].
    RemoveLamp {
        /// Its name.
        lamp: String,
    },
}

/// Steps of a drag: at 25 a second, some seven minutes.
pub(crate) const MOST_STEPS: f64 = 10_000.0;

impl Edit {
    /// Its steps from `configuration` on, with seconds after its start; a drag has several, anything else is its own only step.
    /// Every position is computed from the two ends alone.
    pub fn steps(&self, configuration: &Configuration) -> Result<Vec<(f64, Edit)>, SceneError> {
        let Edit::Drag { object, to, step, seconds } = self else { return Ok(vec![(0.0, self.clone())]) };
        if !(step.is_finite() && *step > 0.0 && seconds.is_finite() && *seconds >= 0.0) {
            return Err(SceneError::Edit("a drag needs a positive step and seconds not below 0".into()));
        }
        let from = configuration.object(configuration.object_id(object)?).pose.position;
        let count = ((from.distance(*to) / step) - 1e-9).ceil().max(1.0);
        if count > MOST_STEPS {
            let what = format!("a drag of {count:e} steps is more than {MOST_STEPS:e}; make its step longer");
            return Err(SceneError::Edit(what));
        }
        let count = count as u32;
        Ok((1..=count)
            .map(|k| {
                let share = f64::from(k) / f64::from(count);
                let to = if k == count { *to } else { from + (*to - from) * share };
                (seconds * share, Edit::Move { object: object.clone(), to })
            })
            .collect())
    }

    /// The name of what it changes.
    pub fn subject(&self) -> &str {
        match self {
            Edit::Move { object, .. }
            | Edit::Turn { object, .. }
            | Edit::Drag { object, .. }
            | Edit::Put { object, .. }
            | Edit::Paint { object, .. }
            | Edit::Remove { object } => object,
            Edit::Texture { material, .. } | Edit::RemoveMaterial { material } | Edit::Reflect { material, .. } => material,
            Edit::AddMaterial { name, .. } | Edit::Duplicate { name, .. } | Edit::DuplicateLamp { name, .. } => name,
            Edit::Add(entry) => &entry.name,
            Edit::AddLamp(entry) => &entry.name,
            Edit::MoveLamp { lamp, .. }
            | Edit::TurnLamp { lamp, .. }
            | Edit::Light { lamp, .. }
            | Edit::Switch { lamp, .. }
            | Edit::Relamp { lamp, .. }
            | Edit::RemoveLamp { lamp } => lamp,
        }
    }

    /// Moves what it says of positions by some metres, where they are not relative to a carrier.
    pub(crate) fn shift(&mut self, configuration: &Configuration, by: DVec3) {
        let object_stands = |name: &str| configuration.object_id(name).is_ok_and(|id| configuration.object(id).carrier.is_none());
        let lamp_stands = |name: &str| configuration.lamps().any(|(_, lamp)| lamp.name == name && lamp.carrier.is_none());
        match self {
            Edit::Move { object, to } | Edit::Drag { object, to, .. } | Edit::Duplicate { object, to, .. }
                if object_stands(object) =>
            {
                *to += by;
            }
            Edit::MoveLamp { lamp, to } | Edit::DuplicateLamp { lamp, to, .. } if lamp_stands(lamp) => *to += by,
            Edit::Put { on: None, to, .. } => *to += by,
            Edit::Add(entry) if entry.on.is_none() => entry.position += by,
            Edit::AddLamp(entry) if entry.on.is_none() => entry.position += by,
            _ => {}
        }
    }

    /// Takes the paths of a file that stood in folder `from` to those of a scene in folder `to`.
    pub(crate) fn relocate(&mut self, from: &Path, to: &Path) -> Result<(), SceneError> {
        match self {
            Edit::Add(entry) => relocate(&mut entry.mesh, from, to),
            Edit::AddLamp(LampEntry { photometry: Some(file), .. })
            | Edit::Relamp { photometry: Some(file), .. }
            | Edit::Texture { texture: Some(file), .. }
            | Edit::AddMaterial { texture: Some(file), .. } => relocate(file, from, to),
            _ => Ok(()),
        }
    }
}
