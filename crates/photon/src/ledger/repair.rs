//! Repair in steps of a few chunks, which threads share.

use super::{
    LedgerSolution,
    chunk::{Chunk, Entry, Loose, PHOTONS},
    gather,
    held::Past,
    replay::{Passage, Recorder},
};
use crate::{
    path::Outcome,
    pool::PhotonIndex,
    solution::{CLASSES, Shooting, Work, in_class},
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

/// Marked photons from which on a step takes no more chunks. More: more for threads to share; fewer: a shorter step.
const STEP: u32 = 1024;

/// What repairing some chunks brings.
struct Repair {
    old: Outcome,
    new: Outcome,
    parted: u64,
    replayed: u64,
    photons: Vec<PhotonIndex>,
    /// New records of chunks in which a path changed.
    chunks: Vec<(usize, Chunk)>,
    room: Room,
}

/// Room that is used again and again.
#[derive(Default)]
struct Room {
    loose: Loose,
    recorded: Vec<Entry>,
    path: Vec<Entry>,
}

impl LedgerSolution {
    /// Repairs the marked photons of the next chunks: those that [`look`](Self::look) put first, then all in a fixed pseudo-random order
    /// that goes round. `None` if none is marked; then the light is exact if everything is scanned.
    pub fn repair_next(&mut self) -> Option<Mended> {
        let next = self.next_chunks();
        for number in &next {
            // Otherwise its photons would be right in different worlds.
            self.chunks[*number].scan(&self.pasts, self.newest);
        }
        let lamps = self.tallies.len();
        let nothing = || Repair {
            old: Outcome::new(lamps, true),
            new: Outcome::new(lamps, false),
            parted: 0,
            replayed: 0,
            photons: Vec::new(),
            chunks: Vec::new(),
            room: Room::default(),
        };
        let add = |mut repair: Repair, number: &usize| {
            self.repair_chunk(*number, &mut repair);
            repair
        };
        let repairs: Vec<Repair> = next.par_iter().fold(nothing, add).collect();
        let mut mended = Mended::default();
        for repair in repairs {
            for outcome in [&repair.old, &repair.new] {
                gather(&mut self.buckets, &mut self.tallies, outcome);
            }
            mended.work += Work { photons: repair.parted, rays: repair.new.rays };
            mended.replayed += repair.replayed;
            mended.photons.extend(repair.photons);
            for (number, chunk) in repair.chunks {
                self.chunks[number].chunk = chunk;
            }
        }
        for number in &next {
            self.chunks[*number].marked.clear();
        }
        (!next.is_empty()).then_some(mended)
    }

    fn next_chunks(&mut self) -> Vec<usize> {
        let (mut next, mut marks) = (Vec::new(), 0);
        while marks < STEP
            && let Some(number) = self.visible.pop()
        {
            let number = number as usize;
            if !self.chunks[number].marked.is_empty() {
                marks += self.chunks[number].marks();
                next.push(number);
            }
        }
        if next.is_empty() {
            let chunks = self.shuffled.len();
            for turn in (self.turn..self.turn + chunks).map(|turn| turn % chunks) {
                let number = self.shuffled[turn] as usize;
                if !self.chunks[number].marked.is_empty() {
                    marks += self.chunks[number].marks();
                    next.push(number);
                    self.turn = turn + 1;
                    if marks >= STEP {
                        break;
                    }
                }
            }
        }
        next
    }

    fn repair_chunk(&self, number: usize, repair: &mut Repair) {
        let held = &self.chunks[number];
        let mut passages = Vec::new();
        let mut passage_of = [u8::MAX; PHOTONS];
        for (past, marks) in &held.marked {
            for rank in marks.ranks() {
                passage_of[usize::from(held.chunk.order()[rank])] = passages.len() as u8;
            }
            let Past { world, surfaces, since } = &self.pasts[past];
            passages.push(Passage {
                rules: &self.rules,
                before: world,
                surfaces,
                after: &self.world,
                changed: &since.changed,
                moved_out: &since.moved_out,
                moved_in: &since.moved_in,
                recorder: Recorder { numbers: &self.numbers, grid: &self.grid },
            });
        }
        let Repair { old, new, parted, replayed, photons, chunks, room: Room { loose, recorded, path } } = repair;
        let parted_before = *parted;
        loose.load(&held.chunk);
        for (photon, index) in self.members(number).enumerate() {
            if let Some(passage) = passages.get(usize::from(passage_of[photon])) {
                let lamp = loose.get(photon as u8, recorded);
                let mending = passage.repair(index, lamp, recorded, old, new, path);
                if mending.parts {
                    loose.set(photon as u8, mending.lamp, path);
                    *parted += 1;
                }
                *replayed += mending.replayed;
                photons.push(index);
            }
        }
        if *parted > parted_before {
            chunks.push((number, loose.store()));
        }
    }

    /// The photons of a chunk.
    fn members(&self, chunk: usize) -> impl Iterator<Item = PhotonIndex> {
        let (slab, class) = (chunk as u64 / CLASSES, chunk as u64 % CLASSES);
        let start = slab * Shooting::SLAB;
        in_class(start..(start + Shooting::SLAB).min(self.pool.photons()), class, self.rules.sequence.copies())
    }
}
