//! The house: four furnished rooms, 10 × 8 × 2.7 m, joined by three doors; two lamps.
//!
//! It is the scene of many small elements: all meshes are cut to triangles of at most `EDGE`, which the scene's `cell` then divides.
//! The house is closed, so no light leaves it; the windows open onto nothing.

mod fixtures;
mod furnishing;
mod materials;
pub mod moves;
pub mod plan;
mod shell;

use crate::furniture::{bed, decor, kitchen, lights, seats, storage, store, study, table};
use crate::mesh::Mesh;
use crate::refine::refined;
use crate::scene::{Camera, Lamp, Object, Scene};
use crate::solid::v;
use plan::{DOORWAYS, SIZE};

/// Longest edge of a mesh element, metres: chosen for 378,000 elements. (Most are right-angled, their short sides about 8 cm.)
const CELL: f64 = 0.118;

/// Longest edge of a triangle of furniture, metres. Shorter: more triangles, fewer elements wasted on slivers.
const EDGE: f64 = 0.3;

/// The scene.
pub fn scene() -> Scene {
    let shell = shell::shell();
    let mut objects: Vec<Object> = shell.parts.iter().map(|p| Object::new(&p.name, "shell").part(&p.name)).collect();
    objects.push(Object::new("interior walls", "walls"));
    for (i, door) in DOORWAYS.iter().enumerate() {
        let [x, y] = door.hinge;
        objects.push(Object::new(&format!("door frame {}", i + 1), "door_frame").at(x, y, 0.0).turned(door.closed));
        // Leaves open clockwise and hang 8 mm above the floor.
        objects.push(Object::new(door.name, "door").movable().at(x, y, 0.008).turned(door.closed - door.ajar));
    }
    objects.extend(furnishing::all());
    let mut meshes: Vec<Mesh> = furniture().into_iter().map(|m| refined(m, EDGE)).collect();
    meshes.extend([shell, shell::walls()]);
    meshes.sort_by(|a, b| a.name.cmp(&b.name));
    Scene {
        name: "house",
        cell: CELL,
        materials: materials::of(&meshes),
        objects,
        lamps: lamps(),
        cameras: cameras(),
        meshes: ("meshes/", meshes),
    }
}

/// All meshes but the walls.
fn furniture() -> Vec<Mesh> {
    vec![
        fixtures::skirting(),
        fixtures::door_frame(),
        fixtures::door(),
        fixtures::window(),
        fixtures::curtains(),
        lights::panel_light(),
        lights::standing_lamp(),
        table::table(),
        table::coffee_table(),
        table::cup(),
        table::bowl(),
        table::oranges(),
        seats::chair(),
        seats::sofa(),
        seats::armchair(),
        seats::throw_pillow(),
        seats::pouf(),
        bed::bed(),
        bed::pillow(),
        bed::box_under_bed(),
        storage::shelf(),
        storage::wardrobe(),
        storage::nightstand(),
        storage::sideboard(),
        storage::chest(),
        storage::books("books_tall", 7, 0.36),
        storage::books("books_short", 40, 0.28),
        storage::books("books_mixed", 11, 0.42),
        storage::lying_books(),
        kitchen::counter(),
        kitchen::cupboards(),
        kitchen::refrigerator(),
        kitchen::pot(),
        kitchen::kettle(),
        kitchen::round_table(),
        kitchen::stool(),
        study::desk(),
        study::screen("screen", 0.6, 0.36, 0.1),
        study::screen("television", 1.1, 0.62, 0.06),
        store::carton("carton_large", 0.5, 0.4, 0.4),
        store::carton("carton_small", 0.36, 0.28, 0.22),
        store::crate_of_slats(),
        store::rolled_rug(),
        store::stepladder(),
        decor::rug(),
        decor::plant(),
        decor::vase("vase_tall", 0.30),
        decor::vase("vase_small", 0.16),
        decor::picture("picture_wide", 0.9, 0.55, ["sea", "sand", "sky"]),
        decor::picture("picture_high", 0.42, 0.58, ["leaf", "terracotta", "cream"]),
    ]
}

fn lamps() -> Vec<Lamp> {
    let lamp = |name, on, at: [f64; 3], tint: [f64; 3], file| Lamp {
        name,
        on,
        position: at.into(),
        rotation: v(0.0, 0.0, 0.0),
        intensity: tint.into(),
        photometry: Some(file),
    };
    // Each tint has a luminance of about one, so that the file's candela hold.
    let (warm, neutral) = ([1.18, 0.97, 0.72], [1.08, 0.99, 0.86]);
    let [x, y] = furnishing::PANEL;
    vec![
        lamp("panel", None, [x, y, SIZE[2] - 0.07], neutral, "ies/panel.ies"),
        lamp("standing lamp", Some("standing lamp"), lights::STANDING, warm, "ies/standing.ies"),
    ]
}

fn cameras() -> Vec<Camera> {
    let camera = |name, eye: [f64; 3], target: [f64; 3], fov| Camera { name, eye: eye.into(), target: target.into(), fov };
    vec![
        camera("living room", [5.7, 4.0, 1.75], [2.4, 1.6, 0.6], 65.0),
        camera("dining table", [3.3, 2.35, 1.5], [1.6, 3.1, 0.75], 55.0),
        camera("kitchen", [7.2, 4.65, 1.75], [8.7, 1.5, 0.7], 68.0),
        camera("bedroom", [5.4, 4.9, 1.7], [2.2, 6.8, 0.6], 68.0),
        camera("storage", [6.55, 5.2, 1.65], [8.7, 6.9, 0.7], 68.0),
        camera("kitchen door", [4.5, 2.45, 1.55], [8.4, 3.55, 0.95], 60.0),
        camera("bedroom door", [4.4, 1.9, 1.6], [5.1, 6.5, 1.0], 55.0),
    ]
}
