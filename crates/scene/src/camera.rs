//! Cameras.

use crate::{Up, within_reach};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A pinhole camera.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct View {
    /// Where it stands, metres.
    pub eye: DVec3,
    /// What it looks at, metres.
    pub target: DVec3,
    /// Vertical angle of view, degrees.
    pub fov: f64,
}

impl View {
    /// Forward (unit), and to the right and upwards half the height of the picture at distance 1; `up` is the scene's.
    pub fn axes(&self, up: Up) -> [DVec3; 3] {
        let forward = (self.target - self.eye).normalize();
        // Straight up or down, any direction may be to the right.
        let right = forward.cross(up.axis()).try_normalize().unwrap_or(DVec3::X);
        let half = (self.fov.to_radians() / 2.0).tan();
        [forward, right * half, right.cross(forward) * half]
    }

    /// What makes it unusable, if anything.
    pub fn fault(&self) -> Option<&'static str> {
        if !within_reach(self.eye) || !within_reach(self.target) {
            Some("its eye or target is not a number or is farther than 1e6 m from the origin")
        } else if self.eye == self.target {
            Some("its eye and target are the same point")
        } else if !(self.fov > 0.0 && self.fov < 180.0) {
            Some("fov must be between 0 and 180 degrees")
        } else {
            None
        }
    }
}
