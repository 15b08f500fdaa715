//! A folder with the Cornell box, in which the program is run.

use serde_json::Value;
use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};
use tempfile::TempDir;

/// A folder that holds `cornell.ron`, its meshes and its moves, and goes away with the test.
pub struct Desk(TempDir);

/// How a run ended.
pub struct Run {
    pub status: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Desk {
    pub fn new() -> Desk {
        let desk = Desk(tempfile::tempdir().expect("a folder for the test"));
        let cornell = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell");
        for name in ["cornell.ron", "box.obj", "short_box.obj", "tall_box.obj"] {
            fs::copy(cornell.join(name), desk.path(name)).expect("the Cornell box");
        }
        desk
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).expect("a file of the test");
    }

    pub fn folder(&self, name: &str) {
        fs::create_dir_all(self.path(name)).expect("a folder of the test");
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Changes `cornell.ron`, in which `from` must occur.
    pub fn change(&self, from: &str, to: &str) {
        let text = self.read("cornell.ron");
        assert!(text.contains(from), "the Cornell box has changed: no {from}");
        self.write("cornell.ron", text.replace(from, to));
    }

    /// The program with `arguments`, which are parted by spaces, about to be run in the folder.
    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lightmend"));
        command.current_dir(self.0.path()).args(arguments.split_whitespace());
        command
    }

    pub fn run(&self, arguments: &str) -> Run {
        let Output { status, stdout, stderr } = self.command(arguments).output().expect("the program runs");
        let text = |bytes| String::from_utf8(bytes).expect("the program prints UTF-8");
        Run { status: status.code(), stdout: text(stdout), stderr: text(stderr) }
    }

    /// Runs the program, which must end well and without a word on standard error; returns standard output.
    pub fn done(&self, arguments: &str) -> String {
        let run = self.run(arguments);
        assert_eq!((run.status, run.stderr.as_str()), (Some(0), ""), "{arguments}");
        run.stdout
    }

    /// Runs the program, which must refuse: status 2, one line on standard error that tells all of `told`, nothing on standard
    /// output, nothing made, changed or removed.
    pub fn refuses(&self, arguments: &str, told: &[&str]) {
        let before = self.content();
        let run = self.run(arguments);
        let stderr = &run.stderr;
        assert_eq!(run.status, Some(2), "{arguments}: {stderr}");
        assert_eq!(stderr.lines().count(), 1, "{arguments}: {stderr}");
        assert!(stderr.starts_with("lightmend: ") && stderr.ends_with('\n'), "{arguments}: {stderr}");
        for words in told {
            assert!(stderr.contains(words), "{arguments}: {words:?} is not told in {stderr}");
        }
        assert_eq!(run.stdout, "", "{arguments}");
        assert_eq!(self.content(), before, "{arguments}");
    }

    /// Every file of the folder with its bytes, and every folder.
    pub fn content(&self) -> BTreeMap<PathBuf, Option<Vec<u8>>> {
        let mut found = BTreeMap::new();
        let mut folders = vec![self.0.path().to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).expect("a folder of the test") {
                let path = entry.expect("an entry of the folder").path();
                if path.is_dir() {
                    found.insert(path.clone(), None);
                    folders.push(path);
                } else if path.is_file() {
                    found.insert(path.clone(), Some(fs::read(path).expect("a file of the test")));
                }
            }
        }
        found
    }

    /// Draws small frames of a scene with few photons, quietly.
    pub fn frames(&self, scene: &str, arguments: &str) {
        self.done(&format!("frames {scene} --size 64x48 --photons 20000 --quiet {arguments}"));
    }

    /// Writes a moves file for ten frames a second, `m.ron`: edits and camera keys with their times.
    pub fn script(&self, edits: &[(f64, &str)], cameras: &[&str]) {
        let edits: String = edits.iter().map(|(at, edit)| format!("(at: {at:?}, edit: {edit}),\n")).collect();
        self.write("m.ron", format!("(fps: 10.0, edits: [\n{edits}], cameras: [{}])", cameras.join(", ")));
    }

    /// Names of the files in a folder, in order.
    pub fn names(&self, folder: &str) -> Vec<String> {
        let entries = fs::read_dir(self.path(folder)).unwrap_or_else(|e| panic!("{folder}: {e}"));
        let name = |entry: std::io::Result<fs::DirEntry>| entry.expect("an entry").file_name().to_string_lossy().into_owned();
        let mut names: Vec<String> = entries.map(name).collect();
        names.sort();
        names
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub fn picture(&self, name: &str) -> image::RgbImage {
        image::open(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}")).into_rgb8()
    }

    /// The channels of an EXR, by name.
    pub fn channels(&self, name: &str) -> BTreeMap<String, Vec<f32>> {
        use exr::prelude::*;
        let image = read_first_flat_layer_from_file(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
        let name = |text: &Text| std::str::from_utf8(text.as_slice()).expect("UTF-8").to_owned();
        let channels = image.layer_data.channel_data.list.iter();
        channels.map(|c| (name(&c.name), c.sample_data.values_as_f32().collect())).collect()
    }

    /// Writes a moves file of these edits, `m.ron`.
    pub fn moves(&self, edits: &[&str]) {
        let edits: String = edits.iter().enumerate().map(|(at, edit)| format!("(at: {at}.0, edit: {edit}),\n")).collect();
        self.write("m.ron", format!("(edits: [\n{edits}])"));
    }
}
