//! A constant frame rate: the person sets it; how finely a frame is drawn, and how much time is left for photons, follows from it.
//!
//! While something moves, a frame may take a share of the time that there is between two; if it takes longer, it is drawn of fewer pixels
//! and stretched. When everything rests, it is drawn once as finely as the window shows it, and then with smooth edges. While light
//! comes in, frames take no more than a quarter of the time, so that the light comes in sooner.

use std::time::{Duration, Instant};

/// Share of the time between two frames that drawing may take while something moves, where a processor draws that could trace photons.
/// Higher: finer pictures; lower: more photons.
const SHARE_OF_PROCESSOR: f64 = 0.6;

/// The same where a graphics card draws, whose time photons have no use for.
const SHARE_OF_CARD: f64 = 0.9;

/// After so long without a movement everything rests.
const REST: Duration = Duration::from_millis(400);

/// After so long edges become smooth: such a frame takes several times as long, and a hand that only paused would have to wait for it.
const LONG_REST: Duration = Duration::from_millis(1200);

/// How finely a frame is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Eighths of the window's pixels along each side: 2 to 8.
    pub eighths: u32,
    /// Samples along each side of a pixel.
    pub grid: u32,
}

impl Quality {
    /// Pixels to draw for a part of the window of `size` pixels.
    pub fn pixels(self, size: [u32; 2]) -> [u32; 2] {
        size.map(|side| (side * self.eighths / 8).max(1))
    }
}

/// Keeps the frame rate.
pub struct Governor {
    /// Frames per second that are wanted.
    pub fps: f64,
    share: f64,
    /// Eighths for a moving picture.
    eighths: u32,
    /// Frames in a row that would have had the time for one more.
    easy: u32,
    /// What frames of each number of eighths took lately, seconds, and when that was.
    known: [Option<(f64, Instant)>; 9],
    moved: Option<Instant>,
    /// What the picture that is shown was drawn with, and the one before it.
    drawn: Quality,
    before: Quality,
    /// How long the last frame in the window's own pixels took, seconds.
    rested: f64,
}

/// Eighths of the window's pixels that a moving picture has at least.
const LEAST: u32 = 2;

/// What frames took longer ago than this says little: another part of the scene is seen.
const LATELY: Duration = Duration::from_secs(2);

/// After so many frames in a row that leave time for more pixels, they get more.
const EASY: u32 = 4;

const FINEST: Quality = Quality { eighths: 8, grid: 1 };
const SMOOTH: Quality = Quality { eighths: 8, grid: 2 };

impl Governor {
    /// Wants `fps` frames a second; whether a processor draws them.
    pub fn new(fps: f64, on_processor: bool) -> Governor {
        let share = if on_processor { SHARE_OF_PROCESSOR } else { SHARE_OF_CARD };
        Governor { fps, share, eighths: 5, easy: 0, known: [None; 9], moved: None, drawn: FINEST, before: FINEST, rested: 0.0 }
    }

    /// Time from one frame to the next.
    pub fn period(&self) -> Duration {
        Duration::from_secs_f64(1.0 / self.fps)
    }

    /// Something moves: the camera, or what it sees.
    pub fn moves(&mut self) {
        self.moved = Some(Instant::now());
    }

    /// When a finer frame is due, if nothing moves until then.
    pub fn finer_at(&self, lit: bool) -> Option<Instant> {
        let moved = self.moved?;
        [moved + REST, moved + LONG_REST]
            .into_iter()
            .find(|at| *at > Instant::now())
            .filter(|_| self.drawn != SMOOTH)
            .filter(|_| !lit || self.drawn.eighths < 8)
    }

    /// Whether something moved just now.
    pub fn is_moving(&self) -> bool {
        self.moved.is_some_and(|at| at.elapsed() < REST)
    }

    /// How finely the next frame is to be drawn; `lit` if the light is still coming in, so that it will be drawn again.
    pub fn quality(&self, lit: bool) -> Quality {
        if self.is_moving() {
            Quality { eighths: self.eighths, grid: 1 }
        } else if lit || self.drawn.eighths < 8 || self.moved.is_some_and(|at| at.elapsed() < LONG_REST) {
            FINEST
        } else {
            SMOOTH
        }
    }

    /// Whether a finer frame is due although nothing changed.
    pub fn wants_finer(&self, lit: bool) -> bool {
        !self.is_moving() && self.quality(lit) != self.drawn && !(lit && self.drawn.eighths == 8)
    }

    /// When the next frame may show light that came in.
    pub fn pause_for_light(&self) -> Duration {
        if self.is_moving() { self.period() } else { self.period().max(Duration::from_secs_f64(4.0 * self.rested)) }
    }

    /// How long a moving frame of so many eighths will take, seconds: a part that does not depend on its pixels and one that does, from
    /// the two nearest that are known; of one, as if four fifths did not depend on them, so that finer ones are tried.
    fn predicted(&self, eighths: u32) -> f64 {
        let pixels = |eighths: u32| f64::from(eighths * eighths);
        let fresh = |n: u32| self.known[n as usize].filter(|(_, at)| at.elapsed() < LATELY).map(|(took, _)| (n, took));
        let mut known: Vec<(u32, f64)> = (LEAST..=8).filter_map(fresh).collect();
        known.sort_by_key(|(n, _)| n.abs_diff(eighths));
        match known[..] {
            [] => 0.0,
            [(same, took), ..] if same == eighths => took,
            [(n, took)] => took * (0.8 + 0.2 * pixels(eighths) / pixels(n)),
            [(a, of_a), (b, of_b), ..] => {
                let slope = ((of_b - of_a) / (pixels(b) - pixels(a))).max(0.0);
                (of_a + slope * (pixels(eighths) - pixels(a))).max(0.0)
            }
        }
    }

    /// A frame was drawn with `quality` in `took`.
    pub fn drew(&mut self, quality: Quality, took: Duration) {
        self.before = std::mem::replace(&mut self.drawn, quality);
        let took = took.as_secs_f64();
        if quality == FINEST {
            self.rested = took;
        }
        if !self.is_moving() || quality.grid > 1 {
            return;
        }
        // The first frame of a size also makes its textures, and perhaps its programs: it says nothing of the next.
        if self.before != quality {
            return;
        }
        let known = &mut self.known[quality.eighths as usize];
        *known = Some((known.map_or(took, |(before, _)| before + 0.3 * (took - before)), Instant::now()));
        // A little more time than the coarsest frame would take is worth a finer one, even if there is too little for either.
        let budget = (self.share / self.fps).max(1.15 * self.predicted(LEAST));
        let suits = |eighths: u32| eighths <= 8 && self.predicted(eighths) <= budget;
        let easy = if suits(quality.eighths + 1) { self.easy + 1 } else { 0 };
        if !suits(quality.eighths) {
            self.eighths = (LEAST..quality.eighths).rev().find(|eighths| suits(*eighths)).unwrap_or(LEAST);
        } else if easy >= EASY {
            self.eighths = quality.eighths + 1;
        }
        self.easy = easy % EASY;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Milliseconds per frame once it has settled, when a frame costs `fixed` and `full` ms for all of the window's pixels.
    fn settled(fps: f64, fixed: f64, full: f64) -> (f64, u32) {
        let mut governor = Governor::new(fps, true);
        let mut last = (0.0, 0);
        for _ in 0..200 {
            governor.moves();
            let quality = governor.quality(true);
            let share = f64::from(quality.eighths) / 8.0;
            let took = fixed + full * share * share;
            governor.drew(quality, Duration::from_secs_f64(took / 1000.0));
            last = (took, quality.eighths);
        }
        last
    }

    #[test]
    fn frames_fit_the_time_that_there_is() {
        for (fps, fixed, full) in [(20.0, 5.0, 60.0), (10.0, 20.0, 150.0), (25.0, 2.0, 10.0), (30.0, 8.0, 100.0)] {
            let (took, eighths) = settled(fps, fixed, full);
            assert!(took <= 600.0 / fps, "{fps}: {took} ms at {eighths}/8");
            let finer = fixed + full * f64::from(eighths + 1).powi(2) / 64.0;
            assert!(eighths == 8 || finer > 590.0 / fps, "{fps}: {eighths}/8 is too coarse");
        }
        assert_eq!(settled(60.0, 5.0, 800.0).1, 2, "what cannot be is drawn as coarsely as may be");
        assert!(settled(60.0, 50.0, 100.0).1 >= 3, "but not if that hardly helps");
    }

    #[test]
    fn at_rest_it_becomes_fine_and_then_smooth() {
        let mut governor = Governor::new(20.0, true);
        governor.drew(Quality { eighths: 4, grid: 1 }, Duration::from_millis(20));
        assert!(governor.wants_finer(true) && governor.quality(true) == FINEST);
        governor.drew(FINEST, Duration::from_millis(50));
        assert!(!governor.wants_finer(true), "while light comes in it is drawn again anyway");
        assert!(governor.wants_finer(false) && governor.quality(false) == SMOOTH);
        governor.drew(SMOOTH, Duration::from_millis(200));
        assert!(!governor.wants_finer(false));
        assert_eq!(governor.pause_for_light(), Duration::from_millis(200));
    }
}
