//! Many photons side by side: the same paths as one by one, segment after segment.
//!
//! All are emitted, then all their rays are traced, then those that survive go on. The processor then has many rays to choose from
//! while one of them waits for memory. In which order photons' hits are recorded is of no consequence: deposits are integers.

use crate::{
    path::{Photon, Record, Rules},
    pool::PhotonIndex,
    tree::AsRay,
    triangle::Ray,
    world::World,
};

impl AsRay for Photon<'_> {
    #[inline(always)]
    fn as_ray(&self) -> &Ray<'_> {
        self.ray()
    }
}

/// Traces photons through `world`. A few hundred at once do best.
pub fn trace_each(rules: &Rules, world: &World, indices: impl Iterator<Item = PhotonIndex>, record: &mut impl Record) {
    let mut photons: Vec<Photon> = indices.filter_map(|index| Photon::emit(rules, world, index)).collect();
    let (mut met, mut going) = (Vec::new(), Vec::with_capacity(photons.len()));
    while !photons.is_empty() {
        world.nearest_each(&photons, &mut met);
        for (photon, met) in photons.drain(..).zip(met.drain(..)) {
            record.ray();
            going.extend(photon.step(rules, world, met, record));
        }
        std::mem::swap(&mut photons, &mut going);
    }
}
