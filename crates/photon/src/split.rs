//! A binary tree over boxes by the surface area heuristic, binned (Wald 2007, *On fast Construction of SAH-based Bounding Volume
//! Hierarchies*).

use glam::Vec3A;
use std::ops::Range;

/// A box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Lowest coordinates, metres.
    pub low: Vec3A,
    /// Highest ones.
    pub high: Vec3A,
}

impl Bounds {
    /// Of nothing.
    pub const EMPTY: Bounds = Bounds { low: Vec3A::INFINITY, high: Vec3A::NEG_INFINITY };

    /// About both.
    pub fn with(self, other: Bounds) -> Bounds {
        Bounds { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// In proportion to the rays that visit it, square metres: half of its surface, but the largest face half as much, since rays end on what
    /// is flat. No box within has more.
    pub fn weight(&self) -> f32 {
        let d = (self.high - self.low).max(Vec3A::ZERO);
        let faces = d * Vec3A::new(d.y, d.z, d.x);
        faces.element_sum() - 0.5 * faces.max_element()
    }

    fn middle(&self) -> Vec3A {
        (self.low + self.high) * 0.5
    }
}

/// Part of the tree. Parents come before their children.
#[derive(Debug, Clone)]
pub struct Branch {
    /// About all in it.
    pub bounds: Bounds,
    /// What is in it: a part of the order.
    pub items: Range<u32>,
    /// Its two halves; none if it has one item.
    pub halves: Option<[u32; 2]>,
}

/// How hard to look for the best split.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Places at which a split is tried, per axis. More: better trees, longer builds.
    pub bins: usize,
    /// Up to so many items every split is tried. More: better trees, longer builds.
    pub exact: usize,
    /// Up to so many items are not split. Above 1: quicker builds, less choice for the collapse.
    pub whole: usize,
    /// Of so many branches, the heaviest, better places are looked for ([`crate::reinsert`]). More: better trees, longer builds.
    pub moved: usize,
}

/// From this depth on, splits are in the middle: a bound of the depth, whatever the boxes are.
const DEEP: u32 = 32;
const MOST_BINS: usize = 16;

struct Builder<'a> {
    boxes: &'a [Bounds],
    middles: Vec<Vec3A>,
    order: Vec<u32>,
    branches: Vec<Branch>,
    effort: Effort,
}

/// The tree over some boxes and the order of boxes in which branches are ranges.
pub fn binary(boxes: &[Bounds], effort: Effort) -> (Vec<Branch>, Vec<u32>) {
    let middles = boxes.iter().map(Bounds::middle).collect();
    let order = (0..boxes.len() as u32).collect();
    let mut builder = Builder { boxes, middles, order, branches: Vec::with_capacity(2 * boxes.len()), effort };
    builder.branch(0..boxes.len(), 0);
    (builder.branches, builder.order)
}

impl Builder<'_> {
    fn branch(&mut self, items: Range<usize>, depth: u32) -> u32 {
        let bounds = self.order[items.clone()].iter().fold(Bounds::EMPTY, |all, i| all.with(self.boxes[*i as usize]));
        let own = self.branches.len();
        self.branches.push(Branch { bounds, items: items.start as u32..items.end as u32, halves: None });
        if items.len() > self.effort.whole {
            let cut = self.cut(items.clone(), depth);
            let halves = [self.branch(items.start..cut, depth + 1), self.branch(cut..items.end, depth + 1)];
            self.branches[own].halves = Some(halves);
        }
        own as u32
    }

    /// Reorders the items; where the second half begins.
    fn cut(&mut self, items: Range<usize>, depth: u32) -> usize {
        let half = items.start + items.len() / 2;
        let (mut low, mut high) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
        for i in &self.order[items.clone()] {
            let middle = self.middles[*i as usize];
            (low, high) = (low.min(middle), high.max(middle));
        }
        if low == high {
            return half;
        }
        if items.len() <= self.effort.exact {
            return self.cut_exactly(items);
        }
        if depth >= DEEP {
            let extent = high - low;
            let axis = (0..3).fold(0, |best, axis| if extent[axis] > extent[best] { axis } else { best });
            self.sort(items, axis);
            return half;
        }
        self.cut_at_bins(items.clone(), low, high).unwrap_or(half)
    }

    fn sort(&mut self, items: Range<usize>, axis: usize) {
        let middles = &self.middles;
        self.order[items]
            .sort_unstable_by(|a, b| middles[*a as usize][axis].total_cmp(&middles[*b as usize][axis]).then(a.cmp(b)));
    }

    fn cut_exactly(&mut self, items: Range<usize>) -> usize {
        let count = items.len();
        let mut best = (f32::INFINITY, 0, count / 2);
        let mut behind = vec![0.0; count];
        for axis in 0..3 {
            self.sort(items.clone(), axis);
            let order = &self.order[items.clone()];
            let mut bounds = Bounds::EMPTY;
            for k in (1..count).rev() {
                bounds = bounds.with(self.boxes[order[k] as usize]);
                behind[k] = bounds.weight() * (count - k) as f32;
            }
            bounds = Bounds::EMPTY;
            for k in 1..count {
                bounds = bounds.with(self.boxes[order[k - 1] as usize]);
                let cost = bounds.weight() * k as f32 + behind[k];
                if cost < best.0 {
                    best = (cost, axis, k);
                }
            }
        }
        if best.1 != 2 {
            self.sort(items.clone(), best.1);
        }
        items.start + best.2
    }

    fn cut_at_bins(&mut self, items: Range<usize>, low: Vec3A, high: Vec3A) -> Option<usize> {
        let bins = self.effort.bins;
        // Clamped where an axis has no extent.
        let scale = (bins as f32 * (1.0 - 1e-6) / (high - low)).min(Vec3A::splat(1e30));
        let bin = |middle: Vec3A| ((middle - low) * scale).as_uvec3().to_array().map(|n| (n as usize).min(bins - 1));
        let mut filled = [[(Bounds::EMPTY, 0u32); MOST_BINS]; 3];
        for i in &self.order[items.clone()] {
            let at = bin(self.middles[*i as usize]);
            for axis in 0..3 {
                let (bounds, count) = &mut filled[axis][at[axis]];
                *bounds = bounds.with(self.boxes[*i as usize]);
                *count += 1;
            }
        }
        let mut best = (f32::INFINITY, 0, 0);
        for axis in 0..3 {
            let mut behind = [(0.0, 0u32); MOST_BINS];
            let (mut bounds, mut count) = (Bounds::EMPTY, 0);
            for k in (1..bins).rev() {
                bounds = bounds.with(filled[axis][k].0);
                count += filled[axis][k].1;
                behind[k] = (bounds.weight() * count as f32, count);
            }
            (bounds, count) = (Bounds::EMPTY, 0);
            for k in 1..bins {
                bounds = bounds.with(filled[axis][k - 1].0);
                count += filled[axis][k - 1].1;
                let cost = bounds.weight() * count as f32 + behind[k].0;
                if count > 0 && behind[k].1 > 0 && cost < best.0 {
                    best = (cost, axis, k);
                }
            }
        }
        let (cost, axis, at) = best;
        if cost == f32::INFINITY {
            return None;
        }
        let part = &mut self.order[items.clone()];
        let (mut left, mut right) = (0, part.len());
        while left < right {
            if bin(self.middles[part[left] as usize])[axis] < at {
                left += 1;
            } else {
                right -= 1;
                part.swap(left, right);
            }
        }
        Some(items.start + left)
    }
}
