//! What is under the pointer, by rays through the photons' trees.

use glam::{DMat3, DVec2, DVec3};
use lightmend_photon::{triangle::Ray, world::World};
use lightmend_raster::camera::Camera;
use lightmend_scene::{Configuration, Motion};

/// A ray into the scene: from the eye through the pointer.
#[derive(Debug, Clone, Copy)]
pub struct Sight {
    /// Metres.
    pub from: DVec3,
    /// Unit.
    pub along: DVec3,
}

impl Sight {
    /// Through a point of the picture, from −1 to 1 to the right and upwards; beyond that outside of it.
    pub fn new(camera: &Camera, at: DVec2) -> Sight {
        Sight { from: camera.eye, along: camera.ray(at).normalize() }
    }

    /// Where it meets the plane through `point` with this `normal`; `None` if that is behind, or too oblique to mean anything.
    pub fn on_plane(&self, point: DVec3, normal: DVec3) -> Option<DVec3> {
        let across = self.along.dot(normal);
        let distance = (point - self.from).dot(normal) / across;
        (across.abs() > 0.01 && distance > 0.0).then(|| self.from + self.along * distance)
    }
}

/// What a ray meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Met {
    /// Its number.
    pub object: usize,
    /// Metres.
    pub point: DVec3,
    /// Unit, towards where the ray comes from.
    pub normal: DVec3,
    /// Metres.
    pub distance: f64,
}

/// Surfaces that lie behind one another more often than this are no room.
const MOST_LAYERS: usize = 1000;

/// The first surface that a ray meets of objects that are not to be skipped.
pub fn meet(world: &World, sight: Sight, skip: impl Fn(usize) -> bool) -> Option<Met> {
    let along = sight.along.as_vec3();
    let mut ray = Ray::new(sight.from.as_vec3(), along, None, 0.0);
    for _ in 0..MOST_LAYERS {
        let hit = world.nearest(&ray)?;
        let object = hit.triangle.object();
        let point = hit.triangle.point(hit.weights);
        if !skip(object) {
            let normal = hit.triangle.normal.as_dvec3();
            let normal = if normal.dot(sight.along) > 0.0 { -normal } else { normal };
            let point = point.as_dvec3();
            return Some(Met { object, point, normal, distance: (point - sight.from).length() });
        }
        ray = Ray::new(point, along, Some(hit.triangle), world.reach().step_back());
    }
    None
}

/// What a person means who points at an object: the nearest of it and its carriers that can be moved; the object itself if none can.
pub fn meant(configuration: &Configuration, object: usize) -> usize {
    let mut at = Some(object);
    while let Some(id) = at {
        if configuration.object(id).movable {
            return id;
        }
        at = configuration.object(id).carrier;
    }
    object
}

/// The box about an object, in the world, metres.
pub fn bounds(configuration: &Configuration, id: usize) -> [DVec3; 2] {
    let motion = configuration.object_motion(id);
    let positions = &configuration.object(id).mesh.positions;
    let mut corners = positions.iter().map(|p| motion.point(*p));
    let first = corners.next().unwrap_or(motion.translation);
    corners.fold([first, first], |[low, high], p| [low.min(p), high.max(p)])
}

/// Where its carrier is; the world's origin if nothing carries it.
pub fn carrier_motion(configuration: &Configuration, carrier: Option<usize>) -> Motion {
    carrier.map_or(Motion { rotation: DMat3::IDENTITY, translation: DVec3::ZERO }, |carrier| configuration.object_motion(carrier))
}
