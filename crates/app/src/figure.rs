//! Figures: panels of curves as SVG and PNG, with legend and units, readable without the program.

use crate::{failure::Failure, output};
use plotters::{coord::Shift, prelude::*, style::FontStyle};
use std::{io::Write, ops::Range, path::Path};

/// One curve.
pub struct Curve {
    /// Its name in the legend; the same name has the same colour in all figures.
    pub name: &'static str,
    /// Its points; x above 0 if the panel's axis is logarithmic.
    pub points: Vec<(f64, f64)>,
}

/// One panel of a figure.
pub struct Panel {
    /// What it shows.
    pub title: String,
    /// Quantity and unit along x.
    pub across: String,
    /// Quantity and unit along y, from 0 on if that axis is linear.
    pub upwards: String,
    /// Its axes.
    pub axes: Axes,
    /// The curves.
    pub curves: Vec<Curve>,
}

/// Which axes are logarithmic; points that have no place on such an axis are left out.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Axes {
    /// Neither.
    Linear,
    /// x.
    LogX,
    /// Both.
    LogLog,
}

/// What was written.
#[derive(Default)]
pub struct Figure {
    /// The text of the SVG.
    pub svg: String,
    /// Panels that were left out.
    pub left_out: usize,
}

const PANEL: (u32, u32) = (620, 400);

/// Height of a line below the panels.
const NOTE: u32 = 24;

/// More panels than this nobody looks at in one picture; the CSV has them all.
const MOST_PANELS: usize = 24;

/// The name of a curve that bounds others: thin and black.
pub const BOUND: &str = "1.1 × drained";

/// Registered once: PNG needs a font of its own, an SVG takes the reader's.
const FONT: &str = "sans-serif";

/// Writes `stem`.svg and `stem`.png, two panels in a row, with `note` below them; nothing if there are no panels.
pub fn write(out: &Path, stem: &str, panels: &[Panel], note: Option<&str>) -> Result<Figure, Failure> {
    let left_out = panels.len().saturating_sub(MOST_PANELS);
    let panels = &panels[..panels.len() - left_out];
    if panels.is_empty() {
        return Ok(Figure::default());
    }
    register_font();
    let columns = if panels.len() == 1 { 1 } else { 2 };
    let height = PANEL.1 * (panels.len() as u32).div_ceil(columns);
    let size = (PANEL.0 * columns, height + note.map_or(0, |_| NOTE));
    let fault = |e: &dyn std::fmt::Display| Failure::failed(format!("the figure cannot be drawn: {e}"));

    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
    draw_all(&area, panels, columns, note).map_err(|e| fault(&e))?;
    drop(area);
    output::write(&out.join(format!("{stem}.svg")), |file| file.write_all(svg.as_bytes()))?;

    let mut pixels = vec![0; (size.0 * size.1 * 3) as usize];
    let area = BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area();
    draw_all(&area, panels, columns, note).map_err(|e| fault(&e))?;
    drop(area);
    let picture = image::RgbImage::from_raw(size.0, size.1, pixels).ok_or_else(|| Failure::failed("the figure has no pixels"))?;
    output::png(&out.join(format!("{stem}.png")), &picture)?;
    Ok(Figure { svg, left_out })
}

fn register_font() {
    // Failing means only that the font was registered before.
    let _ = plotters::style::register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT);
}

/// A picture with black text on it; places are upper left corners, pixels.
pub fn with_text(mut picture: image::RgbImage, labels: &[(String, [u32; 2])]) -> Result<image::RgbImage, Failure> {
    register_font();
    let size = picture.dimensions();
    {
        let area = BitMapBackend::with_buffer(&mut picture, size).into_drawing_area();
        let style = (FONT, 15).into_font().color(&BLACK);
        let drawn = labels.iter().try_for_each(|(text, [x, y])| area.draw_text(text, &style, (*x as i32, *y as i32)));
        drawn.and_then(|()| area.present()).map_err(|e| Failure::failed(format!("text cannot be drawn: {e}")))?;
    }
    Ok(picture)
}

type Drawn<B> = Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

fn draw_all<B: DrawingBackend>(area: &DrawingArea<B, Shift>, panels: &[Panel], columns: u32, note: Option<&str>) -> Drawn<B> {
    area.fill(&WHITE)?;
    let rows = (panels.len() as u32).div_ceil(columns);
    let (above, below) = area.split_vertically(PANEL.1 * rows);
    if let Some(note) = note {
        below.draw_text(note, &(FONT, 13).into_font().color(&RGBColor(60, 60, 60)), (14, 3))?;
    }
    for (place, panel) in above.split_evenly((rows as usize, columns as usize)).iter().zip(panels) {
        draw(place, panel)?;
    }
    area.present()
}

fn colour(name: &str) -> RGBColor {
    match name {
        "ledger" => RGBColor(150, 40, 160),
        "stateless" => RGBColor(200, 60, 30),
        "random" => RGBColor(120, 120, 120),
        "oracle" => RGBColor(20, 130, 60),
        "P" => RGBColor(120, 120, 120),
        "V" => RGBColor(20, 130, 60),
        "V 1/Te" => RGBColor(120, 180, 60),
        "items" => RGBColor(150, 40, 160),
        "foreseen, items" => RGBColor(0, 0, 0),
        BOUND => RGBColor(0, 0, 0),
        _ => RGBColor(40, 80, 190),
    }
}

fn draw<B: DrawingBackend>(place: &DrawingArea<B, Shift>, panel: &Panel) -> Drawn<B> {
    let (log_x, log_y) = (panel.axes != Axes::Linear, panel.axes == Axes::LogLog);
    let shown = |p: &(f64, f64)| (!log_x || p.0 > 0.0) && (!log_y || p.1 > 0.0);
    let points = || panel.curves.iter().flat_map(|c| c.points.iter()).filter(|p| shown(p));
    let last = points().map(|p| p.0).fold(1e-9, f64::max);
    let first = points().filter(|p| p.0 > 0.0 && p.1 > 0.0).map(|p| p.0).fold(last / 10.0, f64::min);
    let top = points().map(|p| p.1).fold(1e-9, f64::max);
    let bottom = points().filter(|p| p.1 > 0.0).map(|p| p.1).fold(top, f64::min);
    let mut builder = ChartBuilder::on(place);
    builder.caption(&panel.title, (FONT, 15)).margin(12).x_label_area_size(42).y_label_area_size(52);
    // The kinds of axes are so many types: the same steps for all.
    macro_rules! draw_on {
        ($chart:expr) => {{
            let mut chart = $chart;
            chart
                .configure_mesh()
                .x_desc(&panel.across)
                .y_desc(&panel.upwards)
                .x_label_formatter(&label)
                .y_label_formatter(&label)
                .label_style((FONT, 13))
                .axis_desc_style((FONT, 14))
                .light_line_style(WHITE)
                .draw()?;
            for curve in &panel.curves {
                let style = colour(curve.name).stroke_width(if curve.name == BOUND { 1 } else { 2 });
                let points = curve.points.iter().copied().filter(|p| shown(p));
                chart
                    .draw_series(LineSeries::new(points, style))?
                    .label(curve.name)
                    .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
            }
            let corner = match panel.axes {
                Axes::Linear => SeriesLabelPosition::UpperRight,
                Axes::LogX => SeriesLabelPosition::UpperLeft,
                Axes::LogLog => SeriesLabelPosition::UpperRight,
            };
            chart
                .configure_series_labels()
                .position(corner)
                .background_style(WHITE.mix(0.85))
                .border_style(RGBColor(180, 180, 180))
                .label_font((FONT, 13))
                .draw()?;
        }};
    }
    let logarithmic = |range: Range<f64>| range.clone().log_scale().with_key_points(round(&range));
    let x = first * 0.8..last * 1.1;
    match panel.axes {
        Axes::Linear => draw_on!(builder.build_cartesian_2d(0.0..last, 0.0..top * 1.05)?),
        Axes::LogX => draw_on!(builder.build_cartesian_2d(logarithmic(x), 0.0..top)?),
        Axes::LogLog => draw_on!(builder.build_cartesian_2d(logarithmic(x), logarithmic(bottom * 0.8..top * 1.25))?),
    }
    Ok(())
}

/// Where a logarithmic axis has labels: 1, 2 and 5 times powers of ten; powers of ten alone where there are many.
fn round(range: &Range<f64>) -> Vec<f64> {
    let [first, last] = [range.start, range.end].map(|end| end.log10().floor() as i32);
    let steps: &[f64] = if last - first > 3 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let places = (first..=last).flat_map(|tens| steps.iter().map(move |step| step * 10f64.powi(tens)));
    places.filter(|place| range.contains(place)).collect()
}

fn label(x: &f64) -> String {
    if *x == 0.0 || (0.01..10_000.0).contains(x) { format!("{}", (x * 100.0).round() / 100.0) } else { format!("{x:.0e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithmic_axes_have_round_labels() {
        let told = |range| round(&range).iter().map(label).collect::<Vec<_>>();
        assert_eq!(told(0.013..0.6), ["0.02", "0.05", "0.1", "0.2", "0.5"]);
        assert_eq!(told(0.01..300.0), ["0.01", "0.1", "1", "10", "100"]);
        assert_eq!(told(8e3..6e5), ["1e4", "2e4", "5e4", "1e5", "2e5", "5e5"]);
        assert_eq!(told(0.002..0.0061), ["2e-3", "5e-3"]);
    }
}
