//! A better binary tree by reinsertion: a branch is taken out and put where the weights of all boxes together become least.
//!
//! Meister, Bittner 2018, *Parallel Reinsertion for Bounding Volume Hierarchy Optimization*, one branch after the other: the heaviest
//! first, in passes over ever fewer of them. Splits from the top down group by middles of boxes, so that what is large and flat shares
//! branches with what is small; this takes it out.

use crate::{
    split::{Bounds, Branch},
    stack::LEVELS,
};
use std::{cmp::Reverse, collections::BinaryHeap};

/// The pass over all candidates is followed by passes over a third of them, a fifth, … one of so many.
const LAST: usize = 31;
/// A search looks at no more branches: boxes that all lie in each other would make it look at all.
const LOOKS: usize = 4096;
/// No branch: above the root.
const NONE: u32 = u32::MAX;

/// A tree in which branches keep their numbers while they move.
struct Moving<'a> {
    branches: &'a mut [Branch],
    parents: Vec<u32>,
    /// Levels below each branch.
    heights: Vec<u8>,
    root: u32,
    /// Of a search: what is yet to be tried, and the weight that is gone before it is entered.
    stack: Vec<(f32, u32)>,
}

/// A better tree over boxes in some order: looks for a new place for `most` of its branches, and then again for ever fewer.
pub fn reinsert((mut branches, order): (Vec<Branch>, Vec<u32>), most: usize) -> (Vec<Branch>, Vec<u32>) {
    let (mut parents, mut heights) = (vec![NONE; branches.len()], vec![0; branches.len()]);
    for (own, branch) in branches.iter().enumerate().rev() {
        if let Some([a, b]) = branch.halves.map(|halves| halves.map(|half| half as usize)) {
            (parents[a], parents[b]) = (own as u32, own as u32);
            heights[own] = 1 + heights[a].max(heights[b]);
        }
    }
    let mut moving = Moving { branches: &mut branches, parents, heights, root: 0, stack: Vec::new() };
    for part in (1..=LAST).step_by(2) {
        for own in moving.heaviest(most / part) {
            if let Some(to) = moving.better_place(own) {
                moving.put(own, to);
            }
        }
    }
    let root = moving.root;
    laid_out(&branches, &order, root)
}

impl Moving<'_> {
    fn weight(&self, branch: u32) -> f32 {
        self.branches[branch as usize].bounds.weight()
    }

    /// The branches of most weight but for the root, in order.
    fn heaviest(&self, most: usize) -> Vec<u32> {
        let mut heaviest = Vec::with_capacity(most + 1);
        // None has more than its parent. Weights order as their bits do.
        let mut next = BinaryHeap::from([(self.weight(self.root).to_bits(), Reverse(self.root))]);
        while heaviest.len() <= most
            && let Some((_, Reverse(branch))) = next.pop()
        {
            heaviest.push(branch);
            let halves = self.branches[branch as usize].halves.into_iter().flatten();
            next.extend(halves.map(|half| (self.weight(half).to_bits(), Reverse(half))));
        }
        heaviest.split_off(1)
    }

    fn sibling(&self, branch: u32) -> u32 {
        let [a, b] = self.branches[self.parents[branch as usize] as usize].halves.expect("a parent");
        if a == branch { b } else { a }
    }

    /// Beside which branch `own` makes the sum of weights least, if not where it is (algorithm 1).
    fn better_place(&mut self, own: u32) -> Option<u32> {
        let (bounds, weight) = (self.branches[own as usize].bounds, self.weight(own));
        let mut best = (0.0, None);
        // What is left of the branches above, without `own`.
        let mut left = Bounds::EMPTY;
        let (mut below, mut looks) = (own, 0);
        let mut gone = self.weight(self.parents[own as usize]);
        while below != self.root {
            let (above, sibling) = (self.parents[below as usize], self.sibling(below));
            self.stack.push((gone, sibling));
            while let Some((gone, to)) = self.stack.pop() {
                looks += 1;
                if gone - weight <= best.0 || looks > LOOKS {
                    continue;
                }
                let branch = &self.branches[to as usize];
                let gain = gone - branch.bounds.with(bounds).weight();
                if gain > best.0 && self.is_shallow(own, to) {
                    best = (gain, Some(to));
                }
                let within = gain + branch.bounds.weight();
                self.stack.extend(branch.halves.into_iter().flatten().map(|half| (within, half)));
            }
            left = left.with(self.branches[sibling as usize].bounds);
            if below != own {
                // Beside all else that is in there.
                let whole = self.weight(above);
                gone += whole - left.weight();
                if gone - whole > best.0 && self.is_shallow(own, above) {
                    best = (gone - whole, Some(above));
                }
            }
            below = above;
        }
        best.1
    }

    /// Whether the tree is not too deep with `own` beside `to`.
    fn is_shallow(&self, own: u32, to: u32) -> bool {
        let height = self.heights[own as usize].max(self.heights[to as usize]);
        let above = std::iter::successors(Some(to), |branch| Some(self.parents[*branch as usize]).filter(|above| *above != NONE));
        above.count() + usize::from(height) <= LEVELS
    }

    fn put(&mut self, own: u32, to: u32) {
        let (parent, sibling) = (self.parents[own as usize], self.sibling(own));
        self.replace(parent, sibling);
        self.measure_up(self.parents[sibling as usize]);
        self.replace(to, parent);
        self.branches[parent as usize].halves = Some([to, own]);
        self.parents[to as usize] = parent;
        self.measure_up(parent);
    }

    /// Puts `new` where `old` is.
    fn replace(&mut self, old: u32, new: u32) {
        let above = self.parents[old as usize];
        self.parents[new as usize] = above;
        match self.branches.get_mut(above as usize).and_then(|branch| branch.halves.as_mut()) {
            Some(halves) => *halves = halves.map(|half| if half == old { new } else { half }),
            None => self.root = new,
        }
    }

    fn measure_up(&mut self, mut branch: u32) {
        while branch != NONE {
            self.measure(branch as usize);
            branch = self.parents[branch as usize];
        }
    }

    /// Makes box and height of a branch those of its halves.
    fn measure(&mut self, branch: usize) {
        let [a, b] = self.branches[branch].halves.expect("halves").map(|half| half as usize);
        self.branches[branch].bounds = self.branches[a].bounds.with(self.branches[b].bounds);
        self.heights[branch] = 1 + self.heights[a].max(self.heights[b]);
    }
}

/// The tree and its order anew: parents before children, each branch a range of the order.
fn laid_out(branches: &[Branch], order: &[u32], root: u32) -> (Vec<Branch>, Vec<u32>) {
    let (mut laid_out, mut order_of_it) = (Vec::with_capacity(branches.len()), Vec::with_capacity(order.len()));
    let mut next = vec![(root, None)];
    while let Some((old, half_of)) = next.pop() {
        let own = laid_out.len() as u32;
        let mut branch = branches[old as usize].clone();
        if let Some((parent, half)) = half_of {
            let parent: &mut Branch = &mut laid_out[parent as usize];
            parent.halves.as_mut().expect("halves")[half] = own;
        }
        if let Some([a, b]) = branch.halves {
            next.extend([(b, Some((own, 1))), (a, Some((own, 0)))]);
        } else {
            let first = order_of_it.len() as u32;
            order_of_it.extend(&order[branch.items.start as usize..branch.items.end as usize]);
            branch.items = first..order_of_it.len() as u32;
        }
        laid_out.push(branch);
    }
    for own in (0..laid_out.len()).rev() {
        if let Some([a, b]) = laid_out[own].halves {
            laid_out[own].items = laid_out[a as usize].items.start..laid_out[b as usize].items.end;
        }
    }
    (laid_out, order_of_it)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::split::{Effort, binary};
    use glam::{Vec3A, vec3a};

    const SPLITS: Effort = Effort { bins: 16, exact: 24, whole: 1, moved: 0 };

    fn box_at(low: Vec3A, extent: Vec3A) -> Bounds {
        Bounds { low, high: low + extent }
    }

    fn random(n: u64) -> f32 {
        (crate::hash::mix(n) >> 40) as f32 / (1u64 << 24) as f32
    }

    /// Small ones all over a room, flat ones among them, some of them twice.
    fn furniture(count: u64) -> Vec<Bounds> {
        let boxes = (0..count).map(|n| {
            let [x, y, z] = [0, 1, 2].map(|k| random(6 * (n - n % 9 / 8) + k));
            let size = if n % 7 == 0 { 0.7 } else { 0.05 };
            let mut extent = size * vec3a(random(6 * n + 3), random(6 * n + 4), random(6 * n + 5));
            extent[n as usize % 3] *= if n % 7 == 0 { 0.0 } else { 1.0 };
            box_at(vec3a(x, y, z), extent)
        });
        boxes.collect()
    }

    /// Boxes one in the other, for which a chain has the least weight.
    fn nested(count: u32) -> Vec<Bounds> {
        let size = |n: u32| Vec3A::splat(1.01f32.powi(n as i32));
        (0..count).map(|n| box_at(-size(n), 2.0 * size(n))).collect()
    }

    fn weights(branches: &[Branch]) -> f64 {
        branches.iter().map(|branch| f64::from(branch.bounds.weight())).sum()
    }

    /// Checks that it is a tree over all boxes, and returns how many levels it has.
    fn check(branches: &[Branch], order: &[u32], boxes: &[Bounds]) -> usize {
        let mut sorted = order.to_vec();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..boxes.len() as u32), "every box once");
        assert_eq!(branches[0].items, 0..boxes.len() as u32);
        let mut depths = vec![None; branches.len()];
        depths[0] = Some(0);
        for (own, branch) in branches.iter().enumerate() {
            let depth = depths[own].expect("parents come before their children");
            let mut bounds = Bounds::EMPTY;
            match branch.halves {
                None => {
                    let items = &order[branch.items.start as usize..branch.items.end as usize];
                    items.iter().for_each(|item| bounds = bounds.with(boxes[*item as usize]));
                }
                Some([a, b]) => {
                    let halves = [a, b].map(|half| &branches[half as usize]);
                    assert_eq!(branch.items, halves[0].items.start..halves[1].items.end);
                    assert_eq!(halves[0].items.end, halves[1].items.start);
                    halves.iter().for_each(|half| bounds = bounds.with(half.bounds));
                    [a, b].iter().for_each(|half| assert_eq!(depths[*half as usize].replace(depth + 1), None, "one parent"));
                }
            }
            assert!(!branch.items.is_empty() && branch.bounds == bounds, "branch {own}");
        }
        depths.into_iter().flatten().max().unwrap()
    }

    #[test]
    fn it_stays_a_tree_and_loses_weight() {
        for whole in [1, 5] {
            let boxes = furniture(3000);
            let (mut branches, mut order) = binary(&boxes, Effort { whole, ..SPLITS });
            let at_first = weights(&branches);
            let mut before = at_first;
            for most in [1, 10, 100, 1000, 1_000_000] {
                (branches, order) = reinsert((branches, order), most);
                check(&branches, &order, &boxes);
                // Sums of weights in f32 differ by their rounding.
                assert!(weights(&branches) < before * (1.0 + 1e-6), "{most}: {} after {before}", weights(&branches));
                before = weights(&branches);
            }
            assert!(before < 0.95 * at_first, "{before} of {at_first}");
        }
    }

    #[test]
    fn small_trees_are_left_as_they_are() {
        for count in 1..=2 {
            let boxes = furniture(count);
            let (branches, order) = reinsert(binary(&boxes, SPLITS), 100);
            assert_eq!(check(&branches, &order, &boxes), count as usize - 1);
        }
    }

    #[test]
    fn a_wall_and_a_far_crumb_part() {
        let crumb = |x: f32, z: f32| box_at(vec3a(x, 0.0, z), Vec3A::splat(0.1));
        let wall = box_at(Vec3A::ZERO, vec3a(10.0, 0.0, 10.0));
        let boxes = [wall, crumb(20.0, 0.0), crumb(5.0, 9.0), crumb(20.2, 0.0)];
        let branch = |items: std::ops::Range<u32>, halves| {
            let bounds = boxes[items.start as usize..items.end as usize].iter().fold(Bounds::EMPTY, |all, one| all.with(*one));
            Branch { bounds, items, halves }
        };
        let mut branches = vec![branch(0..4, Some([1, 2])), branch(0..2, Some([3, 4])), branch(2..4, Some([5, 6]))];
        branches.extend((0..4).map(|item| branch(item..item + 1, None)));
        let (branches, order) = reinsert((branches, vec![0, 1, 2, 3]), 100);
        check(&branches, &order, &boxes);
        for [a, b] in [[0, 2], [1, 3]] {
            let pair = boxes[a].with(boxes[b]);
            assert!(branches.iter().any(|branch| branch.bounds == pair && branch.items.len() == 2), "{a} and {b}: {branches:?}");
        }
    }

    #[test]
    fn it_never_gets_deeper_than_the_stack() {
        let boxes = nested(3000);
        let (mut branches, mut order) = binary(&boxes, SPLITS);
        assert!(check(&branches, &order, &boxes) < 20);
        (branches, order) = reinsert((branches, order), 1_000_000);
        assert_eq!(check(&branches, &order, &boxes), LEVELS, "as a chain it would have 2999");
    }
}
