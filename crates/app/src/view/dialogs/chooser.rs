//! Chooses a file, in the window itself: the same everywhere, also where there is no desktop to ask.

use super::Dialog;
use egui::{Key, ScrollArea, TextEdit, Ui};
use std::path::{Path, PathBuf};

/// What a file is chosen for.
#[derive(Debug, Clone, PartialEq)]
pub enum Purpose {
    OpenScene,
    SaveScene,
    AddObject,
    PlayMoves,
    SaveMoves,
    Texture { material: String },
    Photometry { lamp: usize },
}

/// Chooses a file.
pub struct Chooser {
    pub(super) purpose: Purpose,
    title: &'static str,
    extensions: &'static [&'static str],
    folder: PathBuf,
    /// What is typed: a name in the folder, or a path.
    typed: String,
    /// Folders, then files, in order of names; or why they cannot be listed.
    listed: Result<Vec<(String, bool)>, String>,
    saves: bool,
    fresh: bool,
    /// An existing file that would be written over: to be chosen twice.
    overwrites: Option<PathBuf>,
}

impl Chooser {
    pub(super) fn dialog(
        purpose: Purpose,
        title: &'static str,
        extensions: &'static [&'static str],
        folder: &Path,
        name: String,
    ) -> Dialog {
        let saves = matches!(purpose, Purpose::SaveScene | Purpose::SaveMoves);
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
        let listed = Ok(Vec::new());
        let mut chooser =
            Chooser { purpose, title, extensions, folder, typed: name, listed, saves, fresh: true, overwrites: None };
        chooser.list();
        Dialog::File(chooser)
    }

    fn list(&mut self) {
        let wanted = |name: &str| {
            let extension = Path::new(name).extension().and_then(|e| e.to_str()).map(str::to_lowercase);
            self.extensions.iter().any(|e| Some(*e) == extension.as_deref())
        };
        self.listed = std::fs::read_dir(&self.folder).map_err(|e| format!("{}: {e}", self.folder.display())).map(|entries| {
            let named = entries.flatten().filter_map(|entry| {
                let name = entry.file_name().to_string_lossy().into_owned();
                let folder = entry.path().is_dir();
                (!name.starts_with('.') && (folder || wanted(&name))).then_some((name, folder))
            });
            let mut named: Vec<(String, bool)> = named.collect();
            named.sort_by_key(|(name, folder)| (!folder, name.to_lowercase()));
            named
        });
    }

    fn enter(&mut self, folder: PathBuf) {
        self.folder = folder;
        if !self.saves {
            self.typed.clear();
        }
        self.list();
    }

    /// The file that is meant, once it is chosen; `None` if it is a folder, which is then entered.
    fn choose(&mut self) -> Option<PathBuf> {
        let mut path = self.folder.join(self.typed.trim());
        if path.is_dir() {
            let path = path.canonicalize().unwrap_or(path);
            self.enter(path);
            return None;
        }
        if self.saves && path.extension().is_none() {
            path.set_extension(self.extensions[0]);
        }
        if self.saves && path.exists() && self.overwrites.as_ref() != Some(&path) {
            self.overwrites = Some(path);
            return None;
        }
        (!self.typed.trim().is_empty()).then_some(path)
    }

    /// What was chosen, or `Some(None)` if nothing is to be.
    pub(super) fn ui(&mut self, ui: &mut Ui) -> Option<Option<PathBuf>> {
        let mut chosen = None;
        ui.heading(self.title);
        ui.horizontal(|ui| {
            if ui.button("Up").on_hover_text("The folder that this one is in").clicked()
                && let Some(parent) = self.folder.parent()
            {
                self.enter(parent.to_owned());
            }
            ui.add(egui::Label::new(self.folder.display().to_string()).truncate());
        });
        ScrollArea::vertical().max_height(320.0).auto_shrink([false, false]).show(ui, |ui| match self.listed.clone() {
            Err(why) => {
                ui.colored_label(ui.visuals().error_fg_color, why);
            }
            Ok(listed) => {
                if listed.is_empty() {
                    ui.weak(format!("Nothing here that ends in .{}", self.extensions.join(", .")));
                }
                for (name, folder) in listed {
                    let shown = if folder { format!("{name}/") } else { name.clone() };
                    let response = ui.selectable_label(self.typed == name, shown);
                    if response.double_clicked() && !folder {
                        self.typed = name;
                        chosen = self.choose().map(Some);
                    } else if response.clicked() {
                        if folder {
                            let folder = self.folder.join(&name);
                            self.enter(folder);
                        } else {
                            self.typed = name;
                        }
                    }
                }
            }
        });
        let edit = ui.add(TextEdit::singleline(&mut self.typed).hint_text("name or path").desired_width(f32::INFINITY));
        if std::mem::take(&mut self.fresh) {
            edit.request_focus();
        }
        if edit.changed() {
            self.overwrites = None;
        }
        let entered = edit.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
        if let Some(path) = &self.overwrites {
            ui.colored_label(ui.visuals().warn_fg_color, format!("{} is there already", path.display()));
        }
        ui.horizontal(|ui| {
            let verb = match (self.saves, self.overwrites.is_some()) {
                (true, true) => "Replace it",
                (true, false) => "Save",
                (false, _) => "Open",
            };
            if ui.button(verb).clicked() || entered {
                chosen = self.choose().map(Some);
                if chosen.is_none() {
                    edit.request_focus();
                }
            }
            if ui.button("Cancel").clicked() {
                chosen = Some(None);
            }
        });
        chosen
    }
}
