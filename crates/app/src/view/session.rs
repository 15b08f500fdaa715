//! The room as a person rearranges it: what stands where, what was done, its light, and what of all this is on disk.
//!
//! No window and no graphics: everything here can be tried without.

mod editing;
mod files;

use super::{
    autosave::Autosave,
    history::History,
    light::{LightReader, Ready},
    messages::Messages,
    navigation::Navigation,
    playback::Playback,
};
use crate::failure::Failure;
use lightmend_photon::{
    body::TreePreset,
    path::FirstHits,
    pool::Pool,
    solver::{Controls, Settings, Snapshot, Solver},
    world::World,
};
use lightmend_scene::{Configuration, Edit, Moves, Recording, Scene, SceneError, View};
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
    /// The photons that are shot at once.
    pub pool: Pool,
    /// Bytes for the records of their paths.
    pub ledger_bytes: u64,
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
            ledger_bytes: start.ledger_bytes,
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

    /// Whether this light is to the bit that of the scene as it is now.
    pub fn is_exact(&self, light: &Snapshot) -> bool {
        light.exact && light.edits >= self.edits
    }

    /// Whether nobody will see the rest of its repair to the scene as it is now, as far as can be foreseen.
    pub fn is_complete_for_the_eye(&self, ready: &Ready) -> bool {
        ready.complete_for_the_eye && ready.snapshot.edits >= self.edits
    }

    /// The number of the last edit that the solver was told of.
    pub fn edits(&self) -> u64 {
        self.edits
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
