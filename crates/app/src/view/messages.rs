//! What the program has to say, in the corner of the window, until it was read.

use std::time::{Duration, Instant};

/// How a message is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Something was done.
    Note,
    /// Something is not as the files say.
    Warning,
    /// Something could not be done.
    Failure,
}

/// How long it is shown.
fn lasts(kind: Kind) -> Duration {
    Duration::from_secs(if kind == Kind::Note { 4 } else { 12 })
}

/// Messages that are shown.
#[derive(Debug, Default)]
pub struct Messages {
    shown: Vec<(Kind, String, Instant)>,
    warned: Vec<String>,
}

impl Messages {
    fn add(&mut self, kind: Kind, text: String) {
        self.shown.retain(|(_, shown, _)| *shown != text);
        self.shown.push((kind, text, Instant::now()));
    }

    /// Something was done.
    pub fn say(&mut self, text: String) {
        self.add(Kind::Note, text);
    }

    /// Something is not as the files say; told once, also on standard error.
    pub fn warn(&mut self, text: String) {
        if !self.warned.contains(&text) {
            eprintln!("warning: {text}");
            self.warned.push(text.clone());
            self.add(Kind::Warning, text);
        }
    }

    /// Something could not be done.
    pub fn fail(&mut self, text: String) {
        self.add(Kind::Failure, text);
    }

    /// When the next one goes.
    pub fn next_goes_in(&self) -> Option<Duration> {
        self.shown.iter().map(|(kind, _, since)| lasts(*kind).saturating_sub(since.elapsed())).min()
    }

    /// What is to be shown now. A note goes after a while, a failure later.
    pub fn current(&mut self) -> impl Iterator<Item = (Kind, &str)> {
        self.shown.retain(|(kind, _, since)| since.elapsed() < lasts(*kind));
        self.shown.iter().map(|(kind, text, _)| (*kind, text.as_str()))
    }
}
