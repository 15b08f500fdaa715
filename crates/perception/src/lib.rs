//! What a viewer can notice: how visibly two pictures differ, for tests of images and for the accuracy of views; and how far textures
//! hide errors of the light.
//!
//! A texture's [`Luminance`] has contrast in octaves ([`bands()`]); weighed with what an eye sees ([`contrast_sensitivity`]) it raises the
//! threshold at which errors of the light become visible ([`Masking`], [`cache_folder`]). On a plain surface that threshold is
//! [`threshold_step`].
//!
//! Two pictures of one size become a [`Comparison`] by [`compare`]: FLIP's error of every pixel, its mean, its 99.9th percentile.
//! The mean says how much the pictures differ as a whole; the percentile catches a small place that differs a lot, like a lost
//! shadow, which the mean of a large picture hides. [`check_against_golden`] is a whole image test: it reads the picture that
//! should have been drawn, compares, and when the difference shows, leaves what was drawn, what was expected and the error map
//! in a folder for people to look at.
//!
//! ```
//! use lightmend_perception::compare;
//! let grey = image::RgbImage::from_pixel(64, 64, image::Rgb([128; 3]));
//! let mut spot = grey.clone();
//! image::imageops::replace(&mut spot, &image::RgbImage::from_pixel(3, 3, image::Rgb([255, 0, 0])), 30, 30);
//! let seen = compare(&grey, &spot)?;
//! assert!(seen.mean < 0.02 && seen.percentile_999 > 0.3); // little of the picture, but it shows
//! # Ok::<(), lightmend_perception::CompareError>(())
//! ```

mod bands;
mod cache;
mod flip;
mod golden;
mod masking;
mod sensitivity;

pub use bands::{Band, Luminance, bands};
pub use cache::cache_folder;
pub use flip::{CompareError, Comparison, ErrorMap, PIXELS_PER_DEGREE, compare};
pub use golden::{GoldenError, MEAN_LIMIT, PERCENTILE_999_LIMIT, check_against_golden};
pub use masking::{Masking, MeshLimit, map as masking_map, masking};
pub use sensitivity::{contrast_sensitivity, threshold_step};
