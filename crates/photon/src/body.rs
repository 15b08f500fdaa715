//! Triangles in the world with a tree over them.
//!
//! The tree is obvhs's compressed wide BVH (Ylitie, Karras, Laine 2017). Two of its traits need care (measured in our study):
//! its near limit of 1e-4 is absolute, so trees live in coordinates scaled by a power of two in which the scene is about 1,000
//! units large; and exactly flat boxes make it four times slower and let rays slip through, so every box is padded.

use crate::triangle::{Hit, Ray, Triangle};
use glam::{Vec3, Vec3A};
use obvhs::{
    Boundable, BvhBuildParams,
    aabb::Aabb,
    cwbvh::{CwBvh, builder::build_cwbvh},
    ray::RayHit,
};
use std::time::Duration;

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
    fn parameters(self) -> BvhBuildParams {
        match self {
            TreePreset::Fast => BvhBuildParams::fast_build(),
            TreePreset::Medium => BvhBuildParams::medium_build(),
        }
    }
}

/// How far the scene reaches; fixed when it is loaded, so that moving things never changes how rays are computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// Bound of the fixed objects' coordinates, metres.
    pub metres: f32,
    /// Metres to tree units, a power of two.
    scale: f32,
}

impl Reach {
    /// For a scene whose fixed coordinates stay within `metres` of the origin.
    pub fn new(metres: f32) -> Reach {
        let metres = metres.max(1e-6);
        Reach { metres, scale: (1000.0 / metres).log2().floor().exp2() }
    }

    /// How far boxes are padded: above the rounding of the box test and the tree's near limit, metres.
    fn padding(&self, largest: f32) -> f32 {
        4e-6 * self.metres.max(largest)
    }

    /// How far a path steps back from the surface that it meets, metres.
    pub fn step_back(&self) -> f32 {
        1e-5 * self.metres
    }
}

struct Box3(Aabb);

impl Boundable for Box3 {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

/// Triangles and their tree.
pub struct Body {
    /// In the order of the tree's leaves.
    triangles: Vec<Triangle>,
    tree: CwBvh,
    bounds: [Vec3; 2],
    scale: f32,
}

impl Body {
    /// Builds the tree. Empty bodies are allowed and are never met.
    pub fn new(triangles: Vec<Triangle>, reach: Reach, preset: TreePreset) -> Body {
        let corners = || triangles.iter().flat_map(|t| t.corners);
        let low = corners().fold(Vec3::INFINITY, Vec3::min);
        let high = corners().fold(Vec3::NEG_INFINITY, Vec3::max);
        let padding = Vec3::splat(reach.padding(low.abs().max(high.abs()).max_element()));
        let boxes: Vec<Box3> = triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.corners;
                let low = (a.min(b).min(c) - padding) * reach.scale;
                let high = (a.max(b).max(c) + padding) * reach.scale;
                Box3(Aabb::new(low.into(), high.into()))
            })
            .collect();
        let tree = if triangles.is_empty() {
            CwBvh::default()
        } else {
            build_cwbvh(&boxes, preset.parameters(), &mut Duration::default())
        };
        let triangles = tree.primitive_indices.iter().map(|i| triangles[*i as usize]).collect();
        Body { triangles, tree, bounds: [low - padding, high + padding], scale: reach.scale }
    }

    /// The nearest of `best` and what the ray meets here.
    #[inline]
    pub fn nearest<'t>(&'t self, ray: &Ray, best: Option<Hit<'t>>) -> Option<Hit<'t>> {
        if self.triangles.is_empty() {
            return best;
        }
        self.traverse(ray, best)
    }

    /// The box about it, padded; its low corner is above its high one if it is empty.
    pub fn bounds(&self) -> [Vec3; 2] {
        self.bounds
    }

    fn traverse<'t>(&'t self, ray: &Ray, mut best: Option<Hit<'t>>) -> Option<Hit<'t>> {
        let tree_ray = self.tree_ray(ray, best.map_or(f32::INFINITY, |b| b.distance));
        self.tree.ray_traverse(tree_ray, &mut RayHit::none(), |_, leaf| match ray.meet(&self.triangles[leaf], &best) {
            Some(hit) => {
                best = Some(hit);
                hit.distance * self.scale * SLACK
            }
            None => f32::INFINITY,
        });
        best
    }

    /// All triangles that the ray meets within `farthest`, in any order.
    pub fn meet_all<'t>(&'t self, ray: &Ray, farthest: f32, found: &mut Vec<Hit<'t>>) {
        if self.triangles.is_empty() {
            return;
        }
        self.tree.ray_traverse(self.tree_ray(ray, farthest), &mut RayHit::none(), |_, leaf| {
            found.extend(ray.meet(&self.triangles[leaf], &None).filter(|hit| hit.distance <= farthest));
            f32::INFINITY
        });
    }

    /// The ray in the tree's coordinates.
    fn tree_ray(&self, ray: &Ray, farthest: f32) -> obvhs::ray::Ray {
        obvhs::ray::Ray {
            origin: Vec3A::from(ray.origin * self.scale),
            direction: Vec3A::from(ray.direction),
            inv_direction: Vec3A::from(inverse(ray.direction)),
            tmin: 0.0,
            tmax: farthest * self.scale * SLACK,
        }
    }
}

/// Factor of a hit's distance up to which trees are searched on. The tree takes only what is strictly nearer; equally near triangles must still be visited, to choose by id.
pub const SLACK: f32 = 1.000_001;

/// 1 / d, large but finite where d is zero.
#[inline]
pub fn inverse(direction: Vec3) -> Vec3 {
    direction.recip().clamp(Vec3::splat(-1e18), Vec3::splat(1e18))
}
