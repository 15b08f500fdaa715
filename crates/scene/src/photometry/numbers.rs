//! The numbers of an LM-63 file, word by word, with the line each stands in.
//!
//! Commas and any white space part words, lines mean nothing: the files of forty years agree on no more.

use crate::SceneError;
use std::path::Path;

/// Angles nearer than this are taken for a slip, degrees.
const LEAST_STEP: f64 = 1e-3;

/// Numbers parted by white space and commas.
pub(super) struct Numbers<'a> {
    pub(super) rest: &'a [u8],
    /// One-based line of the last word read.
    pub(super) line: usize,
    pub(super) path: &'a Path,
}

impl<'a> Numbers<'a> {
    pub(super) fn error(&self, what: impl ToString) -> SceneError {
        SceneError::line(self.path, self.line, what)
    }

    /// The next word, with `line` moved to it.
    pub(super) fn word(&mut self) -> Option<&'a [u8]> {
        loop {
            let end = line_end(self.rest);
            if end > 0 {
                self.line += 1;
                self.rest = &self.rest[end..];
            } else if self.rest.first().copied().is_some_and(parts) {
                self.rest = &self.rest[1..];
            } else {
                break;
            }
        }
        let end = self.rest.iter().position(|&b| parts(b)).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        (end > 0).then_some(word)
    }

    /// The next number, finite.
    pub(super) fn number(&mut self, what: &str) -> Result<f64, SceneError> {
        match self.word() {
            Some(word) => self.value(word, what),
            None => Err(self.error(format!("the file ends before {what}"))),
        }
    }

    /// The finite number that a word is.
    pub(super) fn value(&self, word: &[u8], what: &str) -> Result<f64, SceneError> {
        let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok()).filter(|x: &f64| x.is_finite());
        number.ok_or_else(|| self.error(format!("expected {what}, found '{}'", shown(word))))
    }

    pub(super) fn count(&mut self, what: &str) -> Result<usize, SceneError> {
        let count = self.number(what)?;
        if count < 1.0 || count.fract() != 0.0 || count > 1e9 {
            return Err(self.error(format!("{what} is {count}")));
        }
        Ok(count as usize)
    }

    /// Lamp geometry, a count, that many angles, that many factors.
    pub(super) fn skip_tilt(&mut self) -> Result<(), SceneError> {
        self.number("the lamp's position of TILT=INCLUDE")?;
        let pairs = self.count("the number of tilt angles")?;
        for what in ["a tilt angle", "a tilt factor"] {
            for _ in 0..pairs {
                self.number(what)?;
            }
        }
        Ok(())
    }

    pub(super) fn angles(&mut self, count: usize, which: &str) -> Result<Vec<f64>, SceneError> {
        let mut angles: Vec<f64> = Vec::with_capacity(count);
        for _ in 0..count {
            let angle = self.number(&format!("a {which} angle"))?;
            if let Some(before) = angles.last().filter(|&&before| angle < before + LEAST_STEP) {
                return Err(self.error(format!("the {which} angle {angle} follows {before}: angles must increase")));
            }
            angles.push(angle);
        }
        Ok(angles)
    }

    /// Whether text follows the last value; an error when it is one more number.
    pub(super) fn finish(&mut self) -> Result<bool, SceneError> {
        let Some(word) = self.word() else { return Ok(false) };
        if std::str::from_utf8(word).is_ok_and(|w| w.parse::<f64>().is_ok()) {
            return Err(self.error("more candela values than the counts of angles ask for"));
        }
        // Programs of the eighties close a file so.
        Ok(!word.eq_ignore_ascii_case(b"END"))
    }
}

/// White space, commas, latin-1's no-break space, and the padding after the end of old files (NUL, Ctrl-Z).
fn parts(byte: u8) -> bool {
    byte.is_ascii_whitespace() || matches!(byte, b',' | 0x0b | 0xa0 | 0x85 | 0 | 0x1a)
}

/// The length of the line end at the begin of `text`; 0 when there is none. LF, CR LF and a lone CR end a line.
pub(super) fn line_end(text: &[u8]) -> usize {
    match text {
        [b'\r', b'\n', ..] => 2,
        [b'\r' | b'\n', ..] => 1,
        _ => 0,
    }
}

/// A word of a message: readable, and not longer than a message can bear.
pub(super) fn shown(word: &[u8]) -> String {
    let dots = if word.len() > 40 { "..." } else { "" };
    format!("{}{dots}", word[..word.len().min(40)].escape_ascii())
}
