//! Points in six bytes: 16 bits an axis, over the box of the scene as it was when the ledger was begun.
//!
//! A stored point is within half a quantum of the true one. What lies outside is [`UNKNOWN`]: it counts as touching everything.

use glam::Vec3;

/// A stored point.
pub type Place = [u16; 3];

/// The largest coordinate of a point that is inside.
const MOST: f32 = 65_534.0;

/// Somewhere outside.
pub const UNKNOWN: Place = [u16::MAX; 3];

/// A coordinate from which on a point is unknown.
pub const OUTSIDE: f32 = 65_535.0;

/// From metres to stored points.
#[derive(Debug, Clone, Copy)]
pub struct Grid {
    low: Vec3,
    /// Steps per metre of each axis.
    scale: Vec3,
}

/// A box that paths may touch: the sum of its corners and their difference, in steps.
#[derive(Debug, Clone, Copy)]
pub struct Cuboid {
    /// Low corner plus high corner.
    pub sum: [f32; 3],
    /// High corner minus low corner.
    pub size: [f32; 3],
}

impl Grid {
    /// Over a box, a tenth larger on each side, so that things can be put down just outside. No smaller than `reach` / 1000.
    pub fn new([low, high]: [Vec3; 2], reach: f32) -> Grid {
        let [low, high] = if low.cmple(high).all() { [low, high] } else { [Vec3::ZERO, Vec3::ZERO] };
        let margin = ((high - low) * 0.1).max(Vec3::splat(1e-3 * reach));
        let low = low - margin;
        Grid { low, scale: MOST / (high + margin - low) }
    }

    fn steps(&self, point: Vec3) -> Vec3 {
        (point - self.low) * self.scale
    }

    /// A point as it is stored.
    pub fn place(&self, point: Vec3) -> Place {
        let steps = self.steps(point);
        let inside = steps.cmpge(Vec3::ZERO).all() && steps.cmple(Vec3::splat(MOST)).all();
        if inside { steps.to_array().map(|s| s.round_ties_even() as u16) } else { UNKNOWN }
    }

    /// Where a ray leaves the grid.
    pub fn exit(&self, origin: Vec3, direction: Vec3) -> Place {
        let (from, along) = (self.steps(origin), direction * self.scale);
        if self.place(origin) == UNKNOWN {
            return UNKNOWN;
        }
        let to_wall = |axis: usize| match along[axis] {
            a if a > 0.0 => (MOST - from[axis]) / a,
            a if a < 0.0 => from[axis] / -a,
            _ => f32::INFINITY,
        };
        let way = to_wall(0).min(to_wall(1)).min(to_wall(2));
        let at = from + along * way;
        if way.is_finite() && at.is_finite() {
            at.to_array().map(|s| s.clamp(0.0, MOST).round_ties_even() as u16)
        } else {
            UNKNOWN
        }
    }

    /// The middle of a stored point, metres; `None` if it is unknown.
    #[cfg(test)]
    pub fn point(&self, place: Place) -> Option<Vec3> {
        (place[0] != UNKNOWN[0]).then(|| self.low + Vec3::from_array(place.map(f32::from)) / self.scale)
    }

    /// A box, larger by `slack` metres and by what storing and testing can shift a path; and whether all of it is inside. `None` if
    /// none of it is.
    pub fn cuboid(&self, [low, high]: [Vec3; 2], slack: f32) -> (Option<Cuboid>, bool) {
        // Storing shifts a path by at most half a step (and 0.1 where it leaves the grid), rounding in the test by 1/16.
        let slack = self.scale * slack + Vec3::ONE;
        let [low, high] = [self.steps(low) - slack, self.steps(high) + slack];
        let inside = low.cmpge(Vec3::ZERO).all() && high.cmple(Vec3::splat(MOST)).all();
        // Kept near the grid, where the test's rounding is known.
        let [low, high] = [low.max(Vec3::splat(-2.0)), high.min(Vec3::splat(MOST + 2.0))];
        let cuboid = Cuboid { sum: (low + high).to_array(), size: (high - low).to_array() };
        (low.cmple(high).all().then_some(cuboid), inside)
    }
}
