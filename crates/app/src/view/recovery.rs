//! How the light comes right after an action: what is outstanding as time goes by, live by photons, and once the light is exact by what
//! the camera saw.
//!
//! Outstanding change is the visible error against the exact light, over the visible error of the light from before the action
//! (the RMS of irradiance over the camera's pixels). Before the light is exact nobody knows it: until then there are only the photons
//! that are still to be re-shot.

use lightmend_photon::{bucket::Buckets, irradiance::Scale, solver::Snapshot, visible::Visible};
use lightmend_scene::View;
use std::{
    sync::Arc,
    time::{Duration, Instant},
};

/// The curve of the last action.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Trace {
    /// Seconds since the last edit, and the share of the pool's photons that is outstanding.
    pub photons: Vec<[f64; 2]>,
    /// Seconds since the last edit, and the outstanding change; empty until the light is exact, or if nothing that is seen changed.
    pub change: Vec<[f64; 2]>,
    /// Seconds from the last edit until the light was exact.
    pub exact_after: Option<f64>,
    /// Seconds from the last edit until it was complete for the eye, as foreseen, or exact.
    pub complete_after: Option<f64>,
}

impl Trace {
    /// Seconds from the last edit until no more than this share of the change was outstanding.
    pub fn until(&self, share: f64) -> Option<f64> {
        // From the end: the error need not fall steadily.
        let above = self.change.iter().rposition(|[_, outstanding]| *outstanding > share);
        self.change.get(above.map_or(0, |n| n + 1)).map(|[seconds, _]| *seconds)
    }
}

/// Irradiance of what the camera sees, at one moment.
type Sample = (f64, Vec<[f32; 3]>);

/// Samples that are kept of an action; of more, every other one is dropped.
const MOST_SAMPLES: usize = 96;

/// Follows the light after actions.
#[derive(Default)]
pub struct Recovery {
    action: u64,
    /// The light from before the action.
    before: Option<Arc<Snapshot>>,
    edited: Option<Instant>,
    visible: Option<Visible>,
    samples: Vec<Sample>,
    trace: Trace,
    last: Option<Arc<Snapshot>>,
}

/// What the camera sees is looked up once edits rest: it costs as much as tens of thousands of rays.
pub const REST: Duration = Duration::from_millis(60);

impl Recovery {
    /// New light, with what is shown of it: of action number `action`, last edited at `edited`; `current` if it knows of that edit, `complete` if it is so for the eye.
    pub fn look(
        &mut self,
        action: u64,
        edited: Instant,
        current: bool,
        complete: bool,
        view: View,
        (snapshot, expected, scale): (&Arc<Snapshot>, &Buckets, &Scale),
    ) -> Trace {
        if action != self.action {
            self.action = action;
            self.before = self.last.clone().or_else(|| Some(snapshot.clone()));
        }
        if self.edited != Some(edited) {
            self.edited = Some(edited);
            self.visible = None;
            self.samples.clear();
            self.trace = Trace::default();
        }
        self.last = Some(snapshot.clone());
        let seconds = edited.elapsed().as_secs_f64();
        let shooting = snapshot.photons < snapshot.pool_photons;
        if current && self.trace.exact_after.is_none() {
            let outstanding = snapshot.outstanding_photons as f64 / snapshot.pool_photons.max(1) as f64;
            self.trace.photons.push([seconds, outstanding]);
            if self.action > 0 && !shooting && (edited.elapsed() > REST || snapshot.exact) {
                let visible = self.visible.get_or_insert_with(|| Visible::new(&snapshot.world, &view));
                self.samples.push((seconds, visible.values(expected, scale)));
            }
            self.trace.complete_after = (complete || snapshot.exact).then(|| self.trace.complete_after.unwrap_or(seconds));
            if snapshot.exact {
                self.trace.exact_after = Some(seconds);
                self.measure(scale);
            }
            if self.samples.len() > MOST_SAMPLES {
                keep_every_other(&mut self.samples);
            }
            if self.trace.photons.len() > 2 * MOST_SAMPLES {
                keep_every_other(&mut self.trace.photons);
            }
        }
        self.trace.clone()
    }

    /// The light is exact: now the error of all samples is known.
    fn measure(&mut self, scale: &Scale) {
        let (Some(visible), Some(before), Some((_, exact))) = (&self.visible, &self.before, self.samples.last()) else { return };
        let first = visible.difference(&visible.values(&before.buckets, scale), exact);
        // Less than this nobody sees, and dividing by it shows nothing but noise.
        if before.photons >= before.pool_photons && first > 1e-6 {
            self.trace.change =
                self.samples.iter().map(|(at, values)| [*at, visible.difference(values, exact) / first]).collect();
        }
        // Twenty-four megabytes of buckets in a house: no longer needed.
        self.before = None;
        self.samples = Vec::new();
    }
}

fn keep_every_other<T>(list: &mut Vec<T>) {
    let last = list.len() - 1;
    let mut n = 0;
    list.retain(|_| {
        n += 1;
        (n - 1) % 2 == 0 || n - 1 == last
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_read_from_its_end() {
        let change = vec![[0.1, 1.2], [0.2, 0.04], [0.3, 0.3], [0.4, 0.05], [0.5, 0.0]];
        let trace = Trace { change, ..Trace::default() };
        assert_eq!((trace.until(0.05), trace.until(0.5), trace.until(2.0)), (Some(0.4), Some(0.2), Some(0.1)));
        assert_eq!(Trace::default().until(0.05), None);
        let mut list: Vec<i32> = (0..8).collect();
        keep_every_other(&mut list);
        assert_eq!(list, [0, 2, 4, 6, 7]);
    }
}
