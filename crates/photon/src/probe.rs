//! Irradiance at points of surfaces: direct light computed at the point itself, indirect light reconstructed from the buckets.

use crate::{
    irradiance::Irradiance,
    path,
    reconstruction::Reconstruction,
    triangle::{Hit, Ray},
    world::World,
};
use glam::DVec3;

/// What a probe reads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Direct irradiance of all lamps, lux per channel: candela · cos θ / d² where a shadow ray is free.
    pub direct: DVec3,
    /// Indirect irradiance, with its estimated standard error.
    pub indirect: Irradiance,
}

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
        if counts(id) && cosine > 0.0 && world.sees(above, id) {
            sum += configuration.lamp(id).candela(lamp.rotation.transpose() * -to_lamp) * (cosine / squared);
        }
    }
    sum
}

/// A point of a surface, seen from one side.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Metres.
    pub point: DVec3,
    /// Unit, on the side that counts.
    pub normal: DVec3,
    /// The element there; several where surfaces lie in one another.
    elements: Vec<Element>,
}

/// One side of a mesh element.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Element {
    object: usize,
    cell: u32,
    side: usize,
}

/// The mesh element at a point of a surface; unit `normal` chooses the side. `None` if no surface that faces along the normal is
/// within a thousandth of the scene's reach.
pub fn locate(world: &World, point: DVec3, normal: DVec3) -> Option<Place> {
    let near = f64::from(world.reach().metres) * 1e-3;
    // From just above: another surface may stand close over the point.
    for height in [near * 0.02, near * 0.2, near] {
        let from = (point + normal * height).as_vec3();
        let ray = Ray::new(from, -normal.as_vec3(), None, 0.0);
        let Some(hit) = world.nearest(&ray).filter(|h| f64::from(h.distance) <= height + near) else { continue };
        let front = |hit: &Hit| hit.triangle.normal.as_dvec3().dot(normal);
        if front(&hit).abs() < 0.5 {
            continue;
        }
        let element = |hit: &Hit| {
            let object = hit.triangle.object();
            Element { object, cell: path::cell(world, hit), side: usize::from(front(hit) < 0.0) }
        };
        return Some(Place { point, normal, elements: world.layers(&ray, hit).iter().map(element).collect() });
    }
    None
}

/// Reads the light at a place. `indirect` must stem from buckets of indirect light only.
pub fn read(world: &World, indirect: &Reconstruction, place: &Place) -> Reading {
    let mut sum = Irradiance::default();
    for (n, Element { object, cell, side }) in place.elements.iter().enumerate() {
        // A triangle that is listed twice has its light once.
        let same = |e: &Element| (e.object, e.side) == (*object, *side) && indirect.same_place(*object, e.cell, *cell);
        if !place.elements[..n].iter().any(same) {
            sum.add(&indirect.point(*object, *cell, *side, place.point));
        }
    }
    Reading { direct: direct(world, place.point, place.normal), indirect: sum }
}
