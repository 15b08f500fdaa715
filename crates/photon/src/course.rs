//! The way to exact light step by step, after an edit or from nothing, in one order or another: between two steps the light can be
//! looked at.
//!
//! What a step does depends on state alone, so that the light after so many rays is the same at any thread count.

use crate::{
    bucket::Buckets,
    hash::shuffle,
    importance::{Gaze, Importance},
    ledger::{LedgerSolution, Pending, Refused},
    path::Rules,
    pool::{PhotonIndex, Pool},
    shooting::{CLASSES, Shooting, Work},
    solution::Solution,
    world::World,
};
use std::{sync::Arc, time::Instant};

/// A way to exact light.
pub struct Course {
    way: Way,
    done: u64,
    total: u64,
}

enum Way {
    /// Repair of what a ledger finds to be wrong.
    Ledger(Box<LedgerSolution>),
    /// Repair group by group, Algorithm 1 of the seed.
    Groups(Box<Solution>),
    /// Repair of given photons in a given order, so many in a step.
    Photons { solution: Box<Solution>, photons: Vec<PhotonIndex>, block: usize },
    /// Shooting from nothing.
    Shooting { pool: Pool, shooting: Box<Shooting> },
    /// The same while every path is recorded.
    Recording { pool: Pool, solution: Box<LedgerSolution> },
}

/// A step.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Step {
    /// What it cost.
    pub work: Work,
    /// Recorded hits replayed by meeting one triangle each, beside the rays.
    pub replayed: u64,
    /// Photons that are right now.
    pub photons: Vec<PhotonIndex>,
}

/// What a ledger's scan found after an edit; nothing for other orders.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Scan {
    /// Seconds that it took, all photons.
    pub seconds: f64,
    /// Photons that it marked.
    pub marked: u64,
}

/// Photons of a step of the random order.
const BLOCK: usize = 2048;

/// Photons of the first slabs that are shot from nothing.
const FIRST_SLAB: u64 = 16 * CLASSES;

impl Course {
    /// Repair with a ledger of drained light.
    pub fn ledger(drained: &LedgerSolution) -> Course {
        Course::of(Way::Ledger(Box::new(drained.clone())), 0)
    }

    /// Repair by Algorithm 1 of the seed.
    pub fn stateless(drained: &Solution) -> Course {
        Course::of(Way::Groups(Box::new(drained.clone())), 0)
    }

    /// Repair of all photons in random order.
    pub fn random(drained: &Solution) -> Course {
        let mut photons: Vec<PhotonIndex> = (0..drained.pool().photons()).map(PhotonIndex).collect();
        shuffle(&mut photons);
        Course::photons(drained, photons, BLOCK)
    }

    /// Repair of these photons in this order, all relevant ones among them.
    pub fn oracle(drained: &Solution, photons: Vec<PhotonIndex>) -> Course {
        Course::photons(drained, photons, BLOCK / 8)
    }

    /// A new solution from nothing.
    pub fn restart(pool: Pool, rules: Arc<Rules>, world: Arc<World>) -> Course {
        Course::of(Way::Shooting { pool, shooting: Box::new(Shooting::new(rules, world)) }, pool.photons())
    }

    /// A new solution from nothing, every path recorded in a ledger that was only begun.
    pub fn recording(pool: Pool, begun: LedgerSolution) -> Course {
        Course::of(Way::Recording { pool, solution: Box::new(begun) }, pool.photons())
    }

    fn photons(drained: &Solution, photons: Vec<PhotonIndex>, block: usize) -> Course {
        let total = photons.len() as u64;
        Course::of(Way::Photons { solution: Box::new(drained.clone()), photons, block }, total)
    }

    fn of(way: Way, total: u64) -> Course {
        Course { way, done: 0, total }
    }

    /// The edit: from now on the steps lead to the light of `world`. To be called once, before the first step, for a repair. Refused
    /// if a ledger has no room for what is new.
    pub fn change(&mut self, world: Arc<World>) -> Result<Scan, Refused> {
        match &mut self.way {
            Way::Ledger(ledger) => {
                ledger.change(world)?;
                let start = Instant::now();
                ledger.scan(usize::MAX);
                self.total = ledger.outstanding_photons();
                return Ok(Scan { seconds: start.elapsed().as_secs_f64(), marked: self.total });
            }
            Way::Groups(solution) => {
                solution.change(world);
                self.total = solution.stale_photons();
            }
            Way::Photons { solution, .. } => solution.change(world),
            Way::Shooting { shooting, .. } => shooting.change(world),
            Way::Recording { solution, .. } => solution.change(world)?,
        }
        Ok(Scan::default())
    }

    /// From now on, until the light is exact, groups that matter to a camera come first; nothing for other orders.
    pub fn look(&mut self, gaze: Gaze) {
        if let Way::Groups(solution) = &mut self.way {
            solution.look(Some(gaze));
        }
    }

    /// The same for a ledger's photons: those that matter on element sides come first.
    pub fn look_at(&mut self, importance: &Importance) {
        if let Way::Ledger(ledger) = &mut self.way {
            ledger.look(importance);
        }
    }

    /// From now on it is noted what repairs bring, where an order can tell by it what is still to come. To be called after the edit.
    pub fn watch(&mut self) {
        if let Way::Ledger(ledger) = &mut self.way {
            ledger.watch();
        }
    }

    /// What is still to come, where an order knows it.
    pub fn pending(&self) -> Option<Pending> {
        match &self.way {
            Way::Ledger(ledger) => ledger.pending(),
            Way::Groups(_) | Way::Photons { .. } | Way::Shooting { .. } | Way::Recording { .. } => None,
        }
    }

    /// The next step; `None` if the light is exact. Refused if there is no room for more light, or for more records in a ledger.
    pub fn step(&mut self) -> Result<Option<Step>, Refused> {
        let step = match &mut self.way {
            Way::Ledger(ledger) => {
                let Some(mended) = ledger.repair_next()? else { return Ok(None) };
                Step { work: mended.work, replayed: mended.replayed, photons: mended.photons }
            }
            Way::Groups(solution) => {
                let Some(repaired) = solution.repair_next()? else { return Ok(None) };
                Step { work: repaired.work, replayed: 0, photons: solution.pool().photons_of(repaired.group).collect() }
            }
            Way::Photons { solution, photons, block } => {
                let next = &photons[self.done as usize..];
                let next = &next[..next.len().min(*block)];
                if next.is_empty() {
                    return Ok(None);
                }
                Step { work: solution.repair_photons(next)?, replayed: 0, photons: next.to_vec() }
            }
            Way::Shooting { pool, shooting } => {
                let Work { photons, rays } = shooting.work;
                let Some(slab) = slab(photons, pool.photons()) else { return Ok(None) };
                shooting.shoot(slab)?;
                let shot = shooting.photons();
                let work = Work { photons: shot - photons, rays: shooting.work.rays - rays };
                Step { work, replayed: 0, photons: (photons..shot).map(PhotonIndex).collect() }
            }
            Way::Recording { pool, solution } => {
                let before = solution.photons();
                let Some(slab) = slab(before, pool.photons()) else { return Ok(None) };
                let work = solution.grow(before + slab, CLASSES as usize)?;
                Step { work, replayed: 0, photons: (before..solution.photons()).map(PhotonIndex).collect() }
            }
        };
        self.done += step.photons.len() as u64;
        Ok(Some(step))
    }

    /// How much of the work is done, 0 to 1.
    pub fn share(&self) -> f64 {
        self.done as f64 / self.total.max(1) as f64
    }

    /// The light so far.
    pub fn light(&self) -> &Buckets {
        match &self.way {
            Way::Ledger(solution) | Way::Recording { solution, .. } => solution.buckets(),
            Way::Groups(solution) | Way::Photons { solution, .. } => solution.buckets(),
            Way::Shooting { shooting, .. } => shooting.buckets(),
        }
    }

    /// What to show of the light so far: what is [expected](Pending::expected) of it where that is known.
    pub fn expected(&self) -> Buckets {
        let light = self.light();
        self.pending().map_or_else(|| light.clone(), |pending| pending.expected(light))
    }

    /// Photons that the light stems from: of the whole pool in a repair, of those shot so far otherwise.
    pub fn photons_shot(&self) -> u64 {
        match &self.way {
            Way::Ledger(solution) | Way::Recording { solution, .. } => solution.photons(),
            Way::Groups(solution) | Way::Photons { solution, .. } => solution.pool().photons(),
            Way::Shooting { shooting, .. } => shooting.photons(),
        }
    }

    /// The exact light, and the ledger if there is one. `None` if there are steps left.
    pub fn finish(self) -> Option<(Solution, Option<LedgerSolution>)> {
        match self.way {
            Way::Ledger(ledger) => Some((ledger.to_solution()?, Some(*ledger))),
            Way::Groups(solution) => (solution.stale_groups() == 0).then_some((*solution, None)),
            Way::Photons { mut solution, photons, .. } => {
                solution.settle_all();
                (self.done == photons.len() as u64).then_some((*solution, None))
            }
            Way::Shooting { pool, shooting } => {
                (shooting.photons() == pool.photons()).then_some(())?;
                Some((Solution::of(pool, *shooting)?, None))
            }
            Way::Recording { pool, solution } => {
                (solution.photons() == pool.photons()).then_some(())?;
                Some((solution.to_solution()?, Some(*solution)))
            }
        }
    }
}

/// Photons of the next slab: first few, then a quarter of what there is, so that the beginning can be looked at as closely as the rest.
/// `None` if the pool is whole.
fn slab(shot: u64, pool: u64) -> Option<u64> {
    (shot < pool).then(|| (shot / 4).clamp(FIRST_SLAB, Shooting::SLAB).min(pool - shot))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slabs_grow_until_the_pool_is_whole() {
        let (mut shot, mut slabs) = (0, Vec::new());
        while let Some(next) = slab(shot, 4_000_000) {
            shot += next;
            slabs.push(next);
        }
        assert_eq!(shot, 4_000_000);
        assert_eq!(slabs[0], 4608);
        assert!(slabs[..slabs.len() - 1].is_sorted() && slabs.contains(&Shooting::SLAB), "{slabs:?}");
        assert_eq!(slab(0, 100), Some(100));
        assert_eq!(slab(100, 100), None);
    }
}
