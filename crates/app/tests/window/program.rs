//! The program in a folder of its own, with a copy of the ROOM.

use super::screen::{Screen, pause};
use serde_json::Value;
use std::{
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
};
use tempfile::TempDir;

/// A folder that holds a copy of one of our scenes.
pub struct Desk {
    /// Goes away with the test.
    _whole: TempDir,
    folder: PathBuf,
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        match entry.file_type().unwrap().is_dir() {
            true => copy(&entry.path(), &to.join(entry.file_name())),
            false => drop(std::fs::copy(entry.path(), to.join(entry.file_name())).unwrap()),
        }
    }
}

impl Desk {
    pub fn new() -> Desk {
        Desk::of("room")
    }

    /// A folder that holds a copy of one of our scenes; beside it is the ROOM, whose textures others use.
    pub fn of(scene: &str) -> Desk {
        let whole = tempfile::tempdir().unwrap();
        for name in ["room", scene] {
            copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name), &whole.path().join(name));
        }
        Desk { folder: whole.path().join(scene), _whole: whole }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lightmend"));
        command.current_dir(&self.folder).args(arguments.split_whitespace());
        command
    }

    /// Runs the program to its end, which must be a good one.
    pub fn done(&self, arguments: &str) -> String {
        let run = self.command(arguments).output().unwrap();
        assert!(run.status.success(), "{arguments}: {}", String::from_utf8_lossy(&run.stderr));
        String::from_utf8(run.stdout).unwrap()
    }

    /// Opens the window on a screen, as large as that, and waits until it is there and has the keyboard.
    pub fn view(&self, screen: &Screen, arguments: &str) -> Program {
        let [width, height] = super::screen::SIZE;
        let mut command = self.command(&format!("view {arguments} --size {width}x{height}"));
        // Few photons, so that a busy machine is done soon, unless others are asked for.
        if !arguments.contains("--photons") {
            command.args(["--photons", "200000"]);
        }
        command.env("DISPLAY", &screen.display).env_remove("WAYLAND_DISPLAY");
        let program = Program(command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap());
        screen.wait("light in the window", || ["outstanding — ", "exact — "].iter().any(|light| screen.title().contains(light)));
        screen.focus();
        pause(300);
        program
    }
}

/// A running program; it is killed with the test.
pub struct Program(pub Child);

impl Program {
    /// Waits for the end; its status and what it printed on standard error.
    pub fn end(mut self) -> (Option<i32>, String) {
        let status = self.0.wait().unwrap().code();
        let mut text = String::new();
        if let Some(mut stderr) = self.0.stderr.take() {
            std::io::Read::read_to_string(&mut stderr, &mut text).unwrap();
        }
        (status, text)
    }

    /// Whether it still runs.
    pub fn runs(&mut self) -> bool {
        self.0.try_wait().unwrap().is_none()
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The folder for pictures of screens.
pub fn pictures() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("../window");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}
