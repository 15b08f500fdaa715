//! Repair in steps of a few chunks, which threads share.

use super::{
    LedgerSolution,
    chunk::{Chunk, Entry, Loose, PHOTONS},
    held::{Held, Past},
    replay::{Clerk, Drafts, Passage, Recorder},
    scan::Marks,
};
use crate::{
    pool::PhotonIndex,
    record::Outcome,
    shooting::{CLASSES, Work, in_class},
    wave::follow_apart,
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

/// Chunks that were not scanned yet in one step, at most.
const SWEEP: u32 = 64;

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
    drafts: Drafts,
}

impl LedgerSolution {
    /// Repairs the next chunks that hold marked photons: those that [`look`](Self::look) put first, then all in a fixed pseudo-random
    /// order that goes round. A chunk that was not scanned since the last edit is scanned first: without any scan before, this goes through
    /// the whole pool once. `None` if nothing is outstanding.
    pub fn repair_next(&mut self) -> Option<Mended> {
        let next = self.next_chunks();
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
                outcome.add_to(&mut self.buckets, &mut self.tallies);
            }
            if let Some(exchange) = &mut self.exchange {
                exchange.count(&self.numbers, &repair.old, &repair.new, repair.photons.len() as u64);
            }
            mended.work += Work { photons: repair.parted, rays: repair.new.rays };
            mended.replayed += repair.replayed;
            mended.photons.extend(repair.photons);
            for (number, chunk) in repair.chunks {
                let held = &mut self.chunks[number];
                self.bytes -= held.bytes();
                held.chunk = chunk;
                self.bytes += held.bytes();
            }
        }
        for number in &next {
            let held = &mut self.chunks[*number];
            self.outstanding -= u64::from(held.marks());
            held.marked.clear();
        }
        if let Some(exchange) = &mut self.exchange {
            exchange.turn(self.outstanding);
        }
        (!next.is_empty()).then_some(mended)
    }

    /// Chunks with marked photons, all of them scanned.
    fn next_chunks(&mut self) -> Vec<usize> {
        while self.outstanding > 0 {
            let next = self.next_outstanding();
            // Otherwise photons of a chunk would be right in different worlds.
            let old: Vec<usize> = next.iter().copied().filter(|number| self.chunks[*number].right_in != self.newest).collect();
            let found: Vec<Marks> = old.par_iter().map(|number| self.chunks[*number].suspected(&self.pasts)).collect();
            for (number, marks) in old.iter().zip(found) {
                let held = &mut self.chunks[*number];
                held.mark(marks, &self.pasts, self.newest);
                self.unscanned -= 1;
                self.outstanding -= held.photons() - u64::from(held.marks());
            }
            let marked: Vec<usize> = next.into_iter().filter(|number| !self.chunks[*number].marked.is_empty()).collect();
            if !marked.is_empty() {
                return marked;
            }
        }
        Vec::new()
    }

    /// Chunks that are marked or were not scanned, enough for a step.
    fn next_outstanding(&mut self) -> Vec<usize> {
        let (mut next, mut size) = (Vec::new(), 0);
        let newest = self.newest;
        let size_of = |held: &Held| match (held.right_in == newest, held.marked.is_empty()) {
            (true, true) => None,
            (true, false) => Some(held.marks()),
            (false, _) => Some(STEP / SWEEP),
        };
        while size < STEP
            && let Some(number) = self.visible.pop()
        {
            if let Some(more) = size_of(&self.chunks[number as usize]) {
                next.push(number as usize);
                size += more;
            }
        }
        if next.is_empty() {
            let chunks = self.shuffled.len();
            for turn in (self.turn..self.turn + chunks).map(|turn| turn % chunks) {
                let number = self.shuffled[turn] as usize;
                if let Some(more) = size_of(&self.chunks[number]) {
                    next.push(number);
                    size += more;
                    self.turn = turn + 1;
                    if size >= STEP {
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
        let Repair { old, new, parted, replayed, photons, chunks, room: Room { loose, recorded, drafts } } = repair;
        loose.load(&held.chunk);
        drafts.clear(held.chunk.order().len());
        let (mut changed, mut onward) = (Vec::new(), Vec::new());
        for (photon, index) in self.members(number).enumerate() {
            if let Some(passage) = passages.get(usize::from(passage_of[photon])) {
                let lamp = loose.get(photon as u8, recorded);
                let mending = passage.repair(index, lamp, recorded, old, new, &mut drafts.paths[photon]);
                if mending.parts {
                    drafts.lamps[photon] = mending.lamp;
                    changed.push(photon);
                }
                onward.extend(mending.onward.map(|going| (photon as u32, going)));
                *replayed += mending.replayed;
                photons.push(index);
            }
        }
        if !changed.is_empty() {
            let recorder = Recorder { numbers: &self.numbers, grid: &self.grid };
            follow_apart(&self.rules, &self.world, onward, &mut Clerk { recorder, drafts, outcome: new });
            for photon in &changed {
                loose.set(*photon as u8, drafts.lamps[*photon], &drafts.paths[*photon]);
            }
            *parted += changed.len() as u64;
            chunks.push((number, loose.store()));
        }
    }

    /// The photons of a chunk.
    fn members(&self, chunk: usize) -> impl Iterator<Item = PhotonIndex> {
        let (slab, class) = (chunk / CLASSES as usize, chunk as u64 % CLASSES);
        let start = if slab == 0 { 0 } else { self.ends[slab - 1] };
        in_class(start..self.ends[slab], class, self.rules.sequence.copies())
    }
}
