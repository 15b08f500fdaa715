//! Results that cannot be written where they should go. Tests may run as root, whom no permission stops: what stands in the way is
//! of the wrong kind, missing or full.

use crate::desk::Desk;
use std::{fs, os::unix::fs::symlink};

/// A file called `file` and a folder called `folder` stand in the way.
fn desk() -> Desk {
    let desk = Desk::new();
    desk.write("file", "mine");
    desk.folder("folder");
    desk.moves(&["Move(object: \"short box\", to: (1.5, 0.45, 0.0))"]);
    desk.write("points.csv", "x,y,z,nx,ny,nz\n1,0.2,0,0,0,1\n");
    desk
}

/// Every command that writes a file.
const FILES: [&str; 6] = [
    "solve cornell.ron --photons 20000 --dump",
    "replay cornell.ron --photons 20000 --script m.ron --out out --dump",
    "apply cornell.ron --script m.ron --out",
    "probe cornell.ron --photons 20000 --points points.csv --out",
    "import box.obj --out",
    "reference cornell.ron --paths 1000 --points points.csv --out",
];

/// Every command that writes into a folder.
const FOLDERS: [&str; 2] =
    ["solve cornell.ron --photons 20000 --dump dump.tsv --out", "replay cornell.ron --photons 20000 --script m.ron --out"];

#[test]
fn folder_in_place_of_a_file() {
    for command in FILES {
        desk().refuses(&format!("{command} folder"), &["folder: ", "it is a folder"]);
    }
    for (command, name) in [(FOLDERS[0], "front.png"), (FOLDERS[0], "summary.json"), (FOLDERS[1], "recovery.png")] {
        let desk = desk();
        desk.folder(&format!("folder/{name}"));
        desk.refuses(&format!("{command} folder"), &[&format!("folder/{name}: "), "it is a folder"]);
    }
}

#[test]
fn no_such_parent() {
    for command in FILES {
        desk().refuses(&format!("{command} gone/result"), &["gone/result", "there is no folder gone"]);
        desk().refuses(&format!("{command} file/result"), &["file/result", "there is no folder file"]);
    }
}

#[test]
fn file_in_place_of_the_folder() {
    for command in FOLDERS {
        for place in ["file", "file/below"] {
            desk().refuses(&format!("{command} {place}"), &[&format!("{place}: "), "cannot be written"]);
        }
    }
}

/// /proc takes no files from anybody.
#[test]
#[cfg(target_os = "linux")]
fn a_folder_that_takes_no_files() {
    for command in FILES {
        desk().refuses(&format!("{command} /proc/result"), &["/proc", "cannot be written"]);
    }
    for command in FOLDERS {
        desk().refuses(&format!("{command} /proc/results"), &["/proc/results", "cannot be written"]);
    }
}

/// Devices are written into; renaming a file to their name, as root can, would replace them.
#[test]
#[cfg(target_os = "linux")]
fn devices_stay_devices() {
    let desk = desk();
    symlink("/dev/full", desk.path("full")).expect("a link");
    desk.refuses("solve cornell.ron --photons 20000 --dump full", &["full", "No space left"]);
    symlink("/dev/null", desk.path("null")).expect("a link");
    desk.done("solve cornell.ron --photons 20000 --quiet --dump null");
    for (link, device) in [("full", "/dev/full"), ("null", "/dev/null")] {
        assert_eq!(fs::read_link(desk.path(link)).expect("still a link"), std::path::Path::new(device));
    }
    let scene = desk.done("apply cornell.ron --script m.ron --quiet --out /dev/stdout");
    assert!(scene.starts_with("(\n") && scene.contains("(1.5, 0.45, 0.0)"), "{scene}");
}
