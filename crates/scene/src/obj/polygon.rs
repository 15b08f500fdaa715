//! Polygons cut into triangles, whatever their shape.
//!
//! Convex quadrilaterals are halved from the first corner. All others are projected along the axis nearest to their
//! Newell normal (Sutherland et al. 1974; Tampieri, Graphics Gems III, V.5) and cut by ear clipping (the `earcut`
//! crate). Ear clipping drops corners that lie on a straight side of what is left, and may cut slivers there. The
//! triangle on the other side of such a corner then has it in the middle of a side, a crack that leaks light and breaks
//! silhouettes; so that triangle is split at the corner.

use std::collections::{BTreeMap, HashMap, HashSet};

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
    /// Appends the triangles of a polygon, as indices of its corners, in its winding. A polygon with area gives no
    /// triangle without area, one without area gives at least one of those, and a self-intersecting one gives triangles
    /// of no particular sense.
    pub fn cut(&mut self, corners: &[DVec3], out: &mut Vec<[u32; 3]>) {
        if corners.len() < 4 {
            if corners.len() == 3 {
                out.push([0, 1, 2]);
            }
            return;
        }
        // A corner repeated at once changes no shape.
        self.kept.clear();
        self.kept.extend((0..corners.len()).filter(|&i| corners[i] != corners[(i + 1) % corners.len()]).map(|i| i as u32));
        let kept = &self.kept;
        if kept.len() < 3 {
            out.push([0, 1, 2]);
            return;
        }
        let first = out.len();
        let place = |t: [u32; 3]| t.map(|i| corners[kept[i as usize] as usize]);
        if project(kept.iter().map(|&i| corners[i as usize]), &mut self.flat) && !convex_quad(&self.flat) {
            self.ears.earcut_slice(&self.flat, &[], &mut self.indices);
            out.extend(self.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]));
            let twice_area = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|i| DVec2::from(self.flat[i as usize]));
                (b - a).perp_dot(c - a)
            };
            // All or none: sides of neighbours must stay opposite, also at a sliver whose sign is rounding.
            if out[first..].iter().map(twice_area).sum::<f64>() < 0.0 {
                out[first..].iter_mut().for_each(|t| t.swap(1, 2));
            }
            add_dropped(kept.len() as u32, place, first, out);
        }
        if out.len() == first {
            out.extend((2..kept.len() as u32).map(|i| [0, i - 1, i]));
        }
        split_at_slivers(place, &mut out[first..]);
        if out[first..].iter().any(|&t| !has_no_area(place(t))) {
            let mut at = 0;
            out.retain(|&t| {
                at += 1;
                at <= first || !has_no_area(place(t))
            });
        }
        out[first..].iter_mut().for_each(|t| *t = t.map(|i| kept[i as usize]));
    }
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

/// Whether a counter-clockwise polygon is a quadrilateral that turns left at each corner.
fn convex_quad(flat: &[[f64; 2]]) -> bool {
    let at = |i: usize| DVec2::from(flat[i % 4]);
    flat.len() == 4 && (0..4).all(|i| (at(i + 1) - at(i)).perp_dot(at(i + 2) - at(i + 1)) > 0.0)
}

/// Appends flat triangles that close the cracks at dropped corners: loops of sides of the outline that no triangle has
/// and of sides of triangles that have no neighbour.
fn add_dropped(corners: u32, place: impl Fn([u32; 3]) -> [DVec3; 3], first: usize, out: &mut Vec<[u32; 3]>) {
    if out.len() - first + 2 == corners as usize {
        return;
    }
    let sides = |&[a, b, c]: &[u32; 3]| [(a, b), (b, c), (c, a)];
    let present: HashSet<(u32, u32)> = out[first..].iter().flat_map(sides).collect();
    let next = |i: u32| (i + 1) % corners;
    let bare = (0..corners).map(|i| (i, next(i))).filter(|side| !present.contains(side));
    let open = out[first..].iter().flat_map(sides).map(|(a, b)| (b, a));
    let open = open.filter(|&(b, a)| b != next(a) && !present.contains(&(b, a)));
    let mut missing: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (from, to) in bare.chain(open) {
        missing.entry(from).or_default().push(to);
    }
    for start in missing.keys().copied().collect::<Vec<_>>() {
        // A walk that comes back to a corner has closed a loop; what leads there may close another.
        let mut walk = vec![start];
        while let Some(&at) = walk.last() {
            let Some(onward) = missing.get_mut(&at).filter(|onward| !onward.is_empty()) else {
                walk.pop();
                continue;
            };
            // Where loops meet, stay on the line.
            let before = walk.iter().rev().nth(1);
            let straight = |&to: &u32| before.is_none_or(|&before| has_no_area(place([before, at, to])));
            let to = onward.swap_remove(onward.iter().position(straight).unwrap_or(0));
            let Some(back) = walk.iter().position(|&i| i == to) else {
                walk.push(to);
                continue;
            };
            let fan = walk[back..].windows(2).skip(1).map(|w| [to, w[0], w[1]]);
            // Only a self-intersecting outline leaves gaps that have area.
            if fan.clone().all(|t| has_no_area(place(t))) {
                out.extend(fan);
            }
            walk.truncate(back + 1);
        }
    }
}

/// Gives triangles without area some: with the neighbour across their longest side, which is split at the corner on
/// that side. Those without such a neighbour stay.
fn split_at_slivers(place: impl Fn([u32; 3]) -> [DVec3; 3], triangles: &mut [[u32; 3]]) {
    let mut slivers: Vec<usize> = (0..triangles.len()).filter(|&t| has_no_area(place(triangles[t]))).collect();
    if slivers.is_empty() {
        return;
    }
    // Directed sides; a triangle's neighbour runs along the same side the other way.
    let mut owner: HashMap<(u32, u32), usize> = HashMap::new();
    for (t, &[a, b, c]) in triangles.iter().enumerate() {
        owner.extend([((a, b), t), ((b, c), t), ((c, a), t)]);
    }
    // A sliver may wait for its neighbour, itself a sliver, to be mended.
    loop {
        let waiting = slivers.len();
        slivers.retain(|&t| {
            let [from, middle, to] = longest_side_last(triangles[t], &place);
            let Some(&other) = owner.get(&(from, to)) else { return true };
            let Some(apex) = triangles[other].into_iter().find(|&i| i != from && i != to) else { return true };
            let halves = [[from, middle, apex], [middle, to, apex]];
            if other == t || halves.iter().any(|&h| has_no_area(place(h))) {
                return true;
            }
            owner.remove(&(from, to));
            owner.remove(&(to, from));
            for (slot, half) in [(other, halves[0]), (t, halves[1])] {
                triangles[slot] = half;
                let [a, b, c] = half;
                owner.extend([((a, b), slot), ((b, c), slot), ((c, a), slot)]);
            }
            false
        });
        if slivers.is_empty() || slivers.len() == waiting {
            return;
        }
    }
}

/// The triangle turned until its longest side runs from its last corner to its first.
fn longest_side_last([a, b, c]: [u32; 3], place: impl Fn([u32; 3]) -> [DVec3; 3]) -> [u32; 3] {
    let turns = [[a, b, c], [b, c, a], [c, a, b]];
    let side = |t: [u32; 3]| {
        let [from, _, to] = place(t);
        (to * 0.5 - from * 0.5).length()
    };
    turns.into_iter().max_by(|&s, &t| side(s).total_cmp(&side(t))).unwrap_or([a, b, c])
}

#[cfg(test)]
#[path = "polygon_tests.rs"]
mod tests;
