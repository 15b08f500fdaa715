//! What a session was like: frames per second and their times, how far the picture was behind the mouse, photons, and how soon the light
//! was right again.

use super::desk::Desk;
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// Something that went on: a drag, a slider, a script.
struct Stretch {
    title: String,
    began: Instant,
    /// When the last frame of it was shown.
    ended: Instant,
    /// Milliseconds from one frame that was shown to the next.
    intervals: Vec<f64>,
    /// Milliseconds from the beginning of a frame until it was shown.
    frames: Vec<f64>,
    /// Milliseconds from when an event was taken until a frame showed it.
    delays: Vec<f64>,
    /// Photons and rays traced before it, and until its end.
    work: [[u64; 2]; 2],
    pixels: Vec<f64>,
    passes: Vec<[f64; 8]>,
    edits: u64,
    /// Seconds from its end until 5 % of the change were outstanding, until the light was complete for the eye, and until it was exact.
    after: Option<[Option<f64>; 3]>,
}

/// Account of a session.
pub struct Report {
    began: Instant,
    frames: u64,
    stretches: Vec<Stretch>,
    going_on: bool,
    last_shown: Option<Instant>,
}

impl Default for Report {
    fn default() -> Report {
        Report { began: Instant::now(), frames: 0, stretches: Vec::new(), going_on: false, last_shown: None }
    }
}

/// More of them than this nobody reads.
const MOST: usize = 200;

impl Report {
    /// A frame was shown at `now`; it took `took` milliseconds, the room in it `room`; `event` is when something happened that it shows
    /// first.
    pub fn frame(&mut self, desk: &Desk, now: Instant, took: f64, room: Option<Duration>, event: Option<Instant>) {
        self.frames += 1;
        let session = &desk.session;
        let ready = session.light.ready();
        let work = ready.as_ref().map_or([0, 0], |ready| [ready.snapshot.work.photons, ready.snapshot.work.rays]);
        let open = session.history.is_open();
        let title = session.history.last_done().unwrap_or_default();
        let full = self.stretches.len() >= MOST;
        if full {
            // Nothing more is added.
        } else if open && !(self.going_on && self.stretches.last().is_some_and(|s| s.title == title)) {
            self.stretches.push(Stretch {
                title: title.to_owned(),
                began: now,
                ended: now,
                intervals: Vec::new(),
                frames: Vec::new(),
                delays: Vec::new(),
                work: [work; 2],
                pixels: Vec::new(),
                passes: Vec::new(),
                edits: 0,
                after: None,
            });
        } else if open && let Some(stretch) = self.stretches.last_mut() {
            stretch.ended = now;
            stretch.work[1] = work;
            stretch.intervals.extend(self.last_shown.map(|last| (now - last).as_secs_f64() * 1000.0));
            if room.is_some() {
                stretch.frames.push(took);
                stretch.delays.extend(event.map(|event| (now - event).as_secs_f64() * 1000.0));
                let (pace, times) = (&desk.pace, &desk.pace.times);
                stretch.passes.push([
                    pace.desk,
                    times.preparation,
                    times.prepass,
                    times.shadows,
                    times.composition,
                    times.exposure,
                    times.tone,
                    pace.showing,
                ]);
                stretch.pixels.push(f64::from(desk.pace.pixels[0]) * f64::from(desk.pace.pixels[1]));
            }
            stretch.edits = session.edits();
        }
        self.going_on = open;
        self.last_shown = Some(now);
        if let (Some(stretch), Some(ready)) = (self.stretches.last_mut(), &ready)
            && !open
            && stretch.after.is_none()
            && ready.snapshot.edits >= stretch.edits
            && ready.trace.exact_after.is_some()
        {
            stretch.after = Some([ready.trace.until(0.05), ready.trace.complete_after, ready.trace.exact_after]);
        }
    }

    /// As JSON.
    pub fn json(&self, desk: &Desk) -> Value {
        let ready = desk.session.light.ready();
        let room = desk.viewport.rect;
        json!({
            "room_in_window": [room.left(), room.top(), room.width(), room.height()],
            "scene": desk.session.scene.name, "driver": desk.driver, "frames_per_second_wanted": desk.fps,
            "seconds": self.began.elapsed().as_secs_f64(), "frames": self.frames, "edits": desk.session.edits(),
            "photons": ready.as_ref().map(|ready| ready.snapshot.photons), "median_error": ready.as_ref().map(|ready| ready.median_error),
            "stretches": self.stretches.iter().map(Stretch::json).collect::<Vec<_>>(),
        })
    }
}

/// The value that a share of the others do not exceed.
fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(((sorted.len() as f64 * share).ceil() as usize).saturating_sub(1)).copied()
}

impl Stretch {
    fn json(&self) -> Value {
        let seconds = (self.ended - self.began).as_secs_f64();
        let rate =
            |n: usize| if seconds > 0.0 { Some(self.work[1][n].saturating_sub(self.work[0][n]) as f64 / seconds) } else { None };
        let shares = |values: &[f64]| json!({ "median": quantile(values, 0.5), "percentile_99": quantile(values, 0.99), "longest": quantile(values, 1.0) });
        let names = ["events_and_panels", "preparation", "prepass", "shadows", "composition", "exposure", "tone", "showing"];
        let pass = |n: usize| quantile(&self.passes.iter().map(|p| p[n]).collect::<Vec<_>>(), 0.5);
        let passes: serde_json::Map<String, Value> =
            names.iter().enumerate().map(|(n, name)| ((*name).to_owned(), json!(pass(n)))).collect();
        json!({
            "median_milliseconds_by_pass": passes,
            "what": self.title, "seconds": seconds, "frames": self.intervals.len(),
            "frames_per_second": if seconds > 0.0 { Some(self.intervals.len() as f64 / seconds) } else { None },
            "milliseconds_between_frames": shares(&self.intervals), "milliseconds_a_frame": shares(&self.frames),
            "milliseconds_from_event_to_shown": shares(&self.delays), "median_pixels": quantile(&self.pixels, 0.5),
            "photons_per_second": rate(0), "rays_per_second": rate(1),
            "seconds_until_5_percent": self.after.and_then(|after| after[0]), "seconds_until_complete_for_the_eye": self.after.and_then(|after| after[1]),
            "seconds_until_exact": self.after.and_then(|after| after[2]),
        })
    }
}
