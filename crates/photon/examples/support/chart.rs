//! Panels of curves, with legend and units.

use crate::picture::{Drawn, FONT, Picture};
use plotters::{coord::Shift, element::DashedPathElement, prelude::*};

/// How a curve is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stroke {
    Solid,
    Dashed,
    Dotted,
}

/// One curve.
pub struct Curve {
    /// Its name in the legend.
    pub name: String,
    pub colour: RGBColor,
    pub stroke: Stroke,
    pub points: Vec<(f64, f64)>,
}

/// One panel of a figure; both axes begin at 0.
pub struct Panel {
    /// What it shows.
    pub title: String,
    /// Quantity and unit along x.
    pub across: String,
    /// Quantity and unit along y.
    pub upwards: String,
    pub curves: Vec<Curve>,
}

/// Panels, `columns` in a row.
pub struct Panels {
    pub columns: u32,
    pub panels: Vec<Panel>,
}

const PANEL: (u32, u32) = (620, 400);

impl Panels {
    fn rows(&self) -> u32 {
        (self.panels.len() as u32).div_ceil(self.columns)
    }
}

impl Picture for Panels {
    fn size(&self) -> (u32, u32) {
        (PANEL.0 * self.columns, PANEL.1 * self.rows())
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Drawn<B> {
        let places = area.split_evenly((self.rows() as usize, self.columns as usize));
        places.iter().zip(&self.panels).try_for_each(|(place, panel)| draw_panel(place, panel))
    }
}

fn draw_panel<B: DrawingBackend>(place: &DrawingArea<B, Shift>, panel: &Panel) -> Drawn<B> {
    let points = || panel.curves.iter().flat_map(|c| c.points.iter());
    let last = points().map(|p| p.0).fold(1e-9, f64::max);
    let top = points().map(|p| p.1).fold(1e-9, f64::max);
    let mut chart = ChartBuilder::on(place)
        .caption(&panel.title, (FONT, 16))
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(58)
        .build_cartesian_2d(0.0..last, 0.0..top * 1.05)?;
    chart
        .configure_mesh()
        .x_desc(&panel.across)
        .y_desc(&panel.upwards)
        .y_label_formatter(&|y| format!("{y:.0}"))
        .label_style((FONT, 13))
        .axis_desc_style((FONT, 14))
        .light_line_style(WHITE)
        .draw()?;
    for curve in &panel.curves {
        let style = curve.colour.stroke_width(2);
        let points = thinned(&curve.points, 2.0 * last / f64::from(PANEL.0));
        let (size, spacing) = match curve.stroke {
            Stroke::Solid => (1, 0),
            Stroke::Dashed => (8, 5),
            Stroke::Dotted => (2, 5),
        };
        let series = if curve.stroke == Stroke::Solid {
            chart.draw_series(LineSeries::new(points, style))?
        } else {
            chart.draw_series(DashedLineSeries::new(points, size, spacing, style))?
        };
        series.label(&curve.name).legend(move |(x, y)| DashedPathElement::new(vec![(x, y), (x + 24, y)], size, spacing, style));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerRight)
        .legend_area_size(32)
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(180, 180, 180))
        .label_font((FONT, 13))
        .draw()
}

/// Points at least `step` apart along x, and the last.
fn thinned(points: &[(f64, f64)], step: f64) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = Vec::new();
    for (n, point) in points.iter().enumerate() {
        if n + 1 == points.len() || kept.last().is_none_or(|last| point.0 - last.0 >= step) {
            kept.push(*point);
        }
    }
    kept
}
