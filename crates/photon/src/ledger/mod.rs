//! The second way to find what became wrong: a ledger of every photon's path.
//!
//! Paths are short (2.5 hits at a reflectance of 0.5), so all are kept: where each hit lies, in six bytes, and its triangle ([`chunk`]).
//! After an edit a scan of the recorded points marks the photons that may have become wrong and misses none ([`scan`]); each of them is
//! replayed from its record, cleared or traced anew from where it changed ([`replay`]). Not in the seed, which tells such photons by
//! pilots (Dmitriev et al. 2002, §5.2: [`crate::solution`]); the bits in the end are the same.
//!
//! A chunk of photons knows the world in which its records are right. Several edits before it is scanned cost one scan, and several
//! before it is repaired one re-trace: what is marked keeps the world in which it was last right.

mod chunk;
mod grid;
mod numbers;
mod replay;
mod scan;

use crate::{
    bucket::Buckets,
    hash::shuffle,
    path::{FirstHits, Outcome, Rules, Tally},
    pool::{PhotonIndex, Pool},
    solution::{CLASSES, Shooting, Solution, Work, in_class},
    visible::Frustum,
    world::{Crowd, Difference, Surfaces, World},
};
use chunk::{Chunk, Paths};
use grid::Grid;
use numbers::Numbers;
use rayon::prelude::*;
use replay::{Passage, Recorder};
use scan::{Marks, Suspicion};
use std::{collections::BTreeMap, sync::Arc};

/// Why there is no ledger: the stateless way is left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Refused {
    /// Its records would take too much memory.
    #[error("a ledger of this pool takes about {needed} bytes, and {limit} are allowed")]
    Memory {
        /// Bytes, estimated from what was shot.
        needed: u64,
        /// Bytes.
        limit: u64,
    },
    /// More triangles than numbers.
    #[error("the scene has too many triangles for a ledger")]
    Triangles,
    /// The caller ended the work.
    #[error("stopped while the ledger was begun")]
    Stopped,
}

/// The number of a world; later ones are higher.
type WorldNumber = u32;

/// A chunk and what is known of it.
#[derive(Clone)]
struct Held {
    chunk: Chunk,
    /// The world in which the records of all its photons are right but for the marked ones.
    right_in: WorldNumber,
    /// Photons that may have become wrong, with the world in which their records were last right. Each photon once.
    marked: Vec<(WorldNumber, Marks)>,
}

/// A world that records are right in, and what has changed since.
#[derive(Clone)]
struct Past {
    world: Arc<World>,
    surfaces: Arc<Surfaces>,
    since: Arc<Since>,
}

/// From a past world to the newest one.
struct Since {
    changed: Difference,
    moved_out: Vec<usize>,
    moved_in: Crowd,
    suspicion: Suspicion,
}

impl Since {
    fn new(past: &World, world: &World, numbers: &Numbers, grid: &Grid) -> Since {
        let changed = past.difference(world);
        let has_moved = |id: &usize| !past.same_place(world, *id);
        let moved_out: Vec<usize> = changed.objects.iter().copied().filter(has_moved).collect();
        let there: Vec<usize> = moved_out.iter().copied().filter(|id| world.configuration().has_object(*id)).collect();
        let moved_in = world.phantoms(&there);
        let suspicion = Suspicion::new(past, &changed, &moved_in, numbers, grid);
        Since { changed, moved_out, moved_in, suspicion }
    }
}

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

/// A pool of photons with the light that they brought and a record of how each came.
#[derive(Clone)]
pub struct LedgerSolution {
    pool: Pool,
    rules: Arc<Rules>,
    buckets: Buckets,
    tallies: Vec<Tally>,
    world: Arc<World>,
    numbers: Numbers,
    grid: Grid,
    chunks: Vec<Held>,
    /// Worlds that records are right in, the newest with an empty difference.
    pasts: BTreeMap<WorldNumber, Past>,
    newest: WorldNumber,
    /// Chunks before this one were scanned since the last edit.
    scanned: usize,
    /// Chunks in a fixed pseudo-random order, and where in it the next repair begins.
    shuffled: Arc<[u32]>,
    turn: usize,
    /// Chunks to repair before all others, the first one last.
    visible: Vec<u32>,
    limit: u64,
}

/// Chunks repaired in one step. More: more for threads to share; fewer: a shorter step.
const STEP: usize = 16;

impl LedgerSolution {
    /// Shoots a whole pool and keeps its paths in at most `limit` bytes. `progress` hears of the photons shot so far and of the rays of
    /// the last slab, and may end the work by returning `false`.
    pub fn shoot(
        pool: Pool,
        world: Arc<World>,
        first_hits: FirstHits,
        limit: u64,
        progress: &mut dyn FnMut(u64, u64) -> bool,
    ) -> Result<LedgerSolution, Refused> {
        let rules = Arc::new(Rules { sequence: pool.sequence(), first_hits });
        let mut numbers = Numbers::default();
        numbers.cover(world.configuration()).ok_or(Refused::Triangles)?;
        let grid = Grid::new(world.bounds(), world.reach().metres);
        let lamps = world.configuration().lamp_slots();
        let mut buckets = Buckets::new(world.configuration());
        let mut tallies = vec![Tally::default(); lamps];
        let recorder = Recorder { numbers: &numbers, grid: &grid };
        let (mut chunks, mut bytes) = (Vec::new(), 0);
        for start in (0..pool.photons()).step_by(Shooting::SLAB as usize) {
            let slab = start..(start + Shooting::SLAB).min(pool.photons());
            let shot: Vec<(Outcome, Chunk)> = (0..CLASSES)
                .into_par_iter()
                .map(|class| {
                    let (mut outcome, mut paths) = (Outcome::new(lamps, false), Paths::default());
                    for index in in_class(slab.clone(), class, rules.sequence.copies()) {
                        recorder.trace(&rules, &world, index, &mut outcome, &mut paths);
                    }
                    (outcome, Chunk::pack(&paths))
                })
                .collect();
            let mut rays = 0;
            for (outcome, chunk) in shot {
                gather(&mut buckets, &mut tallies, &outcome);
                rays += outcome.rays;
                bytes += chunk.bytes() as u64;
                chunks.push(Held { chunk, right_in: 0, marked: Vec::new() });
            }
            let needed = (bytes as f64 * pool.photons() as f64 / slab.end as f64) as u64;
            if needed > limit {
                return Err(Refused::Memory { needed, limit });
            }
            if !progress(slab.end, rays) {
                return Err(Refused::Stopped);
            }
        }
        let mut shuffled: Vec<u32> = (0..chunks.len() as u32).collect();
        shuffle(&mut shuffled);
        let since = Arc::new(Since::new(&world, &world, &numbers, &grid));
        let past = Past { world: world.clone(), surfaces: Arc::new(world.surfaces()), since };
        let pasts = BTreeMap::from([(0, past)]);
        let scanned = chunks.len();
        Ok(LedgerSolution {
            pool,
            rules,
            buckets,
            tallies,
            world,
            numbers,
            grid,
            chunks,
            pasts,
            newest: 0,
            scanned,
            shuffled: shuffled.into(),
            turn: 0,
            visible: Vec::new(),
            limit,
        })
    }

    /// The pool.
    pub fn pool(&self) -> &Pool {
        &self.pool
    }

    /// The light.
    pub fn buckets(&self) -> &Buckets {
        &self.buckets
    }

    /// The world that photons are brought to.
    pub fn world(&self) -> &Arc<World> {
        &self.world
    }

    /// Memory of the records, bytes.
    pub fn bytes(&self) -> u64 {
        self.chunks.iter().map(|held| held.chunk.bytes() as u64 + size_of::<Held>() as u64 - size_of::<Chunk>() as u64).sum()
    }

    /// Recorded hits and escapes.
    pub fn entries(&self) -> u64 {
        self.chunks.iter().map(|held| held.chunk.entries() as u64).sum()
    }

    /// From now on photons are brought to this world. Nothing is scanned or traced yet. If it is refused nothing changes.
    pub fn change(&mut self, world: Arc<World>) -> Result<(), Refused> {
        let mut numbers = self.numbers.clone();
        numbers.cover(world.configuration()).ok_or(Refused::Triangles)?;
        let needed = self.bytes();
        if needed > self.limit {
            return Err(Refused::Memory { needed, limit: self.limit });
        }
        self.numbers = numbers;
        self.buckets.grow(world.configuration());
        self.tallies.resize(self.tallies.len().max(world.configuration().lamp_slots()), Tally::default());
        self.world = world;
        self.visible.clear();
        // What is right in a world without any difference is right in the newest, and what was marked there is right again.
        let used = |number: &WorldNumber, chunks: &[Held]| {
            chunks.iter().any(|held| held.right_in == *number || held.marked.iter().any(|(world, _)| world == number))
        };
        self.pasts.retain(|number, _| used(number, &self.chunks));
        for past in self.pasts.values_mut() {
            past.since = Arc::new(Since::new(&past.world, &self.world, &self.numbers, &self.grid));
        }
        self.newest += 1;
        for held in &mut self.chunks {
            if self.pasts[&held.right_in].since.changed.is_empty() {
                held.is_right_in(self.newest, &self.pasts);
            }
        }
        let since = Arc::new(Since::new(&self.world, &self.world, &self.numbers, &self.grid));
        self.pasts.insert(self.newest, Past { world: self.world.clone(), surfaces: Arc::new(self.world.surfaces()), since });
        self.scanned = 0;
        Ok(())
    }

    /// Scans up to `chunks` chunks of 256 photons; whether all are scanned now. Its cost does not depend on what changed, so it can be
    /// cut into slices.
    pub fn scan(&mut self, chunks: usize) -> bool {
        let end = (self.scanned + chunks).min(self.chunks.len());
        let (pasts, newest) = (&self.pasts, self.newest);
        self.chunks[self.scanned..end].par_iter_mut().with_min_len(64).for_each(|held| held.scan(pasts, newest));
        self.scanned = end;
        self.scanned == self.chunks.len()
    }

    /// Photons that are marked; all that may be wrong once everything is scanned.
    pub fn marked_photons(&self) -> u64 {
        self.chunks.iter().map(|held| u64::from(held.marks())).sum()
    }

    /// Whether the light is that of the newest world.
    pub fn is_exact(&self) -> bool {
        self.scanned == self.chunks.len() && self.chunks.iter().all(|held| held.marked.is_empty())
    }

    /// Repairs the marked photons of the next chunks: those that [`look`](Self::look) put first, then all in a fixed pseudo-random order
    /// that goes round. `None` if none is marked; then the light is exact if everything is scanned.
    pub fn repair_next(&mut self) -> Option<Mended> {
        let next = self.next_chunks();
        for number in &next {
            // Otherwise its photons would be right in different worlds.
            self.chunks[*number].scan(&self.pasts, self.newest);
        }
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
            held.marked.clear();
            if let Some(chunk) = repair.chunk {
                held.chunk = chunk;
            }
        }
        (!next.is_empty()).then_some(mended)
    }

    fn next_chunks(&mut self) -> Vec<usize> {
        let mut next = Vec::new();
        let is_marked = |number: u32| !self.chunks[number as usize].marked.is_empty();
        while next.len() < STEP
            && let Some(number) = self.visible.pop()
        {
            next.extend(is_marked(number).then_some(number as usize));
        }
        if next.is_empty() {
            let chunks = self.shuffled.len();
            let turns = (self.turn..self.turn + chunks).map(|turn| turn % chunks);
            for turn in turns.filter(|turn| is_marked(self.shuffled[*turn])).take(STEP) {
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
        let mut passage_of = [None; chunk::PHOTONS];
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
        let (slab, class) = (chunk as u64 / CLASSES, chunk as u64 % CLASSES);
        let start = slab * Shooting::SLAB;
        in_class(start..(start + Shooting::SLAB).min(self.pool.photons()), class, self.rules.sequence.copies())
    }

    /// What this camera may see is repaired first, until the next edit: chunks with more recorded hits of marked photons in its frustum
    /// before others. While something moves the pseudo-random order looks better: see [`crate::solver::Order::Adaptive`].
    pub fn look(&mut self, frustum: &Frustum) {
        let seen: Vec<u32> = self.chunks.par_iter().map(|held| held.seen(frustum, &self.grid)).collect();
        self.visible = self.shuffled.iter().copied().filter(|number| seen[*number as usize] > 0).collect();
        self.visible.sort_by_key(|number| seen[*number as usize]);
    }

    /// The light without the ledger, to be repaired the stateless way. `None` if it is not exact.
    pub fn to_solution(&self) -> Option<Solution> {
        let work = Work { photons: self.pool.photons(), rays: 0 };
        let shot = || Shooting::of(self.rules.clone(), self.world.clone(), self.buckets.clone(), self.tallies.clone(), work);
        if self.is_exact() { Solution::of(self.pool, shot()) } else { None }
    }
}

impl Held {
    /// Marks what may have become wrong since this chunk was last right.
    fn scan(&mut self, pasts: &BTreeMap<WorldNumber, Past>, newest: WorldNumber) {
        if self.right_in == newest {
            return;
        }
        let mut marks = pasts[&self.right_in].since.suspicion.marks(&self.chunk);
        for (_, already) in &self.marked {
            marks = marks.without(already);
        }
        if marks.count() > 0 {
            self.marked.push((self.right_in, marks));
        }
        self.is_right_in(newest, pasts);
    }

    /// All but the marked photons are right in this world. Photons marked as right in a world that is like it are so too; not
    /// before, as a chunk's unmarked photons must all be right in one world.
    fn is_right_in(&mut self, newest: WorldNumber, pasts: &BTreeMap<WorldNumber, Past>) {
        self.right_in = newest;
        self.marked.retain(|(number, _)| !pasts[number].since.changed.is_empty());
    }

    fn marks(&self) -> u32 {
        self.marked.iter().map(|(_, marks)| marks.count()).sum()
    }

    /// Recorded points of marked photons that lie in the frustum.
    fn seen(&self, frustum: &Frustum, grid: &Grid) -> u32 {
        if self.marked.is_empty() {
            return 0;
        }
        let is_marked = |rank: usize| self.marked.iter().any(|(_, marks)| marks.has(rank));
        let of_level = |level: chunk::Level| {
            let inside =
                |rank: usize| grid.point(level.places.map(|axis| axis[rank])).is_some_and(|point| frustum.contains(point));
            (0..level.triangles.len()).filter(|rank| is_marked(*rank) && inside(*rank)).count() as u32
        };
        self.chunk.levels().map(of_level).sum()
    }
}

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

fn gather(buckets: &mut Buckets, tallies: &mut [Tally], outcome: &Outcome) {
    buckets.add(&outcome.deposits);
    tallies.iter_mut().zip(&outcome.tallies).for_each(|(sum, tally)| sum.add(tally));
}
