//! Pictures as SVG and PNG, in the colours and the font of `lightmend replay`.

use image::{
    ExtendedColorType, ImageEncoder,
    codecs::png::{CompressionType, FilterType, PngEncoder},
};
use plotters::{coord::Shift, prelude::*, style::FontStyle};
use std::{error::Error, fs::File, io::BufWriter, path::Path};

/// Registered once: PNG needs a font of its own, an SVG takes the reader's.
pub const FONT: &str = "sans-serif";

pub const RED: RGBColor = RGBColor(200, 60, 30);
pub const BLUE: RGBColor = RGBColor(40, 80, 190);
pub const GREEN: RGBColor = RGBColor(20, 130, 60);
pub const OCHRE: RGBColor = RGBColor(200, 140, 0);
pub const GREY: RGBColor = RGBColor(120, 120, 120);
pub const INK: RGBColor = RGBColor(30, 30, 30);

pub type Drawn<B> = Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

/// Something to draw, on either backend.
pub trait Picture {
    /// Width and height, pixels.
    fn size(&self) -> (u32, u32);
    /// Draws it on a white area of that size.
    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Drawn<B>;
}

/// Writes `stem`.svg and `stem`.png.
pub fn write(out: &Path, stem: &str, picture: &impl Picture) -> Result<(), Box<dyn Error>> {
    // Failing means only that the font was registered before.
    let _ = plotters::style::register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT);
    let size = picture.size();
    let mut svg = String::new();
    draw(&SVGBackend::with_string(&mut svg, size).into_drawing_area(), picture).map_err(|e| e.to_string())?;
    std::fs::write(out.join(format!("{stem}.svg")), svg)?;

    let mut pixels = vec![0; (size.0 * size.1 * 3) as usize];
    draw(&BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area(), picture).map_err(|e| e.to_string())?;
    // Paler shades of a line's edge are one: half the file, and nobody sees it.
    pixels.iter_mut().for_each(|shade| *shade = (*shade / 16) * 17);
    let file = BufWriter::new(File::create(out.join(format!("{stem}.png")))?);
    let encoder = PngEncoder::new_with_quality(file, CompressionType::Best, FilterType::NoFilter);
    Ok(encoder.write_image(&pixels, size.0, size.1, ExtendedColorType::Rgb8)?)
}

fn draw<B: DrawingBackend>(area: &DrawingArea<B, Shift>, picture: &impl Picture) -> Drawn<B> {
    area.fill(&WHITE)?;
    picture.draw(area)?;
    area.present()
}
