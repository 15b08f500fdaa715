//! The house without its furniture: an inward-facing box cut at the middles of the interior walls, and those walls as one solid.
//!
//! The box is closed by itself and the interior walls reach 5 cm through it, so light that leaks at no edge of the box cannot leave,
//! and none passes from room to room but through a doorway.

use glam::DVec3;

use super::plan::{DOORWAYS, Room, SIZE, WALL_EAST, WALL_MIDDLE, WALL_WEST};
use crate::mesh::{Mesh, Part};
use crate::shapes::{grid_box, grid_solid, steps};
use crate::solid::Solid;

/// How far the interior walls reach through the box, metres.
const THROUGH: f64 = 0.05;

/// The longest side of a piece of wall, metres.
const PIECE: f64 = 0.5;

/// Coordinates at all `marks` (ascending) and at equal steps of at most [`PIECE`] between them.
fn cuts(marks: &[f64]) -> Vec<f64> {
    let mut all = vec![marks[0]];
    for pair in marks.windows(2) {
        all.extend(steps(pair[0], pair[1], ((pair[1] - pair[0]) / PIECE).ceil() as usize).into_iter().skip(1));
        // Not a rounding error beside the mark: a corner lies where it was said.
        all.pop();
        all.push(pair[1]);
    }
    all
}

/// The outer box: one part for each room and side, like `kitchen floor`. All parts together are closed.
pub fn shell() -> Mesh {
    let [x, y, z] = SIZE;
    let middle = |wall: [f64; 2]| (wall[0] + wall[1]) / 2.0;
    let xs = cuts(&[0.0, middle(WALL_MIDDLE), x]);
    let ys = cuts(&[0.0, middle(WALL_WEST), middle(WALL_EAST), y]);
    let whole = grid_box(&xs, &ys, &cuts(&[0.0, z])).inside_out();
    let mut parts: Vec<Part> = Vec::new();
    for room in Room::ALL {
        for (side, at) in SIDES {
            let of = |t: &&[usize; 3]| {
                let corners = t.map(|i| whole.points[i]);
                let centre = corners.iter().sum::<DVec3>() / 3.0;
                Room::at(centre) == room && corners.iter().all(|p| at(*p))
            };
            let triangles: Vec<_> = whole.triangles.iter().filter(of).copied().collect();
            if !triangles.is_empty() {
                parts.push(Part {
                    name: format!("{} {side}", room.name()),
                    solids: vec![only(&whole, triangles, room.paint(side))],
                });
            }
        }
    }
    Mesh { name: "shell".into(), parts }
}

type Side = (&'static str, fn(DVec3) -> bool);

const SIDES: [Side; 6] = [
    ("floor", |p| p.z == 0.0),
    ("ceiling", |p| p.z == SIZE[2]),
    ("south wall", |p| p.y == 0.0),
    ("north wall", |p| p.y == SIZE[1]),
    ("west wall", |p| p.x == 0.0),
    ("east wall", |p| p.x == SIZE[0]),
];

/// Some triangles of a surface, with only the points that they use.
fn only(whole: &Solid, triangles: Vec<[usize; 3]>, material: &'static str) -> Solid {
    let mut used: Vec<usize> = triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let place = |i: usize| used.partition_point(|&u| u < i);
    let triangles = triangles.iter().map(|t| t.map(place)).collect();
    Solid { material, points: used.iter().map(|&i| whole.points[i]).collect(), uv: Vec::new(), triangles }
}

/// The interior walls with their doorways: one closed solid.
pub fn walls() -> Mesh {
    let [x, y, z] = SIZE;
    let mut marks = [vec![-THROUGH, WALL_MIDDLE[0], WALL_MIDDLE[1], x + THROUGH], vec![-THROUGH, y + THROUGH]];
    marks[1].extend([WALL_WEST, WALL_EAST].concat());
    let mut heights = vec![-THROUGH, z + THROUGH];
    for door in DOORWAYS {
        let [min, max] = door.opening();
        marks[door.along()].extend([min[door.along()], max[door.along()]]);
        heights.push(max.z);
    }
    for m in marks.iter_mut().chain([&mut heights]) {
        m.sort_by(f64::total_cmp);
        m.dedup();
    }
    let solid = grid_solid(&cuts(&marks[0]), &cuts(&marks[1]), &cuts(&heights), |p| {
        let within = |a: f64, [low, high]: [f64; 2]| low < a && a < high;
        let wall = within(p.x, WALL_MIDDLE) || within(p.y, if p.x < WALL_MIDDLE[0] { WALL_WEST } else { WALL_EAST });
        wall && !DOORWAYS.iter().any(|d| {
            let [min, max] = d.opening();
            p.cmpgt(min).all() && p.cmplt(max).all()
        })
    });
    Mesh::new("walls", vec![solid.of("wall white")])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_outer_box_is_closed() {
        let mut all = Solid { material: "", points: Vec::new(), uv: Vec::new(), triangles: Vec::new() };
        for s in shell().solids() {
            let n = all.points.len();
            all.points.extend(&s.points);
            all.triangles.extend(s.triangles.iter().map(|t| t.map(|i| i + n)));
        }
        assert_eq!(all.defect(), None);
        assert!((all.volume() + SIZE.iter().product::<f64>()).abs() < 1e-9);
    }
}
