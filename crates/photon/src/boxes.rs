//! Boxes of the movable objects, side by side in memory: each ray tests them all before any tree.
//!
//! In a room with 37 movables, fetching each box through its object's pointer took a quarter of all time. Below about a hundred
//! objects a top-level tree does not pay (measured in our study).

use crate::triangle::Ray;
use glam::Vec3;

/// Boxes tested at once; the compiler turns the loop over them into vector instructions.
const LANES: usize = 8;

/// [`LANES`] boxes: low x, y, z, high x, y, z of each.
type Lane = [[f32; LANES]; 6];

/// A list of boxes.
#[derive(Debug, Clone, Default)]
pub struct Boxes {
    lanes: Vec<Lane>,
}

impl Boxes {
    /// Boxes by their low and high corners, metres.
    pub fn new(boxes: impl Iterator<Item = [Vec3; 2]>) -> Boxes {
        let mut lanes: Vec<Lane> = Vec::new();
        for (n, [low, high]) in boxes.enumerate() {
            if n % LANES == 0 {
                // What is not filled is empty: its low corner is above its high one.
                lanes.push([[1.0; LANES], [1.0; LANES], [1.0; LANES], [-1.0; LANES], [-1.0; LANES], [-1.0; LANES]]);
            }
            let lane = lanes.len() - 1;
            for axis in 0..3 {
                lanes[lane][axis][n % LANES] = low[axis];
                lanes[lane][axis + 3][n % LANES] = high[axis];
            }
        }
        Boxes { lanes }
    }

    /// Calls `visit` with the number of every box that the ray enters before its current limit, which `visit` returns
    /// (in multiples of the ray's direction).
    #[inline]
    pub fn entered(&self, ray: &Ray, inverse: Vec3, mut limit: f32, mut visit: impl FnMut(usize) -> f32) {
        for (n, lane) in self.lanes.iter().enumerate() {
            let mut enter = [0f32; LANES];
            let mut leave = [f32::INFINITY; LANES];
            for axis in 0..3 {
                let (origin, inverse) = (ray.origin[axis], inverse[axis]);
                let (near, far) = if inverse < 0.0 { (axis + 3, axis) } else { (axis, axis + 3) };
                for k in 0..LANES {
                    let a = (lane[near][k] - origin) * inverse;
                    let b = (lane[far][k] - origin) * inverse;
                    enter[k] = if a > enter[k] { a } else { enter[k] };
                    leave[k] = if b < leave[k] { b } else { leave[k] };
                }
            }
            for k in 0..LANES {
                if enter[k] <= leave[k] && enter[k] <= limit {
                    limit = visit(n * LANES + k);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::inverse;

    #[test]
    fn only_boxes_on_the_way_are_visited() {
        let at = |x: f32| [Vec3::new(x, -1.0, -1.0), Vec3::new(x + 1.0, 1.0, 1.0)];
        let boxes = Boxes::new((0..11).map(|k| at(k as f32 * 2.0)).chain([[Vec3::new(4.0, 5.0, 5.0), Vec3::splat(6.0)]]));
        let visited = |ray: &Ray, limit: f32| {
            let mut seen = Vec::new();
            boxes.entered(ray, inverse(ray.direction), limit, |n| {
                seen.push(n);
                limit
            });
            seen
        };
        let ray = Ray::new(Vec3::new(-1.0, 0.0, 0.0), Vec3::X, None, 0.0);
        assert_eq!(visited(&ray, f32::INFINITY), (0..11).collect::<Vec<_>>());
        assert_eq!(visited(&ray, 6.0), [0, 1, 2]);
        let back = Ray::new(Vec3::new(5.5, 0.0, 0.0), -Vec3::X, None, 0.0);
        assert_eq!(visited(&back, f32::INFINITY), [0, 1, 2]);
        let up = Ray::new(Vec3::new(4.5, 5.5, -9.0), Vec3::Z, None, 0.0);
        assert_eq!(visited(&up, f32::INFINITY), [11]);
    }
}
