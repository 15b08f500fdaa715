//! One photon: from its lamp through the room.
//!
//! A path is a pure function of the photon's index and a world. At every hit the photon deposits, then Russian roulette on the
//! surface's largest reflectance decides whether it goes on, in a Lambertian direction; throughput per channel stays at most 1.
//! Hit *k* takes dimensions 2+2k (event, remapped to one coordinate) and 3+2k (the other) of the sequence
//! (Dmitriev et al. 2002, §4.1).

use crate::{
    crowd::Crowd,
    finish::Finish,
    halton::Sequence,
    lanes::{Arithmetic, One, dots, scaled},
    pool::PhotonIndex,
    sampling::cosine_hemisphere,
    triangle::{Hit, Ray, Triangle, points},
    world::{Difference, World},
};
use glam::Vec3;
use lightmend_scene::Direct;

/// A path is cut after this many hits; at reflectance 0.999 a share of 10⁻²⁸ gets so far.
pub const LONGEST_PATH: u32 = 1 << 16;

/// Which hits deposit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FirstHits {
    /// As each lamp says: those of photon-drawn lamps.
    #[default]
    AsLampsSay,
    /// None: buckets hold indirect light alone.
    Never,
    /// All: buckets hold all light.
    Always,
}

/// How photons become paths; the same for all of a pool, in all worlds.
#[derive(Debug)]
pub struct Rules {
    /// Their random numbers.
    pub sequence: Sequence,
    /// Which hits deposit.
    pub first_hits: FirstHits,
}

/// How a path ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// A surface took the photon.
    Absorbed,
    /// It met nothing.
    Escaped,
    /// It had [`LONGEST_PATH`] hits.
    Cut,
}

/// A photon under way: about to leave a lamp or a surface.
#[derive(Debug, Clone, Copy)]
pub struct Photon<'w> {
    index: PhotonIndex,
    lamp: u16,
    /// Whether its first hit deposits.
    first_counts: bool,
    hits: u32,
    throughput: Vec3,
    ray: Ray<'w>,
}

/// What a photon brings to a hit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Brought {
    /// The number of its lamp.
    pub lamp: u16,
    /// What is left of it, per channel.
    pub throughput: Vec3,
    /// Whether the hit deposits.
    pub counts: bool,
}

impl Brought {
    /// To the first hit after a lamp.
    pub(crate) fn from_lamp(rules: &Rules, world: &World, lamp: u16) -> Brought {
        let counts = match rules.first_hits {
            FirstHits::AsLampsSay => world.configuration().lamp(usize::from(lamp)).direct == Direct::Photons,
            FirstHits::Never => false,
            FirstHits::Always => true,
        };
        Brought { lamp, throughput: Vec3::ONE, counts }
    }

    /// What is brought on after reflection.
    pub(crate) fn reflected(self, reflectance: Vec3) -> Brought {
        Brought { throughput: self.throughput * (reflectance / reflectance.max_element()), counts: true, ..self }
    }
}

/// What a photon takes along from a surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Survivor {
    throughput: Vec3,
    /// Its random number, remapped after the decision that it survives.
    u: f64,
}

/// What becomes of a photon at a surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Landing {
    /// Whether the surface reflects it.
    pub survives: bool,
    /// How, if so.
    pub survivor: Survivor,
}

/// What happens to a photon, as it happens.
pub trait Record {
    /// It meets a surface with the given throughput; `deposits` says whether the hit counts.
    fn hit(&mut self, hit: &Hit, side: u8, throughput: Vec3, lamp: u16, deposits: bool, world: &World);
    /// Its path ends with the given throughput.
    fn end(&mut self, end: End, throughput: Vec3, lamp: u16);
    /// A ray was traced through the trees.
    fn ray(&mut self);
}

impl<'w> Photon<'w> {
    /// Photon `index` as it leaves its lamp; `None` if there is no lamp.
    #[inline(always)]
    pub(crate) fn emit(rules: &Rules, world: &'w World, index: PhotonIndex) -> Option<Photon<'w>> {
        let (lamp, u) = world.choice().choose(rules.sequence.value(index.0, 0))?;
        let direction = world.emission(lamp, u, rules.sequence.value(index.0, 1));
        let ray = Ray::new(world.lamps()[lamp].start(direction), direction, None, 0.0);
        let lamp = lamp as u16;
        let Brought { throughput, counts, .. } = Brought::from_lamp(rules, world, lamp);
        Some(Photon { index, lamp, first_counts: counts, hits: 0, throughput, ray })
    }

    /// Photon `index` on its way, after `hits` hits.
    #[inline(always)]
    pub(crate) fn under_way(index: PhotonIndex, hits: u32, brings: Brought, ray: Ray<'w>) -> Photon<'w> {
        let Brought { lamp, throughput, counts } = brings;
        Photon { index, lamp, first_counts: counts, hits, throughput, ray }
    }

    /// What it brings to its next hit.
    pub(crate) fn brings(&self) -> Brought {
        Brought { lamp: self.lamp, throughput: self.throughput, counts: self.hits > 0 || self.first_counts }
    }

    /// Whether it leaves the same lamp on the same ray.
    pub(crate) fn leaves_like(&self, other: &Photon) -> bool {
        let bits = |ray: &Ray| [ray.origin, ray.direction].map(|v| v.to_array().map(f32::to_bits));
        self.lamp == other.lamp && bits(&self.ray) == bits(&other.ray)
    }

    /// Its number in the pool.
    pub(crate) fn index(&self) -> PhotonIndex {
        self.index
    }

    /// How often it has met a surface.
    pub(crate) fn hits(&self) -> u32 {
        self.hits
    }

    /// The ray that it is on.
    pub(crate) fn ray(&self) -> &Ray<'w> {
        &self.ray
    }

    /// The number of its lamp.
    pub(crate) fn lamp(&self) -> usize {
        usize::from(self.lamp)
    }

    /// Goes on to the next surface; `met` is what the ray meets. `None` when the path has ended.
    pub(crate) fn step<'n>(
        self,
        rules: &Rules,
        world: &World,
        met: Option<Hit<'n>>,
        record: &mut impl Record,
    ) -> Option<Photon<'n>> {
        let Some(hit) = met else {
            self.escape(record);
            return None;
        };
        let landing = self.land(rules, world, &hit, record);
        if !landing.survives || self.is_spent() {
            self.end(&landing, record);
            return None;
        }
        Some(self.leave(rules, world, &hit, &landing.survivor))
    }

    /// Arrives at a surface.
    #[inline(always)]
    pub(crate) fn land(&self, rules: &Rules, world: &World, hit: &Hit, record: &mut impl Record) -> Landing {
        let normal = hit.triangle.normal;
        let back = normal.dot(self.ray.direction) > 0.0;
        record.hit(hit, u8::from(back), self.throughput, self.lamp, self.brings().counts, world);
        let reflectance = reflectance(world, hit);
        let survival = f64::from(reflectance.max_element());
        let u = rules.sequence.value(self.index.0, 2 + 2 * self.hits as usize);
        let survivor =
            Survivor { throughput: self.brings().reflected(reflectance).throughput, u: (u / survival).min(1.0f64.next_down()) };
        Landing { survives: u < survival, survivor }
    }

    /// Ends where it landed: absorbed, or with a path as long as paths may be.
    #[inline(always)]
    pub(crate) fn end(&self, landing: &Landing, record: &mut impl Record) {
        if landing.survives {
            record.end(End::Cut, landing.survivor.throughput, self.lamp);
        } else {
            record.end(End::Absorbed, self.throughput, self.lamp);
        }
    }

    /// Ends where it meets nothing.
    pub(crate) fn escape(&self, record: &mut impl Record) {
        record.end(End::Escaped, self.throughput, self.lamp);
    }

    /// Whether its next hit is its last, whatever happens there.
    pub(crate) fn is_spent(&self) -> bool {
        self.hits + 1 == LONGEST_PATH
    }

    /// Leaves the surface that it met.
    #[inline(always)]
    pub(crate) fn leave<'n>(&self, rules: &Rules, world: &World, hit: &Hit<'n>, survivor: &Survivor) -> Photon<'n> {
        let normal = hit.triangle.normal;
        let facing = if normal.dot(self.ray.direction) > 0.0 { -normal } else { normal };
        let v = rules.sequence.value(self.index.0, 3 + 2 * self.hits as usize);
        let direction = cosine_hemisphere(facing, survivor.u, v);
        let step_back = world.reach().step_back();
        let corners = hit.triangle.corners.map(|corner| corner.to_array());
        let [normal, along] = [normal, self.ray.direction].map(|v| v.to_array());
        let origin = before(One, points(One, corners, hit.weights), hit.distance, normal, along, step_back);
        let ray = Ray::new(origin.into(), direction, Some(hit.triangle), step_back);
        Photon { hits: self.hits + 1, throughput: survivor.throughput, ray, ..*self }
    }

    /// Follows the photon to its end in one world.
    fn follow(self, rules: &Rules, world: &'w World, record: &mut impl Record) {
        let mut photon = self;
        loop {
            record.ray();
            let met = world.nearest(&photon.ray);
            match photon.step(rules, world, met, record) {
                Some(next) => photon = next,
                None => return,
            }
        }
    }
}

/// Points just before hits, on the rays themselves: unlike a step along the normal they cannot pass another surface, however acute the
/// corner. They stand `step_back` above the surface, nearer only where the ray is grazing or the way was short.
#[inline(always)]
pub(crate) fn before<A: Arithmetic>(
    a: A,
    points: [A::Numbers; 3],
    distances: A::Numbers,
    normals: [A::Numbers; 3],
    directions: [A::Numbers; 3],
    step_back: f32,
) -> [A::Numbers; 3] {
    let length = a.sqrt(dots(a, directions, directions));
    let unit = scaled(a, directions, a.div(a.splat(1.0), length));
    let way = a.mul(distances, length);
    let cosine = a.max(a.abs(dots(a, normals, unit)), a.splat(1.0 / 16.0));
    let [x, y, z] = scaled(a, unit, a.min(a.div(a.splat(step_back), cosine), a.div(way, a.splat(2.0))));
    [a.sub(points[0], x), a.sub(points[1], y), a.sub(points[2], z)]
}

/// Reflectance of the surface at a hit, per channel.
#[inline(always)]
pub fn reflectance(world: &World, hit: &Hit) -> Vec3 {
    let Finish { reflectance, texture } = world.finish(hit.triangle);
    match texture {
        None => *reflectance,
        Some(texture) => *reflectance * texture.sample(texture_coordinates(world, hit)),
    }
}

/// Where on its texture a surface is hit.
fn texture_coordinates(world: &World, hit: &Hit) -> [f32; 2] {
    match world.object(hit.triangle.object()).mesh.uvs.get(hit.triangle.in_mesh()) {
        None => [0.0; 2],
        Some(uvs) => {
            let uv = uvs.iter().zip(hit.weights).map(|(uv, w)| *uv * f64::from(w)).sum::<glam::DVec2>();
            uv.as_vec2().to_array()
        }
    }
}

/// Traces photon `index` through `world`.
pub fn trace(rules: &Rules, world: &World, index: PhotonIndex, record: &mut impl Record) {
    if let Some(photon) = Photon::emit(rules, world, index) {
        photon.follow(rules, world, record);
    }
}

/// What a photon met of what changed, on the part of its way that is the same in both worlds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Touched {
    /// Nothing: both paths are the same.
    Nothing,
    /// A changed object where it now stands, or as it now is.
    Object(usize),
    /// A changed object where it stood: its phantom.
    Phantom(usize),
    /// The photon leaves a lamp that changed, or another one than before.
    Lamp(usize),
}

/// Traces photon `index` in both worlds at once (Dmitriev et al. 2002, Algorithm 1): in the old one with phantoms of `changed`, in the
/// new one with those objects themselves (`phantoms` are those of `worlds[0]`). The common beginning is traced once and goes to `common`: it deposits the same in both.
/// From where they part, the old path goes to `old` and the new one to `new`.
pub fn trace_both(
    rules: &Rules,
    worlds: [&World; 2],
    changed: &Difference,
    phantoms: &Crowd,
    index: PhotonIndex,
    common: &mut impl Record,
    old: &mut impl Record,
    new: &mut impl Record,
) -> Touched {
    let [before, after] = worlds;
    let leaving = Photon::emit(rules, after, index);
    let left = if changed.choice { Photon::emit(rules, before, index) } else { leaving };
    let alike = match (&left, &leaving) {
        (Some(old), Some(new)) => old.leaves_like(new) && !changed.lamps.contains(&new.lamp()),
        (None, None) => return Touched::Nothing,
        _ => false,
    };
    let mut photon = match leaving {
        Some(photon) if alike => photon,
        _ => {
            let left = if changed.choice { left } else { Photon::emit(rules, before, index) };
            let lamp = leaving.or(left).map_or(0, |photon| photon.lamp());
            if let Some(photon) = left {
                photon.follow(rules, before, old);
            }
            if let Some(photon) = leaving {
                photon.follow(rules, after, new);
            }
            return Touched::Lamp(lamp);
        }
    };
    loop {
        common.ray();
        let met = after.nearest(&photon.ray);
        let phantom = phantoms.nearest(&photon.ray, met).filter(|hit| !is_same(hit, &met));
        let touched = match (&met, &phantom) {
            (_, Some(hit)) => Touched::Phantom(hit.triangle.object()),
            (Some(hit), None) if changed.objects.binary_search(&hit.triangle.object()).is_ok() => {
                Touched::Object(hit.triangle.object())
            }
            _ => Touched::Nothing,
        };
        if touched != Touched::Nothing {
            // What the old path meets: the phantom if it is nearest of all, otherwise its own traversal tells.
            let met_before = phantom.or_else(|| {
                old.ray();
                before.nearest(&photon.ray)
            });
            if let Some(next) = photon.step(rules, before, met_before, old) {
                next.follow(rules, before, old);
            }
            if let Some(next) = photon.step(rules, after, met, new) {
                next.follow(rules, after, new);
            }
            return touched;
        }
        match photon.step(rules, after, met, common) {
            Some(next) => photon = next,
            None => return Touched::Nothing,
        }
    }
}

fn is_same(hit: &Hit, met: &Option<Hit>) -> bool {
    met.is_some_and(|met| std::ptr::eq::<Triangle>(hit.triangle, met.triangle))
}

/// The mesh element at a hit.
#[inline(always)]
pub fn cell(hit: &Hit) -> u32 {
    hit.triangle.cut.cell(hit.weights[1], hit.weights[2])
}
