//! What of a session is on disk: the scene, what is kept of it by itself, the recording.

use super::Session;
use crate::view::autosave::Autosave;
use lightmend_scene::{CameraKey, Moves, SceneError, View};
use std::path::{Path, PathBuf};

impl Session {
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
        if path.to_string_lossy().ends_with(".autosave.ron") {
            return Err(SceneError::content(path, "is a name of what is kept by itself; save the scene under another one"));
        }
        self.configuration.write(path)?;
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
}
