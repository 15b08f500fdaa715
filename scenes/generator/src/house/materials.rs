//! The house's reflectances, linear Rec. 709: those of the room and a few more, as far as something is made of them.

use std::collections::BTreeSet;

use crate::mesh::Mesh;
use crate::room;
use crate::scene::Material;

const MORE: [Material; 16] = [
    ("wall sage", [0.46, 0.54, 0.42], None),
    ("wall blue", [0.34, 0.43, 0.54], None),
    ("floor tiles", [0.48, 0.45, 0.42], None),
    ("screed", [0.40, 0.39, 0.37], None),
    ("armchair cloth", [0.50, 0.24, 0.16], None),
    ("sideboard front", [0.56, 0.44, 0.28], None),
    ("kitchen paint", [0.36, 0.50, 0.46], None),
    ("worktop", [0.30, 0.20, 0.12], None),
    ("hob plate", [0.12, 0.11, 0.11], None),
    ("brushed steel", [0.52, 0.52, 0.51], None),
    ("refrigerator", [0.76, 0.74, 0.66], None),
    ("kettle red", [0.58, 0.07, 0.05], None),
    ("stool paint", [0.70, 0.46, 0.06], None),
    ("dark glass", [0.03, 0.03, 0.04], None),
    ("parcel tape", [0.62, 0.50, 0.30], None),
    ("rug", [1.0, 1.0, 1.0], Some("../room/textures/rug.png")),
];

/// The materials of these meshes, by name.
pub fn of(meshes: &[Mesh]) -> Vec<Material> {
    let used: BTreeSet<&str> = meshes.iter().flat_map(|m| m.solids()).map(|s| s.material).collect();
    let known: Vec<Material> = MORE.into_iter().chain(room::materials::all()).collect();
    used.iter().filter_map(|name| known.iter().find(|m| m.0 == *name)).copied().collect()
}
