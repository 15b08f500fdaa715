//! Shadow volumes: what a lamp cannot reach behind an object, bounded by triangles.
//!
//! Crow 1977. A set of triangles is turned towards the lamp and pushed away from it to infinity; the sides stand on the edges that
//! do not cancel (Aldridge and Woods 2004). Where the camera is outside a volume, its sides are counted in front of what is seen, and
//! nothing else is drawn (z-pass). Otherwise all triangles cast, near and far ends are drawn too, and what lies behind is counted (z-fail:
//! Everitt and Kilgard 2002). Which one is right is decided for each object and lamp by what stands between the lamp and the near plane.
//!
//! Of closed parts it is enough that the triangles cast that are turned away from the lamp: half the sides, at the silhouette. From inside
//! out, with the lamp in the middle (a room's shell), it is those turned towards it.

use crate::{bounds::Bounds, camera::Camera, welded::Welded};
use glam::DVec3;
use std::{f64::consts::PI, sync::Arc};

/// An object's surface where it stands.
#[derive(Debug, Clone)]
pub struct Caster {
    /// Its shape.
    pub welded: Arc<Welded>,
    /// Its vertices in the world, as the photons' rays meet them: rounded to single precision. Metres.
    pub positions: Vec<DVec3>,
    /// About them.
    pub bounds: Bounds,
}

/// How a volume's triangle list names a vertex: twice its number, and one more for where it goes at infinity.
const fn vertex(v: u32, at_infinity: bool) -> u32 {
    2 * v + at_infinity as u32
}

/// Triangles of a whole volume; an index is twice the vertex, and one more for where it goes at infinity.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Whole {
    /// Sides and far ends, fronts outwards.
    pub shell: Vec<u32>,
    /// Near ends turned towards the lamp: fronts outwards.
    pub towards: Vec<u32>,
    /// Near ends turned away, in the order of the surface's triangles, whose depth they must have to the bit: fronts inwards.
    pub away: Vec<u32>,
}

impl Caster {
    /// Of a shape whose vertices stand at `positions`.
    pub fn new(welded: Arc<Welded>, positions: Vec<DVec3>) -> Caster {
        let bounds = Bounds::about(positions.iter().copied());
        Caster { welded, positions, bounds }
    }

    fn corners(&self, face: usize) -> [DVec3; 3] {
        self.welded.faces[face].corners.map(|v| self.positions[v as usize])
    }

    /// Whether a face is turned towards a point.
    fn faces(&self, face: usize, lamp: DVec3) -> bool {
        let [a, b, c] = self.corners(face);
        (b - a).cross(c - a).dot(lamp - a) > 0.0
    }

    /// How often the closed parts wind around a point (van Oosterom and Strackee 1983): 0 outside, 1 inside, −1 inside of what is
    /// inside out.
    fn winding(&self, point: DVec3, mut counts: impl FnMut(usize) -> bool) -> f64 {
        let mut sum = 0.0;
        for face in (0..self.welded.faces.len()).filter(|face| counts(*face)) {
            let [a, b, c] = self.corners(face).map(|p| p - point);
            let [la, lb, lc] = [a, b, c].map(DVec3::length);
            let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            sum += 2.0 * a.dot(b.cross(c)).atan2(below);
        }
        sum / (4.0 * PI)
    }

    /// Whether a point lies inside a closed part.
    pub fn holds(&self, point: DVec3) -> bool {
        self.bounds.contains(point) && self.winding(point, |face| self.welded.faces[face].closed) > 0.5
    }

    /// Per face, whether it casts as it is (1), turned over (−1) or not at all (0).
    fn casts(&self, lamp: DVec3, whole: bool) -> Vec<i8> {
        let closed = |face: usize| self.welded.faces[face].closed;
        let inside_out = !whole && self.bounds.contains(lamp) && self.winding(lamp, closed) < -0.5;
        (0..self.welded.faces.len())
            .map(|face| match (self.faces(face, lamp), !whole && closed(face), inside_out) {
                (true, true, false) | (false, true, true) => 0,
                (true, ..) => 1,
                (false, ..) => -1,
            })
            .collect()
    }

    /// Sides of the volume; `first` is the number of its first vertex. A side for each edge, even where edges go on straight ahead: the sides
    /// must begin where the surface's own triangles end, to the same fraction of a pixel, or pixels on its rim see past both.
    fn push_sides(&self, casts: &[i8], first: u32, out: &mut Vec<u32>) {
        for edge in &self.welded.edges {
            let direction = |(face, forward): &(u32, bool)| {
                let cast = i32::from(casts[*face as usize]);
                if *forward { cast } else { -cast }
            };
            let times: i32 = self.welded.incident(edge).iter().map(direction).sum();
            let [low, high] = edge.ends.map(|v| v + first);
            let (a, b) = if times > 0 { (low, high) } else { (high, low) };
            for _ in 0..times.abs() {
                let [a, b, far_a, far_b] = [vertex(a, false), vertex(b, false), vertex(a, true), vertex(b, true)];
                out.extend([b, a, far_a, b, far_a, far_b]);
            }
        }
    }

    /// What is drawn of the volume where the camera is outside it.
    pub fn sides(&self, lamp: DVec3, first: u32) -> Vec<u32> {
        let mut sides = Vec::new();
        self.push_sides(&self.casts(lamp, false), first, &mut sides);
        sides
    }

    /// The whole volume, of all triangles.
    pub fn whole(&self, lamp: DVec3, first: u32) -> Whole {
        let casts = self.casts(lamp, true);
        let mut whole = Whole::default();
        self.push_sides(&casts, first, &mut whole.shell);
        for (face, cast) in self.welded.faces.iter().zip(&casts) {
            let [a, b, c] = face.corners.map(|v| v + first);
            let near = [a, b, c].map(|v| vertex(v, false));
            let far = [a, b, c].map(|v| vertex(v, true));
            if *cast > 0 {
                whole.towards.extend(near);
                whole.shell.extend([far[2], far[1], far[0]]);
            } else {
                whole.away.extend(near);
                whole.shell.extend(far);
            }
        }
        whole
    }

    /// Whether the near plane may be in the volume: something of the caster stands between the lamp and the part of the near plane that is in the
    /// picture.
    pub fn may_shade_near_plane(&self, lamp: DVec3, camera: &Camera) -> bool {
        let [a, b, c, d] = camera.near_corners();
        // The sides of the pyramid and its base; their normals point outwards or inwards, both ends are compared.
        let normals = [(a, b), (b, c), (c, d), (d, a)].map(|(p, q)| (p - lamp).cross(q - lamp));
        let normals = [normals[0], normals[1], normals[2], normals[3], camera.forward];
        let spans = normals.map(|n| {
            let along = [lamp, a, b, c, d].map(|p| n.dot(p));
            let slack = 1e-9 * n.length() * (lamp.length() + camera.eye.length());
            (along.into_iter().fold(f64::INFINITY, f64::min) - slack, along.into_iter().fold(f64::NEG_INFINITY, f64::max) + slack)
        });
        let pyramid = Bounds::about([lamp, a, b, c, d].into_iter());
        let apart = |bounds: &Bounds, points: &[DVec3]| {
            bounds.low.cmpgt(pyramid.high).any()
                || bounds.high.cmplt(pyramid.low).any()
                || normals
                    .iter()
                    .zip(spans)
                    .any(|(n, (low, high))| points.iter().all(|p| n.dot(*p) < low) || points.iter().all(|p| n.dot(*p) > high))
        };
        if apart(&self.bounds, &self.bounds.corners()) {
            return false;
        }
        (0..self.welded.faces.len()).any(|face| {
            let corners = self.corners(face);
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let heights = [lamp, a, b, c, d].map(|p| normal.dot(p - corners[0]));
            let slack = 1e-9 * normal.length() * (lamp.length() + camera.eye.length());
            let beside = heights.iter().all(|h| *h > slack) || heights.iter().all(|h| *h < -slack);
            !beside && !apart(&Bounds::about(corners.into_iter()), &corners)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lightmend_scene::{Mesh, Up, View};

    fn caster(inwards: bool, open: bool) -> Caster {
        let corner = |k: usize| DVec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> = quads
            .iter()
            .take(if open { 5 } else { 6 })
            .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
            .map(|[a, b, c]| if inwards { [a, c, b] } else { [a, b, c] })
            .collect();
        let positions: Vec<DVec3> = (0..8).map(corner).collect();
        let material_of = vec![0; triangles.len()];
        let mesh = Mesh { positions: positions.clone(), triangles, material_of, materials: vec!["m".into()], uvs: vec![] };
        Caster::new(Arc::new(Welded::new(&mesh)), positions)
    }

    /// How often a ray from `from` to `to` enters the volume, less how often it leaves it: 0 in the light, more in the shadow.
    fn crossings(caster: &Caster, indices: &[u32], lamp: DVec3, from: DVec3, to: DVec3) -> i32 {
        // Infinity is far away here.
        let place = |index: u32| {
            let p = caster.positions[(index / 2) as usize];
            if index.is_multiple_of(2) { p } else { p + (p - lamp) * 1e4 }
        };
        let direction = to - from;
        indices
            .as_chunks::<3>()
            .0
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.map(place);
                let (u, v) = (b - a, c - a);
                let p = direction.cross(v);
                let determinant = u.dot(p);
                let s = (from - a).dot(p) / determinant;
                let q = (from - a).cross(u);
                let t = direction.dot(q) / determinant;
                let along = v.dot(q) / determinant;
                let met = s >= 0.0 && t >= 0.0 && s + t <= 1.0 && (0.0..=1.0).contains(&along);
                if !met {
                    0
                } else if determinant > 0.0 {
                    1
                } else {
                    -1
                }
            })
            .sum()
    }

    fn shaded(caster: &Caster, lamp: DVec3, point: DVec3) -> bool {
        let whole = caster.whole(lamp, 0);
        let eye = DVec3::new(0.31, 40.0, 17.3);
        let mut all = whole.shell.clone();
        all.extend(&whole.towards);
        all.extend(whole.away.as_chunks::<3>().0.iter().flat_map(|[a, b, c]| [*a, *c, *b]));
        let z_pass = crossings(caster, &caster.sides(lamp, 0), lamp, eye, point);
        // The eye is outside the volume: the sides alone tell the same, whichever faces cast.
        let with_ends = crossings(caster, &all, lamp, eye, point);
        assert_eq!(z_pass > 0, with_ends > 0, "{point}");
        assert!(z_pass >= 0 && with_ends >= 0);
        z_pass > 0
    }

    #[test]
    fn closed_and_open_boxes_shade_what_is_behind_them() {
        let lamp = DVec3::new(0.4, 0.45, 5.0);
        for (inwards, open) in [(false, false), (true, false), (false, true), (true, true)] {
            let caster = caster(inwards, open);
            assert!(shaded(&caster, lamp, DVec3::new(0.5, 0.52, -0.7)));
            assert!(!shaded(&caster, lamp, DVec3::new(2.5, 0.5, -0.7)));
            assert!(!shaded(&caster, lamp, DVec3::new(0.5, 0.52, 2.0)));
        }
    }

    #[test]
    fn closed_boxes_have_half_the_sides() {
        let lamp = DVec3::new(0.4, 0.45, 5.0);
        let [closed, open] = [false, true].map(|open| caster(false, open).sides(lamp, 0).len() / 6);
        assert_eq!(closed, 4, "the top's four edges");
        assert!(open > 2 * closed - 2, "{open}");
    }

    #[test]
    fn a_lamp_inside_a_shell_shades_the_outside() {
        let lamp = DVec3::new(0.4, 0.45, 0.55);
        for inwards in [false, true] {
            let shell = caster(inwards, false);
            // Nothing has an edge here: the whole sphere is in shadow, which only its ends can tell.
            assert!(shell.sides(lamp, 0).is_empty());
            assert_eq!(shell.holds(lamp), !inwards);
        }
    }

    #[test]
    fn the_near_plane_is_in_the_volume_only_behind_the_caster() {
        let view = |eye: DVec3| View { eye, target: eye + DVec3::X, fov: 60.0 };
        let caster = caster(false, false);
        let lamp = DVec3::new(0.5, 0.5, 5.0);
        let may = |eye: DVec3| caster.may_shade_near_plane(lamp, &Camera::new(&view(eye), Up::Z, 1.5, 10.0));
        assert!(may(DVec3::new(0.5, 0.5, -2.0)));
        assert!(may(DVec3::new(0.5, 0.5, 0.5)), "inside the box");
        assert!(!may(DVec3::new(0.5, 0.5, 2.0)), "between lamp and box");
        assert!(!may(DVec3::new(3.0, 0.5, -2.0)), "beside");
    }
}
