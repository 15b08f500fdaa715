//! IESNA LM-63 photometric files: 1986 (no header), 1991, 1995, 2002 and 2019.
//!
//! ANSI/IESNA LM-63-2002, §5: free lines, a `TILT=` line, then numbers parted by commas and any white space:
//! lamps, lumens per lamp, multiplier, count of vertical angles, count of horizontal angles, type (1 = C), units, width,
//! length, height; ballast factor, ballast-lamp photometric factor (reserved since 1995), watts; the vertical angles, the
//! horizontal angles, the candela values of each horizontal angle in turn.
//!
//! Candela are multiplied by the multiplier and the ballast factor. Bytes need not be UTF-8: only numbers are read.

use super::numbers::{Numbers, line_end, shown};
use super::{Photometry, Symmetry, circle};
use crate::{SceneError, Warning};
use std::io::Read;
use std::path::Path;

/// A goniometer of 1° by 1° writes half a megabyte.
const MAX_BYTES: u64 = 16 << 20;
/// Candela of a believable lamp: above is an error, below counts as 0.
const CANDELA: std::ops::RangeInclusive<f64> = 1e-30..=1e30;

impl Photometry {
    /// Reads an IESNA LM-63 file of type C photometry. Errors name the file and the line.
    pub fn read(path: &Path) -> Result<(Self, Vec<Warning>), SceneError> {
        let mut bytes = Vec::new();
        let file = std::fs::File::open(path).map_err(|e| SceneError::read(path, e))?;
        file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(|e| SceneError::read(path, e))?;
        if bytes.len() as u64 > MAX_BYTES {
            return Err(SceneError::content(path, "over 16 MiB: not a photometric file"));
        }
        Self::parse(&bytes, path)
    }

    /// Reads the text of an IESNA LM-63 file; `path` is only for messages.
    pub fn parse(text: &[u8], path: &Path) -> Result<(Self, Vec<Warning>), SceneError> {
        let (mut numbers, tilt) = after_tilt(text, path)?;
        let mut warnings = Vec::new();
        let mut warn = |what: String| warnings.push(Warning(format!("{}: {what}", path.display())));
        if tilt == Tilt::Include {
            numbers.skip_tilt()?;
            warn("TILT=INCLUDE: its factors are not applied; the lamp shines as in the position it was measured in".into());
        }
        let head = Head::read(&mut numbers)?;
        // Since 2019 it tells how the file was made.
        let reserved = text.split(|&b| b == b'\n').next().is_some_and(|first| first.starts_with(b"IES:LM-63"));
        if !reserved && head.photometric != 1.0 && head.photometric != 0.0 {
            warn(format!("the ballast-lamp photometric factor {} is not applied", head.photometric));
        }
        let vertical = numbers.angles(head.vertical, "vertical")?;
        let (first, last) = (vertical[0], vertical[vertical.len() - 1]);
        if first < 0.0 || last > 180.0 {
            let what = format!("the vertical angles run from {first} to {last}: type C has 0 to 180 degrees");
            return Err(numbers.error(what));
        }
        let mut horizontal = numbers.angles(head.horizontal, "horizontal")?;
        let symmetry = circle::symmetry(&mut horizontal).map_err(|what| numbers.error(what))?;
        let mut planes = candela(&mut numbers, &head)?;
        if numbers.finish()? {
            warn("text after the candela values is ignored".into());
        }
        if symmetry == Symmetry::BilateralAcross {
            add_middle(&mut horizontal, &mut planes);
        }

        let all_around = circle::unfold(&horizontal, symmetry);
        let table = (0..head.vertical).flat_map(|row| all_around.iter().map(move |plane| (row, plane.1)));
        let candela = table.map(|(row, plane)| planes[plane][row]).collect();
        let photometry = Self::new(vertical, all_around.iter().map(|plane| plane.0).collect(), candela, symmetry);
        if photometry.luminous_flux() == 0.0 {
            warn("no candela value is above 0: the lamp gives no light".into());
        }
        if let Some(what) = seam(&horizontal, &planes, symmetry, photometry.max_candela) {
            warn(what);
        }
        Ok((photometry, warnings))
    }
}

/// A plane at 180 of a lamp measured from 90 to 270: it becomes C = 0.
fn add_middle(angles: &mut Vec<f64>, planes: &mut Vec<Vec<f64>>) {
    let at = angles.partition_point(|&c| c < 180.0);
    if angles[at] == 180.0 {
        return;
    }
    let s = (180.0 - angles[at - 1]) / (angles[at] - angles[at - 1]);
    let plane = planes[at - 1].iter().zip(&planes[at]).map(|(a, b)| a + s * (b - a)).collect();
    planes.insert(at, plane);
    angles.insert(at, 180.0);
}

/// What is odd where a full circle closes.
fn seam(angles: &[f64], planes: &[Vec<f64>], symmetry: Symmetry, max: f64) -> Option<String> {
    if symmetry != Symmetry::Full {
        return None;
    }
    let (first, last) = (&planes[0], &planes[planes.len() - 1]);
    let end = angles[angles.len() - 1];
    let widest = angles.windows(2).map(|w| w[1] - w[0]).fold(0.0, f64::max);
    if end < 360.0 && 360.0 - end > 1.001 * widest {
        return Some(format!("the horizontal angles end at {end}: from there to 360 the intensity is interpolated"));
    }
    let jump = first.iter().zip(last).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let jumps = end == 360.0 && jump > 0.05 * max;
    jumps.then(|| format!("the planes at 0 and 360 degrees differ by {jump} candela: the light has an edge there"))
}

#[derive(PartialEq)]
enum Tilt {
    None,
    Include,
}

/// The numbers after the `TILT=` line.
fn after_tilt<'a>(text: &'a [u8], path: &'a Path) -> Result<(Numbers<'a>, Tilt), SceneError> {
    let mut line = 1;
    let mut rest = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    loop {
        let end = rest.iter().position(|b| matches!(b, b'\r' | b'\n')).unwrap_or(rest.len());
        let (this, after) = rest.split_at(end);
        if let Some(value) = tilt_value(this) {
            let tilt = if value.to_ascii_uppercase().starts_with(b"NONE") {
                Tilt::None
            } else if value.to_ascii_uppercase().starts_with(b"INCLUDE") {
                Tilt::Include
            } else {
                let file = shown(value);
                let what = format!(
                    "TILT={file}: tilt factors in another file are not read; write TILT=NONE for the lamp as it was measured"
                );
                return Err(SceneError::line(path, line, what));
            };
            return Ok((Numbers { rest: after, line, path }, tilt));
        }
        if after.is_empty() {
            return Err(SceneError::line(path, line, "no TILT= line up to the end: not an IESNA LM-63 file"));
        }
        rest = &after[line_end(after)..];
        line += 1;
    }
}

/// What follows `TILT=`, if the line is that one.
fn tilt_value(line: &[u8]) -> Option<&[u8]> {
    let line = line.trim_ascii();
    let key = line.get(..4)?.eq_ignore_ascii_case(b"TILT");
    key.then(|| line[4..].trim_ascii_start().strip_prefix(b"=")).flatten().map(<[u8]>::trim_ascii)
}

/// The values before the angles that matter here.
struct Head {
    /// Counts of angles, and the line of the counts.
    vertical: usize,
    horizontal: usize,
    line: usize,
    /// What candela values are multiplied by.
    factor: f64,
    /// The ballast-lamp photometric factor.
    photometric: f64,
}

impl Head {
    fn read(numbers: &mut Numbers) -> Result<Self, SceneError> {
        for what in ["the number of lamps", "the lumens per lamp"] {
            numbers.number(what)?;
        }
        let multiplier = numbers.number("the candela multiplier")?;
        let vertical = numbers.count("the number of vertical angles")?;
        let horizontal = numbers.count("the number of horizontal angles")?;
        let line = numbers.line;
        if vertical < 2 {
            return Err(numbers.error("one vertical angle: a lamp needs two or more"));
        }
        let kind = numbers.number("the photometric type")?;
        if kind != 1.0 {
            let name = if kind == 2.0 {
                "B"
            } else if kind == 3.0 {
                "A"
            } else {
                "unknown"
            };
            let what = format!("photometric type {kind} ({name}): only type C (1) is read; convert the file to type C");
            return Err(numbers.error(what));
        }
        for what in ["the units", "the width", "the length", "the height"] {
            numbers.number(what)?;
        }
        let ballast = numbers.number("the ballast factor")?;
        let factor = multiplier * ballast;
        if !(0.0..=*CANDELA.end()).contains(&factor) {
            let what = format!("the candela multiplier {multiplier} times the ballast factor {ballast} is {factor}");
            return Err(numbers.error(what));
        }
        let photometric = numbers.number("the ballast-lamp photometric factor")?;
        numbers.number("the input watts")?;

        // The counts are believed only when that many numbers can be there: two bytes each.
        let need = horizontal.checked_mul(vertical).and_then(|n| n.checked_add(horizontal)?.checked_add(vertical));
        if need.is_none_or(|n| n > numbers.rest.len() / 2) {
            let what = format!("{vertical} vertical and {horizontal} horizontal angles: the file is too short for so many");
            return Err(SceneError::line(numbers.path, line, what));
        }
        Ok(Self { vertical, horizontal, line, factor, photometric })
    }
}

/// Candela values times their factor, `[horizontal][vertical]`.
fn candela(numbers: &mut Numbers, head: &Head) -> Result<Vec<Vec<f64>>, SceneError> {
    let mut planes = Vec::with_capacity(head.horizontal);
    for plane in 0..head.horizontal {
        let mut values = Vec::with_capacity(head.vertical);
        for k in 0..head.vertical {
            let Some(word) = numbers.word() else {
                let (have, need) = (plane * head.vertical + k, head.horizontal * head.vertical);
                let what = format!("{have} candela values; the counts in line {} ask for {need}", head.line);
                return Err(numbers.error(what));
            };
            let value = numbers.value(word, "a candela value")?;
            let scaled = value * head.factor;
            if value < 0.0 || scaled > *CANDELA.end() {
                return Err(numbers.error(format!("{} is not a luminous intensity (candela)", shown(word))));
            }
            values.push(if scaled < *CANDELA.start() { 0.0 } else { scaled });
        }
        planes.push(values);
    }
    Ok(planes)
}

#[cfg(test)]
mod tests;
