//! Moves that do not fit their scene.

use crate::desk::Desk;

/// A moves file with this edit must be refused with these words, by every command that takes moves.
fn refused(edit: &str, told: &[&str]) {
    let desk = Desk::new();
    desk.moves(&["Turn(object: \"tall box\", to: (0.0, 0.0, 48.0))", edit]);
    for command in [
        "replay cornell.ron --photons 20000 --script m.ron --out out",
        "frames cornell.ron --photons 20000 --script m.ron --out out",
        "apply cornell.ron --script m.ron --out after.ron",
    ] {
        desk.refuses(command, &[&["m.ron"], told].concat());
    }
}

#[test]
fn missing_file() {
    Desk::new().refuses("replay cornell.ron --script m.ron --out out", &["m.ron", "No such file"]);
}

#[test]
fn broken_ron() {
    refused("Move(object: \"tall box\" to: (0.0, 0.0, 0.0))", &["m.ron:3:", "comma"]);
    refused("Move(objet: \"tall box\", to: (0.0, 0.0, 0.0))", &["m.ron:3:", "`objet`", "`object`"]);
}

#[test]
fn unknown_object() {
    refused("Move(object: \"shrt box\", to: (1.0, 1.0, 0.0))", &["edit 1", "'shrt box'", "did you mean 'short box'?"]);
}

#[test]
fn fixed_object() {
    refused("Move(object: \"floor\", to: (1.0, 1.0, 0.0))", &["edit 1", "'floor' is fixed", "`movable: true`"]);
}

#[test]
fn not_a_number() {
    refused("Move(object: \"short box\", to: (NaN, 1.0, 0.0))", &["edit 1", "'short box'", "not a number"]);
    refused("Turn(object: \"short box\", to: (inf, 1.0, 0.0))", &["edit 1", "'short box'", "not a number"]);
    refused("Move(object: \"short box\", to: (1e300, 1.0, 0.0))", &["edit 1", "'short box'", "1e6 m"]);
}

#[test]
fn impossible_times() {
    refused("Drag(object: \"short box\", to: (1.0, 1.0, 0.0), step: 0.0, seconds: 1.0)", &["edit 1", "positive step"]);
    let desk = Desk::new();
    desk.write("m.ron", "(edits: [(at: NaN, edit: Move(object: \"short box\", to: (1.0, 1.0, 0.0)))])");
    desk.refuses("replay cornell.ron --script m.ron --out out", &["m.ron", "edit 0", "seconds"]);
}
