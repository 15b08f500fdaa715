//! A model becomes an object of the room: in metres, upright, standing on its origin, with materials of its own.
//!
//! It is written anew beside the scene file, so that the scene stays whole when the model's file goes away, and faces without an area are
//! left out.

use super::{
    dialogs,
    navigation::axes,
    pick::{Sight, meet},
    session::{Selection, Session},
};
use egui::Ui;
use glam::{DMat3, DVec3};
use lightmend_scene::{
    Edit, Mesh, SceneError, Up,
    format::{self, ObjectEntry, write_atomically},
    obj::{ObjFile, Strictness, read_obj, write_obj},
};
use std::path::{Path, PathBuf};

/// The unit of a model's coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    Metre,
    Decimetre,
    Centimetre,
    Millimetre,
    Foot,
    Inch,
}

impl Unit {
    /// All of them.
    pub const ALL: [Unit; 6] = [Unit::Metre, Unit::Decimetre, Unit::Centimetre, Unit::Millimetre, Unit::Foot, Unit::Inch];

    /// What people call it.
    pub fn name(self) -> &'static str {
        match self {
            Unit::Metre => "metres",
            Unit::Decimetre => "decimetres",
            Unit::Centimetre => "centimetres",
            Unit::Millimetre => "millimetres",
            Unit::Foot => "feet",
            Unit::Inch => "inches",
        }
    }

    /// Its length, metres.
    pub fn metres(self) -> f64 {
        match self {
            Unit::Metre => 1.0,
            Unit::Decimetre => 0.1,
            Unit::Centimetre => 0.01,
            Unit::Millimetre => 0.001,
            Unit::Foot => 0.3048,
            Unit::Inch => 0.0254,
        }
    }

    /// What something of that size is probably measured in: furniture is 5 cm to 3 m long.
    fn guess(longest: f64) -> Unit {
        [Unit::Metre, Unit::Centimetre, Unit::Millimetre]
            .into_iter()
            .find(|u| longest * u.metres() <= 3.5)
            .unwrap_or(Unit::Millimetre)
    }
}

/// A model that may be added.
pub struct Model {
    path: PathBuf,
    read: Result<ObjFile, String>,
    name: String,
    unit: Unit,
    up: Up,
    low: DVec3,
    high: DVec3,
}

impl Model {
    /// Reads a model's file.
    pub fn read(session: &Session, path: &Path) -> Model {
        let read = read_obj(path, Strictness::Import).map(|(model, _)| model).map_err(|e| e.to_string());
        let positions = || read.iter().flat_map(|model| &model.parts).flat_map(|part| part.mesh.positions.iter().copied());
        let low = positions().fold(DVec3::INFINITY, DVec3::min);
        let high = positions().fold(DVec3::NEG_INFINITY, DVec3::max);
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let name = session.free_object_name(if stem.trim().is_empty() { "object" } else { stem.trim() });
        // Most programs write OBJ files with y upwards.
        Model { path: path.to_owned(), name, unit: Unit::guess((high - low).max_element()), up: Up::Y, low, high, read }
    }

    /// From the model's coordinates to the object's, in the scene's axes.
    fn turn(&self, scene: Up) -> DMat3 {
        match (self.up, scene) {
            (Up::Y, Up::Z) => DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y),
            (Up::Z, Up::Y) => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
            _ => DMat3::IDENTITY,
        }
    }

    /// Asks how it is to be taken. Whether that is answered.
    pub fn ui(&mut self, session: &mut Session, ui: &mut Ui) -> bool {
        ui.heading("Add an object");
        ui.add(egui::Label::new(self.path.display().to_string()).truncate());
        if let Err(why) = &self.read {
            ui.colored_label(ui.visuals().error_fg_color, why);
            return ui.button("Close").clicked();
        }
        ui.horizontal(|ui| {
            ui.label("Name");
            ui.text_edit_singleline(&mut self.name);
        });
        ui.horizontal(|ui| {
            ui.label("Its lengths are");
            egui::ComboBox::from_id_salt("unit")
                .selected_text(self.unit.name())
                .show_ui(ui, |ui| dialogs::unit_list(ui, &mut self.unit));
            ui.label("and up is");
            ui.selectable_value(&mut self.up, Up::Y, "y");
            ui.selectable_value(&mut self.up, Up::Z, "z");
        });
        let size = (self.turn(session.scene.up) * (self.high - self.low)).abs() * self.unit.metres();
        let [e, n, u] = axes(session.scene.up).map(|axis| size.dot(axis).abs());
        ui.label(format!("In the room it is {e:.2} m wide, {n:.2} m deep and {u:.2} m high."));
        let mut answered = false;
        ui.horizontal(|ui| {
            if ui.button("Add").clicked() {
                let added = self.add(session);
                answered = added.is_ok();
                if let Err(error) = added {
                    session.messages.fail(error.to_string());
                }
            }
            answered |= ui.button("Cancel").clicked();
        });
        answered
    }

    /// Adds it where the camera looks.
    pub fn add(&self, session: &mut Session) -> Result<(), SceneError> {
        let Ok(model) = &self.read else { return Ok(()) };
        let up = session.scene.up;
        let wanted = self.name.trim();
        let name = session.free_object_name(if wanted.is_empty() { "object" } else { wanted });
        let (turn, scale) = (self.turn(up), self.unit.metres());
        let mut mesh = Mesh::merged(model.parts.iter().map(|part| &part.mesh));
        // It stands on its origin, in the middle.
        let [low, high] = {
            let ends = [self.low, self.high].map(|p| turn * p);
            [ends[0].min(ends[1]), ends[0].max(ends[1])]
        };
        let axis = axes(up)[2];
        let middle = (low + high) / 2.0;
        let foot = middle + axis * (low - middle).dot(axis);
        mesh.positions.iter_mut().for_each(|p| *p = (turn * *p - foot) * scale);

        // The materials are called by its name, so that no other model means something else by theirs.
        let mut edits = Vec::new();
        let folder = session.scene.path.parent().unwrap_or(Path::new("")).to_owned();
        for material in &mut mesh.materials {
            let known = model.materials.iter().find(|m| m.name == *material);
            let reflectance = known.map_or(DVec3::splat(0.5), |m| DVec3::from_array(m.reflectance));
            let texture = known.and_then(|m| m.texture.as_ref()).map(|t| format::path_from(&folder, t)).transpose()?;
            let taken = |own: &str, edits: &[Edit]| edits.iter().any(|edit| edit.subject() == own);
            let numbered = (2u64..).map(|n| format!("{name}, {material} ({n})"));
            let own = std::iter::once(format!("{name}, {material}"))
                .chain(numbered)
                .find(|own| session.free_material_name(own) == *own && !taken(own, &edits))
                .unwrap_or_default();
            *material = own.clone();
            edits.push(Edit::AddMaterial { name: own, reflectance, texture });
        }

        let file_name: String = name.chars().map(|c| if c.is_alphanumeric() || c == '-' || c == ' ' { c } else { '_' }).collect();
        let added = folder.join("added");
        std::fs::create_dir_all(&added).map_err(|e| SceneError::content(&added, format!("cannot be made: {e}")))?;
        let numbered = (2..).map(|n| added.join(format!("{file_name} {n}.obj")));
        let path =
            std::iter::once(added.join(format!("{file_name}.obj"))).chain(numbered).find(|p| !p.exists()).unwrap_or_default();
        write_atomically(&path, |out| write_obj(out, &[(name.clone(), &mesh)]))?;

        edits.push(Edit::Add(ObjectEntry {
            name: name.clone(),
            mesh: format::path_from(&folder, &path)?,
            part: None,
            position: self.place(session),
            rotation: DVec3::ZERO,
            on: None,
            movable: true,
            material: None,
            hidden_from_camera: false,
        }));
        if session.perform(format!("Add {name}"), edits) {
            session.selection = session.configuration.object_id(&name).ok().map(Selection::Object);
            session.messages.say(format!("Added {name}: drag it where it belongs"));
            return Ok(());
        }
        // Why was told; the file is of no use then.
        let _ = std::fs::remove_file(&path);
        Err(SceneError::Edit(format!("{name} was not added")))
    }

    /// On what is level where the camera looks, or below that.
    fn place(&self, session: &mut Session) -> DVec3 {
        let view = session.navigation.view();
        let up = axes(session.scene.up)[2];
        let world = session.world();
        let hidden = |id: usize| world.object(id).hidden_from_camera;
        let along = (view.target - view.eye).normalize();
        let ahead = meet(&world, Sight { from: view.eye, along }, hidden);
        let reach = session.configuration.reach();
        let point = match ahead {
            Some(met) if met.normal.dot(up) > 0.9 => return met.point,
            // Not quite at the wall.
            Some(met) => met.point - along * (0.3 * met.distance).min(1.0),
            None => view.eye + along * reach * 0.3,
        };
        meet(&world, Sight { from: point, along: -up }, hidden).map_or(point, |met| met.point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_guessed_from_the_size() {
        assert_eq!(
            [0.9, 2.1, 90.0, 210.0, 1800.0].map(Unit::guess),
            [Unit::Metre, Unit::Metre, Unit::Centimetre, Unit::Centimetre, Unit::Millimetre]
        );
    }
}
