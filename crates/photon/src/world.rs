//! A configuration as rays see it: bodies with trees, and lamps with frames. Immutable; a move replaces one body.

use crate::{
    body::{Body, Reach, SLACK, TreePreset, inverse},
    boxes::Boxes,
    sampling::uniform_sphere,
    triangle::{Hit, Ray, Triangle},
};
use glam::{DMat3, DVec3, Vec3};
use lightmend_scene::{Configuration, Motion, Scene, lamp_rotation};
use std::sync::Arc;

/// A dynamic object where it stands.
pub struct Placed {
    motion: Motion,
    body: Body,
}

/// A lamp where it stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedLamp {
    /// Metres.
    pub position: DVec3,
    /// From lamp axes to the world.
    pub rotation: DMat3,
}

/// A configuration, ready to trace.
#[derive(Clone)]
pub struct World {
    configuration: Configuration,
    fixed: Arc<Body>,
    /// Per object; `None` if it is part of `fixed`.
    dynamic: Vec<Option<Arc<Placed>>>,
    /// The indices of the dynamic objects.
    order: Arc<[usize]>,
    /// Their boxes, in that order.
    boxes: Boxes,
    lamps: Vec<PlacedLamp>,
    reach: Reach,
    preset: TreePreset,
}

/// What differs between two worlds.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Difference {
    /// Objects that stand elsewhere, in order.
    pub objects: Vec<usize>,
    /// Lamps that stand elsewhere, in order.
    pub lamps: Vec<usize>,
}

impl Difference {
    /// Whether nothing differs.
    pub fn is_empty(&self) -> bool {
        self.objects.is_empty() && self.lamps.is_empty()
    }
}

/// Objects of an earlier world (Dmitriev et al. 2002, §5.1: scene phantoms), with their boxes.
#[derive(Debug, Clone, Default)]
pub struct Phantoms {
    objects: Vec<usize>,
    boxes: Boxes,
}

fn placed_triangles(scene: &Scene, id: usize, motion: &Motion) -> Vec<Triangle> {
    let mesh = &scene.objects[id].mesh;
    let corners: Vec<Vec3> = mesh.positions.iter().map(|p| motion.point(*p).as_vec3()).collect();
    let triangles = mesh.triangles.iter().enumerate();
    triangles.map(|(t, indices)| Triangle::new(indices.map(|i| corners[i as usize]), id, t)).collect()
}

fn place_lamp(configuration: &Configuration, id: usize) -> PlacedLamp {
    let motion = configuration.lamp_motion(id);
    PlacedLamp { position: motion.translation, rotation: lamp_rotation(configuration.scene().up, &motion) }
}

impl World {
    /// Builds all trees. `preset` is for what stands still; what moves is built [`TreePreset::Fast`].
    pub fn new(configuration: &Configuration, preset: TreePreset) -> World {
        let scene = configuration.scene();
        let motions = configuration.object_motions();
        let initial = Configuration::initial(scene).object_motions();
        // From the file's poses, not the current ones: a path must not depend on where a moved object has been.
        let largest = scene
            .objects
            .iter()
            .zip(&initial)
            .flat_map(|(object, motion)| object.mesh.positions.iter().map(|p| motion.point(*p).abs().max_element() as f32));
        let reach = Reach::new(largest.fold(0.0, f32::max));
        let fixed: Vec<Triangle> = (0..scene.objects.len())
            .filter(|id| !scene.objects[*id].dynamic)
            .flat_map(|id| placed_triangles(scene, id, &motions[id]))
            .collect();
        let order: Arc<[usize]> = (0..scene.objects.len()).filter(|id| scene.objects[*id].dynamic).collect();
        let mut world = World {
            configuration: configuration.clone(),
            fixed: Arc::new(Body::new(fixed, reach, preset)),
            dynamic: vec![None; scene.objects.len()],
            order: order.clone(),
            boxes: Boxes::default(),
            lamps: (0..scene.lamps.len()).map(|id| place_lamp(configuration, id)).collect(),
            reach,
            preset: if preset == TreePreset::Medium { TreePreset::Fast } else { TreePreset::Medium },
        };
        for id in order.iter() {
            world.dynamic[*id] = Some(world.place(*id, motions[*id]));
        }
        world.boxes = world.bounds_of_dynamic();
        world
    }

    fn bounds_of_dynamic(&self) -> Boxes {
        Boxes::new(self.order.iter().filter_map(|id| self.dynamic[*id].as_ref()).map(|placed| placed.body.bounds()))
    }

    fn place(&self, id: usize, motion: Motion) -> Arc<Placed> {
        let triangles = placed_triangles(self.configuration.scene(), id, &motion);
        Arc::new(Placed { motion, body: Body::new(triangles, self.reach, self.preset) })
    }

    /// The world of another configuration of the same scene; only what moved is built anew.
    pub fn moved_to(&self, configuration: &Configuration) -> World {
        let mut world = World { configuration: configuration.clone(), ..self.clone() };
        for id in self.order.iter() {
            let motion = configuration.object_motion(*id);
            if self.dynamic[*id].as_ref().is_none_or(|placed| placed.motion != motion) {
                world.dynamic[*id] = Some(self.place(*id, motion));
            }
        }
        world.boxes = world.bounds_of_dynamic();
        world.lamps = (0..self.lamps.len()).map(|id| place_lamp(configuration, id)).collect();
        world
    }

    /// What stands elsewhere in `other`.
    pub fn difference(&self, other: &World) -> Difference {
        let motion = |world: &World, id: usize| world.dynamic[id].as_ref().map(|placed| placed.motion);
        Difference {
            objects: self.order.iter().copied().filter(|id| motion(self, *id) != motion(other, *id)).collect(),
            lamps: (0..self.lamps.len()).filter(|id| self.lamps[*id] != other.lamps[*id]).collect(),
        }
    }

    /// Whether object `id` stands in `other` where it stands here.
    pub fn same_place(&self, other: &World, id: usize) -> bool {
        let motion = |world: &World| world.dynamic[id].as_ref().map(|placed| placed.motion);
        motion(self) == motion(other)
    }

    /// The configuration that this is.
    pub fn configuration(&self) -> &Configuration {
        &self.configuration
    }

    /// The scene.
    pub fn scene(&self) -> &Arc<Scene> {
        self.configuration.scene()
    }

    /// The lamps where they stand.
    pub fn lamps(&self) -> &[PlacedLamp] {
        &self.lamps
    }

    /// How far the scene reaches.
    pub fn reach(&self) -> Reach {
        self.reach
    }

    /// The first surface that a ray meets. One traversal: movables first, each behind its box, then what is fixed.
    pub fn nearest(&self, ray: &Ray) -> Option<Hit<'_>> {
        let best = self.nearest_in(&self.boxes, &self.order, ray, None);
        self.fixed.nearest(ray, best)
    }

    /// What the ray meets at the distance of `hit`, but for rounding: surfaces that lie in one another. Which of them a photon meets is
    /// left to rounding, so the light of the place is the sum of theirs. `hit` comes first; neighbours that only share an edge with
    /// the ray are left out.
    pub fn layers<'w>(&'w self, ray: &Ray, hit: Hit<'w>) -> Vec<Hit<'w>> {
        // A few roundings of the largest coordinate.
        let slack = 1e-6 * self.reach.metres;
        let mut found = Vec::new();
        for body in self.dynamic.iter().flatten().map(|placed| &placed.body).chain([&*self.fixed]) {
            body.meet_all(ray, hit.distance + slack, &mut found);
        }
        found.retain(|other| {
            other.triangle.id != hit.triangle.id
                && other.distance >= hit.distance - slack
                && other.weights.iter().all(|w| *w > 0.0)
                && other.triangle.normal.dot(hit.triangle.normal).abs() > 0.999
        });
        found.sort_by_key(|other| other.triangle.id);
        found.insert(0, hit);
        found
    }

    /// The nearest of `best` and the objects `ids` where they stand in this world.
    pub fn nearest_of<'t>(&'t self, ids: &Phantoms, ray: &Ray, best: Option<Hit<'t>>) -> Option<Hit<'t>> {
        self.nearest_in(&ids.boxes, &ids.objects, ray, best)
    }

    fn nearest_in<'t>(&'t self, boxes: &Boxes, ids: &[usize], ray: &Ray, mut best: Option<Hit<'t>>) -> Option<Hit<'t>> {
        let limit = |best: &Option<Hit>| best.map_or(f32::INFINITY, |b| b.distance * SLACK);
        boxes.entered(ray, inverse(ray.direction), limit(&best), |n| {
            if let Some(placed) = &self.dynamic[ids[n]] {
                best = placed.body.nearest(ray, best);
            }
            limit(&best)
        });
        best
    }

    /// The objects `ids` where they stand in this world, to be met beside those of another.
    pub fn phantoms(&self, ids: &[usize]) -> Phantoms {
        let placed = ids.iter().filter_map(|id| self.dynamic[*id].as_ref());
        Phantoms { boxes: Boxes::new(placed.map(|placed| placed.body.bounds())), objects: ids.to_vec() }
    }

    /// Whether nothing stands between a point just above a surface and a lamp.
    pub fn sees(&self, from: Vec3, lamp: usize) -> bool {
        let ray = Ray::new(from, self.lamps[lamp].position.as_vec3() - from, None, 0.0);
        self.nearest(&ray).is_none_or(|hit| hit.distance >= 1.0 - 1e-5)
    }

    /// The direction in which a photon leaves lamp `id`, unit.
    pub fn emission(&self, id: usize, u: f64, v: f64) -> Vec3 {
        let local = match &self.scene().lamps[id].photometry {
            None => uniform_sphere(u, v),
            Some(photometry) => photometry.sample(u, v),
        };
        (self.lamps[id].rotation * local).as_vec3()
    }
}
