//! One order's way to exact light: errors at checkpoints that lie ever farther apart in rays, with the clock stopped while they are
//! measured.

use super::judge::{Errors, Judge};
use crate::{failure::Failure, onlooker::TOLERATED, progress};
use lightmend_photon::{course::Course, ledger::Refused, shooting::Work, world::World};
use std::{
    sync::Arc,
    time::{Duration, Instant},
};

/// The order in which light becomes exact.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum OrderArgument {
    Ledger,
    Stateless,
    Random,
    Restart,
}

impl OrderArgument {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            OrderArgument::Ledger => "ledger",
            OrderArgument::Stateless => "stateless",
            OrderArgument::Random => "random",
            OrderArgument::Restart => "restart",
        }
    }
}

/// A checkpoint.
pub struct Point {
    /// Photons traced and rays, so far.
    pub work: Work,
    /// Recorded hits replayed beside them.
    pub replayed: u64,
    /// Seconds of work so far.
    pub seconds: f64,
    /// By each way to read the light.
    pub errors: Vec<Errors>,
    /// Share of the first camera's pixels in which one could notice that the light is not exact yet.
    pub noticed: Option<f64>,
}

/// A way to exact light that was looked at.
pub struct Track {
    /// The order's name.
    pub order: &'static str,
    /// Checkpoints, the first before any work, the last exact.
    pub points: Vec<Point>,
    /// Whether it ended with the bits of a fresh solution.
    pub bit_equal: bool,
}

/// When an error was as small as asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reached {
    /// Seconds of work.
    pub seconds: f64,
    /// Rays.
    pub rays: f64,
}

/// An error counts as that of the drained light when it is at most so many times as large.
pub const NEAR: f64 = 1.1;

impl Track {
    /// The last checkpoint.
    pub fn drained(&self) -> Option<&Point> {
        self.points.last()
    }

    /// From which checkpoint on the light is complete for the eye; `None` without a camera.
    pub fn complete_for_the_eye(&self) -> Option<&Point> {
        self.points.first()?.noticed?;
        let above = self.points.iter().rposition(|point| point.noticed.is_some_and(|share| share > TOLERATED));
        self.points.get(above.map_or(0, |above| above + 1))
    }

    /// From when on nRMSE is at most [`NEAR`] times that of the drained light: between two checkpoints in proportion.
    pub fn near_drained(&self, readout: usize) -> Option<Reached> {
        let error = |point: &Point| point.errors[readout].measures.nrmse;
        let limit = NEAR * error(self.drained()?);
        near(&self.points.iter().map(|p| (p.seconds, p.work.rays as f64, error(p))).collect::<Vec<_>>(), limit)
    }
}

/// From when on the errors of (seconds, rays, error) are at most `limit`.
fn near(points: &[(f64, f64, f64)], limit: f64) -> Option<Reached> {
    let above = points.iter().rposition(|(_, _, error)| *error > limit);
    let Some(above) = above else { return points.first().map(|(seconds, rays, _)| Reached { seconds: *seconds, rays: *rays }) };
    let ((s0, r0, e0), (s1, r1, e1)) = (points[above], *points.get(above + 1)?);
    let share = (e0 - limit) / (e0 - e1);
    Some(Reached { seconds: s0 + share * (s1 - s0), rays: r0 + share * (r1 - r0) })
}

/// Rays at a checkpoint ÷ rays at the one before, at least. Less: finer curves, longer work.
const SPACING: f64 = 1.33;

/// Every so many checkpoints a frame is drawn: that takes longer than all else.
const FRAMES: usize = 4;

/// How a course ended.
pub enum Ended {
    /// With exact light.
    Exact(Vec<Point>, Course),
    /// The person ended it.
    Interrupted,
    /// A ledger has no room.
    Refused(Refused),
}

/// Follows `course` to its end, after the edit to `after` if there is one.
pub fn follow(
    mut course: Course,
    after: Option<&Arc<World>>,
    judge: &mut Judge,
    what: &str,
    quiet: bool,
) -> Result<Ended, Failure> {
    let bar = progress::bar(1000, what, quiet);
    let (mut work, mut replayed, mut clock) = (Work::default(), 0, Duration::ZERO);
    if let Some(after) = after {
        let start = Instant::now();
        if let Err(refused) = course.change(after.clone()) {
            return Ok(Ended::Refused(refused));
        }
        course.watch();
        clock += start.elapsed();
    }
    // What is seen before any work costs no time.
    let errors = judge.errors(course.light(), course.photons_shot(), true)?;
    let noticed = judge.noticed(course.light(), course.photons_shot());
    let mut points = vec![Point { work, replayed, seconds: 0.0, errors, noticed }];
    let mut next = 1.0;
    loop {
        let start = Instant::now();
        let step = course.step();
        clock += start.elapsed();
        match step {
            Ok(Some(step)) => {
                work += step.work;
                replayed += step.replayed;
            }
            Ok(None) => break,
            Err(refused) => return Ok(Ended::Refused(refused)),
        }
        if progress::interrupted() {
            return Ok(Ended::Interrupted);
        }
        bar.set_position((course.share() * 1000.0) as u64);
        let is_last = course.share() >= 1.0;
        if work.rays as f64 >= next || is_last {
            // As it is shown; the clock stands still while it is read out.
            let light = course.expected();
            let errors = judge.errors(&light, course.photons_shot(), is_last || points.len() % FRAMES == 0)?;
            let noticed = judge.noticed(&light, course.photons_shot());
            points.push(Point { work, replayed, seconds: clock.as_secs_f64(), errors, noticed });
            next = work.rays as f64 * SPACING;
        }
    }
    bar.finish_and_clear();
    Ok(Ended::Exact(points, course))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_is_from_when_on_the_error_stays_small() {
        // Falls below once, rises again, and passes 1.0 a quarter of the way from 1.1 to 0.7.
        let points = [(0.0, 0.0, 5.0), (1.0, 10.0, 0.9), (2.0, 20.0, 1.1), (4.0, 60.0, 0.7), (5.0, 70.0, 0.6)];
        let reached = near(&points, 1.0).unwrap();
        assert!((reached.seconds - 2.5).abs() < 1e-12 && (reached.rays - 30.0).abs() < 1e-12, "{reached:?}");
        assert_eq!(near(&points[3..], 1.0), Some(Reached { seconds: 4.0, rays: 60.0 }));
        assert_eq!(near(&points[..3], 1.0), None);
        assert_eq!(near(&points, 5.0), Some(Reached { seconds: 0.0, rays: 0.0 }));
    }
}
