//! A configuration as rays see it: bodies with trees, and lamps with frames. Immutable.
//!
//! All that stands where it stood at first is in one tree. What moves is taken out of it, which leaves a hole, and gets a tree of its
//! own that every further move replaces.

use crate::{
    body::{Body, Reach, TreePreset},
    crowd::{Crowd, Nearest, Placed},
    emission::LampChoice,
    finish::{Finish, Finishes},
    hash::of_name,
    lanes::{Arithmetic, LANES, Lanes, One, Task, widest},
    packet::{Found, Packet, Rays, alike},
    sampling::uniform_sphere,
    stack::{STACK, Stack},
    stream::{Numbered, Stream},
    tree::{Beam, limit},
    triangle::{Hit, Ray, Triangle},
};
use glam::{DMat3, DVec3, Vec3};
use lightmend_scene::{Configuration, Lamp, Mesh, Motion, Object, lamp_rotation, trig::Double};
use std::sync::{Arc, OnceLock};

/// All that the ray meets of some bodies within a distance.
struct All<'t, 'r> {
    ray: &'r Ray<'r>,
    bodies: Vec<&'t Body>,
    farthest: f32,
    stack: &'r mut Stack,
}

impl<'t> Task for All<'t, '_> {
    type Output = Vec<Hit<'t>>;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Vec<Hit<'t>> {
        let (beam, mut found) = (Beam::new(lanes, self.ray), Vec::new());
        for body in self.bodies {
            body.meet_all(&beam, self.farthest, self.stack, &mut found);
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
    /// How far along their rays photons begin, metres: a step where the lamp lies in a surface, which they would otherwise all meet at once,
    /// whether they leave above or below; else 0.
    pub offset: f32,
}

impl PlacedLamp {
    /// Where a photon that leaves in `direction` begins.
    #[inline(always)]
    pub(crate) fn start(&self, direction: Vec3) -> Vec3 {
        let from = self.position.as_vec3();
        if self.offset > 0.0 { from + direction * self.offset } else { from }
    }
}

/// Objects in one tree.
#[derive(Clone)]
struct Still {
    body: Arc<Body>,
    /// In order of their numbers.
    objects: Arc<[Standing]>,
}

/// An object of [`Still`].
#[derive(Clone)]
struct Standing {
    id: usize,
    mesh: Arc<Mesh>,
    motion: Motion,
    /// By itself, for when it is a phantom.
    alone: Arc<OnceLock<Arc<Placed>>>,
}

impl Standing {
    /// Whether it stands there, and so, in a configuration.
    fn stands(&self, configuration: &Configuration) -> bool {
        configuration.has_object(self.id)
            && Arc::ptr_eq(&self.mesh, &configuration.object(self.id).mesh)
            && configuration.object_motion(self.id) == self.motion
    }
}

impl Still {
    fn new(configuration: &Configuration, reach: Reach, preset: TreePreset) -> Still {
        let standing = |(id, object): (usize, &Object)| {
            let motion = configuration.object_motion(id);
            Standing { id, mesh: object.mesh.clone(), motion, alone: Arc::default() }
        };
        let objects: Arc<[Standing]> = configuration.objects().map(standing).collect();
        let triangles = |standing: &Standing| triangles_of(configuration.object(standing.id), standing.id, &standing.motion);
        Still { body: Arc::new(Body::new(objects.iter().flat_map(triangles).collect(), reach, preset)), objects }
    }

    fn find(&self, id: usize) -> Option<&Standing> {
        self.objects.binary_search_by_key(&id, |standing| standing.id).ok().map(|n| &self.objects[n])
    }

    /// Those that still stand so; `None` if something is gone that cannot move.
    fn reduced(&self, before: &Configuration, after: &Configuration, reach: Reach) -> Option<Still> {
        if self.objects.iter().all(|standing| standing.stands(after)) {
            return Some(self.clone());
        }
        let (stay, gone): (Vec<_>, Vec<_>) = self.objects.iter().cloned().partition(|standing| standing.stands(after));
        if gone.iter().any(|standing| !before.object(standing.id).dynamic) {
            return None;
        }
        let mut left = Still { body: self.body.clone(), objects: stay.into() };
        left.body = Arc::new(self.body.reduced(|id| left.find(id).is_some(), reach));
        Some(left)
    }
}

/// A configuration, ready to trace.
#[derive(Clone)]
pub struct World {
    configuration: Configuration,
    finishes: Arc<Finishes>,
    still: Still,
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
    let triangle = |(t, indices): (usize, &[u32; 3])| Triangle {
        cut: object.lattice.cut(t),
        material: object.mesh.material_of[t],
        ..Triangle::new(indices.map(|i| corners[i as usize]), key, id, t)
    };
    triangles.map(triangle).collect()
}

fn place_lamp(configuration: &Configuration, id: usize) -> PlacedLamp {
    let motion = configuration.lamp_motion(id);
    PlacedLamp { position: motion.translation, rotation: lamp_rotation(configuration.scene().up, &motion), offset: 0.0 }
}

impl World {
    /// Builds the tree. `preset` is for what stands still; what moves gets the other one.
    pub fn new(configuration: &Configuration, preset: TreePreset) -> World {
        let reach = Reach::new(configuration.reach() as f32);
        let world = World {
            configuration: configuration.clone(),
            finishes: Arc::default(),
            still: Still::new(configuration, reach, preset),
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
        let Some(still) = self.still.reduced(&self.configuration, configuration, self.reach) else {
            // Something fixed is gone: what is there now, also what was added since, makes a new tree.
            return World::new(configuration, self.preset);
        };
        let finishes = Arc::new(Finishes::new(configuration));
        let mut world = World { configuration: configuration.clone(), finishes, still, ..self.clone() };
        let movers = configuration.objects().filter(|(id, _)| world.still.find(*id).is_none());
        let placed = movers.map(|(id, object)| {
            let motion = configuration.object_motion(id);
            let kept = self.crowd.find(id).filter(|p| p.motion == motion && Arc::ptr_eq(&p.mesh, &object.mesh));
            kept.cloned().unwrap_or_else(|| world.place(id, motion))
        });
        world.crowd = Crowd::new(placed.collect());
        world.lamps = (0..configuration.lamp_slots()).map(|id| place_lamp(configuration, id)).collect();
        for id in 0..world.lamps.len() {
            let in_surface = world.meets(world.lamps[id].position.as_vec3());
            world.lamps[id].offset = if in_surface { world.reach.step_back() } else { 0.0 };
        }
        let choice = LampChoice::new(configuration);
        if choice != *self.choice {
            world.choice = Arc::new(choice);
        }
        world
    }

    /// Whether a surface passes through a point, but for a few roundings of the largest coordinate.
    fn meets(&self, point: Vec3) -> bool {
        let step = 1e-6 * self.reach.metres;
        Vec3::AXES.iter().any(|axis| {
            let ray = Ray::new(point - *axis * step, *axis * (2.0 * step), None, 0.0);
            self.nearest(&ray).is_some_and(|hit| hit.distance <= 1.0)
        })
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
        let alone = |id: usize| match self.still.find(id) {
            Some(standing) => standing.alone.get_or_init(|| self.place(id, standing.motion)).clone(),
            None => self.place(id, self.motion(id)),
        };
        let placed = |id: &usize| self.crowd.find(*id).cloned().unwrap_or_else(|| alone(*id));
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

    /// All that stands where it stood at first.
    pub(crate) fn still(&self) -> &Arc<Body> {
        &self.still.body
    }

    /// The objects of [`still`](Self::still), in order.
    pub(crate) fn still_objects(&self) -> impl Iterator<Item = usize> + '_ {
        self.still.objects.iter().map(|standing| standing.id)
    }

    /// All other objects.
    pub(crate) fn crowd(&self) -> &Crowd {
        &self.crowd
    }

    /// The box about all that is there, padded, and the lamps.
    pub fn bounds(&self) -> [Vec3; 2] {
        let bodies = self.crowd.bounds().chain([self.still.body.bounds()]).filter(|[low, high]| low.cmple(*high).all());
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

    /// What a triangle of this world is made of.
    #[inline(always)]
    pub(crate) fn finish(&self, triangle: &Triangle) -> &Finish {
        self.finishes.of(triangle)
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
        let (crowd, still) = (&self.crowd, Some(&*self.still.body));
        STACK.with_borrow_mut(|stack| widest(Nearest { ray, crowd, still, best: None, stack }))
    }

    /// The same inside a task.
    #[inline(always)]
    pub(crate) fn nearest_in<L: Lanes>(&self, lanes: L, ray: &Ray, stack: &mut Stack) -> Option<Hit<'_>> {
        Nearest { ray, crowd: &self.crowd, still: Some(&self.still.body), best: None, stack }.run(lanes)
    }

    /// The first surfaces that those of eight rays meet whose bits are set; rays from free space.
    #[inline(always)]
    pub(crate) fn nearest_each<L: Lanes>(&self, l: L, rays: &Rays, mut of: u32, stack: &mut Stack) -> [Option<Hit<'_>>; LANES] {
        let mut hits = [None; LANES];
        while of != 0 {
            let alike = alike(l, rays.direction, of);
            of &= !alike;
            let packet = Packet::new(l, rays, alike);
            let mut found = Found::nothing(l, alike);
            self.crowd.meet_each(&packet, stack, &mut found);
            self.still.body.nearest_each(&packet, stack, &mut found);
            for (hit, met) in hits.iter_mut().zip(found.hits()) {
                *hit = met.or(*hit);
            }
        }
        hits
    }

    /// The first surfaces that the rays of a stream meet; `met` is of as many `None`.
    #[inline(always)]
    pub(crate) fn nearest_of_all<'w, 'r, L: Lanes>(
        &'w self,
        l: L,
        rays: &impl Numbered<'r>,
        stream: &mut Stream,
        stack: &mut Stack,
        met: &mut [Option<Hit<'w>>],
    ) {
        if !self.crowd.placed().is_empty() {
            for (n, best) in met.iter_mut().enumerate() {
                self.crowd.meet(&Beam::new(l, &rays.ray(n)), stack, best);
                stream.shorten(n, limit(best));
            }
        }
        self.still.body.nearest_of_all(l, rays, stream, met);
    }

    /// The same without the widest lanes of this machine.
    #[cfg(test)]
    pub(crate) fn nearest_portably(&self, ray: &Ray) -> Option<Hit<'_>> {
        self.nearest_in(crate::lanes::Portable, ray, &mut Stack::new())
    }

    /// What the ray meets at the distance of `hit`, but for rounding: surfaces that lie in one another. Which of them a photon meets is
    /// left to rounding, so the light of the place is the sum of theirs. `hit` comes first; neighbours that only share an edge with
    /// the ray are left out.
    pub fn layers<'w>(&'w self, ray: &Ray, hit: Hit<'w>) -> Vec<Hit<'w>> {
        // A few roundings of the largest coordinate.
        let slack = 1e-6 * self.reach.metres;
        let bodies = self.crowd.placed().iter().map(|placed| &placed.body).chain([&*self.still.body]).collect();
        let farthest = hit.distance + slack;
        let mut found = STACK.with_borrow_mut(|stack| widest(All { ray, bodies, farthest, stack }));
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
    #[inline(always)]
    pub fn emission(&self, id: usize, u: f64, v: f64) -> Vec3 {
        match &self.configuration.lamp(id).photometry {
            None => self.even_emission(One, id, u, v).into(),
            Some(photometry) => (self.lamps[id].rotation * photometry.sample(u, v)).as_vec3(),
        }
    }

    /// [`emission`](Self::emission) of eight photons, coordinate by coordinate.
    #[inline(always)]
    pub(crate) fn emissions<L: Lanes>(&self, l: L, id: usize, u: &[f64; LANES], v: &[f64; LANES]) -> [[f32; LANES]; 3] {
        let Some(photometry) = &self.configuration.lamp(id).photometry else {
            return l.store_vectors(self.even_emission(l, id, l.load_doubles(u), l.load_doubles(v)));
        };
        let mut directions = [[0.0; LANES]; 3];
        for (k, local) in photometry.sample_each(*u, *v).into_iter().enumerate() {
            let direction = (self.lamps[id].rotation * local).as_vec3();
            directions.iter_mut().zip(direction.to_array()).for_each(|(coordinates, d)| coordinates[k] = d);
        }
        directions
    }

    /// [`emission`](Self::emission) from a lamp that shines evenly, coordinate by coordinate.
    #[inline(always)]
    fn even_emission<A: Arithmetic>(&self, a: A, id: usize, u: A::Doubles, v: A::Doubles) -> [A::Numbers; 3] {
        let [x, y, z] = uniform_sphere(u, v);
        let [p, q, r] = self.lamps[id].rotation.to_cols_array_2d();
        [
            a.narrow(x.constant(p[0]) * x + y.constant(q[0]) * y + z.constant(r[0]) * z),
            a.narrow(x.constant(p[1]) * x + y.constant(q[1]) * y + z.constant(r[1]) * z),
            a.narrow(x.constant(p[2]) * x + y.constant(q[2]) * y + z.constant(r[2]) * z),
        ]
    }
}
