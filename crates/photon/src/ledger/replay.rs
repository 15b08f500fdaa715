//! A suspected photon: its old path from the record, its new one as far as possible from the record too.
//!
//! Where a ray is known to the bit, meeting the recorded triangle alone gives the hit to the bit, without the trees. What else the
//! ray could meet now are only objects that moved; so the hit after an edit is the nearest of the recorded triangle and those. The
//! trees are traversed from the first segment on whose surface went away. The old path is replayed to its end in the world in which
//! it was recorded, and its deposits are taken back as they were made.

use super::{
    chunk::{Entry, NO_LAMP, Paths},
    grid::Grid,
    numbers::{ESCAPED, Numbers},
};
use crate::{
    path::{Photon, Record, Rules, Watch, reflectance},
    pool::PhotonIndex,
    triangle::{Hit, Ray, Triangle},
    world::{Crowd, Difference, Surfaces, World},
};

/// How paths are written down.
pub struct Recorder<'a> {
    /// Numbers of triangles.
    pub numbers: &'a Numbers,
    /// Where points are stored.
    pub grid: &'a Grid,
}

impl Recorder<'_> {
    fn entry(&self, ray: &Ray, met: &Option<Hit>) -> Entry {
        match met {
            Some(hit) => Entry {
                place: self.grid.place(hit.triangle.point(hit.weights)),
                triangle: self.numbers.of(hit.triangle.object(), hit.triangle.in_mesh()),
            },
            None => Entry { place: self.grid.exit(ray.origin, ray.direction), triangle: ESCAPED },
        }
    }

    /// Traces a photon to its end and writes its path down.
    fn follow<'w>(&self, mut photon: Photon<'w>, rules: &Rules, world: &'w World, record: &mut impl Record, paths: &mut Paths) {
        loop {
            record.ray();
            let met = world.nearest(photon.ray());
            paths.push(self.entry(photon.ray(), &met));
            match photon.step(rules, world, met, record) {
                Some(next) => photon = next,
                None => return,
            }
        }
    }

    /// Traces photon `index` and writes its path down.
    pub fn trace(&self, rules: &Rules, world: &World, index: PhotonIndex, record: &mut impl Record, paths: &mut Paths) {
        let photon = Photon::emit(rules, world, index);
        let lamp = photon.as_ref().map_or(NO_LAMP, |photon| photon.lamp() as u16);
        if let Some(photon) = photon {
            self.follow(photon, rules, world, record, paths);
        }
        paths.finish(lamp);
    }
}

/// From the world in which paths were recorded to the newest one.
pub struct Passage<'a> {
    /// How photons become paths.
    pub rules: &'a Rules,
    /// Where the paths were recorded.
    pub before: &'a World,
    /// Its triangles.
    pub surfaces: &'a Surfaces,
    /// The newest world.
    pub after: &'a World,
    /// From one to the other.
    pub changed: &'a Difference,
    /// Objects that stood elsewhere or are gone, in order.
    pub moved_out: &'a [usize],
    /// Objects where they now stand and did not.
    pub moved_in: &'a Crowd,
    /// How new paths are written down.
    pub recorder: Recorder<'a>,
}

impl Passage<'_> {
    /// Repairs one photon: what its old path leaves goes to `old`, what its new one leaves to `new`, its path to `paths`; both records
    /// hear only of where the paths part. Whether they part, and how many recorded hits were replayed.
    pub fn repair(
        &self,
        index: PhotonIndex,
        path: &[Entry],
        old: &mut impl Record,
        new: &mut impl Record,
        paths: &mut Paths,
    ) -> (bool, u64) {
        let triangle = |entry: &Entry| {
            let (object, in_mesh) = self.recorder.numbers.triangle(entry.triangle);
            self.surfaces.triangle(object, in_mesh).expect("a recorded triangle is in the world of its record")
        };
        let recorded = if path.last().is_some_and(|last| last.triangle == ESCAPED) { &path[..path.len() - 1] } else { path };
        let triangles: Vec<Triangle> = recorded.iter().map(triangle).collect();
        let leaving = Photon::emit(self.rules, self.after, index);
        let lamp = leaving.as_ref().map_or(NO_LAMP, |photon| photon.lamp() as u16);
        let lamp_changed = self.changed.choice || leaving.is_some_and(|photon| self.changed.lamps.contains(&photon.lamp()));
        let left = if lamp_changed { Photon::emit(self.rules, self.before, index) } else { leaving };
        let alike = match (&left, &leaving) {
            (Some(left), Some(leaving)) => left.leaves_like(leaving) && !self.changed.lamps.contains(&leaving.lamp()),
            (left, leaving) => left.is_none() && leaving.is_none(),
        };
        if !alike {
            if let Some(photon) = left {
                self.replay(photon, &triangles, old);
            }
            if let Some(photon) = leaving {
                self.recorder.follow(photon, self.rules, self.after, new, paths);
            }
            paths.finish(lamp);
            return (true, triangles.len() as u64);
        }
        let mut photon = leaving;
        let mut common = Watch::default();
        let mut parts = false;
        for (k, entry) in path.iter().enumerate() {
            let Some(here) = photon else { break };
            let recorded = triangles.get(k);
            let was = recorded.map(|triangle| met(here.ray(), triangle));
            let stays = recorded.is_none_or(|triangle| self.moved_out.binary_search(&triangle.object()).is_err());
            let now = if stays {
                self.moved_in.nearest(here.ray(), was)
            } else {
                new.ray();
                self.after.nearest(here.ray())
            };
            let same = match (&was, &now) {
                (Some(was), Some(now)) => stays && was.triangle.is(now.triangle) && self.reflects_alike(was),
                (None, None) => true,
                _ => false,
            };
            if same {
                paths.push(*entry);
                photon = here.step(self.rules, self.after, was, &mut common);
                continue;
            }
            parts = true;
            if let Some(next) = here.step(self.rules, self.before, was, old) {
                self.replay(next, &triangles[k + 1..], old);
            }
            paths.push(self.recorder.entry(here.ray(), &now));
            if let Some(next) = here.step(self.rules, self.after, now, new) {
                self.recorder.follow(next, self.rules, self.after, new, paths);
            }
            break;
        }
        paths.finish(lamp);
        (parts, triangles.len() as u64)
    }

    /// Whether a surface that did not move is of the same reflectance at a hit.
    fn reflects_alike(&self, hit: &Hit) -> bool {
        let repainted = self.changed.objects.binary_search(&hit.triangle.object()).is_ok();
        let bits = |world| reflectance(world, hit).to_array().map(f32::to_bits);
        !repainted || bits(self.before) == bits(self.after)
    }

    /// Follows the old path to its end by what is recorded of it.
    fn replay<'t>(&self, mut photon: Photon<'t>, triangles: &'t [Triangle], old: &mut impl Record) {
        for triangle in triangles.iter().map(Some).chain([None]) {
            let was = triangle.map(|triangle| met(photon.ray(), triangle));
            match photon.step(self.rules, self.before, was, old) {
                Some(next) => photon = next,
                None => return,
            }
        }
    }
}

fn met<'t>(ray: &Ray, triangle: &'t Triangle) -> Hit<'t> {
    ray.meet(triangle, &None).expect("a recorded ray meets its triangle again")
}
