//! Repair in steps of a few chunks, which threads share.

use super::{
    LedgerSolution,
    chunk::{Chunk, Entry, Loose},
    held::{Held, Past, WorldNumber},
    in_chunk,
    replay::{Clerk, Drafts, Onward, Passage, Recorded, Recorder},
    scan::Marks,
};
use crate::{
    bucket::Full,
    pool::PhotonIndex,
    record::{Outcome, book},
    shooting::{CLASSES, Work},
    wave::{emit_each, trace_apart},
};
use rayon::prelude::*;
use std::{cell::RefCell, ops::Range};

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

/// Marked photons from which on a step takes no more chunks, at least and at most. More: more for threads to share; fewer: a shorter step.
const STEP: [u32; 2] = [1024, 4096];

/// Of what is outstanding a step takes this part, so that small repairs, too, can be followed.
const STEPS: u64 = 8;

/// Chunks that were not scanned yet in one step, at most.
const SWEEP: u32 = 64;

/// Marked photons from which on chunks are repaired together: their new paths are traced side by side ([`crate::wave`]), and those of one
/// chunk are few after a small edit.
/// At least so many, at most so many; between them a share for every thread.
const TOGETHER: [u32; 2] = [256, 2048];

/// What repairing some chunks brings.
struct Repair {
    old: Outcome,
    new: Outcome,
    mended: Mended,
    /// The sum of the edits since the photons were last right.
    edits: u64,
    /// New records of chunks in which a path changed.
    chunks: Vec<(usize, Chunk)>,
}

/// Room that is used again and again.
#[derive(Default)]
struct Room {
    loose: Loose,
    entries: Vec<Entry>,
    drafts: Drafts,
    members: Vec<PhotonIndex>,
}

thread_local! {
    /// Of the repairs on a thread: the paths alone are some hundred lists, and a step is short.
    static ROOM: RefCell<Room> = RefCell::default();
}

/// A marked photon.
struct Marked {
    /// The place of its chunk among those that are repaired together.
    chunk: usize,
    /// Its number in the chunk.
    photon: u8,
    index: PhotonIndex,
    /// The lamp that it is recorded to have left.
    lamp: u16,
    /// From the world of its record.
    passage: usize,
    /// Its recorded path.
    path: Range<usize>,
}

impl LedgerSolution {
    /// Repairs the next chunks that hold marked photons: those that [`look`](Self::look) put first, then all in a fixed pseudo-random
    /// order that goes round. A chunk that was not scanned since the last edit is scanned first: without any scan before, this goes through
    /// the whole pool once. `None` if nothing is outstanding. What is outstanding stays so if the light that it would bring does not fit.
    pub fn repair_next(&mut self) -> Result<Option<Mended>, Full> {
        let next = self.next_chunks();
        let repair = |chunks: &&[usize]| ROOM.with_borrow_mut(|room| self.repair_chunks(chunks, room));
        let repairs: Vec<Repair> = self.parts(&next).par_iter().map(repair).collect();
        book(repairs.iter().flat_map(|repair| [&repair.old, &repair.new]), &mut self.buckets, &mut self.tallies)?;
        let mut mended = Mended::default();
        for repair in repairs {
            if let Some(exchange) = &mut self.exchange {
                exchange.count(&self.numbers, &repair.old, &repair.new, repair.mended.photons.len() as u64, repair.edits);
            }
            mended.work += repair.mended.work;
            mended.replayed += repair.mended.replayed;
            mended.photons.extend(repair.mended.photons);
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
            exchange.turn(self.outstanding, &self.numbers);
        }
        Ok((!next.is_empty()).then_some(mended))
    }

    /// Chunks with marked photons, all of them scanned.
    fn next_chunks(&mut self) -> Vec<usize> {
        while self.outstanding > 0 {
            let next = self.next_outstanding();
            // Otherwise photons of a chunk would be right in different worlds.
            let old: Vec<usize> = next.iter().copied().filter(|number| self.chunks[*number].right_in != self.newest).collect();
            let found: Vec<Marks> = old.par_iter().map(|number| self.chunks[*number].suspected(&self.pasts)).collect();
            for (number, marks) in old.iter().zip(found) {
                if let Some(exchange) = &mut self.exchange {
                    exchange.scan(1, marks.count().into());
                }
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
        let step = (self.outstanding / STEPS).clamp(STEP[0].into(), STEP[1].into()) as u32;
        let newest = self.newest;
        let size_of = |held: &Held| match (held.right_in == newest, held.marked.is_empty()) {
            (true, true) => None,
            (true, false) => Some(held.marks()),
            (false, _) => Some(step / SWEEP),
        };
        while size < step
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
                    if size >= step {
                        break;
                    }
                }
            }
        }
        next
    }

    /// Parts of `chunks` that hold as many marked photons as are repaired [`TOGETHER`] or a little more; the last one what is left.
    fn parts<'c>(&self, chunks: &'c [usize]) -> Vec<&'c [usize]> {
        let (mut parts, mut begin, mut marks) = (Vec::new(), 0, 0);
        let all: u32 = chunks.iter().map(|number| self.chunks[*number].marks()).sum();
        let together = all.div_ceil(rayon::current_num_threads() as u32).clamp(TOGETHER[0], TOGETHER[1]);
        for (n, number) in chunks.iter().enumerate() {
            marks += self.chunks[*number].marks();
            if marks >= together || n + 1 == chunks.len() {
                parts.push(&chunks[begin..=n]);
                (begin, marks) = (n + 1, 0);
            }
        }
        parts
    }

    fn repair_chunks(&self, numbers: &[usize], room: &mut Room) -> Repair {
        let Room { loose, entries, drafts, members } = room;
        let lamps = self.tallies.len();
        let (mut old, mut new, mut mended) = (Outcome::new(lamps, true), Outcome::new(lamps, false), Mended::default());

        // All that is recorded is looked up before anything is replayed: these look-ups do not wait for one another.
        entries.clear();
        let (mut passages, mut triangles, mut marked): (Vec<(WorldNumber, Passage)>, Vec<_>, Vec<Marked>) = Default::default();
        for (chunk, number) in numbers.iter().enumerate() {
            let held = &self.chunks[*number];
            members.clear();
            members.extend(self.members(*number));
            for (past, marks) in &held.marked {
                let passage = passages.iter().position(|(number, _)| number == past).unwrap_or_else(|| {
                    passages.push((*past, self.passage(*past)));
                    passages.len() - 1
                });
                for rank in marks.ranks() {
                    let photon = held.chunk.order()[rank];
                    let begin = entries.len();
                    let lamp = held.chunk.path(rank, entries);
                    triangles.extend(entries[begin..].iter().map(|entry| passages[passage].1.triangle(entry)));
                    let index = members[usize::from(photon)];
                    marked.push(Marked { chunk, photon, index, lamp, passage, path: begin..entries.len() });
                }
            }
        }

        let recorded = |one: &Marked| Recorded { entries: &entries[one.path.clone()], triangles: &triangles[one.path.clone()] };
        let passage = |one: &Marked| &passages[one.passage].1;
        drafts.clear(marked.len());
        let (mut anew, mut known, mut onward) = (Vec::new(), Vec::<u32>::new(), Vec::new());
        let mut parts = vec![true; marked.len()];
        for (draft, one) in (0..).zip(&marked) {
            if passage(one).is_new(one.index, one.lamp) {
                mended.replayed += passage(one).forget(one.index, one.lamp, recorded(one), &mut old);
                anew.push((draft, one.index));
            } else {
                known.push(draft);
            }
        }
        let mut leaving =
            emit_each(&self.rules, &self.world, known.iter().map(|draft| marked[*draft as usize].index)).into_iter();
        for draft in known {
            let (one, path) = (&marked[draft as usize], &mut drafts.paths[draft as usize]);
            drafts.lamps[draft as usize] = one.lamp;
            let (goes, replayed) = passage(one).repair(leaving.next(), recorded(one), &mut old, &mut new, path);
            mended.replayed += replayed;
            match goes {
                Onward::Stays => parts[draft as usize] = false,
                Onward::Ends => {}
                Onward::Anew => anew.push((draft, one.index)),
                Onward::From(photon) => onward.push((draft, photon)),
            }
        }
        mended.photons.extend(marked.iter().map(|one| one.index));
        let recorder = Recorder { numbers: &self.numbers, grid: &self.grid };
        trace_apart(&self.rules, &self.world, anew.into_iter(), &onward, &mut Clerk { recorder, drafts, outcome: &mut new });
        let parted: Vec<usize> = (0..marked.len()).filter(|draft| parts[*draft]).collect();
        mended.work = Work { photons: parted.len() as u64, rays: new.rays };

        let rewrite = |drafts_of_chunk: &[usize]| {
            let number = numbers[marked[drafts_of_chunk[0]].chunk];
            loose.load(&self.chunks[number].chunk);
            for draft in drafts_of_chunk {
                loose.set(marked[*draft].photon, drafts.lamps[*draft], &drafts.paths[*draft]);
            }
            (number, loose.store())
        };
        let chunks = parted.chunk_by(|a, b| marked[*a].chunk == marked[*b].chunk).map(rewrite).collect();
        let edits = marked.iter().map(|one| u64::from(self.newest - passages[one.passage].0)).sum();
        Repair { old, new, mended, edits, chunks }
    }

    /// From a past world to the newest one.
    fn passage(&self, past: WorldNumber) -> Passage<'_> {
        let Past { world, surfaces, since } = &self.pasts[&past];
        Passage {
            rules: &self.rules,
            before: world,
            surfaces,
            after: &self.world,
            changed: &since.changed,
            moved_out: &since.moved_out,
            moved_in: &since.moved_in,
            recorder: Recorder { numbers: &self.numbers, grid: &self.grid },
        }
    }

    /// The photons of a chunk.
    fn members(&self, chunk: usize) -> impl Iterator<Item = PhotonIndex> {
        let slab = chunk / CLASSES as usize;
        let start = if slab == 0 { 0 } else { self.ends[slab - 1] };
        in_chunk(start..self.ends[slab], chunk as u64 % CLASSES, self.rules.sequence.copies())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        body::TreePreset,
        bucket::{Address, Bucket, CAPACITY},
        halton::Scrambling,
        path::FirstHits,
        pool::Pool,
        world::World,
    };
    use glam::DVec3;
    use lightmend_scene::{Configuration, Edit, Scene};
    use std::sync::Arc;

    #[test]
    fn what_does_not_fit_is_refused_whole() {
        let path = format!("{}/../../scenes/cornell/cornell.ron", env!("CARGO_MANIFEST_DIR"));
        let home = Configuration::initial(&Scene::read(path.as_ref()).unwrap().0);
        let world = Arc::new(World::new(&home, TreePreset::Fast));
        let pool = Pool::new(20_000, 288, 16, Scrambling::Seed(1)).unwrap();
        let mut ledger = LedgerSolution::shoot(pool, world.clone(), FirstHits::Always, 1 << 30, &mut |_, _| true).unwrap();
        let at = Address { object: 0, cell: 0, side: 0, lamp: 0 };
        ledger.buckets.set(at, Bucket { energy: [0; 3], hits: 0 });
        let hits = CAPACITY - ledger.buckets.deposits();
        ledger.buckets.set(at, Bucket { energy: [0; 3], hits });
        // Brighter paint takes no hit away.
        let bright = home.apply(&Edit::Reflect { material: "white".into(), to: DVec3::ONE }).unwrap();
        ledger.change(Arc::new(world.moved_to(&bright))).unwrap();
        ledger.scan(usize::MAX);
        let (buckets, outstanding) = (ledger.buckets.clone(), ledger.outstanding_photons());
        assert_eq!(ledger.repair_next(), Err(Full));
        assert!(outstanding > 0 && ledger.outstanding_photons() == outstanding && ledger.buckets == buckets);
    }
}
