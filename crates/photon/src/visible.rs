//! What a camera sees of an error: the measure in which outdated light is outstanding.
//!
//! Visible error is the RMS over the camera's pixels of the difference of irradiance from the drained state, over the RMS of the
//! drained state. The camera looks at the drained world.

use crate::{bucket::Buckets, field::Field, irradiance::Scale, path, triangle::Ray, world::World};
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

/// The element sides that a camera sees, each with the number of its pixels.
pub struct Visible {
    sides: Vec<Side>,
}

struct Side {
    object: usize,
    cell: u32,
    side: usize,
    /// Of the cell, m².
    area: f64,
    pixels: u32,
}

/// Pixels of the item buffer: enough that an element of a few per cent of the picture counts as it should.
const WIDTH: u32 = 320;
const HEIGHT: u32 = 240;

impl Visible {
    /// Casts a ray per pixel of a 320 × 240 picture.
    pub fn new(world: &World, view: &View) -> Visible {
        let lens = Lens::new(view, world.configuration().scene().up);
        let see = |pixel: u32| {
            let x = (2.0 * f64::from(pixel % WIDTH) + 1.0 - f64::from(WIDTH)) / f64::from(HEIGHT);
            let y = 1.0 - (2.0 * f64::from(pixel / WIDTH) + 1.0) / f64::from(HEIGHT);
            let (hit, direction) = lens.see(world, x, y)?;
            let (object, side) = (hit.triangle.object(), usize::from(hit.triangle.normal.dot(direction) > 0.0));
            let area = world.object(object).lattice.area_in(hit.triangle.in_mesh());
            Some(Side { object, cell: path::cell(world, &hit), side, area, pixels: 1 })
        };
        let mut seen: Vec<Side> = (0..WIDTH * HEIGHT).into_par_iter().filter_map(see).collect();
        seen.sort_by_key(|s| (s.object, s.cell, s.side));
        seen.dedup_by(|next, first| {
            let same = (next.object, next.cell, next.side) == (first.object, first.cell, first.side);
            first.pixels += u32::from(same);
            same
        });
        Visible { sides: seen }
    }

    /// Irradiance of what is seen, lux per linear Rec. 709 channel, in an order of its own.
    pub fn values(&self, light: &Buckets, scale: &Scale) -> Vec<[f32; 3]> {
        let value = |s: &Side| scale.irradiance(light, s.object, s.cell, s.side, s.area).value.as_vec3().to_array();
        self.sides.iter().map(value).collect()
    }

    /// The same, of a field of the world that is looked at.
    pub fn values_of(&self, field: &Field) -> Vec<[f32; 3]> {
        self.sides.iter().map(|s| field.side(s.object, s.cell, s.side).irradiance.as_vec3().to_array()).collect()
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
