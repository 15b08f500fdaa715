//! The kitchen: counter with hob and tap, wall cupboards, refrigerator, pot, kettle, stool.

use super::bar;
use crate::mesh::Mesh;
use crate::shapes::{hollow, lathe, leg, soft_block, tube};
use crate::solid::{Solid, v};

/// The height of the counter's top, metres.
pub const WORKTOP: f64 = 0.9;

const PAINT: &str = "kitchen paint";
const STEEL: &str = "brushed steel";

/// `n` doors side by side from x = −`half` to `half`, each with an upright handle, their backs at `y`.
fn fronts(n: usize, half: f64, y: f64, z: [f64; 2], handle: [f64; 2]) -> Vec<Solid> {
    let width = 2.0 * half / n as f64;
    (0..n)
        .flat_map(|i| {
            let x = -half + width * i as f64;
            // Handles at the side where a pair of doors meets.
            let grip = if i % 2 == 0 { x + width - 0.05 } else { x + 0.05 };
            [
                bar(PAINT, [x + 0.002, x + width - 0.002], [y, y + 0.018], z),
                bar(STEEL, [grip - 0.006, grip + 0.006], [y + 0.0181, y + 0.04], handle),
            ]
        })
        .collect()
}

/// A counter with four doors, a hob with four plates and a tap over a basin, 2.4 × 0.6 × 0.9 m.
pub fn counter() -> Mesh {
    let mut s = vec![
        bar("black steel", [-1.19, 1.19], [-0.28, 0.22], [0.0, 0.1]),
        bar(PAINT, [-1.2, 1.2], [-0.3, 0.27], [0.1001, 0.8599]),
        soft_block(v(-1.21, -0.3, 0.86), v(1.21, 0.32, WORKTOP), 0.006).of("worktop"),
        bar("black steel", [0.2, 0.78], [-0.24, 0.26], [WORKTOP + 0.0001, WORKTOP + 0.006]),
        tube(
            &[[-0.7, -0.22, 0.9], [-0.7, -0.22, 1.14], [-0.7, -0.18, 1.2], [-0.7, -0.1, 1.2], [-0.7, -0.07, 1.16]]
                .map(|p| p.into()),
            v(1.0, 0.0, 0.0),
            0.012,
            6,
        )
        .of(STEEL),
        // The basin stands on the top.
        hollow(&[(0.16, 0.0), (0.2, 0.1), (0.205, 0.11), (0.195, 0.11), (0.15, 0.02), (0.03, 0.012), (0.03, 0.0)], 16)
            .at(v(-0.7, 0.05, WORKTOP + 0.0001))
            .of("china"),
    ];
    s.extend(fronts(4, 1.198, 0.2701, [0.11, 0.85], [0.62, 0.8]));
    for (x, y, r) in [(0.34, 0.13, 0.085), (0.63, 0.13, 0.07), (0.34, -0.11, 0.07), (0.63, -0.11, 0.085)] {
        s.push(lathe(&[(r, 0.0), (r, 0.008)], 14).at(v(x, y, WORKTOP + 0.0061)).of("hob plate"));
    }
    Mesh::new("counter", s)
}

/// Wall cupboards with four doors, 2.4 × 0.36 × 0.7 m; their underside at z = 0, their back at y = 0.
pub fn cupboards() -> Mesh {
    let mut s = vec![bar(PAINT, [-1.2, 1.2], [0.0, 0.34], [0.0, 0.7])];
    s.extend(fronts(4, 1.198, 0.3401, [0.002, 0.698], [0.04, 0.2]));
    Mesh::new("cupboards", s)
}

/// A refrigerator of two doors, 0.6 × 0.62 × 1.75 m.
pub fn refrigerator() -> Mesh {
    const BODY: &str = "refrigerator";
    let mut s = vec![
        bar(BODY, [-0.3, 0.3], [-0.3, 0.24], [0.03, 1.75]),
        soft_block(v(-0.3, 0.2401, 0.05), v(0.3, 0.31, 0.62), 0.012).of(BODY),
        soft_block(v(-0.3, 0.2401, 0.63), v(0.3, 0.31, 1.75), 0.012).of(BODY),
        bar(STEEL, [-0.27, -0.25], [0.3101, 0.34], [0.36, 0.58]),
        bar(STEEL, [-0.27, -0.25], [0.3101, 0.34], [0.68, 1.05]),
    ];
    for (x, y) in [(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.2), (0.25, 0.2)] {
        s.push(bar("black steel", [x - 0.02, x + 0.02], [y - 0.02, y + 0.02], [0.0, 0.0299]));
    }
    Mesh::new("refrigerator", s)
}

/// A pot with two handles, 24 cm wide, and its lid.
pub fn pot() -> Mesh {
    let mut s = vec![
        lathe(&[(0.11, 0.0), (0.12, 0.01), (0.12, 0.13)], 18).of(STEEL),
        lathe(&[(0.125, 0.1301), (0.12, 0.14), (0.05, 0.155), (0.012, 0.157), (0.02, 0.18), (0.015, 0.185)], 18).of(STEEL),
    ];
    for turn in [0.0, 180.0] {
        let grip = [[0.115, -0.05, 0.1], [0.16, -0.04, 0.105], [0.16, 0.04, 0.105], [0.115, 0.05, 0.1]].map(|p| p.into());
        s.push(tube(&grip, v(0.0, 0.0, 1.0), 0.007, 5).turn_z(turn).of("black steel"));
    }
    Mesh::new("pot", s)
}

/// A kettle with a spout towards +x and a handle over its top.
pub fn kettle() -> Mesh {
    let body = [(0.085, 0.0), (0.1, 0.02), (0.095, 0.09), (0.06, 0.14), (0.035, 0.15), (0.012, 0.153), (0.014, 0.172)];
    let handle = [[-0.07, 0.0, 0.125], [-0.085, 0.0, 0.2], [-0.03, 0.0, 0.235], [0.04, 0.0, 0.23], [0.06, 0.0, 0.14]];
    let spout = [[0.08, 0.0, 0.06], [0.12, 0.0, 0.09], [0.135, 0.0, 0.14]];
    let s = vec![
        lathe(&body, 16).of("kettle red"),
        tube(&handle.map(|p| p.into()), v(0.0, 1.0, 0.0), 0.009, 6).of("black steel"),
        tube(&spout.map(|p| p.into()), v(0.0, 1.0, 0.0), 0.014, 6).of("kettle red"),
    ];
    Mesh::new("kettle", s)
}

/// A round table on one foot, 0.9 m across.
pub fn round_table() -> Mesh {
    let foot = [(0.26, 0.0), (0.25, 0.02), (0.06, 0.05), (0.035, 0.12), (0.035, 0.62), (0.12, super::table::TOP - 0.0301)];
    let top = [(0.44, super::table::TOP - 0.03), (0.45, super::table::TOP - 0.02), (0.45, super::table::TOP - 0.006)];
    let rim = [(0.444, super::table::TOP), (0.2, super::table::TOP)];
    let s = vec![lathe(&foot, 16).of("black steel"), lathe(&[&top[..], &rim[..]].concat(), 28).of("beech")];
    Mesh::new("round_table", s)
}

/// A stool of 46 cm with a round seat.
pub fn stool() -> Mesh {
    let mut s = vec![lathe(&[(0.155, 0.43), (0.17, 0.437), (0.17, 0.455), (0.16, 0.46)], 18).of("stool paint")];
    for turn in [45.0, 135.0, 225.0, 315.0] {
        s.push(leg(v(0.19, 0.0, 0.0), v(0.12, 0.0, 0.4299), 0.024, 0.034).turn_z(turn).of("beech"));
    }
    Mesh::new("stool", s)
}
