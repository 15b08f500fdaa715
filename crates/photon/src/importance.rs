//! What light matters to a camera: the view importance V of Dmitriev et al. 2002, §5.3, and past it.
//!
//! The seed counts photon hits in the camera's frustum, behind whatever stands before them, and weighs those on textures with 1 ÷ T_e, the
//! elevation of the threshold at which errors become visible. Past it, an item buffer says which element sides are seen and in how many
//! pixels, so that projected size and foreshortening count as they should: a deposit of energy Φ changes pixels · Φ ÷ area.

use crate::{triangle::Hit, visible::Frustum};
use std::sync::Arc;

/// A weight of 1 in fixed point: sums do not depend on their order.
pub const UNIT: u32 = 1 << 12;

/// How a camera tells what matters of photon groups, by the hits of pilots.
#[derive(Debug, Clone, PartialEq)]
pub enum Gaze {
    /// Hits in its frustum, all alike: the seed's V.
    Frustum(Frustum),
    /// The same, each as far as its texture lets an error be seen: the seed's V and 1 ÷ T_e.
    Masked(Frustum, Arc<Unmasked>),
}

/// 1 ÷ T_e of every triangle of every object, by number, in [`UNIT`]; of objects without texture nothing is kept.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Unmasked(pub Vec<Box<[u32]>>);

/// Importance of element sides, relative to the most important one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Importance {
    /// Per object, 2 · cell + side; empty where nothing is seen. At most 16 [`UNIT`]s.
    weights: Vec<Box<[u32]>>,
}

impl Importance {
    /// Of `objects` objects: (object, its cells, cell, side, weight above 0). Unseen sides have none.
    pub fn new(objects: usize, sides: &[(usize, u32, u32, usize, f64)]) -> Importance {
        let most = sides.iter().map(|side| side.4).fold(f64::MIN_POSITIVE, f64::max);
        let mut weights: Vec<Box<[u32]>> = vec![Box::default(); objects];
        for (object, cells, cell, side, weight) in sides {
            if weights[*object].is_empty() {
                weights[*object] = vec![0; 2 * *cells as usize].into();
            }
            weights[*object][2 * *cell as usize + side] = (weight / most * f64::from(16 * UNIT)).ceil() as u32;
        }
        Importance { weights }
    }

    /// Of a side of a cell.
    #[inline]
    pub fn of(&self, object: usize, cell: u32, side: u8) -> u32 {
        let weights = self.weights.get(object);
        weights.and_then(|weights| weights.get(2 * cell as usize + usize::from(side))).copied().unwrap_or(0)
    }
}

impl Gaze {
    /// How much a hit matters, in [`UNIT`].
    pub(crate) fn hit(&self, hit: &Hit) -> u32 {
        let inside = |frustum: &Frustum| frustum.contains(hit.triangle.point(hit.weights));
        match self {
            Gaze::Frustum(frustum) => u32::from(inside(frustum)) * UNIT,
            Gaze::Masked(frustum, unmasked) if inside(frustum) => {
                let triangles = unmasked.0.get(hit.triangle.object());
                triangles.and_then(|triangles| triangles.get(hit.triangle.in_mesh())).copied().unwrap_or(UNIT)
            }
            Gaze::Masked(..) => 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_relative_and_what_is_not_seen_has_none() {
        let importance = Importance::new(3, &[(1, 4, 2, 1, 0.5), (1, 4, 3, 0, 2.0)]);
        assert_eq!((importance.of(1, 3, 0), importance.of(1, 2, 1)), (16 * UNIT, 4 * UNIT));
        assert_eq!([importance.of(1, 2, 0), importance.of(0, 0, 0), importance.of(7, 0, 1)], [0; 3]);
        // However little it is, what is seen is not unseen.
        assert_eq!(Importance::new(1, &[(0, 2, 0, 0, 1e-30), (0, 2, 1, 0, 1.0)]).of(0, 0, 0), 1);
    }
}
