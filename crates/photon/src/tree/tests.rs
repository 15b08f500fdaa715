//! Whatever the lanes, the tree and the order of visits: the same hits, and none missed.

use super::*;
use crate::{
    body::{Body, Reach, TreePreset},
    lanes::{Portable, Task, widest},
    world::World,
};
use glam::Vec3;
use glam::vec3;
use lightmend_scene::{Configuration, Scene};
use rayon::prelude::*;

struct First<'t, 'r>(&'t Body, &'r Ray<'r>);

impl<'t> Task for First<'t, '_> {
    type Output = Option<Hit<'t>>;
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Option<Hit<'t>> {
        let mut best = None;
        self.0.nearest(&Beam::new(lanes, self.1), &mut Stack::new(), &mut best);
        best
    }
}

/// Number `n` of a sequence of numbers in [0, 1).
fn random(n: u64) -> f32 {
    (crate::hash::mix(n) >> 40) as f32 / (1u64 << 24) as f32
}

fn point(n: u64) -> Vec3 {
    vec3(random(3 * n), random(3 * n + 1), random(3 * n + 2))
}

/// The bits of a hit; zeros without their sign.
fn bits(hit: Option<Hit>) -> Option<(u32, [u32; 3], (u64, u32))> {
    hit.map(|hit| (hit.distance.to_bits(), hit.weights.map(|w| (w + 0.0).to_bits()), hit.triangle.order()))
}

/// A closed surface: a cube of side 2 about the origin, 16 × 16 squares to a side, its points moved by `shape`.
fn closed(shape: impl Fn(Vec3) -> Vec3) -> Vec<Triangle> {
    let n = 16;
    let mut triangles = Vec::new();
    for side in 0..6 {
        let (axis, sign) = (side % 3, if side < 3 { -1.0 } else { 1.0 });
        let at = |u: usize, v: usize| {
            let mut p = Vec3::splat(sign);
            p[(axis + 1) % 3] = u as f32 / 8.0 - 1.0;
            p[(axis + 2) % 3] = v as f32 / 8.0 - 1.0;
            shape(p)
        };
        for (u, v) in (0..n).flat_map(|u| (0..n).map(move |v| (u, v))) {
            for corners in [[at(u, v), at(u + 1, v), at(u + 1, v + 1)], [at(u, v), at(u + 1, v + 1), at(u, v + 1)]] {
                triangles.push(Triangle::new(corners, 7, 0, triangles.len()));
            }
        }
    }
    triangles
}

fn bumpy(p: Vec3) -> Vec3 {
    p.normalize() * (1.0 + 0.1 * (7.0 * p.x).sin() * (5.0 * p.y).cos() + 0.05 * p.z)
}

fn world_of(scene: &str) -> World {
    let path = format!("{}/../../scenes/{scene}/{scene}.ron", env!("CARGO_MANIFEST_DIR"));
    World::new(&Configuration::initial(&Scene::read(path.as_ref()).unwrap().0), TreePreset::default())
}

#[test]
fn portable_and_wide_lanes_meet_the_same() {
    for scene in ["room", "house"] {
        let world = world_of(scene);
        let lamp = world.lamps()[0].position.as_vec3();
        let met: usize = (0..500_000u64)
            .into_par_iter()
            .map(|n| {
                let origin = lamp + 4.0 * (point(2 * n) - 0.5) * vec3(1.0, 1.0, 0.25);
                let ray = Ray::new(origin, point(2 * n + 1) - 0.5, None, 0.0);
                let hit = bits(world.nearest(&ray));
                assert_eq!(hit, bits(world.nearest_portably(&ray)), "{scene}, ray {n}");
                usize::from(hit.is_some())
            })
            .sum();
        assert!(met > 250_000, "{scene}: {met}");
    }
}

#[test]
fn a_closed_surface_lets_nothing_out() {
    for away in [Vec3::ZERO, vec3(1000.0, -700.0, 0.0)] {
        for shape in [(|p| p) as fn(Vec3) -> Vec3, bumpy] {
            let triangles = closed(|p| shape(p) + away);
            let body = Body::new(triangles.clone(), Reach::new(away.length() + 2.0), TreePreset::Medium);
            let escapes: usize = triangles
                .par_iter()
                .enumerate()
                .map(|(n, triangle)| {
                    let mut escapes = 0;
                    for start in 0..10 {
                        let origin = (point(start) - 0.5) * 0.8 + away;
                        for k in 0..3 {
                            let (a, b) = (triangle.corners[k], triangle.corners[(k + 1) % 3]);
                            for along in [0.0, 0.5, random((n * 30 + k) as u64 + start)] {
                                let ray = Ray::new(origin, a.lerp(b, along) - origin, None, 0.0);
                                escapes += usize::from(widest(First(&body, &ray)).is_none());
                            }
                        }
                    }
                    escapes
                })
                .sum();
            assert_eq!(escapes, 0, "of {} rays", triangles.len() * 90);
        }
    }
}

/// A million rays from about the lamps of each closed scene at every corner, the middle and another point of every edge; also a kilometre away.
#[test]
fn closed_scenes_let_nothing_out() {
    for scene in ["cornell", "room", "house"] {
        let world = world_of(scene);
        // Nothing has moved: all is in one tree.
        let home = world.still().triangles();
        for away in [Vec3::ZERO, vec3(1000.0, -700.0, 300.0)] {
            let moved = |t: &Triangle| Triangle { corners: t.corners.map(|corner| corner + away), ..*t };
            let triangles: Vec<Triangle> = home.iter().map(moved).collect();
            let body = Body::new(triangles.clone(), Reach::new(away.length() + world.reach().metres), TreePreset::Medium);
            let starts = 1_000_000u64.div_ceil(9 * triangles.len() as u64);
            let escapes: usize = (0..starts * triangles.len() as u64)
                .into_par_iter()
                .map(|n| {
                    let (start, triangle) = (n % starts, &triangles[(n / starts) as usize]);
                    let lamps = world.lamps();
                    let lamp = lamps[start as usize % lamps.len()].position.as_vec3() + away;
                    let origin = if (start as usize) < lamps.len() { lamp } else { lamp + (point(start) - 0.5) * 0.04 };
                    let mut escapes = 0;
                    for k in 0..3 {
                        let (a, b) = (triangle.corners[k], triangle.corners[(k + 1) % 3]);
                        for along in [0.0, 0.5, random(3 * n + k as u64)] {
                            let ray = Ray::new(origin, a.lerp(b, along) - origin, None, 0.0);
                            escapes += usize::from(widest(First(&body, &ray)).is_none());
                        }
                    }
                    escapes
                })
                .sum();
            assert_eq!(escapes, 0, "{scene}, {away} away, of {} rays", starts * 9 * triangles.len() as u64);
        }
    }
}

#[test]
fn the_nearest_is_that_of_all() {
    // A bumpy shell, a flat one, all of it twice, and splinters.
    let mut triangles = closed(bumpy);
    triangles.retain(|t| t.in_mesh % 8 == 0);
    triangles.extend(closed(|p| p * 0.5).into_iter().step_by(9));
    triangles.extend((0..200).map(|n| Triangle::new([point(9000 + n), point(9500 + n), point(9700 + n)], 3, 0, 0)));
    triangles.extend(triangles.clone());
    for (n, triangle) in triangles.iter_mut().enumerate() {
        *triangle = Triangle { key: 5 + n as u64 % 3, object: 1, in_mesh: n as u32, ..*triangle };
    }
    let bodies = [TreePreset::Fast, TreePreset::Medium].map(|preset| Body::new(triangles.clone(), Reach::new(2.0), preset));
    let odd = [-0.0, 0.0, 1.0, -1.0, 1e-30, -1e-38, 0.5];
    (0..30_000u64).into_par_iter().for_each(|n| {
        let pick = |k: u64| odd[(random(n * 5 + k) * 7.0) as usize];
        let mut direction = if n % 2 == 0 { vec3(pick(0), pick(1), pick(2)) } else { point(n) - 0.5 };
        if direction.abs().max_element() < 1e-6 {
            direction[n as usize / 2 % 3] = -0.5;
        }
        // On the grid of the flat shell, so that edges and corners are met, or anywhere.
        let origin = if n % 3 == 0 { (point(n + 7) * 16.0).round() / 16.0 - 0.5 } else { point(n + 7) * 2.0 - 1.0 };
        let leaves = (n % 5 == 0).then(|| &triangles[n as usize % triangles.len()]);
        let ray = Ray::new(origin, direction, leaves, 1e-4);
        let all = triangles.iter().fold(None, |best, triangle| ray.meet(triangle, &best).or(best));
        for body in &bodies {
            assert_eq!(bits(First(body, &ray).run(Portable)), bits(all), "ray {n}: {origin} {direction}");
            assert_eq!(bits(widest(First(body, &ray))), bits(all), "ray {n}: {origin} {direction}");
        }
    });
}

#[test]
fn a_tree_of_equal_boxes_ends() {
    let one = Triangle::new([Vec3::ZERO, Vec3::X, Vec3::Y], 0, 0, 0);
    let triangles: Vec<Triangle> = (0..10_000).map(|n| Triangle { in_mesh: n, ..one }).rev().collect();
    for preset in [TreePreset::Fast, TreePreset::Medium] {
        let body = Body::new(triangles.clone(), Reach::new(1.0), preset);
        let ray = Ray::new(vec3(0.25, 0.25, 1.0), -Vec3::Z, None, 0.0);
        assert_eq!(widest(First(&body, &ray)).unwrap().triangle.in_mesh, 0);
        let none = Body::new(Vec::new(), Reach::new(1.0), preset);
        assert!(widest(First(&none, &ray)).is_none());
    }
}
