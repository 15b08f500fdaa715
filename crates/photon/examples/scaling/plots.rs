//! Panels with logarithmic axes: points, the power law through them, and its exponent in the legend.

use crate::{
    Measured,
    picture::{self, BLUE, Drawn, FONT, GREEN, GREY, INK, OCHRE, Picture, RED},
};
use plotters::{coord::Shift, prelude::*};
use std::{error::Error, path::Path};

/// What is drawn of a table's column.
struct Curve {
    name: &'static str,
    colour: RGBColor,
    points: Vec<(f64, f64)>,
}

struct Panel {
    title: String,
    across: &'static str,
    upwards: &'static str,
    curves: Vec<Curve>,
}

/// A power law c · x^e.
struct Law {
    exponent: f64,
    log_factor: f64,
}

impl Law {
    /// By least squares in logarithms. `None` where x does not vary.
    fn through(points: &[(f64, f64)]) -> Option<Law> {
        let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
        let n = logs.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / n;
        let (x, y) = (mean(|p| p.0), mean(|p| p.1));
        let squares: f64 = logs.iter().map(|p| (p.0 - x).powi(2)).sum();
        let products: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
        (squares > 0.0).then(|| Law { exponent: products / squares, log_factor: y - products / squares * x })
    }

    fn at(&self, x: f64) -> f64 {
        (self.log_factor + self.exponent * x.ln()).exp()
    }
}

/// A curve's name, its columns added up, its colour.
type Column = (&'static str, &'static [&'static str], RGBColor);

const PURPLE: RGBColor = RGBColor(150, 40, 160);
const TEAL: RGBColor = RGBColor(0, 150, 160);

const SECONDS: [Column; 8] = [
    ("shooting", &["plain processor s"], INK),
    ("shooting with the ledger", &["ledger processor s"], GREY),
    ("scan, small", &["small scan processor s"], BLUE),
    ("scan, large", &["large scan processor s"], PURPLE),
    ("repair, small", &["small repair processor s"], GREEN),
    ("repair, large", &["large repair processor s"], OCHRE),
    ("a frame of a drag", &["small frame processor s"], TEAL),
    ("of that: the edit taken up", &["small moved processor s", "small change processor s"], RED),
];

const BYTES: [Column; 4] = [
    ("peak, resident", &["peak bytes"], INK),
    ("ledger", &["ledger bytes"], BLUE),
    ("buckets", &["buckets bytes"], GREEN),
    ("trees", &["trees bytes"], OCHRE),
];

/// Draws `scaling_pool`, `scaling_elements` and `scaling_movables`, as far as they were measured.
pub fn draw(out: &Path, measured: &[Measured]) -> Result<(), Box<dyn Error>> {
    let figures: [(&str, &[[&str; 4]]); 3] = [
        ("pool", &[["pool", "room", "photons", "photons"], ["pool", "house", "photons", "photons"]]),
        (
            "elements",
            &[
                ["elements", "room", "elements", "mesh elements"],
                ["elements", "house", "elements", "mesh elements"],
                ["triangles", "room", "triangles", "triangles"],
            ],
        ),
        ("movables", &[["movables", "hall", "movables", "movable objects"]]),
    ];
    for (stem, rows) in figures {
        let mut panels = Vec::new();
        for [axis, scene, x, across] in rows {
            let of_row: Vec<&Measured> =
                measured.iter().filter(|m| m.point.axis() == *axis && m.point.scene == *scene && m.values[*x] > 0.0).collect();
            for (columns, upwards) in [(&SECONDS[..], "processor seconds"), (&BYTES[..], "bytes")] {
                let curves: Vec<Curve> = columns.iter().filter_map(|column| curve(column, x, &of_row)).collect();
                if !curves.is_empty() {
                    panels.push(Panel {
                        title: format!("{}: {upwards} by {across}", scene.to_uppercase()),
                        across,
                        upwards,
                        curves,
                    });
                }
            }
        }
        if !panels.is_empty() {
            picture::write(out, &format!("scaling_{stem}"), &Panels(panels))?;
        }
    }
    Ok(())
}

/// `None` if it was measured at fewer than two points.
fn curve((name, columns, colour): &Column, x: &str, measured: &[&Measured]) -> Option<Curve> {
    let value = |m: &&Measured| Some((m.values[x], columns.iter().map(|c| m.values.get(*c)).sum::<Option<f64>>()?));
    let points: Vec<(f64, f64)> = measured.iter().filter_map(value).filter(|(_, y)| *y > 0.0).collect();
    (points.len() > 1).then_some(Curve { name, colour: *colour, points })
}

/// Two in a row.
struct Panels(Vec<Panel>);

const PANEL: (u32, u32) = (620, 440);

impl Picture for Panels {
    fn size(&self) -> (u32, u32) {
        (2 * PANEL.0, PANEL.1 * (self.0.len() as u32).div_ceil(2))
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Drawn<B> {
        let places = area.split_evenly((self.0.len().div_ceil(2), 2));
        places.iter().zip(&self.0).try_for_each(|(place, panel)| draw_panel(place, panel))
    }
}

fn draw_panel<B: DrawingBackend>(place: &DrawingArea<B, Shift>, panel: &Panel) -> Drawn<B> {
    let points = || panel.curves.iter().flat_map(|curve| curve.points.iter());
    let range = |of: fn(&(f64, f64)) -> f64| {
        points().map(of).fold((f64::INFINITY, 0.0), |(low, high), v| (f64::min(low, v), f64::max(high, v)))
    };
    let ((left, right), (low, high)) = (range(|p| p.0), range(|p| p.1));
    // Room for the legend above the curves.
    let legend = (high / low).powf(0.7).max(10.0);
    let mut chart = ChartBuilder::on(place)
        .caption(&panel.title, (FONT, 16))
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(62)
        .build_cartesian_2d((left / 1.3..right * 1.3).log_scale(), (low / 1.5..high * legend).log_scale())?;
    chart
        .configure_mesh()
        .x_desc(panel.across)
        .y_desc(panel.upwards)
        .x_label_formatter(&|x| format!("{x:.0e}"))
        .y_label_formatter(&|y| format!("{y:.0e}"))
        .label_style((FONT, 13))
        .axis_desc_style((FONT, 14))
        .light_line_style(WHITE)
        .draw()?;
    for Curve { name, colour, points } in &panel.curves {
        let law = Law::through(points);
        let style = colour.stroke_width(2);
        let text = law.as_ref().map_or_else(|| (*name).to_owned(), |law| format!("{name}: exponent {:.2}", law.exponent));
        let line = law.iter().flat_map(|law| points.iter().map(|(x, _)| (*x, law.at(*x))));
        chart
            .draw_series(LineSeries::new(line, style))?
            .label(text)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
        chart.draw_series(points.iter().map(|point| Circle::new(*point, 4, colour.filled())))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(180, 180, 180))
        .label_font((FONT, 13))
        .draw()
}
