//! Recovery after an edit, order against order: how much work until which share of the relevant photons is repaired.
//!
//! A photon is relevant if a hit (triangle, side, exact position), a deposit or the end of its path differs between the drained
//! configuration and the edited one; found by brute force. The seed draws such curves in its Figures 5 and 7.

use crate::{
    course::Course,
    ledger::LedgerSolution,
    path::{Rules, trace},
    pool::{PhotonIndex, Pool},
    record::Trail,
    shooting::Work,
    solution::Solution,
    world::World,
};
use rayon::prelude::*;
use std::{sync::Arc, time::Instant};

/// The order in which photons are repaired.
#[derive(Debug, Clone, Copy)]
pub enum Order<'a> {
    /// What a ledger of the drained light finds to be wrong.
    Ledger(&'a LedgerSolution),
    /// Algorithm 1 of the seed.
    Stateless,
    /// All photons in random order.
    Random,
    /// The relevant photons and no others: the limit of re-shooting.
    Oracle,
    /// A new solution from nothing.
    Restart,
}

/// Which photons of a pool are relevant for an edit.
pub struct Relevant {
    flags: Vec<bool>,
    count: u64,
}

impl Relevant {
    /// Traces every photon in both worlds.
    pub fn find(pool: &Pool, rules: &Rules, before: &World, after: &World) -> Relevant {
        let mut flags = vec![false; pool.photons() as usize];
        const BLOCK: usize = 4096;
        flags.par_chunks_mut(BLOCK).enumerate().for_each(|(block, flags)| {
            let (mut old, mut new) = (Trail::default(), Trail::default());
            for (k, flag) in flags.iter_mut().enumerate() {
                let index = PhotonIndex((block * BLOCK + k) as u64);
                old.clear();
                new.clear();
                trace(rules, before, index, &mut old);
                trace(rules, after, index, &mut new);
                *flag = old.differs(&new);
            }
        });
        let count = flags.iter().filter(|f| **f).count() as u64;
        Relevant { flags, count }
    }

    /// How many.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Which.
    pub fn photons(&self) -> impl Iterator<Item = PhotonIndex> + '_ {
        self.flags.iter().enumerate().filter(|(_, flag)| **flag).map(|(index, _)| PhotonIndex(index as u64))
    }

    fn among(&self, photons: impl Iterator<Item = PhotonIndex>) -> u64 {
        photons.filter(|i| self.flags[i.0 as usize]).count() as u64
    }
}

/// A moment of a recovery.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Moment {
    /// Work since the edit.
    pub work: Work,
    /// Seconds since the edit.
    pub seconds: f64,
    /// Recorded hits replayed by meeting one triangle each, beside the rays.
    pub replayed: u64,
    /// Relevant photons repaired.
    pub repaired: u64,
}

/// What a recovery with a ledger found out beside.
pub struct Kept {
    /// The ledger of the drained light.
    pub ledger: LedgerSolution,
    /// Seconds that its scan took, all photons.
    pub scan_seconds: f64,
    /// Photons that it marked.
    pub marked: u64,
}

/// A recovery from the edit to the drained state.
pub struct Recovery {
    /// Its moments, the edit first.
    pub moments: Vec<Moment>,
    /// The drained solution.
    pub solution: Solution,
    /// With [`Order::Ledger`].
    pub kept: Option<Kept>,
}

/// The first moment at which `share` (0 to 1) of the relevant photons was repaired; the last if none was relevant.
pub fn reached(moments: &[Moment], share: f64, relevant: u64) -> Moment {
    let wanted = (share * relevant as f64).ceil() as u64;
    moments[moments.partition_point(|m| m.repaired < wanted).min(moments.len() - 1)]
}

/// Repairs a drained solution after an edit to `after`, in the given order. `progress` hears of the share that is done and may end it by
/// returning `false`: `None`. `None` also if the ledger refuses the edit.
pub fn recover(
    drained: &Solution,
    after: &Arc<World>,
    order: Order<'_>,
    relevant: &Relevant,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Option<Recovery> {
    let mut course = match order {
        Order::Ledger(ledger) => Course::ledger(ledger),
        Order::Stateless => Course::stateless(drained),
        Order::Random => Course::random(drained),
        Order::Oracle => Course::oracle(drained, relevant.photons().collect()),
        Order::Restart => Course::restart(*drained.pool(), drained.rules().clone(), after.clone()),
    };
    let mut moment = Moment::default();
    let mut moments = vec![moment];
    let start = Instant::now();
    let scan = course.change(after.clone()).ok()?;
    while let Some(step) = course.step().ok()? {
        moment.work += step.work;
        moment.replayed += step.replayed;
        moment.repaired += relevant.among(step.photons.iter().copied());
        moment.seconds = start.elapsed().as_secs_f64();
        moments.push(moment);
        if !progress(course.share()) {
            return None;
        }
    }
    let (solution, ledger) = course.finish()?;
    let kept = ledger.map(|ledger| Kept { ledger, scan_seconds: scan.seconds, marked: scan.marked });
    Some(Recovery { moments, solution, kept })
}
