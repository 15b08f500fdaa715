//! Boxes of the movable objects, side by side in memory: each ray tests them all before any tree.
//!
//! In a room with 37 movables, fetching each box through its object's pointer took a quarter of all time. Below about a hundred
//! objects a top-level tree does not pay (measured in our study).

use crate::{
    lanes::LANES,
    tree::{NO_BOXES, Planes},
};
use glam::Vec3;

/// A list of boxes.
#[derive(Debug, Clone, Default)]
pub struct Boxes {
    eights: Vec<Planes>,
}

impl Boxes {
    /// Boxes by their low and high corners, metres.
    pub fn new(boxes: impl Iterator<Item = [Vec3; 2]>) -> Boxes {
        let mut eights: Vec<Planes> = Vec::new();
        for (n, [low, high]) in boxes.enumerate() {
            if n % LANES == 0 {
                eights.push(NO_BOXES);
            }
            let last = eights.len() - 1;
            for axis in 0..3 {
                eights[last][axis][n % LANES] = low[axis];
                eights[last][axis + 3][n % LANES] = high[axis];
            }
        }
        Boxes { eights }
    }

    /// The boxes, eight by eight; number k of the n-th eight is box 8n + k.
    pub fn eights(&self) -> &[Planes] {
        &self.eights
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        lanes::Portable,
        tree::{Beam, Way},
        triangle::Ray,
    };

    #[test]
    fn only_boxes_on_the_way_are_visited() {
        let at = |x: f32| [Vec3::new(x, -1.0, -1.0), Vec3::new(x + 1.0, 1.0, 1.0)];
        let boxes = Boxes::new((0..11).map(|k| at(k as f32 * 2.0)).chain([[Vec3::new(4.0, 5.0, 5.0), Vec3::splat(6.0)]]));
        let visited = |ray: &Ray, limit: f32| -> Vec<usize> {
            let beam = Beam::new(Portable, ray);
            let masks = boxes.eights().iter().map(|planes| beam.enters(planes, limit).0);
            masks
                .enumerate()
                .flat_map(|(n, mask)| (0..LANES).filter(move |k| mask >> k & 1 != 0).map(move |k| n * LANES + k))
                .collect()
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
