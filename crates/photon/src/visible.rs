//! What a camera sees of an error: the measure in which outdated light is outstanding.
//!
//! Visible error is the RMS over the camera's pixels of the difference of irradiance from the drained state, over the RMS of the
//! drained state. The camera looks at the drained world.

use crate::{bucket::Buckets, field::Field, importance::Importance, irradiance::Scale, path, triangle::Ray, world::World};
use glam::{DVec3, Vec3};
use lightmend_scene::{Up, View};
use rayon::prelude::*;

/// Through the pixel at (x, y), each from −1 to 1 over the picture's height; x to the right, y up.
pub struct Lens {
    eye: Vec3,
    forward: DVec3,
    right: DVec3,
    above: DVec3,
}

impl Lens {
    /// A camera's lens; `up` is the scene's.
    pub fn new(view: &View, up: Up) -> Lens {
        let [forward, right, above] = view.axes(up);
        Lens { eye: view.eye.as_vec3(), forward, right, above }
    }

    /// The first surface seen at (x, y) that is not hidden from cameras, and the direction looked in.
    pub fn see<'w>(&self, world: &'w World, x: f64, y: f64) -> Option<(crate::triangle::Hit<'w>, Vec3)> {
        let direction = (self.forward + self.right * x + self.above * y).as_vec3();
        let mut ray = Ray::new(self.eye, direction, None, 0.0);
        loop {
            let hit = world.nearest(&ray)?;
            if !world.object(hit.triangle.object()).hidden_from_camera {
                return Some((hit, direction));
            }
            ray = Ray::new(hit.triangle.point(hit.weights), direction, Some(hit.triangle), world.reach().step_back());
        }
    }
}

/// What a camera may see, whatever stands in between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frustum {
    eye: DVec3,
    forward: DVec3,
    right: DVec3,
    above: DVec3,
    width: f64,
}

impl Frustum {
    /// Of a camera whose picture is `aspect` times as wide as high; `up` is the scene's.
    pub fn new(view: &View, up: Up, aspect: f64) -> Frustum {
        let Lens { forward, right, above, .. } = Lens::new(view, up);
        let half = right.length();
        Frustum { eye: view.eye, forward, right: right / half / half, above: above / half / half, width: aspect }
    }

    /// Whether a point lies in it.
    pub fn contains(&self, point: Vec3) -> bool {
        let d = point.as_dvec3() - self.eye;
        let depth = d.dot(self.forward);
        depth > 0.0 && d.dot(self.above).abs() <= depth && d.dot(self.right).abs() <= depth * self.width
    }
}

/// Edge of the square that a pixel of a picture [`SHOWN`] pixels high covers on a surface at `point` with a unit normal, m.
pub fn footprint(view: &View, up: Up, point: DVec3, normal: DVec3) -> f64 {
    let towards = point - view.eye;
    let slant = normal.dot(towards.normalize_or_zero()).abs();
    let [_, right, _] = view.axes(up);
    towards.length() * 2.0 * right.length() / SHOWN / slant.max(1e-3).sqrt()
}

/// The element sides that a camera sees, each with the number of its pixels.
pub struct Visible {
    sides: Vec<Side>,
    /// Of each pixel, row by row from the top, an index into `sides`, or none.
    pixels: Vec<u32>,
}

struct Side {
    object: usize,
    cell: u32,
    side: usize,
    /// Of the cell, m².
    area: f64,
    pixels: u32,
    /// Where it was met first, and what it reflects there.
    triangle: usize,
    reflectance: Vec3,
    /// Edge of the square on the surface that a pixel of a picture [`SHOWN`] pixels high covers, m.
    footprint: f64,
}

/// Pixels of the height of the picture that a viewer is thought to look at.
pub const SHOWN: f64 = 720.0;

/// An element side that a camera sees.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    /// Index of the object.
    pub object: usize,
    /// The triangle of its mesh.
    pub triangle: usize,
    /// Edge of the square on the surface that a pixel covers, m: it grows with distance and tilt.
    pub footprint: f64,
}

/// Pixels of the item buffer: enough that an element of a few per cent of the picture counts as it should.
const WIDTH: u32 = 320;
const HEIGHT: u32 = 240;

impl Visible {
    /// Casts a ray per pixel of a 320 × 240 picture.
    pub fn new(world: &World, view: &View) -> Visible {
        let up = world.configuration().scene().up;
        let lens = Lens::new(view, up);
        let see = |pixel: u32| {
            let x = (2.0 * f64::from(pixel % WIDTH) + 1.0 - f64::from(WIDTH)) / f64::from(HEIGHT);
            let y = 1.0 - (2.0 * f64::from(pixel / WIDTH) + 1.0) / f64::from(HEIGHT);
            let (hit, direction) = lens.see(world, x, y)?;
            let (object, side) = (hit.triangle.object(), usize::from(hit.triangle.normal.dot(direction) > 0.0));
            let triangle = hit.triangle.in_mesh();
            let area = world.object(object).lattice.area_in(triangle);
            let normal = hit.triangle.normal.as_dvec3().normalize_or_zero();
            let footprint = footprint(view, up, hit.triangle.point(hit.weights).as_dvec3(), normal);
            let reflectance = path::reflectance(world, &hit);
            Some(Side { object, cell: path::cell(&hit), side, area, pixels: 1, triangle, reflectance, footprint })
        };
        let met: Vec<Option<Side>> = (0..WIDTH * HEIGHT).into_par_iter().map(see).collect();
        let key = |s: &Side| (s.object, s.cell, s.side);
        let keys: Vec<_> = met.iter().map(|side| side.as_ref().map(key)).collect();
        let mut seen: Vec<Side> = met.into_iter().flatten().collect();
        seen.sort_by_key(key);
        seen.dedup_by(|next, first| {
            let same = (next.object, next.cell, next.side) == (first.object, first.cell, first.side);
            first.pixels += u32::from(same);
            same
        });
        let number =
            |wanted: &Option<(usize, u32, usize)>| wanted.and_then(|wanted| seen.binary_search_by_key(&wanted, key).ok());
        let pixels = keys.iter().map(|key| number(key).map_or(u32::MAX, |number| number as u32)).collect();
        Visible { sides: seen, pixels }
    }

    /// How much light matters on each side: pixels ÷ area. (To divide by the elevation of the threshold there did not pay: `docs/perception.md`.)
    pub fn importance(&self, world: &World) -> Importance {
        let weight = |s: &Side| {
            let weight = f64::from(s.pixels) / s.area;
            (s.object, world.object(s.object).lattice.cells(), s.cell, s.side, weight)
        };
        Importance::new(world.configuration().object_slots(), &self.sides.iter().map(weight).collect::<Vec<_>>())
    }

    /// What is seen, in the order of [`values`](Self::values).
    pub fn seen(&self) -> impl Iterator<Item = Seen> + '_ {
        self.sides.iter().map(Side::seen)
    }

    /// Radiance of what is seen, in the same order: candela per m² and linear Rec. 709 channel.
    pub fn radiance(&self, values: &[[f32; 3]]) -> Vec<Vec3> {
        let of = |(s, v): (&Side, &[f32; 3])| Vec3::from_array(*v) * s.reflectance / std::f32::consts::PI;
        self.sides.iter().zip(values).map(of).collect()
    }

    /// Width and height of the picture, and of each pixel, row by row from the top, which of what is seen it shows.
    pub fn picture(&self) -> (u32, u32, impl Iterator<Item = Option<usize>> + '_) {
        (WIDTH, HEIGHT, self.pixels.iter().map(|side| (*side != u32::MAX).then_some(*side as usize)))
    }

    /// Irradiance of what is seen, lux per linear Rec. 709 channel, in an order of its own.
    pub fn values(&self, light: &Buckets, scale: &Scale) -> Vec<[f32; 3]> {
        let value = |s: &Side| scale.irradiance(light, s.object, s.cell, s.side, s.area).value.as_vec3().to_array();
        self.sides.iter().map(value).collect()
    }

    /// The same, of a field of the world that is looked at.
    pub fn values_of(&self, field: &Field) -> Vec<[f32; 3]> {
        self.values_by(|object, cell, side| field.side(object, cell, side).irradiance)
    }

    /// The same, by the irradiance of an object's cell's side.
    pub fn values_by(&self, irradiance: impl Fn(usize, u32, usize) -> DVec3) -> Vec<[f32; 3]> {
        self.sides.iter().map(|s| irradiance(s.object, s.cell, s.side).as_vec3().to_array()).collect()
    }

    /// Visible error of [`values`](Self::values) against the drained ones; 0 if nothing is seen.
    pub fn difference(&self, values: &[[f32; 3]], drained: &[[f32; 3]]) -> f64 {
        let (mut error, mut reference) = (0.0, 0.0);
        for ((side, now), right) in self.sides.iter().zip(values).zip(drained) {
            let [now, right] = [now, right].map(|v| Vec3::from_array(*v).as_dvec3());
            error += f64::from(side.pixels) * (now - right).length_squared();
            reference += f64::from(side.pixels) * right.length_squared();
        }
        if reference > 0.0 { (error / reference).sqrt() } else { 0.0 }
    }

    /// Visible error of `light` against `drained`; 0 if nothing is seen. Both pools have the same size.
    pub fn error(&self, light: &Buckets, drained: &Buckets, scale: &Scale) -> f64 {
        self.difference(&self.values(light, scale), &self.values(drained, scale))
    }
}

impl Side {
    fn seen(&self) -> Seen {
        Seen { object: self.object, triangle: self.triangle, footprint: self.footprint }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frustum_holds_what_the_lens_sees() {
        let view = View { eye: DVec3::new(1.0, 2.0, 1.5), target: DVec3::new(4.0, 3.0, 1.0), fov: 50.0 };
        let (lens, frustum) = (Lens::new(&view, Up::Z), Frustum::new(&view, Up::Z, 4.0 / 3.0));
        for (x, y, inside) in
            [(0.0, 0.0, true), (1.32, 0.99, true), (1.34, 0.0, false), (0.0, -1.01, false), (-1.32, -0.99, true)]
        {
            let direction = lens.forward + lens.right * x + lens.above * y;
            assert_eq!(frustum.contains((view.eye + direction * 3.0).as_vec3()), inside, "{x}, {y}");
            assert!(!frustum.contains((view.eye - direction).as_vec3()), "behind the camera");
        }
    }
}
