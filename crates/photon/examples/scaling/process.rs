//! What the kernel says of this process: its memory, proc(5), and its time.

use rustix::time::{ClockId, clock_gettime};
use std::{error::Error, fs::read_to_string, time::Instant};

/// Memory, bytes: `VmRSS` is what is resident, `VmHWM` the most that ever was.
pub fn memory(field: &str) -> Result<f64, Box<dyn Error>> {
    let status = read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix(field)?.strip_prefix(':'));
    let kilobytes = line.and_then(|line| line.trim().strip_suffix(" kB")).ok_or("the kernel tells no memory")?;
    Ok(kilobytes.parse::<f64>()? * 1024.0)
}

/// Seconds that all threads of this process have run.
fn processor_seconds() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Runs of the same work, seconds.
#[derive(Default)]
pub struct Times {
    wall: Vec<f64>,
    processor: Vec<f64>,
}

impl Times {
    /// Does it once more.
    pub fn run<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let (processor, wall) = (processor_seconds(), Instant::now());
        let result = work();
        self.wall.push(wall.elapsed().as_secs_f64());
        self.processor.push(processor_seconds() - processor);
        result
    }

    /// Median of what the clock said.
    pub fn wall(&self) -> f64 {
        median(&self.wall)
    }

    /// Median of all processors together.
    pub fn processor(&self) -> f64 {
        median(&self.processor)
    }
}

/// The middle one, or the later of two.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}
