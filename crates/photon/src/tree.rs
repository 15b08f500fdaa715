//! A tree over triangles with eight children to a node and eight triangles to a leaf, and the way of a ray through it.
//!
//! Each box test and each triangle test is of eight at once ([`crate::lanes`]). The triangle test is [`Ray`]'s, operation for operation;
//! the boxes only decide what is tested. They are padded by more than their own test rounds, so that no tree and no order of
//! visits changes what is met.

use crate::{
    collapse::Collapse,
    lanes::{Arithmetic, LANES, Lanes, dots},
    reinsert::reinsert,
    split::{Bounds, Branch, Effort, binary},
    stack::Stack,
    triangle::{Hit, Ray, Triangle},
};
use std::sync::Arc;

/// Eight boxes: low x, y, z, high x, y, z of each.
pub type Planes = [[f32; LANES]; 6];

/// What no ray enters.
pub const NO_BOXES: Planes = {
    let (low, high) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
    [low, low, low, high, high, high]
};

/// Marks a child that is a block.
pub const BLOCK: u32 = 1 << 31;

/// Four lines of cache.
#[repr(align(64))]
pub struct Node {
    /// Their boxes.
    pub planes: Planes,
    /// Numbers of nodes, or of blocks if they are marked so.
    pub children: [u32; LANES],
}

/// Up to eight triangles, five lines of cache.
#[derive(Clone)]
#[repr(align(64))]
pub struct Block {
    /// Per corner and axis; not numbers where there is no triangle.
    corners: [[[f32; LANES]; 3]; 3],
    /// The number of the first triangle.
    first: u32,
    /// How many there are.
    count: u32,
}

/// The tree.
#[derive(Default)]
pub struct Tree {
    /// The first is the root.
    pub nodes: Arc<[Node]>,
    /// The leaves.
    pub blocks: Vec<Block>,
}

/// A ray as the tests of eight want it.
pub struct Beam<'r, L: Lanes> {
    /// Its lanes.
    pub lanes: L,
    /// The ray itself.
    pub ray: &'r Ray<'r>,
    origin: [L::Numbers; 3],
    inverse: [L::Numbers; 3],
    /// Which plane of a box is entered, per axis.
    near: [usize; 3],
    /// The ray's own axes.
    axes: [usize; 3],
    skew: Skew<L>,
}

/// Rays to which triangles are sheared: eight triangles to one, or one to eight.
pub struct Skew<L: Lanes> {
    /// Origins along the rays' own axes.
    pub origin: [L::Numbers; 3],
    /// [`Ray::shear`].
    pub shear: [L::Numbers; 3],
}

/// Stands for 1 / 0.
pub const LARGE: f32 = 1e18;

/// 1 / d, large but finite where d is zero.
#[inline(always)]
pub fn inverse(d: f32) -> f32 {
    d.recip().clamp(-LARGE, LARGE)
}

/// What one ray met of eight triangles, or eight rays of one.
pub struct Met<L: Lanes> {
    /// Which of them.
    pub reached: L::Mask,
    /// In multiples of the rays' directions.
    pub distance: L::Numbers,
    /// Of the corners.
    pub weights: [L::Numbers; 3],
}

impl<'r, L: Lanes> Beam<'r, L> {
    /// Prepares a ray.
    #[inline(always)]
    pub fn new(lanes: L, ray: &'r Ray<'r>) -> Beam<'r, L> {
        let inverse = ray.direction.to_array().map(inverse);
        let [x, y, z] = ray.axes.map(usize::from);
        // Known from here on, and not looked at again for every block.
        assert!(x < 3 && y < 3 && z < 3);
        let origin = ray.origin.to_array();
        let near = |inverse: f32, axis: usize| if inverse < 0.0 { axis + 3 } else { axis };
        Beam {
            lanes,
            ray,
            origin: [lanes.splat(ray.origin.x), lanes.splat(ray.origin.y), lanes.splat(ray.origin.z)],
            inverse: [lanes.splat(inverse[0]), lanes.splat(inverse[1]), lanes.splat(inverse[2])],
            near: [near(inverse[0], 0), near(inverse[1], 1), near(inverse[2], 2)],
            axes: [x, y, z],
            skew: Skew {
                origin: [lanes.splat(origin[x]), lanes.splat(origin[y]), lanes.splat(origin[z])],
                shear: [lanes.splat(ray.shear[0]), lanes.splat(ray.shear[1]), lanes.splat(ray.shear[2])],
            },
        }
    }

    /// Where the ray crosses eight planes.
    #[inline(always)]
    fn at(&self, planes: &Planes, plane: usize, axis: usize) -> L::Numbers {
        let l = self.lanes;
        l.mul(l.sub(l.load(&planes[plane]), self.origin[axis]), self.inverse[axis])
    }

    /// Meets eight triangles: [`Ray::meet`] up to the distance, which `limit` bounds.
    #[inline(always)]
    fn meets(&self, block: &Block, limit: f32) -> Option<Met<L>> {
        self.skew.meets(self.lanes, block.load(self.lanes, self.axes), self.lanes.splat(limit))
    }
}

impl<L: Lanes> Skew<L> {
    /// A corner in the rays' own coordinates.
    #[inline(always)]
    fn sheared(&self, l: L, [x, y, z]: [L::Numbers; 3]) -> [L::Numbers; 3] {
        let depth = l.sub(z, self.origin[2]);
        [
            l.add(l.sub(x, self.origin[0]), l.mul(self.shear[0], depth)),
            l.add(l.sub(y, self.origin[1]), l.mul(self.shear[1], depth)),
            l.mul(self.shear[2], depth),
        ]
    }

    /// [`Ray::meet`] up to the distance, which `limit` bounds, of triangles by their corners along the rays' own axes.
    #[inline(always)]
    pub fn meets(&self, l: L, corners: [[L::Numbers; 3]; 3], limit: L::Numbers) -> Option<Met<L>> {
        let zero = l.splat(0.0);
        let (a, b, c) = (self.sheared(l, corners[0]), self.sheared(l, corners[1]), self.sheared(l, corners[2]));
        let (u, v, w) = (cross(l, c, b), cross(l, a, c), cross(l, b, a));
        let negative = l.or(l.or(l.less(u, zero), l.less(v, zero)), l.less(w, zero));
        let positive = l.or(l.or(l.less(zero, u), l.less(zero, v)), l.less(zero, w));
        let determinant = l.add(l.add(u, v), w);
        // Of one sign: where both occur it is missed, where neither does it is seen from the edge.
        let inside = l.or(l.but_not(positive, negative), l.but_not(negative, positive));
        if l.bits(inside) == 0 {
            return None;
        }
        let (u, v, w) = (l.div(u, determinant), l.div(v, determinant), l.div(w, determinant));
        let distance = dots(l, [u, v, w], [a[2], b[2], c[2]]);
        let reached = l.and(inside, l.and(l.at_most(zero, distance), l.at_most(distance, limit)));
        (l.bits(reached) != 0).then_some(Met { reached, distance, weights: [u, v, w] })
    }
}

#[inline(always)]
fn cross<L: Lanes>(l: L, p: [L::Numbers; 3], q: [L::Numbers; 3]) -> L::Numbers {
    l.sub(l.mul(p[0], q[1]), l.mul(p[1], q[0]))
}

impl Tree {
    /// Over triangles whose boxes are padded by `padding` (metres); puts the triangles in the order of the leaves.
    pub fn new(triangles: &mut Vec<Triangle>, padding: f32, effort: Effort) -> Tree {
        if triangles.is_empty() {
            return Tree::default();
        }
        let bounds = |t: &Triangle| {
            let [a, b, c] = t.corners;
            Bounds { low: (a.min(b).min(c) - padding).into(), high: (a.max(b).max(c) + padding).into() }
        };
        let (mut branches, mut order) = binary(&triangles.iter().map(bounds).collect::<Vec<_>>(), effort);
        if effort.moved > 0 {
            (branches, order) = reinsert((branches, order), effort.moved);
        }
        *triangles = order.iter().map(|i| triangles[*i as usize]).collect();
        let collapse = Collapse::new(&branches);
        let mut growing = Growing::default();
        growing.node(&collapse, &branches, 0, triangles);
        Tree { nodes: growing.nodes.into(), blocks: growing.blocks }
    }

    /// The tree in which triangles are gone: nodes are shared, boxes stay as large as they were.
    pub fn without(&self, gone: impl Fn(usize) -> bool) -> Tree {
        let mut blocks = self.blocks.clone();
        for block in &mut blocks {
            for k in (0..LANES).filter(|k| gone(block.first as usize + k)) {
                block.corners.iter_mut().flatten().for_each(|numbers| numbers[k] = f32::NAN);
            }
        }
        Tree { nodes: self.nodes.clone(), blocks }
    }
}

/// A tree that is being built.
#[derive(Default)]
struct Growing {
    nodes: Vec<Node>,
    blocks: Vec<Block>,
}

impl Growing {
    fn node(&mut self, collapse: &Collapse, branches: &[Branch], branch: usize, triangles: &[Triangle]) -> u32 {
        let own = self.nodes.len();
        self.nodes.push(Node { planes: NO_BOXES, children: [BLOCK; LANES] });
        let mut children = collapse.children(branch);
        // The heaviest lies next in memory.
        children.sort_by(|a, b| branches[*b].bounds.weight().total_cmp(&branches[*a].bounds.weight()));
        for (k, child) in children.into_iter().enumerate() {
            let number = if collapse.is_block(child) {
                let items = branches[child].items.clone();
                self.blocks.push(Block::new(items.start, &triangles[items.start as usize..items.end as usize]));
                BLOCK | (self.blocks.len() - 1) as u32
            } else {
                self.node(collapse, branches, child, triangles)
            };
            let Bounds { low, high } = branches[child].bounds;
            let node = &mut self.nodes[own];
            node.children[k] = number;
            for axis in 0..3 {
                node.planes[axis][k] = low[axis];
                node.planes[axis + 3][k] = high[axis];
            }
        }
        own as u32
    }
}

impl Tree {
    /// Calls `visit` with every block that may be met within the limit, near ones first as a rule; `visit` returns the new limit.
    #[inline(always)]
    pub fn walk<W: Way>(&self, way: &W, mut limit: f32, stack: &mut Stack, mut visit: impl Visit<W>) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack = stack.begin();
        let mut at = 0u32;
        loop {
            if at & BLOCK != 0 {
                limit = visit.block(way, &self.blocks[(at ^ BLOCK) as usize], limit);
            } else {
                let node = &self.nodes[at as usize];
                let (mut mask, enter) = way.enters(&node.planes, limit);
                if mask != 0 {
                    let enter = way.lanes().store(enter);
                    let mut take = || {
                        let k = mask.trailing_zeros() as usize;
                        mask &= mask - 1;
                        ((enter[k & 7], node.children[k & 7]), mask == 0)
                    };
                    let (mut nearest, mut last) = take();
                    let bottom = stack.len();
                    while !last {
                        let mut entry;
                        (entry, last) = take();
                        if entry.0 < nearest.0 {
                            std::mem::swap(&mut entry, &mut nearest);
                        }
                        stack.insert(bottom, entry);
                        if entry.1 & BLOCK != 0 {
                            way.lanes().fetch(&self.blocks[(entry.1 ^ BLOCK) as usize]);
                        } else {
                            way.lanes().fetch(&self.nodes[entry.1 as usize]);
                        }
                    }
                    at = nearest.1;
                    continue;
                }
            }
            let Some(next) = stack.pop(limit) else { return };
            at = next;
        }
    }

    /// Makes `best` the nearest of itself and what the ray meets here.
    #[inline(always)]
    pub fn nearest<'t, L: Lanes>(
        &self,
        triangles: &'t [Triangle],
        beam: &Beam<L>,
        stack: &mut Stack,
        best: &mut Option<Hit<'t>>,
    ) {
        self.walk(beam, limit(best), stack, First { left: Left::new(beam.ray, triangles), triangles, best });
    }

    /// All that the ray meets within `farthest`.
    #[inline(always)]
    pub fn all<'t, L: Lanes>(
        &self,
        triangles: &'t [Triangle],
        beam: &Beam<L>,
        farthest: f32,
        stack: &mut Stack,
        found: &mut Vec<Hit<'t>>,
    ) {
        self.walk(beam, farthest * SLACK, stack, Every { triangles, farthest, found });
    }
}

/// What finds its way through a tree: a ray, or several.
pub trait Way {
    /// Its lanes.
    type Lanes: Lanes;
    /// Its lanes.
    fn lanes(&self) -> Self::Lanes;
    /// Where it crosses the first planes of eight boxes along an axis, at the soonest.
    fn soonest(&self, planes: &Planes, axis: usize) -> <Self::Lanes as Arithmetic>::Numbers;
    /// Where it crosses the last planes, at the latest.
    fn latest(&self, planes: &Planes, axis: usize) -> <Self::Lanes as Arithmetic>::Numbers;

    /// Which of eight boxes it enters within `limit`, and where.
    #[inline(always)]
    fn enters(&self, planes: &Planes, limit: f32) -> (u32, <Self::Lanes as Arithmetic>::Numbers) {
        let l = self.lanes();
        let enter = l.max(l.max(self.soonest(planes, 0), self.soonest(planes, 1)), l.max(self.soonest(planes, 2), l.splat(0.0)));
        let leave = l.min(l.min(self.latest(planes, 0), self.latest(planes, 1)), l.min(self.latest(planes, 2), l.splat(limit)));
        (l.bits(l.at_most(enter, leave)), enter)
    }
}

impl<L: Lanes> Way for Beam<'_, L> {
    type Lanes = L;

    #[inline(always)]
    fn lanes(&self) -> L {
        self.lanes
    }

    #[inline(always)]
    fn soonest(&self, planes: &Planes, axis: usize) -> L::Numbers {
        self.at(planes, self.near[axis], axis)
    }

    #[inline(always)]
    fn latest(&self, planes: &Planes, axis: usize) -> L::Numbers {
        self.at(planes, 3 + 2 * axis - self.near[axis], axis)
    }
}

/// What is done with the blocks on a way.
pub trait Visit<W> {
    /// Returns the new limit.
    fn block(&mut self, way: &W, block: &Block, limit: f32) -> f32;
}

struct First<'t, 'b> {
    left: Left<'b>,
    triangles: &'t [Triangle],
    best: &'b mut Option<Hit<'t>>,
}

impl<L: Lanes> Visit<Beam<'_, L>> for First<'_, '_> {
    #[inline(always)]
    fn block(&mut self, beam: &Beam<L>, block: &Block, limit: f32) -> f32 {
        let Some(met) = beam.meets(block, self.best.map_or(f32::MAX, |b| b.distance)) else { return limit };
        for hit in met.hits(beam.lanes, block, self.triangles) {
            if beam.ray.prefers(&hit, self.best, self.left.differs_from(hit.triangle)) {
                *self.best = Some(hit);
            }
        }
        self::limit(self.best)
    }
}

/// The triangle that a ray leaves, if any, as seen from some triangles: among those it is told apart by its place alone, without
/// fetching any.
#[derive(Clone, Copy)]
pub struct Left<'r> {
    leaves: Option<&'r Triangle>,
    among: bool,
}

impl<'r> Left<'r> {
    /// Of a ray, among `triangles`.
    #[inline(always)]
    pub fn new(ray: &Ray<'r>, triangles: &[Triangle]) -> Left<'r> {
        let among = |left: &Triangle| triangles.as_ptr_range().contains(&std::ptr::from_ref(left));
        Left { leaves: ray.leaves, among: ray.leaves.is_some_and(among) }
    }

    /// Whether it is another triangle.
    #[inline(always)]
    pub fn differs_from(self, met: &Triangle) -> bool {
        self.leaves.is_none_or(|left| !std::ptr::eq(left, met) && (self.among || !left.is(met)))
    }
}

struct Every<'t, 'b> {
    triangles: &'t [Triangle],
    farthest: f32,
    found: &'b mut Vec<Hit<'t>>,
}

impl<L: Lanes> Visit<Beam<'_, L>> for Every<'_, '_> {
    #[inline(always)]
    fn block(&mut self, beam: &Beam<L>, block: &Block, limit: f32) -> f32 {
        let Some(met) = beam.meets(block, self.farthest) else { return limit };
        self.found.extend(
            met.hits(beam.lanes, block, self.triangles)
                .filter(|hit| beam.ray.prefers(hit, &None, beam.ray.leaves.is_none_or(|left| !left.is(hit.triangle)))),
        );
        limit
    }
}

/// Factor of a hit's distance up to which trees are searched on: more than distances round.
pub const SLACK: f32 = 1.000_001;

/// How far to search on.
#[inline]
pub fn limit(best: &Option<Hit>) -> f32 {
    best.map_or(f32::INFINITY, |b| b.distance * SLACK)
}

impl Block {
    fn new(first: u32, triangles: &[Triangle]) -> Block {
        let mut corners = [[[f32::NAN; LANES]; 3]; 3];
        for (k, triangle) in triangles.iter().enumerate() {
            for corner in 0..3 {
                for axis in 0..3 {
                    corners[corner][axis][k] = triangle.corners[corner][axis];
                }
            }
        }
        Block { corners, first, count: triangles.len() as u32 }
    }

    /// The corners of its triangles along some axes.
    #[inline(always)]
    pub fn load<L: Lanes>(&self, l: L, [x, y, z]: [usize; 3]) -> [[L::Numbers; 3]; 3] {
        let [a, b, c] = &self.corners;
        [
            [l.load(&a[x]), l.load(&a[y]), l.load(&a[z])],
            [l.load(&b[x]), l.load(&b[y]), l.load(&b[z])],
            [l.load(&c[x]), l.load(&c[y]), l.load(&c[z])],
        ]
    }

    /// The corners of its triangle number `k` along some axes.
    #[inline(always)]
    pub fn splat<L: Lanes>(&self, l: L, k: usize, [x, y, z]: [usize; 3]) -> [[L::Numbers; 3]; 3] {
        let [a, b, c] = &self.corners;
        [
            [l.splat(a[x][k]), l.splat(a[y][k]), l.splat(a[z][k])],
            [l.splat(b[x][k]), l.splat(b[y][k]), l.splat(b[z][k])],
            [l.splat(c[x][k]), l.splat(c[y][k]), l.splat(c[z][k])],
        ]
    }

    /// The numbers of its triangles.
    pub fn numbers(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

impl<L: Lanes> Met<L> {
    /// One by one.
    #[inline(always)]
    pub fn hits<'t>(&self, l: L, block: &Block, triangles: &'t [Triangle]) -> impl Iterator<Item = Hit<'t>> {
        let (mut mask, distances, weights) = (l.bits(self.reached), l.store(self.distance), l.store_vectors(self.weights));
        let first = block.first as usize;
        std::iter::from_fn(move || {
            if mask == 0 {
                return None;
            }
            let k = mask.trailing_zeros() as usize & 7;
            mask &= mask - 1;
            let triangle = &triangles[first + k];
            Some(Hit { distance: distances[k], weights: weights.map(|w| w[k]), triangle })
        })
    }
}

#[cfg(test)]
mod tests;
