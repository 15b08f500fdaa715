//! How the light is shown: what of it, how bright, how often.

use crate::{
    frames::{Range, Show},
    view::{commands::Command, desk::Desk},
};
use egui::{DragValue, Slider, Ui, vec2};

/// All of it.
pub fn panel(desk: &mut Desk, ui: &mut Ui) {
    let choices = [
        (Command::Radiance, Show::Radiance, "camera"),
        (Command::Illuminance, Show::Illuminance, "lux"),
        (Command::Indirect, Show::Indirect, "indirect lux"),
        (Command::Elements, Show::Elements, "elements"),
        (Command::Stale, Show::Stale, "still wrong"),
    ];
    ui.horizontal_wrapped(|ui| {
        for (command, show, name) in choices {
            let hint = super::super::commands::TABLE.iter().find(|e| e.command == command).map_or("", |e| e.hint);
            if ui.selectable_label(desk.show == show, name).on_hover_text(hint).clicked() {
                desk.run(command);
            }
        }
    });
    match desk.show {
        Show::Radiance => exposure(desk, ui),
        Show::Elements => {}
        _ => scale(desk, ui),
    }
    let slider =
        Slider::new(&mut desk.fps, 1.0..=240.0).logarithmic(true).clamping(egui::SliderClamping::Edits).text("frames a second");
    let hint = "While something moves. More: smoother, drawn more coarsely, and fewer photons; fewer: finer, and light is right sooner. At rest it is drawn as finely as the window shows";
    ui.add(slider).on_hover_text(hint);
    pace(desk, ui);
}

fn exposure(desk: &mut Desk, ui: &mut Ui) {
    ui.horizontal(|ui| {
        let mut automatic = desk.exposure.is_none();
        if ui.checkbox(&mut automatic, "automatic exposure").on_hover_text("The logarithmic mean becomes middle grey").changed() {
            desk.exposure = if automatic { None } else { Some(6.0) };
        }
        if let Some(ev) = &mut desk.exposure {
            ui.add(DragValue::new(ev).speed(0.05).range(-20.0..=30.0).prefix("EV ").max_decimals(2))
                .on_hover_text("Exposure value at ISO 100. Higher: darker; a living room at night is about 5, an office 8");
        }
    });
}

fn scale(desk: &mut Desk, ui: &mut Ui) {
    let usual = desk.show.usual_range().or(desk.found_range);
    let mut range = desk.range.or(desk.found_range).or(usual).unwrap_or(Range { low: 1.0, high: 1000.0 });
    super::chart::colours(ui, vec2(ui.available_width(), 14.0));
    ui.horizontal(|ui| {
        let before = range;
        let pull = range.high / 300.0;
        ui.add(DragValue::new(&mut range.low).speed(pull).range(0.0..=before.high * 0.99).max_decimals(2));
        ui.label("to");
        ui.add(DragValue::new(&mut range.high).speed(pull).range(before.low.max(1e-3) * 1.01..=1e7).max_decimals(2));
        ui.label(if desk.show == Show::Stale { "of it" } else { "lux" });
        if range != before {
            desk.range = Some(range);
        }
        if desk.range.is_some() && ui.small_button("fit").on_hover_text("What suits what is seen now").clicked() {
            (desk.range, desk.found_range) = (None, None);
        }
    });
}

fn pace(desk: &Desk, ui: &mut Ui) {
    let pace = &desk.pace;
    let now = if pace.fps > 0.0 { format!("{:.0} frames/s", pace.fps) } else { "at rest".to_owned() };
    let [width, height] = pace.pixels;
    let samples = if pace.samples > 1 { format!(", {0}×{0} samples", pace.samples) } else { String::new() };
    ui.label(format!("{now}; {:.0} ms a frame, longest {:.0}", pace.frame, pace.longest));
    ui.weak(format!("{width}×{height} pixels{samples}"));
    egui::CollapsingHeader::new("Frame by pass").id_salt("passes").show(ui, |ui| {
        egui::Grid::new("pace").num_columns(2).show(ui, |ui| {
            let times = &pace.times;
            for (name, ms) in [
                ("events, panels", pace.desk),
                ("silhouettes, uploads", times.preparation),
                ("depth", times.prepass),
                ("shadow volumes", times.shadows),
                ("composition", times.composition),
                ("exposure", times.exposure),
                ("tone", times.tone),
                ("showing, with panels", pace.showing),
            ] {
                ui.label(name);
                ui.label(format!("{ms:.1} ms"));
                ui.end_row();
            }
        });
        ui.weak(&desk.driver);
    });
}
