//! What is in the window: the room, menus, panels, dialogs. It knows of egui, but of no window and no graphics device, so all of it can be
//! tried with made-up events.

mod doing;
mod painting;

use super::{
    commands::{self, Command, Entry, Menu, TABLE},
    dialogs::{self, Dialog},
    navigation::axes,
    panels,
    session::Session,
    viewport::Viewport,
};
use crate::frames::{Range, Show};
use egui::{Color32, Key, Pos2, Rect, Ui, vec2};
use lightmend_raster::Times;
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
            Some(ready) if self.session.is_exact(&ready.snapshot) => "exact".to_owned(),
            Some(ready) if self.session.is_complete_for_the_eye(&ready) => "complete for the eye".to_owned(),
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
