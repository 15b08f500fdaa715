//! From one configuration to the next.

use crate::{
    Configuration, Edit, FARTHEST, Lamp, Material, Object, Pose, SceneError, Warning,
    configuration::State,
    format::{MaterialEntry, ObjectEntry},
    load::{Index, Loader},
    within_reach,
};
use glam::DVec3;

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
