//! How long work takes, by the clock and of the processor: what other programs do meanwhile shows less in the second.

use rustix::time::{ClockId, clock_gettime};
use std::time::Instant;

/// Seconds by the clock, and of all threads together.
pub type Seconds = [f64; 2];

/// Seconds that all threads of this process have run.
fn processor_seconds() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Does some work.
pub fn timed<T>(work: impl FnOnce() -> T) -> (Seconds, T) {
    let (wall, processor) = (Instant::now(), processor_seconds());
    let result = work();
    ([wall.elapsed().as_secs_f64(), processor_seconds() - processor], result)
}

/// The middle one, or the later of two.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
