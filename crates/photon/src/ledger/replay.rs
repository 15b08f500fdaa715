//! A suspected photon: its old light from the record, its new path as far as possible from the record too.
//!
//! Where a ray is known to the bit, meeting the recorded triangle alone gives the hit to the bit, without the trees. What else the
//! ray could meet now are only objects that moved; so the hit after an edit is the nearest of the recorded triangle and those. The
//! trees are traversed from the first segment on whose surface went away. What the old path brought from there on follows from its
//! elements and their materials in the world in which it was recorded; only as far as a textured surface reflected it must it be
//! replayed, as the reflectance is another at every point.

use super::{
    chunk::{Entry, NO_LAMP},
    grid::Grid,
    numbers::{ESCAPED, Element, Numbers},
    surfaces::Surfaces,
};
use crate::{
    bucket::Address,
    crowd::Crowd,
    path::{Brought, End, LONGEST_PATH, Photon, Record, Rules, cell, reflectance},
    pool::PhotonIndex,
    record::{Outcome, Watch},
    triangle::{Hit, Ray, Triangle},
    wave::Log,
    world::{Difference, World},
};
use glam::Vec3;

/// How paths are written down.
#[derive(Clone, Copy)]
pub struct Recorder<'a> {
    /// Numbers of elements.
    pub numbers: &'a Numbers,
    /// Where points are stored.
    pub grid: &'a Grid,
}

/// Writes a path down and gathers its light.
struct Writing<'a> {
    recorder: Recorder<'a>,
    outcome: &'a mut Outcome,
    path: &'a mut Vec<Entry>,
}

impl Record for Writing<'_> {
    #[inline(always)]
    fn hit(&mut self, hit: &Hit, side: u8, throughput: Vec3, lamp: u16, deposits: bool, _: &World) {
        let (object, cell) = (hit.triangle.object(), cell(hit));
        let place = self.recorder.grid.place(hit.triangle.point(hit.weights));
        self.path.push(Entry { place, element: self.recorder.numbers.of(Element { object, cell, side }) });
        if deposits {
            self.outcome.deposit(Address { object: object as u32, cell, side, lamp }, throughput);
        }
    }

    fn end(&mut self, end: End, throughput: Vec3, lamp: u16) {
        self.outcome.end(end, throughput, lamp);
    }

    fn ray(&mut self) {
        self.outcome.ray();
    }
}

impl Recorder<'_> {
    /// Writes down where a ray leaves.
    fn escape(&self, ray: &Ray) -> Entry {
        Entry { place: self.grid.exit(ray.origin, ray.direction), element: ESCAPED }
    }

    /// One step, written down.
    fn step<'w>(
        self,
        photon: Photon,
        rules: &Rules,
        world: &World,
        met: Option<Hit<'w>>,
        outcome: &mut Outcome,
        path: &mut Vec<Entry>,
    ) -> Option<Photon<'w>> {
        if met.is_none() {
            path.push(self.escape(photon.ray()));
        }
        photon.step(rules, world, met, &mut Writing { recorder: self, outcome, path })
    }
}

/// Paths of the photons of a chunk while they are traced.
#[derive(Default)]
pub struct Drafts {
    /// By the photon's number in its chunk.
    pub paths: Vec<Vec<Entry>>,
    /// Their lamps.
    pub lamps: Vec<u16>,
}

impl Drafts {
    /// For so many photons, none of which has a path.
    pub fn clear(&mut self, photons: usize) {
        self.paths.resize_with(self.paths.len().max(photons), Vec::new);
        self.paths.iter_mut().for_each(Vec::clear);
        self.lamps.clear();
        self.lamps.resize(photons, NO_LAMP);
    }
}

/// Writes paths down and gathers their light.
pub struct Clerk<'a> {
    /// How.
    pub recorder: Recorder<'a>,
    /// The paths.
    pub drafts: &'a mut Drafts,
    /// What they leave.
    pub outcome: &'a mut Outcome,
}

impl Log for Clerk<'_> {
    #[inline(always)]
    fn emitted(&mut self, number: u32, lamp: Option<u16>) {
        self.drafts.lamps[number as usize] = lamp.unwrap_or(NO_LAMP);
    }

    #[inline(always)]
    fn missed(&mut self, number: u32, ray: &Ray) {
        self.drafts.paths[number as usize].push(self.recorder.escape(ray));
    }

    #[inline(always)]
    fn of(&mut self, number: u32) -> impl Record {
        Writing { recorder: self.recorder, outcome: self.outcome, path: &mut self.drafts.paths[number as usize] }
    }
}

/// A path at rest, with the triangles that it met, `None` where it escaped.
#[derive(Clone, Copy)]
pub struct Recorded<'r, 'a> {
    /// Its hits, and perhaps where it left.
    pub entries: &'r [Entry],
    /// As many.
    pub triangles: &'r [Option<&'a Triangle>],
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

/// From where a photon's path is to be traced.
#[derive(Debug, Clone, Copy)]
pub enum Onward<'a> {
    /// From nowhere: its record is right.
    Stays,
    /// Its new path is known to its end.
    Ends,
    /// From its lamp.
    Anew,
    /// From where its known path ends.
    From(Photon<'a>),
}

impl<'a> Passage<'a> {
    /// Whether nothing of a recorded path is left: its photon leaves another lamp, or one that changed.
    pub fn is_new(&self, index: PhotonIndex, was_lamp: u16) -> bool {
        let leaves =
            || self.after.choice().choose(self.rules.sequence.value(index.0, 0)).map_or(NO_LAMP, |(lamp, _)| lamp as u16);
        let lamp = if self.changed.choice { leaves() } else { was_lamp };
        lamp != was_lamp || self.changed.lamps.contains(&usize::from(lamp))
    }

    /// Takes back all that a photon left; how many of its hits were replayed.
    pub fn forget(&self, index: PhotonIndex, was_lamp: u16, recorded: Recorded<'_, 'a>, old: &mut Outcome) -> u64 {
        if was_lamp == NO_LAMP {
            return 0;
        }
        let brought = Brought::from_lamp(self.rules, self.before, was_lamp);
        let left = || Photon::emit(self.rules, self.before, index).expect("its lamp is recorded");
        self.take_back(brought, left, recorded, 0, old)
    }

    /// Repairs one photon that is not [new](Self::is_new), who is `leaving` its lamp, up to where its new path must be traced: what its old path leaves goes to
    /// `old`, what the new one leaves at the first hit that differs to `new`, the path so far to `path`. How many recorded hits were replayed.
    pub fn repair(
        &self,
        leaving: Option<Photon<'a>>,
        recorded: Recorded<'_, 'a>,
        old: &mut Outcome,
        new: &mut Outcome,
        path: &mut Vec<Entry>,
    ) -> (Onward<'a>, u64) {
        if let Some(photon) = &leaving
            && self.changed.choice
            && !self.leaves_alike(photon)
        {
            let replayed = self.forget(photon.index(), photon.lamp() as u16, recorded, old);
            return (Onward::Anew, replayed);
        }
        let mut photon = leaving;
        for (k, recorded_triangle) in recorded.triangles.iter().copied().enumerate() {
            let Some(here) = photon else { break };
            if recorded_triangle.is_some_and(|triangle| self.moved_out.binary_search(&triangle.object()).is_ok()) {
                let replayed = self.take_back(here.brings(), || here, recorded, k, old);
                path.extend_from_slice(&recorded.entries[..k]);
                return (Onward::From(here), k as u64 + replayed);
            }
            let was = recorded_triangle.map(|triangle| met(here.ray(), triangle));
            let now = self.moved_in.nearest(here.ray(), was);
            let same = match (&was, &now) {
                (Some(was), Some(now)) => was.triangle.is(now.triangle) && self.reflects_alike(was),
                (None, None) => true,
                _ => false,
            };
            if same {
                photon = here.step(self.rules, self.after, was, &mut Watch::default());
                continue;
            }
            let hits = k as u64 + u64::from(was.is_some());
            let replayed = self.take_back(here.brings(), || here, recorded, k, old);
            path.extend_from_slice(&recorded.entries[..k]);
            let onward = self.recorder.step(here, self.rules, self.after, now, new, path);
            return (onward.map_or(Onward::Ends, Onward::From), hits + replayed);
        }
        (Onward::Stays, recorded.triangles.iter().flatten().count() as u64)
    }

    /// Whether a photon left its lamp on the same ray.
    fn leaves_alike(&self, leaving: &Photon) -> bool {
        Photon::emit(self.rules, self.before, leaving.index()).is_some_and(|left| left.leaves_like(leaving))
    }

    /// The triangle of an entry where it was recorded; `None` if the path escaped.
    pub fn triangle(&self, entry: &Entry) -> Option<&'a Triangle> {
        (entry.element != ESCAPED).then(|| {
            let Element { object, cell, .. } = self.recorder.numbers.element(entry.element);
            self.surfaces.triangle(object, cell).expect("a recorded element is in the world of its record")
        })
    }

    /// Whether a surface that did not move is of the same reflectance at a hit.
    fn reflects_alike(&self, hit: &Hit) -> bool {
        let repainted = self.changed.objects.binary_search(&hit.triangle.object()).is_ok();
        let bits = |world| reflectance(world, hit).to_array().map(f32::to_bits);
        !repainted || bits(self.before) == bits(self.after)
    }

    /// Takes back what an old path left from hit `from` on; `brought` is what comes there and `photon` who brings it. How many hits
    /// were replayed.
    fn take_back(
        &self,
        mut brought: Brought,
        photon: impl Fn() -> Photon<'a>,
        recorded: Recorded<'_, 'a>,
        from: usize,
        old: &mut Outcome,
    ) -> u64 {
        let Recorded { entries, triangles } = recorded;
        if entries.len() >= LONGEST_PATH as usize {
            // Whether the last hit took it or only its length is not recorded.
            self.replay(photon(), &triangles[from..], old);
            return (entries.len() - from) as u64;
        }
        // Where the photon itself is known, and it there.
        let (mut at, mut known): (usize, Option<Photon>) = (from, None);
        for n in from..entries.len() {
            let Some(triangle) = triangles[n] else {
                old.end(End::Escaped, brought.throughput, brought.lamp);
                break;
            };
            if brought.counts {
                let Element { object, cell, side } = self.recorder.numbers.element(entries[n].element);
                old.deposit(Address { object: object as u32, cell, side, lamp: brought.lamp }, brought.throughput);
            }
            if n + 1 == entries.len() {
                old.end(End::Absorbed, brought.throughput, brought.lamp);
                break;
            }
            let finish = self.before.finish(triangle);
            brought = if finish.texture.is_none() {
                brought.reflected(finish.reflectance)
            } else {
                let here = known.unwrap_or_else(&photon);
                let next = self.replay(here, &triangles[at..=n], &mut Watch::default()).expect("its record goes on");
                (at, known) = (n + 1, Some(next));
                next.brings()
            };
        }
        (at - from) as u64
    }

    /// Follows an old path by the triangles that it met; `None` if it ends there.
    fn replay(&self, mut photon: Photon<'a>, triangles: &[Option<&'a Triangle>], record: &mut impl Record) -> Option<Photon<'a>> {
        for triangle in triangles {
            let was = triangle.map(|triangle| met(photon.ray(), triangle));
            photon = photon.step(self.rules, self.before, was, record)?;
        }
        Some(photon)
    }
}

fn met<'t>(ray: &Ray, triangle: &'t Triangle) -> Hit<'t> {
    ray.meet(triangle, &None).expect("a recorded ray meets its triangle again")
}

#[cfg(test)]
mod tests;
