//! Boxes, and where the shadow of one may fall: what need not be drawn.

use crate::camera::Camera;
use glam::{DVec2, DVec3};

/// An axis-parallel box, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The corner of least coordinates.
    pub low: DVec3,
    /// The opposite one.
    pub high: DVec3,
}

/// How far beyond a caster, as a share of its distance from the lamp, a shadow begins to count: a surface that touches it is not behind it.
const BEHIND: f64 = 1e-7;

impl Bounds {
    /// About points; empty (low above high) without any.
    pub fn about(points: impl Iterator<Item = DVec3>) -> Bounds {
        let empty = Bounds { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };
        points.fold(empty, |b, p| Bounds { low: b.low.min(p), high: b.high.max(p) })
    }

    /// Its corners.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|k| {
            DVec3::from_array(std::array::from_fn(|a| if k >> a & 1 == 1 { self.high[a] } else { self.low[a] }))
        })
    }

    /// The largest `normal · point` of its points.
    pub fn farthest_along(&self, normal: DVec3) -> f64 {
        let corner = |a: usize| if normal[a] > 0.0 { self.high[a] } else { self.low[a] };
        normal.x * corner(0) + normal.y * corner(1) + normal.z * corner(2)
    }

    /// The same with so much more on all sides, metres.
    pub fn grown(&self, by: f64) -> Bounds {
        Bounds { low: self.low - by, high: self.high + by }
    }

    /// Whether a point lies in it.
    pub fn contains(&self, p: DVec3) -> bool {
        p.cmpge(self.low).all() && p.cmple(self.high).all()
    }

    /// The box enlarged `t` times, seen from `lamp`: where the shadow of what it holds is, `t` times as far away.
    fn shadow_at(&self, lamp: DVec3, t: f64) -> Bounds {
        Bounds { low: lamp + (self.low - lamp) * t, high: lamp + (self.high - lamp) * t }
    }

    /// From how many to how many times its distance from `lamp` its shadow may touch `receiver`; `None` if nowhere behind it.
    ///
    /// At t times the distance the shadow is a box too, and each side of it moves linearly with t: six linear inequalities.
    pub fn shadow_reaches(&self, lamp: DVec3, receiver: &Bounds) -> Option<[f64; 2]> {
        let (mut from, mut to) = (1.0 + BEHIND, f64::INFINITY);
        for axis in 0..3 {
            // slope · t ≤ limit
            for (slope, limit) in [
                (self.low[axis] - lamp[axis], receiver.high[axis] - lamp[axis]),
                (lamp[axis] - self.high[axis], lamp[axis] - receiver.low[axis]),
            ] {
                if slope > 0.0 {
                    to = f64::min(to, limit / slope);
                } else if slope < 0.0 {
                    from = f64::max(from, limit / slope);
                } else if limit < 0.0 {
                    return None;
                }
            }
        }
        (from <= to).then_some([from, to])
    }

    /// The part of the picture that its shadow may cover between `from` and `to` times its distance from the lamp; `None` if the camera
    /// sees none of it.
    pub fn shadow_in_picture(&self, lamp: DVec3, [from, to]: [f64; 2], camera: &Camera) -> Option<Rectangle> {
        if !to.is_finite() {
            return Some(Rectangle::WHOLE);
        }
        let points = [self.shadow_at(lamp, from), self.shadow_at(lamp, to)].map(|b| b.corners());
        let points = points.as_flattened();
        let outside = |(normal, distance): &(DVec3, f64)| points.iter().all(|p| normal.dot(*p) < *distance);
        if camera.planes().iter().any(outside) {
            return None;
        }
        Rectangle::about(points, camera)
    }

    /// The part of the picture that it may cover.
    pub fn in_picture(&self, camera: &Camera) -> Option<Rectangle> {
        if camera.may_see(self) { Rectangle::about(&self.corners(), camera) } else { None }
    }
}

/// A part of the picture: from −1 to 1 to the right and upwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    /// Left and lower.
    pub low: DVec2,
    /// Right and upper.
    pub high: DVec2,
}

impl Rectangle {
    /// All of the picture.
    pub const WHOLE: Rectangle = Rectangle { low: DVec2::splat(-1.0), high: DVec2::splat(1.0) };

    /// About convex points; the whole picture if some lie behind the camera.
    fn about(points: &[DVec3], camera: &Camera) -> Option<Rectangle> {
        let mut rectangle = Rectangle { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY };
        for point in points {
            let Some(at) = camera.project(*point) else { return Some(Rectangle::WHOLE) };
            rectangle = Rectangle { low: rectangle.low.min(at), high: rectangle.high.max(at) };
        }
        rectangle.common(&Rectangle::WHOLE)
    }

    /// What two have in common.
    pub fn common(&self, other: &Rectangle) -> Option<Rectangle> {
        let both = Rectangle { low: self.low.max(other.low), high: self.high.min(other.high) };
        both.low.cmple(both.high).all().then_some(both)
    }

    /// The smallest that holds two.
    pub fn with(&self, other: &Rectangle) -> Rectangle {
        Rectangle { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// In pixels of a picture: left, top, width, height; a pixel more on each side, for rounding.
    pub fn pixels(&self, width: u32, height: u32) -> [u32; 4] {
        let clamp = |x: f64, most: u32| x.clamp(0.0, f64::from(most)) as u32;
        let left = clamp((self.low.x + 1.0) / 2.0 * f64::from(width) - 1.0, width);
        let right = clamp((self.high.x + 1.0) / 2.0 * f64::from(width) + 2.0, width);
        let top = clamp((1.0 - self.high.y) / 2.0 * f64::from(height) - 1.0, height);
        let bottom = clamp((1.0 - self.low.y) / 2.0 * f64::from(height) + 2.0, height);
        [left, top, right - left, bottom - top]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(at: f64, size: f64) -> Bounds {
        Bounds { low: DVec3::new(at, -size, -size), high: DVec3::new(at + size, size, size) }
    }

    #[test]
    fn a_shadow_reaches_what_is_behind_and_nothing_else() {
        let caster = cube(1.0, 0.5);
        let lamp = DVec3::ZERO;
        assert!(caster.shadow_reaches(lamp, &cube(4.0, 1.0)).is_some());
        assert!(caster.shadow_reaches(lamp, &cube(-4.0, 1.0)).is_none(), "on the other side of the lamp");
        assert!(caster.shadow_reaches(lamp, &cube(0.2, 0.3)).is_none(), "before the caster");
        let aside = Bounds { low: DVec3::new(4.0, 3.0, 0.0), high: DVec3::new(5.0, 4.0, 1.0) };
        assert!(caster.shadow_reaches(lamp, &aside).is_none(), "beside its cone");
        let wall = Bounds { low: DVec3::new(2.0, -9.0, -9.0), high: DVec3::new(2.0, 9.0, 9.0) };
        assert!(wall.shadow_reaches(lamp, &cube(1.0, 1.0)).is_none(), "what only touches the wall");
        assert!(wall.shadow_reaches(lamp, &cube(1.1, 1.0)).is_some(), "what sticks through it");
        assert!(cube(-0.5, 1.0).shadow_reaches(lamp, &cube(7.0, 1.0)).is_some(), "a lamp inside");
    }
}
