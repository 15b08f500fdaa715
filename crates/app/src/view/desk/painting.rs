//! What is painted over the room: lamps, as what can be clicked, and messages.

use super::{Desk, SELECTED};
use crate::view::{messages::Kind, panels, session::Selection};
use egui::{Align2, Color32, FontId, Rect, Stroke, Ui, vec2};

impl Desk {
    /// Lamps, as what can be clicked.
    pub(super) fn marks(&mut self, ui: &Ui) {
        let painter = ui.painter_at(self.viewport.rect);
        for mark in self.viewport.marks(&mut self.session) {
            let lamp = self.session.configuration.lamp(mark.lamp);
            let selected = self.session.selection == Some(Selection::Lamp(mark.lamp));
            let hovered = self.viewport.hovered == Some(Selection::Lamp(mark.lamp));
            if !mark.near && !selected {
                continue;
            }
            let colour = if lamp.lit { panels::screen_colour(lamp.intensity) } else { Color32::from_gray(70) };
            painter.circle(mark.at, 5.0, colour, Stroke::new(1.5, Color32::from_black_alpha(200)));
            for n in 0..8 {
                let ray = egui::Vec2::angled(n as f32 * std::f32::consts::TAU / 8.0);
                painter.line_segment([mark.at + ray * 7.0, mark.at + ray * 10.0], Stroke::new(1.5, colour));
            }
            if selected || hovered {
                painter.circle_stroke(mark.at, 12.0, Stroke::new(2.0, SELECTED));
                painter.text(
                    mark.at + vec2(16.0, 0.0),
                    Align2::LEFT_CENTER,
                    &lamp.name,
                    FontId::proportional(13.0),
                    Color32::WHITE,
                );
            }
        }
    }

    /// What the program has to say, over the room; nothing that can be clicked.
    pub(super) fn messages(&mut self, ui: &Ui) {
        let painter = ui.painter_at(self.viewport.rect);
        let mut bottom = self.viewport.rect.left_bottom() + vec2(12.0, -12.0);
        let width = (self.viewport.rect.width() - 40.0).max(10.0);
        if let Some(rest) = self.session.messages.next_goes_in() {
            ui.ctx().request_repaint_after(rest);
        }
        let shown: Vec<(Kind, String)> = self.session.messages.current().map(|(kind, text)| (kind, text.to_owned())).collect();
        for (kind, text) in shown.into_iter().rev() {
            let colour = match kind {
                Kind::Note => Color32::from_gray(235),
                Kind::Warning => Color32::from_rgb(255, 205, 110),
                Kind::Failure => Color32::from_rgb(255, 140, 120),
            };
            let text = painter.layout(text, FontId::proportional(14.0), colour, width);
            let place = Rect::from_min_size(bottom - vec2(0.0, text.size().y), text.size());
            painter.rect_filled(place.expand(6.0), 4.0, Color32::from_black_alpha(190));
            painter.galley(place.min, text, colour);
            bottom.y = place.min.y - 16.0;
        }
    }
}
