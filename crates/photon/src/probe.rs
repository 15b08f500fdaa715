//! Points of surfaces, and the direct light there.

use crate::{triangle::Ray, world::World};
use glam::DVec3;

/// Direct irradiance of all lamps at a point on the side of unit `normal`, lux per channel.
pub fn direct(world: &World, point: DVec3, normal: DVec3) -> DVec3 {
    direct_of(world, point, normal, |_| true)
}

/// As [`direct`], of the lamps that `counts` names.
pub fn direct_of(world: &World, point: DVec3, normal: DVec3, counts: impl Fn(usize) -> bool) -> DVec3 {
    let above = (point + normal * f64::from(world.reach().step_back()) * 4.0).as_vec3();
    let mut sum = DVec3::ZERO;
    let configuration = world.configuration();
    for (id, _) in configuration.lamps() {
        let lamp = &world.lamps()[id];
        let to_lamp = lamp.position - point;
        let squared = to_lamp.length_squared();
        let cosine = to_lamp.dot(normal) / squared.sqrt();
        if !counts(id) || cosine <= 0.0 {
            continue;
        }
        // Where a lamp does not shine nothing is asked of the trees.
        let candela = configuration.lamp(id).candela(lamp.rotation.transpose() * -to_lamp);
        if candela != DVec3::ZERO && world.sees(above, id) {
            sum += candela * (cosine / squared);
        }
    }
    sum
}

/// A point of a surface, seen from one side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Metres.
    pub point: DVec3,
    /// Unit, on the side that counts.
    pub normal: DVec3,
}

/// The place at a point of a surface; unit `normal` chooses the side. `None` if no surface that faces along the normal is
/// within a thousandth of the scene's reach.
pub fn locate(world: &World, point: DVec3, normal: DVec3) -> Option<Place> {
    let near = f64::from(world.reach().metres) * 1e-3;
    // From just above: another surface may stand close over the point.
    for height in [near * 0.02, near * 0.2, near] {
        let from = (point + normal * height).as_vec3();
        let ray = Ray::new(from, -normal.as_vec3(), None, 0.0);
        let Some(hit) = world.nearest(&ray).filter(|h| f64::from(h.distance) <= height + near) else { continue };
        if hit.triangle.normal.as_dvec3().dot(normal).abs() >= 0.5 {
            return Some(Place { point, normal });
        }
    }
    None
}
