//! What the figures are made of: which photons an edit makes wrong and what re-shooting them costs, by brute force, and the course
//! of one repair by Algorithm 1 (Dmitriev et al. 2002, §5.2).

use lightmend_photon::{
    path::{Rules, Touched, trace, trace_both},
    pool::{GroupId, PhotonIndex, Pool},
    record::{Trail, Watch},
    solution::Solution,
    world::World,
};
use rayon::prelude::*;
use std::{sync::Arc, time::Instant};

/// One photon before and after an edit. Rays are traversals of the trees.
#[derive(Debug, Clone, Copy, Default)]
pub struct Fact {
    /// Whether a hit or a deposit differs: the seed's *relevant photon*.
    pub relevant: bool,
    /// Rays of its old path.
    pub old: u32,
    /// Rays of its new path.
    pub new: u32,
    /// Rays of both at once, their common beginning traced once.
    pub both: u32,
    /// The segment on which it first meets what changed, 1 the one that leaves the lamp; 0 if it never does.
    pub met_on: u32,
}

/// Traces every photon of a pool in both worlds, thrice: for its old path, its new one, and both at once.
pub fn facts(pool: &Pool, rules: &Rules, before: &World, after: &World) -> Vec<Fact> {
    let changed = before.difference(after);
    let phantoms = before.phantoms(&changed.phantoms);
    let mut facts = vec![Fact::default(); pool.photons() as usize];
    const BLOCK: usize = 4096;
    facts.par_chunks_mut(BLOCK).enumerate().for_each(|(block, facts)| {
        let (mut old, mut new) = (Trail::default(), Trail::default());
        for (k, fact) in facts.iter_mut().enumerate() {
            let index = PhotonIndex((block * BLOCK + k) as u64);
            old.clear();
            new.clear();
            trace(rules, before, index, &mut old);
            trace(rules, after, index, &mut new);
            let [mut common, mut back, mut forth] = [Watch::default(); 3];
            let worlds = [before, after];
            let touched = trace_both(rules, worlds, &changed, &phantoms, index, &mut common, &mut back, &mut forth);
            *fact = Fact {
                relevant: old.differs(&new),
                old: old.rays as u32,
                new: new.rays as u32,
                both: (common.rays + back.rays + forth.rays) as u32,
                met_on: match touched {
                    Touched::Nothing => 0,
                    Touched::Lamp(_) => 1,
                    Touched::Object(_) | Touched::Phantom(_) => common.rays as u32,
                },
            };
        }
    });
    facts
}

/// How many photons are relevant.
pub fn relevant(facts: &[Fact]) -> u64 {
    facts.iter().filter(|fact| fact.relevant).count() as u64
}

/// A moment of a repair: sums since the edit.
#[derive(Debug, Clone, Copy, Default)]
pub struct Moment {
    /// Seconds.
    pub seconds: f64,
    /// Rays.
    pub rays: u64,
    /// Relevant photons repaired.
    pub repaired: u64,
    /// Rays that a store of all old paths would have saved: all but those of the new paths.
    pub saved_by_store: u64,
}

impl Moment {
    /// The moment after these photons were re-shot, but for the time.
    fn after(self, photons: impl Iterator<Item = PhotonIndex>, facts: &[Fact]) -> Moment {
        let mut next = self;
        for photon in photons {
            let fact = facts[photon.0 as usize];
            next.rays += u64::from(fact.both);
            next.repaired += u64::from(fact.relevant);
            // A photon that meets nothing that changed costs its path once, with a store or without.
            next.saved_by_store += u64::from(fact.both.saturating_sub(fact.new));
        }
        next
    }
}

/// The groups in the order of the seed's Algorithm 1: P counts pilots of groups that were shot before, and nothing else.
fn algorithm_1(pool: &Pool, facts: &[Fact]) -> Vec<GroupId> {
    let mut priority = vec![0u32; pool.groups() as usize];
    let mut left: Vec<GroupId> = (0..pool.groups()).map(GroupId).collect();
    let mut order = Vec::new();
    while let Some(next) = left.iter().copied().reduce(|a, b| if priority[b.0 as usize] > priority[a.0 as usize] { b } else { a })
    {
        left.retain(|group| *group != next);
        order.push(next);
        for pilot in pool.photons_of(next).filter(|photon| pool.is_pilot(*photon)) {
            priority[pool.resembled(pilot).0 as usize] += u32::from(facts[pilot.0 as usize].met_on > 0);
        }
    }
    order
}

/// Repairs a drained solution on one thread, group by group in the order of Algorithm 1. The edit comes first among the moments.
///
/// One thread, so that groups of 114 photons, too small to be shared out, do not look slow beside groups of 4,000. The order being
/// the same each time, it is run `times` times, and each group counts with its least time: other programs run too.
pub fn course(
    drained: &Solution,
    after: &Arc<World>,
    facts: &[Fact],
    times: u32,
) -> Result<(Vec<Moment>, Solution), rayon::ThreadPoolBuildError> {
    let thread = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let order = algorithm_1(drained.pool(), facts);
    let run = || {
        let mut solution = drained.clone();
        let mut repairs = Vec::new();
        let mut start = Instant::now();
        thread.install(|| {
            solution.change(after.clone());
            for group in &order {
                repairs.push((solution.repair(*group).unwrap(), start.elapsed().as_secs_f64()));
                start = Instant::now();
            }
        });
        (repairs, solution)
    };
    let (mut repairs, solution) = run();
    for _ in 1..times {
        for (least, (_, seconds)) in repairs.iter_mut().zip(run().0) {
            least.1 = least.1.min(seconds);
        }
    }
    let mut moments = vec![Moment::default()];
    for (repaired, seconds) in repairs {
        let last = moments[moments.len() - 1];
        let photons = drained.pool().photons_of(repaired.group);
        moments.push(Moment { seconds: last.seconds + seconds, ..last.after(photons, facts) });
    }
    Ok((moments, solution))
}

/// The groups of a pool in the order of `urgency`, highest first. Without times.
fn in_order(pool: &Pool, urgency: impl Fn(GroupId) -> f64) -> Vec<GroupId> {
    let mut groups: Vec<(f64, GroupId)> = (0..pool.groups()).map(|g| (urgency(GroupId(g)), GroupId(g))).collect();
    groups.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    groups.into_iter().map(|(_, group)| group).collect()
}

/// What the same groups would allow if pilots knew all: most relevant photons per ray first. Without times.
pub fn perfect_pilots(pool: &Pool, facts: &[Fact]) -> Vec<Moment> {
    let groups = in_order(pool, |g| {
        let all = Moment::default().after(pool.photons_of(g), facts);
        all.repaired as f64 / all.rays.max(1) as f64
    });
    let mut moments = vec![Moment::default()];
    for group in groups {
        moments.push(moments[moments.len() - 1].after(pool.photons_of(group), facts));
    }
    moments
}

/// What the same pilots would allow if all of them were shot first, and the corrective photons then in order of P. Without times.
pub fn pilots_first(pool: &Pool, facts: &[Fact]) -> Vec<Moment> {
    let pilots = || (0..pool.photons()).map(PhotonIndex).filter(|i| pool.is_pilot(*i));
    let mut priority = vec![0u32; pool.groups() as usize];
    for pilot in pilots() {
        priority[pool.resembled(pilot).0 as usize] += u32::from(facts[pilot.0 as usize].met_on > 0);
    }
    let mut moments = vec![Moment::default(), Moment::default().after(pilots(), facts)];
    for group in in_order(pool, |g| f64::from(priority[g.0 as usize])) {
        let correctives = pool.photons_of(group).filter(|i| !pool.is_pilot(*i));
        moments.push(moments[moments.len() - 1].after(correctives, facts));
    }
    moments
}

/// The first moment at which `share` (0 to 1) of the relevant photons was repaired.
pub fn reached(moments: &[Moment], share: f64, relevant: u64) -> Moment {
    let wanted = (share * relevant as f64).ceil() as u64;
    moments[moments.partition_point(|m| m.repaired < wanted).min(moments.len() - 1)]
}
