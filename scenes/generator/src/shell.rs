//! A closed room: six rectangles with shared corners, facing inwards.

use crate::mesh::Part;
use crate::solid::{Solid, v};

/// The six walls of a room of `x` × `y` × `z` metres whose corner is the origin. Together they are one closed box: neighbours have
/// the very same coordinates. `paint` names the material of each.
pub fn walls(x: f64, y: f64, z: f64, paint: impl Fn(&str) -> &'static str) -> Vec<Part> {
    // Counter-clockwise seen from inside; bits 1, 2, 4 of a corner are its x, y, z.
    let faces: [(&str, [usize; 4]); 6] = [
        ("floor", [0, 1, 3, 2]),
        ("ceiling", [4, 6, 7, 5]),
        ("south wall", [0, 4, 5, 1]),
        ("north wall", [2, 3, 7, 6]),
        ("west wall", [0, 2, 6, 4]),
        ("east wall", [1, 5, 7, 3]),
    ];
    faces
        .map(|(name, corners)| {
            let at = |i: usize, bit: usize, size: f64| if i & bit == 0 { 0.0 } else { size };
            let points = corners.map(|i| v(at(i, 1, x), at(i, 2, y), at(i, 4, z))).to_vec();
            let solid = Solid { material: paint(name), points, uv: Vec::new(), triangles: vec![[0, 1, 2], [0, 2, 3]] };
            Part { name: name.to_string(), solids: vec![solid] }
        })
        .to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_close_a_room_and_face_inwards() {
        let mut all = Solid { material: "", points: Vec::new(), uv: Vec::new(), triangles: Vec::new() };
        for part in walls(2.0, 3.0, 4.0, |_| "") {
            for s in part.solids {
                let n = all.points.len();
                all.points.extend(s.points);
                all.triangles.extend(s.triangles.iter().map(|t| t.map(|i| i + n)));
            }
        }
        assert_eq!(all.defect(), None);
        assert!((all.volume() + 24.0).abs() < 1e-12);
    }
}
