//! Questions, and files to choose, in the window itself: the same everywhere, also where there is no desktop to ask.

mod chooser;

use super::{
    autosave,
    commands::{MOUSE, Menu, TABLE},
    desk::{Desk, Request},
    furnish::{Model, Unit},
    session::Session,
};
use chooser::{Chooser, Purpose};
use egui::{Context, Grid, Id, Modal, ScrollArea, Ui};
use lightmend_scene::{Edit, format};
use std::path::{Path, PathBuf};

/// What is asked.
pub enum Dialog {
    /// Keys and mouse.
    Help,
    /// Something is not saved, before this is done.
    Unsaved(Request),
    /// There is an autosave of an earlier run.
    Kept { scene: PathBuf, autosave: PathBuf },
    /// A file.
    File(Chooser),
    /// How a model is to be taken.
    Model(Box<Model>),
}

fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

impl Dialog {
    /// For another scene.
    pub fn open_scene(session: &Session) -> Dialog {
        Chooser::dialog(Purpose::OpenScene, "Open a scene", &["ron"], folder_of(&session.path), String::new())
    }

    /// For saving under another name.
    pub fn save_scene(session: &Session) -> Dialog {
        let name = session.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Chooser::dialog(Purpose::SaveScene, "Save the scene as", &["ron"], folder_of(&session.path), name)
    }

    /// For a model.
    pub fn add_object(session: &Session) -> Dialog {
        Chooser::dialog(Purpose::AddObject, "Add an object", &["obj"], folder_of(&session.path), String::new())
    }

    /// For a script.
    pub fn play(session: &Session) -> Dialog {
        let moves = folder_of(&session.path).join("moves");
        let folder = if moves.is_dir() { &moves } else { folder_of(&session.path) };
        Chooser::dialog(Purpose::PlayMoves, "Play moves", &["ron"], folder, String::new())
    }

    /// For what was done.
    pub fn save_moves(session: &Session) -> Dialog {
        let stem = session.path.file_stem().unwrap_or_default().to_string_lossy();
        Chooser::dialog(
            Purpose::SaveMoves,
            "Save what was done as moves",
            &["ron"],
            folder_of(&session.path),
            format!("{stem}-moves.ron"),
        )
    }

    /// For a material.
    pub fn texture(session: &Session, material: &str) -> Dialog {
        let purpose = Purpose::Texture { material: material.to_owned() };
        Chooser::dialog(purpose, "A texture", &["png", "jpg", "jpeg"], folder_of(&session.path), String::new())
    }

    /// For a lamp.
    pub fn photometry(session: &Session, lamp: usize) -> Dialog {
        // Where the lamp's present file is, there are probably more.
        let present =
            session.configuration.lamp(lamp).entry.photometry.as_deref().map(|file| folder_of(&session.scene.path).join(file));
        let ies = folder_of(&session.path).join("ies");
        let folder = match &present {
            Some(file) => folder_of(file).to_owned(),
            None if ies.is_dir() => ies,
            None => folder_of(&session.path).to_owned(),
        };
        Chooser::dialog(Purpose::Photometry { lamp }, "A photometric file", &["ies"], &folder, String::new())
    }

    /// For a model that was chosen already.
    pub fn chosen_object(session: &Session, path: PathBuf) -> Dialog {
        Dialog::Model(Box::new(Model::read(session, &path)))
    }
}

/// What was asked is shown, and what was answered is done.
pub fn show(desk: &mut Desk, ctx: &Context) {
    let Some(mut dialog) = desk.dialog.take() else { return };
    let mut closes = false;
    let modal = Modal::new(Id::unique("dialog")).show(ctx, |ui| {
        ui.set_width(460.0);
        closes = match &mut dialog {
            Dialog::Help => help(ui),
            Dialog::Unsaved(then) => unsaved(desk, ui, then),
            Dialog::Kept { scene, autosave } => kept(desk, ui, scene, autosave),
            Dialog::Model(model) => model.ui(&mut desk.session, ui),
            Dialog::File(chooser) => match chooser.ui(ui) {
                None => false,
                Some(None) => true,
                Some(Some(path)) => {
                    let purpose = chooser.purpose.clone();
                    chosen(desk, purpose, &path);
                    true
                }
            },
        };
    });
    // Escape and a click beside it mean "no"; but what was kept needs an answer.
    let dismissed = modal.should_close() && !matches!(dialog, Dialog::Kept { .. });
    if !closes && !dismissed && desk.dialog.is_none() {
        desk.dialog = Some(dialog);
    }
}

fn chosen(desk: &mut Desk, purpose: Purpose, path: &Path) {
    match purpose {
        Purpose::OpenScene => open(desk, path),
        Purpose::SaveScene => {
            let saved = desk.session.save(path);
            desk.told(saved);
        }
        Purpose::AddObject => desk.dialog = Some(Dialog::chosen_object(&desk.session, path.to_owned())),
        Purpose::PlayMoves => {
            let playing = desk.session.play(path);
            desk.told(playing);
        }
        Purpose::SaveMoves => match desk.session.write_recording(path) {
            Ok(()) => desk.session.messages.say(format!("Saved: {}", path.display())),
            Err(error) => desk.session.messages.fail(error.to_string()),
        },
        Purpose::Texture { material } => {
            let folder = folder_of(&desk.session.scene.path).to_owned();
            match format::path_from(&folder, path) {
                Ok(texture) => {
                    let title = format!("Texture of {material}");
                    desk.session.perform(title, vec![Edit::Texture { material, texture: Some(texture) }]);
                }
                Err(error) => desk.session.messages.fail(error.to_string()),
            }
        }
        Purpose::Photometry { lamp } if desk.session.configuration.has_lamp(lamp) => {
            super::panels::relamp(&mut desk.session, lamp, Some(path));
        }
        Purpose::Photometry { .. } => {}
    }
}

/// Another scene instead of this one, once what is not saved was asked for.
pub fn open(desk: &mut Desk, path: &Path) {
    let request = Request::Open { scene: path.to_owned(), save_as: path.to_owned(), thrown_away: false };
    if desk.session.is_changed() {
        desk.dialog = Some(Dialog::Unsaved(request));
    } else {
        desk.requests.push(request);
    }
}

fn help(ui: &mut Ui) -> bool {
    ui.heading("Keys and mouse");
    ScrollArea::vertical().max_height(420.0).show(ui, |ui| {
        Grid::new("mouse").num_columns(2).striped(true).show(ui, |ui| {
            for (what, does) in MOUSE {
                ui.strong(what);
                ui.label(does);
                ui.end_row();
            }
            for menu in Menu::ALL {
                for entry in TABLE.iter().filter(|e| e.menu == menu) {
                    if let Some(key) = entry.key {
                        ui.strong(ui.ctx().format_shortcut(&key));
                        ui.label(entry.title).on_hover_text(entry.hint);
                        ui.end_row();
                    }
                }
            }
        });
    });
    ui.button("Close").clicked()
}

fn unsaved(desk: &mut Desk, ui: &mut Ui, then: &Request) -> bool {
    let name = desk.session.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    ui.heading(format!("{name} was changed"));
    ui.label("Save the changes?");
    let mut answered = false;
    ui.horizontal(|ui| {
        let button = ui.button("Save");
        if ui.memory(|m| m.focused().is_none()) {
            button.request_focus();
        }
        let save = button.clicked();
        let path = desk.session.path.clone();
        if save {
            let saved = desk.session.save(&path);
            answered = true;
            if saved.is_ok() {
                desk.requests.push(then.clone());
            }
            desk.told(saved);
        } else if ui.button("Throw them away").clicked() {
            desk.requests.push(match then.clone() {
                Request::Open { scene, save_as, .. } => Request::Open { scene, save_as, thrown_away: true },
                Request::Quit { .. } => Request::Quit { thrown_away: true },
                other => other,
            });
            answered = true;
        } else if ui.button("Cancel").clicked() {
            answered = true;
        }
    });
    answered
}

fn kept(desk: &mut Desk, ui: &mut Ui, scene: &Path, autosave: &Path) -> bool {
    ui.heading("Changes of an earlier run were kept");
    ui.label(format!("{} holds what was not saved when the program ended.", autosave.display()));
    let mut answered = false;
    ui.horizontal(|ui| {
        if ui.button("Go on with them").on_hover_text("Nothing is written to the scene's file until it is saved").clicked() {
            let request = Request::Open { scene: autosave.to_owned(), save_as: scene.to_owned(), thrown_away: false };
            desk.requests.push(request);
            answered = true;
        } else if ui.button("Throw them away").clicked() {
            desk.session.forget_earlier();
            answered = true;
        }
    });
    answered
}

/// The question about an autosave of an earlier run, if there is one.
pub fn kept_before(scene: &Path) -> Option<Dialog> {
    autosave::earlier(scene).map(|autosave| Dialog::Kept { scene: scene.to_owned(), autosave })
}

/// Units that models come in, for a list.
pub fn unit_list(ui: &mut Ui, unit: &mut Unit) {
    for choice in Unit::ALL {
        ui.selectable_value(unit, choice, choice.name());
    }
}
