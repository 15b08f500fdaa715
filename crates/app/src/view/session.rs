//! The room as a person rearranges it: what stands where, what was done, its light, and what of all this is on disk.
//!
//! No window and no graphics: everything here can be tried without.

use super::{
    autosave::Autosave,
    history::{self, Action, History},
    light::LightReader,
    messages::Messages,
    navigation::Navigation,
    placement,
    playback::Playback,
};
use crate::failure::Failure;
use lightmend_photon::{
    body::TreePreset,
    path::FirstHits,
    pool::Pool,
    solver::{Controls, Settings, Solver},
    world::World,
};
use lightmend_scene::{CameraKey, Configuration, Edit, Moves, Recording, Scene, SceneError, View, format::write_ron};
use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Instant,
};

/// What is selected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Selection {
    /// An object, by number.
    Object(usize),
    /// A lamp, by number.
    Lamp(usize),
}

/// How a session begins.
#[derive(Clone, Copy)]
pub struct Start {
    /// The photons.
    pub pool: Pool,
    /// Threads that trace.
    pub threads: usize,
    /// How they work.
    pub controls: Controls,
}

/// A scene that is being rearranged.
pub struct Session {
    /// As its file states it.
    pub scene: Arc<Scene>,
    /// Where Save writes.
    pub path: PathBuf,
    /// As it is now.
    pub configuration: Configuration,
    /// As it was saved last.
    saved: Configuration,
    /// It was opened from what was kept of an earlier run.
    unsaved: bool,
    /// Undo and redo.
    pub history: History,
    /// The camera.
    pub navigation: Navigation,
    /// What is selected.
    pub selection: Option<Selection>,
    /// Whether dragged objects snap to floor and walls.
    pub snapping: bool,
    /// Traces in the background.
    pub solver: Arc<Solver>,
    /// Reads its light.
    pub light: LightReader,
    /// What it has to say.
    pub messages: Messages,
    /// A script that is being played.
    pub playback: Option<Playback>,
    /// Where the recording is written.
    pub record: Option<PathBuf>,
    recording: Recording,
    /// An edit that goes on, since when, and what it began with: not recorded yet.
    waiting: Option<(f64, Edit, Configuration)>,
    autosave: Autosave,
    began: Instant,
    /// Trees for the pointer's rays; of some configuration that was.
    world: Option<Arc<World>>,
    /// Number of the last edit that the solver was told of.
    edits: u64,
    /// Counts what may change the picture.
    revision: u64,
}

/// Frames per second of a recording's playback.
const RECORDED_FPS: f64 = 25.0;

/// Of what goes on, one edit is recorded in so many seconds.
const RECORDED_OFTEN: f64 = 0.2;

/// From the far corner of what there is, if the scene has no camera.
fn some_view(configuration: &Configuration) -> View {
    let boxes = configuration.objects().map(|(id, _)| super::pick::bounds(configuration, id));
    let [low, high] = boxes.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]).unwrap_or([glam::DVec3::NEG_ONE, glam::DVec3::ONE]);
    let target = (low + high) / 2.0;
    // Inside of a room one sees more of it than from outside.
    let eye = target + (high - low).max(glam::DVec3::splat(0.1)) * glam::DVec3::new(0.4, -0.42, 0.3);
    View { eye, target, fov: 70.0 }
}

impl Session {
    /// Begins to rearrange `scene`; Save writes to `path`. `wake` is called from another thread when there is new light.
    pub fn start(
        scene: Arc<Scene>,
        path: PathBuf,
        start: Start,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Result<Session, Failure> {
        let configuration = Configuration::initial(&scene);
        let settings = Settings {
            pool: start.pool,
            first_hits: FirstHits::AsLampsSay,
            threads: start.threads,
            controls: start.controls,
            courteous: true,
        };
        let solver = Solver::start(configuration.clone(), settings)
            .map_err(|e| Failure::failed(format!("threads cannot be started: {e}")))?;
        let solver = Arc::new(solver);
        let view = scene.cameras.first().map_or_else(|| some_view(&configuration), |(_, view)| *view);
        let navigation = Navigation::new(view, scene.up, configuration.reach());
        let light = LightReader::start(solver.clone(), start, configuration.clone(), view, wake)?;
        Ok(Session {
            autosave: Autosave::beside(&path),
            path,
            saved: configuration.clone(),
            unsaved: false,
            history: History::default(),
            navigation,
            selection: None,
            snapping: true,
            solver,
            light,
            messages: Messages::default(),
            playback: None,
            record: None,
            recording: Recording::new(RECORDED_FPS),
            waiting: None,
            began: Instant::now(),
            world: None,
            edits: 0,
            revision: 0,
            configuration,
            scene,
        })
    }

    /// Seconds since it began.
    pub fn now(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// Changes whenever something else stands, shines or is painted.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// The number of the last edit that the solver was told of.
    pub fn edits(&self) -> u64 {
        self.edits
    }

    /// Whether something waits to be kept in the autosave.
    pub fn keeps_waiting(&self) -> bool {
        self.autosave.waits()
    }

    /// What was opened is not what the file says that it would be saved to.
    pub fn differs_from_file(&mut self) {
        self.autosave.taken_over();
        self.unsaved = true;
    }

    /// Whether the file says something else.
    pub fn is_changed(&self) -> bool {
        self.unsaved || self.configuration != self.saved
    }

    /// The trees of what stands now.
    pub fn world(&mut self) -> Arc<World> {
        let known = self.world.take().or_else(|| self.solver.snapshot().map(|snapshot| snapshot.world.clone()));
        let world = match known {
            Some(world) if *world.configuration() == self.configuration => world,
            Some(world) => Arc::new(world.moved_to(&self.configuration)),
            None => Arc::new(World::new(&self.configuration, TreePreset::default())),
        };
        self.world = Some(world.clone());
        world
    }

    /// Trees of the scene, of now or of shortly before: for what may be a frame late.
    pub fn recent_world(&mut self) -> Arc<World> {
        match &self.world {
            Some(world) => world.clone(),
            None => self.world(),
        }
    }

    /// Takes what an edit made of the scene, and tells everyone.
    fn take(&mut self, configuration: Configuration) {
        if configuration == self.configuration {
            return;
        }
        self.configuration = configuration;
        self.revision += 1;
        self.edits = self.solver.edit(self.configuration.clone());
        self.light.edited(&self.configuration, self.edits);
        let there = match self.selection {
            Some(Selection::Object(id)) => self.configuration.has_object(id),
            Some(Selection::Lamp(id)) => self.configuration.has_lamp(id),
            None => true,
        };
        if !there {
            self.selection = None;
        }
        self.autosave.changed();
    }

    /// Records what waits to be recorded.
    fn flush(&mut self) {
        if let Some((at, edit, before)) = self.waiting.take() {
            self.recording.edit(at, &edit, &before);
        }
    }

    /// Edits in a row; nothing happens if one of them cannot be.
    fn apply(&mut self, edits: &[Edit]) -> Result<(), SceneError> {
        let mut states = vec![self.configuration.clone()];
        let mut warnings = Vec::new();
        for edit in edits {
            let next = states[states.len() - 1].apply_warning(edit, &mut warnings)?;
            states.push(next);
        }
        let now = self.now();
        self.flush();
        for (edit, before) in edits.iter().zip(&states) {
            self.recording.edit(now, edit, before);
        }
        warnings.iter().for_each(|warning| self.messages.warn(warning.to_string()));
        if let Some(last) = states.pop() {
            self.take(last);
        }
        Ok(())
    }

    /// Does something that can be undone. What is wrong with it is told.
    pub fn perform(&mut self, title: impl Into<String>, edits: Vec<Edit>) -> bool {
        let before = self.configuration.clone();
        self.light.begins();
        let done = self.apply(&edits).and_then(|()| self.history.did(title.into(), &before, edits));
        self.told(done)
    }

    /// Does a part of something that goes on: a slider that is pulled, an object that is turned.
    pub fn go_on(&mut self, title: &str, edit: Edit) -> bool {
        let before = self.configuration.clone();
        let mut warnings = Vec::new();
        let next = match before.apply_warning(&edit, &mut warnings) {
            Ok(next) if next == before => return true,
            Ok(next) => next,
            Err(error) => return self.told(Err(error)),
        };
        warnings.iter().for_each(|warning| self.messages.warn(warning.to_string()));
        if !self.history.is_open() {
            self.light.begins();
        }
        // A slider tells of every frame; what is recorded of it follows a few times a second, and its end to the bit.
        let now = self.now();
        let same = |waiting: &Edit| history::overtakes(&edit, waiting);
        self.waiting = match self.waiting.take() {
            Some((at, waiting, start)) if same(&waiting) && now - at < RECORDED_OFTEN => Some((at, edit.clone(), start)),
            other => {
                self.waiting = other;
                self.flush();
                Some((now, edit.clone(), before.clone()))
            }
        };
        let done = self.history.goes_on(title, &before, edit);
        self.take(next);
        self.told(done)
    }

    /// Moves a held object to a place in the world, metres.
    pub fn drag(&mut self, object: usize, at: glam::DVec3) {
        let title = format!("Move {}", self.configuration.object(object).name);
        self.slide(&title, placement::move_to(&self.configuration, object, at));
    }

    /// One of a row of moves of an object.
    fn slide(&mut self, title: &str, edit: Edit) {
        let Edit::Move { object, to } = &edit else { return };
        let before = self.configuration.clone();
        let next = match before.apply(&edit) {
            Ok(next) if next == before => return,
            Ok(next) => next,
            Err(error) => return self.messages.fail(error.to_string()),
        };
        if !self.history.is_open() {
            self.light.begins();
        }
        self.flush();
        self.recording.drag(self.now(), object, *to, &before);
        let done = self.history.goes_on(title, &before, edit);
        self.take(next);
        self.told(done);
    }

    /// What went on is over.
    pub fn end(&mut self) {
        self.flush();
        let done = self.history.close();
        self.told(done);
    }

    /// What went on is over, and everything is as it was before it.
    pub fn cancel(&mut self) {
        if self.history.is_open() {
            self.undo();
            self.history.cancelled();
        }
    }

    fn told(&mut self, done: Result<(), SceneError>) -> bool {
        if let Err(error) = &done {
            self.messages.fail(error.to_string());
        }
        done.is_ok()
    }

    /// Undoes the last action.
    pub fn undo(&mut self) {
        self.stop_playing();
        match self.history.undo() {
            Ok(Some(Action { title, backward, .. })) => {
                self.light.begins();
                match self.apply(&backward) {
                    Ok(()) => self.messages.say(format!("Undone: {title}")),
                    Err(error) => {
                        self.messages.fail(format!("{title} cannot be undone: {error}"));
                        // It stays done.
                        let _ = self.history.redo();
                    }
                }
            }
            Ok(None) => self.messages.say("Nothing to undo".into()),
            Err(error) => self.messages.fail(error.to_string()),
        }
    }

    /// Does again what was undone last.
    pub fn redo(&mut self) {
        self.stop_playing();
        match self.history.redo() {
            Ok(Some(Action { title, forward, .. })) => {
                self.light.begins();
                match self.apply(&forward) {
                    Ok(()) => self.messages.say(format!("Done again: {title}")),
                    Err(error) => {
                        self.messages.fail(format!("{title} cannot be done again: {error}"));
                        // It stays undone.
                        let _ = self.history.undo();
                    }
                }
            }
            Ok(None) => self.messages.say("Nothing to do again".into()),
            Err(error) => self.messages.fail(error.to_string()),
        }
    }

    /// Time passes: scripts play, the camera is recorded, what changed is kept.
    pub fn tick(&mut self) {
        if let Some(mut playback) = self.playback.take() {
            let (steps, view) = playback.due();
            for edit in steps {
                match &edit {
                    Edit::Move { .. } => self.slide(&playback.title, edit),
                    _ => {
                        self.go_on(&playback.title, edit);
                    }
                }
            }
            if let Some(view) = view {
                self.navigation.set(view);
            }
            if playback.is_over() {
                self.end();
                self.messages.say(format!("{} is over", playback.title));
            } else {
                self.playback = Some(playback);
            }
        }
        let view = self.navigation.view();
        self.recording.camera(self.now(), view);
        self.light.looks(view);
        if self.solver.view() != Some(view) {
            self.solver.look(view);
        }
        if let Some(error) = self.autosave.tick(&self.configuration, self.unsaved || self.configuration != self.saved) {
            self.messages.fail(error);
        }
    }

    /// Throws the light away, for the solver to shoot it anew.
    pub fn start_over(&mut self) {
        self.light.begins();
        self.edits = self.solver.start_over();
        self.light.edited(&self.configuration, self.edits);
    }

    /// Plays a script from now on.
    pub fn play(&mut self, path: &Path) -> Result<(), SceneError> {
        let (moves, warnings) = Moves::read(path, &self.scene)?;
        warnings.iter().for_each(|warning| self.messages.warn(warning.to_string()));
        let title = format!("Play {}", path.file_name().unwrap_or_default().to_string_lossy());
        // Tried before anything of it happens: the scene may have been rearranged since.
        let mut trial = self.configuration.clone();
        for timed in &moves.edits {
            trial = trial.apply(&timed.edit)?;
        }
        self.playback = Some(Playback::new(title, moves, &self.configuration)?);
        Ok(())
    }

    /// Stops the script that is playing.
    pub fn stop_playing(&mut self) {
        if self.playback.take().is_some() {
            self.end();
            self.messages.say("The script was stopped".into());
        }
    }

    /// What was done so far, as a moves file.
    pub fn recorded(&mut self) -> Moves {
        self.flush();
        let mut moves = self.recording.moves();
        // Without any frame, where one looks now.
        if moves.cameras.is_empty() {
            let View { eye, target, fov } = self.navigation.view();
            moves.cameras.push(CameraKey { at: 0.0, eye, target, fov });
        }
        moves
    }

    /// Writes what was done so far.
    pub fn write_recording(&mut self, path: &Path) -> Result<(), SceneError> {
        self.recorded().write(path, &self.scene)
    }

    /// Writes the scene as it is; from now on that is its file.
    pub fn save(&mut self, path: &Path) -> Result<(), SceneError> {
        let folder = |path: &Path| path.parent().unwrap_or(Path::new("")).to_owned();
        if path.to_string_lossy().ends_with(".autosave.ron") {
            return Err(SceneError::content(path, "is a name of what is kept by itself; save the scene under another one"));
        }
        let mut file = self.configuration.to_file();
        file.relocate(&folder(&self.scene.path), &folder(path))?;
        write_ron(path, &file)?;
        (self.saved, self.unsaved) = (self.configuration.clone(), false);
        self.autosave.remove();
        let same = |a: &Path, b: &Path| a == b || a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b));
        if !same(path, &self.path) {
            self.autosave = Autosave::beside(path);
            // What was kept for the file that this one replaces is of no use any more.
            self.autosave.taken_over();
            self.path = path.to_owned();
        }
        self.messages.say(format!("Saved: {}", path.display()));
        Ok(())
    }

    /// Keeps what is not saved in the autosave, at once; where that is.
    pub fn keep(&mut self) -> Option<PathBuf> {
        let changed = self.is_changed();
        changed.then(|| self.autosave.write_now(&self.configuration)).and_then(|result| match result {
            Ok(path) => Some(path),
            Err(error) => {
                self.messages.fail(error);
                None
            }
        })
    }

    /// It is over: nothing needs to be kept if nothing is unsaved, or if that is thrown away on purpose.
    pub fn leave(&mut self, thrown_away: bool) {
        if thrown_away || !(self.is_changed() || self.autosave.is_asked()) {
            self.autosave.remove();
        }
    }

    /// What was kept of an earlier run is thrown away on purpose.
    pub fn forget_earlier(&mut self) {
        self.autosave.remove();
    }

    /// A name that no object has yet, like "chair 2".
    pub fn free_object_name(&self, like: &str) -> String {
        free_name(like, |name| self.configuration.object_id(name).is_ok())
    }

    /// A name that no lamp has yet.
    pub fn free_lamp_name(&self, like: &str) -> String {
        free_name(like, |name| self.configuration.lamps().any(|(_, lamp)| lamp.name == name))
    }

    /// A name that no material has yet.
    pub fn free_material_name(&self, like: &str) -> String {
        free_name(like, |name| self.configuration.materials().any(|material| material.name == name))
    }
}

/// `like`, or `like 2`, `like 3` and so on.
fn free_name(like: &str, taken: impl Fn(&str) -> bool) -> String {
    let stem = like.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end();
    let stem = if stem.is_empty() { like } else { stem };
    let numbered = (2u64..).map(|n| format!("{stem} {n}"));
    std::iter::once(like.to_owned()).chain(numbered).find(|name| !taken(name)).unwrap_or_default()
}
