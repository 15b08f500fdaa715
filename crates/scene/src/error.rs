//! What can be wrong with a file: one line that says which file, where in it, what is wrong and what to do.

use std::path::{Path, PathBuf};

/// A file or an edit that cannot be used. `Display` is one line for the user.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// A file cannot be opened or read.
    #[error("{}: cannot be read: {why}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        why: String,
    },
    /// A place in a file is malformed.
    #[error("{}:{line}: {what}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// One-based line, or `line:column`.
        line: String,
        /// What is wrong and what to do.
        what: String,
    },
    /// Something that a file says cannot be used.
    #[error("{}: {what}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Which object, lamp or material, what is wrong, what to do.
        what: String,
    },
    /// An edit that does not fit the scene.
    #[error("{0}")]
    Edit(String),
}

impl SceneError {
    /// A file that cannot be opened or read.
    pub fn read(path: &Path, why: impl ToString) -> Self {
        Self::Read { path: path.to_owned(), why: why.to_string() }
    }

    /// A malformed place; `line` is one-based.
    pub fn line(path: &Path, line: impl ToString, what: impl ToString) -> Self {
        Self::Line { path: path.to_owned(), line: line.to_string(), what: what.to_string() }
    }

    /// Unusable content.
    pub fn content(path: &Path, what: impl ToString) -> Self {
        Self::Content { path: path.to_owned(), what: what.to_string() }
    }
}

/// Input that can be used, but not as its author meant it: printed once, with what it costs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning(pub String);

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}
