//! What stands in the four rooms, and what lies on it and goes where it goes.
//!
//! Backs stand 1.6 cm and more from a wall: its skirting board is between them.

use super::plan::{SIZE, WALL_EAST, WALL_WEST};
use crate::furniture::{kitchen, storage, table};
use crate::scene::Object;

/// Where the ceiling light of the living room is, x and y in metres.
pub const PANEL: [f64; 2] = [4.0, 2.5];

/// Where the dining table stands at first.
pub const TABLE: [f64; 2] = [1.7, 3.0];

/// Where the cup of `cup.ron` stands on the dining table at first.
pub const CUP: [f64; 2] = [-0.35, -0.2];

/// Where the wardrobe stands at first.
pub const WARDROBE: [f64; 2] = [2.6, 7.68];

/// Where the table of the storage room stands at first.
pub const DARK_TABLE: [f64; 2] = [8.65, 6.4];

/// Where the standing lamp stands at first.
pub const LAMP: [f64; 2] = [4.55, 7.2];

/// Pictures hang 2 mm in front of their wall.
const HUNG: f64 = 0.002;

fn here(name: &str, mesh: &str) -> Object {
    Object::new(name, mesh).movable()
}

/// A movable thing whose name is that of its carrier and its own.
fn on(carrier: &str, name: &str, mesh: &str) -> Object {
    Object::new(&format!("{carrier}: {name}"), mesh).movable().on(carrier)
}

/// All of it.
pub fn all() -> Vec<Object> {
    [living(), kitchen_and_desk(), bedroom(), storage_room()].concat()
}

/// Books and vases on a shelf, not the same on each.
fn stocked(shelf: &str, kind: usize) -> Vec<Object> {
    let b = storage::BOARDS;
    let meshes = ["books_tall", "books_short", "books_mixed"];
    let books = |name: &str, i: usize, x: f64, board: usize| on(shelf, name, meshes[(i + kind) % 3]).at(x, 0.0, b[board]);
    vec![
        books("books above", 0, -0.44, 3),
        books("books in the middle", 1, -0.05, 2),
        books("books below", 2, -0.43, 1),
        books("books at the foot", 0, 0.02, 0),
        on(shelf, "pile", "lying_books").at(-0.27, 0.0, b[2]).turned(6.0 * kind as f64),
        on(shelf, "vase", if kind == 1 { "vase_small" } else { "vase_tall" }).at(0.27, 0.0, b[3]),
    ]
}

fn living() -> Vec<Object> {
    let [x, y] = TABLE;
    let north = WALL_WEST[0];
    let mut all = vec![
        Object::new("ceiling light", "panel_light").at(PANEL[0], PANEL[1], SIZE[2]),
        Object::new("west window", "window").at(0.0, 3.0, 0.0).turned(-90.0),
        Object::new("west curtains", "curtains").at(0.0, 3.0, 0.0).turned(-90.0),
        here("table", "table").at(x, y, 0.0),
        here("chair south west", "chair").at(x - 0.34, y - 0.71, 0.0).turned(4.0),
        here("chair south east", "chair").at(x + 0.36, y - 0.67, 0.0).turned(-14.0),
        here("chair north west", "chair").at(x - 0.33, y + 0.7, 0.0).turned(183.0),
        here("chair north east", "chair").at(x + 0.34, y + 0.71, 0.0).turned(176.0),
        on("table", "cup west", "cup").at(CUP[0], CUP[1], table::TOP).turned(30.0),
        on("table", "cup east", "cup").at(0.38, 0.16, table::TOP).turned(200.0),
        on("table", "cup south", "cup").at(0.33, -0.24, table::TOP).turned(80.0),
        on("table", "bowl", "bowl").at(0.02, 0.05, table::TOP),
        Object::new("oranges", "oranges").movable().on("table: bowl").at(0.0, 0.0, 0.03),
        here("sofa", "sofa").at(3.2, 0.5, 0.0),
        on("sofa", "pillow left", "throw_pillow").at(-0.55, 0.02, 0.445).turned(-12.0),
        on("sofa", "pillow right", "throw_pillow").at(0.56, 0.02, 0.445).turned(9.0),
        here("rug", "rug").at(3.3, 1.75, 0.0),
        here("coffee table", "coffee_table").at(3.2, 1.7, 0.0101),
        on("coffee table", "books", "lying_books").at(-0.22, 0.05, table::LOW).turned(15.0),
        on("coffee table", "cup", "cup").at(0.2, -0.08, table::LOW).turned(140.0),
        on("coffee table", "vase", "vase_small").at(0.34, 0.12, table::LOW),
        here("armchair east", "armchair").at(5.35, 1.5, 0.0).turned(78.0),
        here("armchair west", "armchair").at(1.3, 1.15, 0.0).turned(-72.0),
        here("pouf", "pouf").at(3.85, 2.65, 0.0),
        here("sideboard", "sideboard").at(3.3, north - 0.23, 0.0).turned(180.0),
        on("sideboard", "television", "television").at(0.1, -0.02, storage::SIDEBOARD),
        on("sideboard", "vase", "vase_tall").at(-0.65, 0.0, storage::SIDEBOARD),
        here("shelf", "shelf").at(0.18, 1.2, 0.0).turned(-90.0),
        here("plant west", "plant").at(0.46, 0.42, 0.0),
        here("plant east", "plant").at(5.72, 0.46, 0.0).turned(50.0),
        here("picture over the sofa", "picture_wide").at(3.2, HUNG, 1.55),
        here("picture by the table", "picture_high").at(1.7, north - HUNG, 1.6).turned(180.0),
    ];
    all.extend(stocked("shelf", 0));
    all
}

fn kitchen_and_desk() -> Vec<Object> {
    let mut all = vec![
        Object::new("counter", "counter").at(9.68, 1.35, 0.0).turned(90.0),
        Object::new("wall cupboards", "cupboards").at(SIZE[0] - 0.001, 1.35, 1.45).turned(90.0),
        Object::new("south window", "window").at(7.3, 0.0, 0.0),
        here("pot", "pot").at(9.55, 1.69, kitchen::WORKTOP + 0.0142).turned(20.0),
        here("kettle", "kettle").at(9.79, 1.98, kitchen::WORKTOP + 0.0142).turned(150.0),
        here("bowl", "bowl").at(9.66, 2.35, kitchen::WORKTOP),
        here("kitchen cup", "cup").at(9.58, 0.22, kitchen::WORKTOP).turned(100.0),
        here("refrigerator", "refrigerator").at(9.66, 2.95, 0.0).turned(90.0),
        here("breakfast table", "round_table").at(8.3, 3.5, 0.0),
        here("stool west", "stool").at(7.62, 3.3, 0.0).turned(10.0),
        here("stool north", "stool").at(7.85, 4.08, 0.0).turned(35.0),
        here("stool south", "stool").at(8.75, 2.95, 0.0).turned(70.0),
        on("breakfast table", "cup west", "cup").at(-0.22, -0.12, table::TOP).turned(160.0),
        on("breakfast table", "cup north", "cup").at(0.02, 0.27, table::TOP).turned(60.0),
        on("breakfast table", "bowl", "bowl").at(0.12, 0.0, table::TOP),
        Object::new("breakfast oranges", "oranges").movable().on("breakfast table: bowl").at(0.0, 0.0, 0.03).turned(40.0),
        here("desk", "desk").at(7.3, 0.36, 0.0),
        on("desk", "screen", "screen").at(-0.16, -0.12, table::TOP).turned(-6.0),
        on("desk", "books", "lying_books").at(0.42, -0.05, table::TOP).turned(12.0),
        on("desk", "cup", "cup").at(0.22, 0.14, table::TOP).turned(-40.0),
        here("desk chair", "chair").at(7.1, 0.96, 0.0).turned(172.0),
        here("kitchen shelf", "shelf").at(6.5, 1.65, 0.0).turned(-90.0),
        here("kitchen plant", "plant").at(9.5, 4.42, 0.0).turned(110.0),
        here("kitchen picture", "picture_wide").at(7.1, WALL_EAST[0] - HUNG, 1.6).turned(180.0),
    ];
    all.extend(stocked("kitchen shelf", 1));
    all
}

fn bedroom() -> Vec<Object> {
    let south = WALL_WEST[1];
    let mut all = vec![
        Object::new("north window", "window").at(5.12, SIZE[1], 0.0).turned(180.0),
        Object::new("north curtains", "curtains").at(5.12, SIZE[1], 0.0).turned(180.0),
        here("bed", "bed").at(1.06, 6.35, 0.0),
        on("bed", "pillow south", "pillow").at(-0.7, -0.36, 0.53),
        on("bed", "pillow north", "pillow").at(-0.7, 0.35, 0.53).turned(6.0),
        here("box under the bed", "box_under_bed").at(1.1, 6.1, 0.0).turned(5.0),
        here("wardrobe", "wardrobe").at(WARDROBE[0], WARDROBE[1], 0.0).turned(180.0),
        here("bedroom chest", "chest").at(2.45, 6.35, 0.0).turned(-90.0),
        here("dresser", "sideboard").at(2.6, south + 0.23, 0.0),
        on("dresser", "vase tall", "vase_tall").at(-0.55, 0.0, storage::SIDEBOARD),
        on("dresser", "vase small", "vase_small").at(-0.36, 0.05, storage::SIDEBOARD),
        on("dresser", "books", "books_short").at(0.25, 0.0, storage::SIDEBOARD),
        here("bedroom rug", "rug").at(3.85, 5.9, 0.0),
        here("bedroom armchair", "armchair").at(5.4, 6.95, 0.0).turned(152.0),
        on("bedroom armchair", "pillow", "throw_pillow").at(0.0, 0.0, 0.425).turned(5.0),
        here("bedroom pouf", "pouf").at(5.75, 6.05, 0.0),
        here("standing lamp", "standing_lamp").at(LAMP[0], LAMP[1], 0.0),
        here("bedroom chair", "chair").at(0.75, south + 0.38, 0.0).turned(-10.0),
        here("picture over the bed", "picture_wide").at(HUNG, 6.35, 1.6).turned(-90.0),
        here("picture over the dresser", "picture_high").at(2.6, south + HUNG, 1.6),
    ];
    for (name, y, thing) in [("nightstand south", 5.36, "lying_books"), ("nightstand north", 7.34, "cup")] {
        all.push(here(name, "nightstand").at(0.22, y, 0.0).turned(-90.0));
        all.push(on(name, "thing", thing).at(0.04, 0.02, 0.5).turned(-20.0));
    }
    all
}

fn storage_room() -> Vec<Object> {
    let b = storage::BOARDS;
    let top = table::TOP;
    vec![
        here("dark table", "table").at(DARK_TABLE[0], DARK_TABLE[1], 0.0),
        on("dark table", "carton", "carton_small").at(0.35, 0.1, top).turned(12.0),
        on("dark table", "bowl", "bowl").at(-0.25, -0.1, top),
        on("dark table", "books", "lying_books").at(-0.05, 0.22, top).turned(-30.0),
        here("store shelf west", "shelf").at(7.25, 7.82, 0.0).turned(180.0),
        on("store shelf west", "carton", "carton_small").at(-0.22, 0.0, b[1]),
        on("store shelf west", "books", "books_mixed").at(0.0, 0.0, b[1]),
        on("store shelf west", "vase", "vase_tall").at(0.2, 0.0, b[2]),
        on("store shelf west", "pot", "pot").at(-0.2, 0.0, b[3]),
        on("store shelf west", "pile", "lying_books").at(0.22, 0.0, b[3]),
        here("store shelf east", "shelf").at(8.35, 7.82, 0.0).turned(180.0),
        on("store shelf east", "carton below", "carton_small").at(0.2, 0.0, b[0]),
        on("store shelf east", "carton", "carton_small").at(-0.2, 0.01, b[2]).turned(3.0),
        on("store shelf east", "kettle", "kettle").at(0.24, 0.0, b[2]),
        on("store shelf east", "books", "books_tall").at(-0.42, 0.0, b[1]),
        here("store chest", "chest").at(9.55, 7.55, 0.0).turned(-170.0),
        here("crate", "crate").at(9.2, 5.38, 0.0).turned(4.0),
        here("carton", "carton_large").at(9.68, 5.75, 0.0).turned(88.0),
        on("carton", "upper carton", "carton_large").at(0.01, -0.02, 0.4).turned(8.0),
        Object::new("top carton", "carton_small").movable().on("carton: upper carton").at(0.0, 0.02, 0.4).turned(-15.0),
        here("rolled rug", "rolled_rug").at(9.87, 7.1, 0.0),
        here("stepladder", "stepladder").at(6.75, 6.6, 0.0).turned(-90.0),
        here("store chair", "chair").at(7.55, 5.4, 0.0).turned(25.0),
        here("store pouf", "pouf").at(9.1, 7.3, 0.0),
    ]
}
