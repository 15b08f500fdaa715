//! Image tests: what was drawn against the picture that a person once looked at and kept, the golden picture.
//!
//! Drawing differs a little between graphics cards and drivers, so pictures are compared as a viewer would, not bit by bit.

use crate::{CompareError, Comparison, compare};
use image::{ImageError, RgbImage};
use std::path::{Path, PathBuf};

/// Largest mean FLIP error of an accepted picture, 0 to 1. Higher lets more change all over the picture, lower refuses what no more
/// than another driver does. Measured on a 640 × 480 view of the room: a random level up or down in all 8-bit values is
/// accepted (0.014); one level up in all of them is refused (0.035), for FLIP is steep near 0.
pub const MEAN_LIMIT: f64 = 0.02;

/// Largest 99.9th percentile of the FLIP error of an accepted picture, 0 to 1. Higher lets larger things be wrong, lower refuses
/// edges that fall a little to the side. Measured on the same view: edges a quarter pixel to the side are accepted (0.22), half a
/// pixel is refused (0.34), and so is a square of 25 × 25 pixels with values a quarter lower (0.49), whose mean is 0.001.
pub const PERCENTILE_999_LIMIT: f64 = 0.3;

/// An image test that fails. `Display` is one line that says what to look at.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GoldenError {
    /// There is no golden picture yet.
    #[error("no golden picture {}: look at {} and, if it is right, copy it there", golden.display(), drawn.display())]
    Missing {
        /// Where the golden picture should be.
        golden: PathBuf,
        /// What was drawn, written for people to look at.
        drawn: PathBuf,
    },
    /// The pictures differ visibly: see NAME.png, NAME.golden.png and NAME.flip.png in the folder.
    #[error(
        "{name} differs from its golden picture: mean FLIP {mean:.4} (at most {MEAN_LIMIT}), \
         99.9th percentile {percentile_999:.4} (at most {PERCENTILE_999_LIMIT}); pictures in {}",
        leave.display()
    )]
    Differs {
        /// The test's name.
        name: String,
        /// Mean FLIP error, 0 to 1.
        mean: f64,
        /// 99.9th percentile of the FLIP error, 0 to 1.
        percentile_999: f64,
        /// The folder with the three pictures.
        leave: PathBuf,
    },
    /// The pictures cannot be compared: see NAME.png and NAME.golden.png in the folder.
    #[error("{name} cannot be compared with its golden picture: {why}; pictures in {}", leave.display())]
    Compare {
        /// The test's name.
        name: String,
        /// What is wrong with their sizes.
        why: CompareError,
        /// The folder with the two pictures.
        leave: PathBuf,
    },
    /// A picture cannot be read or written.
    #[error("{}: {why}", path.display())]
    File {
        /// The picture or its folder.
        path: PathBuf,
        /// The reason, from the system or the decoder.
        why: String,
    },
}

/// Accepts `picture` if a viewer would hardly notice that it is not the PNG file `golden`: mean FLIP error at most [`MEAN_LIMIT`]
/// and 99.9th percentile at most [`PERCENTILE_999_LIMIT`].
///
/// Writes nothing when it accepts. When the pictures differ, the folder `leave`, made if need be, gets `name`.png (what was
/// drawn), `name`.golden.png (what was expected) and `name`.flip.png (the error map in the colour map magma, if sizes agree).
/// Without a golden picture it gets `name`.png, to look at and to copy.
pub fn check_against_golden(name: &str, golden: &Path, picture: &RgbImage, leave: &Path) -> Result<Comparison, GoldenError> {
    let write = |drawn: &RgbImage, suffix: &str| {
        let path = leave.join(format!("{name}{suffix}"));
        std::fs::create_dir_all(leave).map_err(|why| file(leave, why))?;
        drawn.save(&path).map_err(|why| file(&path, why))?;
        Ok(path)
    };
    let expected = match image::open(golden) {
        Ok(expected) => expected.into_rgb8(),
        Err(ImageError::IoError(why)) if why.kind() == std::io::ErrorKind::NotFound => {
            return Err(GoldenError::Missing { golden: golden.to_owned(), drawn: write(picture, ".png")? });
        }
        Err(why) => return Err(file(golden, why)),
    };
    let leave_both = || {
        write(picture, ".png")?;
        write(&expected, ".golden.png")
    };

    let comparison = match compare(&expected, picture) {
        Ok(comparison) => comparison,
        Err(why) => {
            leave_both()?;
            return Err(GoldenError::Compare { name: name.to_owned(), why, leave: leave.to_owned() });
        }
    };
    let Comparison { mean, percentile_999, .. } = comparison;
    if mean <= MEAN_LIMIT && percentile_999 <= PERCENTILE_999_LIMIT {
        return Ok(comparison);
    }
    leave_both()?;
    write(&comparison.picture(), ".flip.png")?;
    Err(GoldenError::Differs { name: name.to_owned(), mean, percentile_999, leave: leave.to_owned() })
}

fn file(path: &Path, why: impl ToString) -> GoldenError {
    GoldenError::File { path: path.to_owned(), why: why.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;

    /// A golden picture of 64 × 64 grey pixels in a folder of its own, and a folder to leave pictures in, not yet made.
    fn golden() -> (tempfile::TempDir, PathBuf, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let (golden, leave) = (folder.path().join("golden.png"), folder.path().join("deep/left"));
        RgbImage::from_pixel(64, 64, Rgb([128; 3])).save(&golden).unwrap();
        (folder, golden, leave)
    }

    /// The golden picture with a square of another grey in it.
    fn square(size: u32, level: u8) -> RgbImage {
        let inside = |x, y| x < size && y < size;
        RgbImage::from_fn(64, 64, |x, y| Rgb([if inside(x, y) { level } else { 128 }; 3]))
    }

    fn left(leave: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            std::fs::read_dir(leave).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_passing_picture_leaves_nothing() {
        let (_folder, golden, leave) = golden();
        let comparison = check_against_golden("grey", &golden, &square(16, 131), &leave).unwrap();
        assert!(comparison.mean > 0.0);
        assert!(!leave.exists());
    }

    #[test]
    fn a_small_large_difference_fails_by_the_percentile_and_leaves_three_pictures() {
        let (_folder, golden, leave) = golden();
        let drawn = square(4, 255);
        let error = check_against_golden("grey", &golden, &drawn, &leave).unwrap_err();
        let GoldenError::Differs { mean, percentile_999, .. } = &error else { panic!("{error}") };
        assert!(*mean <= MEAN_LIMIT && *percentile_999 > PERCENTILE_999_LIMIT, "{error}");
        let line = format!(
            "grey differs from its golden picture: mean FLIP {mean:.4} (at most 0.02), 99.9th percentile {percentile_999:.4} \
             (at most 0.3); pictures in {}",
            leave.display()
        );
        assert_eq!(error.to_string(), line);

        assert_eq!(left(&leave), ["grey.flip.png", "grey.golden.png", "grey.png"]);
        let read = |name: &str| image::open(leave.join(name)).unwrap().into_rgb8();
        let expected = image::open(&golden).unwrap().into_rgb8();
        assert_eq!((read("grey.png"), read("grey.golden.png")), (drawn.clone(), expected.clone()));
        assert_eq!(read("grey.flip.png"), compare(&expected, &drawn).unwrap().picture());
    }

    #[test]
    fn a_little_everywhere_fails_by_the_mean() {
        let (_folder, golden, leave) = golden();
        let error = check_against_golden("grey", &golden, &square(64, 130), &leave).unwrap_err();
        let GoldenError::Differs { mean, percentile_999, .. } = error else { panic!("{error}") };
        assert!(mean > MEAN_LIMIT && percentile_999 <= PERCENTILE_999_LIMIT);
    }

    #[test]
    fn another_size_fails_and_leaves_both_pictures() {
        let (_folder, golden, leave) = golden();
        let error = check_against_golden("grey", &golden, &RgbImage::new(32, 64), &leave).unwrap_err().to_string();
        assert!(error.contains("64 × 64") && error.contains("32 × 64") && error.contains("left"), "{error}");
        assert_eq!(left(&leave), ["grey.golden.png", "grey.png"]);
    }

    #[test]
    fn a_missing_golden_picture_says_how_to_make_it() {
        let (folder, _, leave) = golden();
        let (golden, picture) = (folder.path().join("none.png"), square(4, 255));
        let error = check_against_golden("new", &golden, &picture, &leave).unwrap_err();
        let drawn = leave.join("new.png");
        assert_eq!(error, GoldenError::Missing { golden: golden.clone(), drawn: drawn.clone() });
        assert!(error.to_string().contains(&drawn.display().to_string()));
        std::fs::copy(&drawn, &golden).unwrap();
        assert_eq!(check_against_golden("new", &golden, &picture, &leave).unwrap().mean, 0.0);
    }

    #[test]
    fn a_broken_golden_picture_is_named() {
        let (_folder, golden, leave) = golden();
        std::fs::write(&golden, "no picture").unwrap();
        let error = check_against_golden("grey", &golden, &square(0, 0), &leave).unwrap_err();
        assert!(matches!(&error, GoldenError::File { path, .. } if *path == golden), "{error}");
        assert!(!error.to_string().contains('\n'));
    }
}
