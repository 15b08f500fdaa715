//! A camera as the shaders see it: rays through pixels, and a projection without a far plane.
//!
//! Depth is reversed: near / distance, 1 at the near plane, 0 at infinity (Everitt and Kilgard 2002 for the infinite
//! projection). Positions are projected relative to the eye, so that rooms far from the origin lose nothing to it.

use crate::bounds::Bounds;
use glam::{DVec2, DVec3};
use lightmend_scene::{Up, View};

/// A view of a certain width and height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Metres.
    pub eye: DVec3,
    /// Unit.
    pub forward: DVec3,
    /// Half the picture's width at distance 1.
    pub right: DVec3,
    /// Half its height.
    pub above: DVec3,
    /// Distance of the near plane, metres.
    pub near: f64,
}

impl Camera {
    /// Of a picture `aspect` times as wide as high, in a scene that reaches `reach` metres; `up` is the scene's.
    pub fn new(view: &View, up: Up, aspect: f64, reach: f64) -> Camera {
        let [forward, right, above] = view.axes(up);
        Camera { eye: view.eye, forward, right: right * aspect, above, near: reach * 1e-4 }
    }

    /// The direction through a point of the picture, from −1 to 1 to the right and upwards; it ends at distance 1 along `forward`.
    pub fn ray(&self, at: DVec2) -> DVec3 {
        self.forward + self.right * at.x + self.above * at.y
    }

    /// Corners of the near plane's part in the picture, metres.
    pub fn near_corners(&self) -> [DVec3; 4] {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| self.eye + self.ray(DVec2::new(x, y)) * self.near)
    }

    /// Where a point is in the picture (−1 to 1 to the right and upwards); `None` behind the near plane.
    pub fn project(&self, point: DVec3) -> Option<DVec2> {
        let d = point - self.eye;
        let depth = d.dot(self.forward);
        let across = |axis: DVec3| d.dot(axis) / axis.length_squared() / depth;
        (depth >= self.near).then(|| DVec2::new(across(self.right), across(self.above)))
    }

    /// Planes that bound what is seen, as normals (inwards) and distances: `normal · point ≥ distance` inside.
    pub fn planes(&self) -> [(DVec3, f64); 5] {
        let side = |axis: DVec3, sign: f64| {
            let normal = self.forward + axis * sign / axis.length_squared();
            (normal, normal.dot(self.eye))
        };
        let ahead = (self.forward, self.forward.dot(self.eye) + self.near);
        [side(self.right, 1.0), side(self.right, -1.0), side(self.above, 1.0), side(self.above, -1.0), ahead]
    }

    /// Whether a box may be seen, whatever stands in between.
    pub fn may_see(&self, bounds: &Bounds) -> bool {
        self.planes().iter().all(|(normal, distance)| bounds.farthest_along(*normal) >= *distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_projected_is_on_its_ray() {
        let view = View { eye: DVec3::new(1.0, 2.0, 1.5), target: DVec3::new(4.0, 3.0, 1.0), fov: 50.0 };
        let camera = Camera::new(&view, Up::Z, 4.0 / 3.0, 6.0);
        for at in [DVec2::ZERO, DVec2::new(0.9, -0.3), DVec2::new(-1.0, 1.0)] {
            let point = camera.eye + camera.ray(at) * 3.0;
            assert!((camera.project(point).unwrap() - at).length() < 1e-12);
            assert!(camera.may_see(&Bounds { low: point - 0.01, high: point + 0.01 }));
        }
        let beside = camera.eye + camera.ray(DVec2::new(1.2, 0.0)) * 3.0;
        assert!(!camera.may_see(&Bounds { low: beside - 0.01, high: beside + 0.01 }));
        assert_eq!(camera.project(camera.eye - camera.forward), None);
        assert!(camera.above.z > 0.0, "up is up");
    }
}
