//! What is put away: cartons, a crate of slats, a rolled rug, a stepladder.

use super::bar;
use crate::mesh::Mesh;
use crate::shapes::{lathe, leg};
use crate::solid::{Solid, v};

/// A closed carton of `x` × `y` × `z` metres with two flaps and tape across.
pub fn carton(name: &str, x: f64, y: f64, z: f64) -> Mesh {
    let (a, b) = (x / 2.0, y / 2.0);
    let s = vec![
        bar("cardboard", [-a, a], [-b, b], [0.0, z - 0.005]),
        bar("cardboard", [-a, a], [-b, -0.002], [z - 0.0049, z - 0.0005]),
        bar("cardboard", [-a, a], [0.002, b], [z - 0.0049, z - 0.0005]),
        bar("parcel tape", [-a, a], [-0.03, 0.03], [z - 0.0004, z]),
    ];
    Mesh::new(name, s)
}

/// An open crate of slats, 0.5 × 0.35 × 0.3 m.
pub fn crate_of_slats() -> Mesh {
    const WOOD: &str = "pine";
    let (x, y) = (0.25, 0.175);
    let mut s = vec![bar(WOOD, [-x, x], [-y, y], [0.0, 0.012])];
    for i in 0..3 {
        let z = [0.02 + 0.095 * i as f64, 0.1 + 0.095 * i as f64];
        s.push(bar(WOOD, [-x, x], [-y, -y + 0.01], z));
        s.push(bar(WOOD, [-x, x], [y - 0.01, y], z));
        s.push(bar(WOOD, [-x, -x + 0.01], [-y + 0.0101, y - 0.0101], z));
        s.push(bar(WOOD, [x - 0.01, x], [-y + 0.0101, y - 0.0101], z));
    }
    for (i, j) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        let (px, py) = (i * (x - 0.026), j * (y - 0.026));
        s.push(bar(WOOD, [px - 0.0158, px + 0.0158], [py - 0.0158, py + 0.0158], [0.0121, 0.29]));
    }
    Mesh::new("crate", s)
}

/// A rug rolled up, 1.4 m long, standing on its end; its strings are brass-coloured.
pub fn rolled_rug() -> Mesh {
    let mut s = vec![lathe(&[(0.085, 0.0), (0.09, 0.02), (0.09, 1.38), (0.085, 1.4)], 16).of("teal cloth")];
    for z in [0.35, 1.05] {
        s.push(lathe(&[(0.094, z), (0.094, z + 0.015)], 16).of("fringe"));
    }
    Mesh::new("rolled_rug", s)
}

/// A stepladder of four steps, 1.3 m high, opened.
pub fn stepladder() -> Mesh {
    let steel: &str = "brushed steel";
    let mut s: Vec<Solid> = Vec::new();
    for side in [-1.0, 1.0] {
        s.push(leg(v(0.24 * side, 0.42, 0.0), v(0.18 * side, 0.04, 1.28), 0.03, 0.03).of(steel));
        s.push(leg(v(0.24 * side, -0.36, 0.0), v(0.18 * side, -0.02, 1.28), 0.024, 0.024).of(steel));
    }
    for i in 1..5 {
        let t = i as f64 / 5.0;
        let (y, half) = (0.42 - 0.38 * t, 0.222 - 0.06 * t);
        s.push(bar(steel, [-half, half], [y - 0.05, y + 0.05], [1.28 * t - 0.02, 1.28 * t]));
    }
    s.push(bar("stool paint", [-0.2, 0.2], [-0.1, 0.1], [1.2801, 1.31]));
    Mesh::new("stepladder", s)
}
