//! Lattice points: the corners of mesh elements, between which light is interpolated, but never across a crease.
//!
//! A triangle cut into n² cells has (n+1)(n+2)/2 of them: point (i, j) has the barycentric weights b₁ = i/n of the second corner and
//! b₂ = j/n of the third. Every triangle has points of its own, so that a shader finds them by arithmetic. Points of several triangles
//! at the same place, to the bit, form a *group* where the surface is smooth, and a group has one irradiance.
//!
//! Smooth are triangles whose normals are less than [`LatticePoints::CREASE`] apart, or joined by a chain of such triangles that meet
//! at the place. The normals count with their sign: back to back is a crease.
//!
//! Where two smooth triangles cut their common edge into different numbers of parts, the points that do not coincide stay in groups of
//! their own triangle; which of them are nearest to each other is known as a *seam*. Not mended: a corner of one triangle within an edge of another.

use crate::{Lattice, Mesh};
use glam::DVec3;
use std::ops::Range;

/// The lattice points of one mesh, and which of them share their light.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LatticePoints {
    /// First point of each triangle; one more entry than triangles.
    first: Vec<u32>,
    /// Group of each point.
    group: Vec<u32>,
    /// Number of groups.
    groups: u32,
    /// Pairs of groups beside each other on an edge that is cut in two ways.
    seams: Vec<[u32; 2]>,
}

/// A point on the border of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct BorderPoint {
    /// Bits of its coordinates.
    place: [u64; 3],
    /// Its triangle's normal, packed.
    direction: u32,
    /// Its number.
    point: u32,
}

impl LatticePoints {
    /// Cosine of the angle, 30°, from which on a bend is a crease. A smaller angle (a larger cosine) shows the facets of round things in
    /// the light; a larger one smears light around edges that are meant. Normals are compared to within 0.2°.
    pub const CREASE: f64 = 0.866_025_403_784_438_6;

    /// The points of all triangles of `mesh`, which `lattice` cuts.
    ///
    /// # Panics
    /// If there are more points than a `u32` can number: from 1.4 · 10⁹ triangles on.
    pub fn new(mesh: &Mesh, lattice: &Lattice) -> LatticePoints {
        let triangles = mesh.triangles.len();
        let mut first = Vec::with_capacity(triangles + 1);
        let (mut total, mut on_borders) = (0, 0);
        for t in 0..triangles {
            first.push(total as u32);
            total += u64::from(lattice.points_in(t));
            on_borders += 3 * lattice.divisions(t) as usize;
        }
        first.push(u32::try_from(total).expect("a mesh of fewer than 1.4e9 triangles"));

        let mut border = Vec::with_capacity(on_borders);
        for t in 0..triangles {
            push_border(mesh.corners(t), lattice.divisions(t), first[t], &mut border);
        }
        border.sort_unstable();

        // At first, each point's entry is a point of its group that is no later; the first of the group names itself.
        let mut group: Vec<u32> = (0..total as u32).collect();
        let mut heads: Vec<BorderPoint> = Vec::new();
        for here in border.chunk_by(|a, b| a.place == b.place) {
            heads.clear();
            for alike in here.chunk_by(|a, b| a.direction == b.direction) {
                alike.iter().for_each(|p| group[p.point as usize] = alike[0].point);
                heads.push(alike[0]);
            }
            for (k, a) in heads.iter().enumerate() {
                for b in heads[..k].iter().filter(|b| smooth(a.direction, b.direction)) {
                    let (a, b) = (earliest(&group, a.point), earliest(&group, b.point));
                    group[a.max(b) as usize] = a.min(b);
                }
            }
        }

        // Groups get numbers in the order of their first points, so that neighbours in memory stay neighbours.
        let mut groups = 0;
        for point in 0..group.len() {
            let earlier = group[point] as usize;
            if earlier == point {
                group[point] = groups;
                groups += 1;
            } else {
                group[point] = group[earlier];
            }
        }
        let pairs = unequal(mesh, lattice, &first).into_iter().map(|pair| pair.map(|point| group[point as usize]));
        let mut seams: Vec<[u32; 2]> = pairs.filter(|[a, b]| a != b).map(|[a, b]| [a.min(b), a.max(b)]).collect();
        seams.sort_unstable();
        seams.dedup();
        LatticePoints { first, group, groups, seams }
    }

    /// All points of the mesh.
    pub fn count(&self) -> u32 {
        self.first[self.triangles()]
    }

    /// Triangles of the mesh.
    pub fn triangles(&self) -> usize {
        self.first.len() - 1
    }

    /// First point of triangle `t`: its first corner.
    pub fn first(&self, t: usize) -> u32 {
        self.first[t]
    }

    /// The points of triangle `t`.
    pub fn points_of(&self, t: usize) -> Range<u32> {
        self.first[t]..self.first[t + 1]
    }

    /// Number, within its triangle, of point (i, j) of a triangle whose edges have `n` divisions; i + j ≤ n. Row i has n − i + 1 points.
    #[inline]
    pub fn index(n: u32, i: u32, j: u32) -> u32 {
        i * (2 * n + 3 - i) / 2 + j
    }

    /// The group of a point.
    #[inline]
    pub fn group(&self, point: u32) -> u32 {
        self.group[point as usize]
    }

    /// Number of groups.
    pub fn groups(&self) -> u32 {
        self.groups
    }

    /// Pairs of groups that lie beside each other on an edge which two smooth triangles cut into different numbers of parts.
    pub fn seams(&self) -> &[[u32; 2]] {
        &self.seams
    }

    /// The three points of each cell of triangle `t`, in the order of [`Lattice::cells_of`]. An upright cell has the points (i, j),
    /// (i+1, j), (i, j+1), wound as its triangle; an inverted one (i+1, j), (i, j+1), (i+1, j+1), wound the other way.
    pub fn cells_points(&self, t: usize) -> impl Iterator<Item = [u32; 3]> + use<> {
        let Range { start, end } = self.points_of(t);
        // The solution of (n+1)(n+2)/2 = points.
        let n = ((8 * u64::from(end - start) + 1).isqrt() as u32 - 3) / 2;
        (0..n).flat_map(move |i| {
            let (row, next) = (start + Self::index(n, i, 0), start + Self::index(n, i + 1, 0));
            (0..2 * (n - i) - 1).map(move |m| {
                let j = m / 2;
                if m % 2 == 0 { [row + j, next + j, row + j + 1] } else { [next + j, row + j + 1, next + j + 1] }
            })
        })
    }
}

/// Adds the points on the border of a triangle whose edges have `n` divisions and whose first point is `first`. A triangle without an
/// area has no normal to be smooth with: its points stay alone.
fn push_border(corners: [DVec3; 3], n: u32, first: u32, border: &mut Vec<BorderPoint>) {
    let Some(direction) = direction(corners) else { return };
    let corners = corners.map(|c| c + 0.0); // −0 becomes 0
    for edge in 0..3 {
        for k in 0..n {
            let (i, j) = [(k, 0), (n - k, k), (0, n - k)][edge];
            let place = on_edge(corners[edge], corners[(edge + 1) % 3], k, n).to_array().map(f64::to_bits);
            border.push(BorderPoint { place, direction, point: first + LatticePoints::index(n, i, j) });
        }
    }
}

/// An edge of a triangle from its lower end to its higher.
struct Side {
    /// Bits of its ends' coordinates.
    ends: [[u64; 3]; 2],
    direction: u32,
    divisions: u32,
    triangle: usize,
    /// Which edge of its triangle it is, and whether it runs from its lower to its higher end there.
    edge: usize,
    forwards: bool,
}

impl Side {
    /// Point `k` from the lower end.
    fn point(&self, k: u32, first: &[u32]) -> u32 {
        let n = self.divisions;
        let k = if self.forwards { k } else { n - k };
        let (i, j) = [(k, 0), (n - k, k), (0, n - k)][self.edge];
        first[self.triangle] + LatticePoints::index(n, i, j)
    }
}

/// Pairs of points beside each other on common edges that smooth triangles cut into different numbers of parts.
fn unequal(mesh: &Mesh, lattice: &Lattice, first: &[u32]) -> Vec<[u32; 2]> {
    let mut sides: Vec<Side> = Vec::new();
    for triangle in 0..mesh.triangles.len() {
        let Some(direction) = direction(mesh.corners(triangle)) else { continue };
        let divisions = lattice.divisions(triangle);
        let corners = mesh.corners(triangle).map(|c| c + 0.0);
        for edge in 0..3 {
            let ends = [corners[edge], corners[(edge + 1) % 3]];
            let forwards = ends[0].to_array() <= ends[1].to_array();
            let ends = if forwards { ends } else { [ends[1], ends[0]] }.map(|p| p.to_array().map(f64::to_bits));
            sides.push(Side { ends, direction, divisions, triangle, edge, forwards });
        }
    }
    sides.sort_by_key(|side| (side.ends, side.triangle, side.edge));
    let mut pairs = Vec::new();
    for here in sides.chunk_by(|a, b| a.ends == b.ends) {
        for (number, a) in here.iter().enumerate() {
            for b in here[..number].iter().filter(|b| a.divisions != b.divisions && smooth(a.direction, b.direction)) {
                for (from, to) in [(a, b), (b, a)] {
                    let (n, m) = (u64::from(from.divisions), u64::from(to.divisions));
                    for k in (1..n).filter(|k| k * m % n != 0) {
                        let nearest = (2 * k * m + n) / (2 * n);
                        pairs.push([from.point(k as u32, first), to.point(nearest as u32, first)]);
                    }
                }
            }
        }
    }
    pairs
}

/// Point `k` of the `n` on an edge, with the same bits whichever of its ends comes first.
fn on_edge(from: DVec3, to: DVec3, k: u32, n: u32) -> DVec3 {
    if k == 0 {
        return from;
    }
    let forwards = from.to_array() <= to.to_array();
    let (a, b, k) = if forwards { (from, to, k) } else { (to, from, n - k) };
    a + (b - a) * (f64::from(k) / f64::from(n))
}

/// Largest coordinate of a packed normal: all fit into 10 bits.
const UNIT: f64 = 511.0;

/// The rounded normal of a triangle, packed: however many triangles meet at a place, their directions are few. `None` without an area.
fn direction([a, b, c]: [DVec3; 3]) -> Option<u32> {
    let normal = (b - a).cross(c - a).try_normalize()?;
    Some(normal.to_array().into_iter().fold(0, |packed, x| packed << 10 | (x * UNIT + UNIT).round() as u32))
}

/// Whether there is no crease between triangles of two directions.
fn smooth(a: u32, b: u32) -> bool {
    let [a, b] = [a, b].map(|packed| DVec3::from_array([20, 10, 0].map(|bit| f64::from(packed >> bit & 1023) - UNIT)));
    a.dot(b) > LatticePoints::CREASE * (a.length_squared() * b.length_squared()).sqrt()
}

/// The earliest point that is known to be of the group of `point`.
fn earliest(group: &[u32], mut point: u32) -> u32 {
    while group[point as usize] != point {
        point = group[point as usize];
    }
    point
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Mesh {
        let material_of = vec![0; triangles.len()];
        Mesh { positions, triangles, material_of, materials: vec!["m".into()], uvs: vec![] }
    }

    fn points(mesh: &Mesh, cell: f64) -> (Lattice, LatticePoints) {
        let lattice = Lattice::new(mesh, cell).unwrap();
        let points = LatticePoints::new(mesh, &lattice);
        (lattice, points)
    }

    /// Each triangle with corners of its own.
    fn torn(mesh: &Mesh) -> Mesh {
        let positions = (0..mesh.triangles.len()).flat_map(|t| mesh.corners(t)).collect();
        let triangles = (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        Mesh { positions, triangles, ..mesh.clone() }
    }

    /// Two squares with a common edge, bent by `degrees` out of one plane, four triangles.
    fn bend(degrees: f64) -> Mesh {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let xz = [(-1.0, 0.0), (0.0, 0.0), (cos, sin)];
        let positions = [0.1, 1.1].into_iter().flat_map(|y| xz.map(|(x, z)| DVec3::new(x, y, z))).collect();
        mesh(positions, vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
    }

    /// A fan of `sides` triangles around the origin, `height` below which its rim of radius 1 lies.
    fn cone(sides: u32, height: f64) -> Mesh {
        let rim = (0..sides).map(|s| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(s) / f64::from(sides)).sin_cos();
            DVec3::new(cos, sin, -height)
        });
        let triangles = (0..sides).map(|s| [0, 1 + s, 1 + (s + 1) % sides]).collect();
        mesh([DVec3::ZERO].into_iter().chain(rim).collect(), triangles)
    }

    /// The points of a triangle that `n` divides, as (i, j), by number.
    fn numbered(n: u32) -> Vec<(u32, u32)> {
        (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))).collect()
    }

    #[test]
    fn an_edge_that_is_cut_in_two_ways_is_a_seam() {
        // The upper triangle is high, so that it is cut finer along the common edge than the lower one.
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let mesh = mesh(vec![p(0.0, 0.0), p(1.0, 0.0), p(0.5, 3.0), p(0.5, -0.5)], vec![[0, 1, 2], [1, 0, 3]]);
        let (lattice, points) = points(&mesh, 0.5);
        let [n, m] = [0, 1].map(|t| lattice.divisions(t));
        assert_eq!((n, m), (7, 2));
        // The lower triangle's middle lies between points 3 and 4 of the upper one.
        let upper = |k: u32| points.group(points.first(0) + LatticePoints::index(7, k, 0));
        let lower = |k: u32| points.group(points.first(1) + LatticePoints::index(2, k, 0));
        assert_eq!([upper(0), upper(7)], [lower(2), lower(0)], "they share the ends");
        let beside = |a: u32, b: u32| points.seams().contains(&[a.min(b), a.max(b)]);
        assert!(beside(upper(3), lower(1)) && beside(upper(4), lower(1)) && beside(upper(1), lower(2)));
        assert_eq!(points.seams().len(), 6);
        let (_, equal) = self::points(&bend(0.0), 0.1);
        assert!(equal.seams().is_empty());
    }

    #[test]
    fn points_are_numbered_in_rows() {
        for n in [1, 2, 3, 7, 30] {
            for (number, (i, j)) in numbered(n).into_iter().enumerate() {
                assert_eq!(LatticePoints::index(n, i, j), number as u32);
            }
        }
        assert_eq!(LatticePoints::index(30_000, 30_000, 0), 30_001 * 30_002 / 2 - 1);
    }

    #[test]
    fn cells_have_the_points_around_them() {
        let square = mesh(vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y], vec![[0, 1, 2], [0, 2, 3]]);
        for n in [1, 2, 3, 4, 5, 16, 33] {
            let (lattice, points) = points(&square, 2f64.sqrt() / (f64::from(n) - 0.5));
            let numbered = numbered(n);
            for t in 0..2 {
                assert_eq!(lattice.divisions(t), n);
                assert_eq!(points.points_of(t).len(), numbered.len());
                let corners: Vec<_> = points.cells_points(t).collect();
                assert_eq!(corners.len(), lattice.cells_of(t).len());
                for (cell, corners) in lattice.cells_of(t).zip(corners) {
                    let at = corners.map(|p| numbered[(p - points.first(t)) as usize]);
                    let weight = |sum: u32| sum as f32 / (3 * n) as f32;
                    let [i, j] = [at.map(|(i, _)| i), at.map(|(_, j)| j)];
                    let (b1, b2) = (weight(i.iter().sum()), weight(j.iter().sum()));
                    assert_eq!(lattice.cell(t, b1, b2), cell, "{at:?} of {n}");
                    let extent = |x: [u32; 3]| x.iter().max().unwrap() - x.iter().min().unwrap();
                    assert_eq!((extent(i), extent(j)), (1, 1), "{at:?} of {n}");
                }
            }
        }
    }

    #[test]
    fn flat_neighbours_share_the_points_of_their_edges() {
        // Coordinates that round, corners shared or not, and a corner at −0.
        let third = 1.0 / 3.0;
        let turned = |x: f64, y: f64| DVec3::new(0.1 + 0.7 * x - 0.3 * y, third * y + 0.2 * x, 0.9 - x * third + y);
        let corners = vec![turned(0.0, 0.0), turned(1.0, 0.0), turned(1.0, 1.0), turned(0.0, 1.0)];
        let whole = mesh(corners, vec![[0, 1, 2], [3, 0, 2]]);
        let mut negative = torn(&mesh(vec![DVec3::ZERO, DVec3::X, DVec3::Y, -DVec3::X], vec![[0, 1, 2], [3, 0, 2]]));
        negative.positions[0] = -DVec3::ZERO;
        for mesh in [torn(&whole), whole, negative] {
            for cell in [5.0, 0.3, 0.1, 0.017] {
                let (lattice, points) = points(&mesh, cell);
                let n = lattice.divisions(0);
                assert_eq!(lattice.divisions(1), n);
                assert_eq!(points.count() - points.groups(), n + 1, "all on the common edge, {n} divisions");
            }
        }
    }

    #[test]
    fn a_crease_parts_what_a_shallow_bend_joins() {
        let joined = |degrees: f64| {
            let (lattice, points) = points(&bend(degrees), 0.1);
            let n = lattice.divisions(0);
            // Two triangles share each point of both squares' diagonals, and of the common edge if it is smooth.
            let shared = points.count() - points.groups();
            assert!([2, 3].contains(&(shared / (n + 1))) && shared % (n + 1) == 0, "{degrees}°: {shared}");
            shared > 2 * (n + 1)
        };
        for degrees in [0.0, 20.0, -20.0, 29.5, -29.5] {
            assert!(joined(degrees), "{degrees}°");
        }
        for degrees in [30.5, -30.5, 40.0, 90.0, -90.0, 150.0] {
            assert!(!joined(degrees), "{degrees}°");
        }
        // Two sheets back to back.
        let sheets = mesh(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2], [0, 2, 1]]);
        let (_, points) = points(&sheets, 0.1);
        assert_eq!(points.groups(), points.count());
    }

    #[test]
    fn smoothness_is_a_chain() {
        // Around a blunt cone each side is smooth with the next; the tip is one group although opposite sides are 80° apart.
        let blunt = cone(24, 40f64.to_radians().tan());
        let (_, points) = points(&blunt, 9.0);
        assert_eq!((points.count(), points.groups()), (72, 25));
        // A pyramid of four such sides has edges.
        let (_, points) = self::points(&cone(4, 40f64.to_radians().tan()), 9.0);
        assert_eq!(points.groups(), points.count());
    }

    #[test]
    fn ten_thousand_triangles_at_one_place() {
        for height in [0.0, 0.1, 1.0] {
            let (_, points) = points(&cone(10_000, height), 9.0);
            assert_eq!((points.count(), points.groups()), (30_000, 10_001), "height {height}");
        }
    }

    #[test]
    fn groups_are_numbered_by_their_first_points() {
        let (_, points) = points(&cone(24, 0.3), 0.2);
        let mut next = 0;
        for group in (0..points.count()).map(|p| points.group(p)) {
            assert!(group <= next);
            next = next.max(group + 1);
        }
        assert_eq!(next, points.groups());
    }

    #[test]
    fn triangles_without_an_area_stay_alone() {
        let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X * 0.5];
        let (_, points) = points(&mesh(corners, vec![[0, 1, 2], [0, 3, 1], [0, 0, 0], [1, 2, 2]]), 0.25);
        assert_eq!(points.groups(), points.count());
    }

    #[test]
    fn a_mesh_without_triangles_has_no_points() {
        let (_, points) = points(&Mesh::default(), 0.1);
        assert_eq!((points.count(), points.groups(), points.triangles()), (0, 0, 0));
    }
}
