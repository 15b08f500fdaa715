//! What belongs to the walls and cannot be moved: skirting boards, door frames, windows, curtains; and the leaf of the doors.

use super::plan::{DOORWAYS, Room};
use crate::furniture::{bar, decor};
use crate::mesh::Mesh;
use crate::shapes::{soft_block, tube};
use crate::solid::v;

const WHITE: &str = "skirting white";
const PAINT: &str = "door paint";

/// Boards 8 cm high along all walls, with gaps at the door frames.
pub fn skirting() -> Mesh {
    let mut s = Vec::new();
    for room in Room::ALL {
        let [xs, ys] = room.bounds();
        for (axis, across) in [(0, ys), (1, xs)] {
            let ends = if axis == 0 { xs } else { ys };
            for (wall, inwards) in [(across[0], 0.014), (across[1], -0.014)] {
                // Pieces of the board between the casings of the doorways in this wall.
                let mut cut = vec![ends[0], ends[1]];
                for door in DOORWAYS.iter().filter(|d| d.along() == axis) {
                    let [min, max] = door.opening();
                    let here = min[1 - axis] - 0.01 < wall && wall < max[1 - axis] + 0.01;
                    if here && ends[0] < min[axis] && max[axis] < ends[1] {
                        cut.splice(1..1, [min[axis] - 0.061, max[axis] + 0.061]);
                    }
                }
                for piece in cut.chunks(2) {
                    let depth = if inwards > 0.0 { [wall, wall + inwards] } else { [wall + inwards, wall] };
                    // Boards along y end at those along x.
                    let short = |i: usize| if axis == 1 && (piece[i] == ends[i]) { 0.0141 } else { 0.0 };
                    let length = [piece[0] + short(0), piece[1] - short(1)];
                    let [x, y] = if axis == 0 { [length, depth] } else { [depth, length] };
                    s.push(bar(WHITE, x, y, [0.0, 0.08]));
                }
            }
        }
    }
    Mesh::new("skirting", s)
}

/// The frame of a doorway: lining, stops and casings on both sides; its origin is the hinge, the closed leaf lies along +y.
pub fn door_frame() -> Mesh {
    let lining = [-0.119, -0.001];
    let stop = [-0.065, -0.0405];
    let mut s = vec![
        bar(PAINT, lining, [-0.055, -0.005], [0.0, 2.015]),
        bar(PAINT, lining, [0.805, 0.855], [0.0, 2.015]),
        bar(PAINT, lining, [-0.055, 0.855], [2.0151, 2.065]),
        bar(PAINT, stop, [-0.0049, 0.012], [0.0, 2.015]),
        bar(PAINT, stop, [0.788, 0.8049], [0.0, 2.015]),
        bar(PAINT, stop, [0.0121, 0.7879], [1.997, 2.015]),
    ];
    for casing in [[-0.002, 0.012], [-0.132, -0.118]] {
        s.push(bar(PAINT, casing, [-0.11, -0.006], [0.0, 2.12]));
        s.push(bar(PAINT, casing, [0.806, 0.91], [0.0, 2.12]));
        s.push(bar(PAINT, casing, [-0.0059, 0.8059], [2.0161, 2.12]));
    }
    Mesh::new("door_frame", s)
}

/// The leaf of all doors: that of the room's door with its lever on both sides.
pub fn door() -> Mesh {
    let mut leaf = decor::door();
    for part in &mut leaf.parts {
        let levers: Vec<_> = part.solids.iter().filter(|s| s.material == "brass").cloned().collect();
        // A mirror image is inside out.
        part.solids.extend(levers.into_iter().map(|s| s.map(|p| v(-0.04 - p.x, p.y, p.z)).inside_out()));
    }
    leaf
}

/// A window of two sashes, 1.3 × 1.2 m, its sill at 0.95 m; the wall is y = 0, the room is on the +y side. It is night.
pub fn window() -> Mesh {
    let (half, low, high) = (0.65, 0.95, 2.15);
    let mut s = vec![
        bar(WHITE, [-half - 0.07, -half], [0.0, 0.1], [low, high]),
        bar(WHITE, [half, half + 0.07], [0.0, 0.1], [low, high]),
        bar(WHITE, [-half - 0.08, half + 0.08], [0.0, 0.105], [high + 0.0001, high + 0.08]),
        soft_block(v(-half - 0.12, 0.0, low - 0.04), v(half + 0.12, 0.18, low - 0.0001), 0.012).of(WHITE),
        bar("night", [-half, half], [0.01, 0.018], [low, high]),
    ];
    for (a, b) in [(-half + 0.001, -0.001), (0.001, half - 0.001)] {
        s.push(bar(WHITE, [a, a + 0.05], [0.0181, 0.06], [low + 0.001, high - 0.001]));
        s.push(bar(WHITE, [b - 0.05, b], [0.0181, 0.06], [low + 0.001, high - 0.001]));
        for z in [low + 0.002, low + 0.82, high - 0.052] {
            s.push(bar(WHITE, [a + 0.0501, b - 0.0501], [0.0182, 0.059], [z, z + 0.05]));
        }
    }
    Mesh::new("window", s)
}

/// Two curtains on a rod, 1.9 m long, down to the floor; the wall is y = 0, the room is on the +y side.
pub fn curtains() -> Mesh {
    let (y, rod) = (0.25, 2.4);
    let mut s = vec![tube(&[v(-0.95, y, rod), v(0.0, y, rod), v(0.95, y, rod)], v(0.0, 0.0, 1.0), 0.012, 8).of("black steel")];
    for x in [-0.95, 0.95] {
        s.push(bar("black steel", [x - 0.006, x + 0.006], [0.0, y], [rod - 0.006, rod + 0.006]));
    }
    for x in [-0.72, 0.72] {
        s.push(decor::curtain(0.42, rod - 0.012, 5).at(v(x, y, 0.0)).of("curtain cloth"));
    }
    Mesh::new("curtains", s)
}
