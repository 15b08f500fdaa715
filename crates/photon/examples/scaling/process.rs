//! What the kernel says of this process' memory, proc(5), and how long the same work takes again and again.

use crate::times::{Seconds, median, timed};
use std::{error::Error, fs::read_to_string};

/// Memory, bytes: `VmRSS` is what is resident, `VmHWM` the most that ever was.
pub fn memory(field: &str) -> Result<f64, Box<dyn Error>> {
    let status = read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix(field)?.strip_prefix(':'));
    let kilobytes = line.and_then(|line| line.trim().strip_suffix(" kB")).ok_or("the kernel tells no memory")?;
    Ok(kilobytes.parse::<f64>()? * 1024.0)
}

/// Runs of the same work.
#[derive(Default)]
pub struct Times(Vec<Seconds>);

impl Times {
    /// Does it once more.
    pub fn run<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let (seconds, result) = timed(work);
        self.0.push(seconds);
        result
    }

    /// Median of what the clock said.
    pub fn wall(&self) -> f64 {
        median(self.0.iter().map(|[wall, _]| *wall).collect())
    }

    /// Median of all processors together.
    pub fn processor(&self) -> f64 {
        median(self.0.iter().map(|[_, processor]| *processor).collect())
    }
}
