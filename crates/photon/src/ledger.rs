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
mod repair;
mod replay;
mod scan;
mod surfaces;

use crate::{
    bucket::Buckets,
    hash::shuffle,
    path::{FirstHits, Outcome, Rules, Tally},
    pool::Pool,
    solution::{CLASSES, Shooting, Solution, Work, in_class},
    visible::Frustum,
    world::World,
};
use chunk::{Chunk, Loose};
use grid::Grid;
use held::{Held, Past, Since, WorldNumber};
use numbers::Numbers;
use rayon::prelude::*;
pub use repair::Mended;
use replay::Recorder;
use std::{
    collections::BTreeMap,
    fmt::{Debug, Formatter},
    sync::Arc,
};
use surfaces::Surfaces;

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
    /// More mesh elements than numbers.
    #[error("the scene has too many mesh elements for a ledger")]
    Elements,
    /// The caller ended the work.
    #[error("stopped while the ledger was begun")]
    Stopped,
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
        numbers.cover(world.configuration()).ok_or(Refused::Elements)?;
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
                .map_init(<(Loose, Vec<_>)>::default, |(loose, path), class| {
                    let mut outcome = Outcome::new(lamps, false);
                    loose.clear(in_class(slab.clone(), class, rules.sequence.copies()).count());
                    for (photon, index) in in_class(slab.clone(), class, rules.sequence.copies()).enumerate() {
                        let lamp = recorder.trace(&rules, &world, index, &mut outcome, path);
                        loose.set(photon as u8, lamp, path);
                    }
                    (outcome, loose.store())
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
        let past = Past { world: world.clone(), surfaces: Arc::new(Surfaces::new(&world, None)), since };
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
        numbers.cover(world.configuration()).ok_or(Refused::Elements)?;
        let needed = self.bytes();
        if needed > self.limit {
            return Err(Refused::Memory { needed, limit: self.limit });
        }
        self.numbers = numbers;
        self.buckets.grow(world.configuration());
        self.tallies.resize(self.tallies.len().max(world.configuration().lamp_slots()), Tally::default());
        self.world = world;
        self.visible.clear();
        let surfaces = Arc::new(Surfaces::new(&self.world, self.pasts.values().last().map(|past| &*past.surfaces)));
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
        self.pasts.insert(self.newest, Past { world: self.world.clone(), surfaces, since });
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

impl Debug for LedgerSolution {
    fn fmt(&self, f: &mut Formatter) -> std::fmt::Result {
        f.debug_struct("LedgerSolution").field("pool", &self.pool).field("bytes", &self.bytes()).finish_non_exhaustive()
    }
}

fn gather(buckets: &mut Buckets, tallies: &mut [Tally], outcome: &Outcome) {
    buckets.add(&outcome.deposits);
    tallies.iter_mut().zip(&outcome.tallies).for_each(|(sum, tally)| sum.add(tally));
}
