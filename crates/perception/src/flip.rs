//! How visibly two pictures differ when a viewer flips between them in place.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild 2020, "FLIP: A Difference Evaluator for Alternating Images",
//! <https://doi.org/10.1145/3406183>, computed by the authors' own C++ (crate `nv-flip`). The pooled figures are ours: exact,
//! from the error map, where `nv-flip` reads percentiles off a histogram.

use image::{ImageBuffer, Luma, Rgb, RgbImage};

/// Pixels in one degree of the viewer's visual angle: 67, a screen 0.7 m wide with 3840 pixels a row, seen from 0.7 m.
/// Higher is a viewer farther away, who sees less of small differences; lower is one who looks closer and sees more.
pub const PIXELS_PER_DEGREE: f32 = nv_flip::DEFAULT_PIXELS_PER_DEGREE;

/// FLIP's error of each pixel: 0 where nobody sees a difference, 1 where it could not be larger. Rows from the top.
pub type ErrorMap = ImageBuffer<Luma<f32>, Vec<f32>>;

/// How visibly a test picture differs from its reference.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Mean of the error map, 0 to 1: the authors' choice where one number has to do.
    pub mean: f64,
    /// 99.9th percentile of the error map, 0 to 1: the smallest error that at least 99.9 % of the pixels do not exceed.
    /// In pictures of fewer than 1000 pixels that is the largest error.
    pub percentile_999: f64,
    /// The error of each pixel.
    pub error_map: ErrorMap,
}

/// Two pictures that cannot be compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// Sizes differ, both in pixels (width, height).
    #[error("pictures of different sizes: the reference has {} × {} pixels, the test {} × {}", reference.0, reference.1, test.0, test.1)]
    Sizes {
        /// The reference's size.
        reference: (u32, u32),
        /// The test picture's size.
        test: (u32, u32),
    },
    /// No pixels: width and height.
    #[error("empty pictures: {0} × {1} pixels")]
    Empty(u32, u32),
}

impl Comparison {
    /// The error map in the colour map magma, as FLIP's authors show it: black where nothing shows, through purple and orange
    /// to pale yellow where the pictures differ most.
    pub fn picture(&self) -> RgbImage {
        let magma = nv_flip::magma_lut().to_vec();
        let (colours, _) = magma.as_chunks::<3>();
        let colour = |x, y| colours[(self.error_map.get_pixel(x, y)[0] * 255.0).round() as u8 as usize];
        RgbImage::from_fn(self.error_map.width(), self.error_map.height(), |x, y| Rgb(colour(x, y)))
    }
}

/// Compares two sRGB pictures of one size, as seen at [`PIXELS_PER_DEGREE`]. Fails when sizes differ or there are no pixels.
pub fn compare(reference: &RgbImage, test: &RgbImage) -> Result<Comparison, CompareError> {
    let (width, height) = reference.dimensions();
    if test.dimensions() != (width, height) {
        return Err(CompareError::Sizes { reference: (width, height), test: test.dimensions() });
    }
    if width == 0 || height == 0 {
        return Err(CompareError::Empty(width, height));
    }
    let flip_image = |picture| nv_flip::FlipImageRgb8::with_data(width, height, picture);
    let errors = nv_flip::flip(flip_image(reference), flip_image(test), PIXELS_PER_DEGREE).to_vec();

    let mean = errors.iter().map(|&error| f64::from(error)).sum::<f64>() / errors.len() as f64;
    let percentile_999 = percentile_999(&errors);
    let error_map = ErrorMap::from_raw(width, height, errors).expect("one error for each pixel");
    Ok(Comparison { mean, percentile_999, error_map })
}

/// The value of nearest rank: ⌈0.999 n⌉ = n − ⌊n / 1000⌋ of the n values are not larger.
fn percentile_999(errors: &[f32]) -> f64 {
    let mut sorted = errors.to_vec();
    sorted.sort_unstable_by(f32::total_cmp);
    f64::from(sorted[sorted.len() - sorted.len() / 1000 - 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(width: u32, height: u32, colour: [u8; 3]) -> RgbImage {
        RgbImage::from_pixel(width, height, Rgb(colour))
    }

    /// Colours that change from pixel to pixel.
    fn pattern(width: u32, height: u32) -> RgbImage {
        RgbImage::from_fn(width, height, |x, y| Rgb([(x * 5) as u8, (y * 7) as u8, (x * y) as u8]))
    }

    #[test]
    fn identical_pictures_do_not_differ() {
        let picture = pattern(50, 40);
        let same = compare(&picture, &picture).unwrap();
        assert_eq!((same.mean, same.percentile_999), (0.0, 0.0));
        assert_eq!(same.error_map, ErrorMap::new(50, 40));
        assert!(same.picture().pixels().all(|pixel| pixel == same.picture().get_pixel(0, 0)));
    }

    /// One red pixel in grey: noticed where it is, not elsewhere, and the map has the pictures' shape.
    #[test]
    fn a_single_different_pixel_is_noticed_where_it_is() {
        let grey = plain(60, 40, [128; 3]);
        let mut spot = grey.clone();
        spot.put_pixel(45, 10, Rgb([255, 0, 0]));
        let seen = compare(&grey, &spot).unwrap();
        let error = |x, y| seen.error_map.get_pixel(x, y)[0];
        assert_eq!(seen.error_map.dimensions(), (60, 40));
        assert!(error(45, 10) > 0.2, "{}", error(45, 10));
        assert_eq!([error(10, 10), error(45, 35), error(10, 30)], [0.0; 3]);
        let brightness = |x, y| seen.picture().get_pixel(x, y).0.iter().map(|&c| u32::from(c)).sum::<u32>();
        assert!(brightness(45, 10) > brightness(10, 10) + 100);
        let sum: f64 = seen.error_map.iter().map(|&error| f64::from(error)).sum();
        assert!((seen.mean - sum / 2400.0).abs() < 1e-12);
    }

    /// Without edges or colour, FLIP is a closed form: the lightness difference 100 to the power q_c = 0.7; up to p_c = 0.4 of the
    /// largest such difference (41.28, green against blue) fills the errors up to p_t = 0.95, the rest what remains.
    #[test]
    fn black_against_white_is_near_the_most() {
        let seen = compare(&plain(30, 30, [0; 3]), &plain(30, 30, [255; 3])).unwrap();
        let exact = 0.95 + 0.05 * (100f64.powf(0.7) - 0.4 * 41.28) / (0.6 * 41.28);
        assert!((seen.mean - exact).abs() < 1e-3, "{} is not {exact}", seen.mean);
        assert!((seen.percentile_999 - seen.mean).abs() < 1e-5);
    }

    /// The largest difference that FLIP knows is green against blue: not above 1, in the last colour of the map.
    #[test]
    fn green_against_blue_is_the_most() {
        let seen = compare(&plain(8, 8, [0, 255, 0]), &plain(8, 8, [0, 0, 255])).unwrap();
        assert!((seen.percentile_999 - 1.0).abs() < 1e-4, "{}", seen.percentile_999);
        assert_eq!(seen.picture().get_pixel(4, 4).0, [252, 253, 191]);
    }

    #[test]
    fn which_is_the_reference_does_not_matter() {
        let (a, b) = (pattern(40, 50), plain(40, 50, [90, 120, 60]));
        let (ab, ba) = (compare(&a, &b).unwrap(), compare(&b, &a).unwrap());
        assert!(ab.mean > 0.1);
        assert!((ab.mean - ba.mean).abs() < 1e-6 && (ab.percentile_999 - ba.percentile_999).abs() < 1e-6);
    }

    #[test]
    fn percentile_is_exact() {
        let descending = |n: u32| (1..=n).rev().map(|i| i as f32).collect::<Vec<_>>();
        for (n, value) in [(1, 1.0), (999, 999.0), (1000, 999.0), (1001, 1000.0), (2000, 1998.0), (10_000, 9990.0)] {
            assert_eq!(percentile_999(&descending(n)), value, "of {n} values");
        }
    }

    #[test]
    fn pictures_that_cannot_be_compared_are_refused() {
        let error = compare(&plain(4, 3, [0; 3]), &plain(3, 4, [0; 3])).unwrap_err();
        assert_eq!(error.to_string(), "pictures of different sizes: the reference has 4 × 3 pixels, the test 3 × 4");
        assert_eq!(compare(&RgbImage::new(0, 5), &RgbImage::new(0, 5)), Err(CompareError::Empty(0, 5)));
    }
}
