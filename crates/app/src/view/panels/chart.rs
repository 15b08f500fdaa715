//! What is better looked at than read: the recovery of the last edit, a lamp's polar diagram, the false colours.

use crate::view::recovery::Trace;
use egui::{Align2, Color32, FontId, Pos2, Rect, Sense, Stroke, Ui, Vec2, pos2, vec2};
use lightmend_raster::FALSE_COLOURS;
use lightmend_scene::Photometry;

const PHOTONS: Color32 = Color32::from_rgb(90, 150, 250);
const CHANGE: Color32 = Color32::from_rgb(250, 130, 70);

fn font() -> FontId {
    FontId::proportional(11.0)
}

/// A length of time that is a round number and not less.
fn round_up(seconds: f64) -> f64 {
    let ten = 10f64.powf(seconds.max(0.01).log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * ten).find(|t| *t >= seconds * 0.999).unwrap_or(seconds)
}

/// What is outstanding after the last edit, over time.
pub fn recovery(ui: &mut Ui, trace: &Trace, size: Vec2) {
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
    let plot = Rect::from_min_max(rect.min + vec2(30.0, 8.0), rect.max - vec2(8.0, 18.0));
    let weak = ui.visuals().weak_text_color();
    let last = trace.photons.last().map_or(0.0, |p| p[0]).max(trace.exact_after.unwrap_or(0.0));
    let end = round_up(last.max(0.5));
    let top = trace.change.iter().map(|p| p[1]).fold(1.0, f64::max);
    let place = |[seconds, share]: [f64; 2]| {
        pos2(plot.left() + (seconds / end) as f32 * plot.width(), plot.bottom() - (share / top) as f32 * plot.height())
    };
    for share in [0.0, 0.5, 1.0] {
        let y = place([0.0, share]).y;
        painter.hline(plot.x_range(), y, Stroke::new(0.5, weak));
        painter.text(pos2(plot.left() - 3.0, y), Align2::RIGHT_CENTER, format!("{:.0} %", 100.0 * share), font(), weak);
    }
    painter.text(plot.left_bottom() + vec2(0.0, 3.0), Align2::LEFT_TOP, "0", font(), weak);
    painter.text(plot.right_bottom() + vec2(0.0, 3.0), Align2::RIGHT_TOP, format!("{end} s"), font(), weak);
    for (points, colour) in [(&trace.photons, PHOTONS), (&trace.change, CHANGE)] {
        painter.line(points.iter().map(|p| place(*p)).collect::<Vec<Pos2>>(), Stroke::new(1.5, colour));
    }
    let legend = |n: f32, text: &str, colour: Color32| {
        painter.text(plot.right_top() + vec2(0.0, 12.0 * n), Align2::RIGHT_TOP, text, font(), colour);
    };
    legend(0.0, "photons outstanding", PHOTONS);
    if !trace.change.is_empty() {
        legend(1.0, "visible change outstanding", CHANGE);
    }
    let five = trace.until(0.05).map(|five| format!("5 % of the change outstanding after {five:.1} s"));
    let eye = trace.complete_after.map(|eye| format!("complete for the eye after {eye:.1} s"));
    let exact = trace.exact_after.map_or("not exact yet".to_owned(), |exact| format!("exact after {exact:.1} s"));
    ui.weak(five.into_iter().chain(eye).chain([exact]).collect::<Vec<_>>().join(", "));
    response.on_hover_text(
        "Since the last edit. Blue: share of the pool that is still to be re-shot. Orange, known once the light is exact: how far the picture's indirect light was from exact, as a share of how far it was when the edit began",
    );
}

/// Luminous intensity over γ in two planes: C 0–180 and C 90–270, straight below at the bottom.
pub fn polar(ui: &mut Ui, photometry: &Photometry, size: Vec2) {
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
    let centre = rect.center();
    let radius = rect.height().min(rect.width()) / 2.0 - 14.0;
    let weak = ui.visuals().weak_text_color();
    let most = photometry.max_candela().max(1e-9);
    for ring in 1..=4 {
        painter.circle_stroke(centre, radius * ring as f32 / 4.0, Stroke::new(0.5, weak));
    }
    for spoke in 0..12 {
        let way = Vec2::angled(spoke as f32 * std::f32::consts::TAU / 12.0);
        painter.line_segment([centre, centre + way * radius], Stroke::new(0.3, weak));
    }
    painter.text(centre + vec2(3.0, radius), Align2::LEFT_BOTTOM, format!("{most:.0} cd"), font(), weak);
    for (c, colour) in [(0.0, CHANGE), (90.0, PHOTONS)] {
        let points = (-180..=180).map(|gamma| {
            let gamma = f64::from(gamma);
            let plane = if gamma < 0.0 { c + 180.0 } else { c };
            let share = (photometry.candela_at(plane, gamma.abs()) / most) as f32;
            let (sin, cos) = (gamma as f32).to_radians().sin_cos();
            centre + vec2(sin, cos) * radius * share
        });
        painter.line(points.collect::<Vec<Pos2>>(), Stroke::new(1.5, colour));
        let line = if c == 0.0 { 0.0 } else { 12.0 };
        painter.text(
            rect.left_top() + vec2(4.0, 3.0 + line),
            Align2::LEFT_TOP,
            format!("C{c:.0}–C{:.0}", c + 180.0),
            font(),
            colour,
        );
    }
    response.on_hover_text(
        "Luminous intensity by direction, straight below at the bottom, in the lamp's own axes: C0 is +x, C90 is +y",
    );
}

/// False colours, from least to most.
pub fn colours(ui: &mut Ui, size: Vec2) {
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(rect);
    let columns = rect.width().max(1.0) as usize;
    let last = FALSE_COLOURS.len() - 1;
    for column in 0..columns {
        let at = column as f32 / columns as f32 * last as f32;
        let n = (at as usize).min(last - 1);
        let [a, b] = [FALSE_COLOURS[n], FALSE_COLOURS[n + 1]];
        let [red, green, blue] =
            [0, 1, 2].map(|c| (f32::from(a[c]) + (f32::from(b[c]) - f32::from(a[c])) * (at - n as f32)) as u8);
        let x = rect.left() + column as f32;
        painter.rect_filled(
            Rect::from_min_max(pos2(x, rect.top()), pos2(x + 1.0, rect.bottom())),
            0.0,
            Color32::from_rgb(red, green, blue),
        );
    }
}
