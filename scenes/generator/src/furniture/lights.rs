//! The bodies of the lamps. The lamps themselves are points in the scene file, below or inside these.

use crate::mesh::Mesh;
use crate::shapes::{hollow, lathe, tube};
use crate::solid::{Solid, v};

/// Where the floor lamp's point of light is, metres from the middle of its foot.
pub const READING: [f64; 3] = [0.46, 0.0, 1.43];

/// A shade: a thin cone, open at both ends, from radius `a` at `low` to `b` at `high`.
fn shade(a: f64, low: f64, b: f64, high: f64) -> Solid {
    hollow(&[(a, low), (b, high), (b - 0.006, high), (a - 0.006, low)], 15)
}

/// A floor lamp whose stem bows over; the shade hangs at [`READING`].
pub fn floor_lamp() -> Mesh {
    let bow: [(f64, f64); 8] =
        [(0.0, 0.03), (0.0, 0.47), (0.0, 0.91), (0.0, 1.35), (0.08, 1.58), (0.27, 1.69), (0.42, 1.66), (0.46, 1.575)];
    let path: Vec<_> = bow.map(|(x, z)| v(x, 0.0, z)).to_vec();
    let s = vec![
        lathe(&[(0.15, 0.0), (0.14, 0.03)], 16).of("black steel"),
        tube(&path, v(0.0, 1.0, 0.0), 0.011, 5).of("black steel"),
        // The cap closes the shade at its top.
        lathe(&[(0.053, 1.56), (0.053, 1.5749)], 8).at(v(READING[0], 0.0, 0.0)).of("black steel"),
        shade(0.17, 1.38, 0.06, 1.57).at(v(READING[0], 0.0, 0.0)).of("lamp shade"),
    ];
    Mesh::new("floor_lamp", s)
}

/// A pendant: its light is at z = 0, the ceiling `1.0` m above; the shade is open above and below.
pub fn pendant() -> Mesh {
    let s = vec![
        shade(0.2, -0.07, 0.1, 0.1).of("enamel"),
        // A bar across the shade's upper opening, and the cord that it hangs on.
        super::bar("black steel", [-0.094, 0.094], [-0.004, 0.004], [0.085, 0.093]),
        super::bar("black steel", [-0.003, 0.003], [-0.003, 0.003], [0.0931, 0.97]),
        lathe(&[(0.03, 0.9701), (0.045, 1.0)], 8).of("enamel"),
    ];
    Mesh::new("pendant", s)
}

/// A round ceiling light, upper side at z = 0; its light is 2 cm below its lower side.
pub fn ceiling_light() -> Mesh {
    Mesh::new("ceiling_light", vec![lathe(&[(0.15, -0.06), (0.2, -0.035), (0.2, 0.0)], 16).of("enamel")])
}

/// A wall washer on the ceiling, upper side at z = 0.
pub fn washer() -> Mesh {
    Mesh::new("washer", vec![lathe(&[(0.06, -0.07), (0.06, 0.0)], 12).of("black steel")])
}

/// Where the standing lamp's point of light is, metres above the middle of its foot.
pub const STANDING: [f64; 3] = [0.0, 0.0, 1.52];

/// A standing lamp: an upright stem, and around its light a wide shade that is open above and below, on three spokes.
pub fn standing_lamp() -> Mesh {
    let mut s = vec![
        lathe(
            &[
                (0.15, 0.0),
                (0.15, 0.02),
                (0.02, 0.035),
                (0.012, 0.0351),
                (0.012, 0.75),
                (0.012, 1.4),
                (0.022, 1.401),
                (0.022, 1.46),
            ],
            14,
        )
        .of("brass"),
        shade(0.22, 1.39, 0.15, 1.66).of("lamp shade"),
    ];
    for turn in [0.0, 120.0, 240.0] {
        // From the stem into the shade.
        s.push(super::bar("brass", [0.0121, 0.214], [-0.003, 0.003], [1.405, 1.411]).turn_z(turn));
    }
    Mesh::new("standing_lamp", s)
}

/// A square ceiling light, upper side at z = 0; its light is 2 cm below its lower side.
pub fn panel_light() -> Mesh {
    let frame = crate::shapes::soft_block(v(-0.3, -0.3, -0.05), v(0.3, 0.3, 0.0), 0.015).of("enamel");
    Mesh::new("panel_light", vec![frame])
}
