//! What is put around pictures: the legend of false colours, and the contact sheet of all frames.

use super::show::Show;
use crate::{failure::Failure, figure, output};
use image::{RgbImage, imageops};
use lightmend_raster::{FALSE_COLOURS, Look, Settings};
use std::path::Path;

/// Name of the contact sheet in the folder.
pub const FILE: &str = "contact.png";

/// Width of a frame on the sheet, pixels.
const THUMB: u32 = 320;
const COLUMNS: usize = 4;
/// More frames than this are thinned out evenly.
const MOST: usize = 48;
/// Height of a line of text, pixels.
const LINE: u32 = 20;

/// Small copies of frames.
#[derive(Default)]
pub struct ContactSheet {
    /// Every `stride`-th frame.
    thumbs: Vec<(RgbImage, String)>,
    stride: usize,
    seen: usize,
}

impl ContactSheet {
    /// Adds a frame.
    pub fn add(&mut self, picture: &RgbImage, label: String) {
        self.stride = self.stride.max(1);
        if self.seen.is_multiple_of(self.stride) {
            let height = (u64::from(picture.height()) * u64::from(THUMB) / u64::from(picture.width())).clamp(1, 4096) as u32;
            self.thumbs.push((imageops::thumbnail(picture, THUMB, height), label));
        }
        self.seen += 1;
        if self.thumbs.len() > MOST {
            let mut number = 0;
            self.thumbs.retain(|_| {
                number += 1;
                number % 2 == 1
            });
            self.stride *= 2;
        }
    }

    /// Writes the sheet; its name, or `None` if there is not more than one frame.
    pub fn write(&self, out: &Path) -> Result<Option<&'static str>, Failure> {
        if self.thumbs.len() < 2 {
            return Ok(None);
        }
        let height = self.thumbs.iter().map(|(thumb, _)| thumb.height()).max().unwrap_or(1) + LINE;
        let columns = COLUMNS.min(self.thumbs.len());
        let rows = self.thumbs.len().div_ceil(columns) as u32;
        let mut sheet = RgbImage::from_pixel(columns as u32 * THUMB, rows * height, image::Rgb([255; 3]));
        let mut labels = Vec::new();
        for (place, (thumb, label)) in self.thumbs.iter().enumerate() {
            let (x, y) = ((place % columns) as u32 * THUMB, (place / columns) as u32 * height);
            imageops::replace(&mut sheet, thumb, i64::from(x), i64::from(y));
            labels.push((label.clone(), [x + 6, y + height - LINE + 2]));
        }
        output::png(&out.join(FILE), &figure::with_text(sheet, &labels)?)?;
        Ok(Some(FILE))
    }
}

/// A picture in false colours with its scale below; any other as it is.
pub fn with_legend(picture: RgbImage, show: Show, settings: &Settings) -> Result<RgbImage, Failure> {
    let (Some(title), Look::FalseColours { low, high, logarithmic }) = (show.title(), settings.look) else { return Ok(picture) };
    let (width, height) = picture.dimensions();
    let margin = (width / 20).min(40);
    let bar = width.saturating_sub(2 * margin);
    let mut framed = RgbImage::from_pixel(width, height + 4 * LINE, image::Rgb([255; 3]));
    imageops::replace(&mut framed, &picture, 0, 0);
    for x in 0..bar {
        let at = f64::from(x) / f64::from(bar.max(2) - 1) * 8.0;
        let k = (at as usize).min(7);
        let mix = |c: usize| {
            let [a, b] = [FALSE_COLOURS[k][c], FALSE_COLOURS[k + 1][c]].map(f64::from);
            (a + (b - a) * (at - k as f64)).round() as u8
        };
        let colour = image::Rgb([mix(0), mix(1), mix(2)]);
        (height + LINE + 6..height + 2 * LINE + 6).for_each(|y| framed.put_pixel(margin + x, y, colour));
    }
    let mut labels = vec![(title.to_owned(), [margin, height + 3])];
    let steps = if bar < 300 { 2 } else { 4 };
    for k in 0..=steps {
        let share = f64::from(k) / f64::from(steps);
        let [low, high] = [low, high].map(f64::from);
        let value = if logarithmic { low * (high / low).powf(share) } else { low + (high - low) * share };
        let x = margin + (f64::from(bar) * share) as u32;
        let text = number(value);
        // The last one ends where the bar ends.
        let width = 8 * text.len() as u32;
        labels.push((
            text,
            [
                (x.saturating_sub(if k == 0 { 0 } else { width / 2 })).min((margin + bar).saturating_sub(width)),
                height + 2 * LINE + 10,
            ],
        ));
    }
    figure::with_text(framed, &labels)
}

/// Three digits, no more than are needed.
fn number(value: f64) -> String {
    let digits = if value >= 100.0 || value == 0.0 { 0 } else { (2 - value.log10().floor() as i32).clamp(0, 6) as usize };
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sheets_hold_frames_of_the_whole_film() {
        let mut sheet = ContactSheet::default();
        for frame in 0..1000 {
            sheet.add(&RgbImage::new(64, 48), frame.to_string());
        }
        let labels: Vec<usize> = sheet.thumbs.iter().map(|(_, l)| l.parse().unwrap()).collect();
        assert!((24..=MOST).contains(&labels.len()), "{labels:?}");
        assert!(labels.windows(2).all(|w| w[1] - w[0] == labels[1]), "{labels:?}");
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!([0.0, 0.5, 3.16227, 20.0, 1000.0].map(number), ["0", "0.5", "3.16", "20", "1000"]);
    }
}
