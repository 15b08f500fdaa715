//! What is in the window: the room, menus, panels, dialogs. It knows of egui, but of no window and no graphics device, so all of it can be
//! tried with made-up events.

use super::{
    commands::{self, Command, Entry, Menu, TABLE},
    dialogs::{self, Dialog},
    messages::Kind,
    navigation::axes,
    panels,
    session::{Selection, Session},
    viewport::{self, Viewport},
};
use crate::frames::{Range, Show};
use egui::{Align2, Color32, FontId, Key, Pos2, Rect, Stroke, Ui, vec2};
use glam::DVec3;
use lightmend_raster::Times;
use lightmend_scene::{Edit, SceneError};
use std::path::PathBuf;

/// What only the window can do.
#[derive(Debug, Clone, PartialEq)]
pub enum Request {
    /// Write what is seen.
    Picture { path: PathBuf, exr: bool },
    /// Another scene instead of this one. `save_as` is where Save writes; `thrown_away` says that what is not saved of this one is.
    Open { scene: PathBuf, save_as: PathBuf, thrown_away: bool },
    /// Full screen, and back.
    FullScreen,
    /// Take the graphics device anew.
    RestartGraphics,
    /// The end; `thrown_away` says that what is not saved is.
    Quit { thrown_away: bool },
}

/// How frames come along.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Pace {
    /// Frames per second over the last second; 0 while nothing needs to be drawn.
    pub fps: f64,
    /// Of the passes of the last frame that was drawn, milliseconds.
    pub times: Times,
    /// What the desk did before it, milliseconds.
    pub desk: f64,
    /// What showing it took, with the panels, milliseconds.
    pub showing: f64,
    /// Of that frame as a whole, milliseconds.
    pub frame: f64,
    /// The longest of the last hundred, milliseconds.
    pub longest: f64,
    /// Pixels that were drawn.
    pub pixels: [u32; 2],
    /// Samples a pixel.
    pub samples: u32,
}

/// What is in the window.
pub struct Desk {
    /// The room.
    pub session: Session,
    /// Its part of the window.
    pub viewport: Viewport,
    /// What is drawn.
    pub show: Show,
    /// Values of the first and the last false colour; nothing: as it suits.
    pub range: Option<Range>,
    /// The range that was found to suit.
    pub found_range: Option<Range>,
    /// EV100; nothing: as it suits.
    pub exposure: Option<f32>,
    /// Frames per second that are wanted.
    pub fps: f64,
    /// What is asked of the window.
    pub requests: Vec<Request>,
    /// How frames come along.
    pub pace: Pace,
    /// The driver that draws.
    pub driver: String,
    /// A question, or a file that is being chosen.
    pub dialog: Option<Dialog>,
    /// Photons and rays a second.
    pub rates: panels::Rates,
    pictures: u32,
    /// A text was being typed in the frame before.
    typed: bool,
    /// Somebody walked in the frame before.
    walked: bool,
}

impl Desk {
    /// With a scene on it.
    pub fn new(session: Session, show: Show, fps: f64) -> Desk {
        session.light.show(show);
        Desk {
            session,
            viewport: Viewport::default(),
            show,
            range: None,
            found_range: None,
            exposure: None,
            fps,
            requests: Vec::new(),
            pace: Pace::default(),
            driver: String::new(),
            dialog: None,
            rates: panels::Rates::default(),
            pictures: 0,
            typed: false,
            walked: false,
        }
    }

    /// All of it; `seconds` since the frame before. Returns whether one walks.
    pub fn ui(&mut self, ui: &mut Ui, seconds: f64) -> bool {
        let ctx = ui.ctx().clone();
        let dropped = ctx.input(|input| input.raw.dropped_files.clone());
        for file in dropped {
            self.drop_file(file.path().to_owned());
        }
        let typing = ctx.egui_wants_keyboard_input();
        // Escape ends typing before anyone is told of it: it means no more than that.
        let busy = typing || std::mem::replace(&mut self.typed, typing) || egui::Popup::is_any_open(&ctx);
        if self.dialog.is_none() {
            for command in commands::pressed(&ctx, busy) {
                self.run(command);
            }
        }
        egui::Panel::top("menus").show(ui, |ui| egui::MenuBar::new().ui(ui, |ui| self.menus(ui)));
        egui::Panel::bottom("state").show(ui, |ui| panels::state_line(self, ui));
        egui::Panel::right("panel").default_size(290.0).size_range(200.0..=560.0).show(ui, |ui| {
            egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| panels::all(self, ui));
        });
        let mut walks = false;
        egui::CentralPanel::no_frame().show(ui, |ui| {
            self.viewport.rect = ui.max_rect();
            walks = self.room(ui, seconds);
        });
        dialogs::show(self, &ctx);
        self.session.tick();
        walks
    }

    fn menus(&mut self, ui: &mut Ui) {
        for menu in Menu::ALL {
            ui.menu_button(menu.title(), |ui| {
                ui.set_min_width(210.0);
                for entry in TABLE.iter().filter(|e| e.menu == menu) {
                    self.menu_entry(ui, entry);
                }
                if menu == Menu::View {
                    ui.separator();
                    self.cameras(ui);
                }
            });
        }
    }

    fn menu_entry(&mut self, ui: &mut Ui, entry: &Entry) {
        let title = match entry.command {
            Command::Undo => self.session.history.last_done().map_or("Undo".into(), |what| format!("Undo: {what}")),
            Command::Redo => self.session.history.last_undone().map_or("Redo".into(), |what| format!("Redo: {what}")),
            Command::Pause if self.session.solver.controls().paused => "Go on repairing".into(),
            _ => entry.title.to_owned(),
        };
        let chosen = match entry.command {
            Command::Snapping => self.session.snapping,
            Command::Radiance => self.show == Show::Radiance,
            Command::Illuminance => self.show == Show::Illuminance,
            Command::Indirect => self.show == Show::Indirect,
            Command::Elements => self.show == Show::Elements,
            Command::Stale => self.show == Show::Stale,
            Command::Pause => self.session.solver.controls().paused,
            _ => false,
        };
        let mut button = egui::Button::new(title).selected(chosen);
        if let Some(key) = entry.key {
            button = button.shortcut_text(ui.ctx().format_shortcut(&key));
        }
        if ui.add_enabled(self.can(entry.command), button).on_hover_text(entry.hint).clicked() {
            self.run(entry.command);
            ui.close();
        }
    }

    fn cameras(&mut self, ui: &mut Ui) {
        let cameras = self.session.scene.cameras.clone();
        if cameras.is_empty() {
            ui.weak("The scene has no cameras");
        }
        for (n, (name, view)) in cameras.iter().enumerate() {
            let key = if n < 9 { (n + 1).to_string() } else { String::new() };
            let button = egui::Button::new(format!("Camera: {name}")).shortcut_text(key);
            if ui.add(button).clicked() {
                self.session.navigation.set(*view);
                ui.close();
            }
        }
    }

    /// Whether a command would do anything.
    fn can(&self, command: Command) -> bool {
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

    fn look_at(&mut self, show: Show) {
        self.show = show;
        self.found_range = None;
        self.range = None;
        self.session.light.show(show);
    }

    /// A picture beside the scene file, under a name that is free.
    fn picture(&mut self, extension: &str) {
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

    fn duplicate(&mut self) {
        let up = axes(self.session.scene.up);
        match self.session.selection {
            Some(Selection::Object(id)) => {
                let object = self.session.configuration.object(id);
                let name = self.session.free_object_name(&object.name);
                // Beside it, not in it.
                let [low, high] = super::pick::bounds(&self.session.configuration, id);
                let aside = up[0] * ((high - low).dot(up[0]).abs() + 0.1);
                let carrier = super::pick::carrier_motion(&self.session.configuration, object.carrier);
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

    fn delete(&mut self) {
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

    fn turn(&mut self, by: f64) {
        if let Some(Selection::Object(id)) = self.session.selection {
            viewport::turn(&mut self.session, id, by, false);
        }
    }

    fn nudge(&mut self, step: DVec3) {
        match self.session.selection {
            Some(Selection::Object(id)) if self.session.configuration.object(id).movable => {
                viewport::nudge(&mut self.session, id, step);
            }
            Some(Selection::Lamp(id)) => viewport::move_lamp(&mut self.session, id, step),
            _ => {}
        }
    }

    fn face(&mut self) {
        match self.session.selection {
            Some(Selection::Object(id)) => {
                let [low, high] = super::pick::bounds(&self.session.configuration, id);
                self.session.navigation.face((low + high) / 2.0, (high - low).length() / 2.0);
            }
            Some(Selection::Lamp(id)) => {
                self.session.navigation.face(self.session.configuration.lamp_motion(id).translation, 0.3);
            }
            None => {}
        }
    }

    /// A file was dropped on the window.
    fn drop_file(&mut self, path: PathBuf) {
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

    /// The room: mouse and keys, marks of lamps, messages. Returns whether one walks.
    fn room(&mut self, ui: &mut Ui, seconds: f64) -> bool {
        let ctx = ui.ctx().clone();
        let rect = self.viewport.rect;
        let blocked = self.dialog.is_some() || egui::Popup::is_any_open(&ctx);
        let panels = ui.layer_id();
        // The panel's edge is pulled from both sides of it.
        let grip = ctx.global_style().interaction.resize_grab_radius_side + 1.0;
        let inner = Rect::from_min_max(rect.min, rect.max - vec2(grip, 0.0));
        let free = |at: Pos2| !blocked && inner.contains(at) && ctx.layer_id_at(at).is_none_or(|layer| layer == panels);
        let (events, pointer, modifiers) = ctx.input(|i| (i.events.clone(), i.pointer.latest_pos(), i.modifiers));
        self.viewport.hold(modifiers);
        self.viewport.take(&mut self.session, &events, &free);
        self.viewport.hover(&mut self.session, pointer, &free);
        let mut walks = false;
        if self.dialog.is_none() && !ctx.egui_wants_keyboard_input() {
            // The first step is no longer than a frame, however long nothing was drawn before it.
            let seconds = seconds.min(if self.walked { 0.2 } else { 1.0 / self.fps });
            walks = ctx.input(|i| {
                let down = |key: Key| !i.modifiers.command && i.key_down(key);
                self.viewport.walk(&mut self.session, &down, i.modifiers.shift, seconds)
            });
            self.plain_keys(&ctx);
        }
        self.walked = walks;
        if self.session.history.is_open()
            && self.session.playback.is_none()
            && !self.viewport.is_busy()
            && !ctx.input(|i| i.pointer.any_down())
            && !nudging(&ctx)
        {
            // A slider was let go, or a row of turns is over.
            self.session.end();
        }
        self.marks(ui);
        self.messages(ui);
        walks
    }

    /// Cameras by number, and steps by arrow keys.
    fn plain_keys(&mut self, ctx: &egui::Context) {
        let digits = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];
        for (n, key) in digits.into_iter().enumerate() {
            if ctx.input(|i| i.modifiers.is_none() && i.key_pressed(key))
                && let Some((_, view)) = self.session.scene.cameras.get(n)
            {
                self.session.navigation.set(*view);
            }
        }
        let view = self.session.navigation.view();
        let [_, right, _] = view.axes(self.session.scene.up);
        let [e, n, up] = axes(self.session.scene.up);
        // Along the axis of the room that is most to the right in the picture, so that what is in line stays in line.
        let right = if right.dot(e).abs() >= right.dot(n).abs() { e * right.dot(e).signum() } else { n * right.dot(n).signum() };
        let away = up.cross(right);
        let keys = [(Key::ArrowRight, right), (Key::ArrowLeft, -right), (Key::ArrowUp, away), (Key::ArrowDown, -away)];
        for (key, way) in keys {
            let (times, fine) = ctx.input(|i| (i.num_presses(key), i.modifiers.shift));
            if times > 0 {
                self.nudge(way * times as f64 * if fine { 0.01 } else { 0.05 });
            }
        }
    }

    /// Lamps, as what can be clicked.
    fn marks(&mut self, ui: &Ui) {
        let painter = ui.painter_at(self.viewport.rect);
        for mark in self.viewport.marks(&mut self.session) {
            let lamp = self.session.configuration.lamp(mark.lamp);
            let selected = self.session.selection == Some(Selection::Lamp(mark.lamp));
            let hovered = self.viewport.hovered == Some(Selection::Lamp(mark.lamp));
            if !mark.near && !selected {
                continue;
            }
            let colour = if lamp.lit { panels::screen_colour(lamp.intensity) } else { Color32::from_gray(70) };
            painter.circle(mark.at, 5.0, colour, Stroke::new(1.5, Color32::from_black_alpha(200)));
            for n in 0..8 {
                let ray = egui::Vec2::angled(n as f32 * std::f32::consts::TAU / 8.0);
                painter.line_segment([mark.at + ray * 7.0, mark.at + ray * 10.0], Stroke::new(1.5, colour));
            }
            if selected || hovered {
                painter.circle_stroke(mark.at, 12.0, Stroke::new(2.0, SELECTED));
                painter.text(
                    mark.at + vec2(16.0, 0.0),
                    Align2::LEFT_CENTER,
                    &lamp.name,
                    FontId::proportional(13.0),
                    Color32::WHITE,
                );
            }
        }
    }

    /// What the program has to say, over the room; nothing that can be clicked.
    fn messages(&mut self, ui: &Ui) {
        let painter = ui.painter_at(self.viewport.rect);
        let mut bottom = self.viewport.rect.left_bottom() + vec2(12.0, -12.0);
        let width = (self.viewport.rect.width() - 40.0).max(10.0);
        if let Some(rest) = self.session.messages.next_goes_in() {
            ui.ctx().request_repaint_after(rest);
        }
        let shown: Vec<(Kind, String)> = self.session.messages.current().map(|(kind, text)| (kind, text.to_owned())).collect();
        for (kind, text) in shown.into_iter().rev() {
            let colour = match kind {
                Kind::Note => Color32::from_gray(235),
                Kind::Warning => Color32::from_rgb(255, 205, 110),
                Kind::Failure => Color32::from_rgb(255, 140, 120),
            };
            let text = painter.layout(text, FontId::proportional(14.0), colour, width);
            let place = Rect::from_min_size(bottom - vec2(0.0, text.size().y), text.size());
            painter.rect_filled(place.expand(6.0), 4.0, Color32::from_black_alpha(190));
            painter.galley(place.min, text, colour);
            bottom.y = place.min.y - 16.0;
        }
    }

    /// Another scene on the desk; the rest stays as it is set.
    pub fn take(&mut self, mut session: Session) {
        // What was held belongs to the scene that goes.
        self.viewport.let_go(&mut self.session);
        self.viewport.hovered = None;
        self.dialog = None;
        session.light.show(self.show);
        session.snapping = self.session.snapping;
        session.solver.control(self.session.solver.controls());
        self.session = session;
        self.found_range = None;
        self.rates = panels::Rates::default();
    }

    /// What the window is called: the scene, whether it is saved, and how its light is.
    pub fn title(&self) -> String {
        let name = self.session.path.file_name().unwrap_or_default().to_string_lossy();
        let changed = if self.session.is_changed() { "*" } else { "" };
        let light = match self.session.light.ready() {
            Some(ready) if ready.snapshot.exact && ready.snapshot.edits >= self.session.edits() => "exact".to_owned(),
            Some(ready) if self.session.solver.controls().paused => {
                format!("paused, {:.0} % outstanding", panels::outstanding_percent(&ready))
            }
            Some(ready) => format!("{:.0} % outstanding", panels::outstanding_percent(&ready)),
            None => "no light yet".to_owned(),
        };
        format!("{name}{changed} — {light} — Lightmend")
    }
}

/// The colour of what is selected.
pub const SELECTED: Color32 = Color32::from_rgb(255, 160, 40);

/// The colour of what the pointer is over.
pub const HOVERED: Color32 = Color32::from_rgb(235, 235, 235);

/// Whether keys are held that move or turn what is selected: one action until they are let go.
fn nudging(ctx: &egui::Context) -> bool {
    let keys = [Key::ArrowLeft, Key::ArrowRight, Key::ArrowUp, Key::ArrowDown, Key::PageUp, Key::PageDown, Key::R, Key::T];
    ctx.input(|i| keys.into_iter().any(|key| i.key_down(key)))
}
