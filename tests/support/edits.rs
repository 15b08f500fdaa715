//! Random edits of all kinds.

use crate::own_scene_path;
use glam::DVec3;
use lightmend_scene::{Configuration, Edit, format::ObjectEntry};
use proptest::prelude::*;

/// One random step: a kind of edit, what it is done to, numbers for it, and how many groups are repaired before the next step.
#[derive(Debug, Clone)]
pub struct Step {
    kind: u8,
    at: prop::sample::Index,
    by: [f64; 3],
    /// How much is repaired before the next step.
    pub groups: usize,
}

/// Any step.
pub fn step() -> impl Strategy<Value = Step> {
    (0u8..22, any::<prop::sample::Index>(), prop::array::uniform3(-0.4f64..0.4), 0usize..200)
        .prop_map(|(kind, at, by, groups)| Step { kind, at, by, groups })
}

/// The edit that a step is in this configuration; `number` tells it from others.
pub fn edit(configuration: &Configuration, step: &Step, number: usize) -> Edit {
    let by = DVec3::from_array(step.by);
    let objects: Vec<_> = configuration.objects().filter(|(_, object)| object.movable).map(|(_, object)| object).collect();
    let object = || objects[step.at.index(objects.len())];
    let lamps: Vec<_> = configuration.lamps().map(|(_, lamp)| lamp).collect();
    let lamp = || lamps[step.at.index(lamps.len())];
    let file = configuration.to_file();
    let materials: Vec<_> = file.materials.keys().collect();
    let material = || materials[step.at.index(materials.len())].clone();
    let reflectance = (by + 0.45).clamp(DVec3::ZERO, DVec3::ONE);
    let name = format!("new {number}");
    let used = |material: &str| configuration.objects().any(|(_, o)| o.materials.iter().any(|m| m.name == material));
    let unused: Vec<_> = materials.iter().filter(|name| !used(name)).collect();
    // What does not ride on the object itself can carry it.
    let carries = |id: &usize| {
        let below = std::iter::successors(Some(*id), |id| configuration.object(*id).carrier);
        below.into_iter().all(|id| configuration.object(id).name != object().name)
    };
    let carriers: Vec<_> = configuration.objects().map(|(id, _)| id).filter(carries).collect();
    let carrier = carriers.get(step.groups % carriers.len().max(1)).map(|id| &configuration.object(*id).name);
    match step.kind {
        0 | 1 => Edit::Move { object: object().name.clone(), to: object().pose.position + by },
        2 => Edit::Turn { object: object().name.clone(), to: object().pose.rotation + by * 100.0 },
        3 => Edit::Paint { object: object().name.clone(), material: Some(material()) },
        4 => Edit::Reflect { material: material(), to: reflectance },
        5 => Edit::Duplicate { object: object().name.clone(), name, to: object().pose.position + by },
        6 if objects.len() > 2 => Edit::Remove { object: object().name.clone() },
        7 => Edit::MoveLamp { lamp: lamp().name.clone(), to: lamp().pose.position + by * 0.3 },
        8 => Edit::TurnLamp { lamp: lamp().name.clone(), to: by * 200.0 },
        9 => Edit::Light { lamp: lamp().name.clone(), intensity: reflectance * 100.0 },
        10 => Edit::Switch { lamp: lamp().name.clone(), on: by.x > 0.0 },
        11 => Edit::Relamp { lamp: lamp().name.clone(), photometry: Some(file_of_room("ies/washer.ies")), intensity: None },
        12 => Edit::DuplicateLamp { lamp: lamp().name.clone(), name, to: lamp().pose.position + by * 0.3 },
        13 if lamps.len() > 1 => Edit::RemoveLamp { lamp: lamp().name.clone() },
        14 => Edit::Relamp { lamp: lamp().name.clone(), photometry: None, intensity: Some(reflectance * 100.0) },
        15 => Edit::Paint { object: object().name.clone(), material: None },
        16 => Edit::Texture { material: material(), texture: (by.x > 0.0).then(|| file_of_room("textures/rug.png")) },
        17 => Edit::AddMaterial { name, reflectance, texture: (by.x > 0.0).then(|| file_of_room("textures/rug.png")) },
        18 if !unused.is_empty() => Edit::RemoveMaterial { material: unused[step.at.index(unused.len())].to_string() },
        19 => Edit::Put { object: object().name.clone(), on: None, to: object().pose.position + by, rotation: by * 100.0 },
        20 if carrier.is_some() => {
            Edit::Put { object: object().name.clone(), on: carrier.cloned(), to: by + DVec3::Z, rotation: by * 100.0 }
        }
        _ => Edit::Add(
            ObjectEntry { position: DVec3::new(1.0, 1.0, 0.5) + by, movable: by.y > 0.0, ..object().entry.clone() }.named(name),
        ),
    }
}

fn file_of_room(name: &str) -> String {
    own_scene_path("room").with_file_name(name).canonicalize().unwrap().to_string_lossy().into_owned()
}

/// An entry under another name, not riding on anything.
pub trait Named {
    /// Called `name`.
    fn named(self, name: String) -> Self;
}

impl Named for ObjectEntry {
    fn named(self, name: String) -> Self {
        ObjectEntry { name, on: None, ..self }
    }
}
