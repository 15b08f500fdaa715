//! Why the program ends without success, and with which status.

use lightmend_scene::SceneError;
use std::fmt;

/// A failure, told in one line.
#[derive(Debug)]
pub struct Failure {
    status: u8,
    line: String,
}

impl Failure {
    /// Bad input or arguments: status 2.
    pub fn input(line: impl fmt::Display) -> Failure {
        Failure { status: 2, line: line.to_string() }
    }

    /// Anything else: status 1.
    pub fn failed(line: impl fmt::Display) -> Failure {
        Failure { status: 1, line: line.to_string() }
    }

    /// The exit status.
    pub fn status(&self) -> u8 {
        self.status
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.line.replace('\n', " "))
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Failure {
        Failure::input(error)
    }
}
