//! The panel at the right: what is selected, how the light is, how it is shown.

mod chart;
mod lamp;
mod light;
mod object;
mod picture;

pub use lamp::{relamp, switch};
pub use light::{Rates, outstanding_percent, state_line};

use super::{desk::Desk, session::Selection};
use egui::{CollapsingHeader, Color32, Ui};
use glam::DVec3;

/// All of it.
pub fn all(desk: &mut Desk, ui: &mut Ui) {
    ui.add_space(4.0);
    match desk.session.selection {
        Some(Selection::Object(id)) => object::panel(desk, ui, id),
        Some(Selection::Lamp(id)) => lamp::panel(desk, ui, id),
        None => nothing(desk, ui),
    }
    ui.separator();
    CollapsingHeader::new("Light").default_open(true).show(ui, |ui| light::panel(desk, ui));
    CollapsingHeader::new("Picture").default_open(true).show(ui, |ui| picture::panel(desk, ui));
}

/// Nothing is selected: what there is to select.
fn nothing(desk: &mut Desk, ui: &mut Ui) {
    ui.weak("Click an object or a lamp, or choose one:");
    let mut chosen = None;
    CollapsingHeader::new("Lamps").default_open(true).show(ui, |ui| {
        let mut lamps: Vec<(usize, String)> =
            desk.session.configuration.lamps().map(|(id, lamp)| (id, lamp.name.clone())).collect();
        lamps.sort_by(|a, b| a.1.cmp(&b.1));
        for (id, name) in lamps {
            if ui.selectable_label(false, name).clicked() {
                chosen = Some(Selection::Lamp(id));
            }
        }
    });
    CollapsingHeader::new("Objects").show(ui, |ui| {
        let objects = desk.session.configuration.objects();
        let mut objects: Vec<(usize, String, bool)> =
            objects.map(|(id, object)| (id, object.name.clone(), object.movable)).collect();
        objects.sort_by(|a, b| (!a.2, &a.1).cmp(&(!b.2, &b.1)));
        for (id, name, movable) in objects {
            let text = if movable { egui::RichText::new(name) } else { egui::RichText::new(name).weak() };
            if ui.selectable_label(false, text).clicked() {
                chosen = Some(Selection::Object(id));
            }
        }
    });
    if chosen.is_some() {
        desk.session.selection = chosen;
    }
}

/// A linear colour as a screen shows it, as bright as it can be.
pub fn screen_colour(linear: DVec3) -> Color32 {
    let [r, g, b] = (linear / linear.max_element().max(1e-12)).to_array().map(|c| c as f32);
    Color32::from(egui::Rgba::from_rgb(r, g, b))
}

/// Three numbers in a row that can be pulled and typed. Whether they changed.
fn triple(ui: &mut Ui, value: &mut DVec3, speed: f64, suffix: &str, decimals: usize, hint: &str) -> bool {
    let mut changed = false;
    ui.horizontal(|ui| {
        for (axis, name) in value.as_mut().iter_mut().zip(["x ", "y ", "z "]) {
            let number = egui::DragValue::new(axis).speed(speed).prefix(name).suffix(suffix).max_decimals(decimals);
            changed |= ui.add(number).on_hover_text(hint).changed();
        }
    });
    changed
}
