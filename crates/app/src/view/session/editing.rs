//! Editing: what a person does becomes edits, which can be undone and are recorded.

use super::Session;
use crate::view::{
    history::{self, Action},
    placement,
};
use lightmend_scene::{Edit, SceneError};

/// Of what goes on, one edit is recorded in so many seconds.
const RECORDED_OFTEN: f64 = 0.2;

impl Session {
    /// Records what waits to be recorded.
    pub(super) fn flush(&mut self) {
        if let Some((at, edit, before)) = self.waiting.take() {
            self.recording.edit(at, &edit, &before);
        }
    }

    /// Edits in a row; nothing happens if one of them cannot be.
    pub(super) fn apply(&mut self, edits: &[Edit]) -> Result<(), SceneError> {
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
    pub(super) fn slide(&mut self, title: &str, edit: Edit) {
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

    pub(super) fn told(&mut self, done: Result<(), SceneError>) -> bool {
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
}
