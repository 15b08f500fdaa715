//! Contrast of a repeated picture by octaves of spatial frequency.
//!
//! Cosine-log filters and local contrast after Peli, "Contrast in complex images", 1990: the filters of two neighbouring octaves add up
//! to 1, and a band's contrast is what it brings ÷ the local mean of all lower bands. The amplitude is that of the monogenic signal
//! (Felsberg and Sommer 2001), so that a grating has the same contrast at its slopes as at its crests. Filters work on the spectrum:
//! a texture is periodic, and so is that.

use rayon::prelude::*;
use rustfft::{Fft, FftPlannerScalar, num_complex::Complex64};
use std::{f64::consts::PI, sync::Arc};

/// Luminance of a picture that is repeated over the plane, row by row.
#[derive(Debug, Clone)]
pub struct Luminance {
    /// Texels in a row.
    pub width: usize,
    /// One per texel, in linear light; the unit does not matter.
    pub values: Vec<f64>,
}

/// An octave of a picture.
#[derive(Debug, Clone)]
pub struct Band {
    /// Its centre, cycles per texel; it reaches from half of that to twice that.
    pub frequency: f64,
    /// Amplitude ÷ local mean, per texel, at most 1.
    pub contrast: Vec<f64>,
}

/// Contrasts are rounded to multiples of this, far below what anybody sees: rounding of the transforms does not reach the result.
const STEP: f64 = 1.0 / (1 << 24) as f64;

/// The octaves of a picture up to `limit` (cycles per texel), finest first; what lies above it is taken away first.
pub fn bands(picture: &Luminance, limit: f64) -> Vec<Band> {
    let (width, height) = (picture.width, picture.values.len() / picture.width);
    let mean = picture.values.iter().sum::<f64>() / picture.values.len() as f64;
    let (least, most) = picture.values.iter().fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
    if least >= most {
        return Vec::new();
    }
    let mut planner = FftPlannerScalar::new();
    let mut spectrum: Vec<Complex64> = picture.values.iter().map(|v| Complex64::new(*v, 0.0)).collect();
    transform(&mut spectrum, &planner.plan_fft_forward(width), &planner.plan_fft_forward(height));
    let scale = 1.0 / picture.values.len() as f64;
    let back = [planner.plan_fft_inverse(width), planner.plan_fft_inverse(height)];
    // The spectrum lies column by column.
    let filtered = |filter: &(dyn Fn(f64, f64, f64) -> Complex64 + Sync)| {
        let mut picture = vec![Complex64::default(); spectrum.len()];
        picture.par_chunks_exact_mut(height).enumerate().for_each(|(column, values)| {
            let x = wave_number(column, width);
            for (row, value) in values.iter_mut().enumerate() {
                let y = wave_number(row, height);
                let frequency = x.hypot(y);
                if frequency <= limit {
                    *value = spectrum[column * height + row] * filter(frequency, x, y) * scale;
                }
            }
        });
        transform(&mut picture, &back[1], &back[0]);
        picture
    };
    let coarsest = 0.5 / width.max(height) as f64;
    let centres = (1..).map(|octave| 0.5f64.powi(octave)).skip_while(|f| *f > limit).take_while(|f| *f > coarsest);
    centres
        .map(|centre| {
            // Both are real: one transform for two.
            let both = filtered(&|f, _, _| Complex64::new(gain(f, centre), below(f, centre)));
            let across = filtered(&|f, x, y| match f {
                0.0 => Complex64::default(),
                f => Complex64::new(y, -x) * (gain(f, centre) / f),
            });
            let contrast = both.iter().zip(&across).map(|(both, across)| {
                let amplitude = (both.re * both.re + across.norm_sqr()).sqrt();
                let contrast = amplitude / both.im.max(mean * 1e-3);
                (contrast / STEP).round().min(1.0 / STEP) * STEP
            });
            Band { frequency: centre, contrast: contrast.collect() }
        })
        .collect()
}

/// Of the octave around `centre`, at `frequency`.
fn gain(frequency: f64, centre: f64) -> f64 {
    let octaves = (frequency / centre).log2();
    if octaves.abs() < 1.0 { 0.5 + 0.5 * (PI * octaves).cos() } else { 0.0 }
}

/// Of all octaves below that around `centre`, and the mean.
fn below(frequency: f64, centre: f64) -> f64 {
    if frequency <= centre / 2.0 {
        1.0
    } else if frequency < centre {
        1.0 - gain(frequency, centre)
    } else {
        0.0
    }
}

/// Cycles per texel of a place of the spectrum.
fn wave_number(place: usize, places: usize) -> f64 {
    let signed = if 2 * place > places { place as f64 - places as f64 } else { place as f64 };
    signed / places as f64
}

/// Along rows, then along columns; what lay row by row lies column by column then.
fn transform(values: &mut Vec<Complex64>, rows: &Arc<dyn Fft<f64>>, columns: &Arc<dyn Fft<f64>>) {
    let (width, height) = (rows.len(), columns.len());
    values.par_chunks_exact_mut(width).for_each(|row| rows.process(row));
    let mut turned = vec![Complex64::default(); values.len()];
    turned.par_chunks_exact_mut(height).enumerate().for_each(|(x, column)| {
        column.iter_mut().enumerate().for_each(|(y, value)| *value = values[y * width + x]);
        columns.process(column);
    });
    *values = turned;
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// 1 + contrast · cos(2π (x · cycles + y · cycles)) for each grating (cycles per picture along x and y, contrast).
    pub fn gratings(width: usize, height: usize, gratings: &[(f64, f64, f64)]) -> Luminance {
        let value = |place: usize| {
            let (x, y) = ((place % width) as f64 / width as f64, (place / width) as f64 / height as f64);
            1.0 + gratings.iter().map(|(u, v, c)| c * (2.0 * PI * (u * x + v * y) + 0.3).cos()).sum::<f64>()
        };
        Luminance { width, values: (0..width * height).map(value).collect() }
    }

    #[test]
    fn band_contrast_is_that_of_the_grating() {
        // Rectangular, and of a size that is no power of two, too.
        for (width, height) in [(128, 128), (96, 160)] {
            for (u, v, contrast) in [(8.0, 0.0, 0.4), (0.0, 12.0, 0.05), (11.0, 7.0, 0.9), (3.0, 0.0, 0.2)] {
                let frequency = (u / width as f64).hypot(v / height as f64);
                let found = bands(&gratings(width, height, &[(u, v, contrast)]), 0.5);
                for band in &found {
                    // Where the grating is part of the local mean too, contrast at a crest differs from that in a trough.
                    if below(frequency, band.frequency) > 0.0 {
                        continue;
                    }
                    let right = contrast * gain(frequency, band.frequency);
                    let off = band.contrast.iter().map(|c| (c - right).abs()).fold(0.0, f64::max);
                    assert!(off <= 0.05 * right + 1e-6, "{u} {v}: {} against {right}, off {off}", band.frequency);
                }
                let best = found.iter().map(|band| gain(frequency, band.frequency)).fold(0.0, f64::max);
                assert!(best >= 0.5, "no band holds {u} {v}");
            }
        }
    }

    #[test]
    fn what_the_mesh_cannot_show_changes_nothing() {
        let coarse = gratings(128, 128, &[(4.0, 0.0, 0.3)]);
        let fine = gratings(128, 128, &[(4.0, 0.0, 0.3), (40.0, 9.0, 0.5), (0.0, 17.0, 0.2)]);
        let contrast = |picture| bands(picture, 0.125).into_iter().map(|band| band.contrast).collect::<Vec<_>>();
        assert_eq!(contrast(&coarse), contrast(&fine), "to the bit");
        assert_ne!(bands(&coarse, 0.5)[1].contrast, bands(&fine, 0.5)[1].contrast);
    }
}
