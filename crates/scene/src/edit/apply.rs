//! From one configuration to the next.

use crate::{
    Configuration, Edit, FARTHEST, Lamp, Material, Object, Pose, SceneError, Warning,
    configuration::{Slot, State},
    format::{MaterialEntry, ObjectEntry},
    load::{Index, Loader, MOST_CELLS, own_name, printable},
    unknown, within_reach,
};
use glam::DVec3;
use std::sync::Arc;

fn reachable(what: &str, to: DVec3) -> Result<DVec3, SceneError> {
    if within_reach(to) {
        return Ok(to);
    }
    Err(SceneError::Edit(format!("{what} cannot go to {to}: not a number, or farther than {FARTHEST:e} m from the origin")))
}

fn finite(what: &str, to: DVec3) -> Result<DVec3, SceneError> {
    if to.is_finite() { Ok(to) } else { Err(SceneError::Edit(format!("{what} cannot turn to {to}: not a number"))) }
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
            Edit::Put { object, on, to, rotation } => {
                let what = format!("object '{object}'");
                let pose = Pose { position: reachable(&what, *to)?, rotation: finite(&what, *rotation)? };
                state.put(object, on.as_deref(), pose)?;
            }
            Edit::Paint { object, material } => {
                material.as_ref().map(|name| state.material(name)).transpose()?;
                let painted = state.object(object)?;
                let entry = ObjectEntry { material: material.clone(), ..painted.entry.clone() };
                let mesh = painted.mesh.clone();
                let materials = self.load(&mut state, warnings, |loader, _, _| loader.materials_of(&entry, &mesh))?;
                let painted = state.object(object)?;
                (painted.materials, painted.entry) = (materials, entry);
            }
            Edit::Texture { material, texture } => {
                state.material(material)?;
                let blank: Vec<ObjectEntry> =
                    state.made_of(material).filter(|o| o.mesh.uvs.is_empty()).map(|o| o.entry.clone()).collect();
                let read = self.load(&mut state, warnings, |loader, _, _| {
                    let Some(file) = texture else { return Ok(None) };
                    blank.iter().for_each(|entry| loader.warn_of_blank(entry));
                    loader.texture(&format!("material '{material}'"), file).map(Some)
                })?;
                state.remake(material, |old| Material { texture: read, texture_path: texture.clone(), ..old })?;
            }
            Edit::AddMaterial { name, reflectance, texture } => {
                state.new_material(name)?;
                let entry = MaterialEntry { reflectance: *reflectance, texture: texture.clone() };
                let material = self.load(&mut state, warnings, |loader, _, _| loader.material(name, &entry))?;
                state.add_material(material);
            }
            Edit::RemoveMaterial { material } => state.remove_material(material)?,
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
                state.lamp(lamp)?.intensity = *intensity;
                state.countable(lamp)?;
            }
            Edit::Switch { lamp, on } => state.lamp(lamp)?.lit = *on,
            Edit::Relamp { lamp, photometry, intensity } => {
                let what = format!("lamp '{lamp}'");
                let read = self.load(&mut state, warnings, |loader, _, _| {
                    photometry.as_ref().map(|file| loader.photometry(&what, file)).transpose()
                })?;
                let relamped = state.lamp(lamp)?;
                (relamped.photometry, relamped.entry.photometry) = (read, photometry.clone());
                if let Some(intensity) = intensity {
                    (relamped.intensity, relamped.rated) = (*intensity, *intensity);
                }
                state.countable(lamp)?;
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
        read: impl FnOnce(&mut Loader, &Index, f64) -> Result<T, SceneError>,
    ) -> Result<T, SceneError> {
        let scene = self.scene();
        let mut loader = Loader::new(&scene.path);
        loader.knows([&scene.materials, &state.materials, &state.of_meshes]);
        (loader.materials, loader.of_meshes) = (state.materials.clone(), state.of_meshes.clone());
        let present = state.objects.iter().enumerate().filter(|(_, slot)| slot.present);
        let index = present.map(|(id, slot)| (slot.thing.name.clone(), id)).collect();
        let thing = read(&mut loader, &index, scene.file.cell)?;
        warnings.append(&mut loader.warnings);
        (state.materials, state.of_meshes) = (loader.materials, loader.of_meshes);
        Ok(thing)
    }
}

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

    /// A lamp's light must be a number, also when it is switched off.
    fn countable(&mut self, name: &str) -> Result<(), SceneError> {
        let lit = Lamp { lit: true, ..self.lamp(name)?.clone() };
        let countable = lit.intensity.is_finite() && lit.flux().is_finite() && lit.rated_flux().is_finite();
        if countable && lit.intensity.min_element() >= 0.0 {
            return Ok(());
        }
        let what = format!("lamp '{name}': intensity {} must be candela, not below 0 and a number", lit.intensity);
        Err(SceneError::Edit(what))
    }

    /// Carriers form no ring.
    fn put(&mut self, name: &str, on: Option<&str>, pose: Pose) -> Result<(), SceneError> {
        self.movable(name)?;
        let id = self.object_id(name)?;
        let carrier = on.map(|on| self.object_id(on)).transpose()?;
        let mut below = carrier;
        while let Some(at) = below {
            if at == id {
                let on = on.unwrap_or_default();
                let why = if on == name { "itself".into() } else { format!("'{on}', which rides on it") };
                return Err(SceneError::Edit(format!("object '{name}' cannot be put on {why}")));
            }
            below = self.objects[at].thing.carrier;
        }
        let object = self.object(name)?;
        (object.carrier, object.entry.on, object.pose) = (carrier, on.map(str::to_owned), pose);
        Ok(())
    }

    pub fn material(&self, name: &str) -> Result<&Arc<Material>, SceneError> {
        let known = self.materials.keys().map(String::as_str);
        self.materials.get(name).ok_or_else(|| SceneError::Edit(unknown("material", name, known)))
    }

    /// The objects that are there and use a material.
    fn made_of(&self, material: &str) -> impl Iterator<Item = &Object> {
        let present = self.objects.iter().filter(|slot| slot.present).map(|slot| &*slot.thing);
        present.filter(move |object| object.materials.iter().any(|m| m.name == material))
    }

    fn reflect(&mut self, name: &str, to: DVec3) -> Result<(), SceneError> {
        if !(to.is_finite() && to.min_element() >= 0.0 && to.max_element() <= 1.0) {
            return Err(SceneError::Edit(format!("material '{name}': reflectance {to} must be within 0 to 1")));
        }
        self.remake(name, |old| Material { reflectance: to.as_vec3(), ..old })
    }

    /// Changes a material wherever it is used.
    fn remake(&mut self, name: &str, change: impl FnOnce(Material) -> Material) -> Result<(), SceneError> {
        let new = Arc::new(change(Material::clone(self.material(name)?)));
        for slot in &mut self.objects {
            if slot.thing.materials.iter().any(|m| m.name == name) {
                let uses = Arc::make_mut(&mut slot.thing).materials.iter_mut().filter(|m| m.name == name);
                uses.for_each(|m| *m = new.clone());
            }
        }
        self.materials.insert(name.to_owned(), new);
        Ok(())
    }

    fn new_material(&self, name: &str) -> Result<(), SceneError> {
        new_name("material", name)?;
        if self.materials.contains_key(name) {
            return Err(SceneError::Edit(format!("there is a material '{name}' already; give the new one another name")));
        }
        // When the object is read again its material must not turn into this one.
        let mut own =
            self.objects.iter().filter(|slot| slot.present && slot.thing.entry.material.is_none()).map(|slot| &slot.thing);
        let kept = |object: &Object| object.mesh.materials.iter().any(|own| own_name(own, &object.entry.mesh) == name);
        match own.find(|object| kept(object)) {
            None => Ok(()),
            Some(object) => {
                let what =
                    format!("the name '{name}' is kept for a material of object '{}'; give the new one another", object.name);
                Err(SceneError::Edit(what))
            }
        }
    }

    fn add_material(&mut self, material: Material) {
        // What says the same as a mesh's own file still counts as the mesh's, so that undoing leaves no trace.
        if self.of_meshes.get(&material.name).is_some_and(|own| **own != material) {
            self.of_meshes.remove(&material.name);
        }
        self.materials.insert(material.name.clone(), Arc::new(material));
    }

    fn remove_material(&mut self, name: &str) -> Result<(), SceneError> {
        self.material(name)?;
        if let Some(object) = self.made_of(name).next() {
            let what = format!("material '{name}' is used by object '{}'; paint that first", object.name);
            return Err(SceneError::Edit(what));
        }
        self.materials.remove(name);
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
                // One lattice for one slot: cells keep their numbers. One mesh: it is seen at a glance that it is the same.
                (object.mesh, object.lattice) = (slot.thing.mesh.clone(), slot.thing.lattice.clone());
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
