//! The light that the solver works on: with a ledger, or the stateless way, which first shoots a pool and then knows its groups.

use crate::{
    bucket::{Buckets, Full},
    ledger::{LedgerSolution, Refused, SLAB},
    path::Rules,
    pool::Pool,
    shooting::{CLASSES, Shooting, Work, has_room},
    solution::Solution,
    world::World,
};
use std::sync::Arc;

/// What there is of it.
pub enum Light {
    /// Any number of photons, each with the record of its path.
    Ledger(Box<LedgerSolution>),
    /// Shot for the first time, perhaps at an earlier world than the wanted one: then it is `stale`.
    Shooting { shooting: Box<Shooting>, stale: bool },
    /// A pool or more, in groups.
    Groups(Box<Solution>),
}

/// What became of shooting more photons.
pub enum Grown {
    By(Work),
    /// The ledger refuses.
    Refused(Refused),
    /// No light has room.
    Full,
}

impl Light {
    /// Dark, without a ledger.
    pub fn shoot(rules: &Arc<Rules>, world: &Arc<World>) -> Light {
        Light::Shooting { shooting: Box::new(Shooting::new(rules.clone(), world.clone())), stale: false }
    }

    /// Photons shot.
    pub fn photons(&self) -> u64 {
        match self {
            Light::Ledger(ledger) => ledger.photons(),
            Light::Shooting { shooting, .. } => shooting.photons(),
            Light::Groups(solution) => solution.pool().photons(),
        }
    }

    /// The light.
    pub fn buckets(&self) -> &Buckets {
        match self {
            Light::Ledger(ledger) => ledger.buckets(),
            Light::Shooting { shooting, .. } => shooting.buckets(),
            Light::Groups(solution) => solution.buckets(),
        }
    }

    /// Of the photons shot, those that may be wrong.
    pub fn outstanding(&self) -> u64 {
        match self {
            Light::Ledger(ledger) => ledger.outstanding_photons(),
            Light::Shooting { shooting, stale } => u64::from(*stale) * shooting.photons(),
            Light::Groups(solution) => solution.stale_photons(),
        }
    }

    /// Groups that hold light of an earlier world, of a pool that is kept without a ledger.
    pub fn stale_groups(&self, pool: Pool) -> usize {
        match self {
            Light::Ledger(_) => 0,
            Light::Shooting { stale, .. } => usize::from(*stale) * pool.groups() as usize,
            Light::Groups(solution) => solution.stale_groups(),
        }
    }

    /// Whether there is anything to repair before more is shot.
    pub fn is_wrong(&self) -> bool {
        match self {
            Light::Ledger(ledger) => !ledger.is_exact(),
            // It goes on where it began: it cannot be repaired before it is whole.
            Light::Shooting { .. } => false,
            Light::Groups(solution) => solution.stale_groups() > 0,
        }
    }

    /// Whether another slab of photons fits.
    pub fn has_room(&self) -> bool {
        match self {
            Light::Ledger(ledger) => ledger.admits(ledger.photons() + SLAB).is_ok(),
            Light::Shooting { shooting, .. } => has_room(shooting.buckets(), shooting.photons()).is_ok(),
            Light::Groups(solution) => !solution.is_full(),
        }
    }

    /// From now on the light of `world` is wanted.
    pub fn change(&mut self, world: &Arc<World>) -> Result<(), Refused> {
        match self {
            Light::Ledger(ledger) => ledger.change(world.clone())?,
            Light::Shooting { shooting, stale } => {
                *stale = !shooting.world().difference(world).is_empty();
                if !*stale {
                    shooting.change(world.clone());
                }
            }
            Light::Groups(solution) => solution.change(world.clone()),
        }
        Ok(())
    }

    /// Shoots some `count` photons more, up to `goal` in all. With a ledger they are light when their slab is complete.
    pub fn shoot_more(&mut self, count: u64, goal: u64) -> Grown {
        match self {
            Light::Ledger(ledger) => {
                let classes = (count * CLASSES).div_ceil(SLAB) as usize;
                match ledger.grow(goal, classes) {
                    Ok(work) => Grown::By(work),
                    Err(refused) => Grown::Refused(refused),
                }
            }
            Light::Shooting { shooting, .. } => {
                let before = shooting.work;
                if let Err(Full) = shooting.shoot(count.min(goal - shooting.photons())) {
                    return Grown::Full;
                }
                let rays = shooting.work.rays - before.rays;
                Grown::By(Work { photons: shooting.photons() - before.photons, rays })
            }
            Light::Groups(solution) => {
                let more = count.min(goal.saturating_sub(solution.pool().photons()));
                match solution.grow(more).unwrap_or_default() {
                    Work { photons: 0, .. } if solution.is_full() => Grown::Full,
                    work => Grown::By(work),
                }
            }
        }
    }

    /// A pool that is whole without a ledger is split into groups.
    pub fn finish(&mut self, pool: Pool, world: &Arc<World>) {
        if let Light::Shooting { shooting, stale } = self
            && shooting.photons() >= pool.photons()
            && let Some(mut solution) = Solution::of(pool.grown(shooting.photons()), Shooting::clone(shooting))
        {
            if *stale {
                solution.change(world.clone());
            }
            *self = Light::Groups(Box::new(solution));
        }
    }
}
