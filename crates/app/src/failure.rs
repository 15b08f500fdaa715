//! Why the program ends without success, and with which status.

use lightmend_photon::bucket::Full;
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

    /// Arguments that clap refuses, its paragraph in one line. Help and the version are no failure: they are printed, and the
    /// program ends.
    pub fn arguments(error: clap::Error) -> Failure {
        use clap::error::ErrorKind;
        if !error.use_stderr() || error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
            error.exit();
        }
        let text = error.to_string();
        let told = text.lines().map(str::trim).take_while(|l| !l.starts_with("Usage:") && !l.starts_with("For more information"));
        let line = told.filter(|l| !l.is_empty()).collect::<Vec<_>>().join(" ").replace(" tip:", "; tip:");
        Failure::input(format!("{}; see --help", line.trim_start_matches("error: ")))
    }

    /// Anything else: status 1.
    pub fn failed(line: impl fmt::Display) -> Failure {
        Failure { status: 1, line: line.to_string() }
    }

    /// The same failure with something more to say.
    pub fn with(self, more: &str) -> Failure {
        Failure { line: format!("{}; {more}", self.line), ..self }
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

/// Photons were asked for whose light cannot be counted.
impl From<Full> for Failure {
    fn from(full: Full) -> Failure {
        Failure::input(full)
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Failure {
        Failure::input(error)
    }
}
