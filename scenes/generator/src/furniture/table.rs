//! The table and what stands on it.

use super::bar;
use crate::mesh::Mesh;
use crate::shapes::{ball, lathe, leg, soft_block, tube};
use crate::solid::v;

/// The height of the table's top, metres: where cups stand.
pub const TOP: f64 = 0.74;

/// The table, 1.4 × 0.85 m, on four tapered legs with an apron.
pub fn table() -> Mesh {
    const WOOD: &str = "oak";
    let mut s = vec![soft_block(v(-0.7, -0.425, TOP - 0.034), v(0.7, 0.425, TOP), 0.008).of(WOOD)];
    for x in [-1.0, 1.0] {
        for y in [-1.0, 1.0] {
            s.push(leg(v(0.635 * x, 0.36 * y, 0.0), v(0.62 * x, 0.345 * y, TOP - 0.034), 0.034, 0.062).of(WOOD));
        }
        let inner = [0.608, 0.63];
        s.push(bar(WOOD, if x < 0.0 { [-inner[1], -inner[0]] } else { inner }, [-0.312, 0.312], [TOP - 0.12, TOP - 0.034]));
        let inner = [0.333, 0.355];
        s.push(bar(WOOD, [-0.587, 0.587], if x < 0.0 { [-inner[1], -inner[0]] } else { inner }, [TOP - 0.12, TOP - 0.034]));
    }
    Mesh::new("table", s)
}

/// A cup with a handle, 8 cm wide and 9 cm high; hollow, its handle towards +x.
pub fn cup() -> Mesh {
    let wall = [(0.026, 0.0), (0.037, 0.022), (0.041, 0.09), (0.0375, 0.09), (0.0335, 0.024), (0.02, 0.008)];
    let handle = [(0.038, 0.074), (0.06, 0.073), (0.064, 0.05), (0.036, 0.03)];
    let path: Vec<_> = handle.iter().map(|&(x, z)| v(x, 0.0, z)).collect();
    Mesh::new("cup", vec![lathe(&wall, 10).of("china"), tube(&path, v(0.0, 1.0, 0.0), 0.0045, 4).of("china")])
}

/// A wide wooden bowl.
pub fn bowl() -> Mesh {
    let profile = [(0.055, 0.0), (0.105, 0.035), (0.135, 0.08), (0.129, 0.082), (0.1, 0.042), (0.05, 0.013)];
    Mesh::new("bowl", vec![lathe(&profile, 12).of("walnut")])
}

/// Three oranges and a lemon as they lie in the bowl, their support at z = 0.
pub fn oranges() -> Mesh {
    let mut s: Vec<_> = [0.0, 120.0, 240.0].map(|a| ball(0.037).at(v(0.045, 0.0, 0.037)).turn_z(a).of("orange peel")).to_vec();
    let lemon = ball(0.028).map(|p| v(p.x * 1.25, p.y, p.z)).turn_z(30.0);
    s.push(lemon.at(v(0.0, 0.0, 0.037 + 0.057)).of("lemon peel"));
    Mesh::new("oranges", s)
}

/// The height of the coffee table's top, metres.
pub const LOW: f64 = 0.42;

/// A coffee table with a shelf below, 0.95 × 0.5 m.
pub fn coffee_table() -> Mesh {
    const WOOD: &str = "beech";
    let mut s = vec![
        soft_block(v(-0.475, -0.25, LOW - 0.025), v(0.475, 0.25, LOW), 0.008).of(WOOD),
        soft_block(v(-0.43, -0.2, 0.14), v(0.43, 0.2, 0.158), 0.005).of(WOOD),
    ];
    for (x, y) in [(-0.44, -0.215), (-0.44, 0.215), (0.44, -0.215), (0.44, 0.215)] {
        s.push(leg(v(x, y, 0.0), v(x * 0.99, y, LOW - 0.0251), 0.026, 0.04).of(WOOD));
    }
    Mesh::new("coffee_table", s)
}
