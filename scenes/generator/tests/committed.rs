//! The scenes in the repository are what the generator writes, and what it writes is sound.

use std::path::Path;

use lightmend_scenes::{files, house, room, scenes};

#[test]
fn regenerating_changes_nothing() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the generator lies in scenes/");
    for file in files().expect("files") {
        let committed = std::fs::read(folder.join(&file.path)).unwrap_or_else(|e| panic!("{}: {e}", file.path));
        assert!(committed == file.bytes, "{} differs: run `cargo run -p lightmend-scenes -- scenes`", file.path);
    }
}

#[test]
fn every_solid_is_closed_and_faces_outwards() {
    for scene in scenes() {
        for mesh in scene.meshes.1.iter().filter(|m| !["shell", "box"].contains(&m.name.as_str())) {
            for (i, s) in mesh.solids().enumerate() {
                assert_eq!(s.defect(), None, "{} solid {i}, {}", mesh.name, s.material);
                assert!(s.volume() > 0.0, "{} solid {i}, {} faces inwards", mesh.name, s.material);
            }
        }
    }
}

#[test]
fn every_material_is_known() {
    for scene in scenes() {
        for s in scene.meshes.1.iter().flat_map(|m| m.solids()) {
            assert!(scene.materials.iter().any(|m| m.0 == s.material), "{}", s.material);
        }
    }
}

/// The element count that the figures of the method's paper were measured at.
#[test]
fn the_room_has_about_12_400_elements() {
    let n = room::scene().elements() as f64;
    assert!((n / 12_400.0 - 1.0).abs() < 0.03, "{n}");
}

/// The scene in which the cost of many small elements and of many movable objects is measured.
#[test]
fn the_house_has_about_378_000_elements_and_much_to_move() {
    let house = house::scene();
    let n = house.elements() as f64;
    assert!((n / 378_000.0 - 1.0).abs() < 0.02, "{n}");
    let movables = house.movables().count();
    assert!(movables >= 60, "{movables}");
}
