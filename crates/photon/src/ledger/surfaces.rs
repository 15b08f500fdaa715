//! The triangles of a world by the mesh elements that they hold.
//!
//! They are those of the trees. What did not move keeps its table from world to world.

use crate::{body::Body, crowd::Placed, triangle::Triangle, world::World};
use std::sync::Arc;

/// Where an object's triangles are.
#[derive(Clone)]
enum Trees {
    Still(Arc<Body>),
    Own(Arc<Placed>),
}

impl Trees {
    fn body(&self) -> &Body {
        match self {
            Trees::Still(body) => body,
            Trees::Own(placed) => &placed.body,
        }
    }

    fn are(&self, other: &Trees) -> bool {
        std::ptr::eq(self.body().triangles(), other.body().triangles())
    }
}

#[derive(Clone)]
struct Table {
    trees: Trees,
    /// By the object's cell, a place among the triangles.
    places: Arc<[u32]>,
}

/// The triangles of a world.
pub struct Surfaces {
    /// By the object's number; `None` if it is gone.
    tables: Vec<Option<Table>>,
}

impl Surfaces {
    /// Of a world; `like` are those of one that shares objects with it.
    pub fn new(world: &World, like: Option<&Surfaces>) -> Surfaces {
        let mut surfaces = Surfaces { tables: vec![None; world.configuration().object_slots()] };
        surfaces.add(world, &Trees::Still(world.still().clone()), world.still_objects(), like);
        for placed in world.crowd().placed() {
            surfaces.add(world, &Trees::Own(placed.clone()), std::iter::once(placed.id), like);
        }
        surfaces
    }

    /// Adds the objects of one body.
    fn add(&mut self, world: &World, trees: &Trees, objects: impl Iterator<Item = usize>, like: Option<&Surfaces>) {
        // Where each object's table is among the new ones.
        let mut new: Vec<(usize, Vec<u32>)> = Vec::new();
        for id in objects {
            let kept = like.and_then(|like| like.tables.get(id)?.as_ref()).filter(|table| table.trees.are(trees));
            match kept {
                Some(table) => self.tables[id] = Some(table.clone()),
                None => new.push((id, vec![0; world.object(id).lattice.cells() as usize])),
            }
        }
        if new.is_empty() {
            return;
        }
        let mut last = 0;
        for (place, triangle) in trees.body().triangles().iter().enumerate() {
            if new[last].0 != triangle.object() {
                // What was taken out of a tree is still among its triangles.
                let Ok(found) = new.binary_search_by_key(&triangle.object(), |(id, _)| *id) else { continue };
                last = found;
            }
            for cell in world.object(triangle.object()).lattice.cells_of(triangle.in_mesh()) {
                new[last].1[cell as usize] = place as u32;
            }
        }
        for (id, places) in new {
            self.tables[id] = Some(Table { trees: trees.clone(), places: places.into() });
        }
    }

    /// The triangle of an element of an object that is there.
    #[inline]
    pub fn triangle(&self, object: usize, cell: u32) -> Option<&Triangle> {
        let table = self.tables.get(object)?.as_ref()?;
        Some(&table.trees.body().triangles()[table.places[cell as usize] as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::TreePreset;
    use glam::DVec3;
    use lightmend_scene::{Configuration, Edit, Scene};

    #[test]
    fn every_element_leads_to_its_triangle() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/room/room.ron");
        let home = Configuration::initial(&Scene::read(&path).unwrap().0);
        let world = World::new(&home, TreePreset::Fast);
        let moved = home.apply(&Edit::Move { object: "table".into(), to: DVec3::new(2.4, 3.0, 0.0) }).unwrap();
        let moved = world.moved_to(&moved);
        let surfaces = Surfaces::new(&world, None);
        let mut found = 0;
        for (world, surfaces) in [(&world, &surfaces), (&moved, &Surfaces::new(&moved, Some(&surfaces)))] {
            let table = world.configuration().object_id("table").unwrap();
            let corners = world.configuration().object_motion(table);
            for (id, object) in world.configuration().objects() {
                for t in 0..object.mesh.triangles.len() {
                    for cell in object.lattice.cells_of(t) {
                        let triangle = surfaces.triangle(id, cell).unwrap();
                        assert_eq!((triangle.object(), triangle.in_mesh()), (id, t));
                        found += 1;
                    }
                }
            }
            let first = world.configuration().object(table).mesh.corners(0)[0];
            assert_eq!(surfaces.triangle(table, 0).unwrap().corners[0], corners.point(first).as_vec3(), "where it stands now");
        }
        assert!(found > 20_000);
    }
}
