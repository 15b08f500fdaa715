//! Figures: curves as SVG and PNG, with legend and units, readable without the program.

use crate::{failure::Failure, output, replay::Chapter};
use plotters::{coord::Shift, prelude::*, style::FontStyle};
use std::{io::Write, path::Path};

const PANEL: (u32, u32) = (620, 400);

/// Registered once: PNG needs a font of its own, an SVG takes the reader's.
const FONT: &str = "sans-serif";

/// Writes recovery.svg and recovery.png: a panel per edit, the share of relevant photons repaired against rays.
pub fn recovery(out: &Path, scene: &str, chapters: &[Chapter]) -> Result<(), Failure> {
    if chapters.is_empty() {
        return Ok(());
    }
    // Failing means only that the font was registered before.
    let _ = plotters::style::register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT);
    let columns = if chapters.len() == 1 { 1 } else { 2 };
    let size = (PANEL.0 * columns, PANEL.1 * (chapters.len() as u32).div_ceil(columns));
    let fault = |e: &dyn std::fmt::Display| Failure::failed(format!("the figure cannot be drawn: {e}"));

    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
    panels(&area, scene, chapters, columns).map_err(|e| fault(&e))?;
    drop(area);
    output::write(&out.join("recovery.svg"), |file| file.write_all(svg.as_bytes()))?;

    let mut pixels = vec![0; (size.0 * size.1 * 3) as usize];
    let area = BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area();
    panels(&area, scene, chapters, columns).map_err(|e| fault(&e))?;
    drop(area);
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_raw(size.0, size.1, pixels)
        .ok_or_else(|| Failure::failed("the figure has no pixels"))?
        .write_to(&mut png, image::ImageFormat::Png)
        .map_err(|e| fault(&e))?;
    output::write(&out.join("recovery.png"), |file| file.write_all(png.get_ref()))
}

type Drawn<B> = Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

fn panels<B: DrawingBackend>(area: &DrawingArea<B, Shift>, scene: &str, chapters: &[Chapter], columns: u32) -> Drawn<B> {
    area.fill(&WHITE)?;
    let rows = (chapters.len() as u32).div_ceil(columns);
    for (panel, chapter) in area.split_evenly((rows as usize, columns as usize)).iter().zip(chapters) {
        draw(panel, scene, chapter)?;
    }
    area.present()
}

fn colour(order: &str) -> RGBColor {
    match order {
        "stateless" => RGBColor(200, 60, 30),
        "random" => RGBColor(120, 120, 120),
        "oracle" => RGBColor(20, 130, 60),
        _ => RGBColor(40, 80, 190),
    }
}

fn draw<B: DrawingBackend>(panel: &DrawingArea<B, Shift>, scene: &str, chapter: &Chapter) -> Drawn<B> {
    let moments = || chapter.tracks.iter().flat_map(|t| t.recovery.moments.iter()).filter(|m| m.work.rays > 0);
    let oracle = chapter.oracle_rays();
    let unit = oracle.unwrap_or(1) as f64;
    let longest = moments().map(|m| m.work.rays as f64 / unit).fold(1e-3, f64::max);
    let shortest = moments().filter(|m| m.repaired > 0).map(|m| m.work.rays as f64 / unit).fold(longest / 10.0, f64::min);
    let title = format!("{scene}, {} ({} of {} photons relevant)", chapter.title, chapter.relevant, chapter.photons);
    let mut chart = ChartBuilder::on(panel)
        .caption(title, (FONT, 15))
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(52)
        .build_cartesian_2d((shortest * 0.8..longest * 1.1).log_scale(), 0.0..100.0)?;
    let across = if oracle.is_some() { "rays traced, multiples of the oracle's total" } else { "rays traced" };
    chart
        .configure_mesh()
        .x_desc(across)
        .y_desc("relevant photons repaired, %")
        .x_label_formatter(&|x| {
            if *x >= 0.01 && *x < 10_000.0 { format!("{}", (*x * 100.0).round() / 100.0) } else { format!("{x:.0e}") }
        })
        .label_style((FONT, 13))
        .axis_desc_style((FONT, 14))
        .light_line_style(WHITE)
        .draw()?;
    let relevant = chapter.relevant.max(1) as f64;
    for track in &chapter.tracks {
        let style = colour(track.order).stroke_width(2);
        let points = track.recovery.moments.iter().filter(|m| m.work.rays > 0);
        let line = points.map(|m| (m.work.rays as f64 / unit, m.repaired as f64 / relevant * 100.0));
        chart
            .draw_series(LineSeries::new(line, style))?
            .label(track.order)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(180, 180, 180))
        .label_font((FONT, 13))
        .draw()?;
    Ok(())
}
