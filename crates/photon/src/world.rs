//! A configuration as rays see it: bodies with trees, and lamps with frames. Immutable; a move replaces one body.

use crate::{
    body::{Body, Reach, TreePreset},
    boxes::Boxes,
    emission::LampChoice,
    hash::of_name,
    lanes::{LANES, Lanes, Task, widest},
    sampling::uniform_sphere,
    tree::{Beam, limit},
    triangle::{Hit, Ray, Triangle},
};
use glam::{DMat3, DVec3, Vec3};
use lightmend_scene::{Configuration, Lamp, Mesh, Motion, Object, lamp_rotation};
use std::sync::Arc;

/// An object where it stands, with a tree of its own.
pub(crate) struct Placed {
    pub(crate) id: usize,
    mesh: Arc<Mesh>,
    motion: Motion,
    pub(crate) body: Body,
}

/// Objects with trees of their own, in order of their numbers, and their boxes side by side.
#[derive(Clone, Default)]
pub struct Crowd {
    placed: Vec<Arc<Placed>>,
    boxes: Boxes,
}

impl Crowd {
    fn new(placed: Vec<Arc<Placed>>) -> Crowd {
        let boxes = Boxes::new(placed.iter().map(|placed| placed.body.bounds()));
        Crowd { placed, boxes }
    }

    fn find(&self, id: usize) -> Option<&Arc<Placed>> {
        self.placed.binary_search_by_key(&id, |placed| placed.id).ok().map(|n| &self.placed[n])
    }

    /// They, in order of their numbers.
    pub(crate) fn placed(&self) -> &[Arc<Placed>] {
        &self.placed
    }

    /// The boxes about them, padded.
    pub fn bounds(&self) -> impl Iterator<Item = [Vec3; 2]> + '_ {
        self.placed.iter().map(|placed| placed.body.bounds())
    }

    /// The nearest of `best` and these objects.
    pub fn nearest<'t>(&'t self, ray: &Ray, best: Option<Hit<'t>>) -> Option<Hit<'t>> {
        widest(Nearest { ray, crowd: self, fixed: None, best })
    }
}

/// What the ray meets first of some bodies.
struct Nearest<'t, 'r> {
    ray: &'r Ray<'r>,
    crowd: &'t Crowd,
    fixed: Option<&'t Body>,
    best: Option<Hit<'t>>,
}

impl<'t> Task for Nearest<'t, '_> {
    type Output = Option<Hit<'t>>;

    /// Movables first, each behind its box, then what is fixed.
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Option<Hit<'t>> {
        let Nearest { ray, crowd, fixed, mut best } = self;
        let beam = Beam::new(lanes, ray);
        for (n, planes) in crowd.boxes.eights().iter().enumerate() {
            let placed = &crowd.placed[n * LANES..];
            let (mut mask, enter) = beam.enters(planes, limit(&best));
            if mask == 0 {
                continue;
            }
            let enter = lanes.store(enter);
            while mask != 0 {
                let k = mask.trailing_zeros() as usize;
                mask &= mask - 1;
                if enter[k] <= limit(&best) {
                    placed[k].body.nearest(&beam, &mut best);
                }
            }
        }
        if let Some(body) = fixed {
            body.nearest(&beam, &mut best);
        }
        best
    }
}

/// What the ray meets first of one body. Apart from [`Nearest`], so that where nothing moves no ray pays for the loop over what does.
struct Alone<'t, 'r> {
    ray: &'r Ray<'r>,
    body: &'t Body,
}

impl<'t> Task for Alone<'t, '_> {
    type Output = Option<Hit<'t>>;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Option<Hit<'t>> {
        let mut best = None;
        self.body.nearest(&Beam::new(lanes, self.ray), &mut best);
        best
    }
}

/// All that the ray meets of some bodies within a distance.
struct All<'t, 'r> {
    ray: &'r Ray<'r>,
    bodies: Vec<&'t Body>,
    farthest: f32,
}

impl<'t> Task for All<'t, '_> {
    type Output = Vec<Hit<'t>>;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Vec<Hit<'t>> {
        let (beam, mut found) = (Beam::new(lanes, self.ray), Vec::new());
        for body in self.bodies {
            body.meet_all(&beam, self.farthest, &mut found);
        }
        found
    }
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
    /// The objects in `fixed`, with their meshes and where they stand, in order of their numbers.
    fixed_objects: Arc<[(usize, Arc<Mesh>, Motion)]>,
    /// All others.
    crowd: Crowd,
    /// By number, also those that are gone.
    lamps: Vec<PlacedLamp>,
    choice: Arc<LampChoice>,
    reach: Reach,
    preset: TreePreset,
}

/// What differs between two worlds.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Difference {
    /// Objects of the new world whose surfaces are new, stand elsewhere or are of another material, and those that are gone; in order.
    pub objects: Vec<usize>,
    /// Those of them that stood somewhere in the old world where they no longer stand.
    pub phantoms: Vec<usize>,
    /// Lamps that are new or gone, stand elsewhere or shine otherwise, in order.
    pub lamps: Vec<usize>,
    /// Whether photons are shared out among the lamps otherwise.
    pub choice: bool,
}

impl Difference {
    /// Whether nothing differs.
    pub fn is_empty(&self) -> bool {
        self.objects.is_empty() && self.lamps.is_empty() && !self.choice
    }
}

fn triangles_of(object: &Object, id: usize, motion: &Motion) -> Vec<Triangle> {
    let corners: Vec<Vec3> = object.mesh.positions.iter().map(|p| motion.point(*p).as_vec3()).collect();
    let key = of_name(&object.name);
    let triangles = object.mesh.triangles.iter().enumerate();
    triangles.map(|(t, indices)| Triangle::new(indices.map(|i| corners[i as usize]), key, id, t)).collect()
}

fn place_lamp(configuration: &Configuration, id: usize) -> PlacedLamp {
    let motion = configuration.lamp_motion(id);
    PlacedLamp { position: motion.translation, rotation: lamp_rotation(configuration.scene().up, &motion) }
}

impl World {
    /// Builds all trees. `preset` is for what stands still; what moves gets the other one.
    pub fn new(configuration: &Configuration, preset: TreePreset) -> World {
        let fixed: Vec<usize> = configuration.objects().filter(|(_, o)| !o.dynamic).map(|(id, _)| id).collect();
        let reach = Reach::new(configuration.reach() as f32);
        let world = World {
            configuration: configuration.clone(),
            fixed: fixed_body(configuration, &fixed, reach, preset),
            fixed_objects: fixed
                .iter()
                .map(|id| (*id, configuration.object(*id).mesh.clone(), configuration.object_motion(*id)))
                .collect(),
            crowd: Crowd::default(),
            lamps: Vec::new(),
            choice: Arc::new(LampChoice::new(configuration)),
            reach,
            preset,
        };
        world.moved_to(configuration)
    }

    /// The world of another configuration of the same scene; only what changed is built anew.
    pub fn moved_to(&self, configuration: &Configuration) -> World {
        let mut world = World { configuration: configuration.clone(), ..self.clone() };
        let stands = |(id, mesh, motion): &(usize, Arc<Mesh>, Motion)| {
            configuration.has_object(*id)
                && Arc::ptr_eq(mesh, &configuration.object(*id).mesh)
                && configuration.object_motion(*id) == *motion
        };
        if !self.fixed_objects.iter().all(stands) {
            // Something fixed is gone: what is fixed now, also what was added since, makes a new tree.
            return World::new(configuration, self.preset);
        }
        let is_fixed = |id: usize| self.fixed_objects.binary_search_by_key(&id, |(fixed, ..)| *fixed).is_ok();
        let movers = configuration.objects().filter(|(id, _)| !is_fixed(*id));
        let placed = movers.map(|(id, object)| {
            let motion = configuration.object_motion(id);
            let kept = self.crowd.find(id).filter(|p| p.motion == motion && Arc::ptr_eq(&p.mesh, &object.mesh));
            kept.cloned().unwrap_or_else(|| world.place(id, motion))
        });
        world.crowd = Crowd::new(placed.collect());
        world.lamps = (0..configuration.lamp_slots()).map(|id| place_lamp(configuration, id)).collect();
        let choice = LampChoice::new(configuration);
        if choice != *self.choice {
            world.choice = Arc::new(choice);
        }
        world
    }

    fn place(&self, id: usize, motion: Motion) -> Arc<Placed> {
        let object = self.configuration.object(id);
        let preset = if self.preset == TreePreset::Medium { TreePreset::Fast } else { TreePreset::Medium };
        let body = Body::new(triangles_of(object, id, &motion), self.reach, preset);
        Arc::new(Placed { id, mesh: object.mesh.clone(), motion, body })
    }

    /// Where object `id` stands.
    fn motion(&self, id: usize) -> Motion {
        self.crowd.find(id).map_or_else(|| self.configuration.object_motion(id), |placed| placed.motion)
    }

    /// Whether object `id` is there in both worlds, with the same triangles in the same place.
    pub fn same_place(&self, other: &World, id: usize) -> bool {
        let [a, b] = [self, other].map(|world| &world.configuration);
        a.has_object(id)
            && b.has_object(id)
            && Arc::ptr_eq(&a.object(id).mesh, &b.object(id).mesh)
            && self.motion(id) == other.motion(id)
    }

    /// From this world to `new`.
    pub fn difference(&self, new: &World) -> Difference {
        let [before, after] = [self, new].map(|world| &world.configuration);
        let mut difference = Difference { choice: *self.choice != *new.choice, ..Difference::default() };
        for id in 0..before.object_slots().max(after.object_slots()) {
            let (was, is) = (before.has_object(id), after.has_object(id));
            let moved = was != is || (was && !self.same_place(new, id));
            let repainted = was && is && {
                let (old, new) = (before.object(id), after.object(id));
                !std::ptr::eq(old, new) && !old.same_surfaces(new)
            };
            if moved || repainted {
                difference.objects.push(id);
            }
            if moved && was {
                difference.phantoms.push(id);
            }
        }
        for id in 0..before.lamp_slots().max(after.lamp_slots()) {
            let (was, is) = (before.has_lamp(id), after.has_lamp(id));
            let shines_alike = |a: &Lamp, b: &Lamp| a.photometry == b.photometry && a.direct == b.direct;
            if was != is || (was && !(self.lamps[id] == new.lamps[id] && shines_alike(before.lamp(id), after.lamp(id)))) {
                difference.lamps.push(id);
            }
        }
        difference
    }

    /// The objects `ids` where they stand in this world, to be met beside those of another: its phantoms
    /// (Dmitriev et al. 2002, §5.1).
    pub fn phantoms(&self, ids: &[usize]) -> Crowd {
        let placed = |id: &usize| self.crowd.find(*id).cloned().unwrap_or_else(|| self.place(*id, self.motion(*id)));
        Crowd::new(ids.iter().map(placed).collect())
    }

    /// The box about object `id` where it stands; `None` if it is gone.
    pub fn bounds_of(&self, id: usize) -> Option<[Vec3; 2]> {
        let of_mesh = || {
            let motion = self.motion(id);
            let corners = self.object(id).mesh.positions.iter().map(|p| motion.point(*p).as_vec3());
            corners.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
        };
        let there = self.configuration.has_object(id);
        there.then(|| self.crowd.find(id).map_or_else(of_mesh, |placed| placed.body.bounds()))
    }

    /// What never moves.
    pub(crate) fn fixed(&self) -> &Arc<Body> {
        &self.fixed
    }

    /// The objects of [`fixed`](Self::fixed), in order.
    pub(crate) fn fixed_objects(&self) -> impl Iterator<Item = usize> + '_ {
        self.fixed_objects.iter().map(|(id, ..)| *id)
    }

    /// All other objects.
    pub(crate) fn crowd(&self) -> &Crowd {
        &self.crowd
    }

    /// The box about all that is there, padded, and the lamps.
    pub fn bounds(&self) -> [Vec3; 2] {
        let bodies = self.crowd.bounds().chain([self.fixed.bounds()]).filter(|[low, high]| low.cmple(*high).all());
        let lamps = self.configuration.lamps().map(|(id, _)| [self.lamps[id].position.as_vec3(); 2]);
        bodies.chain(lamps).fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], [l, h]| [low.min(l), high.max(h)])
    }

    /// The configuration that this is.
    pub fn configuration(&self) -> &Configuration {
        &self.configuration
    }

    /// Object number `id`.
    #[inline]
    pub fn object(&self, id: usize) -> &Object {
        self.configuration.object(id)
    }

    /// The lamps where they stand, by number, also those that are gone.
    pub fn lamps(&self) -> &[PlacedLamp] {
        &self.lamps
    }

    /// How photons are shared out among the lamps.
    pub fn choice(&self) -> &LampChoice {
        &self.choice
    }

    /// How far the scene reaches.
    pub fn reach(&self) -> Reach {
        self.reach
    }

    /// The first surface that a ray meets.
    pub fn nearest(&self, ray: &Ray) -> Option<Hit<'_>> {
        if self.crowd.placed.is_empty() {
            return widest(Alone { ray, body: &self.fixed });
        }
        widest(Nearest { ray, crowd: &self.crowd, fixed: Some(&self.fixed), best: None })
    }

    /// The same without the widest lanes of this machine.
    #[cfg(test)]
    pub(crate) fn nearest_portably(&self, ray: &Ray) -> Option<Hit<'_>> {
        Nearest { ray, crowd: &self.crowd, fixed: Some(&self.fixed), best: None }.run(crate::lanes::Portable)
    }

    /// What the ray meets at the distance of `hit`, but for rounding: surfaces that lie in one another. Which of them a photon meets is
    /// left to rounding, so the light of the place is the sum of theirs. `hit` comes first; neighbours that only share an edge with
    /// the ray are left out.
    pub fn layers<'w>(&'w self, ray: &Ray, hit: Hit<'w>) -> Vec<Hit<'w>> {
        // A few roundings of the largest coordinate.
        let slack = 1e-6 * self.reach.metres;
        let bodies = self.crowd.placed.iter().map(|placed| &placed.body).chain([&*self.fixed]).collect();
        let mut found = widest(All { ray, bodies, farthest: hit.distance + slack });
        found.retain(|other| {
            !other.triangle.is(hit.triangle)
                && other.distance >= hit.distance - slack
                && other.weights.iter().all(|w| *w > 0.0)
                && other.triangle.normal.dot(hit.triangle.normal).abs() > 0.999
        });
        found.sort_by_key(|other| other.triangle.order());
        found.insert(0, hit);
        found
    }

    /// Whether nothing stands between a point just above a surface and a lamp.
    pub fn sees(&self, from: Vec3, lamp: usize) -> bool {
        let ray = Ray::new(from, self.lamps[lamp].position.as_vec3() - from, None, 0.0);
        self.nearest(&ray).is_none_or(|hit| hit.distance >= 1.0 - 1e-5)
    }

    /// The direction in which a photon leaves lamp `id`, unit.
    pub fn emission(&self, id: usize, u: f64, v: f64) -> Vec3 {
        let local = match &self.configuration.lamp(id).photometry {
            None => uniform_sphere(u, v),
            Some(photometry) => photometry.sample(u, v),
        };
        (self.lamps[id].rotation * local).as_vec3()
    }
}

fn fixed_body(configuration: &Configuration, ids: &[usize], reach: Reach, preset: TreePreset) -> Arc<Body> {
    let triangles = |id: &usize| triangles_of(configuration.object(*id), *id, &configuration.object_motion(*id));
    Arc::new(Body::new(ids.iter().flat_map(triangles).collect(), reach, preset))
}
