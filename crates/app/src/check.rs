//! `lightmend check`: what is in a scene, and what is wrong with it.

use crate::{
    Common,
    failure::Failure,
    masking,
    output::{self, say},
};
use lightmend_photon::emission::LampChoice;
use lightmend_scene::{Configuration, Mesh, Scene, luminance};
use serde_json::json;
use std::{collections::BTreeMap, path::PathBuf, sync::Arc};

#[derive(clap::Args)]
pub struct Arguments {
    /// Scene file
    scene: PathBuf,
    /// Folder for pictures of how far each texture hides errors of the light: the texture, and beside it its threshold elevation
    #[arg(long, value_name = "DIR")]
    masking: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let common = &arguments.common;
    let scene = common.read_scene(&arguments.scene)?;
    if common.talks() {
        describe(&scene);
    }
    if let Some(folder) = &arguments.masking {
        masking::write_maps(&scene, folder, common.talks())?;
    }
    output::json(None, &summary(&scene), common.json)
}

fn summary(scene: &Arc<Scene>) -> serde_json::Value {
    let objects: Vec<_> = scene
        .objects
        .iter()
        .map(|o| {
            json!({
                "name": o.name, "movable": o.movable, "triangles": o.mesh.triangles.len(), "cells": o.lattice.cells(),
                "area": area(&o.mesh), "open_edges": open_edges(&o.mesh),
            })
        })
        .collect();
    let choice = LampChoice::new(&Configuration::initial(scene));
    let lamps: Vec<_> = scene
        .lamps
        .iter()
        .enumerate()
        .map(|(l, lamp)| json!({ "name": lamp.name, "flux": lamp.flux().to_array(), "chance": choice.chance(l) }))
        .collect();
    json!({ "scene": scene.name, "triangles": scene.triangles(), "cells": scene.cells(), "objects": objects, "lamps": lamps })
}

fn describe(scene: &Arc<Scene>) {
    let movable = scene.objects.iter().filter(|o| o.movable).count();
    say(&format!(
        "{}: {} objects ({movable} movable), {} triangles, {} mesh elements, {} lamps, {} cameras",
        scene.name,
        scene.objects.len(),
        scene.triangles(),
        scene.cells(),
        scene.lamps.len(),
        scene.cameras.len()
    ));
    say(&format!("\n{:<28} {:>9} {:>9} {:>10}  {:<8} on", "object", "triangles", "elements", "area m²", ""));
    for object in &scene.objects {
        let carrier = object.carrier.map_or("", |c| scene.objects[c].name.as_str());
        let open = open_edges(&object.mesh);
        say(&format!(
            "{:<28} {:>9} {:>9} {:>10.3}  {:<8} {carrier}{}",
            object.name,
            object.mesh.triangles.len(),
            object.lattice.cells(),
            area(&object.mesh),
            if object.movable { "movable" } else { "fixed" },
            if open > 0 { format!("  ({open} open edges)") } else { String::new() },
        ));
    }
    let choice = LampChoice::new(&Configuration::initial(scene));
    say(&format!("\n{:<28} {:>10} {:>8}  direct light by", "lamp", "lumens", "photons"));
    for (l, lamp) in scene.lamps.iter().enumerate() {
        let share = format!("{:.1} %", choice.chance(l) * 100.0);
        say(&format!("{:<28} {:>10.1} {share:>8}  {:?}", lamp.name, luminance(lamp.flux()), lamp.direct));
    }
}

fn area(mesh: &Mesh) -> f64 {
    (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            (b - a).cross(c - a).length() / 2.0
        })
        .sum()
}

/// Edges that are not met by two triangles of opposite direction, after joining equal vertices. None in a closed mesh.
fn open_edges(mesh: &Mesh) -> usize {
    let mut balance: BTreeMap<[[u64; 3]; 2], i32> = BTreeMap::new();
    for t in 0..mesh.triangles.len() {
        let corners = mesh.corners(t).map(|p| (p + glam::DVec3::ZERO).to_array().map(f64::to_bits));
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let (a, b) = (corners[a], corners[b]);
            *balance.entry(if a < b { [a, b] } else { [b, a] }).or_default() += if a < b { 1 } else { -1 };
        }
    }
    balance.values().filter(|b| **b != 0).count()
}
