//! Triangles in the world with a tree over them.

use crate::{
    lanes::Lanes,
    packet::{Found, Packet},
    split::Effort,
    stack::Stack,
    stream::{Numbered, Stream},
    tree::{Beam, Tree},
    triangle::{Hit, Triangle},
};
use glam::Vec3;
use std::sync::Arc;

/// How much time a tree's build may take, for faster rays. The result of tracing is the same to the bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TreePreset {
    /// For trees that are rebuilt at every move.
    Fast,
    /// For what stands still: measured no slower to trace than the presets above it.
    #[default]
    Medium,
}

impl TreePreset {
    fn effort(self) -> Effort {
        match self {
            TreePreset::Fast => Effort { bins: 8, exact: 0, whole: 8, moved: 0 },
            TreePreset::Medium => Effort { bins: 16, exact: 24, whole: 1, moved: 2048 },
        }
    }
}

/// How far the scene reaches; fixed when it is loaded, so that moving things never changes how rays are computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// Bound of the fixed objects' coordinates, metres.
    pub metres: f32,
}

impl Reach {
    /// For a scene whose fixed coordinates stay within `metres` of the origin.
    pub fn new(metres: f32) -> Reach {
        Reach { metres: metres.max(1e-6) }
    }

    /// How far boxes are padded: above the rounding of the box test, metres.
    fn padding(&self, largest: f32) -> f32 {
        4e-6 * self.metres.max(largest)
    }

    /// How far a path steps back from the surface that it meets, metres.
    pub fn step_back(&self) -> f32 {
        1e-5 * self.metres
    }
}

/// Triangles and their tree.
pub struct Body {
    /// In the order of the tree's leaves.
    triangles: Arc<[Triangle]>,
    tree: Tree,
    bounds: [Vec3; 2],
}

impl Body {
    /// Builds the tree. Empty bodies are allowed and are never met.
    pub fn new(mut triangles: Vec<Triangle>, reach: Reach, preset: TreePreset) -> Body {
        let (bounds, padding) = padded(triangles.iter(), reach);
        let tree = Tree::new(&mut triangles, padding, preset.effort());
        Body { triangles: triangles.into(), tree, bounds }
    }

    /// The body in which only triangles of some objects are left, in a fortieth to a sixtieth of the time of a build.
    pub fn reduced(&self, stays: impl Fn(usize) -> bool, reach: Reach) -> Body {
        let gone = |t: usize| self.triangles.get(t).is_some_and(|triangle| !stays(triangle.object()));
        let (bounds, _) = padded(self.triangles.iter().filter(|triangle| stays(triangle.object())), reach);
        Body { triangles: self.triangles.clone(), tree: self.tree.without(gone), bounds }
    }

    /// In the order of the tree's leaves.
    pub(crate) fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// Makes `best` the nearest of itself and what the ray meets here.
    #[inline(always)]
    pub(crate) fn nearest<'t, L: Lanes>(&'t self, beam: &Beam<L>, stack: &mut Stack, best: &mut Option<Hit<'t>>) {
        self.tree.nearest(&self.triangles, beam, stack, best);
    }

    /// Makes what is found the nearest of itself and what the rays meet here.
    #[inline(always)]
    pub(crate) fn nearest_each<'t, L: Lanes>(&'t self, packet: &Packet<L>, stack: &mut Stack, found: &mut Found<'t, L>) {
        self.tree.nearest_each(&self.triangles, packet, stack, found);
    }

    /// Makes each of `met` the nearest of itself and what its ray meets here.
    #[inline(always)]
    pub(crate) fn nearest_of_all<'t, 'r, L: Lanes>(
        &'t self,
        l: L,
        rays: &impl Numbered<'r>,
        stream: &mut Stream,
        met: &mut [Option<Hit<'t>>],
    ) {
        self.tree.nearest_of_all(l, &self.triangles, rays, stream, met);
    }

    /// The box about it, padded; its low corner is above its high one if it is empty.
    pub fn bounds(&self) -> [Vec3; 2] {
        self.bounds
    }

    /// All triangles that the ray meets within `farthest`, in any order.
    #[inline(always)]
    pub(crate) fn meet_all<'t, L: Lanes>(&'t self, beam: &Beam<L>, farthest: f32, stack: &mut Stack, found: &mut Vec<Hit<'t>>) {
        self.tree.all(&self.triangles, beam, farthest, stack, found);
    }
}

/// The box about some triangles, padded, and by how much.
fn padded<'t>(triangles: impl Iterator<Item = &'t Triangle>, reach: Reach) -> ([Vec3; 2], f32) {
    let none = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    let [low, high] = triangles.flat_map(|t| t.corners).fold(none, |[low, high], p| [low.min(p), high.max(p)]);
    let padding = reach.padding(low.abs().max(high.abs()).max_element());
    ([low - padding, high + padding], padding)
}
