//! Many photons side by side: the same paths as one by one, segment after segment.
//!
//! All are emitted, then all their rays are traced, then all arrive, then the survivors leave. In each of these loops the processor
//! has independent work at hand while one photon waits for memory. In which order photons' hits are recorded is of no consequence:
//! deposits are integers.

use crate::{
    lanes::{Lanes, Task, widest},
    path::{Photon, Record, Rules},
    pool::PhotonIndex,
    stack::Stack,
    tree::{AsRay, FLYING},
    triangle::Ray,
    world::{STACKS, World},
};

impl AsRay for Photon<'_> {
    #[inline(always)]
    fn as_ray(&self) -> &Ray<'_> {
        self.ray()
    }
}

struct Wave<'a, I, R> {
    rules: &'a Rules,
    world: &'a World,
    indices: I,
    record: &'a mut R,
    stacks: &'a mut [Stack; FLYING],
}

impl<I: Iterator<Item = PhotonIndex>, R: Record> Task for Wave<'_, I, R> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Wave { rules, world, indices, record, stacks } = self;
        let mut photons = Vec::with_capacity(256);
        for index in indices {
            photons.extend(Photon::emit(rules, world, index));
        }
        let (mut met, mut going, mut survivors) = (Vec::new(), Vec::with_capacity(photons.len()), Vec::with_capacity(photons.len()));
        while !photons.is_empty() {
            world.nearest_each(lanes, &photons, stacks, &mut met);
            survivors.clear();
            for (number, (photon, met)) in photons.iter().zip(&met).enumerate() {
                record.ray();
                if let Some(survivor) = photon.land(rules, world, met, record) {
                    survivors.push((number, survivor));
                }
            }
            going.clear();
            for (number, survivor) in &survivors {
                if let Some(hit) = &met[*number] {
                    going.push(photons[*number].leave(rules, world, hit, *survivor));
                }
            }
            std::mem::swap(&mut photons, &mut going);
        }
    }
}

/// Traces photons through `world`. A few hundred at once do best.
pub fn trace_each(rules: &Rules, world: &World, indices: impl Iterator<Item = PhotonIndex>, record: &mut impl Record) {
    STACKS.with_borrow_mut(|stacks| widest(Wave { rules, world, indices, record, stacks }));
}
