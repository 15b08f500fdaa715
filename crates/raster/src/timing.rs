//! How long the passes of a frame take, by the device's own clock.

use crate::{
    device::{Device, RasterError},
    targets::mapped,
};
use std::time::Duration;

/// A pass of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pass {
    /// Depth and triangle numbers.
    Prepass,
    /// Shadow volumes and masks, of all lamps.
    Shadows,
    /// Adding up the light.
    Composition,
    /// Measuring the exposure.
    Exposure,
    /// Tone curve.
    Tone,
    /// Into a window.
    Present,
}

const PASSES: usize = 6;

/// Milliseconds of the passes of one frame; 0 where a pass was not needed or the driver has no clock.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Times {
    /// Silhouettes and uploads, on the CPU.
    pub preparation: f64,
    /// See [`Pass`].
    pub prepass: f64,
    /// See [`Pass`].
    pub shadows: f64,
    /// See [`Pass`].
    pub composition: f64,
    /// See [`Pass`].
    pub exposure: f64,
    /// See [`Pass`].
    pub tone: f64,
    /// See [`Pass`].
    pub present: f64,
}

/// Timestamps of the passes.
pub struct Stopwatch {
    clock: Option<Clock>,
    preparation: Duration,
    /// Passes that wrote timestamps since the last reading.
    ran: [bool; PASSES],
}

struct Clock {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readable: wgpu::Buffer,
    /// Nanoseconds.
    tick: f64,
}

const STAMPS: u32 = 2 * PASSES as u32;
const BYTES: u64 = 8 * STAMPS as u64;

impl Stopwatch {
    /// Without a clock on the device it only measures the preparation.
    pub fn new(device: &Device) -> Stopwatch {
        let clock = device.device.features().contains(wgpu::Features::TIMESTAMP_QUERY).then(|| {
            let buffer = |usage| {
                device.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("timestamps"),
                    size: BYTES,
                    usage,
                    mapped_at_creation: false,
                })
            };
            Clock {
                queries: device.device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("timestamps"),
                    ty: wgpu::QueryType::Timestamp,
                    count: STAMPS,
                }),
                resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
                readable: buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ),
                tick: f64::from(device.queue.get_timestamp_period()),
            }
        });
        Stopwatch { clock, preparation: Duration::ZERO, ran: [false; PASSES] }
    }

    /// The CPU has done its part of a new frame.
    pub fn prepared(&mut self, took: Duration) {
        self.preparation = took;
        self.ran = [false; PASSES];
    }

    fn stamps(&mut self, pass: Pass) -> Option<(&wgpu::QuerySet, u32)> {
        self.ran[pass as usize] = true;
        Some((&self.clock.as_ref()?.queries, 2 * pass as u32))
    }

    /// For a pass that is one render pass.
    pub fn render(&mut self, pass: Pass) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        self.render_of(pass, 0, 1)
    }

    /// For the `n`-th of `count` render passes that are timed together.
    pub fn render_of(&mut self, pass: Pass, n: usize, count: usize) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let (query_set, begin) = self.stamps(pass)?;
        Some(wgpu::RenderPassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: (n == 0).then_some(begin),
            end_of_pass_write_index: (n + 1 == count).then_some(begin + 1),
        })
        .filter(|w| w.beginning_of_pass_write_index.is_some() || w.end_of_pass_write_index.is_some())
    }

    /// Makes the frame's timestamps readable.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        (0..PASSES).filter(|pass| self.ran[*pass]).for_each(|pass| self.resolve_pass(encoder, pass));
    }

    /// Makes those of presenting readable, which has commands of its own.
    pub fn resolve_present(&self, encoder: &mut wgpu::CommandEncoder) {
        self.resolve_pass(encoder, Pass::Present as usize);
    }

    fn resolve_pass(&self, encoder: &mut wgpu::CommandEncoder, pass: usize) {
        if let Some(clock) = &self.clock {
            let first = 2 * pass as u32;
            // Results of one pass at a time: those of a pass that did not run would never be there.
            encoder.resolve_query_set(&clock.queries, first..first + 2, &clock.resolved, 0);
            encoder.copy_buffer_to_buffer(&clock.resolved, 0, &clock.readable, u64::from(first) * 8, 16);
        }
    }

    /// The last frame's times, once it is done.
    pub fn read(&mut self, device: &Device) -> Result<Times, RasterError> {
        let mut times = Times { preparation: self.preparation.as_secs_f64() * 1000.0, ..Times::default() };
        let Some(clock) = &self.clock else { return Ok(times) };
        let bytes = mapped(device, &clock.readable)?;
        clock.readable.unmap();
        let stamps: Vec<u64> = bytes.as_chunks::<8>().0.iter().map(|b| u64::from_le_bytes(*b)).collect();
        let took = |pass: Pass| {
            let first = 2 * pass as usize;
            let ticks = stamps[first + 1].saturating_sub(stamps[first]);
            if self.ran[pass as usize] { ticks as f64 * clock.tick / 1e6 } else { 0.0 }
        };
        times.prepass = took(Pass::Prepass);
        times.shadows = took(Pass::Shadows);
        times.composition = took(Pass::Composition);
        times.exposure = took(Pass::Exposure);
        times.tone = took(Pass::Tone);
        times.present = took(Pass::Present);
        Ok(times)
    }
}
