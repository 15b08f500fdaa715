//! Every kind of edit and back again; what is written of either is read as the same.

use crate::{
    Configuration, Edit, Scene,
    format::{LampEntry, ObjectEntry, write_ron},
};
use glam::DVec3;
use proptest::{
    prelude::*,
    test_runner::{RngAlgorithm, TestRng, TestRunner},
};
use std::{fs, path::Path, sync::Arc};

/// Two meshes that mean different things by "wood", one of them textured; a third with a material of its own comes by edits only.
const SCENE: &str = r#"(
    name: "mtl", up: z, cell: 0.5,
    materials: { "oak": (reflectance: (0.5, 0.35, 0.2)), "rug": (reflectance: (1.0, 0.9, 0.8), texture: "textures/a.png") },
    objects: [
        (name: "floor", mesh: "meshes/floor.obj"),
        (name: "table", mesh: "meshes/a.obj", movable: true, position: (1.0, 0.0, 0.5), rotation: (0.0, 0.0, 10.0)),
        (name: "tray", mesh: "meshes/b.obj", movable: true, on: "table", position: (0.1, 0.2, 0.3)),
        (name: "cup", mesh: "meshes/b.obj", movable: true, on: "tray", position: (0.0, 0.1, 0.1), material: "oak"),
        (name: "shelf", mesh: "meshes/b.obj", position: (3.0, 0.0, 1.0)),
    ],
    lamps: [
        (name: "pendant", position: (0.0, 0.0, 2.0), intensity: (1.0, 0.9, 0.8), rated: (2.0, 2.0, 2.0), photometry: "ies/lamp.ies"),
        (name: "candle", on: "tray", position: (0.0, 0.0, 0.4), intensity: (3.0, 2.0, 1.0), off: true),
    ],
)"#;

const IES: &str = "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 3 1 1 2 0.1 0.1 0\n1 1 50\n0 45 90\n0\n300 200 100\n";

fn mesh(library: &str, material: &str, uv: bool) -> String {
    let (coordinates, face) = if uv { ("vt 0 0\nvt 1 0\nvt 0 1\n", "f 1/1 2/2 3/3") } else { ("", "f 1 2 3") };
    format!("mtllib {library}\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{coordinates}o part\nusemtl {material}\n{face}\n")
}

fn mtl_scene(folder: &Path) -> Arc<Scene> {
    for sub in ["meshes", "textures", "ies"] {
        fs::create_dir_all(folder.join(sub)).unwrap();
    }
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).unwrap();
    write("meshes/a.mtl", "newmtl wood\nKd 0.6 0.4 0.2\nmap_Kd ../textures/a.png\n");
    write("meshes/b.mtl", "newmtl wood\nKd 0.1 0.2 0.3\n");
    write("meshes/c.mtl", "newmtl cloth\nKd 0.3 0.3 0.9\nnewmtl wood\nKd 0.9 0.9 0.9\n");
    write("meshes/a.obj", &mesh("a.mtl", "wood", true));
    write("meshes/b.obj", &mesh("b.mtl", "wood", false));
    write("meshes/c.obj", &(mesh("c.mtl", "cloth", true) + "usemtl wood\nf 3/1 2/2 1/3\n"));
    write("meshes/floor.obj", &mesh("none.mtl", "oak", true));
    for (name, red) in [("a", 200), ("b", 90)] {
        image::RgbImage::from_pixel(2, 2, image::Rgb([red, 100, 50])).save(folder.join(format!("textures/{name}.png"))).unwrap();
    }
    write("ies/lamp.ies", IES);
    write("mtl.ron", SCENE);
    Scene::read(&folder.join("mtl.ron")).unwrap().0
}

fn entry(name: &str, mesh: &str, on: Option<&str>) -> ObjectEntry {
    ObjectEntry {
        name: name.into(),
        mesh: mesh.into(),
        part: None,
        position: DVec3::new(0.5, 0.25, 0.1),
        rotation: DVec3::Z * 30.0,
        on: on.map(Into::into),
        movable: true,
        material: None,
        hidden_from_camera: false,
    }
}

/// Makes the edit and takes it back; the configuration after it.
fn leads_home(before: &Configuration, edit: &Edit) -> Configuration {
    let after = before.apply(edit).unwrap_or_else(|e| panic!("{edit:?}: {e}"));
    let inverse = edit.inverse(before).unwrap();
    let home =
        inverse.iter().fold(after.clone(), |at, back| at.apply(back).unwrap_or_else(|e| panic!("{edit:?}: {back:?}: {e}")));
    assert!(home == *before, "{edit:?} and back by {inverse:?}");
    assert_eq!(home.to_file(), before.to_file(), "{edit:?} and back by {inverse:?}");
    assert_eq!(home.content_hash(), before.content_hash(), "{edit:?} and back by {inverse:?}");
    assert!(home.apply(edit).unwrap() == after, "{edit:?}, back, and made again");
    after
}

/// Writes the scene to another folder and reads it as any other.
fn reads_the_same(configuration: &Configuration) {
    let folder = tempfile::tempdir().unwrap();
    let mut file = configuration.to_file();
    file.relocate(configuration.scene().path.parent().unwrap(), folder.path()).unwrap();
    let path = folder.path().join("written.ron");
    write_ron(&path, &file).unwrap();
    let read = Configuration::initial(&Scene::read(&path).unwrap().0);
    assert!(
        read.content_hash() == configuration.content_hash(),
        "it was {:?}\nand is {:?}",
        configuration.to_file(),
        read.to_file()
    );
    // A scene has them in order of their names.
    file.objects.sort_by(|a, b| a.name.cmp(&b.name));
    file.lamps.sort_by(|a, b| a.name.cmp(&b.name));
    assert!(read.to_file() == file, "it was {file:?}\nand is {:?}", read.to_file());
}

#[test]
fn every_edit_of_the_room_has_an_inverse() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/room/room.ron");
    let (scene, _) = Scene::read(&path).unwrap();
    let mut configuration = Configuration::initial(&scene);
    let (name, to, object) = (|name: &str| name.to_owned(), DVec3::new(2.0, 1.5, 0.25), || "table".to_owned());
    let lamp = || "reading lamp".to_owned();
    for edit in [
        Edit::Move { object: object(), to },
        Edit::Turn { object: object(), to: DVec3::Z * 30.0 },
        Edit::Drag { object: object(), to: to * 0.5, step: 0.05, seconds: 1.0 },
        Edit::Put { object: name("bowl"), on: None, to, rotation: DVec3::Z * 5.0 },
        Edit::Put { object: name("bowl"), on: Some(name("cup west")), to: DVec3::Z * 0.1, rotation: DVec3::ZERO },
        Edit::Put { object: name("cup west"), on: Some(name("nightstand")), to: DVec3::Z * 0.5, rotation: DVec3::ZERO },
        Edit::Paint { object: object(), material: Some(name("china")) },
        Edit::Paint { object: object(), material: None },
        Edit::Paint { object: name("sofa"), material: None },
        Edit::Reflect { material: name("beech"), to: DVec3::splat(0.2) },
        Edit::Texture { material: name("beech"), texture: Some(name("textures/rug.png")) },
        Edit::Texture { material: name("beech"), texture: None },
        Edit::AddMaterial { name: name("felt"), reflectance: DVec3::splat(0.3), texture: None },
        Edit::Paint { object: name("pouf"), material: Some(name("felt")) },
        Edit::Paint { object: name("pouf"), material: None },
        Edit::RemoveMaterial { material: name("felt") },
        Edit::Duplicate { object: object(), name: name("other table"), to },
        Edit::Add(entry("new", "meshes/cup.obj", Some("other table"))),
        Edit::Remove { object: name("other table") },
        Edit::Remove { object: object() },
        Edit::MoveLamp { lamp: lamp(), to: DVec3::new(0.4, 0.0, 1.4) },
        Edit::TurnLamp { lamp: lamp(), to: DVec3::X * 20.0 },
        Edit::Light { lamp: lamp(), intensity: DVec3::new(0.5, 0.0, 2.0) },
        Edit::Switch { lamp: lamp(), on: false },
        Edit::Relamp { lamp: lamp(), photometry: None, intensity: Some(DVec3::splat(400.0)) },
        Edit::Light { lamp: lamp(), intensity: DVec3::new(0.5, 0.0, 2.0) },
        Edit::Relamp { lamp: lamp(), photometry: Some(name("ies/washer.ies")), intensity: Some(DVec3::ONE) },
        Edit::Relamp { lamp: lamp(), photometry: Some(name("ies/pendant.ies")), intensity: None },
        Edit::DuplicateLamp { lamp: lamp(), name: name("second"), to },
        Edit::Light { lamp: lamp(), intensity: DVec3::splat(0.1) },
        Edit::RemoveLamp { lamp: name("second") },
        Edit::AddLamp(LampEntry { name: name("third"), ..scene.lamps[0].stated() }),
        Edit::Remove { object: name("floor lamp") },
        Edit::Remove { object: name("north wall") },
    ] {
        configuration = leads_home(&configuration, &edit);
    }
    reads_the_same(&configuration);
}

#[test]
fn a_changed_material_of_a_mesh_stays_the_meshes() {
    // Regression: what a mesh's file says was compared with what edits had made of it.
    let folder = tempfile::tempdir().unwrap();
    let start = Configuration::initial(&mtl_scene(folder.path()));
    let name = |name: &str| name.to_owned();
    let mut configuration = start.clone();
    for edit in [
        Edit::Reflect { material: name("wood"), to: DVec3::splat(0.25) },
        Edit::Texture { material: name("wood"), texture: Some(name("textures/b.png")) },
        Edit::Reflect { material: name("wood (meshes/a.obj)"), to: DVec3::splat(0.125) },
        Edit::Paint { object: name("shelf"), material: Some(name("rug")) },
        Edit::Paint { object: name("shelf"), material: None },
        Edit::Paint { object: name("table"), material: Some(name("rug")) },
        Edit::Paint { object: name("table"), material: None },
        Edit::Remove { object: name("table") },
        Edit::Add(entry("table", "meshes/a.obj", None)),
        Edit::Add(entry("box", "meshes/c.obj", Some("table"))),
        Edit::Paint { object: name("box"), material: Some(name("cloth")) },
        Edit::Paint { object: name("box"), material: None },
    ] {
        configuration = leads_home(&configuration, &edit);
        reads_the_same(&configuration);
    }
    let [wood, other] = ["wood", "wood (meshes/a.obj)"].map(|name| start.state().materials[name].clone());
    assert!(wood.texture.is_none() && other.texture.is_some(), "objects are read in order of names");
    let of = |object: &str| &*configuration.object(configuration.object_id(object).unwrap()).materials[0].name;
    assert_eq!([of("shelf"), of("table"), of("box")], ["wood", "wood (meshes/a.obj)", "cloth"]);
}

#[test]
fn what_does_not_fit_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let start = Configuration::initial(&mtl_scene(folder.path()));
    let refused = |edit: Edit, told: &str| {
        let error = start.apply(&edit).map(drop).unwrap_err().to_string();
        assert!(error.contains(told) && !error.contains('\n'), "{error}");
    };
    let put =
        |object: &str, on: &str| Edit::Put { object: object.into(), on: Some(on.into()), to: DVec3::ZERO, rotation: DVec3::ZERO };
    refused(put("table", "cup"), "object 'table' cannot be put on 'cup', which rides on it");
    refused(put("table", "table"), "object 'table' cannot be put on itself");
    refused(put("floor", "table"), "'floor' is fixed");
    refused(put("table", "cap"), "did you mean 'cup'?");
    refused(Edit::RemoveMaterial { material: "oak".into() }, "material 'oak' is used by object '");
    let add = |name: &str, reflectance: f64| Edit::AddMaterial {
        name: name.into(),
        reflectance: DVec3::splat(reflectance),
        texture: None,
    };
    refused(add("oak", 0.5), "already");
    refused(add("wood (meshes/floor.obj)", 1.5), "within 0 to 1");
    refused(add("oak (meshes/floor.obj)", 0.5), "kept for a material of object 'floor'");
    refused(Edit::Texture { material: "oak".into(), texture: Some("none.png".into()) }, "none.png");
    let bright = |intensity| Edit::Relamp { lamp: "candle".into(), photometry: None, intensity: Some(intensity) };
    refused(bright(DVec3::splat(1e308)), "candela");
    refused(bright(DVec3::new(-1.0, 0.0, 0.0)), "candela");
    let mut warnings = Vec::new();
    let texture = Edit::Texture { material: "wood".into(), texture: Some("textures/b.png".into()) };
    start.apply_warning(&texture, &mut warnings).unwrap();
    assert!(warnings.iter().any(|w| w.0.contains("object 'shelf'") && w.0.contains("no texture coordinates")), "{warnings:?}");
}

/// A kind of edit, what it is done to, and numbers for it.
type Step = (usize, prop::sample::Index, prop::sample::Index, [f64; 3]);

/// `None` where there is nothing to do it to.
fn edit(at: &Configuration, (kind, one, other, by): &Step, number: usize) -> Option<Edit> {
    let by = DVec3::from_array(*by);
    let pick = |of: Vec<String>, index: &prop::sample::Index| (!of.is_empty()).then(|| of[index.index(of.len())].clone());
    let objects = |all: bool| at.objects().filter(|(_, o)| all || o.movable).map(|(_, o)| o.name.clone()).collect::<Vec<_>>();
    let object = || pick(objects(false), one);
    let lamp = || pick(at.lamps().map(|(_, l)| l.name.clone()).collect(), one);
    let material = |index| pick(at.state().materials.keys().cloned().collect(), index);
    let texture = || [None, Some("textures/a.png".to_owned()), Some("textures/b.png".to_owned())][other.index(3)].clone();
    let meshes = ["meshes/a.obj", "meshes/b.obj", "meshes/c.obj"];
    let on = || if by.y > 0.3 { None } else { pick(objects(true), other) };
    Some(match kind {
        0 => Edit::Move { object: object()?, to: by },
        1 => Edit::Turn { object: object()?, to: by * 100.0 },
        2 | 3 => Edit::Put { object: object()?, on: on(), to: by, rotation: by * 10.0 },
        4 => Edit::Paint { object: pick(objects(true), one)?, material: material(other) },
        5 => Edit::Paint { object: pick(objects(true), one)?, material: None },
        6 => Edit::Reflect { material: material(one)?, to: by.abs() },
        7 => Edit::Texture { material: material(one)?, texture: texture() },
        8 => Edit::AddMaterial {
            name: [format!("m{number}"), "wood".into(), "cloth".into()][one.index(3)].clone(),
            reflectance: by.abs(),
            texture: texture(),
        },
        9 => Edit::RemoveMaterial { material: material(one)? },
        10 => {
            let names = ["table".into(), "cup".into(), format!("o{number}")];
            Edit::Add(ObjectEntry {
                movable: by.x > 0.0,
                position: by,
                ..entry(&names[one.index(3)], meshes[other.index(3)], on().as_deref())
            })
        }
        11 => Edit::Duplicate { object: pick(objects(true), one)?, name: format!("o{number}"), to: by },
        12 => Edit::Remove { object: pick(objects(true), one)? },
        13 => Edit::Light { lamp: lamp()?, intensity: by.abs() },
        14 => Edit::Switch { lamp: lamp()?, on: by.x > 0.0 },
        15 => Edit::Relamp {
            lamp: lamp()?,
            photometry: (by.x > 0.0).then(|| "ies/lamp.ies".into()),
            intensity: (by.y > 0.0).then(|| by.abs()),
        },
        16 => Edit::AddLamp(LampEntry { name: format!("l{number}"), on: on(), ..at.scene().lamps[one.index(2)].stated() }),
        17 => Edit::DuplicateLamp { lamp: lamp()?, name: format!("l{number}"), to: by },
        18 => Edit::RemoveLamp { lamp: lamp()? },
        19 => Edit::MoveLamp { lamp: lamp()?, to: by },
        _ => Edit::TurnLamp { lamp: lamp()?, to: by * 100.0 },
    })
}

#[test]
fn whatever_is_done_can_be_undone_and_written() {
    let folder = tempfile::tempdir().unwrap();
    let start = Configuration::initial(&mtl_scene(folder.path()));
    let config = ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let index = any::<prop::sample::Index>;
    let steps = prop::collection::vec((0usize..21, index(), index(), prop::array::uniform3(-1.0f64..1.0)), 1..40);
    runner
        .run(&steps, |steps| {
            let mut configuration = start.clone();
            let mut undo: Vec<Edit> = Vec::new();
            for (number, step) in steps.iter().enumerate() {
                let Some(edit) = edit(&configuration, step, number) else { continue };
                if configuration.apply(&edit).is_ok() {
                    let mut inverse = edit.inverse(&configuration).unwrap();
                    configuration = leads_home(&configuration, &edit);
                    inverse.reverse();
                    undo.extend(inverse);
                }
            }
            reads_the_same(&configuration);
            while let Some(edit) = undo.pop() {
                configuration = configuration.apply(&edit).unwrap_or_else(|e| panic!("{edit:?}: {e}"));
            }
            prop_assert!(configuration == start, "undoing everything leaves a trace");
            prop_assert_eq!(configuration.to_file(), start.to_file());
            Ok(())
        })
        .unwrap();
}
