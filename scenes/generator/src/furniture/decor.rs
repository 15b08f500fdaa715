//! The folding screen, the rug, the plant, vases, pictures, and the door.

use glam::DVec2;

use super::bar;
use crate::mesh::Mesh;
use crate::shapes::{block, grid_box, lathe, leg, steps, tube};
use crate::solid::{Solid, v};

/// The corners of the folding screen on the floor, metres in the room's axes.
const FOLDS: [[f64; 2]; 5] = [[0.0, 0.0], [0.22, 0.44], [0.08, 0.92], [0.5, 1.18], [0.96, 0.98]];

/// A folding screen of four panels on round posts, 1.66 m high: it stands around the corner to its −y, +x.
pub fn screen() -> Mesh {
    let mut s: Vec<Solid> = FOLDS.map(|[x, y]| leg(v(x, y, 0.0), v(x, y, 1.68), 0.03, 0.03).of("walnut")).to_vec();
    for pair in FOLDS.windows(2) {
        let (a, b) = (v(pair[0][0], pair[0][1], 0.0), v(pair[1][0], pair[1][1], 0.0));
        let length = a.distance(b);
        let angle = (b - a).y.atan2((b - a).x).to_degrees();
        let ends = [0.012, length - 0.012];
        let panel = [
            bar("walnut", ends, [-0.011, 0.011], [0.06, 0.12]),
            bar("walnut", ends, [-0.011, 0.011], [1.58, 1.64]),
            bar("screen paper", [0.013, length - 0.013], [-0.003, 0.003], [0.1201, 1.5799]),
        ];
        s.extend(panel.into_iter().map(|p| p.turn_z(angle).at(a)));
    }
    Mesh::new("screen", s)
}

/// The rug, 1.9 × 1.1 × 0.01 m, with its picture and fringes at both short ends.
pub fn rug() -> Mesh {
    let (x, y) = (0.95, 0.55);
    let field = block(v(-x, -y, 0.0), v(x, y, 0.01));
    let mut s = vec![field.textured(|p| DVec2::new((p.x + x) / (2.0 * x), (p.y + y) / (2.0 * y))).of("rug")];
    for (a, b) in [(-x - 0.05, -x - 0.0001), (x + 0.0001, x + 0.05)] {
        s.push(bar("fringe", [a, b], [-y + 0.01, y - 0.01], [0.0, 0.004]));
    }
    Mesh::new("rug", s)
}

/// A plant in a pot: seven leaves on bent stalks.
pub fn plant() -> Mesh {
    let pot = [(0.1, 0.0), (0.15, 0.3), (0.135, 0.3), (0.13, 0.25)];
    let mut s = vec![lathe(&pot, 12).of("terracotta")];
    for i in 0..7 {
        let t = i as f64 / 6.0;
        let (length, rise) = (0.34 + 0.1 * (1.0 - t), 0.25 + 0.5 * t);
        let stalk = [v(0.01 + 0.03 * (1.0 - t), 0.0, 0.245), v(0.05, 0.0, 0.25 + rise * 0.55), v(0.07, 0.0, 0.25 + rise)];
        // Each leaf turns by the golden angle from the one below.
        let turn = 137.508 * i as f64;
        s.push(tube(&stalk, v(0.0, 1.0, 0.0), 0.005, 3).turn_z(turn).of("leaf"));
        let leaf = grid_box(&steps(0.0, 1.0, 3), &[-1.0, 0.0, 1.0], &[0.0, 1.0]).map(|p| {
            let width = 0.004 + 0.062 * (std::f64::consts::PI * p.x.powf(0.8)).sin().max(0.0);
            // It rises, then droops; the midrib is its keel.
            let z = length * (0.55 * p.x - (0.75 - 0.35 * t) * p.x * p.x) + 0.25 * width * p.y.abs();
            v(0.07 + 0.75 * length * p.x, width * p.y, 0.25 + rise + z + 0.003 * p.z)
        });
        s.push(leaf.turn_z(turn).of("leaf"));
    }
    Mesh::new("plant", s)
}

/// A hollow vase of `h` metres.
pub fn vase(name: &str, h: f64) -> Mesh {
    let outside = [(0.17, 0.0), (0.28, 0.4), (0.12, 0.82), (0.16, 1.0)];
    let mut profile: Vec<_> = outside.iter().map(|&(r, z)| (r * h, z * h)).collect();
    profile.extend([(0.13, 1.0), (0.09, 0.82), (0.13, 0.3)].map(|(r, z)| (r * h, z * h)));
    let glaze = if h > 0.2 { "glaze blue" } else { "glaze white" };
    Mesh::new(name, vec![lathe(&profile, 11).of(glaze)])
}

/// A door leaf, 0.8 × 2.0 m: its hinge is the z axis, the leaf lies along +y, the room is on the +x side. Bottom at z = 0.
pub fn door() -> Mesh {
    const PAINT: &str = "door paint";
    let (back, front) = (-0.04, 0.0);
    let mut s = vec![bar(PAINT, [back, front], [0.0, 0.11], [0.0, 2.0]), bar(PAINT, [back, front], [0.69, 0.8], [0.0, 2.0])];
    for z in [[0.0, 0.2], [0.85, 1.0], [1.88, 2.0]] {
        s.push(bar(PAINT, [back + 0.0001, front - 0.0001], [0.1101, 0.6899], z));
    }
    for z in [[0.2001, 0.8499], [1.0001, 1.8799]] {
        s.push(bar(PAINT, [back + 0.013, front - 0.013], [0.1102, 0.6898], z));
    }
    // Rose and lever, on the room's side only: the wall is behind.
    s.push(
        lathe(&[(0.024, 0.0), (0.024, 0.006), (0.009, 0.0061), (0.009, 0.05)], 7)
            .turn_y(90.0)
            .at(v(front + 0.0001, 0.745, 0.94))
            .of("brass"),
    );
    s.push(tube(&[v(0.042, 0.752, 0.94), v(0.042, 0.69, 0.94), v(0.038, 0.625, 0.937)], v(0.0, 0.0, 1.0), 0.008, 5).of("brass"));
    Mesh::new("door", s)
}

/// A framed picture of three bands, `w` × `h` metres; its back at y = 0, its middle at the origin.
pub fn picture(name: &str, w: f64, h: f64, bands: [&'static str; 3]) -> Mesh {
    let (x, z, f) = (w / 2.0, h / 2.0, 0.025);
    let mut s = vec![
        bar("black steel", [-x, x], [0.0, 0.025], [-z, -z + f]),
        bar("black steel", [-x, x], [0.0, 0.025], [z - f, z]),
        bar("black steel", [-x, -x + f], [0.0, 0.0249], [-z + f + 0.0001, z - f - 0.0001]),
        bar("black steel", [x - f, x], [0.0, 0.0249], [-z + f + 0.0001, z - f - 0.0001]),
        bar("cream", [-x + f, x - f], [0.001, 0.01], [-z + f, z - f]),
    ];
    // Hills one behind the other, in a mount.
    let (x, z) = (x - 0.09, z - 0.09);
    for (i, band) in bands.into_iter().enumerate() {
        let low = -z + 2.0 * z * i as f64 / 3.0;
        let high = low + 2.0 * z / 3.0 - 0.0001;
        let hill = grid_box(&steps(-x, x, 3), &[0.0101, 0.013], &[0.0, 1.0]).map(|p| {
            let line = |k: usize, z0: f64| {
                if k.is_multiple_of(3) { z0 } else { z0 + 0.12 * z * (p.x / x * (2.0 + k as f64) + k as f64).sin() }
            };
            let (a, b) = (line(i, low), line(i + 1, high));
            v(p.x, p.y, a + (b - a) * p.z)
        });
        s.push(hill.of(band));
    }
    Mesh::new(name, s)
}

/// A curtain, `w` metres wide, in folds about the plane y = 0, from z = 0.02 to `h`; `folds` of them.
pub fn curtain(w: f64, h: f64, folds: usize) -> Solid {
    let xs = steps(-w / 2.0, w / 2.0, folds * 2);
    grid_box(&xs, &[-0.006, 0.006], &steps(0.02, h, 5)).map(|p| {
        // Gathered at the rod, wider at the hem.
        let depth = 0.028 + 0.022 * (1.0 - p.z / h);
        v(p.x * (1.0 - 0.1 * p.z / h), p.y + depth * (std::f64::consts::TAU * folds as f64 * (p.x / w + 0.5)).cos(), p.z)
    })
}
