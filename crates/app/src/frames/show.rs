//! What is drawn, and in which colours.

use crate::failure::Failure;
use lightmend_raster::{Look, Parts, RasterError, Settings};

/// What is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Show {
    /// What the camera sees
    Radiance,
    /// All light that arrives at surfaces, lux
    Illuminance,
    /// The light that arrives from other surfaces, lux
    Indirect,
    /// Mesh elements, each in a colour of its own
    Elements,
    /// How far the indirect light still is from exact, as a share of it; drains a copy of the light after every edit
    Stale,
}

/// Values of the first and the last false colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    pub low: f32,
    pub high: f32,
}

impl Range {
    /// "1,500".
    pub fn parse(text: &str) -> Result<Range, String> {
        let ends = text.split_once(',').map(|(low, high)| (low.trim().parse::<f32>(), high.trim().parse::<f32>()));
        match ends {
            Some((Ok(low), Ok(high))) if low >= 0.0 && low < high && high.is_finite() => Ok(Range { low, high }),
            _ => Err("two numbers, the first not below 0 and less than the second, like 1,500".into()),
        }
    }

    /// The range of false colours; `None` of any other look.
    #[cfg(feature = "window")]
    pub fn of(look: Look) -> Option<Range> {
        match look {
            Look::FalseColours { low, high, .. } => Some(Range { low, high }),
            _ => None,
        }
    }

    fn look(self) -> Look {
        Look::FalseColours { low: self.low, high: self.high, logarithmic: self.low > 0.0 }
    }
}

impl Show {
    /// The quantity and its unit; `None` for what has no scale.
    pub fn title(self) -> Option<&'static str> {
        match self {
            Show::Radiance | Show::Elements => None,
            Show::Illuminance => Some("illuminance, lux"),
            Show::Indirect => Some("indirect illuminance, lux"),
            Show::Stale => Some("indirect light still off by this share"),
        }
    }

    /// Refuses options that would have no effect.
    pub fn check(self, range: bool, exposure: bool) -> Result<(), Failure> {
        if range && self.title().is_none() {
            return Err(Failure::input("--range: only illuminance, indirect and stale are drawn on a scale; see --show"));
        }
        if exposure && self != Show::Radiance {
            return Err(Failure::input("--exposure: only radiance is exposed; give --range for false colours"));
        }
        Ok(())
    }

    /// Values of the first and the last false colour, if nothing else is known; `None` for what has no scale.
    pub fn usual_range(self) -> Option<Range> {
        match self {
            Show::Radiance | Show::Elements => None,
            Show::Illuminance | Show::Indirect => Some(Range { low: 1.0, high: 1000.0 }),
            Show::Stale => Some(Range { low: 0.0, high: 1.0 }),
        }
    }

    /// How it is drawn.
    pub fn settings(self, [width, height]: [u32; 2], grid: u32, range: Option<Range>, exposure: Option<f32>) -> Settings {
        let parts = match self {
            Show::Radiance => Parts::RADIANCE,
            Show::Illuminance => Parts::IRRADIANCE,
            Show::Indirect | Show::Stale => Parts::INDIRECT_IRRADIANCE,
            Show::Elements => Parts::ELEMENT_COLOURS,
        };
        let look = match (self.usual_range(), self) {
            (Some(usual), _) => range.unwrap_or(usual).look(),
            (None, Show::Elements) => Look::Plain,
            // EV100 = log2(L / (K / S)) with saturation at 1.2 · 2^EV cd/m² (ISO 12232; Lagarde and de Rousiers 2014, §5.1.3).
            (None, _) => Look::Photograph { exposure: exposure.map(|ev| 1.0 / (1.2 * ev.exp2())) },
        };
        Settings { width, height, grid, parts, look }
    }

    /// The same with a scale that fits what was drawn: from a hundredth of its end, a round number, on. `None` if it stays as it is.
    pub fn ranged(
        self,
        settings: &Settings,
        wanted: bool,
        samples: impl FnOnce() -> Result<Vec<[f32; 4]>, RasterError>,
    ) -> Result<Option<Settings>, Failure> {
        if !wanted || !matches!(self, Show::Illuminance | Show::Indirect) {
            return Ok(None);
        }
        let seen = samples()?.into_iter().filter(|s| s[3] > 0.0);
        let mut lux: Vec<f32> = seen.map(|[r, g, b, _]| 0.2126 * r + 0.7152 * g + 0.0722 * b).collect();
        lux.sort_by(f32::total_cmp);
        // Beside a lamp a few pixels are far brighter than any other.
        let high = round_up(lux.get(lux.len() * 99 / 100).copied().unwrap_or(0.0));
        Ok(Some(Settings { look: Range { low: high / 100.0, high }.look(), ..*settings }))
    }
}

/// The next 1, 2 or 5 times a power of ten.
fn round_up(value: f32) -> f32 {
    if !(value > 0.0 && value.is_finite()) {
        return 1.0;
    }
    let ten = 10f32.powf(value.log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|m| m * ten).into_iter().find(|r| *r >= value * 0.9999).unwrap_or(10.0 * ten)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_scales_are_round() {
        assert_eq!([0.3, 1.0, 130.0, 501.0, 0.0].map(round_up), [0.5, 1.0, 200.0, 1000.0, 1.0]);
    }
}
