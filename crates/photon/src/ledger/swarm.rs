//! Boxes about what moved, in a tree that streams of segments go down, fewer at every step.
//!
//! Things that ride on one another stand together: most segments pass all of them by at once. And a thousand boxes, tested one by one,
//! would cost twice as much as shooting the pool.

use super::{
    chunk::PHOTONS,
    grid::{Cuboid, Grid},
    scan::{Row, crossed},
};
use glam::Vec3;

/// So many boxes are tested one by one on all segments that come.
const FEW: usize = 3;

/// So many are not parted: a test more costs as much as all of them.
const TOGETHER: usize = 8;

/// Some boxes.
pub enum Swarm {
    /// Each tested on all segments.
    Few(Vec<Cuboid>),
    /// Tested only on segments that come near.
    Within {
        /// About all of them.
        around: Cuboid,
        /// They.
        parts: Vec<Swarm>,
    },
}

impl Swarm {
    /// Boxes by their corners, metres, larger by `slack` metres; those outside of the grid are left out.
    pub fn new(boxes: impl Iterator<Item = [Vec3; 2]>, slack: f32, grid: &Grid) -> Swarm {
        let cuboid = |bounds| grid.cuboid(bounds, slack).0;
        let mut boxes: Vec<_> = boxes.filter(|bounds| cuboid(*bounds).is_some()).collect();
        Swarm::of(&mut boxes, &cuboid)
    }

    fn of(boxes: &mut [[Vec3; 2]], cuboid: &impl Fn([Vec3; 2]) -> Option<Cuboid>) -> Swarm {
        let few = |boxes: &[[Vec3; 2]]| Swarm::Few(boxes.iter().filter_map(|bounds| cuboid(*bounds)).collect());
        let bounds = boxes.iter().copied().reduce(|[low, high], [l, h]| [low.min(l), high.max(h)]);
        // What is about a box in the grid is in the grid as well.
        let Some((bounds, around)) = bounds.and_then(|bounds| Some((bounds, cuboid(bounds)?))).filter(|_| boxes.len() >= FEW)
        else {
            return few(boxes);
        };
        let parts = if boxes.len() <= TOGETHER {
            vec![few(boxes)]
        } else {
            let size = bounds[1] - bounds[0];
            let axis = (0..3).fold(0, |longest, axis| if size[axis] > size[longest] { axis } else { longest });
            let middle = |[low, high]: &[Vec3; 2]| low[axis] + high[axis];
            boxes.sort_by(|a, b| middle(a).total_cmp(&middle(b)));
            let (left, right) = boxes.split_at_mut(boxes.len() / 2);
            vec![Swarm::of(left, cuboid), Swarm::of(right, cuboid)]
        };
        Swarm::Within { around, parts }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        matches!(self, Swarm::Few(boxes) if boxes.is_empty())
    }

    /// Raises the flags of the first `segments` segments that meet a box.
    pub fn met(&self, from: &Row, to: &Row, flags: &mut [u32; PHOTONS], segments: usize) {
        let (around, parts) = match self {
            Swarm::Few(boxes) => return boxes.iter().for_each(|cuboid| crossed(from, to, cuboid, flags, segments)),
            Swarm::Within { around, parts } => (around, parts),
        };
        let mut near = [0; PHOTONS];
        crossed(from, to, around, &mut near, segments);
        let [mut nearer_from, mut nearer_to] = [Row::default(), Row::default()];
        let (mut ranks, mut count) = ([0; PHOTONS], 0);
        for rank in (0..segments.min(PHOTONS)).filter(|rank| near[*rank] != 0 && flags[*rank] == 0) {
            for axis in 0..3 {
                nearer_from.0[axis][count] = from.0[axis][rank];
                nearer_to.0[axis][count] = to.0[axis][rank];
            }
            ranks[count] = rank;
            count += 1;
        }
        if count > 0 {
            let mut met = [0; PHOTONS];
            parts.iter().for_each(|part| part.met(&nearer_from, &nearer_to, &mut met, count));
            ranks[..count].iter().zip(met).for_each(|(rank, met)| flags[*rank] |= met);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hash::mix;

    #[test]
    fn a_swarm_is_met_where_one_of_its_boxes_is() {
        let grid = Grid::new([Vec3::ZERO, Vec3::new(6.0, 4.0, 3.0)], 6.0);
        let number = |n: u64| (mix(n) >> 40) as f32 / (1u64 << 24) as f32;
        let point = |n: u64| Vec3::new(number(3 * n), number(3 * n + 1), number(3 * n + 2)) * Vec3::new(6.0, 4.0, 3.0);
        let mut rows = [Row::default(), Row::default()];
        for (rank, end) in (0..PHOTONS).flat_map(|rank| [(rank, 0), (rank, 1)]) {
            let place = grid.place(point((2 * rank + end) as u64));
            (0..3).for_each(|axis| rows[end].0[axis][rank] = f32::from(place[axis]));
        }
        let [from, to] = &rows;
        for count in [0, 1, 2, 3, 8, 9, 100, 1000] {
            let boxes: Vec<[Vec3; 2]> = (0..count).map(|n| point(1000 + n)).map(|low| [low, low + Vec3::splat(0.1)]).collect();
            let swarm = Swarm::new(boxes.iter().copied(), 0.0, &grid);
            let (mut met, mut expected) = ([0; PHOTONS], [0; PHOTONS]);
            let segments = PHOTONS - 3;
            swarm.met(from, to, &mut met, segments);
            boxes
                .iter()
                .filter_map(|bounds| grid.cuboid(*bounds, 0.0).0)
                .for_each(|c| crossed(from, to, &c, &mut expected, segments));
            // A box that is met by a hair may be in one that is missed by a hair; these are none.
            assert_eq!(met, expected, "{count}");
            assert_eq!(swarm.is_empty(), count == 0);
        }
        let outside = [Vec3::splat(30.0), Vec3::splat(31.0)];
        assert!(Swarm::new([outside].into_iter(), 0.0, &grid).is_empty());
    }
}
