//! Shooting a pool for the first time, slab by slab and class by class.

use crate::{
    bucket::{Buckets, Full, MOST_DEPOSITS},
    path::Rules,
    pool::PhotonIndex,
    record::{Outcome, Tally, book},
    wave::trace_each,
    world::World,
};
use rayon::prelude::*;
use std::{
    cell::RefCell,
    iter::once,
    ops::{AddAssign, Range},
    sync::{Arc, Mutex, PoisonError},
};

/// Work done: what a fair comparison counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Work {
    /// Photons traced (one that is re-shot counts once).
    pub photons: u64,
    /// Rays through the trees.
    pub rays: u64,
}

impl AddAssign for Work {
    fn add_assign(&mut self, more: Work) {
        self.photons += more.photons;
        self.rays += more.rays;
    }
}

/// Photons of one residue class in a row: they leave a lamp in nearly the same direction and visit the same nodes of the trees.
pub(crate) const CLASSES: u64 = 288;

/// So many photons side by side are traced fastest: more would have their rays nearer to one another, but themselves farther from the processor.
const WAVE: u64 = 4096;

/// Into how many classes some photons are best divided: waves that are large, but enough of them for all threads.
fn classes(photons: u64) -> u64 {
    let wanted = (photons / WAVE).max(4 * rayon::current_num_threads() as u64);
    (1..CLASSES).find(|count| CLASSES.is_multiple_of(*count) && *count >= wanted).unwrap_or(CLASSES)
}

/// A pool while it is shot for the first time: any prefix of it is a valid estimate.
#[derive(Clone)]
pub struct Shooting {
    pub(crate) rules: Arc<Rules>,
    pub(crate) world: Arc<World>,
    pub(crate) buckets: Buckets,
    pub(crate) tallies: Vec<Tally>,
    /// Work so far.
    pub work: Work,
}

thread_local! {
    /// What the last wave on a thread left: its memory serves the next one.
    static LEFT: RefCell<Outcome> = RefCell::new(Outcome::new(0, false));
}

impl Shooting {
    /// Nothing shot yet.
    pub fn new(rules: Arc<Rules>, world: Arc<World>) -> Shooting {
        let buckets = Buckets::new(world.configuration());
        let tallies = vec![Tally::default(); world.configuration().lamp_slots()];
        Shooting { rules, world, buckets, tallies, work: Work::default() }
    }

    /// Photons shot so far; their indices are the first ones.
    pub fn photons(&self) -> u64 {
        self.work.photons
    }

    /// How many photons to shoot at most between two looks at the clock. More are traced faster: they visit the same nodes of the trees.
    pub const SLAB: u64 = 1024 * CLASSES;

    /// How many at least.
    pub const LEAST: u64 = CLASSES;

    /// What is shot at.
    pub fn world(&self) -> &Arc<World> {
        &self.world
    }

    /// The light so far.
    pub fn buckets(&self) -> &Buckets {
        &self.buckets
    }

    /// Goes on in a world that differs from its own in nothing that photons meet: lamps that were dimmed, say.
    pub fn change(&mut self, world: Arc<World>) {
        self.buckets.grow(world.configuration());
        self.tallies.resize(self.tallies.len().max(world.configuration().lamp_slots()), Tally::default());
        self.world = world;
    }

    /// Shoots the next `count` photons, [`SLAB`](Self::SLAB) at most; none once the buckets hold what they can count of a first shooting.
    pub fn shoot(&mut self, count: u64) -> Result<(), Full> {
        has_room(&self.buckets, self.work.photons)?;
        let first = self.work.photons;
        let count = count.min(Shooting::SLAB);
        let indices = first..first + count;
        if self.tallies.is_empty() {
            self.work.photons += count;
            return Ok(());
        }
        let (classes, lamps, world) = (classes(count), self.tallies.len(), &*self.world);
        // Added while other waves are traced, and while it is still in the processor's caches. There is room for all of the slab.
        let light = Mutex::new((&mut self.buckets, &mut self.tallies, &mut self.work.rays));
        (0..classes).into_par_iter().try_for_each(|class| {
            LEFT.with_borrow_mut(|outcome| {
                outcome.clear(lamps);
                let photons = in_class(indices.clone(), class, classes, self.rules.sequence.copies());
                trace_each(&self.rules, world, photons, outcome);
                let (buckets, tallies, rays) = &mut *light.lock().unwrap_or_else(PoisonError::into_inner);
                **rays += outcome.rays;
                book(once(&*outcome), buckets, tallies)
            })
        })?;
        self.work.photons += count;
        Ok(())
    }

    /// Light that came about otherwise: what `work.photons` photons brought.
    pub(crate) fn of(rules: Arc<Rules>, world: Arc<World>, buckets: Buckets, tallies: Vec<Tally>, work: Work) -> Shooting {
        Shooting { rules, world, buckets, tallies, work }
    }
}

/// Whether a further slab of photons may be shot.
pub(crate) fn has_room(buckets: &Buckets, photons: u64) -> Result<(), Full> {
    if buckets.deposits() >= MOST_DEPOSITS || photons >= MOST_DEPOSITS as u64 { Err(Full) } else { Ok(()) }
}

/// The photons among `indices` whose points are congruent to `class` modulo `classes`; copy by copy, so that the tables of one
/// sequence stay at hand.
pub(crate) fn in_class(indices: Range<u64>, class: u64, classes: u64, copies: u32) -> impl Iterator<Item = PhotonIndex> {
    let shift = copies.ilog2();
    (0..1u64 << shift).flat_map(move |copy| {
        let first = indices.start.saturating_sub(copy).div_ceil(1 << shift);
        let end = indices.end.saturating_sub(copy).div_ceil(1 << shift);
        let first = first + (class + classes - first % classes) % classes;
        (first..end).step_by(classes as usize).map(move |point| PhotonIndex(point << shift | copy))
    })
}
