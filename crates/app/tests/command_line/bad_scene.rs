//! Scenes that cannot be used, one fault each, and the one that can.

use crate::desk::Desk;

const SOLVE: &str = "solve cornell.ron --photons 20000 --out out --dump dump.tsv";

/// The Cornell box with `from` replaced by `to` must be refused with these words.
fn refused(from: &str, to: &str, told: &[&str]) {
    let desk = Desk::new();
    desk.change(from, to);
    for command in [SOLVE, "check cornell.ron"] {
        desk.refuses(command, told);
    }
}

/// The Cornell box with another mesh in place of the short box must be refused with these words.
fn refused_mesh(mesh: &str, told: &[&str]) {
    let desk = Desk::new();
    desk.write("bad.obj", mesh);
    desk.change("short_box.obj", "bad.obj");
    desk.refuses(SOLVE, told);
}

#[test]
fn missing_file() {
    Desk::new().refuses("solve nowhere.ron", &["nowhere.ron", "No such file"]);
}

#[test]
fn folder_in_place_of_the_file() {
    Desk::new().refuses("solve .", &["cannot be read", "directory"]);
}

#[test]
fn broken_ron() {
    refused("up: z,", "up z,", &["cornell.ron:4:7: ", "colon"]);
    refused("cell: 0.15", "cell: \"wide\"", &["cornell.ron:5:"]);
}

#[test]
fn not_text() {
    let desk = Desk::new();
    desk.write("cornell.ron", b"(name: \"\xff\")");
    desk.refuses(SOLVE, &["cornell.ron", "UTF-8"]);
}

#[test]
fn unknown_field() {
    refused("movable: true", "moveable: true", &["cornell.ron:18:", "`moveable`", "`movable`"]);
    refused("cell: 0.15", "cel: 0.15", &["cornell.ron:5:", "`cel`", "`cell`"]);
}

#[test]
fn unknown_part() {
    refused("part: \"floor\"", "part: \"flor\"", &["cornell.ron", "object 'floor'", "did you mean 'floor'?"]);
}

#[test]
fn unknown_carrier() {
    refused("name: \"lamp\",", "name: \"lamp\", on: \"tal box\",", &["cornell.ron", "lamp 'lamp'", "did you mean 'tall box'?"]);
}

#[test]
fn ring_of_carriers() {
    let desk = Desk::new();
    desk.change("(name: \"short box\",", "(name: \"short box\", on: \"tall box\",");
    desk.change("(name: \"tall box\",", "(name: \"tall box\", on: \"short box\",");
    desk.refuses(SOLVE, &["cornell.ron", "object 'short box' carries itself", "`on`"]);
}

#[test]
fn duplicate_names() {
    refused("\"tall box\", mesh", "\"short box\", mesh", &["cornell.ron", "two objects", "'short box'", "another name"]);
}

#[test]
fn missing_mesh() {
    refused("short_box.obj", "gone.obj", &["cornell.ron", "object 'short box'", "gone.obj", "No such file"]);
}

#[test]
fn missing_texture() {
    let told = ["cornell.ron", "material 'white'", "gone.png", "No such file"];
    refused("\"white\": (", "\"white\": (texture: \"gone.png\", ", &told);
}

#[test]
fn unreadable_texture() {
    let desk = Desk::new();
    desk.write("white.png", "no picture");
    desk.change("\"white\": (", "\"white\": (texture: \"white.png\", ");
    desk.refuses(SOLVE, &["white.png", "PNG or JPEG"]);
}

#[test]
fn malformed_photometric_file() {
    let desk = Desk::new();
    desk.write("lamp.ies", "IESNA:LM-63-1995\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n1 1 10\n0 45 banana\n0\n1 2 3\n");
    desk.change("(name: \"lamp\",", "(name: \"lamp\", photometry: \"lamp.ies\",");
    desk.refuses(SOLVE, &["lamp.ies:5", "'banana'"]);
}

#[test]
fn zero_area_triangle() {
    let told = ["bad.obj:7:", "object `chip`", "triangle 2", "no area", "lightmend import"];
    refused_mesh("o chip\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\n", &told);
}

#[test]
fn nan_vertex() {
    refused_mesh("v 0 0 0\nv 1 0 0\nv 0 1 nan\nf 1 2 3\n", &["bad.obj:3:", "vertex z", "nan"]);
}

#[test]
fn face_without_its_vertex() {
    refused_mesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", &["bad.obj:4:", "index 9", "3 vertices"]);
}

#[test]
fn empty_mesh() {
    refused_mesh("", &["bad.obj", "no triangles"]);
}

#[test]
fn lamp_of_impossible_intensity() {
    for red in ["-170.0", "NaN", "inf", "1e308"] {
        refused("(170.0,", &format!("({red},"), &["cornell.ron", "lamp 'lamp'", "intensity"]);
    }
}

#[test]
fn lamp_of_no_intensity_is_a_warning() {
    let desk = Desk::new();
    desk.change("(170.0, 155.0, 125.0)", "(0.0, 0.0, 0.0)");
    let run = desk.run(SOLVE);
    assert_eq!(run.status, Some(0), "{}", run.stderr);
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    assert!(run.stderr.starts_with("warning: cornell.ron: lamp 'lamp' gives no light"), "{}", run.stderr);
    assert_eq!(desk.json("out/summary.json")["photons"], 20_000);
}

/// Single precision ends at 3.4e38: such a box once made the tree builder panic.
#[test]
fn farther_than_rays_can_say() {
    for x in ["1e7", "1e300", "NaN"] {
        refused("(1.32, ", &format!("({x}, "), &["cornell.ron", "object 'short box'", "1e6 m"]);
        refused("(1.0, 1.0, 1.9)", &format!("({x}, 1.0, 1.9)"), &["cornell.ron", "lamp 'lamp'", "1e6 m"]);
        refused("(1.0, -2.7,", &format!("({x}, -2.7,"), &["cornell.ron", "camera 'front'", "1e6 m"]);
    }
    refused_mesh("v 0 0 0\nv 1e7 0 0\nv 0 1 0\nf 1 2 3\n", &["object 'short box'", "bad.obj", "1e6 m", "metres"]);
}

#[test]
fn impossible_cell_and_reflectance() {
    refused("cell: 0.15", "cell: 0.0", &["cornell.ron", "cell is 0", "positive"]);
    refused("cell: 0.15", "cell: 1e-9", &["cornell.ron", "object 'ceiling'", "larger"]);
    refused("cell: 0.15", "cell: 0.0002", &["cornell.ron", "mesh elements", "larger than 0.0002 m"]);
    refused("(0.14, ", "(1.4, ", &["cornell.ron", "material 'green'", "0 to 1"]);
}
