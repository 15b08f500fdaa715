//! A desk for tests, with made-up events, as mice, keyboards and clumsy hands send them; no window is needed.

use super::{
    desk::Desk,
    session::{Selection, Session, Start},
};
use crate::frames::Show;
use egui::{Context, Event, Key, Modifiers, PointerButton, Pos2, RawInput, Rect, vec2};
use glam::DVec3;
use lightmend_photon::{halton::Scrambling, pool::Pool, solver::Controls};
use lightmend_scene::{Configuration, Moves, Scene};
use std::path::Path;

/// A desk with the ROOM on it, in a folder of its own.
pub struct Trial {
    pub desk: Desk,
    pub context: Context,
    pub size: egui::Vec2,
    time: f64,
    pub folder: tempfile::TempDir,
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().flatten() {
        match entry.file_type().unwrap().is_dir() {
            true => copy(&entry.path(), &to.join(entry.file_name())),
            false => assert!(std::fs::copy(entry.path(), to.join(entry.file_name())).is_ok()),
        }
    }
}

pub fn start() -> Start {
    let pool = Pool::new(20_000, 288, 4, Scrambling::Seed(1)).unwrap();
    Start { pool, ledger_bytes: 1 << 30, threads: 1, controls: Controls::default() }
}

impl Trial {
    pub fn new() -> Trial {
        Trial::after(|_| {})
    }

    /// After something was done in the folder.
    pub fn after(before: impl FnOnce(&Path)) -> Trial {
        let folder = tempfile::tempdir().unwrap();
        copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/room"), folder.path());
        before(folder.path());
        let path = folder.path().join("room.ron");
        let scene = Scene::read(&path).unwrap().0;
        let session = Session::start(scene, path, start(), || {}).unwrap();
        let desk = Desk::new(session, Show::Radiance, 20.0);
        let mut trial = Trial { desk, context: Context::default(), size: vec2(1280.0, 800.0), time: 0.0, folder };
        trial.frame([]);
        trial.frame([]);
        trial
    }

    pub fn frame(&mut self, events: impl IntoIterator<Item = Event>) {
        self.time += 0.05;
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, self.size)),
            time: Some(self.time),
            events: events.into_iter().collect(),
            focused: true,
            ..RawInput::default()
        };
        let desk = &mut self.desk;
        let output = self.context.run_ui(input, |ui| {
            desk.ui(ui, 0.05);
        });
        output.drop_without_applying_deltas();
    }

    pub fn button(at: Pos2, button: PointerButton, pressed: bool) -> Event {
        Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE }
    }

    pub fn press(&mut self, at: Pos2, button: PointerButton) {
        self.frame([Event::PointerMoved(at)]);
        self.frame([Trial::button(at, button, true)]);
    }

    pub fn point(&mut self, at: Pos2) {
        self.frame([Event::PointerMoved(at)]);
    }

    pub fn release(&mut self, at: Pos2, button: PointerButton) {
        self.frame([Trial::button(at, button, false)]);
    }

    pub fn drag(&mut self, from: Pos2, to: Pos2) {
        self.press(from, PointerButton::Primary);
        for step in 1..=8 {
            self.point(from + (to - from) * (step as f32 / 8.0));
        }
        self.release(to, PointerButton::Primary);
    }

    pub fn click(&mut self, at: Pos2) {
        self.press(at, PointerButton::Primary);
        self.release(at, PointerButton::Primary);
    }

    pub fn key(&mut self, key: Key, modifiers: Modifiers) {
        let event = |pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
        self.frame([Event::PointerGone, event(true)]);
        self.frame([event(false)]);
    }

    pub fn id(&self, name: &str) -> usize {
        self.desk.session.configuration.object_id(name).unwrap()
    }

    /// A point of the window where an object is seen.
    pub fn seen(&mut self, name: &str) -> Pos2 {
        let wanted = Selection::Object(self.id(name));
        let rect = self.desk.viewport.rect;
        let places: Vec<Pos2> = (0..40)
            .flat_map(|j| (0..60).map(move |i| (i, j)))
            .map(|(i, j)| rect.min + rect.size() * vec2((i as f32 + 0.5) / 60.0, (j as f32 + 0.5) / 40.0))
            .collect();
        let mut found: Vec<Pos2> = Vec::new();
        for at in places {
            if self.desk.viewport.under(&mut self.desk.session, at).is_some_and(|(s, _)| s == wanted) {
                found.push(at);
            }
        }
        assert!(!found.is_empty(), "{name} is not in the picture");
        found[found.len() / 2]
    }

    pub fn place(&self, name: &str) -> DVec3 {
        self.desk.session.configuration.object_motion(self.id(name)).translation
    }

    pub fn state(&self) -> Configuration {
        self.desk.session.configuration.clone()
    }

    /// What the recording leads to, read from the file that it was written to.
    pub fn replayed(&mut self) -> Configuration {
        let path = self.folder.path().join("recorded.ron");
        self.desk.session.write_recording(&path).unwrap();
        let (moves, _) = Moves::read(&path, &self.desk.session.scene).unwrap();
        let mut configuration = Configuration::initial(&self.desk.session.scene);
        for timed in &moves.edits {
            configuration = configuration.apply(&timed.edit).unwrap();
        }
        configuration
    }
}
