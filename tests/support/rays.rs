//! What rays say: which point a pixel sees, and whether a lamp is in sight of it.
//!
//! Most of it is asked of the photons' own world, in single precision. Where that and the mask disagree, every triangle is asked
//! again in double precision.

use glam::{DVec2, DVec3};
use lightmend_photon::{
    body::TreePreset,
    triangle::{Ray, Triangle},
    world::World,
};
use lightmend_raster::{bounds::Bounds, camera::Camera};
use lightmend_scene::Configuration;

/// A point of a surface, seen by the camera.
#[derive(Debug, Clone, Copy)]
pub struct Sight {
    /// Metres.
    pub point: DVec3,
    /// Unit, on the side that is seen.
    pub normal: DVec3,
    /// Object and triangle.
    pub of: (usize, usize),
}

/// An object's triangles in the world.
struct Surface {
    bounds: Bounds,
    corners: Vec<[DVec3; 3]>,
}

/// A configuration, for rays.
pub struct Rays {
    /// As photons see it.
    pub world: World,
    /// By object number.
    surfaces: Vec<Surface>,
}

impl Rays {
    /// Of a configuration.
    pub fn new(configuration: &Configuration) -> Rays {
        let surface = |id: usize| {
            let motion = configuration.object_motion(id);
            let mesh = &configuration.object(id).mesh;
            // Rounded as photons' rays and the rasteriser have them.
            let positions: Vec<DVec3> = mesh.positions.iter().map(|p| motion.point(*p).as_vec3().as_dvec3()).collect();
            let corners = mesh.triangles.iter().map(|t| t.map(|i| positions[i as usize])).collect();
            Surface { bounds: Bounds::about(positions.into_iter()), corners }
        };
        let surfaces = (0..configuration.object_slots()).map(surface).collect();
        Rays { world: World::new(configuration, TreePreset::default()), surfaces }
    }

    fn reach(&self) -> f64 {
        f64::from(self.world.reach().metres)
    }

    /// How near two surfaces touch: a few roundings of the largest coordinate.
    fn touch(&self) -> f64 {
        1e-6 * self.reach()
    }

    /// Where lamp `id` hangs.
    pub fn lamp(&self, id: usize) -> DVec3 {
        self.world.lamps()[id].position
    }

    /// The first surface that the camera sees at a place of the picture.
    pub fn first(&self, camera: &Camera, at: DVec2) -> Option<(usize, usize)> {
        let direction = camera.ray(at).as_vec3();
        let mut ray = Ray::new((camera.eye + camera.ray(at) * camera.near).as_vec3(), direction, None, 0.0);
        loop {
            let hit = self.world.nearest(&ray)?;
            if !self.world.object(hit.triangle.object()).hidden_from_camera {
                return Some((hit.triangle.object(), hit.triangle.in_mesh()));
            }
            let step = self.world.reach().step_back();
            ray = Ray::new(hit.triangle.point(hit.weights), direction, Some(hit.triangle), step);
        }
    }

    /// Where the camera's ray meets a triangle's plane. Nothing for triangles without a normal.
    ///
    /// The rasteriser's corners lie on a grid of 1/256 of a pixel, so a pixel may see a triangle that its ray just misses. Then it is
    /// the nearest point of the triangle.
    pub fn sight(&self, camera: &Camera, at: DVec2, of: (usize, usize)) -> Option<Sight> {
        let [a, b, c] = self.surfaces[of.0].corners[of.1];
        let (u, v) = (b - a, c - a);
        let normal = u.cross(v).try_normalize()?;
        let ray = camera.ray(at);
        let normal = if normal.dot(ray) > 0.0 { -normal } else { normal };
        let (s, p) = (camera.eye - a, ray.cross(v));
        let determinant = u.dot(p);
        let weights =
            if determinant == 0.0 { DVec2::splat(1.0 / 3.0) } else { DVec2::new(s.dot(p), ray.dot(s.cross(u))) / determinant };
        let inside = weights.max(DVec2::ZERO);
        let inside = inside / f64::max(1.0, inside.x + inside.y);
        Some(Sight { point: a + u * inside.x + v * inside.y, normal, of })
    }

    /// Whether the lamp is in sight of a point, but for rounding.
    pub fn sees(&self, sight: &Sight, lamp: DVec3) -> bool {
        let step = self.world.reach().step_back();
        let above = (sight.point + sight.normal * f64::from(step)).as_vec3();
        let corners = self.surfaces[sight.of.0].corners[sight.of.1].map(|c| c.as_vec3());
        let own = Triangle::new(corners, 0, sight.of.0, sight.of.1);
        let ray = Ray::new(above, lamp.as_vec3() - above, Some(&own), step);
        self.world.nearest(&ray).is_none_or(|hit| hit.distance >= 1.0)
    }

    /// Points of the plane of `sight` which triangles shade that the way from the lamp to it just misses: shadows too thin to be found
    /// by looking here and there.
    pub fn shaded_nearby(&self, sight: &Sight, lamp: DVec3) -> Vec<DVec3> {
        let way = sight.point - lamp;
        let near = |[a, b, c]: [DVec3; 3]| {
            let middle = (a + b + c) / 3.0;
            [(a, b), (b, c), (c, a)].map(|(from, to)| {
                // The edge's nearest point to the way (both as lines), and a little into the triangle.
                let (u, s) = (to - from, lamp - from);
                let (uu, uw, ww) = (u.length_squared(), u.dot(way), way.length_squared());
                let share = (u.dot(s) * ww - way.dot(s) * uw) / (uu * ww - uw * uw);
                let nearest = (from + u * share.clamp(0.0, 1.0)).lerp(middle, 1e-3);
                let height = (nearest - lamp).dot(sight.normal) / way.dot(sight.normal);
                (height > 0.0 && height < 1.0).then(|| lamp + (nearest - lamp) / height)
            })
        };
        let surfaces = self.world.configuration().objects().map(|(id, _)| &self.surfaces[id]);
        let touched = surfaces.filter(|surface| crosses(&surface.bounds, lamp, way, 1e-2 * self.reach()));
        touched.flat_map(|surface| surface.corners.iter().flat_map(|corners| near(*corners))).flatten().collect()
    }

    /// How far a place of the picture is from the outline of a triangle, in pixels of a picture of `size`.
    pub fn outline_distance(&self, camera: &Camera, at: DVec2, of: (usize, usize), size: [u32; 2]) -> f64 {
        let pixels = DVec2::new(f64::from(size[0]), f64::from(size[1])) / 2.0;
        let [a, b, c] = self.surfaces[of.0].corners[of.1];
        let distance = |(mut p, mut q): (DVec3, DVec3)| {
            let beyond = |point: DVec3| (point - camera.eye).dot(camera.forward) - camera.near * 1.001;
            // What is before the near plane is cut off.
            let cut = p.lerp(q, beyond(p) / (beyond(p) - beyond(q)));
            p = if beyond(p) < 0.0 { cut } else { p };
            q = if beyond(q) < 0.0 { cut } else { q };
            let [p, q] = [p, q].map(|point| Some((camera.project(point)? - at) * pixels));
            let (p, way) = (p?, q? - p?);
            let share = (-p.dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            Some((p + way * share).length())
        };
        [(a, b), (b, c), (c, a)].into_iter().filter_map(distance).fold(f64::INFINITY, f64::min)
    }

    /// The same to double precision, by all triangles. What touches the point's plane near it does not stand between.
    pub fn sees_exactly(&self, sight: &Sight, lamp: DVec3) -> bool {
        let way = sight.point - lamp;
        let height = -way.dot(sight.normal);
        let touch = self.touch() / height;
        self.world.configuration().objects().all(|(id, _)| {
            let surface = &self.surfaces[id];
            !crosses(&surface.bounds, lamp, way, self.touch())
                || surface.corners.iter().enumerate().all(|(t, corners)| {
                    (id, t) == sight.of || meets(corners, lamp, way).is_none_or(|at| at <= 0.0 || at >= 1.0 - touch)
                })
        })
    }
}

/// Whether a segment crosses a box that is `slack` larger.
fn crosses(bounds: &Bounds, from: DVec3, way: DVec3, slack: f64) -> bool {
    let inverse = way.recip();
    let (a, b) = ((bounds.low - slack - from) * inverse, (bounds.high + slack - from) * inverse);
    // Written so that a NaN (0 · ∞) crosses.
    !(a.min(b).max_element() > 1.0 || a.max(b).min_element() < 0.0 || a.min(b).max_element() > a.max(b).min_element())
}

/// How much of the way it is to a triangle (Möller and Trumbore 1997).
fn meets([a, b, c]: &[DVec3; 3], from: DVec3, way: DVec3) -> Option<f64> {
    let (u, v) = (*b - *a, *c - *a);
    let p = way.cross(v);
    let determinant = u.dot(p);
    let s = from - *a;
    let x = s.dot(p) / determinant;
    let q = s.cross(u);
    let y = way.dot(q) / determinant;
    (x >= 0.0 && y >= 0.0 && x + y <= 1.0).then(|| v.dot(q) / determinant)
}
