//! What surfaces are made of, side by side: every hit needs it.

use crate::triangle::Triangle;
use glam::Vec3;
use lightmend_scene::{Configuration, Material, Texture};
use std::sync::Arc;

/// What a surface is made of.
pub struct Finish {
    /// Per linear Rec. 709 channel; multiplies the texture.
    pub reflectance: Vec3,
    /// An image over the surface.
    pub texture: Option<Arc<Texture>>,
}

/// The materials of all objects of a configuration.
#[derive(Default)]
pub struct Finishes {
    /// Where each object's begin, by its number; beyond all for those that are gone.
    first: Vec<u32>,
    all: Vec<Finish>,
}

impl Finishes {
    /// Of a configuration.
    pub fn new(configuration: &Configuration) -> Finishes {
        let mut finishes = Finishes { first: vec![u32::MAX; configuration.object_slots()], all: Vec::new() };
        for (id, object) in configuration.objects() {
            finishes.first[id] = finishes.all.len() as u32;
            let finish =
                |material: &Arc<Material>| Finish { reflectance: material.reflectance, texture: material.texture.clone() };
            finishes.all.extend(object.materials.iter().map(finish));
        }
        finishes
    }

    /// Of a triangle of an object that is there.
    #[inline(always)]
    pub fn of(&self, triangle: &Triangle) -> &Finish {
        &self.all[self.first[triangle.object()] as usize + usize::from(triangle.material)]
    }
}
