//! The few shapes that furniture is made of: boxes on a grid, soft boxes, turned bodies, lofts and tubes.
//!
//! Long thin parts are cut across. A triangle of longest edge e is cut into ⌈e / cell⌉² mesh elements, so a sliver of 2 m × 2 cm
//! would cost as many elements as a square of 2 m; cut into short pieces it costs one element a piece and side.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::solid::{Solid, v};

/// The element size that parts are cut for, metres: that of the room.
pub const CELL: f64 = 0.5;

/// The surface of a box whose faces are cut at the given coordinates along x, y and z (each ascending, at least two).
pub fn grid_box(xs: &[f64], ys: &[f64], zs: &[f64]) -> Solid {
    let axes = [xs, ys, zs];
    let mut index: BTreeMap<[usize; 3], usize> = BTreeMap::new();
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for axis in 0..3 {
        let (u, w) = ((axis + 1) % 3, (axis + 2) % 3);
        for far in [false, true] {
            for i in 0..axes[u].len() - 1 {
                for j in 0..axes[w].len() - 1 {
                    let mut corner = |di: usize, dj: usize| {
                        let mut key = [0; 3];
                        key[axis] = if far { axes[axis].len() - 1 } else { 0 };
                        key[u] = i + di;
                        key[w] = j + dj;
                        *index.entry(key).or_insert_with(|| {
                            points.push(v(xs[key[0]], ys[key[1]], zs[key[2]]));
                            points.len() - 1
                        })
                    };
                    let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                    let quad = if far { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                    triangles.extend(quad);
                }
            }
        }
    }
    Solid { material: "", points, uv: Vec::new(), triangles }
}

/// The surface of those cells of a grid whose middle `filled` accepts. No two of them may touch along an edge or a corner only.
pub fn grid_solid(xs: &[f64], ys: &[f64], zs: &[f64], filled: impl Fn(DVec3) -> bool) -> Solid {
    let axes = [xs, ys, zs];
    let counts = axes.map(|a| a.len() as i64 - 1);
    let full = |cell: [i64; 3]| {
        (0..3).all(|a| (0..counts[a]).contains(&cell[a]))
            && filled(DVec3::from_array([0, 1, 2].map(|a| {
                let i = cell[a] as usize;
                (axes[a][i] + axes[a][i + 1]) / 2.0
            })))
    };
    let mut index: BTreeMap<[i64; 3], usize> = BTreeMap::new();
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for (i, j, k) in (0..counts[0]).flat_map(|i| (0..counts[1]).flat_map(move |j| (0..counts[2]).map(move |k| (i, j, k)))) {
        let cell = [i, j, k];
        if !full(cell) {
            continue;
        }
        for axis in 0..3 {
            for far in [0, 1] {
                let mut neighbour = cell;
                neighbour[axis] += 2 * far - 1;
                if full(neighbour) {
                    continue;
                }
                let mut corner = |du: i64, dw: i64| {
                    let mut key = cell;
                    key[axis] += far;
                    key[(axis + 1) % 3] += du;
                    key[(axis + 2) % 3] += dw;
                    *index.entry(key).or_insert_with(|| {
                        points.push(v(xs[key[0] as usize], ys[key[1] as usize], zs[key[2] as usize]));
                        points.len() - 1
                    })
                };
                let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                triangles.extend(if far == 1 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
            }
        }
    }
    Solid { material: "", points, uv: Vec::new(), triangles }
}

/// `n` equal steps from `a` to `b`: `n` + 1 coordinates.
pub fn steps(a: f64, b: f64, n: usize) -> Vec<f64> {
    (0..=n).map(|i| a + (b - a) * i as f64 / n as f64).collect()
}

/// Of the bodies that `build` makes when cut into so many pieces along x, y and z, the one of fewest mesh elements, then triangles.
fn cheapest(size: DVec3, build: impl Fn([usize; 3]) -> Solid) -> Solid {
    let most = size.to_array().map(|s| (s / CELL).ceil() as usize * 2);
    let mut best = build([1; 3]);
    let mut cost = (best.cells(CELL), best.triangles.len());
    for x in 1..=most[0] {
        for y in 1..=most[1] {
            for z in 1..=most[2] {
                let other = build([x, y, z]);
                let other_cost = (other.cells(CELL), other.triangles.len());
                if other_cost < cost {
                    (best, cost) = (other, other_cost);
                }
            }
        }
    }
    best
}

/// A box from `min` to `max`, metres, cut so that it costs the fewest mesh elements.
pub fn block(min: DVec3, max: DVec3) -> Solid {
    cheapest(max - min, |n| grid_box(&steps(min.x, max.x, n[0]), &steps(min.y, max.y, n[1]), &steps(min.z, max.z, n[2])))
}

/// A box whose edges are cut off at 45 degrees, `edge` metres from each side, cut so that it costs the fewest mesh elements.
pub fn soft_block(min: DVec3, max: DVec3, edge: f64) -> Solid {
    cheapest(max - min, |n| cut_soft_block(min, max, edge, n))
}

/// As [`soft_block`], its flat parts cut into `n` pieces along each axis: for bodies that are bent afterwards.
pub fn cut_soft_block(min: DVec3, max: DVec3, edge: f64, n: [usize; 3]) -> Solid {
    let cuts = [0, 1, 2].map(|a| steps(min[a] + edge, max[a] - edge, n[a]));
    let mut points = Vec::new();
    let mut index = BTreeMap::new();
    // A point of the face on side `side[axis]` of `axis`: its place among the cuts of the other two axes.
    let mut at = |axis: usize, far: bool, place: [usize; 3]| {
        *index.entry((axis, far, place)).or_insert_with(|| {
            let mut p = DVec3::from_array([0, 1, 2].map(|a| cuts[a][place[a]]));
            p[axis] = if far { max[axis] } else { min[axis] };
            points.push(p);
            points.len() - 1
        })
    };
    let end = |axis: usize, far: bool| if far { n[axis] } else { 0 };
    let mut polygons: Vec<Vec<usize>> = Vec::new();
    let sides = [false, true];
    for axis in 0..3 {
        let (u, w) = ((axis + 1) % 3, (axis + 2) % 3);
        let place = |i: usize, j: usize| {
            let mut place = [0; 3];
            place[u] = i;
            place[w] = j;
            place
        };
        for far in sides {
            for i in 0..n[u] {
                for j in 0..n[w] {
                    polygons.push([(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| at(axis, far, place(i + a, j + b))).to_vec());
                }
            }
            // The strip along `w` between this face and that of `u`.
            for far_u in sides {
                for k in 0..n[w] {
                    let (on_this, on_that) = (
                        |k| place(end(u, far_u), k),
                        |k| {
                            let mut place = [0; 3];
                            place[axis] = end(axis, far);
                            place[w] = k;
                            place
                        },
                    );
                    polygons.push(vec![
                        at(axis, far, on_this(k)),
                        at(axis, far, on_this(k + 1)),
                        at(u, far_u, on_that(k + 1)),
                        at(u, far_u, on_that(k)),
                    ]);
                }
            }
        }
    }
    for corner in 0..8 {
        let far = [corner & 1 != 0, corner & 2 != 0, corner & 4 != 0];
        let place = [0, 1, 2].map(|a| end(a, far[a]));
        polygons.push(
            [0, 1, 2]
                .map(|axis| {
                    let mut place = place;
                    place[axis] = 0;
                    at(axis, far[axis], place)
                })
                .to_vec(),
        );
    }
    // The body is convex: outwards is away from its middle.
    let middle = (min + max) / 2.0;
    let mut triangles = Vec::new();
    for polygon in polygons {
        for i in 1..polygon.len() - 1 {
            let t = [polygon[0], polygon[i], polygon[i + 1]];
            let [a, b, c] = t.map(|i| points[i]);
            triangles.push(if (b - a).cross(c - a).dot(a - middle) > 0.0 { t } else { [t[0], t[2], t[1]] });
        }
    }
    Solid { material: "", points, uv: Vec::new(), triangles }
}

/// A cushion of `x` × `y` × `z` metres, thick in the middle and thin at its seams, its middle at the origin.
pub fn cushion(x: f64, y: f64, z: f64) -> Solid {
    grid_box(&steps(-1.0, 1.0, 4), &steps(-1.0, 1.0, 4), &[-1.0, 1.0]).map(|p| {
        // Sampled at equal steps the crown would be a ridge: the power makes it broad.
        let swell = 0.12 + 0.88 * ((1.0 - p.x.abs().powi(4)) * (1.0 - p.y.abs().powi(4))).sqrt();
        let pull = |a: f64, b: f64| a * (1.0 - 0.07 * (1.0 - b.powi(2)) * a.powi(2));
        v(x / 2.0 * pull(p.x, p.y), y / 2.0 * pull(p.y, p.x), z / 2.0 * p.z * swell)
    })
}

/// Joins rings of equal length, each counter-clockwise seen from the end, and closes both ends (the rings at the ends are convex).
pub fn loft(rings: &[Vec<DVec3>]) -> Solid {
    let n = rings[0].len();
    let mut triangles = wall(rings.len() - 1, n, rings.len());
    let last = (rings.len() - 1) * n;
    for i in 1..n - 1 {
        triangles.push([0, i + 1, i]);
        triangles.push([last, last + i, last + i + 1]);
    }
    Solid { material: "", points: rings.concat(), uv: Vec::new(), triangles }
}

/// The quads between `bands` pairs of successive rings of `n` points; the ring after the last of `count` is the first.
fn wall(bands: usize, n: usize, count: usize) -> Vec<[usize; 3]> {
    let mut triangles = Vec::new();
    for band in 0..bands {
        let (low, high) = (band * n, (band + 1) % count * n);
        for i in 0..n {
            let j = (i + 1) % n;
            triangles.push([low + i, low + j, high + j]);
            triangles.push([low + i, high + j, high + i]);
        }
    }
    triangles
}

fn circle(radius: f64, z: f64, n: usize) -> Vec<DVec3> {
    (0..n)
        .map(|i| {
            let (s, c) = (std::f64::consts::TAU * (i as f64 + 0.5) / n as f64).sin_cos();
            v(radius * c, radius * s, z)
        })
        .collect()
}

/// A body turned about the z axis: `profile` holds (radius, height) in metres, from the lower end up the outside; both ends are
/// closed by a point on the axis.
pub fn lathe(profile: &[(f64, f64)], n: usize) -> Solid {
    let rings: Vec<_> = profile.iter().map(|&(r, z)| circle(r, z, n)).collect();
    let mut triangles = wall(rings.len() - 1, n, rings.len());
    let mut points = rings.concat();
    let (bottom, top) = (points.len(), points.len() + 1);
    points.push(v(0.0, 0.0, profile[0].1));
    points.push(v(0.0, 0.0, profile[profile.len() - 1].1));
    let last = (rings.len() - 1) * n;
    for i in 0..n {
        let j = (i + 1) % n;
        triangles.push([bottom, j, i]);
        triangles.push([top, last + i, last + j]);
    }
    Solid { material: "", points, uv: Vec::new(), triangles }
}

/// A hollow body turned about the z axis, open along it: `profile` is a closed line, up the outside and down the inside.
pub fn hollow(profile: &[(f64, f64)], n: usize) -> Solid {
    let rings: Vec<_> = profile.iter().map(|&(r, z)| circle(r, z, n)).collect();
    Solid { material: "", triangles: wall(rings.len(), n, rings.len()), points: rings.concat(), uv: Vec::new() }
}

/// A ball of `radius` metres about the origin.
pub fn ball(radius: f64) -> Solid {
    let ring = |degrees: f64| (radius * degrees.to_radians().cos(), radius * degrees.to_radians().sin());
    let mut s = lathe(&[-48.0, 0.0, 48.0].map(ring), 8);
    // The poles of a lathe lie in the plane of its last ring; those of a ball do not.
    let n = s.points.len();
    s.points[n - 2].z = -radius;
    s.points[n - 1].z = radius;
    s
}

/// A round bar of `radius` metres along `path`, which bends in the plane that `side` stands upright on.
pub fn tube(path: &[DVec3], side: DVec3, radius: f64, n: usize) -> Solid {
    let rings: Vec<_> = (0..path.len())
        .map(|i| {
            let along = (path[(i + 1).min(path.len() - 1)] - path[i.saturating_sub(1)]).normalize();
            let out = side.cross(along);
            circle(radius, 0.0, n).iter().map(|q| path[i] + out * q.x + side * q.y).collect()
        })
        .collect();
    loft(&rings)
}

/// A square leg from `foot` to `top`, whose sides grow from `a` to `b` metres.
pub fn leg(foot: DVec3, top: DVec3, a: f64, b: f64) -> Solid {
    let n = (foot.distance(top) / (CELL - 0.02)).ceil() as usize;
    let rings: Vec<_> = (0..=n)
        .map(|i| {
            let t = i as f64 / n as f64;
            let (p, h) = (foot.lerp(top, t), (a + (b - a) * t) / 2.0);
            [(-h, -h), (h, -h), (h, h), (-h, h)].map(|(x, y)| p + v(x, y, 0.0)).to_vec()
        })
        .collect();
    loft(&rings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shape_is_closed_and_faces_outwards() {
        let shapes = [
            block(v(0.0, 0.0, 0.0), v(2.0, 0.02, 0.3)),
            soft_block(v(-1.0, 0.0, 0.0), v(1.0, 1.0, 0.3), 0.05),
            cushion(0.6, 0.4, 0.15),
            lathe(&[(0.1, 0.0), (0.2, 0.5)], 8),
            hollow(&[(0.2, 0.0), (0.2, 0.3), (0.19, 0.3), (0.19, 0.0)], 8),
            ball(0.04),
            tube(&[v(0.0, 0.0, 0.0), v(0.0, 0.0, 1.0), v(0.3, 0.0, 1.2)], v(0.0, 1.0, 0.0), 0.01, 6),
            leg(v(0.0, 0.0, 0.0), v(0.1, 0.0, 0.7), 0.03, 0.05),
            // An L: the cell in its corner is left out.
            grid_solid(&[0.0, 1.0, 3.0], &[0.0, 2.0, 3.0], &[0.0, 1.0], |p| p.x < 1.0 || p.y < 2.0),
        ];
        for (i, s) in shapes.iter().enumerate() {
            assert_eq!(s.defect(), None, "shape {i}");
            assert!(s.volume() > 0.0, "shape {i}");
        }
    }

    #[test]
    fn a_ball_has_nearly_the_volume_of_a_sphere() {
        let sphere = 4.0 / 3.0 * std::f64::consts::PI;
        assert!((ball(1.0).volume() / sphere - 0.77).abs() < 0.1);
    }
}
