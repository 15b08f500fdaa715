//! Repair in steps of a few chunks, which threads share.

use super::{
    LedgerSolution,
    chunk::{Chunk, PHOTONS, Paths},
    gather,
    held::Past,
    replay::{Passage, Recorder},
    scan::Marks,
};
use crate::{
    path::Outcome,
    pool::PhotonIndex,
    solution::{CLASSES, Work, in_class},
};
use rayon::prelude::*;

/// A step of repair.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Mended {
    /// Photons whose paths changed, and rays through the trees.
    pub work: Work,
    /// Recorded hits that were replayed by meeting their triangle alone, beside `work`.
    pub replayed: u64,
    /// The photons that had been marked.
    pub photons: Vec<PhotonIndex>,
}

/// Chunks repaired in one step. More: more for threads to share; fewer: a shorter step.
const STEP: usize = 16;

/// What repairing one chunk brings.
struct Repair {
    old: Outcome,
    new: Outcome,
    parted: u64,
    replayed: u64,
    photons: Vec<PhotonIndex>,
    /// Its new records, if any path changed.
    chunk: Option<Chunk>,
}

impl LedgerSolution {
    /// Repairs the next chunks that hold marked photons: those that [`look`](Self::look) put first, then all in a fixed pseudo-random
    /// order that goes round. A chunk that was not scanned since the last edit is scanned first: without any scan before, this goes through
    /// the whole pool once. `None` if nothing is outstanding.
    pub fn repair_next(&mut self) -> Option<Mended> {
        let next = self.next_chunks();
        let repairs: Vec<Repair> = next.par_iter().map(|number| self.repair_chunk(*number)).collect();
        let mut mended = Mended::default();
        for (number, repair) in next.iter().zip(repairs) {
            for outcome in [&repair.old, &repair.new] {
                gather(&mut self.buckets, &mut self.tallies, outcome);
            }
            mended.work += Work { photons: repair.parted, rays: repair.new.rays };
            mended.replayed += repair.replayed;
            mended.photons.extend(repair.photons);
            let held = &mut self.chunks[*number];
            self.outstanding -= u64::from(held.marks());
            held.marked.clear();
            if let Some(chunk) = repair.chunk {
                self.bytes -= held.bytes();
                held.chunk = chunk;
                self.bytes += held.bytes();
            }
        }
        (!next.is_empty()).then_some(mended)
    }

    /// Chunks with marked photons, all of them scanned.
    fn next_chunks(&mut self) -> Vec<usize> {
        while self.outstanding > 0 {
            let next = self.next_outstanding();
            for number in &next {
                // Otherwise its photons would be right in different worlds.
                let held = &mut self.chunks[*number];
                if held.right_in != self.newest {
                    held.scan(&self.pasts, self.newest);
                    self.unscanned -= 1;
                    self.outstanding -= held.photons() - u64::from(held.marks());
                }
            }
            let marked: Vec<usize> = next.into_iter().filter(|number| !self.chunks[*number].marked.is_empty()).collect();
            if !marked.is_empty() {
                return marked;
            }
        }
        Vec::new()
    }

    fn next_outstanding(&mut self) -> Vec<usize> {
        let mut next = Vec::new();
        let is_outstanding = |number: u32| {
            let held = &self.chunks[number as usize];
            !held.marked.is_empty() || held.right_in != self.newest
        };
        while next.len() < STEP
            && let Some(number) = self.visible.pop()
        {
            next.extend(is_outstanding(number).then_some(number as usize));
        }
        if next.is_empty() {
            let chunks = self.shuffled.len();
            let turns = (self.turn..self.turn + chunks).map(|turn| turn % chunks);
            for turn in turns.filter(|turn| is_outstanding(self.shuffled[*turn])).take(STEP) {
                next.push(self.shuffled[turn] as usize);
                self.turn = turn + 1;
            }
        }
        next
    }

    fn repair_chunk(&self, number: usize) -> Repair {
        let held = &self.chunks[number];
        let lamps = self.tallies.len();
        let mut repair = Repair {
            old: Outcome::new(lamps, true),
            new: Outcome::new(lamps, false),
            parted: 0,
            replayed: 0,
            photons: Vec::new(),
            chunk: None,
        };
        let passages: Vec<(Passage, &Marks)> = held
            .marked
            .iter()
            .map(|(past, marks)| {
                let Past { world, surfaces, since } = &self.pasts[past];
                let passage = Passage {
                    rules: &self.rules,
                    before: world,
                    surfaces,
                    after: &self.world,
                    changed: &since.changed,
                    moved_out: &since.moved_out,
                    moved_in: &since.moved_in,
                    recorder: Recorder { numbers: &self.numbers, grid: &self.grid },
                };
                (passage, marks)
            })
            .collect();
        let mut passage_of = [None; PHOTONS];
        for (rank, photon) in held.chunk.order().iter().enumerate() {
            passage_of[usize::from(*photon)] = passages.iter().find(|(_, marks)| marks.has(rank)).map(|(passage, _)| passage);
        }
        let (recorded, mut paths) = (held.chunk.unpack(), Paths::default());
        for (photon, index) in self.members(number).enumerate() {
            let (lamp, path) = recorded.get(photon);
            match passage_of[photon] {
                Some(passage) => {
                    let (parts, replayed) = passage.repair(index, path, &mut repair.old, &mut repair.new, &mut paths);
                    repair.parted += u64::from(parts);
                    repair.replayed += replayed;
                    repair.photons.push(index);
                }
                None => {
                    path.iter().for_each(|entry| paths.push(*entry));
                    paths.finish(lamp);
                }
            }
        }
        repair.chunk = (repair.parted > 0).then(|| Chunk::pack(&paths));
        repair
    }

    /// The photons of a chunk.
    fn members(&self, chunk: usize) -> impl Iterator<Item = PhotonIndex> {
        let (slab, class) = (chunk / CLASSES as usize, chunk as u64 % CLASSES);
        let start = if slab == 0 { 0 } else { self.ends[slab - 1] };
        in_class(start..self.ends[slab], class, self.rules.sequence.copies())
    }
}
