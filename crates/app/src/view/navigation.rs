//! How the camera moves: walking, looking around, orbiting, stepping to what is selected.

use glam::DVec3;
use lightmend_scene::{Up, View, within_reach};

/// The scene's axes as a person stands in it: two horizontal ones and up, right-handed.
pub fn axes(up: Up) -> [DVec3; 3] {
    match up {
        Up::Z => [DVec3::X, DVec3::Y, up.axis()],
        Up::Y => [DVec3::X, DVec3::NEG_Z, up.axis()],
    }
}

/// How far up or down one can look, radians: not quite upright, so that "to the right" stays defined.
const STEEPEST: f64 = 1.55;

/// A camera that a person moves. What it was set to is kept to the bit until it is moved.
#[derive(Debug, Clone)]
pub struct Navigation {
    view: View,
    up: Up,
    /// Metres per second.
    pub speed: f64,
    /// What one walks about in, metres.
    size: f64,
}

impl Navigation {
    /// Looks through `view`, in a scene that reaches `reach` metres. A room of 6 m is crossed in 4 s.
    pub fn new(view: View, up: Up, reach: f64) -> Navigation {
        Navigation { view, up, speed: reach / 4.0, size: reach }
    }

    /// What is seen.
    pub fn view(&self) -> View {
        self.view
    }

    /// From now on looks through `view`.
    pub fn set(&mut self, view: View) {
        if view.fault().is_none() {
            self.view = view;
        }
    }

    /// Distance to the target, and the angles of the way there: about up, and above the horizon; radians.
    fn spherical(&self, offset: DVec3) -> (f64, f64, f64) {
        let [e, n, u] = axes(self.up).map(|axis| offset.dot(axis));
        (offset.length(), n.atan2(e), u.atan2(e.hypot(n)))
    }

    fn offset(&self, (distance, about, above): (f64, f64, f64)) -> DVec3 {
        let [e, n, u] = axes(self.up);
        let above = above.clamp(-STEEPEST, STEEPEST);
        ((e * about.cos() + n * about.sin()) * above.cos() + u * above.sin()) * distance
    }

    /// Turns the head: to the left and upwards, radians.
    pub fn look(&mut self, left: f64, upwards: f64) {
        let (distance, about, above) = self.spherical(self.view.target - self.view.eye);
        let target = self.view.eye + self.offset((distance, about + left, above + upwards));
        self.set(View { target, ..self.view });
    }

    /// Steps: forwards, to the right and up, metres. Forwards is where one looks, but level with the floor.
    pub fn walk(&mut self, forwards: f64, right: f64, up: f64) {
        let (_, about, _) = self.spherical(self.view.target - self.view.eye);
        let [e, n, u] = axes(self.up);
        let ahead = e * about.cos() + n * about.sin();
        let step = ahead * forwards + ahead.cross(u) * right + u * up;
        self.shift(step);
    }

    /// Goes towards what is looked at, metres.
    pub fn dolly(&mut self, metres: f64) {
        let forward = (self.view.target - self.view.eye).normalize();
        self.shift(forward * metres);
    }

    /// Slides the camera in the picture's plane, in shares of the picture's height at the target's distance.
    pub fn pan(&mut self, right: f64, above: f64) {
        let [_, r, a] = self.view.axes(self.up);
        let distance = self.view.eye.distance(self.view.target);
        self.shift((r * right + a * above) * 2.0 * distance);
    }

    fn shift(&mut self, step: DVec3) {
        let [eye, target] = [self.view.eye + step, self.view.target + step];
        // Nobody walks farther than single precision can tell rooms apart.
        if within_reach(eye) && within_reach(target) && eye.abs().max_element() < self.size * 100.0 + 100.0 {
            self.set(View { eye, target, ..self.view });
        }
    }

    /// Goes round `centre`: to the left and upwards, radians. The centre keeps its place in the picture.
    pub fn orbit(&mut self, centre: DVec3, left: f64, upwards: f64) {
        let (distance, about, above) = self.spherical(self.view.eye - centre);
        let clamped = (above - upwards).clamp(-STEEPEST, STEEPEST);
        let (radius, heading, pitch) = self.spherical(self.view.target - self.view.eye);
        let eye = centre + self.offset((distance, about - left, clamped));
        let target = eye + self.offset((radius, heading - left, pitch - (clamped - above)));
        self.set(View { eye, target, ..self.view });
    }

    /// Looks at `centre` from where it is, near enough that something of `radius` metres fills half of the picture.
    pub fn face(&mut self, centre: DVec3, radius: f64) {
        let away = (self.view.eye - centre).try_normalize().unwrap_or(axes(self.up)[2]);
        let far = 2.0 * radius.max(0.05) / (self.view.fov.to_radians() / 2.0).tan();
        self.set(View { eye: centre + away * far, target: centre, ..self.view });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at_the_door(up: Up) -> Navigation {
        let [e, n, u] = axes(up);
        let view = View { eye: e + n * 2.0 + u * 1.6, target: e * 4.0 + n * 2.0 + u * 1.6, fov: 60.0 };
        Navigation::new(view, up, 6.0)
    }

    #[test]
    fn walking_is_level_and_looking_turns_about_the_eye() {
        for up in [Up::Y, Up::Z] {
            let [e, n, u] = axes(up);
            assert_eq!(e.cross(n), u);
            let mut camera = at_the_door(up);
            camera.look(0.0, -0.5);
            camera.walk(1.0, 0.0, 0.0);
            assert!((camera.view().eye - (e * 2.0 + n * 2.0 + u * 1.6)).length() < 1e-12, "level, though one looks down");
            camera.look(std::f64::consts::FRAC_PI_2, 0.5);
            let forward = (camera.view().target - camera.view().eye).normalize();
            assert!((forward - n).length() < 1e-12, "{forward}: to the left of east is north");
            camera.walk(0.0, 1.0, 0.5);
            assert!((camera.view().eye - (e * 3.0 + n * 2.0 + u * 2.1)).length() < 1e-12, "right of north is east");
            camera.look(0.0, 9.0);
            assert!(camera.view().fault().is_none() && camera.view().axes(up).iter().all(|a| a.is_finite()));
        }
    }

    #[test]
    fn orbiting_keeps_the_distance_and_the_place_in_the_picture() {
        let mut camera = at_the_door(Up::Z);
        let centre = DVec3::new(3.0, 2.5, 0.5);
        let in_picture = |view: View| {
            let [forward, right, above] = view.axes(Up::Z);
            let d = centre - view.eye;
            (d.dot(right) / d.dot(forward), d.dot(above) / d.dot(forward))
        };
        let (before, place) = (camera.view(), in_picture(camera.view()));
        for _ in 0..7 {
            camera.orbit(centre, 0.3, -0.05);
        }
        let (after, now) = (camera.view(), in_picture(camera.view()));
        assert!((after.eye.distance(centre) - before.eye.distance(centre)).abs() < 1e-9);
        assert!(after.eye.distance(before.eye) > 1.0);
        assert!((place.0 - now.0).abs() < 0.05, "{place:?} {now:?}");
        camera.orbit(centre, 0.0, 99.0);
        assert!(camera.view().fault().is_none());
    }
}
