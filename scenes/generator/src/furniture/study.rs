//! The desk and the two screens of the house.

use super::bar;
use crate::mesh::Mesh;
use crate::shapes::{lathe, leg, soft_block};
use crate::solid::{Solid, v};

/// A desk with three drawers to its left, 1.3 × 0.65 × 0.74 m; one sits at its +y side.
pub fn desk() -> Mesh {
    const WOOD: &str = "walnut";
    let top = super::table::TOP;
    let mut s = vec![
        soft_block(v(-0.65, -0.325, top - 0.028), v(0.65, 0.325, top), 0.008).of(WOOD),
        bar(WOOD, [0.22, 0.62], [-0.3, 0.27], [0.06, top - 0.0281]),
        bar(WOOD, [-0.6, 0.2199], [-0.3, -0.282], [0.35, top - 0.0281]),
        bar("black steel", [0.24, 0.6], [-0.28, 0.25], [0.0, 0.0599]),
    ];
    for i in 0..3 {
        let low = 0.07 + 0.212 * i as f64;
        s.push(bar(WOOD, [0.228, 0.612], [0.2701, 0.29], [low, low + 0.2]));
        s.push(bar("brass", [0.37, 0.47], [0.2901, 0.306], [low + 0.12, low + 0.135]));
    }
    for y in [-0.29, 0.29] {
        s.push(leg(v(-0.61, y, 0.0), v(-0.6, y, top - 0.0281), 0.034, 0.05).of(WOOD));
    }
    Mesh::new("desk", s)
}

/// A flat screen of `w` × `h` metres whose lower edge is `lift` above its foot; it looks along +y.
pub fn screen(name: &str, w: f64, h: f64, lift: f64) -> Mesh {
    let x = w / 2.0;
    let foot: Solid = lathe(&[(0.14, 0.0), (0.13, 0.012)], 16);
    let s = vec![
        foot.map(|p| v(p.x * w / 0.6, p.y, p.z)).of("black steel"),
        bar("black steel", [-0.03, 0.03], [-0.035, -0.012], [0.0121, lift + h * 0.5]),
        soft_block(v(-x, -0.0119, lift), v(x, 0.025, lift + h), 0.006).of("black steel"),
        bar("dark glass", [-x + 0.012, x - 0.012], [0.0251, 0.027], [lift + 0.012, lift + h - 0.012]),
    ];
    Mesh::new(name, s)
}
