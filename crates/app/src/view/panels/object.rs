//! An object: where it stands, what it is made of.

use crate::view::{desk::Desk, dialogs::Dialog, pick, session::Selection};
use egui::{ComboBox, Ui};
use glam::DVec3;
use lightmend_scene::Edit;

/// Object number `id`.
pub fn panel(desk: &mut Desk, ui: &mut Ui, id: usize) {
    let configuration = desk.session.configuration.clone();
    let object = configuration.object(id);
    let name = object.name.clone();
    ui.heading(&name);
    let size = {
        let [low, high] = pick::bounds(&configuration, id);
        (high - low).abs()
    };
    let triangles = object.mesh.triangles.len();
    ui.weak(format!("{:.2} × {:.2} × {:.2} m, {triangles} triangles", size.x, size.y, size.z));
    if let Some(carrier) = object.carrier {
        ui.horizontal(|ui| {
            ui.weak("stands on");
            if ui.link(&configuration.object(carrier).name).clicked() {
                desk.session.selection = Some(Selection::Object(carrier));
            }
        });
    }
    if object.movable {
        let (mut position, mut rotation) = (object.pose.position, object.pose.rotation);
        ui.label(if object.carrier.is_some() { "Position on what carries it" } else { "Position" });
        if super::triple(ui, &mut position, 0.01, " m", 4, "Pull to the left or right, or double-click and type") {
            desk.session.go_on(&format!("Move {name}"), Edit::Move { object: name.clone(), to: position });
        }
        ui.label("Rotation");
        if super::triple(ui, &mut rotation, 0.5, "°", 3, "About x, then y, then z; pull, or double-click and type") {
            desk.session.go_on(&format!("Turn {name}"), Edit::Turn { object: name.clone(), to: rotation });
        }
    } else {
        ui.weak("It is fixed: `movable: true` in the scene file lets it move.");
    }
    paint(desk, ui, id);
}

/// Its materials.
fn paint(desk: &mut Desk, ui: &mut Ui, id: usize) {
    let configuration = desk.session.configuration.clone();
    let object = configuration.object(id);
    let name = object.name.clone();
    ui.add_space(4.0);
    ui.label("Made of");
    let shown = object.entry.material.clone().unwrap_or_else(|| "what its model says".into());
    let mut painted = None;
    ComboBox::from_id_salt("made of").selected_text(&shown).width(ui.available_width() - 8.0).show_ui(ui, |ui| {
        if ui.selectable_label(object.entry.material.is_none(), "what its model says").clicked() {
            painted = Some(None);
        }
        for material in configuration.materials() {
            if ui.selectable_label(object.entry.material.as_ref() == Some(&material.name), &material.name).clicked() {
                painted = Some(Some(material.name.clone()));
            }
        }
    });
    if let Some(material) = painted.filter(|m| *m != object.entry.material) {
        desk.session.perform(format!("Paint {name}"), vec![Edit::Paint { object: name.clone(), material }]);
    }
    let mut known: Vec<&str> = Vec::new();
    for material in &object.materials {
        if known.contains(&material.name.as_str()) {
            continue;
        }
        known.push(&material.name);
        ui.group(|ui| {
            ui.horizontal(|ui| {
                let users = configuration.objects().filter(|(_, o)| o.materials.iter().any(|m| m.name == material.name)).count();
                ui.strong(&material.name);
                let others = if users == 1 { "only here".to_owned() } else { format!("on {users} objects") };
                ui.weak(others).on_hover_text("What is changed here changes on all of them. “Own copy” gives this object one of its own");
            });
            let mut rgb = material.reflectance.to_array();
            ui.horizontal(|ui| {
                // A screen shows sRGB; the numbers stay linear.
                if ui.color_edit_button_rgb(&mut rgb).on_hover_text("Reflectance, linear Rec. 709").changed() {
                    let to = DVec3::from_array(rgb.map(|c| f64::from(c.clamp(0.0, 1.0))));
                    desk.session.go_on(&format!("Colour of {}", material.name), Edit::Reflect { material: material.name.clone(), to });
                }
                let grey = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
                ui.label(format!("reflects {:.0} %", 100.0 * grey)).on_hover_text("Of the luminance of white light; above 85 % is whiter than fresh paint, and light takes many bounces to die down");
            });
            let mut value = DVec3::from_array(material.reflectance.to_array().map(f64::from));
            ui.horizontal(|ui| {
                let mut changed = false;
                for (channel, name) in value.as_mut().iter_mut().zip(["R ", "G ", "B "]) {
                    let number = egui::DragValue::new(channel).speed(0.005).range(0.0..=1.0).prefix(name).max_decimals(3);
                    changed |= ui.add(number).on_hover_text("Linear Rec. 709, 0 to 1").changed();
                }
                if changed {
                    desk.session.go_on(&format!("Colour of {}", material.name), Edit::Reflect { material: material.name.clone(), to: value });
                }
            });
            ui.horizontal(|ui| {
                match &material.texture_path {
                    Some(path) => ui.weak(path.rsplit('/').next().unwrap_or(path)).on_hover_text(path),
                    None => ui.weak("no texture"),
                };
                if ui.small_button("Texture…").on_hover_text("A PNG or JPEG; its colours are multiplied with the reflectance").clicked() {
                    desk.dialog = Some(Dialog::texture(&desk.session, &material.name));
                }
                if material.texture_path.is_some() && ui.small_button("None").clicked() {
                    let edit = Edit::Texture { material: material.name.clone(), texture: None };
                    desk.session.perform(format!("Texture of {}", material.name), vec![edit]);
                }
            });
            if ui.small_button("Own copy").on_hover_text("A new material like this one, for all of this object").clicked() {
                let new = desk.session.free_material_name(&material.name);
                let add = Edit::AddMaterial {
                    name: new.clone(),
                    reflectance: material.reflectance.as_dvec3(),
                    texture: material.texture_path.clone(),
                };
                let paint = Edit::Paint { object: name.clone(), material: Some(new) };
                desk.session.perform(format!("Own copy of {}", material.name), vec![add, paint]);
            }
        });
    }
}
