//! The furnished room: 6 × 5 × 2.8 m, dining table, sofa corner, bed, and a corner behind a folding screen.
//!
//! The chest behind the screen and the box under the bed are lit indirectly only: no lamp sees them. The room is closed, so no light
//! leaves it; window and door open onto nothing.

mod fixtures;
pub mod materials;
pub mod moves;

use crate::furniture::{self, lights, storage, table};
use crate::mesh::Mesh;
use crate::scene::{Camera, Lamp, Object, Scene};
use crate::shell;
use crate::solid::v;
use glam::{DVec2, DVec3};

/// Length, width and height, metres.
pub const SIZE: [f64; 3] = [6.0, 5.0, 2.8];

/// Where the table stands; its drag begins here.
pub const TABLE: [f64; 2] = [1.9, 3.0];

/// Metres after which the checks of [`papered`] come again: coarse enough that cells of [`scene`] show light of that detail.
const CHECKS: f64 = 2.5;

/// The scene.
pub fn scene() -> Scene {
    let paint = |wall: &str| match wall {
        "floor" => "floorboards",
        "ceiling" => "ceiling white",
        _ => "wall white",
    };
    let walls = shell::walls(SIZE[0], SIZE[1], SIZE[2], paint);
    let mut objects: Vec<Object> = walls.iter().map(|p| Object::new(&p.name, "shell").part(&p.name)).collect();
    let mut meshes = vec![Mesh { name: "shell".into(), parts: walls }];
    for mesh in fixtures::meshes() {
        objects.push(Object::new(&mesh.name.replace('_', " "), &mesh.name));
        meshes.push(mesh);
    }
    meshes.extend(furniture::meshes());
    meshes.sort_by(|a, b| a.name.cmp(&b.name));
    objects.extend(standing());
    objects.extend(riding());
    Scene {
        name: "room",
        // A little above the size that parts are cut for: few of them change, and the walls come out at 12,400 elements in all.
        cell: 0.53,
        materials: materials::all(),
        objects,
        lamps: lamps(),
        cameras: cameras(),
        meshes: ("meshes/", meshes),
    }
}

/// The same for pictures, written beside it as `fine.ron`: elements as fine as the shadows under furniture (docs/accuracy.md, how to choose), and
/// a little above the sizes that furniture is made of.
pub fn fine() -> Scene {
    Scene { name: "fine room", cell: 0.152, ..scene() }
}

/// The same with floor and walls in large strong checks, which hide errors of the light: written beside it, as `papered.ron`.
pub fn papered() -> Scene {
    let mut scene = scene();
    let checks = |wall: &str| if wall == "ceiling" { "ceiling white" } else { "checks" };
    let mut walls = shell::walls(SIZE[0], SIZE[1], SIZE[2], checks);
    for part in walls.iter_mut().filter(|part| part.name != "ceiling") {
        // Along the wall and up it; across the floor.
        let flat = |p: DVec3| match part.name.as_str() {
            "floor" => DVec2::new(p.x, p.y),
            "south wall" | "north wall" => DVec2::new(p.x, p.z),
            _ => DVec2::new(p.y, p.z),
        };
        part.solids = part.solids.iter().map(|s| s.clone().textured(|p| flat(p) / CHECKS)).collect();
    }
    for object in scene.objects.iter_mut().filter(|object| object.mesh == "shell") {
        object.mesh = "papered_shell".into();
    }
    scene.meshes.1.retain(|mesh| mesh.name != "shell");
    scene.meshes.1.push(Mesh { name: "papered_shell".into(), parts: walls });
    scene.materials.push(("checks", [1.0; 3], Some("textures/checks.png")));
    scene.materials.sort_by_key(|m| m.0);
    Scene { name: "papered room", ..scene }
}

/// What stands on the floor or hangs.
fn standing() -> Vec<Object> {
    let [x, y] = TABLE;
    let here = |name: &str, mesh: &str| Object::new(name, mesh).movable();
    vec![
        here("table", "table").at(x, y, 0.0),
        here("chair south west", "chair").at(x - 0.34, y - 0.71, 0.0).turned(4.0),
        here("chair south east", "chair").at(x + 0.36, y - 0.67, 0.0).turned(-14.0),
        here("chair north west", "chair").at(x - 0.33, y + 0.7, 0.0).turned(183.0),
        here("chair north east", "chair").at(x + 0.34, y + 0.71, 0.0).turned(176.0),
        here("sofa", "sofa").at(3.1, 0.5, 0.0),
        here("rug", "rug").at(2.97, 1.5, 0.0),
        here("pouf", "pouf").at(4.35, 1.3, 0.0),
        here("floor lamp", "floor_lamp").at(4.42, 0.3, 0.0).turned(160.0),
        here("screen", "screen").at(4.72, 0.12, 0.0),
        here("chest", "chest").at(5.4, 0.55, 0.0).turned(12.0),
        here("bed", "bed").at(4.94, 2.4, 0.0).turned(180.0),
        here("box under bed", "box_under_bed").at(4.95, 2.4, 0.0).turned(5.0),
        here("nightstand", "nightstand").at(5.77, 3.42, 0.0).turned(90.0),
        here("wardrobe", "wardrobe").at(5.66, 4.3, 0.0).turned(90.0),
        here("shelf", "shelf").at(4.08, 4.82, 0.0).turned(180.0),
        here("plant", "plant").at(0.5, 4.5, 0.0),
        here("door", "door").at(0.06, 0.5, 0.01).turned(-7.0),
        here("picture over sofa", "picture_wide").at(3.1, 0.0, 1.55),
        here("picture over bed", "picture_wide").at(6.0, 2.4, 1.6).turned(90.0),
        here("picture left of door", "picture_high").at(0.0, 1.95, 1.55).turned(-90.0),
        Object::new("pendant", "pendant").at(x, y, SIZE[2] - 1.0),
        Object::new("ceiling light", "ceiling_light").at(3.6, 2.2, SIZE[2]),
        Object::new("washer", "washer").at(4.08, 4.0, SIZE[2]),
    ]
}

/// What stands or lies on other things, and goes where they go.
fn riding() -> Vec<Object> {
    let on = |carrier: &str, name: &str, mesh: &str| Object::new(name, mesh).movable().on(carrier);
    let b = storage::BOARDS;
    vec![
        on("table", "cup west", "cup").at(-0.35, -0.2, table::TOP).turned(30.0),
        on("table", "cup east", "cup").at(0.38, 0.16, table::TOP).turned(200.0),
        on("table", "bowl", "bowl").at(0.02, 0.03, table::TOP),
        on("bowl", "fruit", "oranges").at(0.0, 0.0, 0.03),
        on("sofa", "throw pillow left", "throw_pillow").at(-0.55, 0.02, 0.445).turned(-12.0),
        on("bed", "pillow south", "pillow").at(-0.7, 0.36, 0.53),
        on("bed", "pillow north", "pillow").at(-0.7, -0.35, 0.53).turned(6.0),
        on("nightstand", "bedside books", "lying_books").at(0.02, 0.0, 0.5).turned(-20.0),
        on("shelf", "books tall", "books_tall").at(-0.44, 0.0, b[3]),
        on("shelf", "books short", "books_short").at(-0.1, 0.0, b[2]),
        on("shelf", "books mixed", "books_mixed").at(-0.43, 0.0, b[1]),
        on("shelf", "books low", "books_tall").at(0.02, 0.0, b[0]),
        on("shelf", "books high", "books_short").at(0.1, 0.0, b[4]),
        on("shelf", "lying books", "lying_books").at(-0.28, 0.0, b[2]),
        on("shelf", "vase tall", "vase_tall").at(0.26, 0.0, b[3]),
        on("shelf", "vase small", "vase_small").at(-0.25, 0.0, b[4]),
    ]
}

fn lamps() -> Vec<Lamp> {
    let lamp = |name, on, at: [f64; 3], turn, tint: [f64; 3], file| Lamp {
        name,
        on,
        position: at.into(),
        rotation: v(0.0, 0.0, turn),
        intensity: tint.into(),
        photometry: Some(file),
    };
    // Each tint has a luminance of about one, so that the file's candela hold.
    let (warm, neutral) = ([1.18, 0.97, 0.72], [1.08, 0.99, 0.86]);
    vec![
        lamp("ceiling light", None, [3.6, 2.2, SIZE[2] - 0.08], 0.0, neutral, "ies/diffuser.ies"),
        lamp("pendant", None, [TABLE[0], TABLE[1], SIZE[2] - 1.0], 0.0, warm, "ies/pendant.ies"),
        lamp("reading lamp", Some("floor lamp"), lights::READING, 0.0, warm, "ies/reading.ies"),
        // Its lobe leans towards C = 0: turned to the north wall.
        lamp("washer", None, [4.08, 4.0, SIZE[2] - 0.09], 90.0, neutral, "ies/washer.ies"),
    ]
}

fn cameras() -> Vec<Camera> {
    let camera = |name, eye: [f64; 3], target: [f64; 3], fov| Camera { name, eye: eye.into(), target: target.into(), fov };
    vec![
        camera("door", [0.3, 0.95, 1.6], [3.55, 2.75, 0.85], 65.0),
        camera("table", [0.75, 1.75, 1.45], [2.15, 3.2, 0.7], 55.0),
        camera("bed", [2.9, 3.55, 1.5], [5.05, 2.1, 0.45], 58.0),
        camera("wardrobe", [5.15, 3.85, 1.6], [1.6, 1.5, 0.85], 65.0),
        camera("chest", [5.88, 0.98, 1.5], [5.38, 0.5, 0.2], 65.0),
    ]
}
