//! What belongs to the walls and cannot be moved: skirting boards, the door's frame, the window with its curtains.

use super::SIZE;
use crate::furniture::decor::curtain;
use crate::mesh::Mesh;
use crate::shapes::{block, soft_block, tube};
use crate::solid::{Solid, v};

fn bar(material: &'static str, x: [f64; 2], y: [f64; 2], z: [f64; 2]) -> Solid {
    block(v(x[0], y[0], z[0]), v(x[1], y[1], z[1])).of(material)
}

/// The fixed meshes.
pub fn meshes() -> Vec<Mesh> {
    vec![skirting(), door_frame(), window(), curtains()]
}

/// A board 8 cm high around the room, with a gap for the door's frame.
fn skirting() -> Mesh {
    let [x, y, _] = SIZE;
    let (t, h, paint) = (0.014, [0.0, 0.08], "skirting white");
    let s = vec![
        bar(paint, [0.0, x], [0.0, t], h),
        bar(paint, [0.0, x], [y - t, y], h),
        bar(paint, [x - t, x], [t + 0.0001, y - t - 0.0001], h),
        bar(paint, [0.0, t], [t + 0.0001, 0.409], h),
        bar(paint, [0.0, t], [1.391, y - t - 0.0001], h),
    ];
    Mesh::new("skirting", s)
}

/// The frame around the door, and the darkness behind it.
fn door_frame() -> Mesh {
    let (paint, depth) = ("door paint", [0.0, 0.075]);
    let s = vec![
        bar(paint, depth, [0.41, 0.494], [0.0, 2.1]),
        bar(paint, depth, [1.306, 1.39], [0.0, 2.1]),
        bar(paint, [0.0, 0.0751], [0.4941, 1.3059], [2.016, 2.1]),
        bar("night", [0.0, 0.008], [0.4942, 1.3058], [0.0, 2.0159]),
    ];
    Mesh::new("door_frame", s)
}

/// A casement window on the north wall, 1.2 × 1.3 m: casing, two sashes, a sill, and night behind the glass.
fn window() -> Mesh {
    let y = SIZE[1];
    let paint = "skirting white";
    let (left, right, low, high) = (1.3, 2.5, 0.95, 2.25);
    let casing = [y - 0.11, y];
    let mut s = vec![
        bar(paint, [left - 0.06, left], casing, [low, high]),
        bar(paint, [right, right + 0.06], casing, [low, high]),
        bar(paint, [left - 0.07, right + 0.07], [y - 0.115, y], [high + 0.0001, high + 0.07]),
        soft_block(v(left - 0.12, y - 0.2, low - 0.04), v(right + 0.12, y, low - 0.0001), 0.012).of(paint),
        bar("night", [left, right], [y - 0.02, y - 0.012], [low, high]),
    ];
    let middle = (left + right) / 2.0;
    for (a, b) in [(left + 0.001, middle - 0.001), (middle + 0.001, right - 0.001)] {
        let sash = [y - 0.06, y - 0.021];
        s.push(bar(paint, [a, a + 0.05], sash, [low + 0.001, high - 0.001]));
        s.push(bar(paint, [b - 0.05, b], sash, [low + 0.001, high - 0.001]));
        for z in [low + 0.002, high - 0.052] {
            s.push(bar(paint, [a + 0.0501, b - 0.0501], [y - 0.059, y - 0.022], [z, z + 0.05]));
        }
    }
    Mesh::new("window", s)
}

/// Two curtains on a rod in front of the window, down to the floor.
fn curtains() -> Mesh {
    let (y, rod) = (SIZE[1] - 0.27, 2.46);
    let mut s = vec![tube(&[v(0.95, y, rod), v(1.9, y, rod), v(2.85, y, rod)], v(0.0, 0.0, 1.0), 0.012, 6).of("black steel")];
    for x in [0.95, 2.85] {
        s.push(bar("black steel", [x - 0.006, x + 0.006], [y + 0.027, SIZE[1]], [rod - 0.006, rod + 0.006]));
    }
    for x in [1.15, 2.65] {
        s.push(curtain(0.42, rod - 0.012, 4).at(v(x, y, 0.0)).of("curtain cloth"));
    }
    Mesh::new("curtains", s)
}
