//! Watertight ray–triangle intersection, in one function for all rays.
//!
//! Woop, Benthin, Wald 2013, *Watertight Ray/Triangle Intersection*, in f32 without the double-precision fallback: a vertex is
//! sheared to the same numbers in every triangle that shares it, so the signs of the edge functions on a shared edge are exactly
//! opposite, never wrong, at worst zero; accepting zeros closes all edges. No fused multiply-add: Rust never contracts.
//!
//! The nearest hit is by distance, then by a hash of the object's name and the triangle's number, so that a path never depends on the order in which a tree is visited.

use crate::lanes::{Arithmetic, One, dots};
use glam::Vec3;
use lightmend_scene::Cut;

/// A triangle in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Triangle {
    /// World-space corners, metres; counter-clockwise seen from the front.
    pub corners: [Vec3; 3],
    /// Unit normal of the front.
    pub normal: Vec3,
    /// Hash of the object's name: decides between hits at the same distance, whatever the objects' numbers are.
    pub key: u64,
    /// Number of the object.
    pub object: u32,
    /// Number of the triangle in the object's mesh.
    pub in_mesh: u32,
    /// Its mesh elements.
    pub cut: Cut,
    /// Which of the mesh's materials it is of.
    pub material: u16,
}

impl Triangle {
    /// Triangle `in_mesh` of object number `object`, whose name hashes to `key`; all one mesh element, of the mesh's first material.
    pub fn new(corners: [Vec3; 3], key: u64, object: usize, in_mesh: usize) -> Triangle {
        // In f64, so that slivers have a normal.
        let [a, b, c] = corners.map(|v| v.as_dvec3());
        let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
        let cut = Cut { first: in_mesh as u32, divisions: 1 };
        Triangle { corners, normal, key, object: object as u32, in_mesh: in_mesh as u32, cut, material: 0 }
    }

    /// Number of the object.
    pub fn object(&self) -> usize {
        self.object as usize
    }

    /// Number of the triangle in the object's mesh.
    pub fn in_mesh(&self) -> usize {
        self.in_mesh as usize
    }

    /// What is compared between hits at the same distance.
    pub fn order(&self) -> (u64, u32) {
        (self.key, self.in_mesh)
    }

    /// Whether it is the same triangle of the same object, wherever that stands.
    pub fn is(&self, other: &Triangle) -> bool {
        (self.object, self.in_mesh) == (other.object, other.in_mesh)
    }

    /// The point with these barycentric weights, kept inside the triangle's box: on an axis-parallel wall it never leaves it.
    pub fn point(&self, weights: [f32; 3]) -> Vec3 {
        points(One, self.corners.map(|corner| corner.to_array()), weights).into()
    }
}

/// A ray with what the intersection needs of it. The direction need not be of unit length, but at least 1e-6 long.
#[derive(Debug, Clone, Copy)]
pub struct Ray<'a> {
    /// Metres.
    pub origin: Vec3,
    /// Distances are in multiples of its length.
    pub direction: Vec3,
    /// The surface it leaves, which it cannot meet again.
    pub leaves: Option<&'a Triangle>,
    /// Within this distance, coplanar neighbours of the surface it leaves are not met either.
    pub near: f32,
    /// The axes that take the places of x, y and z; the direction is largest along the last.
    pub(crate) axes: [u8; 3],
    /// What is added to x and y per z, and the factor of z: these take the ray to the z axis and its largest component to 1.
    pub(crate) shear: [f32; 3],
}

/// Points of triangles: see [`Triangle::point`].
#[inline(always)]
pub(crate) fn points<A: Arithmetic>(a: A, corners: [[A::Numbers; 3]; 3], weights: [A::Numbers; 3]) -> [A::Numbers; 3] {
    let [p, q, r] = corners;
    let along = [[p[0], q[0], r[0]], [p[1], q[1], r[1]], [p[2], q[2], r[2]]];
    [between(a, along[0], weights), between(a, along[1], weights), between(a, along[2], weights)]
}

#[inline(always)]
fn between<A: Arithmetic>(a: A, [p, q, r]: [A::Numbers; 3], weights: [A::Numbers; 3]) -> A::Numbers {
    let point = dots(a, [p, q, r], weights);
    a.min(a.max(point, a.min(a.min(p, q), r)), a.max(a.max(p, q), r))
}

/// Where rays are aimed, as intersection needs it: along which axis most, and [`Ray::shear`].
pub(crate) struct Aim<A: Arithmetic> {
    /// Not along x.
    pub not_x: A::Mask,
    /// Along z rather than y.
    pub z_above_y: A::Mask,
    /// Against that axis.
    pub down: A::Mask,
    pub shear: [A::Numbers; 3],
}

/// Of directions without -0.
#[inline(always)]
pub(crate) fn aims<A: Arithmetic>(a: A, [x, y, z]: [A::Numbers; 3]) -> Aim<A> {
    let [dx, dy, dz] = [a.abs(x), a.abs(y), a.abs(z)];
    let not_x = a.or(a.at_most(dx, dy), a.at_most(dx, dz));
    let z_above_y = a.at_most(dy, dz);
    let along = a.choose(not_x, a.choose(z_above_y, z, y), x);
    let first = a.choose(not_x, a.choose(z_above_y, x, z), y);
    let second = a.choose(not_x, a.choose(z_above_y, y, x), z);
    let down = a.less(along, a.splat(0.0));
    let [first, second] = [a.choose(down, second, first), a.choose(down, first, second)];
    let shear = [a.div(a.negative(first), along), a.div(a.negative(second), along), a.div(a.splat(1.0), along)];
    Aim { not_x, z_above_y, down, shear }
}

/// [`Ray::axes`] of what [`aims`] says of a ray.
#[inline(always)]
pub(crate) fn axes(not_x: bool, z_above_y: bool, down: bool) -> [u8; 3] {
    const AXES: [[[u8; 3]; 2]; 3] = [[[1, 2, 0], [2, 1, 0]], [[2, 0, 1], [0, 2, 1]], [[0, 1, 2], [1, 0, 2]]];
    AXES[usize::from(not_x) * (1 + usize::from(z_above_y))][usize::from(down)]
}

/// Where a ray meets a triangle.
#[derive(Debug, Clone, Copy)]
pub struct Hit<'a> {
    /// In multiples of the ray's direction.
    pub distance: f32,
    /// Barycentric weights of the corners; their sum is 1 to rounding.
    pub weights: [f32; 3],
    /// What was met.
    pub triangle: &'a Triangle,
}

impl Hit<'_> {
    /// Whether it is nearer than `best`, or as near and of smaller order.
    #[inline(always)]
    pub(crate) fn precedes(&self, best: &Option<Hit>) -> bool {
        best.is_none_or(|best| {
            self.distance < best.distance || (self.distance == best.distance && self.triangle.order() < best.triangle.order())
        })
    }
}

impl<'a> Ray<'a> {
    /// A ray that leaves `leaves`, or starts in free space.
    #[inline(always)]
    pub fn new(origin: Vec3, direction: Vec3, leaves: Option<&'a Triangle>, near: f32) -> Ray<'a> {
        // Adding zero turns -0 into 0: boxes and triangles then agree on the octant.
        let direction = direction + Vec3::ZERO;
        let Aim { not_x, z_above_y, down, shear } = aims(One, direction.to_array());
        Ray { origin, direction, leaves, near, axes: axes(not_x, z_above_y, down), shear }
    }

    /// Meets a triangle if it is nearer than `best`, or as near and smaller order. Trees test eight at once, with the same operations
    /// and to the same bits; this is for one, as when a recorded path is replayed.
    #[inline]
    pub fn meet<'t>(&self, triangle: &'t Triangle, best: &Option<Hit<'t>>) -> Option<Hit<'t>> {
        let [x, y, z] = self.axes.map(usize::from);
        let sheared = |corner: Vec3| {
            let v = (corner - self.origin).to_array();
            Vec3::new(v[x] + self.shear[0] * v[z], v[y] + self.shear[1] * v[z], self.shear[2] * v[z])
        };
        let [a, b, c] = triangle.corners.map(sheared);
        let u = c.x * b.y - c.y * b.x;
        let v = a.x * c.y - a.y * c.x;
        let w = b.x * a.y - b.y * a.x;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        if determinant == 0.0 {
            return None;
        }
        let weights = [u / determinant, v / determinant, w / determinant];
        let distance = weights[0] * a.z + weights[1] * b.z + weights[2] * c.z;
        // Written so that a NaN is no hit.
        if !(0.0..f32::INFINITY).contains(&distance) {
            return None;
        }
        let hit = Hit { distance, weights, triangle };
        self.prefers(&hit, best, self.leaves.is_none_or(|left| !left.is(triangle))).then_some(hit)
    }

    /// Whether a hit is nearer than `best`, or as near and smaller order, and not on the surface that the ray leaves; `another` says that
    /// it is another triangle.
    #[inline(always)]
    pub(crate) fn prefers(&self, hit: &Hit, best: &Option<Hit>, another: bool) -> bool {
        hit.precedes(best)
            && another
            && self.leaves.is_none_or(|left| hit.distance >= self.near || !self.leaves_plane_of(left, hit.triangle))
    }

    /// Whether a triangle met at almost no distance is only a continuation of the surface that the ray leaves.
    #[cold]
    fn leaves_plane_of(&self, left: &Triangle, met: &Triangle) -> bool {
        let (n, m) = (left.normal, met.normal);
        let n = if n.dot(self.direction) < 0.0 { -n } else { n };
        let cosine = n.dot(m);
        cosine.abs() > 0.5 && m.dot(self.direction) * cosine > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;

    fn triangle(a: Vec3, b: Vec3, c: Vec3, id: usize) -> Triangle {
        Triangle::new([a, b, c], 0, 0, id)
    }

    #[test]
    fn shared_edges_and_corners_are_never_missed() {
        // A fan around a point, seen from 1,000 places: rays at the corners and along the edges always meet it.
        let rim: Vec<Vec3> = (0..7)
            .map(|k| {
                let (s, c) = (k as f32 * 0.9).sin_cos();
                vec3(c, s, 0.1 * s)
            })
            .collect();
        let centre = vec3(0.013, -0.027, 0.05);
        let fan: Vec<Triangle> = (0..7).map(|k| triangle(centre, rim[k], rim[(k + 1) % 7], k)).collect();
        for place in 0..1000 {
            let origin = vec3((place % 10) as f32 * 0.31 - 1.4, (place / 10 % 10) as f32 * 0.29 - 1.3, 2.0 + place as f32 * 0.01);
            for k in 0..7 {
                for along in [0.0, 0.001, 0.37, 0.9] {
                    let ray = Ray::new(origin, centre.lerp(rim[k], along) - origin, None, 0.0);
                    assert!(fan.iter().any(|t| ray.meet(t, &None).is_some()), "place {place}, edge {k}, {along}");
                }
            }
        }
    }

    #[test]
    fn ties_go_to_the_smaller_id() {
        let a = triangle(vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), 5);
        let b = Triangle { in_mesh: 3, ..a };
        let ray = Ray::new(vec3(0.2, 0.2, 1.0), vec3(0.0, 0.0, -1.0), None, 0.0);
        let first = ray.meet(&a, &None);
        assert_eq!(ray.meet(&b, &first).unwrap().triangle.in_mesh, 3);
        let first = ray.meet(&b, &None);
        assert!(ray.meet(&a, &first).is_none());
    }

    #[test]
    fn a_ray_that_leaves_a_plane_does_not_meet_its_other_half() {
        let left = triangle(vec3(0.0, 0.0, 6.0), vec3(1.0, 0.0, 6.0), vec3(0.0, 1.0, 6.0), 0);
        let other = triangle(vec3(1.0, 0.0, 6.0), vec3(1.0, 1.0, 6.0), vec3(0.0, 1.0, 6.0), 1);
        let ray = Ray::new(vec3(0.5, 0.5, 6.0), vec3(0.1, 0.1, -1.0), Some(&left), 1e-4);
        assert!(ray.meet(&left, &None).is_none() && ray.meet(&other, &None).is_none());
        let wall = triangle(vec3(0.5, 0.0, 7.0), vec3(0.5, 0.0, 5.0), vec3(0.5, 3.0, 6.0), 2);
        assert!(Ray::new(vec3(0.5, 0.5, 6.0), vec3(0.1, 0.1, -1.0), Some(&left), 1e-4).meet(&wall, &None).is_some());
    }

    #[test]
    fn odd_directions_are_met() {
        let t = triangle(vec3(-1.0, -1.0, 1.0), vec3(1.0, -1.0, 1.0), vec3(0.0, 1.0, 1.0), 0);
        for d in [vec3(-0.0, 0.0, 1.0), vec3(0.0, -0.0, 1.0), vec3(1e-30, 1e-38, 1.0)] {
            assert_eq!(Ray::new(Vec3::ZERO, d, None, 0.0).meet(&t, &None).unwrap().distance, 1.0);
        }
        assert!(Ray::new(Vec3::ZERO, vec3(f32::NAN, 0.0, 1.0), None, 0.0).meet(&t, &None).is_none());
    }
}
