//! Triangles in the world with a tree over them.

use crate::{
    lanes::Lanes,
    split::Effort,
    tree::{Beam, Tree},
    triangle::{Hit, Triangle},
};
use glam::Vec3;

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
            TreePreset::Fast => Effort { bins: 8, exact: 0, whole: 8 },
            TreePreset::Medium => Effort { bins: 16, exact: 24, whole: 1 },
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
    triangles: Vec<Triangle>,
    tree: Tree,
    bounds: [Vec3; 2],
}

impl Body {
    /// Builds the tree. Empty bodies are allowed and are never met.
    pub fn new(mut triangles: Vec<Triangle>, reach: Reach, preset: TreePreset) -> Body {
        let corners = || triangles.iter().flat_map(|t| t.corners);
        let low = corners().fold(Vec3::INFINITY, Vec3::min);
        let high = corners().fold(Vec3::NEG_INFINITY, Vec3::max);
        let padding = reach.padding(low.abs().max(high.abs()).max_element());
        let tree = Tree::new(&mut triangles, padding, preset.effort());
        Body { triangles, tree, bounds: [low - padding, high + padding] }
    }

    /// In the order of the tree's leaves.
    pub(crate) fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// Makes `best` the nearest of itself and what the ray meets here.
    #[inline(always)]
    pub(crate) fn nearest<'t, L: Lanes>(&'t self, beam: &Beam<L>, best: &mut Option<Hit<'t>>) {
        self.tree.nearest(&self.triangles, beam, best);
    }

    /// The box about it, padded; its low corner is above its high one if it is empty.
    pub fn bounds(&self) -> [Vec3; 2] {
        self.bounds
    }

    /// All triangles that the ray meets within `farthest`, in any order.
    pub(crate) fn meet_all<'t, L: Lanes>(&'t self, beam: &Beam<L>, farthest: f32, found: &mut Vec<Hit<'t>>) {
        self.tree.all(&self.triangles, beam, farthest, found);
    }
}
