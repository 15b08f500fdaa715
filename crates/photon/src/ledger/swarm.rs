//! Boxes about what moved, in a tree: things that ride on one another stand together, and most segments pass all of them by at once; a
//! thousand boxes tested one by one would cost twice as much as shooting the pool.

use super::grid::{Cuboid, Grid};
use glam::Vec3;

/// So many boxes have no box about them.
const FEW: usize = 3;

/// So many are not parted: a test more costs as much as all of them.
const TOGETHER: usize = 8;

/// The boxes, and boxes about some of them, depth first.
#[derive(Debug, Default)]
pub struct Swarm(pub Vec<Node>);

/// A box.
#[derive(Debug, Clone, Copy)]
pub struct Node {
    /// It.
    pub cuboid: Cuboid,
    /// One of what moved; otherwise it is about those that follow, up to `next`.
    pub moved: bool,
    /// What comes next if it is not met.
    pub next: u32,
}

impl Swarm {
    /// Boxes by their corners, metres, larger by `slack` metres; those outside of the grid are left out.
    pub fn new(boxes: impl Iterator<Item = [Vec3; 2]>, slack: f32, grid: &Grid) -> Swarm {
        let cuboid = |bounds| grid.cuboid(bounds, slack).0;
        let mut boxes: Vec<_> = boxes.filter(|bounds| cuboid(*bounds).is_some()).collect();
        let mut swarm = Swarm::default();
        swarm.gather(&mut boxes, &cuboid);
        swarm
    }

    fn gather(&mut self, boxes: &mut [[Vec3; 2]], cuboid: &impl Fn([Vec3; 2]) -> Option<Cuboid>) {
        let bounds = boxes.iter().copied().reduce(|[low, high], [l, h]| [low.min(l), high.max(h)]);
        // What is about a box in the grid is in the grid as well.
        let around = bounds.and_then(|bounds| Some((bounds, cuboid(bounds)?))).filter(|_| boxes.len() >= FEW);
        let place = self.0.len();
        if let Some((_, cuboid)) = around {
            self.0.push(Node { cuboid, moved: false, next: 0 });
        }
        match around {
            Some(([low, high], _)) if boxes.len() > TOGETHER => {
                let size = high - low;
                let axis = (0..3).fold(0, |longest, axis| if size[axis] > size[longest] { axis } else { longest });
                let middle = |[low, high]: &[Vec3; 2]| low[axis] + high[axis];
                boxes.sort_by(|a, b| middle(a).total_cmp(&middle(b)));
                let (left, right) = boxes.split_at_mut(boxes.len() / 2);
                self.gather(left, cuboid);
                self.gather(right, cuboid);
            }
            _ => {
                for cuboid in boxes.iter().filter_map(|bounds| cuboid(*bounds)) {
                    self.0.push(Node { cuboid, moved: true, next: self.0.len() as u32 + 1 });
                }
            }
        }
        if around.is_some() {
            self.0[place].next = self.0.len() as u32;
        }
    }
}
