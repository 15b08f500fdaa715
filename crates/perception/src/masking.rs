//! Threshold elevation: how many times less visible an error of the light is on a texture than on a plain surface.
//!
//! Dmitriev et al. 2002, §5.3, after Dumont et al. 2001, Ramasubramanian et al. 1999 and Daly 1993. A texture's contrast per octave
//! ([`bands`]) times the eye's sensitivity at that octave is m, contrast in multiples of its threshold. In that octave the texture raises the
//! threshold to T = (1 + (k₁ (k₂ m)^s)^b)^(1/b) times its height (Daly's masking function, k₁ = 6^(−7/3), k₂ = 6^(10/3)). Masking acts between
//! patterns of like frequency; so frequencies above what the mesh can show of indirect light are removed before (Luebke et al. 2001),
//! and of the octaves that remain each counts with the eye's sensitivity: T_e = Σ S ÷ Σ (S ÷ T), by which an error of the same
//! contrast in all octaves becomes less visible. Octaves that the texture has nothing in count too, with T = 1. (Ramasubramanian weighs
//! octaves by the texture's own contrast; then fine strong texture would hide coarse errors, which it does not.)
//!
//! Contrast is that of linear light: a ratio, it does not depend on exposure, and a display shows it so as long as its tone curve is straight.

use crate::{
    PIXELS_PER_DEGREE,
    bands::{Band, Luminance, bands},
    sensitivity::contrast_sensitivity,
};
use lightmend_scene::{Texture, luminance};

/// Slope of the masking function over m. 0.7: textures as well known as a grating after practice; 1: noise, which masks more.
const SLOPE: f64 = 0.7;

/// How sharply the masking function bends at the threshold, 2 to 4. Lower: masking begins sooner.
const BEND: f64 = 4.0;

/// What the eye is adapted to, cd/m²: a display's white.
const ADAPTATION: f64 = 100.0;

/// The coarsest octave in which errors of light count, cycles per degree.
const COARSEST: f64 = 0.25;

/// log₂ of texels per pixel at the first level: close to a surface a texel is as large as eight pixels.
const FIRST_LEVEL: i32 = -3;

/// By how much contrast of `m` times its threshold raises the threshold of patterns of like frequency (Daly 1993).
pub fn masking(m: f64) -> f64 {
    let (k1, k2) = (6f64.powf(-7.0 / 3.0), 6f64.powf(10.0 / 3.0));
    (1.0 + (k1 * (k2 * m).powf(SLOPE)).powf(BEND)).powf(1.0 / BEND)
}

/// The finest detail of indirect light that a mesh can show, in texels: an octave, so that a texture on triangles of many sizes needs
/// few tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct MeshLimit(i32);

impl MeshLimit {
    /// Of cells that are `texels` wide: a period needs two of them. Rounded to the next lower octave.
    pub fn of_cells(texels: f64) -> MeshLimit {
        MeshLimit((0.5 / texels).log2().floor().clamp(-16.0, -1.0) as i32)
    }

    /// Cycles per texel.
    pub fn frequency(self) -> f64 {
        2f64.powi(self.0)
    }

    /// log₂ of that.
    pub fn octave(self) -> i32 {
        self.0
    }
}

/// Mean threshold elevation of a texture at each mip level.
#[derive(Debug, Clone, PartialEq)]
pub struct Masking {
    /// From [`FIRST_LEVEL`] on; at least one.
    pub(crate) levels: Vec<f32>,
}

impl Masking {
    /// Looks at a texture on a mesh.
    pub fn new(picture: &Luminance, limit: MeshLimit) -> Masking {
        let bands = bands(picture, limit.frequency());
        let most = picture.width.max(picture.values.len() / picture.width).ilog2() as i32;
        let mean = |level| {
            let map = elevation(picture.values.len(), &bands, limit, level);
            (map.iter().sum::<f64>() / map.len() as f64) as f32
        };
        Masking { levels: (FIRST_LEVEL..=most).map(mean).collect() }
    }

    /// Where a pixel covers so many texels (above 0) along an edge: that of the nearest mip level.
    pub fn at(&self, texels_per_pixel: f64) -> f32 {
        let level = texels_per_pixel.log2().round() as i32 - FIRST_LEVEL;
        self.levels[(level.max(0) as usize).min(self.levels.len() - 1)]
    }
}

/// Threshold elevation of every texel where a pixel covers `texels_per_pixel` texels along an edge.
pub fn map(picture: &Luminance, limit: MeshLimit, texels_per_pixel: f64) -> Vec<f64> {
    elevation(picture.values.len(), &bands(picture, limit.frequency()), limit, texels_per_pixel.log2().round() as i32)
}

fn elevation(texels: usize, bands: &[Band], limit: MeshLimit, level: i32) -> Vec<f64> {
    // Of a texel's cycles so many pass in a degree; finer than half a pixel nothing is shown.
    let per_degree = 2f64.powi(level) * f64::from(PIXELS_PER_DEGREE);
    let finest = limit.octave().min(-1 - level.max(0));
    let octaves: Vec<f64> =
        (-30..=finest).rev().map(|octave| 2f64.powi(octave)).take_while(|f| f * per_degree >= COARSEST).collect();
    let sensitivity: Vec<f64> = octaves.iter().map(|f| contrast_sensitivity(f * per_degree, ADAPTATION)).collect();
    let of_octave: Vec<Option<&Band>> = octaves.iter().map(|f| bands.iter().find(|band| band.frequency == *f)).collect();
    let whole: f64 = sensitivity.iter().sum();
    if whole == 0.0 {
        return vec![1.0; texels];
    }
    let at = |texel: usize| {
        let left =
            sensitivity.iter().zip(&of_octave).map(|(s, band)| s / band.map_or(1.0, |band| masking(band.contrast[texel] * s)));
        whole / left.sum::<f64>()
    };
    (0..texels).map(at).collect()
}

/// Luminance of a texture.
impl From<&Texture> for Luminance {
    fn from(texture: &Texture) -> Luminance {
        let values = texture.linear().map(|texel| luminance(texel.as_dvec3())).collect();
        Luminance { width: texture.size()[0] as usize, values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bands::tests::gratings;

    #[test]
    fn the_masking_function_is_dalys() {
        assert!((6f64.powf(-7.0 / 3.0) - 0.0153).abs() < 1e-4 && (6f64.powf(10.0 / 3.0) - 392.5).abs() < 0.05);
        assert_eq!(masking(0.0), 1.0);
        // Its two straight pieces meet at the threshold.
        assert!((masking(1.0) - 2f64.powf(0.25)).abs() < 1e-9);
        assert!((masking(1000.0) / 1000f64.powf(0.7) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_flat_texture_raises_nothing() {
        let flat = Luminance { width: 48, values: vec![0.3; 48 * 32] };
        assert!(Masking::new(&flat, MeshLimit::of_cells(1.0)).levels.iter().all(|t| *t == 1.0));
    }

    #[test]
    fn elevation_follows_the_contrast_of_a_grating() {
        let limit = MeshLimit::of_cells(1.0);
        let mut last = 1.0;
        for contrast in [0.01, 0.03, 0.1, 0.3, 0.9] {
            let picture = gratings(64, 64, &[(8.0, 0.0, contrast)]);
            let found = map(&picture, limit, 1.0);
            // By hand: of the octaves 1/2, 1/4 … cycles per texel the grating fills that of 1/8.
            let octaves = (1..).map(|o| 0.5f64.powi(o)).take_while(|f| f * f64::from(PIXELS_PER_DEGREE) >= COARSEST);
            let (mut whole, mut left) = (0.0, 0.0);
            for octave in octaves {
                let s = contrast_sensitivity(octave * f64::from(PIXELS_PER_DEGREE), ADAPTATION);
                whole += s;
                left += if octave == 0.125 { s / masking(contrast * s) } else { s };
            }
            let right = whole / left;
            assert!(found.iter().all(|t| (t / right - 1.0).abs() < 0.05), "{contrast}: {} against {right}", found[0]);
            assert!(right > last, "{contrast}: {right} after {last}");
            last = right;
        }
    }

    #[test]
    fn only_what_the_mesh_can_show_masks() {
        let limit = MeshLimit::of_cells(8.0);
        assert_eq!(limit.frequency(), 1.0 / 16.0);
        let coarse = gratings(128, 128, &[(4.0, 0.0, 0.3)]);
        let both = gratings(128, 128, &[(4.0, 0.0, 0.3), (20.0, 0.0, 0.6)]);
        assert_eq!(Masking::new(&coarse, limit), Masking::new(&both, limit), "to the bit");
        let fine = gratings(128, 128, &[(20.0, 0.0, 0.6)]);
        assert!(Masking::new(&fine, limit).levels.iter().all(|t| *t == 1.0));
        assert!(Masking::new(&coarse, limit).at(1.0) > 1.0);
    }
}
