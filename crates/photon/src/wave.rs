//! Many photons side by side: the same paths as one by one, segment after segment.
//!
//! All are emitted, then all their rays are traced, then all arrive, then the survivors leave. Rays that leave lamps in much the same direction
//! are traced in packets (`packet.rs`), those that leave surfaces as a stream (`stream.rs`). Directions, origins and throughputs are computed eight
//! at a time, coordinate by coordinate, with the same functions that serve one photon. In which order photons' hits are recorded is of no
//! consequence: deposits are integers.

mod flock;

use crate::{
    lanes::{LANES, Lanes, Portable, Task, widest},
    path::{End, Photon, Record, Rules},
    pool::PhotonIndex,
    record::Watch,
    stack::{STACK, Stack},
    stream::{Numbered, Stream},
    triangle::{Hit, Ray},
    world::World,
};
use flock::{Flock, Landing, lane, neighbours, starts};
use std::ops::RangeInclusive;

/// Who hears of many photons.
pub trait Log {
    /// Photon number `number` leaves a lamp, if there is one.
    #[inline(always)]
    fn emitted(&mut self, _number: u32, _lamp: Option<u16>) {}

    /// It meets nothing on this ray.
    #[inline(always)]
    fn missed(&mut self, _number: u32, _ray: &Ray) {}

    /// Hears of what else happens to it.
    fn of(&mut self, number: u32) -> impl Record;
}

/// One record for all of them.
struct Together<'r, R>(&'r mut R);

impl<R: Record> Log for Together<'_, R> {
    #[inline(always)]
    fn of(&mut self, _number: u32) -> impl Record {
        &mut *self.0
    }
}

/// So many rays that left surfaces are traced together; fewer are not worth a list.
const TOGETHER: RangeInclusive<usize> = 16..=Stream::MOST;

struct Wave<'a, 'w, I, L> {
    rules: &'a Rules,
    world: &'w World,
    /// Photons that are emitted, with their numbers.
    indices: I,
    /// Photons that are under way already, with their numbers. They join the others when these have met something.
    under_way: &'a [(u32, Photon<'w>)],
    log: &'a mut L,
    stack: &'a mut Stack,
}

impl<I: Iterator<Item = (u32, PhotonIndex)>, G: Log> Task for Wave<'_, '_, I, G> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) {
        let Wave { rules, world, indices, mut under_way, log, stack } = self;
        let (mut photons, mut stream) = (Flock::default(), Stream::default());
        let starts = starts(rules, indices);
        photons.emit_all(l, rules, world, &starts, &neighbours(&starts), log);
        let mut from_lamps = photons.len > 0;
        if !from_lamps {
            photons.join(&mut under_way);
        }
        let mut going = Flock::default();
        let (mut met, mut landings): (Vec<Option<Hit>>, Vec<Landing>) =
            (Vec::with_capacity(photons.len), Vec::with_capacity(photons.eights().len()));
        let mut places: Vec<u32> = Vec::with_capacity(photons.len);
        while photons.len > 0 {
            for (n, eight) in photons.eights().iter().enumerate() {
                for number in &eight.numbers[..photons.lanes(n)] {
                    log.of(*number).ray();
                }
            }
            met.clear();
            if from_lamps {
                for (n, eight) in photons.eights().iter().enumerate() {
                    let count = photons.lanes(n);
                    met.extend_from_slice(&world.nearest_each(l, &eight.rays(), (1 << count) - 1, stack)[..count]);
                }
            } else if TOGETHER.contains(&photons.len) {
                stream.clear();
                for (n, eight) in photons.eights().iter().enumerate() {
                    stream.extend(l, &eight.rays(), photons.lanes(n));
                }
                met.resize(photons.len, None);
                world.nearest_of_all(l, &photons, &mut stream, stack, &mut met);
            } else {
                for place in 0..photons.len {
                    met.push(world.nearest_in(l, &photons.ray(place), stack));
                }
            }
            from_lamps = false;
            places.clear();
            places.resize(photons.len, 0);
            let (mut lives, mut ends) = (0, photons.len);
            landings.clear();
            for (n, eight) in photons.eights().iter().enumerate() {
                let met = &met[n * LANES..][..photons.lanes(n)];
                let (landing, survivors) = eight.land(l, rules, world, met, log);
                landings.push(landing);
                // Who survives cannot be foreseen: sorted without a branch, or every other photon would stop the processor.
                for k in 0..met.len() {
                    let goes_on = survivors >> k & 1;
                    places[if goes_on != 0 { lives } else { ends - 1 }] = (n * LANES + k) as u32;
                    lives += goes_on as usize;
                    ends -= 1 - goes_on as usize;
                }
            }
            for place in places[ends..].iter().map(|place| *place as usize) {
                let (eight, k) = (&photons.eights()[place / LANES], place % LANES);
                let mut record = log.of(eight.numbers[k]);
                match &met[place] {
                    None => record.end(End::Escaped, lane(&eight.throughput, k).into(), eight.lamps[k]),
                    Some(_) if landings[place / LANES].u[k] < 1.0 => {
                        record.end(End::Cut, lane(&landings[place / LANES].throughput, k).into(), eight.lamps[k]);
                    }
                    Some(_) => record.end(End::Absorbed, lane(&eight.throughput, k).into(), eight.lamps[k]),
                }
            }
            going.clear();
            for places in places[..lives].chunks(LANES) {
                going.leave(l, rules, world.reach().step_back(), &photons, (&met, &landings), places);
            }
            going.join(&mut under_way);
            std::mem::swap(&mut photons, &mut going);
        }
    }
}

/// Traces photons through `world`. A few thousand at once do best.
pub fn trace_each(rules: &Rules, world: &World, indices: impl Iterator<Item = PhotonIndex>, record: &mut impl Record) {
    trace_apart(rules, world, (0..).zip(indices), &[], &mut Together(record));
}

/// As [`trace_each`], to the bit, with the instructions that every processor has: to compare.
pub fn trace_each_portably(rules: &Rules, world: &World, indices: impl Iterator<Item = PhotonIndex>, record: &mut impl Record) {
    let log = &mut Together(record);
    STACK.with_borrow_mut(|stack| Wave { rules, world, indices: (0..).zip(indices), under_way: &[], log, stack }.run(Portable));
}

/// Traces photons through `world`, from their lamps and from where they are, each with its number.
pub fn trace_apart<'w>(
    rules: &Rules,
    world: &'w World,
    indices: impl Iterator<Item = (u32, PhotonIndex)>,
    under_way: &[(u32, Photon<'w>)],
    log: &mut impl Log,
) {
    STACK.with_borrow_mut(|stack| widest(Wave { rules, world, indices, under_way, log, stack }));
}

/// Photons as they leave their lamps; none where there are no lamps.
struct Leaving<'a, 'w, I> {
    rules: &'a Rules,
    world: &'w World,
    indices: I,
}

/// Nobody listens.
struct Nobody;

impl Log for Nobody {
    fn of(&mut self, _number: u32) -> impl Record {
        Watch::default()
    }
}

impl<'w, I: Iterator<Item = PhotonIndex>> Task for Leaving<'_, 'w, I> {
    type Output = Vec<Photon<'w>>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Vec<Photon<'w>> {
        let mut photons = Flock::default();
        let starts = starts(self.rules, (0..).zip(self.indices));
        let in_turn: Vec<u32> = (0..starts.len() as u32).collect();
        photons.emit_all(l, self.rules, self.world, &starts, &in_turn, &mut Nobody);
        (0..photons.len).map(|place| photons.eights()[place / LANES].photon(place % LANES)).collect()
    }
}

/// Photons as they leave their lamps; none where there are no lamps. In less time than one by one.
pub fn emit_each<'w>(rules: &Rules, world: &'w World, indices: impl Iterator<Item = PhotonIndex>) -> Vec<Photon<'w>> {
    widest(Leaving { rules, world, indices })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        body::TreePreset,
        halton::{Scrambling, Sequence},
        path::{FirstHits, trace},
        record::Outcome,
    };
    use lightmend_scene::{Configuration, Edit, Scene};
    use rayon::prelude::*;

    /// A whole pool, with the table in the tree of what stands still and with it moved out of there.
    #[test]
    fn a_pool_is_the_same_portably_and_one_by_one() {
        let path = format!("{}/../../scenes/room/room.ron", env!("CARGO_MANIFEST_DIR"));
        let room = Configuration::initial(&Scene::read(path.as_ref()).unwrap().0);
        let moved = room.apply(&Edit::Move { object: "table".into(), to: glam::DVec3::new(2.6, 1.0, 0.0) }).unwrap();
        let world = World::new(&room, TreePreset::default());
        let rules = Rules { sequence: Sequence::new(Scrambling::Seed(5)), first_hits: FirstHits::Always };
        for (world, lamps) in [(world.moved_to(&moved), moved.lamp_slots()), (world, room.lamp_slots())] {
            (0..288u64).into_par_iter().for_each(|class| {
                let indices = || (class..200_000).step_by(288).map(PhotonIndex);
                let outcomes = [(); 3].map(|()| Outcome::new(lamps, false));
                let [mut wide, mut portable, mut single] = outcomes;
                trace_each(&rules, &world, indices(), &mut wide);
                trace_each_portably(&rules, &world, indices(), &mut portable);
                assert!(wide == portable, "class {class}");
                indices().for_each(|index| trace(&rules, &world, index, &mut single));
                for outcome in [&mut wide, &mut single] {
                    outcome.deposits.sort_by_key(|d| (d.to.object, d.to.cell, d.to.side, d.to.lamp, d.energy));
                }
                assert!(wide == single, "class {class}");
            });
        }
    }
}
