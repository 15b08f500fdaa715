//! The second way to find what became wrong: a ledger of every photon's path.
//!
//! Paths are short (2.5 hits at a reflectance of 0.5), so all are kept: where each hit lies, in six bytes, and on which side
//! of which mesh element (`ledger/chunk.rs`).
//! After an edit a scan of the recorded points marks the photons that may have become wrong and misses none (`ledger/scan.rs`); each of them is
//! replayed from its record, cleared or traced anew from where it changed (`ledger/replay.rs`). Not in the seed, which tells such photons by
//! pilots (Dmitriev et al. 2002, §5.2: [`crate::solution`]); the bits in the end are the same.
//!
//! A chunk of photons knows the world in which its records are right. Several edits before it is scanned cost one scan, and several
//! before it is repaired one re-trace: what is marked keeps the world in which it was last right.

mod chunk;
mod grid;
mod held;
mod numbers;
mod pending;
mod repair;
mod replay;
mod scan;
mod surfaces;
mod swarm;

use crate::{
    bucket::{Buckets, Full},
    hash::shuffle,
    importance::Importance,
    path::{Brought, FirstHits, Rules},
    pool::{PhotonIndex, Pool},
    record::{Outcome, Tally, book},
    shooting::{CLASSES, Shooting, Work, has_room, in_class},
    solution::Solution,
    wave::trace_apart,
    world::World,
};
use chunk::{Chunk, PHOTONS};
use grid::Grid;
use held::{Held, Past, WorldNumber};
use numbers::Numbers;
use pending::Exchange;
pub use pending::Pending;
use rayon::prelude::*;
pub use repair::Mended;
use replay::{Clerk, Drafts, Recorder};
use std::{
    collections::BTreeMap,
    fmt::{Debug, Formatter},
    ops::Range,
    sync::Arc,
};
use surfaces::Surfaces;

/// Why there is no ledger: the stateless way is left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Refused {
    /// Its records would take too much memory.
    #[error("a ledger of {photons} photons takes about {needed} bytes, and {limit} are allowed")]
    Memory {
        /// Photons that there would be.
        photons: u64,
        /// Bytes, estimated from what was shot.
        needed: u64,
        /// Bytes.
        limit: u64,
    },
    /// More mesh elements than numbers.
    #[error("the scene has too many mesh elements for a ledger")]
    Elements,
    /// More light than can be counted.
    #[error(transparent)]
    Full(#[from] Full),
    /// The caller ended the work.
    #[error("stopped while the ledger was begun")]
    Stopped,
}

/// A slab that is being shot: chunks in their order, and what came of them, wave by wave.
#[derive(Clone, Default)]
struct Growing {
    outcomes: Vec<Outcome>,
    chunks: Vec<Held>,
}

/// Photons of a slab.
pub(crate) const SLAB: u64 = CLASSES * PHOTONS as u64;

/// So many chunks in a row are shot side by side. More photons are traced faster.
const SIDE_BY_SIDE: u64 = 4;

/// The photons of a chunk of a slab: those of a class. Chunks that are shot together are of neighbouring ones.
fn in_chunk(slab: Range<u64>, chunk: u64, copies: u32) -> impl Iterator<Item = PhotonIndex> {
    in_class(slab, chunk / SIDE_BY_SIDE + CLASSES / SIDE_BY_SIDE * (chunk % SIDE_BY_SIDE), CLASSES, copies)
}

/// A pool of photons with the light that they brought and a record of how each came. Any prefix of a pool is one: it can grow.
#[derive(Clone)]
pub struct LedgerSolution {
    pool: Pool,
    rules: Arc<Rules>,
    buckets: Buckets,
    tallies: Vec<Tally>,
    world: Arc<World>,
    numbers: Numbers,
    grid: Grid,
    /// The photons of each slab end before these; slab by slab, a chunk for each class ([`in_chunk`]).
    ends: Vec<u64>,
    chunks: Vec<Held>,
    /// What was shot of the next slab so far, each chunk at the world that was the newest then.
    growing: Growing,
    /// Where that slab will end.
    growing_to: u64,
    /// Worlds that records are right in, the newest with an empty difference.
    pasts: BTreeMap<WorldNumber, Past>,
    newest: WorldNumber,
    /// The chunk that is scanned next: the scan goes round, or the last ones would never be reached under edits that keep coming.
    scan_turn: usize,
    /// Chunks that were not scanned since the last edit.
    unscanned: usize,
    /// Photons of these, and marked ones of the others.
    outstanding: u64,
    /// Chunks in a fixed pseudo-random order, and where in it the next repair begins.
    shuffled: Vec<u32>,
    turn: usize,
    /// Chunks to repair before all others, the first one last.
    visible: Vec<u32>,
    /// What repairs brought, if they are watched.
    exchange: Option<Exchange>,
    bytes: u64,
    limit: u64,
}

impl LedgerSolution {
    /// Nothing shot yet, and at most `limit` bytes of records ever. `pool` says how photons are made and grouped; it may grow beyond.
    pub fn begin(pool: Pool, world: Arc<World>, first_hits: FirstHits, limit: u64) -> Result<LedgerSolution, Refused> {
        let mut numbers = Numbers::default();
        numbers.cover(world.configuration()).ok_or(Refused::Elements)?;
        let grid = Grid::new(world.bounds(), world.reach().metres);
        let past = Past::new(&world, Arc::new(Surfaces::new(&world, None)), &world, &numbers, &grid);
        Ok(LedgerSolution {
            pool,
            rules: Arc::new(Rules { sequence: pool.sequence(), first_hits }),
            buckets: Buckets::new(world.configuration()),
            tallies: vec![Tally::default(); world.configuration().lamp_slots()],
            world,
            numbers,
            grid,
            ends: Vec::new(),
            chunks: Vec::new(),
            growing: Growing::default(),
            growing_to: 0,
            pasts: BTreeMap::from([(0, past)]),
            newest: 0,
            scan_turn: 0,
            unscanned: 0,
            outstanding: 0,
            shuffled: Vec::new(),
            turn: 0,
            visible: Vec::new(),
            exchange: None,
            bytes: 0,
            limit,
        })
    }

    /// Shoots a whole pool and keeps its paths in at most `limit` bytes. `progress` hears of the photons shot so far and of the rays of
    /// the last slab, and may end the work by returning `false`.
    pub fn shoot(
        pool: Pool,
        world: Arc<World>,
        first_hits: FirstHits,
        limit: u64,
        progress: &mut dyn FnMut(u64, u64) -> bool,
    ) -> Result<LedgerSolution, Refused> {
        let mut solution = LedgerSolution::begin(pool, world, first_hits, limit)?;
        while solution.photons() < pool.photons() {
            let work = solution.grow(pool.photons(), CLASSES as usize)?;
            // What is to come is foreseen: nobody waits for a ledger that cannot be whole.
            solution.admits(pool.photons())?;
            if !progress(solution.photons(), work.rays) {
                return Err(Refused::Stopped);
            }
        }
        Ok(solution)
    }

    /// Whether more photons may be shot, and the records of so many in all are likely to fit.
    pub fn admits(&self, photons: u64) -> Result<(), Refused> {
        has_room(&self.buckets, self.photons())?;
        let needed = (self.bytes as f64 * photons as f64 / self.photons().max(1) as f64) as u64;
        if needed > self.limit { Err(Refused::Memory { photons, needed, limit: self.limit }) } else { Ok(()) }
    }

    /// Shoots so many classes more of the next slab of photons, up to `photons` in all, at the newest world, whatever is still wrong.
    /// When a slab is complete its light arrives; what an edit made wrong of it meanwhile is then outstanding. Refused, nothing changes.
    pub fn grow(&mut self, photons: u64, classes: usize) -> Result<Work, Refused> {
        let start = self.photons();
        if self.growing.chunks.is_empty() {
            self.growing_to = (start + SLAB).min(photons);
        }
        let slab = start..self.growing_to;
        if slab.is_empty() || photons <= start {
            return Ok(Work::default());
        }
        self.admits(slab.end)?;
        let (world, lamps) = (&*self.world, self.tallies.len());
        let recorder = Recorder { numbers: &self.numbers, grid: &self.grid };
        let first = self.growing.chunks.len() as u64;
        let newest = self.newest;
        let waves = first / SIDE_BY_SIDE..(first + classes.max(1) as u64).min(CLASSES).div_ceil(SIDE_BY_SIDE);
        let shot: Vec<(Outcome, Vec<Held>)> = waves
            .into_par_iter()
            .map_init(Drafts::default, |drafts, wave| {
                let mut outcome = Outcome::new(lamps, false);
                let chunks = || {
                    (wave * SIDE_BY_SIDE..(wave + 1) * SIDE_BY_SIDE)
                        .map(|chunk| in_chunk(slab.clone(), chunk, self.rules.sequence.copies()))
                };
                drafts.clear(chunks().map(|photons| photons.count()).sum());
                let clerk = &mut Clerk { recorder, drafts, outcome: &mut outcome };
                trace_apart(&self.rules, world, (0..).zip(chunks().flatten()), &[], clerk);
                let mut next = 0;
                let mut held = |photons: usize| {
                    let own = next..next + photons;
                    next = own.end;
                    let chunk = Chunk::new(&drafts.lamps[own.clone()], &drafts.paths[own]);
                    Held { chunk, right_in: newest, marked: Vec::new() }
                };
                let held = chunks().map(|photons| held(photons.count())).collect();
                (outcome, held)
            })
            .collect();
        let photons = shot.iter().flat_map(|(_, held)| held).map(Held::photons).sum();
        let work = Work { photons, rays: shot.iter().map(|(outcome, _)| outcome.rays).sum() };
        for (outcome, held) in shot {
            self.growing.outcomes.push(outcome);
            self.growing.chunks.extend(held);
        }
        if self.growing.chunks.len() as u64 == CLASSES {
            let number = self.chunks.len() as u32;
            let Growing { outcomes, chunks } = std::mem::take(&mut self.growing);
            book(outcomes.iter(), &mut self.buckets, &mut self.tallies)?;
            self.exchange = None;
            for held in chunks {
                if held.right_in != newest {
                    self.unscanned += 1;
                    self.outstanding += held.photons();
                }
                self.bytes += held.bytes();
                self.chunks.push(held);
            }
            let mut next: Vec<u32> = (number..self.chunks.len() as u32).collect();
            shuffle(&mut next);
            self.shuffled.extend(next);
            self.ends.push(slab.end);
        }
        Ok(work)
    }

    /// Photons shot.
    pub fn photons(&self) -> u64 {
        self.ends.last().copied().unwrap_or(0)
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
        self.bytes
    }

    /// Whether the records have grown past what is allowed, as paths became longer.
    pub fn is_too_large(&self) -> bool {
        self.bytes > self.limit
    }

    /// Recorded hits and escapes.
    pub fn entries(&self) -> u64 {
        self.chunks.iter().map(|held| held.chunk.entries() as u64).sum()
    }

    /// From now on photons are brought to this world. Nothing is scanned or traced yet. If it is refused nothing changes.
    pub fn change(&mut self, world: Arc<World>) -> Result<(), Refused> {
        let mut numbers = self.numbers.clone();
        numbers.cover(world.configuration()).ok_or(Refused::Elements)?;
        self.numbers = numbers;
        self.buckets.grow(world.configuration());
        self.tallies.resize(self.tallies.len().max(world.configuration().lamp_slots()), Tally::default());
        self.world = world;
        self.visible.clear();
        let surfaces = Arc::new(Surfaces::new(&self.world, self.pasts.values().last().map(|past| &*past.surfaces)));
        self.forget_unused_pasts();
        for past in self.pasts.values_mut() {
            past.lead_to(&self.world, &self.numbers, &self.grid);
        }
        self.newest += 1;
        let newest = Past::new(&self.world, surfaces, &self.world, &self.numbers, &self.grid);
        self.pasts.insert(self.newest, newest);
        // What is right in a world without any difference is right in the newest, and what was marked there is right again.
        let like_newest: Vec<WorldNumber> =
            self.pasts.iter().filter(|(_, past)| past.since.changed.is_empty()).map(|(number, _)| *number).collect();
        // What is wrong the other way round tells nothing.
        let returns = like_newest.len() > 1 || self.outstanding == 0;
        let told = self.exchange.take().filter(|_| !returns);
        self.exchange = told.and_then(|exchange| exchange.after_edit(&self.world, &self.numbers, &self.buckets));
        (self.unscanned, self.outstanding) = (0, 0);
        for held in &mut self.chunks {
            if like_newest.binary_search(&held.right_in).is_ok() {
                held.is_right_in(self.newest, &self.pasts);
                self.outstanding += u64::from(held.marks());
            } else {
                self.unscanned += 1;
                self.outstanding += held.photons();
            }
        }
        for held in self.growing.chunks.iter_mut().filter(|held| like_newest.binary_search(&held.right_in).is_ok()) {
            held.is_right_in(self.newest, &self.pasts);
        }
        Ok(())
    }

    /// Drops worlds that no records are right in any more.
    fn forget_unused_pasts(&mut self) {
        let mut used: Vec<bool> = vec![false; self.newest as usize + 1];
        for held in self.chunks.iter().chain(&self.growing.chunks) {
            used[held.right_in as usize] = true;
            held.marked.iter().for_each(|(world, _)| used[*world as usize] = true);
        }
        self.pasts.retain(|number, _| used[*number as usize]);
    }

    /// Scans up to `chunks` chunks of 256 photons, going round; whether all are scanned now. Its cost does not depend on what changed, so
    /// it can be cut into slices.
    pub fn scan(&mut self, chunks: usize) -> bool {
        let mut left = chunks.min(self.chunks.len());
        while left > 0 && self.unscanned > 0 {
            let (pasts, newest) = (&self.pasts, self.newest);
            let end = (self.scan_turn + left).min(self.chunks.len());
            let slice = &mut self.chunks[self.scan_turn..end];
            let scan = |held: &mut Held| {
                let is_old = held.right_in != newest;
                held.scan(pasts, newest);
                let marks = u64::from(held.marks());
                if is_old { (1, held.photons() - marks, marks) } else { (0, 0, 0) }
            };
            let sum = |a: (usize, u64, u64), b: (usize, u64, u64)| (a.0 + b.0, a.1 + b.1, a.2 + b.2);
            let (scanned, right, marked) = slice.par_iter_mut().with_min_len(64).map(scan).reduce(Default::default, sum);
            self.unscanned -= scanned;
            self.outstanding -= right;
            if let Some(exchange) = &mut self.exchange {
                exchange.scan(scanned as u64, marked);
            }
            left -= end - self.scan_turn;
            self.scan_turn = end % self.chunks.len();
        }
        self.unscanned == 0
    }

    /// Photons that may be wrong: marked ones, and all of chunks that were not scanned yet.
    pub fn outstanding_photons(&self) -> u64 {
        self.outstanding
    }

    /// Whether the light is that of the newest world.
    pub fn is_exact(&self) -> bool {
        self.outstanding == 0
    }

    /// What matters is repaired first, until the next edit: chunks whose marked photons have left more on important element sides, on
    /// average over them, before others, so that the visible error falls most for the work. (More of it in sum first, or more hits in
    /// the camera's frustum, is worse than no order: see `docs/perception.md`.) Of chunks that were not scanned yet nothing is known. While something moves the pseudo-random order looks better:
    /// see [`crate::solver::Order::Adaptive`].
    pub fn look(&mut self, importance: &Importance) {
        self.exchange.iter_mut().for_each(Exchange::choose);
        // Of a lamp that the rasteriser draws the first hits bring nothing.
        let counts: Vec<bool> =
            (0..self.tallies.len()).map(|lamp| Brought::from_lamp(&self.rules, &self.world, lamp as u16).counts).collect();
        let seen: Vec<u64> = self.chunks.par_iter().map(|held| held.importance(importance, &self.numbers, &counts)).collect();
        self.visible = self.shuffled.iter().copied().filter(|number| seen[*number as usize] > 0).collect();
        self.visible.sort_by_key(|number| seen[*number as usize]);
    }

    /// The light without the ledger, to be repaired the stateless way. `None` if it is not exact, or fewer photons than the groups need.
    pub fn to_solution(&self) -> Option<Solution> {
        if self.is_exact() { Solution::of(self.pool.grown(self.photons()), self.to_shooting()?) } else { None }
    }

    /// The light without the ledger, to go on shooting. `None` if it is not exact.
    pub fn to_shooting(&self) -> Option<Shooting> {
        let work = Work { photons: self.photons(), rays: 0 };
        let shot = || Shooting::of(self.rules.clone(), self.world.clone(), self.buckets.clone(), self.tallies.clone(), work);
        self.is_exact().then(shot)
    }
}

impl Debug for LedgerSolution {
    fn fmt(&self, f: &mut Formatter) -> std::fmt::Result {
        f.debug_struct("LedgerSolution").field("pool", &self.pool).field("bytes", &self.bytes()).finish_non_exhaustive()
    }
}
