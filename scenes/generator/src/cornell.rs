//! The Cornell box: two metres wide, closed, after Goral et al. 1984 and the reflectances that later renderers agreed on.

use crate::mesh::{Mesh, Part};
use crate::scene::{Camera, Edit, Lamp, Object, Scene, moves};
use crate::shapes::grid_box;
use crate::solid::{Solid, v};
use crate::{File, shell};

const CELL: f64 = 0.15;
const SIDE: f64 = 2.0;

fn boxed(x: f64, y: f64, z: f64) -> Vec<Solid> {
    vec![grid_box(&[-x / 2.0, x / 2.0], &[-y / 2.0, y / 2.0], &[0.0, z]).of("white")]
}

/// The scene.
pub fn scene() -> Scene {
    let paint = |wall: &str| match wall {
        "west wall" => "red",
        "east wall" => "green",
        _ => "white",
    };
    let walls: Vec<Part> = shell::walls(SIDE, SIDE, SIDE, paint);
    let mut objects: Vec<Object> = walls.iter().map(|p| Object::new(&p.name, "box").part(&p.name)).collect();
    for o in objects.iter_mut().zip(&walls).filter(|(_, p)| p.name == "south wall").map(|(o, _)| o) {
        *o = o.clone().hidden();
    }
    objects.push(Object::new("short box", "short_box").movable().at(1.32, 0.68, 0.0).turned(-17.0));
    objects.push(Object::new("tall box", "tall_box").movable().at(0.66, 1.3, 0.0).turned(18.0));
    Scene {
        name: "cornell",
        cell: CELL,
        materials: vec![
            ("green", [0.14, 0.45, 0.091], None),
            ("red", [0.63, 0.065, 0.05], None),
            ("white", [0.725, 0.71, 0.68], None),
        ],
        objects,
        lamps: vec![Lamp {
            name: "lamp",
            on: None,
            position: v(1.0, 1.0, 1.9),
            rotation: v(0.0, 0.0, 0.0),
            // About 2,000 lm in all, warm white.
            intensity: v(170.0, 155.0, 125.0),
            photometry: None,
        }],
        // Outside the box, looking through its south wall.
        cameras: vec![Camera { name: "front", eye: v(1.0, -2.7, 1.0), target: v(1.0, 1.0, 1.0), fov: 40.0 }],
        meshes: (
            "",
            vec![
                Mesh { name: "box".into(), parts: walls },
                Mesh::new("short_box", boxed(0.6, 0.6, 0.6)),
                Mesh::new("tall_box", boxed(0.6, 0.6, 1.2)),
            ],
        ),
    }
}

/// Its moves files.
pub fn scripts() -> Vec<File> {
    vec![
        File::text("cornell/moves/short_box.ron", moves(&[(0.0, Edit::Move("short box", v(1.5, 0.45, 0.0)))], None)),
        File::text("cornell/moves/tall_box_turn.ron", moves(&[(0.0, Edit::Turn("tall box", 48.0))], None)),
    ]
}
