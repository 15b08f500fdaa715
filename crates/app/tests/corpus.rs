//! Real input: Cornell boxes that others drew, imported, solved, and repaired after a box has moved.
//!
//! The files are those of the outside corpus (`LIGHTMEND_CORPUS`): absolute and relative indices, groups and objects, materials whose
//! file is missing or elsewhere, one OBJ per wall. All are open in front, and three are some 556 units wide.

use serde_json::Value;
use std::{
    path::{Path, PathBuf},
    process::Command,
};

/// Reflectances of the McGuire box; the other files leave some or all of theirs to renderers of spectra.
const WHITE: &str = "0.725,0.71,0.68";
const RED: &str = "0.63,0.065,0.05";
const GREEN: &str = "0.14,0.45,0.091";
const PHOTONS: u64 = 100_000;

/// A box of the corpus and what its file does not say.
struct Cornell {
    folder: &'static str,
    models: &'static [&'static str],
    scale: &'static str,
    lamp: &'static str,
    reflectances: &'static [(&'static str, &'static str)],
    movable: &'static str,
    to: &'static str,
}

const BOXES: [Cornell; 4] = [
    Cornell {
        folder: "cornell_mcguire",
        models: &["CornellBox-Original.obj"],
        scale: "1",
        lamp: "0,1.78,0,10",
        reflectances: &[],
        movable: "shortBox",
        to: "(-0.25, 0.0, 0.08)",
    },
    Cornell {
        folder: "cornell_tobj",
        models: &["cornell_box.obj"],
        scale: "0.01",
        lamp: "2.78,5.2,2.795,100",
        reflectances: &[("white", WHITE), ("red", RED), ("green", GREEN)],
        movable: "short_block",
        to: "(0.6, 0.0, -0.2)",
    },
    Cornell {
        folder: "cornell_embree",
        models: &["cornell_box.obj"],
        scale: "0.01",
        lamp: "2.78,5.2,2.795,100",
        reflectances: &[("white", WHITE), ("red", RED), ("green", GREEN)],
        movable: "short_block",
        to: "(0.6, 0.0, -0.2)",
    },
    Cornell {
        folder: "cbox_lajolla",
        models: &[
            "meshes/cbox_back.obj",
            "meshes/cbox_ceiling.obj",
            "meshes/cbox_floor.obj",
            "meshes/cbox_greenwall.obj",
            "meshes/cbox_largebox.obj",
            "meshes/cbox_luminaire.obj",
            "meshes/cbox_redwall.obj",
            "meshes/cbox_smallbox.obj",
        ],
        scale: "0.01",
        lamp: "2.78,5.2,2.795,100",
        reflectances: &[("default", WHITE), ("cbox_redwall", RED), ("cbox_greenwall", GREEN)],
        movable: "cbox_smallbox",
        to: "(0.6, 0.0, -0.2)",
    },
];

/// Runs the program; its summary.
fn lightmend(arguments: &mut Command) -> Value {
    let output = arguments.args(["--quiet", "--json"]).output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {}: {error}", output.status);
    serde_json::from_slice(&output.stdout).unwrap()
}

fn program(command: &str) -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_lightmend"));
    program.arg(command);
    program
}

fn import(cornell: &Cornell, corpus: &Path, scene: &Path) {
    let mut command = program("import");
    command.args(cornell.models.iter().map(|model| corpus.join("scenes").join(cornell.folder).join(model)));
    command.args(["--scale", cornell.scale, "--lamp", cornell.lamp, "--movable", cornell.movable, "--out"]).arg(scene);
    for (name, reflectance) in cornell.reflectances {
        command.args(["--reflectance", &format!("{name}={reflectance}")]);
    }
    lightmend(&mut command);
}

#[test]
fn cornell_boxes_of_others_are_solved_and_repaired() {
    let Some(corpus) = std::env::var_os("LIGHTMEND_CORPUS").map(PathBuf::from) else {
        println!("skipped: LIGHTMEND_CORPUS is not set");
        return;
    };
    let photons = PHOTONS.to_string();
    for cornell in &BOXES {
        let name = cornell.folder;
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        std::fs::create_dir_all(&folder).unwrap();
        let scene = folder.join("scene.ron");
        import(cornell, &corpus, &scene);

        let solved = lightmend(program("solve").arg(&scene).args(["--photons", &photons, "--out"]).arg(folder.join("solved")));
        let count = |what: &str| solved[what].as_u64().unwrap();
        assert_eq!(count("absorbed") + count("escaped") + count("cut"), PHOTONS, "{name}");
        // Open in front: the lamp hangs near the middle, so a tenth escapes at once and more later.
        assert!(count("escaped") > PHOTONS / 5 && count("absorbed") > PHOTONS / 5, "{name}: {solved}");

        let moves = folder.join("moves.ron");
        let (object, to) = (cornell.movable, cornell.to);
        std::fs::write(&moves, format!("(edits: [(at: 0.0, edit: Move(object: \"{object}\", to: {to}))])\n")).unwrap();
        let mut replay = program("replay");
        replay.arg(&scene).arg("--script").arg(&moves).args(["--photons", &photons, "--out"]).arg(folder.join("replayed"));
        let edit = lightmend(&mut replay)["edits"][0].take();
        let relevant = edit["relevant_photons"].as_u64().unwrap();
        assert!((PHOTONS / 100..PHOTONS / 2).contains(&relevant), "{name}: {relevant} relevant photons");
        let orders = edit["orders"].as_object().unwrap();
        assert_eq!(orders.len(), 5, "{name}: {edit}");
        assert!(orders.values().all(|order| order["bit_equal_to_fresh"] == true), "{name}: {edit}");
        let rays = |order: &str| orders[order]["drained"]["rays"].as_u64().unwrap();
        assert!(rays("ledger") < rays("oracle") && rays("oracle") < rays("restart"), "{name}: {edit}");
    }
}
