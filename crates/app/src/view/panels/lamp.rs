//! A lamp: where it is, how bright, which colour, and how its light spreads.

use crate::view::{desk::Desk, dialogs::Dialog, session::Session};
use egui::{Ui, vec2};
use glam::DVec3;
use lightmend_scene::{Edit, format, luminance};
use std::path::Path;

/// Lamp number `id`.
pub fn panel(desk: &mut Desk, ui: &mut Ui, id: usize) {
    let configuration = desk.session.configuration.clone();
    let lamp = configuration.lamp(id);
    let name = lamp.name.clone();
    ui.heading(&name);
    let rated = luminance(lamp.rated);
    ui.horizontal(|ui| {
        let mut lit = lamp.lit;
        if ui.checkbox(&mut lit, "on").on_hover_text("Shows at once: no photon is re-shot").changed() {
            switch(&mut desk.session, id);
        }
        ui.weak(format!("{:.0} lm", luminance(lamp.flux())));
    });

    // Dimming keeps the colour, and recolouring the brightness.
    let bright = luminance(lamp.intensity);
    let mut dimmed = if rated > 0.0 { 100.0 * bright / rated } else { 0.0 };
    let slider = egui::Slider::new(&mut dimmed, 0.0..=200.0).suffix(" %").max_decimals(0).clamping(egui::SliderClamping::Never);
    let hint = "Of what its share of the photons follows. Shows at once. Much brighter than 100 %: its light is noisier than that of others";
    if rated > 0.0 && ui.add(slider).on_hover_text(hint).changed() {
        let colour = if bright > 0.0 { lamp.intensity / bright } else { lamp.rated / rated };
        let edit = Edit::Light { lamp: name.clone(), intensity: colour * (dimmed.max(0.0) / 100.0 * rated) };
        desk.session.go_on(&format!("Dim {name}"), edit);
    }
    ui.horizontal(|ui| {
        let strongest = lamp.intensity.max_element();
        let mut rgb = (lamp.intensity / strongest.max(1e-12)).to_array().map(|c| c as f32);
        if ui.color_edit_button_rgb(&mut rgb).on_hover_text("Colour; shows at once, the brightness stays").changed() {
            let colour = DVec3::from_array(rgb.map(f64::from));
            recolour(&mut desk.session, id, colour);
        }
        let mut kelvin = nearest_kelvin(lamp.intensity);
        let number = egui::DragValue::new(&mut kelvin).range(1500.0..=12000.0).speed(20.0).suffix(" K").max_decimals(0);
        if ui.add(number).on_hover_text("The nearest colour temperature of a black body; pull to take it").changed() {
            recolour(&mut desk.session, id, black_body(kelvin));
        }
    });

    ui.label("Position");
    let mut position = lamp.pose.position;
    if super::triple(ui, &mut position, 0.01, " m", 4, "Pull, or double-click and type; or drag its mark in the room") {
        desk.session.go_on(&format!("Move lamp {name}"), Edit::MoveLamp { lamp: name.clone(), to: position });
    }
    ui.label("Rotation");
    let mut rotation = lamp.pose.rotation;
    if super::triple(ui, &mut rotation, 0.5, "°", 3, "About x, then y, then z") {
        desk.session.go_on(&format!("Turn lamp {name}"), Edit::TurnLamp { lamp: name.clone(), to: rotation });
    }

    ui.add_space(4.0);
    ui.horizontal(|ui| {
        match &lamp.entry.photometry {
            Some(file) => ui.label(file.rsplit('/').next().unwrap_or(file)).on_hover_text(file),
            None => ui.label("shines alike in all directions"),
        };
        if ui.button("Photometry…").on_hover_text("An LM-63 (IES) file. All photons may have to be shot anew").clicked() {
            desk.dialog = Some(Dialog::photometry(&desk.session, id));
        }
        if lamp.photometry.is_some()
            && ui.small_button("None").on_hover_text("Alike in all directions, with the same flux").clicked()
        {
            relamp(&mut desk.session, id, None);
        }
    });
    if let Some(photometry) = &lamp.photometry {
        super::chart::polar(ui, photometry, vec2(ui.available_width().min(260.0), 200.0));
        let flux = photometry.luminous_flux();
        ui.weak(format!("{flux:.0} lm, peak {:.0} cd, as the file states it", photometry.max_candela()));
    }
}

/// On or off.
pub fn switch(session: &mut Session, id: usize) {
    let lamp = session.configuration.lamp(id);
    let (name, on) = (lamp.name.clone(), !lamp.lit);
    let title = format!("Switch {name} {}", if on { "on" } else { "off" });
    session.perform(title, vec![Edit::Switch { lamp: name, on }]);
}

/// Another colour, as bright as before.
fn recolour(session: &mut Session, id: usize, colour: DVec3) {
    let lamp = session.configuration.lamp(id);
    let bright = luminance(colour);
    if bright > 0.0 {
        let intensity = colour * (luminance(lamp.intensity) / bright);
        let name = lamp.name.clone();
        session.go_on(&format!("Colour of {name}"), Edit::Light { lamp: name, intensity });
    }
}

/// Another photometric file, or none; its colour stays. A first file says how bright it is; without one the flux stays.
pub fn relamp(session: &mut Session, id: usize, file: Option<&Path>) {
    let lamp = session.configuration.lamp(id);
    let name = lamp.name.clone();
    let colour = if luminance(lamp.intensity) > 0.0 { lamp.intensity / luminance(lamp.intensity) } else { DVec3::ONE };
    let (photometry, intensity) = match file {
        Some(path) => {
            let folder = session.scene.path.parent().unwrap_or(Path::new("")).to_owned();
            match format::path_from(&folder, path) {
                // From file to file it stays as dimmed and coloured as it is.
                Ok(path) => (Some(path), lamp.photometry.is_none().then_some(colour)),
                Err(error) => return session.messages.fail(error.to_string()),
            }
        }
        None => {
            // As if it were on; one that is dimmed to nothing shines as it is rated.
            let factor = if luminance(lamp.intensity) > 0.0 { lamp.intensity } else { lamp.rated };
            let flux = lamp.photometry.as_ref().map_or(4.0 * std::f64::consts::PI, |p| p.luminous_flux());
            let candela = luminance(factor) * flux / (4.0 * std::f64::consts::PI);
            (None, Some(colour * candela))
        }
    };
    let title = match &photometry {
        Some(file) => format!("{name}: {}", file.rsplit('/').next().unwrap_or(file)),
        None => format!("{name}: no photometry"),
    };
    session.perform(title, vec![Edit::Relamp { lamp: name, photometry, intensity }]);
}

/// Linear Rec. 709 of a black body, the strongest channel 1. CIE 1931 chromaticity by the cubic fits of Kim et al. (2002, US patent
/// 7024034), from 1667 K on.
fn black_body(kelvin: f64) -> DVec3 {
    let t = 1000.0 / kelvin.clamp(1667.0, 25000.0);
    let x = if t >= 0.25 {
        -0.2661239 * t.powi(3) - 0.2343589 * t.powi(2) + 0.8776956 * t + 0.179910
    } else {
        -3.0258469 * t.powi(3) + 2.1070379 * t.powi(2) + 0.2226347 * t + 0.240390
    };
    let y = if kelvin < 2222.0 {
        -1.1063814 * x.powi(3) - 1.34811020 * x.powi(2) + 2.18555832 * x - 0.20219683
    } else if kelvin < 4000.0 {
        -0.9549476 * x.powi(3) - 1.37418593 * x.powi(2) + 2.09137015 * x - 0.16748867
    } else {
        3.0817580 * x.powi(3) - 5.87338670 * x.powi(2) + 3.75112997 * x - 0.37001483
    };
    let (big_x, big_z) = (x / y, (1.0 - x - y) / y);
    let rgb = DVec3::new(
        3.2404542 * big_x - 1.5371385 - 0.4985314 * big_z,
        -0.9692660 * big_x + 1.8760108 + 0.0415560 * big_z,
        0.0556434 * big_x - 0.2040259 + 1.0572252 * big_z,
    );
    let rgb = rgb.max(DVec3::ZERO);
    rgb / rgb.max_element()
}

/// The temperature whose share of red is nearest.
fn nearest_kelvin(colour: DVec3) -> f64 {
    let ratio = |c: DVec3| (c.x.max(1e-6) / (c.y + c.z).max(1e-6)).ln();
    let wanted = ratio(colour);
    let steps = (0..=105).map(|n| 1500.0 + 100.0 * f64::from(n));
    steps
        .min_by(|a, b| (ratio(black_body(*a)) - wanted).abs().total_cmp(&(ratio(black_body(*b)) - wanted).abs()))
        .unwrap_or(6500.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn black_bodies_go_from_red_over_white_to_blue() {
        let [warm, white, cold] = [2000.0, 6500.0, 12000.0].map(black_body);
        assert!(warm.x == 1.0 && warm.z < 0.15, "{warm}");
        assert!(white.min_element() > 0.93, "{white}");
        assert!(cold.z == 1.0 && cold.x < 0.8, "{cold}");
        for kelvin in [1700.0, 2700.0, 4000.0, 6500.0, 10000.0] {
            assert!((nearest_kelvin(black_body(kelvin)) - kelvin).abs() <= 50.0, "{kelvin}");
        }
    }
}
