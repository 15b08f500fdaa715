//! From linear light to what a screen shows: exposure, tone curve, false colours. Twin of `tone.wgsl`.

use bytemuck::{Pod, Zeroable};

/// How radiance becomes a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Look {
    /// Exposure, Reinhard's curve on luminance with white at 4 (Reinhard et al. 2002, Eq. 4), sRGB.
    Photograph {
        /// Factor of radiance, per cd/m². `None`: what makes the logarithmic mean of all that is not black come out at middle grey
        /// (0.18, before the curve 0.22).
        exposure: Option<f32>,
    },
    /// False colours of the luminance of what is drawn.
    FalseColours {
        /// The value of the first colour.
        low: f32,
        /// The value of the last colour.
        high: f32,
        /// Whether equal ratios are equal steps; then both values must be positive.
        logarithmic: bool,
    },
    /// Colours as they are, in sRGB.
    Plain,
}

/// False colours from least to most, sRGB: dark blue over green to yellow; brighter is more also in grey, and for the colour-blind.
pub const FALSE_COLOURS: [[u8; 3]; 9] = [
    [36, 10, 62],
    [56, 38, 117],
    [53, 79, 139],
    [40, 114, 142],
    [31, 149, 139],
    [56, 182, 120],
    [127, 211, 78],
    [205, 225, 40],
    [255, 250, 150],
];

/// As the shader reads it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct GpuTone {
    grid: u32,
    kind: u32,
    exposure: f32,
    low: f32,
    high: f32,
    unused: [f32; 3],
    colours: [[f32; 4]; 9],
}

impl GpuTone {
    /// For a picture with `grid`² samples a pixel.
    pub fn new(look: Look, grid: u32) -> GpuTone {
        let (kind, exposure, low, high) = match look {
            Look::Photograph { exposure } => (0, exposure.unwrap_or(0.0), 0.0, 1.0),
            Look::FalseColours { low, high, logarithmic } => (1 + u32::from(logarithmic), 0.0, low, high),
            Look::Plain => (3, 0.0, 0.0, 1.0),
        };
        let colours = FALSE_COLOURS.map(|rgb| {
            let [r, g, b] = rgb.map(|c| f32::from(c) / 255.0);
            [r, g, b, 1.0]
        });
        GpuTone { grid, kind, exposure, low, high, unused: [0.0; 3], colours }
    }

    /// Whether the exposure is measured.
    pub fn measures(&self) -> bool {
        self.kind == 0 && self.exposure == 0.0
    }
}
