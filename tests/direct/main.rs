//! Direct light, textures and the interpolation of indirect light, pixel by pixel against closed forms.

mod diagrams;
mod goniometric;
mod interpolated;
mod isotropic;
mod lamps;
mod textured;

/// Leaves a picture of signed errors behind: red is too much, blue too little, full at `most`; grey where nothing was compared.
fn leave_errors(name: &str, size: u32, most: f64, errors: impl Iterator<Item = (usize, f64)>) -> String {
    let mut picture = image::RgbImage::from_pixel(size, size, image::Rgb([96; 3]));
    for (index, error) in errors {
        let part = |x: f64| (255.0 * (x / most).clamp(0.0, 1.0)) as u8;
        picture.put_pixel(index as u32 % size, index as u32 / size, image::Rgb([part(error), 0, part(-error)]));
    }
    let path = format!("{}/{name}.png", env!("CARGO_TARGET_TMPDIR"));
    picture.save(&path).unwrap();
    path
}
