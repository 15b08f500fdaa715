//! Many photons side by side: the same paths as one by one, segment after segment.
//!
//! All are emitted, then all their rays are traced, then all arrive, then the survivors leave. Each of these loops is compiled as one
//! piece for the widest lanes, and has independent work at hand while one photon waits for memory. In which order photons' hits are
//! recorded is of no consequence: deposits are integers.

use crate::{
    lanes::{Lanes, Task, widest},
    path::{Photon, Record, Rules},
    pool::PhotonIndex,
    stack::Stack,
    world::{STACK, World},
};

struct Wave<'a, I, R> {
    rules: &'a Rules,
    world: &'a World,
    indices: I,
    record: &'a mut R,
    stack: &'a mut Stack,
}

impl<I: Iterator<Item = PhotonIndex>, R: Record> Task for Wave<'_, I, R> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Wave { rules, world, indices, record, stack } = self;
        let mut photons = Vec::with_capacity(indices.size_hint().0);
        for index in indices {
            photons.extend(Photon::emit(rules, world, index));
        }
        let (mut met, mut going) = (Vec::new(), Vec::new());
        while !photons.is_empty() {
            for photon in &photons {
                record.ray();
                met.push(world.nearest_in(lanes, photon.ray(), stack));
            }
            let mut survivors = Vec::with_capacity(photons.len());
            for (photon, met) in photons.iter().zip(&met) {
                if let (Some(survivor), Some(hit)) = (photon.land(rules, world, met, record), met) {
                    survivors.push((photon, hit, survivor));
                }
            }
            going.clear();
            for (photon, hit, survivor) in &survivors {
                going.push(photon.leave(rules, world, hit, *survivor));
            }
            met.clear();
            std::mem::swap(&mut photons, &mut going);
        }
    }
}

/// Traces photons through `world`. A few hundred at once do best.
pub fn trace_each(rules: &Rules, world: &World, indices: impl Iterator<Item = PhotonIndex>, record: &mut impl Record) {
    STACK.with_borrow_mut(|stack| widest(Wave { rules, world, indices, record, stack }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        body::TreePreset,
        halton::{Scrambling, Sequence},
        lanes::Portable,
        path::{FirstHits, Outcome, trace},
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
                let stack = &mut Stack::new();
                Wave { rules: &rules, world: &world, indices: indices(), record: &mut portable, stack }.run(Portable);
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
