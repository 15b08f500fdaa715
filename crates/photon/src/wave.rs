//! Many photons side by side: the same paths as one by one, segment after segment.
//!
//! All are emitted, then all their rays are traced, then all arrive, then the survivors leave. Each of these loops is compiled as one
//! piece for the widest lanes, and has independent work at hand while one photon waits for memory. In which order photons' hits are
//! recorded is of no consequence: deposits are integers.

use crate::{
    lanes::{Lanes, Portable, Task, widest},
    path::{Landing, Photon, Record, Rules},
    pool::PhotonIndex,
    stack::Stack,
    triangle::Ray,
    world::{STACK, World},
};

/// Who hears of many photons.
pub trait Log {
    /// Photon number `number` leaves its lamp, if there is one.
    #[inline(always)]
    fn emitted(&mut self, _number: u32, _photon: &Option<Photon>) {}

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

struct Wave<'a, 'w, I, L> {
    rules: &'a Rules,
    world: &'w World,
    /// Photons that are emitted, numbered from 0.
    indices: I,
    /// Those that are under way, with their numbers.
    photons: Vec<(u32, Photon<'w>)>,
    log: &'a mut L,
    stack: &'a mut Stack,
}

impl<I: Iterator<Item = PhotonIndex>, G: Log> Task for Wave<'_, '_, I, G> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Wave { rules, world, indices, mut photons, log, stack } = self;
        photons.reserve(indices.size_hint().0);
        for (number, index) in indices.enumerate() {
            let photon = Photon::emit(rules, world, index);
            log.emitted(number as u32, &photon);
            photons.extend(photon.map(|photon| (number as u32, photon)));
        }
        let (mut met, mut going) = (Vec::with_capacity(photons.len()), Vec::with_capacity(photons.len()));
        let (mut arrived, mut survivors): (Vec<(u32, Landing)>, Vec<u32>) = (Vec::new(), Vec::new());
        while !photons.is_empty() {
            for (number, photon) in &photons {
                log.of(*number).ray();
                met.push(world.nearest_in(lanes, photon.ray(), stack));
            }
            survivors.clear();
            survivors.resize(photons.len(), 0);
            for (place, ((number, photon), met)) in photons.iter().zip(&met).enumerate() {
                match met {
                    Some(hit) => arrived.push((place as u32, photon.land(rules, world, hit, &mut log.of(*number)))),
                    None => {
                        log.missed(*number, photon.ray());
                        photon.escape(&mut log.of(*number));
                    }
                }
            }
            // Who survives cannot be foreseen: sorted without a branch, or every other photon would stop the processor.
            let (mut lives, mut ends) = (0, survivors.len());
            for (n, (place, landing)) in arrived.iter().enumerate() {
                let goes_on = landing.survives & !photons[*place as usize].1.is_spent();
                survivors[if goes_on { lives } else { ends - 1 }] = n as u32;
                lives += usize::from(goes_on);
                ends -= usize::from(!goes_on);
            }
            for n in &survivors[ends..] {
                let (place, landing) = &arrived[*n as usize];
                let (number, photon) = &photons[*place as usize];
                photon.end(landing, &mut log.of(*number));
            }
            for n in &survivors[..lives] {
                let (place, landing) = &arrived[*n as usize];
                let ((number, photon), hit) = (&photons[*place as usize], &met[*place as usize]);
                going.extend(hit.as_ref().map(|hit| (*number, photon.leave(rules, world, hit, &landing.survivor))));
            }
            met.clear();
            arrived.clear();
            photons.clear();
            std::mem::swap(&mut photons, &mut going);
        }
    }
}

/// Traces photons through `world`. A few hundred at once do best.
pub fn trace_each(rules: &Rules, world: &World, indices: impl Iterator<Item = PhotonIndex>, record: &mut impl Record) {
    trace_apart(rules, world, indices, &mut Together(record));
}

/// As [`trace_each`], to the bit, with the instructions that every processor has: to compare.
pub fn trace_each_portably(rules: &Rules, world: &World, indices: impl Iterator<Item = PhotonIndex>, record: &mut impl Record) {
    let log = &mut Together(record);
    STACK.with_borrow_mut(|stack| Wave { rules, world, indices, photons: Vec::new(), log, stack }.run(Portable));
}

/// Traces photons through `world`, numbered from 0.
pub fn trace_apart(rules: &Rules, world: &World, indices: impl Iterator<Item = PhotonIndex>, log: &mut impl Log) {
    STACK.with_borrow_mut(|stack| widest(Wave { rules, world, indices, photons: Vec::new(), log, stack }));
}

/// Traces photons that are under way to their ends.
pub fn follow_apart<'w>(rules: &Rules, world: &'w World, photons: Vec<(u32, Photon<'w>)>, log: &mut impl Log) {
    STACK.with_borrow_mut(|stack| widest(Wave { rules, world, indices: std::iter::empty(), photons, log, stack }));
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
