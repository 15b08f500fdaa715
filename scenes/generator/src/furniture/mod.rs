//! The pieces of furniture. Each stands with the middle of its footprint at the origin and its feet at z = 0, unless it says
//! otherwise; its front looks along +y.

pub mod bed;
pub mod decor;
pub mod kitchen;
pub mod lights;
pub mod seats;
pub mod storage;
pub mod store;
pub mod study;
pub mod table;

use crate::mesh::Mesh;
use crate::shapes::block;
use crate::solid::{Solid, v};

/// A box of `material` between two corners, metres.
pub(crate) fn bar(material: &'static str, x: [f64; 2], y: [f64; 2], z: [f64; 2]) -> Solid {
    block(v(x[0], y[0], z[0]), v(x[1], y[1], z[1])).of(material)
}

/// The room's meshes that can be moved, in the order of their names.
pub fn meshes() -> Vec<Mesh> {
    let mut all = vec![
        bed::bed(),
        bed::box_under_bed(),
        bed::pillow(),
        seats::chair(),
        seats::sofa(),
        seats::throw_pillow(),
        seats::pouf(),
        table::table(),
        table::cup(),
        table::bowl(),
        table::oranges(),
        storage::shelf(),
        storage::wardrobe(),
        storage::nightstand(),
        storage::books("books_tall", 7, 0.36),
        storage::books("books_short", 40, 0.28),
        storage::books("books_mixed", 11, 0.42),
        storage::lying_books(),
        storage::chest(),
        lights::floor_lamp(),
        lights::pendant(),
        lights::ceiling_light(),
        lights::washer(),
        decor::screen(),
        decor::rug(),
        decor::plant(),
        decor::vase("vase_tall", 0.30),
        decor::vase("vase_small", 0.16),
        decor::door(),
        decor::picture("picture_wide", 0.9, 0.55, ["sea", "sand", "sky"]),
        decor::picture("picture_high", 0.42, 0.58, ["leaf", "terracotta", "cream"]),
    ];
    all.sort_by(|a, b| a.name.cmp(&b.name));
    all
}
