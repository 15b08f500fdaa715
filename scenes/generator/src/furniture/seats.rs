//! What one sits on: the chair, the sofa with its loose pillow, the pouf.

use super::bar;
use crate::mesh::Mesh;
use crate::shapes::{block, cushion, cut_soft_block, lathe, leg, soft_block, steps};
use crate::solid::{Solid, v};

/// A wooden chair: tapered legs, a seat with an apron, posts and slats that lean back. 0.42 m wide.
pub fn chair() -> Mesh {
    const WOOD: &str = "beech";
    // Above the seat the back leans by 12 degrees.
    let lean = |s: Solid| s.map(|p| v(p.x, p.y - 0.21 * (p.z - 0.45).max(0.0), p.z)).of(WOOD);
    let mut s = vec![soft_block(v(-0.21, -0.175, 0.43), v(0.21, 0.225, 0.46), 0.01).of(WOOD)];
    for side in [-1.0, 1.0] {
        s.push(leg(v(0.19 * side, 0.2, 0.0), v(0.18 * side, 0.19, 0.43), 0.026, 0.04).of(WOOD));
        let post: Vec<_> = [(0.0, 0.028), (0.45, 0.036), (0.86, 0.028)]
            .map(|(z, w): (f64, f64)| {
                let h = w / 2.0;
                [(-h, -h), (h, -h), (h, h), (-h, h)].map(|(x, y)| v(0.19 * side + x, -0.195 + y, z)).to_vec()
            })
            .to_vec();
        s.push(lean(crate::shapes::loft(&post)));
        s.push(bar(WOOD, apron(0.168 * side, 0.012), [-0.17, 0.168], [0.375, 0.43]));
    }
    s.push(bar(WOOD, [-0.158, 0.158], [0.176, 0.198], [0.375, 0.43]));
    // The top rail is bowed backwards.
    let xs = steps(-0.205, 0.205, 2);
    let rail = crate::shapes::grid_box(&xs, &[-0.21, -0.185], &[0.86, 0.94]);
    s.push(lean(rail.map(|p| v(p.x, p.y - 0.025 * (1.0 - (p.x / 0.205).powi(2)), p.z))));
    s.push(lean(block(v(-0.17, -0.205, 0.53), v(0.17, -0.187, 0.56))));
    for x in [-0.108, -0.036, 0.036, 0.108] {
        // Up to the top rail, which lies a little further back there.
        let bow = |z: f64, x: f64| 0.02 * (1.0 - (x / 0.205).powi(2)) * (z - 0.56) / 0.3;
        let slat = block(v(x - 0.018, -0.202, 0.56), v(x + 0.018, -0.19, 0.86));
        s.push(lean(slat.map(|p| v(p.x, p.y - bow(p.z, x), p.z))));
    }
    Mesh::new("chair", s)
}

fn apron(x: f64, half: f64) -> [f64; 2] {
    [x - half, x + half]
}

/// A sofa for three, 2.0 × 0.9 m: feet, base, arms, back, and loose cushions.
pub fn sofa() -> Mesh {
    const CLOTH: &str = "sofa cloth";
    let mut s = vec![
        soft_block(v(-0.82, -0.40, 0.12), v(0.82, 0.43, 0.27), 0.025).of(CLOTH),
        soft_block(v(-0.82, -0.45, 0.12), v(0.82, -0.401, 0.70), 0.02).of(CLOTH),
    ];
    for side in [-1.0, 1.0] {
        let arm = soft_block(v(-0.09, -0.45, 0.12), v(0.09, 0.45, 0.60), 0.05);
        // Arms that lean outwards a little.
        s.push(arm.map(|p| v(side * (0.911 + p.x * side + 0.03 * (p.z - 0.12)), p.y, p.z)).of(CLOTH));
        for y in [-0.38, 0.36] {
            s.push(leg(v(0.79 * side, y, 0.0), v(0.77 * side, y, 0.12), 0.03, 0.05).of("walnut"));
        }
    }
    for x in [-0.545, 0.0, 0.545] {
        s.push(
            puffed(cut_soft_block(v(-0.27, -0.26, 0.271), v(0.27, 0.45, 0.42), 0.04, [2, 2, 1]), 0.27, 0.42)
                .at(v(x, 0.0, 0.0))
                .of(CLOTH),
        );
        let back = puffed(cut_soft_block(v(-0.268, -0.24, 0.0), v(0.268, 0.22, 0.17), 0.05, [2, 1, 1]), 0.268, 0.17);
        // Laid flat, then stood up and leant against the back.
        s.push(back.turn_x(102.0).at(v(x, -0.21, 0.671)).of(CLOTH));
    }
    Mesh::new("sofa", s)
}

/// A seat's upper side, filled: raised by 2.5 cm in the middle.
fn puffed(s: Solid, half: f64, top: f64) -> Solid {
    s.map(|p| if p.z > top - 0.02 { v(p.x, p.y, p.z + 0.025 * (1.0 - (p.x / half).powi(2)).max(0.0)) } else { p })
}

/// A loose pillow, standing on its edge and leaning back.
pub fn throw_pillow() -> Mesh {
    Mesh::new("throw_pillow", vec![cushion(0.44, 0.42, 0.16).turn_x(72.0).at(v(0.0, 0.0, 0.23)).of("ochre cloth")])
}

/// A round pouf, 0.5 m across.
pub fn pouf() -> Mesh {
    let profile = [(0.19, 0.0), (0.245, 0.1), (0.245, 0.28), (0.2, 0.37), (0.1, 0.395)];
    Mesh::new("pouf", vec![lathe(&profile, 14).of("teal cloth")])
}

/// An armchair, 0.8 × 0.8 m: a sofa's parts for one, on a wooden base.
pub fn armchair() -> Mesh {
    const CLOTH: &str = "armchair cloth";
    let mut s = vec![
        soft_block(v(-0.3, -0.34, 0.16), v(0.3, 0.36, 0.28), 0.02).of(CLOTH),
        puffed(cut_soft_block(v(-0.285, -0.24, 0.281), v(0.285, 0.38, 0.42), 0.04, [2, 2, 1]), 0.285, 0.42).of(CLOTH),
    ];
    for side in [-1.0, 1.0] {
        let arm = soft_block(v(-0.055, -0.36, 0.16), v(0.055, 0.36, 0.6), 0.035);
        s.push(arm.map(|p| v(side * (0.358 + p.x * side), p.y, p.z - 0.1 * p.y * (p.z - 0.16))).of(CLOTH));
        for y in [-0.3, 0.3] {
            s.push(leg(v(0.32 * side, y * 1.05, 0.0), v(0.28 * side, y * 0.98, 0.1599), 0.026, 0.045).of("beech"));
        }
    }
    // The back leans by 14 degrees and is bowed around the shoulders.
    let back = cut_soft_block(v(-0.3, 0.0, 0.0), v(0.3, 0.13, 0.62), 0.045, [4, 1, 2]);
    s.push(back.map(|p| v(p.x, p.y + 0.6 * p.x * p.x, p.z)).turn_x(14.0).at(v(0.0, -0.38, 0.281)).of(CLOTH));
    Mesh::new("armchair", s)
}
