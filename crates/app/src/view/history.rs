//! Undo and redo without limit: what was done, and the edits that lead back.
//!
//! All edits state absolute values, so what is undone comes back to the bit; it is an edit like any other, for the solver, for what is
//! recorded, and for the file.

use lightmend_scene::{Configuration, Edit, SceneError};
use std::mem::discriminant;

/// One thing that a person did.
#[derive(Debug, Clone, PartialEq)]
pub struct Action {
    /// What, for the menu: "Move table".
    pub title: String,
    /// Does it.
    pub forward: Vec<Edit>,
    /// Undoes it.
    pub backward: Vec<Edit>,
}

/// What was done and what was undone.
#[derive(Default)]
pub struct History {
    done: Vec<Action>,
    undone: Vec<Action>,
    /// The last action is still going on: before it, this was the configuration.
    open: Option<Configuration>,
    /// What could be done again before that: it comes back if the action is cancelled.
    before_open: Vec<Action>,
}

/// Whether after `later` nothing is left of `earlier`: the same thing was put somewhere else, turned otherwise, dimmed again.
pub fn overtakes(later: &Edit, earlier: &Edit) -> bool {
    let wholly = matches!(
        later,
        Edit::Move { .. }
            | Edit::Turn { .. }
            | Edit::Put { .. }
            | Edit::Reflect { .. }
            | Edit::Texture { .. }
            | Edit::MoveLamp { .. }
            | Edit::TurnLamp { .. }
            | Edit::Light { .. }
            | Edit::Switch { .. }
    );
    wholly && discriminant(later) == discriminant(earlier) && later.subject() == earlier.subject()
}

/// Edits that, one after the other, lead from `before` and all of `edits` back to `before`.
fn backward(before: &Configuration, edits: &[Edit]) -> Result<Vec<Edit>, SceneError> {
    let mut configuration = before.clone();
    let mut inverses = Vec::new();
    for edit in edits {
        inverses.push(edit.inverse(&configuration)?);
        configuration = configuration.apply(edit)?;
    }
    Ok(inverses.into_iter().rev().flatten().collect())
}

impl History {
    /// Something was done at once. It led from `before`.
    pub fn did(&mut self, title: String, before: &Configuration, edits: Vec<Edit>) -> Result<(), SceneError> {
        self.close()?;
        let backward = backward(before, &edits)?;
        self.undone.clear();
        self.done.push(Action { title, forward: edits, backward });
        Ok(())
    }

    /// Something goes on, step by step: while the title is the same it is one action, and of edits of one kind only the last counts.
    pub fn goes_on(&mut self, title: &str, before: &Configuration, edit: Edit) -> Result<(), SceneError> {
        let same = self.open.is_some() && self.done.last().is_some_and(|action| action.title == title);
        if !same {
            self.close()?;
            self.before_open = std::mem::take(&mut self.undone);
            self.done.push(Action { title: title.to_owned(), forward: Vec::new(), backward: Vec::new() });
            self.open = Some(before.clone());
        }
        if let Some(action) = self.done.last_mut() {
            // All of an action are about one thing: what it moves, or the riders that it gathers first.
            match action.forward.last_mut() {
                Some(last) if overtakes(&edit, last) => *last = edit,
                _ => action.forward.push(edit),
            }
        }
        Ok(())
    }

    /// What went on is over.
    pub fn close(&mut self) -> Result<(), SceneError> {
        if let Some(before) = self.open.take()
            && let Some(action) = self.done.last_mut()
        {
            action.backward = backward(&before, &action.forward)?;
        }
        Ok(())
    }

    /// Whether something goes on.
    pub fn is_open(&self) -> bool {
        self.open.is_some()
    }

    /// The last thing done is to be undone.
    pub fn undo(&mut self) -> Result<Option<Action>, SceneError> {
        self.close()?;
        let action = self.done.pop();
        self.undone.extend(action.clone());
        Ok(action)
    }

    /// The last thing undone is to be done again.
    pub fn redo(&mut self) -> Result<Option<Action>, SceneError> {
        self.close()?;
        let action = self.undone.pop();
        self.done.extend(action.clone());
        Ok(action)
    }

    /// What was undone last was cancelled: it is not to come back, and what it swept away is.
    pub fn cancelled(&mut self) {
        self.undone = std::mem::take(&mut self.before_open);
    }

    /// What would be undone.
    pub fn last_done(&self) -> Option<&str> {
        self.done.last().map(|action| action.title.as_str())
    }

    /// What would be done again.
    pub fn last_undone(&self) -> Option<&str> {
        self.undone.last().map(|action| action.title.as_str())
    }
}
