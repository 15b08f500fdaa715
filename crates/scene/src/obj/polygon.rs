//! Polygons cut into triangles, whatever their shape.
//!
//! Convex quadrilaterals are halved from the first corner. All others are projected along the axis nearest to their
//! Newell normal (Sutherland et al. 1974; Tampieri, Graphics Gems III, V.5) and cut by ear clipping (the `earcut`
//! crate). Ear clipping drops corners that lie on a straight side. A neighbour may use such a corner, and the crack
//! between them would leak light, so the triangle behind it is split there.

use std::collections::HashMap;

use earcut::Earcut;
use glam::{DVec2, DVec3};

/// Triangles with less than this times the square of their longest side have no area: rounding decides their normal.
const LEAST_AREA: f64 = 1e-14;

/// Whether a triangle is a point or a line.
pub fn has_no_area([a, b, c]: [DVec3; 3]) -> bool {
    // Halves and a common scale: neither the largest nor the smallest numbers may overflow.
    let sides = [b * 0.5 - a * 0.5, c * 0.5 - b * 0.5, a * 0.5 - c * 0.5];
    let scale = sides.iter().map(|s| s.abs().max_element()).fold(0.0, f64::max);
    if scale == 0.0 {
        return true;
    }
    let sides = sides.map(|s| s / scale);
    let longest = sides.iter().map(|s| s.length_squared()).fold(0.0, f64::max);
    0.5 * sides[0].cross(sides[1]).length() <= LEAST_AREA * longest
}

/// Cuts polygons; reuse it for its buffers.
#[derive(Default)]
pub struct Cutter {
    ears: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    kept: Vec<u32>,
    indices: Vec<u32>,
}

impl Cutter {
    /// Appends the triangles of a polygon, as indices of its corners, in its winding. A polygon without area gives at
    /// least one triangle without area; a self-intersecting one gives triangles of no particular sense.
    pub fn cut(&mut self, corners: &[DVec3], out: &mut Vec<[u32; 3]>) {
        if corners.len() < 4 {
            if corners.len() == 3 {
                out.push([0, 1, 2]);
            }
            return;
        }
        // A corner repeated at once changes no shape.
        self.kept.clear();
        self.kept.extend((0..corners.len() as u32).filter(|&i| {
            let next = (i as usize + 1) % corners.len();
            corners[i as usize] != corners[next]
        }));
        let kept = &self.kept;
        if kept.len() < 3 {
            out.push([0, 1, 2]);
            return;
        }
        let first = out.len();
        if !project(kept.iter().map(|&i| corners[i as usize]), &mut self.flat) {
            fan(kept, out);
            return;
        }
        if kept.len() < 4 || kept.len() == 4 && convex_quad(&self.flat) {
            fan(kept, out);
            return;
        }
        self.ears.earcut_slice(&self.flat, &[], &mut self.indices);
        let twice_area = |t: [u32; 3]| {
            let [a, b, c] = t.map(|i| DVec2::from(self.flat[i as usize]));
            (b - a).perp_dot(c - a)
        };
        out.extend(self.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]));
        // All or none: sides of neighbours must stay opposite, also at a sliver whose sign is rounding.
        if out[first..].iter().map(|&t| twice_area(t)).sum::<f64>() < 0.0 {
            out[first..].iter_mut().for_each(|t| t.swap(1, 2));
        }
        if out.len() == first {
            fan(kept, out);
            return;
        }
        add_dropped(kept.len() as u32, first, out);
        for t in &mut out[first..] {
            *t = t.map(|i| kept[i as usize]);
        }
        split_at_slivers(corners, first, out);
    }
}

/// All triangles from the first corner.
fn fan(corners: &[u32], out: &mut Vec<[u32; 3]>) {
    out.extend(corners[1..].windows(2).map(|w| [corners[0], w[0], w[1]]));
}

/// The polygon in two dimensions, counter-clockwise; false if it encloses no area in any direction. The axis nearest
/// to the normal is left out rather than turned upright: coordinates that agree in the file still agree.
fn project(corners: impl Iterator<Item = DVec3> + Clone, flat: &mut Vec<[f64; 2]>) -> bool {
    let Some(origin) = corners.clone().next() else { return false };
    let extent = corners.clone().map(|c| (c * 0.5 - origin * 0.5).abs().max_element()).fold(0.0, f64::max);
    if extent == 0.0 {
        return false;
    }
    // A power of two, so that scaling rounds nothing.
    let scale = (-extent.log2().floor()).clamp(-1000.0, 1000.0).exp2();
    let local = corners.map(|c| (c * 0.5 - origin * 0.5) * scale);
    let Some(last) = local.clone().last() else { return false };
    let (mut normal, mut previous) = (DVec3::ZERO, last);
    for corner in local.clone() {
        normal += previous.cross(corner);
        previous = corner;
    }
    let size = normal.abs();
    if size.max_element() <= LEAST_AREA {
        return false;
    }
    flat.clear();
    let (axis, negative) = if size.z >= size.x && size.z >= size.y {
        (2, normal.z < 0.0)
    } else if size.y >= size.x {
        (1, normal.y < 0.0)
    } else {
        (0, normal.x < 0.0)
    };
    flat.extend(local.map(|c| {
        let c = c.to_array();
        let (u, v) = (c[(axis + 1) % 3], c[(axis + 2) % 3]);
        if negative { [v, u] } else { [u, v] }
    }));
    true
}

/// Whether a counter-clockwise quadrilateral turns left at each corner.
fn convex_quad(flat: &[[f64; 2]]) -> bool {
    let at = |i: usize| DVec2::from(flat[i % 4]);
    (0..4).all(|i| (at(i + 1) - at(i)).perp_dot(at(i + 2) - at(i + 1)) > 0.0)
}

/// Appends a flat triangle for each corner that is in none, between its neighbours on the polygon.
fn add_dropped(corners: u32, first: usize, out: &mut Vec<[u32; 3]>) {
    let mut used = vec![false; corners as usize];
    for t in &out[first..] {
        t.iter().for_each(|&i| used[i as usize] = true);
    }
    let Some(start) = (0..corners).find(|&i| used[i as usize]) else { return };
    let (mut before, mut dropped) = (start, Vec::new());
    for i in (1..=corners).map(|k| (start + k) % corners) {
        if used[i as usize] {
            for middle in dropped.drain(..) {
                out.push([before, middle, i]);
                before = middle;
            }
            before = i;
        } else {
            dropped.push(i);
        }
    }
}

/// Removes triangles without area: the neighbour across the longest side is split at the corner that lies on it.
/// Those without such a neighbour stay.
fn split_at_slivers(corners: &[DVec3], first: usize, out: &mut [[u32; 3]]) {
    let place = |t: [u32; 3]| t.map(|i| corners[i as usize]);
    let mut slivers: Vec<usize> = (first..out.len()).filter(|&t| has_no_area(place(out[t]))).collect();
    if slivers.is_empty() {
        return;
    }
    // Directed sides; a triangle's neighbour runs along the same side the other way.
    let mut owner: HashMap<(u32, u32), usize> = HashMap::new();
    for (t, &[a, b, c]) in out.iter().enumerate().skip(first) {
        owner.extend([((a, b), t), ((b, c), t), ((c, a), t)]);
    }
    // A sliver may wait for its neighbour, itself a sliver, to be mended.
    loop {
        let waiting = slivers.len();
        slivers.retain(|&t| {
            let [a, b, c] = out[t];
            let length = |i: u32, j: u32| (corners[i as usize] * 0.5 - corners[j as usize] * 0.5).length();
            let (ab, bc, ca) = (length(a, b), length(b, c), length(c, a));
            let (from, middle, to) = if ca >= ab && ca >= bc {
                (a, b, c)
            } else if ab >= bc {
                (b, c, a)
            } else {
                (c, a, b)
            };
            let Some(&other) = owner.get(&(from, to)) else { return true };
            let Some(apex) = out[other].into_iter().find(|&i| i != from && i != to) else { return true };
            let halves = [[from, middle, apex], [middle, to, apex]];
            if other == t || halves.iter().any(|&h| has_no_area(place(h))) {
                return true;
            }
            for (slot, half) in [(other, halves[0]), (t, halves[1])] {
                out[slot] = half;
                let [a, b, c] = half;
                owner.extend([((a, b), slot), ((b, c), slot), ((c, a), slot)]);
            }
            owner.remove(&(from, to));
            owner.remove(&(to, from));
            false
        });
        if slivers.is_empty() || slivers.len() == waiting {
            return;
        }
    }
}

#[cfg(test)]
#[path = "polygon_tests.rs"]
mod tests;
