//! From an OBJ file to light, and what an import must leave alone.

use crate::desk::Desk;

/// A closed box of 2 m, in centimetres, with a material file and an image.
fn model(desk: &Desk) {
    desk.folder("models");
    desk.write(
        "models/crate.obj",
        "mtllib crate.mtl\no crate\nusemtl wood\nv 0 0 0\nv 200 0 0\nv 200 200 0\nv 0 200 0\nv 0 0 200\nv 200 0 200\nv 200 200 200\n\
         v 0 200 200\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\nf 5/1 8/2 7/3 6/4\nf 1/1 5/2 6/3 2/4\nf 2/1 6/2 7/3 3/4\n\
         f 3/1 7/2 8/3 4/4\nf 4/1 8/2 5/3 1/4\n",
    );
    desk.write("models/crate.mtl", "newmtl wood\nKd 0.5 0.4 0.3\nmap_Kd wood.png\n");
    desk.write("models/wood.png", PNG);
}

/// One white pixel.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x01\0\0\0\x01\x08\0\0\0\0\x3a\x7e\x9b\x55\
    \0\0\0\x0aIDATx\x9cc\xf8\x0f\0\x01\x01\x01\0\xb1\x38\xf6\x14\0\0\0\0IEND\xaeB`\x82";

#[test]
fn import_check_solve() {
    let desk = Desk::new();
    model(&desk);
    let told = desk.done("import models/crate.obj --out new.ron --scale 0.01 --lamp 1,1,1,100 --movable crate");
    assert!(told.contains("1 objects, 12 triangles"), "{told}");
    let told = desk.done("check new.ron --json");
    let checked: serde_json::Value = serde_json::from_str(&told).expect("one JSON document");
    let [object] = &checked["objects"].as_array().expect("objects")[..] else { panic!("{told}") };
    assert_eq!((&object["name"], &object["movable"]), (&"crate".into(), &true.into()));
    assert!((object["area"].as_f64().expect("an area") - 24.0).abs() < 1e-9, "{told}");
    assert_eq!(object["open_edges"], 0);
    desk.done("solve new.ron --photons 20000 --out out");
    let summary = desk.json("out/summary.json");
    assert_eq!((&summary["absorbed"], &summary["escaped"]), (&20_000.into(), &0.into()));
    assert!(desk.path("out/front.png").is_file());
}

#[test]
fn an_import_stands_on_its_own() {
    let desk = Desk::new();
    model(&desk);
    desk.done("import models/crate.obj --out new.ron --lamp 1,1,1,100 --quiet");
    std::fs::remove_dir_all(desk.path("models")).expect("the models are there");
    desk.done("solve new.ron --photons 20000 --quiet");
}

#[test]
fn glow_is_warned_of_once() {
    let desk = Desk::new();
    model(&desk);
    desk.write("models/crate.mtl", "newmtl wood\nKd 0.5 0.4 0.3\nKe 4 4 4\n");
    let run = desk.run("import models/crate.obj --out new.ron --lamp 1,1,1,100");
    assert_eq!((run.status, run.stderr.lines().count()), (Some(0), 1), "{}", run.stderr);
    assert!(run.stderr.contains("material 'wood'") && run.stderr.contains("--lamp"), "{}", run.stderr);
}

#[test]
fn empty_model() {
    let desk = Desk::new();
    desk.write("empty.obj", "# nothing\n");
    desk.refuses("import empty.obj --out new.ron", &["empty.obj", "no triangles"]);
    desk.refuses("import gone.obj --out new.ron", &["gone.obj", "No such file"]);
}

/// The meshes of `box.ron` go to `box.obj`: an import beside its model would replace it.
#[test]
fn models_are_never_overwritten() {
    let desk = Desk::new();
    desk.refuses("import box.obj --out box.ron", &["box.obj", "overwrite", "another name"]);
    desk.refuses("import short_box.obj box.obj --out ./box.ron", &["box.obj", "overwrite", "another name"]);
    desk.refuses("import box.obj --out new.obj", &["new.obj", ".ron"]);
}

/// An image copied onto itself was once an empty file; two images of one name were once the same image.
#[test]
fn images_are_never_overwritten() {
    let desk = Desk::new();
    model(&desk);
    desk.done("import models/crate.obj --out models/new.ron --lamp 1,1,1,100 --quiet");
    assert_eq!(std::fs::read(desk.path("models/wood.png")).expect("the image"), PNG);
    desk.write("wood.png", "another wood");
    desk.done("import models/crate.obj --out new.ron --lamp 1,1,1,100 --quiet");
    assert_eq!(desk.read("wood.png"), "another wood");
    assert!(desk.read("new.ron").contains("\"wood 2.png\""));
    desk.done("check new.ron --quiet");
}

/// What an import refuses late leaves no image behind.
#[test]
fn refused_imports_copy_nothing() {
    let desk = Desk::new();
    model(&desk);
    desk.refuses("import models/crate.obj --out new.ron --movable crat", &["did you mean 'crate'?"]);
}

/// Regression: the first mesh's material won for both.
#[test]
fn materials_of_the_same_name_in_two_models_stay_two() {
    let desk = Desk::new();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl gold\nf 1 2 3\n";
    for (name, colour) in [("a", "0.8 0.6 0.2"), ("b", "0.1 0.1 0.1")] {
        desk.write(&format!("{name}.mtl"), format!("newmtl gold\nKd {colour}\n"));
        desk.write(&format!("{name}.obj"), format!("mtllib {name}.mtl\no {name}\n{triangle}"));
    }
    desk.done("import a.obj b.obj --out both.ron --quiet");
    let scene = desk.read("both.ron");
    assert!(scene.contains("0.8") && scene.contains("0.1"), "{scene}");
}
