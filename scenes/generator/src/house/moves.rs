//! What is moved in the house, one file each, and all of it in a row. Every end and every way is free of other things.

use super::furnishing::{CUP, DARK_TABLE, LAMP, TABLE, WARDROBE};
use super::plan::DOORWAYS;
use super::scene;
use crate::File;
use crate::furniture::table;
use crate::scene::{Edit, moves};
use crate::solid::v;

/// Where the lamp is set down on its way from the bedroom, through the doorway, to the end of the sofa.
const WAY: [[f64; 2]; 5] = [[5.3, 5.3], [5.3, 4.46], [5.3, 3.7], [4.55, 2.7], [4.55, 0.5]];

/// The moves files.
pub fn scripts() -> Vec<File> {
    let to = |object, [x, y]: [f64; 2], by: f64| Edit::Move(object, v(x + by, y, 0.0));
    let cup = || Edit::Move("table: cup west", v(CUP[0] + 0.3, CUP[1], table::TOP));
    let [kitchen, ..] = DOORWAYS;
    let door = |open: f64| Edit::Turn(kitchen.name, kitchen.closed - open);
    // The table of the unlit room goes towards the shelf, where its chair is not in the way.
    let dark_table = || to("dark table", DARK_TABLE, -0.5);
    let lamp = |from: f64, way: &[[f64; 2]]| -> Vec<(f64, Edit)> {
        way.iter().enumerate().map(|(i, p)| (from + i as f64, to("standing lamp", *p, 0.0))).collect()
    };
    let mut all = vec![
        (0.0, to("table", TABLE, 0.5)),
        (1.0, cup()),
        (2.0, to("wardrobe", WARDROBE, 0.8)),
        (3.0, dark_table()),
        (4.0, door(0.0)),
        (6.0, door(kitchen.ajar)),
        (7.0, Edit::Drag("table", v(TABLE[0], TABLE[1], 0.0), 0.05, 0.5)),
    ];
    all.extend(lamp(9.0, &WAY));
    let mut back = WAY;
    back.reverse();
    let mut back = back[1..].to_vec();
    back.push(LAMP);
    all.extend(lamp(15.0, &back));
    let file = |name: &str, edits: &[(f64, Edit)], camera: &str| {
        File::text(&format!("house/moves/{name}.ron"), moves(edits, scene().camera(camera)))
    };
    vec![
        file("all", &all, "living room"),
        file("cup", &[(0.0, cup())], "dining table"),
        file("dark_table", &[(0.0, dark_table())], "storage"),
        file("door", &[(0.0, door(0.0))], "kitchen door"),
        file("lamp", &lamp(0.0, &WAY), "bedroom door"),
        file("table", &[(0.0, to("table", TABLE, 0.5))], "living room"),
        file("wardrobe", &[(0.0, to("wardrobe", WARDROBE, 0.8))], "bedroom"),
    ]
}
