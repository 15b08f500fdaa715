//! What is moved in the room, one file each, and all of it in a row. Every end is free of other things.

use super::{TABLE, scene};
use crate::File;
use crate::furniture::table;
use crate::scene::{Edit, moves};
use crate::solid::v;

/// The moves files.
pub fn scripts() -> Vec<File> {
    let [x, y] = TABLE;
    let to_table = || Edit::Move("table", v(x + 0.5, y, 0.0));
    let chest = || Edit::Move("chest", v(5.65, 0.32, 0.0));
    let bed_box = || Edit::Move("box under bed", v(4.75, 3.42, 0.0));
    let cup = || Edit::Move("cup west", v(-0.35 + 0.3, -0.2, table::TOP));
    let wardrobe = || Edit::Move("wardrobe", v(5.66 - 0.8, 4.3, 0.0));
    let door = || Edit::Turn("door", -87.0);
    // Twenty-two steps of 5 cm, twenty a second.
    let drag = |back: bool| Edit::Drag("table", v(if back { x } else { x + 1.1 }, y, 0.0), 0.05, 1.1);
    let all = [
        (0.0, to_table()),
        (1.0, cup()),
        (2.0, wardrobe()),
        (3.0, bed_box()),
        (4.0, chest()),
        (5.0, door()),
        (6.0, Edit::Move("table", v(x, y, 0.0))),
        (7.0, drag(false)),
        (9.0, drag(true)),
        (11.0, Edit::Turn("door", -7.0)),
    ];
    let seen = |camera: &str| scene().camera(camera);
    let file = |name: &str, edits: &[(f64, Edit)], camera| File::text(&format!("room/moves/{name}.ron"), moves(edits, camera));
    vec![
        file("all", &all, None),
        file("bed_box", &[(0.0, bed_box())], seen("bed")),
        file("cup", &[(0.0, cup())], seen("table")),
        file("door", &[(0.0, door())], seen("wardrobe")),
        file("drag", &[(0.0, drag(false))], None),
        file("screen_box", &[(0.0, chest())], seen("chest")),
        file("table", &[(0.0, to_table())], None),
        file("wardrobe", &[(0.0, wardrobe())], None),
    ]
}
