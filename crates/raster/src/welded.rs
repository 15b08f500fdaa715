//! A mesh as shadow volumes need it: vertices welded, T-junctions stitched, edges with the triangles that meet there.
//!
//! A volume's sides cancel exactly only where neighbouring triangles share their vertices. Vertices closer together than a
//! millionth of the mesh are one; where a vertex lies on an edge of a triangle that does not use it, that triangle is split
//! there. Rounding can then open no crack in a shadow, and none in the picture, which draws the same triangles.
//! Edges, and which parts of a mesh are closed: Aldridge and Woods 2004, *Robust, geometry-independent shadow volumes*.

use crate::bounds::Bounds;
use glam::DVec3;
use lightmend_scene::Mesh;
use std::collections::{BTreeMap, HashMap};

/// Vertices closer together than this share of the mesh's size are one.
const WELD: f64 = 2e-6;

/// A triangle with welded corners.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Face {
    /// Indices into [`Welded::positions`].
    pub corners: [u32; 3],
    /// The mesh's triangle that it is, or is a part of.
    pub source: u32,
    /// Whether it belongs to a closed part: one that every edge balances, so that it has an inside.
    pub closed: bool,
}

/// An edge and the faces that meet there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// The lower vertex, then the higher.
    pub ends: [u32; 2],
    /// Its entries in [`Welded::incidences`].
    pub first: u32,
    /// One past the last of them.
    pub end: u32,
}

/// A mesh with shared vertices and edges, in the object's own space.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Welded {
    /// Vertices, metres.
    pub positions: Vec<DVec3>,
    /// Triangles, those of the mesh in its order; parts of one in a row.
    pub faces: Vec<Face>,
    /// Every edge once.
    pub edges: Vec<Edge>,
    /// Per edge, the faces that meet there, and whether they run from its lower to its higher vertex.
    pub incidences: Vec<(u32, bool)>,
}

impl Welded {
    /// Welds and stitches a mesh.
    pub fn new(mesh: &Mesh) -> Welded {
        let low = mesh.positions.iter().fold(DVec3::INFINITY, |a, b| a.min(*b));
        let high = mesh.positions.iter().fold(DVec3::NEG_INFINITY, |a, b| a.max(*b));
        let tolerance = if mesh.positions.is_empty() { 1.0 } else { (high - low).length() * WELD };
        let (positions, number) = weld(&mesh.positions, tolerance.max(f64::MIN_POSITIVE));
        let mut faces: Vec<Face> = (0u32..)
            .zip(&mesh.triangles)
            .map(|(source, corners)| Face { corners: corners.map(|i| number[i as usize]), source, closed: false })
            .filter(|face| !collapsed(face.corners))
            .collect();
        let splits = t_junctions(&positions, &faces, tolerance);
        if !splits.is_empty() {
            faces = faces.into_iter().flat_map(|face| split(face, &splits)).collect();
        }
        let (edges, incidences) = edges_of(&faces);
        let mut welded = Welded { positions, faces, edges, incidences };
        welded.mark_closed();
        welded
    }

    /// Its connected parts, those together that fit a box of diagonal `size`, metres: their shadows are small, and need not be drawn in all
    /// of the picture. No edge is cut.
    pub fn parts(&self, size: f64) -> Vec<Welded> {
        let mut joined = self.connected();
        let mut members: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        (0..self.faces.len() as u32).for_each(|face| members.entry(joined.find(face)).or_default().push(face));
        let boxes = members.into_values().map(|faces| {
            let corners = faces.iter().flat_map(|face| self.faces[*face as usize].corners);
            let bounds = Bounds::about(corners.map(|v| self.positions[v as usize]));
            (bounds, faces)
        });
        let mut groups = Vec::new();
        let mut whole = vec![boxes.collect::<Vec<_>>()];
        while let Some(mut group) = whole.pop() {
            let about = Bounds::about(group.iter().flat_map(|(bounds, _)| [bounds.low, bounds.high]));
            if group.len() < 2 || (about.high - about.low).length() <= size {
                groups.push(group.into_iter().flat_map(|(_, faces)| faces).collect::<Vec<u32>>());
                continue;
            }
            // Halved across the axis along which the middles lie farthest apart.
            let middle = |bounds: &Bounds| bounds.low + bounds.high;
            let span = Bounds::about(group.iter().map(|(bounds, _)| middle(bounds)));
            let extent = span.high - span.low;
            let axis = if extent.x >= extent.y && extent.x >= extent.z {
                0
            } else if extent.y >= extent.z {
                1
            } else {
                2
            };
            group.sort_by(|a, b| middle(&a.0)[axis].total_cmp(&middle(&b.0)[axis]));
            let upper = group.split_off(group.len() / 2);
            whole.extend([upper, group]);
        }
        groups.sort();
        groups.into_iter().map(|faces| self.subset(faces)).collect()
    }

    /// Some of the faces, which share no edge with the others.
    fn subset(&self, mut faces: Vec<u32>) -> Welded {
        faces.sort_unstable();
        let mut number: HashMap<u32, u32> = HashMap::new();
        let mut positions = Vec::new();
        let mut renumbered = |v: u32| {
            *number.entry(v).or_insert_with(|| {
                positions.push(self.positions[v as usize]);
                positions.len() as u32 - 1
            })
        };
        let faces = faces.iter().map(|face| self.faces[*face as usize]);
        let faces: Vec<Face> = faces.map(|face| Face { corners: face.corners.map(&mut renumbered), ..face }).collect();
        let (edges, incidences) = edges_of(&faces);
        Welded { positions, faces, edges, incidences }
    }

    /// Whether all of it is closed, with its fronts outwards: from outside only fronts are seen.
    pub fn outwards(&self) -> bool {
        let mut parts = self.connected();
        let mut volumes: BTreeMap<u32, f64> = BTreeMap::new();
        for (number, face) in (0u32..).zip(&self.faces) {
            let [a, b, c] = face.corners.map(|v| self.positions[v as usize] - self.positions[0]);
            *volumes.entry(parts.find(number)).or_default() += a.dot(b.cross(c));
        }
        self.faces.iter().all(|face| face.closed) && volumes.values().all(|volume| *volume > 0.0)
    }

    /// Which faces are connected by edges.
    fn connected(&self) -> Parts {
        let mut parts = Parts::new(self.faces.len());
        for edge in &self.edges {
            self.incident(edge).windows(2).for_each(|pair| parts.join(pair[0].0, pair[1].0));
        }
        parts
    }

    /// The faces that meet at an edge, and whether they run from its lower to its higher vertex.
    pub fn incident(&self, edge: &Edge) -> &[(u32, bool)] {
        &self.incidences[edge.first as usize..edge.end as usize]
    }

    /// Parts of which every edge is run through as often one way as the other.
    fn mark_closed(&mut self) {
        let mut parts = self.connected();
        let mut open = vec![false; self.faces.len()];
        for edge in &self.edges {
            let met = &self.incidences[edge.first as usize..edge.end as usize];
            if 2 * met.iter().filter(|(_, forward)| *forward).count() != met.len() {
                open[parts.find(met[0].0) as usize] = true;
            }
        }
        for face in 0..self.faces.len() {
            self.faces[face].closed = !open[parts.find(face as u32) as usize];
        }
    }
}

fn collapsed([a, b, c]: [u32; 3]) -> bool {
    a == b || b == c || c == a
}

/// Joins vertices within `tolerance`; the position of each that is left, and the number of each old one.
fn weld(positions: &[DVec3], tolerance: f64) -> (Vec<DVec3>, Vec<u32>) {
    let place = |p: DVec3| (p / tolerance).floor().to_array().map(|x| x as i64);
    let mut grid: HashMap<[i64; 3], Vec<u32>> = HashMap::with_capacity(positions.len());
    let mut kept: Vec<DVec3> = Vec::new();
    let number = positions
        .iter()
        .map(|p| {
            let [x, y, z] = place(*p);
            // The first of the kept vertices that is near, whichever cell it lies in.
            let cells = (-1..=1).flat_map(|dx| (-1..=1).flat_map(move |dy| (-1..=1).map(move |dz| [x + dx, y + dy, z + dz])));
            let near = cells.filter_map(|cell| grid.get(&cell)).flatten().copied();
            let near = near.filter(|k| kept[*k as usize].distance(*p) <= tolerance).min();
            near.unwrap_or_else(|| {
                kept.push(*p);
                let new = kept.len() as u32 - 1;
                grid.entry([x, y, z]).or_default().push(new);
                new
            })
        })
        .collect();
    (kept, number)
}

/// Vertices inside edges, and inside what is left of an edge after its first ones, in order.
type Splits = HashMap<[u32; 2], Vec<u32>>;

fn key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Vertices of unbalanced edges that lie inside other unbalanced edges.
fn t_junctions(positions: &[DVec3], faces: &[Face], tolerance: f64) -> Splits {
    let (edges, incidences) = edges_of(faces);
    let unbalanced: Vec<[u32; 2]> = edges
        .iter()
        .filter(|edge| {
            let met = &incidences[edge.first as usize..edge.end as usize];
            2 * met.iter().filter(|(_, forward)| *forward).count() != met.len()
        })
        .map(|edge| edge.ends)
        .collect();
    let mut ends: Vec<u32> = unbalanced.iter().flatten().copied().collect();
    ends.sort_unstable();
    ends.dedup();
    // The vertices along each axis: an edge looks for its vertices where the fewest lie within its extent.
    let along: [Vec<u32>; 3] = std::array::from_fn(|axis| {
        let mut sorted = ends.clone();
        sorted.sort_by(|a, b| positions[*a as usize][axis].total_cmp(&positions[*b as usize][axis]));
        sorted
    });
    let mut splits = Splits::new();
    for [a, b] in unbalanced {
        let (from, to) = (positions[a as usize], positions[b as usize]);
        let (low, high) = (from.min(to) - tolerance, from.max(to) + tolerance);
        let candidates = (0..3).map(|axis| {
            let sorted = &along[axis];
            let first = sorted.partition_point(|v| positions[*v as usize][axis] < low[axis]);
            let end = sorted.partition_point(|v| positions[*v as usize][axis] <= high[axis]);
            &sorted[first..end]
        });
        let Some(candidates) = candidates.min_by_key(|c| c.len()) else { continue };
        let way = to - from;
        let length = way.length();
        let mut inside: Vec<(f64, u32)> = candidates
            .iter()
            .filter(|v| **v != a && **v != b)
            .filter_map(|v| {
                let offset = positions[*v as usize] - from;
                let share = offset.dot(way) / (length * length);
                let distance = (offset - way * share).length();
                (share > 0.0 && share < 1.0 && distance <= tolerance).then_some((share, *v))
            })
            .collect();
        if !inside.is_empty() {
            inside.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
            let inside: Vec<u32> = inside.into_iter().map(|(_, v)| v).collect();
            for (v, rest) in inside.iter().zip(1..inside.len()) {
                splits.insert(key(*v, b), inside[rest..].to_vec());
            }
            splits.insert([a, b], inside);
        }
    }
    splits
}

/// A face split at the vertices inside its edges.
fn split(face: Face, splits: &Splits) -> Vec<Face> {
    let mut whole = vec![face];
    let mut done = Vec::new();
    while let Some(face) = whole.pop() {
        let edges = [0, 1, 2].map(|k| (k, face.corners[k], face.corners[(k + 1) % 3]));
        let inside = edges.iter().find_map(|(k, a, b)| {
            let first = splits.get(&key(*a, *b))?.first()?;
            (!face.corners.contains(first)).then_some((*k, *first))
        });
        match inside {
            None => done.push(face),
            Some((k, vertex)) => {
                let [a, b, c] = [0, 1, 2].map(|n| face.corners[(k + n) % 3]);
                whole.push(Face { corners: [vertex, b, c], ..face });
                whole.push(Face { corners: [a, vertex, c], ..face });
            }
        }
    }
    done
}

fn edges_of(faces: &[Face]) -> (Vec<Edge>, Vec<(u32, bool)>) {
    let mut runs: Vec<([u32; 2], u32, bool)> = Vec::with_capacity(3 * faces.len());
    for (number, face) in (0u32..).zip(faces) {
        let [a, b, c] = face.corners;
        runs.extend([(a, b), (b, c), (c, a)].map(|(from, to)| (key(from, to), number, from < to)));
    }
    runs.sort_unstable();
    let mut edges: Vec<Edge> = Vec::with_capacity(runs.len() / 2);
    for (place, (ends, ..)) in (0u32..).zip(&runs) {
        match edges.last_mut().filter(|edge| edge.ends == *ends) {
            Some(edge) => edge.end = place + 1,
            None => edges.push(Edge { ends: *ends, first: place, end: place + 1 }),
        }
    }
    (edges, runs.into_iter().map(|(_, face, forward)| (face, forward)).collect())
}

/// Disjoint sets of faces.
struct Parts(Vec<u32>);

impl Parts {
    fn new(count: usize) -> Parts {
        Parts((0..count as u32).collect())
    }

    fn find(&mut self, of: u32) -> u32 {
        let mut root = of;
        while self.0[root as usize] != root {
            self.0[root as usize] = self.0[self.0[root as usize] as usize];
            root = self.0[root as usize];
        }
        root
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Mesh {
        let material_of = vec![0; triangles.len()];
        Mesh { positions, triangles, material_of, materials: vec!["m".into()], uvs: vec![] }
    }

    fn unbalanced(welded: &Welded) -> usize {
        let odd = |e: &&Edge| 2 * welded.incident(e).iter().filter(|(_, f)| *f).count() != welded.incident(e).len();
        welded.edges.iter().filter(odd).count()
    }

    /// A unit cube, its eight corners listed once for each face, off by a rounding.
    fn loose_cube() -> Mesh {
        let corner = |k: usize| DVec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let positions =
            quads.iter().zip(0..).flat_map(|(q, n)| q.map(|k| corner(k) + DVec3::splat(1e-7 * f64::from(n)))).collect();
        let triangles = (0..6).flat_map(|q| [[4 * q, 4 * q + 1, 4 * q + 2], [4 * q, 4 * q + 2, 4 * q + 3]]).collect();
        mesh(positions, triangles)
    }

    #[test]
    fn loose_faces_are_welded_to_a_closed_cube() {
        let welded = Welded::new(&loose_cube());
        assert_eq!((welded.positions.len(), welded.edges.len(), unbalanced(&welded)), (8, 18, 0));
        assert!(welded.faces.iter().all(|f| f.closed) && welded.outwards());
        let mut inwards = loose_cube();
        inwards.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        assert!(!Welded::new(&inwards).outwards());
    }

    #[test]
    fn a_missing_face_or_a_flipped_one_leaves_it_open() {
        let mut open = loose_cube();
        open.triangles.pop();
        open.material_of.pop();
        assert!(Welded::new(&open).faces.iter().all(|f| !f.closed));
        let mut flipped = loose_cube();
        flipped.triangles[3].swap(0, 1);
        let welded = Welded::new(&flipped);
        assert_eq!(unbalanced(&welded), 3);
        assert!(welded.faces.iter().all(|f| !f.closed));
    }

    #[test]
    fn parts_are_closed_or_open_each_for_itself() {
        let mut two = loose_cube();
        let first = two.positions.len() as u32;
        two.positions.extend([DVec3::splat(5.0), DVec3::new(6.0, 5.0, 5.0), DVec3::new(5.0, 6.0, 5.0)]);
        two.triangles.push([first, first + 1, first + 2]);
        two.material_of.push(0);
        let welded = Welded::new(&two);
        let closed: Vec<bool> = welded.faces.iter().map(|f| f.closed).collect();
        assert_eq!(closed.iter().filter(|c| **c).count(), 12);
        assert!(!closed[12]);
        assert_eq!(welded.parts(100.0), std::slice::from_ref(&welded));
        let parts = welded.parts(3.0);
        assert_eq!(
            parts.iter().map(|p| (p.faces.len(), p.positions.len(), unbalanced(p))).collect::<Vec<_>>(),
            [(12, 8, 0), (1, 3, 3)]
        );
    }

    #[test]
    fn t_junctions_are_stitched() {
        // A square of one triangle above, three below whose corners divide its edge.
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.3);
        let positions = vec![p(0.0, 0.0), p(3.0, 0.0), p(0.0, 3.0), p(1.0, 0.0), p(2.0, 0.0), p(0.0, -1.0), p(3.0, -1.0)];
        let triangles = vec![[0, 1, 2], [0, 5, 3], [3, 5, 4], [4, 5, 6], [4, 6, 1]];
        let welded = Welded::new(&mesh(positions, triangles));
        assert_eq!(welded.faces.len(), 7);
        assert_eq!(welded.faces.iter().filter(|f| f.source == 0).count(), 3);
        for ends in [[0, 3], [3, 4], [1, 4]] {
            let edge = welded.edges.iter().find(|e| e.ends == ends).unwrap();
            assert_eq!(welded.incident(edge).len(), 2, "{ends:?}");
        }
        let area: f64 = welded
            .faces
            .iter()
            .map(|f| {
                let [a, b, c] = f.corners.map(|v| welded.positions[v as usize]);
                (b - a).cross(c - a).z / 2.0
            })
            .sum();
        assert!((area - 7.5).abs() < 1e-12);
    }

    #[test]
    fn collapsed_triangles_vanish() {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::splat(1e-9)];
        assert_eq!(Welded::new(&mesh(positions, vec![[0, 1, 2], [1, 3, 2]])).faces.len(), 1);
    }
}
