//! The edits: one change of the scene each, stated absolutely, never as an increment.

use crate::{
    Configuration, FARTHEST, Lamp, Material, Object, SceneError, Warning,
    configuration::{Slot, State},
    format::{LampEntry, ObjectEntry, relocate},
    load::{Loader, MOST_CELLS, printable},
    unknown, within_reach,
};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::{path::Path, sync::Arc};

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
    /// Make an object of one of the scene's materials.
    Paint {
        /// Its name.
        object: String,
        /// The material's name.
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
    /// Give a lamp another photometric file. As its share of the photons may change, all photons may become wrong.
    Relamp {
        /// Its name.
        lamp: String,
        /// LM-63 file, relative to the scene's folder.
        photometry: String,
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

fn reachable(what: &str, to: DVec3) -> Result<DVec3, SceneError> {
    if within_reach(to) {
        return Ok(to);
    }
    Err(SceneError::Edit(format!("{what} cannot go to {to}: not a number, or farther than {FARTHEST:e} m from the origin")))
}

fn finite(what: &str, to: DVec3) -> Result<DVec3, SceneError> {
    if to.is_finite() { Ok(to) } else { Err(SceneError::Edit(format!("{what} cannot turn to {to}: not a number"))) }
}

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

    /// Takes the paths of a file that stood in folder `from` to those of a scene in folder `to`.
    pub(crate) fn relocate(&mut self, from: &Path, to: &Path) -> Result<(), SceneError> {
        match self {
            Edit::Add(entry) => relocate(&mut entry.mesh, from, to),
            Edit::AddLamp(LampEntry { photometry: Some(file), .. }) | Edit::Relamp { photometry: file, .. } => {
                relocate(file, from, to)
            }
            _ => Ok(()),
        }
    }
}

impl Configuration {
    /// The configuration after an edit.
    pub fn apply(&self, edit: &Edit) -> Result<Configuration, SceneError> {
        self.apply_warning(edit, &mut Vec::new())
    }

    /// As [`apply`](Self::apply); warnings of the files that are read are collected.
    pub fn apply_warning(&self, edit: &Edit, warnings: &mut Vec<Warning>) -> Result<Configuration, SceneError> {
        let mut state = State::clone(self.state());
        match edit {
            Edit::Move { object, to } | Edit::Drag { object, to, .. } => {
                let to = reachable(&format!("object '{object}'"), *to)?;
                state.movable(object)?.pose.position = to;
            }
            Edit::Turn { object, to } => {
                let to = finite(&format!("object '{object}'"), *to)?;
                state.movable(object)?.pose.rotation = to;
            }
            Edit::Paint { object, material } => {
                let known = state.materials.keys().map(String::as_str);
                let paint = state.materials.get(material);
                let paint = paint.cloned().ok_or_else(|| SceneError::Edit(unknown("material", material, known)))?;
                let object = state.object(object)?;
                object.materials.fill(paint);
                object.entry.material = Some(material.clone());
            }
            Edit::Reflect { material, to } => state.reflect(material, *to)?,
            Edit::Add(entry) => {
                let object = self.load(&mut state, warnings, |loader, index, cell| loader.object(entry, index, cell))?;
                state.add_object(object)?;
            }
            Edit::Duplicate { object, name, to } => {
                let to = reachable(&format!("object '{name}'"), *to)?;
                let mut copy = Object::clone(state.object(object)?);
                (copy.name, copy.entry.name, copy.pose.position) = (name.clone(), name.clone(), to);
                state.add_object(copy)?;
            }
            Edit::Remove { object } => state.remove(object)?,
            Edit::MoveLamp { lamp, to } => {
                let to = reachable(&format!("lamp '{lamp}'"), *to)?;
                state.lamp(lamp)?.pose.position = to;
            }
            Edit::TurnLamp { lamp, to } => {
                let to = finite(&format!("lamp '{lamp}'"), *to)?;
                state.lamp(lamp)?.pose.rotation = to;
            }
            Edit::Light { lamp, intensity } => {
                let lit = state.lamp(lamp)?;
                lit.intensity = *intensity;
                if !(intensity.min_element() >= 0.0 && lit.flux().is_finite() && intensity.is_finite()) {
                    let what = format!("lamp '{lamp}': intensity {intensity} must be candela, not below 0 and a number");
                    return Err(SceneError::Edit(what));
                }
            }
            Edit::Switch { lamp, on } => state.lamp(lamp)?.lit = *on,
            Edit::Relamp { lamp, photometry } => {
                let what = format!("lamp '{lamp}'");
                let read = self.load(&mut state, warnings, |loader, _, _| loader.photometry(&what, photometry))?;
                let relamped = state.lamp(lamp)?;
                relamped.photometry = Some(read);
                relamped.entry.photometry = Some(photometry.clone());
            }
            Edit::AddLamp(entry) => {
                let lamp = self.load(&mut state, warnings, |loader, index, _| loader.lamp(entry, index))?;
                state.add_lamp(lamp)?;
            }
            Edit::DuplicateLamp { lamp, name, to } => {
                let to = reachable(&format!("lamp '{name}'"), *to)?;
                let mut copy = Lamp::clone(state.lamp(lamp)?);
                (copy.name, copy.entry.name, copy.pose.position) = (name.clone(), name.clone(), to);
                state.add_lamp(copy)?;
            }
            Edit::RemoveLamp { lamp } => {
                let id = state.lamp_id(lamp)?;
                state.lamps[id].present = false;
            }
        }
        Ok(self.with(state))
    }

    /// Reads what an edit names, as the scene's loader would.
    fn load<T>(
        &self,
        state: &mut State,
        warnings: &mut Vec<Warning>,
        read: impl FnOnce(&mut Loader, &crate::load::Index, f64) -> Result<T, SceneError>,
    ) -> Result<T, SceneError> {
        let scene = self.scene();
        let mut loader = Loader::new(&scene.path);
        loader.own = scene.file.materials.keys().cloned().collect();
        loader.materials = state.materials.clone();
        let present = state.objects.iter().enumerate().filter(|(_, slot)| slot.present);
        let index = present.map(|(id, slot)| (slot.thing.name.clone(), id)).collect();
        let thing = read(&mut loader, &index, scene.file.cell)?;
        warnings.append(&mut loader.warnings);
        state.materials = loader.materials;
        Ok(thing)
    }
}

/// Steps of a drag: at 25 a second, some seven minutes.
const MOST_STEPS: f64 = 10_000.0;

fn new_name(kind: &str, name: &str) -> Result<(), SceneError> {
    if printable(name) {
        return Ok(());
    }
    Err(SceneError::Edit(format!("the name {name:?} of a new {kind}: names must be printable and not empty")))
}

impl State {
    fn movable(&mut self, name: &str) -> Result<&mut Object, SceneError> {
        let object = self.object(name)?;
        if object.movable {
            return Ok(object);
        }
        Err(SceneError::Edit(format!("object '{name}' is fixed; give it `movable: true` in the scene file")))
    }

    fn object(&mut self, name: &str) -> Result<&mut Object, SceneError> {
        let id = self.object_id(name)?;
        Ok(Arc::make_mut(&mut self.objects[id].thing))
    }

    fn lamp(&mut self, name: &str) -> Result<&mut Lamp, SceneError> {
        let id = self.lamp_id(name)?;
        Ok(Arc::make_mut(&mut self.lamps[id].thing))
    }

    fn reflect(&mut self, name: &str, to: DVec3) -> Result<(), SceneError> {
        if !(to.is_finite() && to.min_element() >= 0.0 && to.max_element() <= 1.0) {
            return Err(SceneError::Edit(format!("material '{name}': reflectance {to} must be within 0 to 1")));
        }
        let known = self.materials.keys().map(String::as_str);
        let old = self.materials.get(name).ok_or_else(|| SceneError::Edit(unknown("material", name, known)))?;
        let new = Arc::new(Material { reflectance: to.as_vec3(), ..Material::clone(old) });
        for slot in &mut self.objects {
            if slot.thing.materials.iter().any(|m| m.name == name) {
                let uses = Arc::make_mut(&mut slot.thing).materials.iter_mut().filter(|m| m.name == name);
                uses.for_each(|m| *m = new.clone());
            }
        }
        self.materials.insert(name.to_owned(), new);
        Ok(())
    }

    /// A removed object that comes back takes its old place, so that undoing leaves no trace.
    fn add_object(&mut self, mut object: Object) -> Result<(), SceneError> {
        if self.object_id(&object.name).is_ok() {
            return Err(SceneError::Edit(format!("there is an object '{}' already; give the new one another name", object.name)));
        }
        new_name("object", &object.name)?;
        let present = self.objects.iter().filter(|slot| slot.present).map(|slot| &*slot.thing);
        let cells: u64 = present.chain([&object]).map(|o| u64::from(o.lattice.cells())).sum();
        if cells > MOST_CELLS {
            let what = format!("object '{}': with it there would be {cells} mesh elements, more than {MOST_CELLS}", object.name);
            return Err(SceneError::Edit(what));
        }
        object.dynamic |= object.carrier.is_some_and(|id| self.objects[id].thing.dynamic);
        let place = self.objects.iter_mut().find(|s| !s.present && s.thing.name == object.name && s.thing.mesh == object.mesh);
        match place {
            Some(slot) => {
                // One lattice for one slot: cells keep their numbers.
                object.lattice = slot.thing.lattice.clone();
                *slot = Slot { thing: Arc::new(object), present: true };
            }
            None => self.objects.push(Slot { thing: Arc::new(object), present: true }),
        }
        Ok(())
    }

    fn add_lamp(&mut self, lamp: Lamp) -> Result<(), SceneError> {
        if self.lamp_id(&lamp.name).is_ok() {
            return Err(SceneError::Edit(format!("there is a lamp '{}' already; give the new one another name", lamp.name)));
        }
        new_name("lamp", &lamp.name)?;
        let new = Slot { thing: Arc::new(lamp), present: true };
        match self.lamps.iter_mut().find(|s| !s.present && s.thing.name == new.thing.name) {
            Some(slot) => *slot = new,
            None => self.lamps.push(new),
        }
        Ok(())
    }

    fn remove(&mut self, name: &str) -> Result<(), SceneError> {
        let id = self.object_id(name)?;
        self.objects[id].present = false;
        let rides_on_nothing = |carrier: Option<usize>, objects: &[Slot<Object>]| carrier.is_some_and(|c| !objects[c].present);
        // Riders of riders follow, one layer a round.
        loop {
            let next = self.objects.iter().position(|s| s.present && rides_on_nothing(s.thing.carrier, &self.objects));
            let Some(rider) = next else { break };
            self.objects[rider].present = false;
        }
        for slot in &mut self.lamps {
            slot.present &= !rides_on_nothing(slot.thing.carrier, &self.objects);
        }
        Ok(())
    }
}
