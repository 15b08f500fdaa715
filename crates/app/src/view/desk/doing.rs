//! What commands do, and files that are dropped.

use super::{Desk, Request};
use crate::{
    frames::Show,
    view::{
        commands::Command,
        dialogs::{self, Dialog},
        navigation::axes,
        panels, pick,
        session::Selection,
        viewport,
    },
};
use glam::DVec3;
use lightmend_scene::{Edit, SceneError};
use std::path::PathBuf;

impl Desk {
    /// Whether a command would do anything.
    pub(super) fn can(&self, command: Command) -> bool {
        match command {
            Command::Undo => self.session.history.last_done().is_some(),
            Command::Redo => self.session.history.last_undone().is_some(),
            Command::Duplicate | Command::Delete | Command::Face => self.session.selection.is_some(),
            Command::TurnLeft | Command::TurnRight | Command::TurnLeftFine | Command::TurnRightFine => {
                matches!(self.session.selection, Some(Selection::Object(id)) if self.session.configuration.object(id).movable)
            }
            Command::Raise | Command::Lower => match self.session.selection {
                Some(Selection::Object(id)) => self.session.configuration.object(id).movable,
                selection => selection.is_some(),
            },
            Command::SwitchLamp => matches!(self.session.selection, Some(Selection::Lamp(_))),
            Command::StopScript => self.session.playback.is_some(),
            _ => true,
        }
    }

    /// Does a command.
    pub fn run(&mut self, command: Command) {
        if !self.can(command) {
            return;
        }
        match command {
            Command::OpenScene => self.dialog = Some(Dialog::open_scene(&self.session)),
            Command::Save => {
                let path = self.session.path.clone();
                let saved = self.session.save(&path);
                self.told(saved);
            }
            Command::SaveAs => self.dialog = Some(Dialog::save_scene(&self.session)),
            Command::AddObject => self.dialog = Some(Dialog::add_object(&self.session)),
            Command::PlayScript => self.dialog = Some(Dialog::play(&self.session)),
            Command::StopScript => self.session.stop_playing(),
            Command::SaveRecording => self.dialog = Some(Dialog::save_moves(&self.session)),
            Command::Picture => self.picture("png"),
            Command::PictureExr => self.picture("exr"),
            Command::Quit => self.quit(),
            Command::Undo => {
                self.viewport.let_go(&mut self.session);
                self.session.undo();
            }
            Command::Redo => {
                self.viewport.let_go(&mut self.session);
                self.session.redo();
            }
            Command::Duplicate => self.duplicate(),
            Command::Delete => self.delete(),
            Command::Deselect => {
                if !self.viewport.put_back(&mut self.session) {
                    self.session.selection = None;
                }
            }
            Command::TurnLeft => self.turn(15.0),
            Command::TurnRight => self.turn(-15.0),
            Command::TurnLeftFine => self.turn(1.0),
            Command::TurnRightFine => self.turn(-1.0),
            Command::Raise => self.nudge(axes(self.session.scene.up)[2] * 0.05),
            Command::Lower => self.nudge(axes(self.session.scene.up)[2] * -0.05),
            Command::Snapping => {
                self.session.snapping = !self.session.snapping;
                let how = if self.session.snapping { "keep to floor and walls" } else { "go anywhere" };
                self.session.messages.say(format!("Dragged objects {how}"));
            }
            Command::SwitchLamp => {
                if let Some(Selection::Lamp(id)) = self.session.selection {
                    panels::switch(&mut self.session, id);
                }
            }
            Command::Radiance => self.look_at(Show::Radiance),
            Command::Illuminance => self.look_at(Show::Illuminance),
            Command::Indirect => self.look_at(Show::Indirect),
            Command::Elements => self.look_at(Show::Elements),
            Command::Stale => self.look_at(Show::Stale),
            Command::Face => self.face(),
            Command::FullScreen => self.requests.push(Request::FullScreen),
            Command::RestartGraphics => self.requests.push(Request::RestartGraphics),
            Command::Pause => {
                let mut controls = self.session.solver.controls();
                controls.paused = !controls.paused;
                self.session.solver.control(controls);
                self.session.light.nudge();
            }
            Command::StartOver => {
                self.session.start_over();
            }
            Command::Help => self.dialog = Some(Dialog::Help),
        }
    }

    /// What was wrong is told.
    pub fn told(&mut self, result: Result<(), SceneError>) {
        if let Err(error) = result {
            self.session.messages.fail(error.to_string());
        }
    }

    /// The end, once what is not saved was asked for.
    pub fn quit(&mut self) {
        // What was kept of an earlier run stays where it is, for the next one to ask.
        let asked = matches!(self.dialog, Some(Dialog::Kept { .. }));
        if self.session.is_changed() && !asked {
            self.dialog = Some(Dialog::Unsaved(Request::Quit { thrown_away: false }));
        } else {
            self.requests.push(Request::Quit { thrown_away: false });
        }
    }

    pub(super) fn look_at(&mut self, show: Show) {
        self.show = show;
        self.found_range = None;
        self.range = None;
        self.session.light.show(show);
    }

    /// A picture beside the scene file, under a name that is free.
    pub(super) fn picture(&mut self, extension: &str) {
        let stem = self.session.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let path = loop {
            self.pictures += 1;
            let path = self.session.path.with_file_name(format!("{stem}-{:03}.{extension}", self.pictures));
            if !path.exists() {
                break path;
            }
        };
        self.requests.push(Request::Picture { path, exr: extension == "exr" });
    }

    pub(super) fn duplicate(&mut self) {
        let up = axes(self.session.scene.up);
        match self.session.selection {
            Some(Selection::Object(id)) => {
                let object = self.session.configuration.object(id);
                let name = self.session.free_object_name(&object.name);
                // Beside it, not in it.
                let [low, high] = pick::bounds(&self.session.configuration, id);
                let aside = up[0] * ((high - low).dot(up[0]).abs() + 0.1);
                let carrier = pick::carrier_motion(&self.session.configuration, object.carrier);
                let to = object.pose.position + carrier.rotation.transpose() * aside;
                let edit = Edit::Duplicate { object: object.name.clone(), name: name.clone(), to };
                if self.session.perform(format!("Duplicate {}", object.name.clone()), vec![edit]) {
                    self.session.selection = self.session.configuration.object_id(&name).ok().map(Selection::Object);
                }
            }
            Some(Selection::Lamp(id)) => {
                let lamp = self.session.configuration.lamp(id);
                let name = self.session.free_lamp_name(&lamp.name);
                let to = lamp.pose.position + up[0] * 0.3;
                let edit = Edit::DuplicateLamp { lamp: lamp.name.clone(), name: name.clone(), to };
                if self.session.perform(format!("Duplicate lamp {}", lamp.name.clone()), vec![edit]) {
                    let found = self.session.configuration.lamps().find(|(_, lamp)| lamp.name == name).map(|(id, _)| id);
                    self.session.selection = found.map(Selection::Lamp);
                }
            }
            None => {}
        }
    }

    pub(super) fn delete(&mut self) {
        self.viewport.let_go(&mut self.session);
        match self.session.selection {
            Some(Selection::Object(id)) => {
                let name = self.session.configuration.object(id).name.clone();
                self.session.perform(format!("Delete {name}"), vec![Edit::Remove { object: name }]);
            }
            Some(Selection::Lamp(id)) => {
                let name = self.session.configuration.lamp(id).name.clone();
                self.session.perform(format!("Delete lamp {name}"), vec![Edit::RemoveLamp { lamp: name }]);
            }
            None => {}
        }
    }

    pub(super) fn turn(&mut self, by: f64) {
        if let Some(Selection::Object(id)) = self.session.selection {
            viewport::turn(&mut self.session, id, by, false);
        }
    }

    pub(super) fn nudge(&mut self, step: DVec3) {
        match self.session.selection {
            Some(Selection::Object(id)) if self.session.configuration.object(id).movable => {
                viewport::nudge(&mut self.session, id, step);
            }
            Some(Selection::Lamp(id)) => viewport::move_lamp(&mut self.session, id, step),
            _ => {}
        }
    }

    pub(super) fn face(&mut self) {
        match self.session.selection {
            Some(Selection::Object(id)) => {
                let [low, high] = pick::bounds(&self.session.configuration, id);
                self.session.navigation.face((low + high) / 2.0, (high - low).length() / 2.0);
            }
            Some(Selection::Lamp(id)) => {
                self.session.navigation.face(self.session.configuration.lamp_motion(id).translation, 0.3);
            }
            None => {}
        }
    }

    /// A file was dropped on the window.
    pub(super) fn drop_file(&mut self, path: PathBuf) {
        if self.dialog.is_some() {
            return self.session.messages.fail("answer the question first, then drop it again".into());
        }
        match path.extension().and_then(|e| e.to_str()).map(str::to_lowercase).as_deref() {
            Some("obj") => self.dialog = Some(Dialog::chosen_object(&self.session, path)),
            Some("ies") => match self.session.selection {
                Some(Selection::Lamp(id)) => panels::relamp(&mut self.session, id, Some(&path)),
                _ => self.session.messages.fail("select the lamp first that the photometric file is for".into()),
            },
            Some("ron") => dialogs::open(self, &path),
            _ => self.session.messages.fail(format!("{}: an OBJ, IES or scene file can be dropped here", path.display())),
        }
    }
}
