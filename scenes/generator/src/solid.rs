//! One closed surface of one material: points, triangles, and how they are turned about.
//!
//! Triangles wind counter-clockwise seen from outside. A piece of furniture is a list of such solids that touch; each is closed
//! by itself, so that shadow volumes and inside tests need not know what touches what.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

/// A point or a vector, metres.
pub fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// A closed triangle surface in metres, with one material.
#[derive(Clone, Debug)]
pub struct Solid {
    /// The name that the scene file gives a reflectance to.
    pub material: &'static str,
    /// Vertices, metres.
    pub points: Vec<DVec3>,
    /// Texture coordinates, one per vertex, or none at all.
    pub uv: Vec<DVec2>,
    /// Indices into `points`, counter-clockwise seen from outside.
    pub triangles: Vec<[usize; 3]>,
}

impl Solid {
    /// The same surface in another material.
    pub fn of(mut self, material: &'static str) -> Self {
        self.material = material;
        self
    }

    /// Every vertex through `f`, which must not fold the surface.
    pub fn map(mut self, f: impl Fn(DVec3) -> DVec3) -> Self {
        for p in &mut self.points {
            *p = f(*p);
        }
        self
    }

    /// Moved by `by` metres.
    pub fn at(self, by: DVec3) -> Self {
        self.map(|p| p + by)
    }

    /// Turned about the z axis, degrees, counter-clockwise from above.
    pub fn turn_z(self, degrees: f64) -> Self {
        let (s, c) = degrees.to_radians().sin_cos();
        self.map(|p| v(c * p.x - s * p.y, s * p.x + c * p.y, p.z))
    }

    /// Turned about the y axis, degrees, from z to x.
    pub fn turn_y(self, degrees: f64) -> Self {
        let (s, c) = degrees.to_radians().sin_cos();
        self.map(|p| v(c * p.x + s * p.z, p.y, c * p.z - s * p.x))
    }

    /// Turned about the x axis, degrees, from y to z.
    pub fn turn_x(self, degrees: f64) -> Self {
        let (s, c) = degrees.to_radians().sin_cos();
        self.map(|p| v(p.x, c * p.y - s * p.z, s * p.y + c * p.z))
    }

    /// Texture coordinates from the position of each vertex.
    pub fn textured(mut self, f: impl Fn(DVec3) -> DVec2) -> Self {
        self.uv = self.points.iter().map(|p| f(*p)).collect();
        self
    }

    /// Turned inside out: the inner surface of a room.
    pub fn inside_out(mut self) -> Self {
        for t in &mut self.triangles {
            t.swap(1, 2);
        }
        self
    }

    /// The number of mesh elements: each triangle gives ⌈e / cell⌉² of them, where e is its longest edge (scene-format.md).
    pub fn cells(&self, cell: f64) -> usize {
        self.triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| self.points[i]);
                let edge = a.distance(b).max(b.distance(c)).max(c.distance(a));
                let n = (edge / cell).ceil() as usize;
                n * n
            })
            .sum()
    }

    /// What keeps this from being a closed surface of triangles with an area, if anything does. Looks at the coordinates as they
    /// are written, so points that fall together in the file count as one.
    pub fn defect(&self) -> Option<String> {
        let weld: Vec<[i64; 3]> = self.points.iter().map(|p| p.to_array().map(|x| (x * 1e5).round() as i64)).collect();
        let mut edges: BTreeMap<([i64; 3], [i64; 3]), i32> = BTreeMap::new();
        let mut volume = 0.0;
        for t in &self.triangles {
            let [a, b, c] = t.map(|i| self.points[i]);
            volume += a.dot(b.cross(c)) / 6.0;
            if (b - a).cross(c - a).length() < 1e-8 {
                return Some(format!("triangle without area at {a}"));
            }
            for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                *edges.entry((weld[t[i]], weld[t[j]])).or_default() += 1;
            }
        }
        for ((a, b), n) in &edges {
            if *n != 1 || edges.get(&(*b, *a)) != Some(&1) {
                return Some(format!("edge {a:?} to {b:?} (units of 10 µm) is not shared by exactly two triangles"));
            }
        }
        (volume == 0.0).then(|| "no volume".to_string())
    }

    /// The volume enclosed, cubic metres; negative when the triangles face inwards.
    pub fn volume(&self) -> f64 {
        self.triangles.iter().map(|t| t.map(|i| self.points[i])).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }
}
