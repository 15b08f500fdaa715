//! What holds things, and the books and the chest that it holds.

use super::bar;
use crate::mesh::Mesh;
use crate::shapes::{block, leg, soft_block};
use crate::solid::{Solid, v};

/// Heights of the upper sides of the shelf's boards, metres: where things stand.
pub const BOARDS: [f64; 6] = [0.10, 0.47, 0.83, 1.18, 1.52, 1.86];

/// An open shelf, 0.95 × 0.30 × 1.86 m.
pub fn shelf() -> Mesh {
    const WOOD: &str = "oak";
    let mut s = vec![bar("oak", [-0.475, 0.475], [-0.15, -0.142], [0.02, 1.84])];
    for x in [[-0.475, -0.453], [0.453, 0.475]] {
        s.push(bar(WOOD, x, [-0.1419, 0.15], [0.0, BOARDS[5] - 0.022]));
    }
    for (i, z) in BOARDS.iter().enumerate() {
        let x = if i == 5 { [-0.485, 0.485] } else { [-0.4529, 0.4529] };
        s.push(bar(WOOD, x, if i == 5 { [-0.155, 0.158] } else { [-0.1418, 0.145] }, [z - 0.022, *z]));
    }
    s.push(bar(WOOD, [-0.4528, 0.4528], [0.12, 0.135], [0.0, BOARDS[0] - 0.022]));
    Mesh::new("shelf", s)
}

/// A wardrobe with two panelled doors, a plinth and a cornice, 1.2 × 0.6 × 2.05 m.
pub fn wardrobe() -> Mesh {
    const PAINT: &str = "wardrobe paint";
    let mut s = vec![
        bar(PAINT, [-0.57, 0.57], [-0.28, 0.24], [0.0, 0.08]),
        bar(PAINT, [-0.59, 0.59], [-0.29, 0.255], [0.0801, 1.97]),
        soft_block(v(-0.615, -0.3, 1.9701), v(0.615, 0.3, 2.05), 0.022).of(PAINT),
    ];
    for side in [-1.0, 1.0] {
        let x = |a: f64, b: f64| if side < 0.0 { [-b, -a] } else { [a, b] };
        // Stiles and rails stand proud of the panels.
        s.push(bar(PAINT, x(0.003, 0.083), [0.2551, 0.278], [0.1, 1.95]));
        s.push(bar(PAINT, x(0.5, 0.58), [0.2551, 0.278], [0.1, 1.95]));
        for z in [[0.1, 0.2], [0.94, 1.04], [1.85, 1.95]] {
            s.push(bar(PAINT, x(0.0831, 0.4999), [0.2551, 0.2779], z));
        }
        for z in [[0.2001, 0.9399], [1.0401, 1.8499]] {
            s.push(bar("wardrobe panel", x(0.0832, 0.4998), [0.2551, 0.264], z));
        }
        s.push(block(v(-0.011, 0.2781, 0.94), v(0.011, 0.302, 1.04)).at(v(0.043 * side, 0.0, 0.0)).of("brass"));
    }
    Mesh::new("wardrobe", s)
}

/// A bedside table with a drawer, 0.4 × 0.36 × 0.5 m.
pub fn nightstand() -> Mesh {
    const WOOD: &str = "walnut";
    let mut s = vec![
        soft_block(v(-0.2, -0.18, 0.475), v(0.2, 0.18, 0.5), 0.007).of(WOOD),
        bar(WOOD, [-0.185, 0.185], [-0.17, 0.15], [0.28, 0.4749]),
        bar(WOOD, [-0.175, 0.175], [0.1501, 0.165], [0.29, 0.465]),
        block(v(-0.03, 0.1651, 0.378), v(0.03, 0.182, 0.392)).of("brass"),
    ];
    for x in [-0.16, 0.16] {
        for y in [-0.145, 0.125] {
            s.push(leg(v(x * 1.06, y * 1.06, 0.0), v(x, y, 0.28), 0.022, 0.036).of(WOOD));
        }
    }
    Mesh::new("nightstand", s)
}

const COVERS: [&str; 7] = ["book red", "book blue", "book green", "book cream", "book black", "book ochre", "book violet"];

/// Pseudo-random numbers from 0 to 1 (Lehmer 1951, the multiplier of Park and Miller 1988): the same books everywhere.
fn lehmer(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state * 48_271 % 2_147_483_647;
        state as f64 / 2_147_483_647.0
    }
}

/// A row of books, `length` metres at most; the last one leans. It stands against x = 0 and grows along +x, spines at y ≈ 0.1.
pub fn books(name: &str, seed: u64, length: f64) -> Mesh {
    let mut random = lehmer(seed);
    let mut solids = Vec::new();
    let mut x = 0.0;
    let mut last = usize::MAX;
    loop {
        let (w, h, d) = (0.018 + 0.03 * random(), 0.19 + 0.085 * random(), 0.13 + 0.05 * random());
        let mut cover = (random() * COVERS.len() as f64) as usize;
        if cover == last {
            cover = (cover + 1) % COVERS.len();
        }
        last = cover;
        let full = x + w > length - 0.09;
        // The last one leans by 14 degrees, its upper edge on its neighbour.
        let place = |s: Solid| match full {
            true => s.turn_y(-14.0).at(v(x + h * 14.0_f64.to_radians().sin() + 0.002, 0.08 - d + 0.02, 0.0)),
            false => s.at(v(x, 0.1 - d, 0.0)),
        };
        solids.push(place(bar(COVERS[cover], [0.0, w], [0.0, d], [0.0, h])));
        if full {
            return Mesh::new(name, solids);
        }
        x += w + 0.001;
    }
}

/// Three books that lie on each other, the middle of the pile at the origin.
pub fn lying_books() -> Mesh {
    let sizes =
        [("book green", 0.24, 0.17, 0.032, 0.0), ("book red", 0.21, 0.15, 0.026, 9.0), ("book cream", 0.18, 0.125, 0.02, -6.0)];
    let mut z = 0.0;
    let mut solids = Vec::new();
    for (cover, w, d, h, turn) in sizes {
        solids.push(bar(cover, [-w / 2.0, w / 2.0], [-d / 2.0, d / 2.0], [0.0, h]).turn_z(turn).at(v(0.0, 0.0, z)));
        z += h + 0.0002;
    }
    Mesh::new("lying_books", solids)
}

/// A wooden chest with a lid, 0.4 × 0.34 × 0.36 m.
pub fn chest() -> Mesh {
    let s = vec![
        bar("pine", [-0.2, 0.2], [-0.17, 0.17], [0.0, 0.3]),
        soft_block(v(-0.21, -0.18, 0.3001), v(0.21, 0.18, 0.36), 0.015).of("pine"),
        bar("brass", [-0.03, 0.03], [0.1701, 0.176], [0.24, 0.295]),
    ];
    Mesh::new("chest", s)
}

/// The height of the sideboard's top, metres.
pub const SIDEBOARD: f64 = 0.78;

/// A sideboard with three doors on legs, 1.6 × 0.42 × 0.78 m.
pub fn sideboard() -> Mesh {
    const WOOD: &str = "walnut";
    let mut s = vec![
        soft_block(v(-0.8, -0.21, SIDEBOARD - 0.024), v(0.8, 0.21, SIDEBOARD), 0.006).of(WOOD),
        bar(WOOD, [-0.785, 0.785], [-0.2, 0.17], [0.18, SIDEBOARD - 0.0241]),
    ];
    for i in 0..3 {
        let x = -0.78 + 0.522 * i as f64;
        s.push(bar("sideboard front", [x, x + 0.516], [0.1701, 0.188], [0.19, SIDEBOARD - 0.034]));
        s.push(bar("brass", [x + 0.4, x + 0.48], [0.1881, 0.204], [0.66, 0.672]));
    }
    for (x, y) in [(-0.7, -0.15), (-0.7, 0.13), (0.7, -0.15), (0.7, 0.13)] {
        s.push(leg(v(x * 1.04, y * 1.1, 0.0), v(x, y, 0.1799), 0.024, 0.042).of(WOOD));
    }
    Mesh::new("sideboard", s)
}
