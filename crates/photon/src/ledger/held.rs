//! What is known of a chunk: in which worlds its records are right.
//!
//! All photons of a chunk are right in one world but for the marked ones, and each of those keeps the world in which it was last right:
//! there its old path is replayed. So edits may come before everything is scanned, or repaired.

use super::{
    chunk::{Chunk, Level},
    grid::Grid,
    numbers::{ESCAPED, Element, Numbers},
    scan::{Marks, Suspicion},
    surfaces::Surfaces,
};
use crate::{
    crowd::Crowd,
    importance::Importance,
    world::{Difference, World},
};
use std::{collections::BTreeMap, sync::Arc};

/// The number of a world; later ones are higher.
pub type WorldNumber = u32;

/// A chunk and what is known of it.
#[derive(Clone)]
pub struct Held {
    /// The records.
    pub chunk: Chunk,
    /// The world in which the records of all its photons are right but for the marked ones.
    pub right_in: WorldNumber,
    /// Photons that may have become wrong, with the world in which their records were last right. Each photon once.
    pub marked: Vec<(WorldNumber, Marks)>,
}

/// A world that records are right in, and what has changed since.
#[derive(Clone)]
pub struct Past {
    /// It.
    pub world: Arc<World>,
    /// Its triangles.
    pub surfaces: Arc<Surfaces>,
    /// What has changed since.
    pub since: Arc<Since>,
}

/// From a past world to the newest one.
pub struct Since {
    /// What differs.
    pub changed: Difference,
    /// Objects that stood elsewhere or are gone, in order.
    pub moved_out: Vec<usize>,
    /// Objects where they now stand and did not.
    pub moved_in: Crowd,
    /// What is looked for in records.
    pub suspicion: Suspicion,
}

impl Past {
    /// A world, and what has changed from it to the newest one.
    pub fn new(past: &Arc<World>, surfaces: Arc<Surfaces>, newest: &World, numbers: &Numbers, grid: &Grid) -> Past {
        let since = Arc::new(Since::new(past, newest, numbers, grid));
        Past { world: past.clone(), surfaces, since }
    }

    /// This is the newest world now.
    pub fn lead_to(&mut self, newest: &World, numbers: &Numbers, grid: &Grid) {
        self.since = Arc::new(Since::new(&self.world, newest, numbers, grid));
    }
}

impl Since {
    /// Looks at both.
    pub fn new(past: &World, world: &World, numbers: &Numbers, grid: &Grid) -> Since {
        let changed = past.difference(world);
        let has_moved = |id: &usize| !past.same_place(world, *id);
        let moved_out: Vec<usize> = changed.objects.iter().copied().filter(has_moved).collect();
        let there: Vec<usize> = moved_out.iter().copied().filter(|id| world.configuration().has_object(*id)).collect();
        let moved_in = world.phantoms(&there);
        let suspicion = Suspicion::new(past, &changed, &moved_in, numbers, grid);
        Since { changed, moved_out, moved_in, suspicion }
    }
}

impl Held {
    /// Marks what may have become wrong since this chunk was last right.
    pub fn scan(&mut self, pasts: &BTreeMap<WorldNumber, Past>, newest: WorldNumber) {
        if self.right_in != newest {
            self.mark(self.suspected(pasts), pasts, newest);
        }
    }

    /// What may have become wrong since this chunk was last right, and is not marked yet.
    pub fn suspected(&self, pasts: &BTreeMap<WorldNumber, Past>) -> Marks {
        let marks = pasts[&self.right_in].since.suspicion.marks(&self.chunk);
        self.marked.iter().fold(marks, |marks, (_, already)| marks.without(already))
    }

    /// Marks what is [`suspected`](Self::suspected).
    pub fn mark(&mut self, suspected: Marks, pasts: &BTreeMap<WorldNumber, Past>, newest: WorldNumber) {
        if suspected.count() > 0 {
            self.marked.push((self.right_in, suspected));
        }
        self.is_right_in(newest, pasts);
    }

    /// All but the marked photons are right in this world. Photons marked as right in a world that is like it are so too; not
    /// before, as a chunk's unmarked photons must all be right in one world.
    pub fn is_right_in(&mut self, newest: WorldNumber, pasts: &BTreeMap<WorldNumber, Past>) {
        self.right_in = newest;
        self.marked.retain(|(number, _)| !pasts[number].since.changed.is_empty());
    }

    /// How many photons there are.
    pub fn photons(&self) -> u64 {
        self.chunk.order().len() as u64
    }

    /// Memory, bytes; marks, of which there are none most of the time, apart.
    pub fn bytes(&self) -> u64 {
        (self.chunk.bytes() + size_of::<Held>() - size_of::<Chunk>()) as u64
    }

    /// How many photons are marked.
    pub fn marks(&self) -> u32 {
        self.marked.iter().map(|(_, marks)| marks.count()).sum()
    }

    /// How much the recorded deposits of a marked photon matter on average; `counts` says of which lamps first hits deposit.
    pub fn importance(&self, importance: &Importance, numbers: &Numbers, counts: &[bool]) -> u64 {
        if self.marked.is_empty() {
            return 0;
        }
        let is_marked = |rank: usize| self.marked.iter().any(|(_, marks)| marks.has(rank));
        let lamps = self.chunk.lamps();
        let first_counts = |rank: usize| counts.get(usize::from(lamps[rank.min(lamps.len() - 1)])).is_some_and(|counts| *counts);
        let mut sum = 0;
        for (level, Level { elements, .. }) in self.chunk.levels().enumerate() {
            for (rank, element) in elements.iter().enumerate() {
                if *element != ESCAPED && is_marked(rank) && (level > 0 || first_counts(rank)) {
                    let Element { object, cell, side } = numbers.element(*element);
                    sum += u64::from(importance.of(object, cell, side));
                }
            }
        }
        // Sums that are not 0 stay so.
        sum.div_ceil(u64::from(self.marks().max(1)))
    }
}
