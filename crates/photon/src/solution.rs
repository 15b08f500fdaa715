//! A pool of photons shot at a configuration, and its repair after edits: the seed's Algorithm 1.
//!
//! Dmitriev et al. 2002, §5.2. All photons of one group were shot at one frozen world. When the configuration changes, the groups
//! whose world differs are stale: their phantoms are the objects that stood elsewhere then, at most one per object, derived from
//! that world. The stale group of highest priority V·P is traced in both worlds; photons whose paths part are taken back in the old
//! world and added in the new one. Pilots that meet what changed raise the priority P of the group they resemble; those that the camera may see raise its V. In the end every
//! group has been shot, and every bucket equals that of a fresh solution to the bit.
//!
//! Beyond the seed, P starts with the first segments that can reach what changed (`first_segment.rs`): no pilot is needed to find what
//! a lamp shines at.

use crate::{
    bucket::{Buckets, Full},
    first_segment::FirstSegments,
    hash::shuffle,
    importance::Gaze,
    path::{FirstHits, Rules, Touched, trace_both},
    pool::{GroupId, PhotonIndex, Pool},
    record::{Outcome, Tally, Watch, book},
    saved::Saved,
    shooting::{Shooting, Work, has_room},
    urgency::{Key, Urgency},
    world::{Difference, World},
};
use rayon::prelude::*;
use std::sync::Arc;

/// Photons that one task traces in a row.
const TASK: u64 = 512;

/// What `Solution` keeps of a world that groups were shot at.
#[derive(Clone)]
struct Past {
    world: Arc<World>,
    /// From it to the current world.
    changed: Difference,
    /// Of each group, the first segments that can reach what changed; only while something did.
    reaching: Arc<[u32]>,
    groups: usize,
}

/// A pool of photons and the light that they brought.
#[derive(Clone)]
pub struct Solution {
    pool: Pool,
    rules: Arc<Rules>,
    buckets: Buckets,
    tallies: Vec<Tally>,
    world: Arc<World>,
    pasts: Vec<Past>,
    /// Per group, an index into `pasts`.
    past_of: Vec<u32>,
    /// Of each group, the pilots that resemble it and met what changed.
    priority: Vec<u32>,
    view: Visibility,
    /// V·P of the stale groups, as it now is.
    urgency: Urgency,
    /// All groups in a fixed pseudo-random order, and where in it the last one was repaired.
    shuffled: Arc<[GroupId]>,
    turn: usize,
}

/// V of each group: how much the hits of pilots that resemble it matter to the camera.
#[derive(Clone, Default)]
struct Visibility {
    gaze: Option<Gaze>,
    hits: Vec<u64>,
    /// Pilots shot since the camera moved.
    pilots: u64,
}

/// How many first segments that can reach what changed a pilot that met it is worth. More: what pilots find counts sooner; fewer: what
/// a lamp shines at comes first for longer. Four times as many or a quarter change little.
const PILOT: u64 = 16;

/// V counts once so many pilots per group have been shot since the camera moved; until then it is 1 for all.
/// More: V is more reliable; fewer: it is used sooner.
const PILOTS_FOR_VISIBILITY: u64 = 8;

impl Visibility {
    fn is_robust(&self) -> bool {
        self.gaze.is_some() && self.pilots >= PILOTS_FOR_VISIBILITY * self.hits.len() as u64
    }

    fn importance(&self, group: usize) -> u64 {
        if self.is_robust() { self.hits[group] } else { 1 }
    }
}

/// A photon whose paths part, or a pilot that the camera may see.
struct Finding {
    photon: PhotonIndex,
    touched: Touched,
    seen: u64,
}

/// A group that was brought up to date.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Repaired {
    /// Which.
    pub group: GroupId,
    /// What it cost.
    pub work: Work,
}

impl Solution {
    /// Shoots a whole pool, or as much of it as the buckets can count ([`is_full`](Self::is_full)). `progress` hears of the photons shot so far
    /// and of the rays of the last slab, and may end the work by returning `false`; what was shot until then is then the whole pool, smaller.
    /// `None` if that is less than the groups need.
    pub fn shoot(
        pool: Pool,
        world: Arc<World>,
        first_hits: FirstHits,
        progress: &mut dyn FnMut(u64, u64) -> bool,
    ) -> Option<Solution> {
        let rules = Arc::new(Rules { sequence: pool.sequence(), first_hits });
        Solution::finish(pool, Shooting::new(rules, world), progress)
    }

    /// As [`shoot`](Self::shoot), going on from what was saved; its scrambling and first hits must be those of the pool. `None` also if
    /// more was saved than the pool holds.
    pub fn resume(pool: Pool, world: Arc<World>, saved: Saved, progress: &mut dyn FnMut(u64, u64) -> bool) -> Option<Solution> {
        let rules = Arc::new(Rules { sequence: pool.sequence(), first_hits: saved.first_hits });
        let shot = Work { photons: saved.photons, rays: 0 };
        let shooting = Shooting::of(rules, world, saved.buckets, saved.tallies, shot);
        (saved.photons <= pool.photons()).then(|| Solution::finish(pool, shooting, progress))?
    }

    /// What can be saved of a solution of which nothing is stale.
    pub fn to_saved(&self) -> Option<Saved> {
        (self.stale_groups() == 0).then(|| Saved {
            scrambling: self.pool.scrambling,
            copies: self.pool.copies_and_groups(),
            first_hits: self.rules.first_hits,
            photons: self.pool.photons(),
            buckets: self.buckets.clone(),
            tallies: self.tallies.clone(),
        })
    }

    /// Shoots `count` more photons; each joins the group that it resembles. Only while nothing is stale: `None` otherwise. None at all are shot
    /// where the buckets could not count them.
    pub fn grow(&mut self, count: u64) -> Option<Work> {
        if self.stale_groups() > 0 {
            return None;
        }
        let (buckets, tallies) = (std::mem::take(&mut self.buckets), std::mem::take(&mut self.tallies));
        let before = Work { photons: self.pool.photons(), rays: 0 };
        let mut shooting = Shooting::of(self.rules.clone(), self.world.clone(), buckets, tallies, before);
        while shooting.photons() < before.photons + count {
            if shooting.shoot(before.photons + count - shooting.photons()).is_err() {
                break;
            }
        }
        self.pool = self.pool.grown(shooting.photons());
        (self.buckets, self.tallies) = (shooting.buckets, shooting.tallies);
        Some(Work { photons: shooting.work.photons - before.photons, rays: shooting.work.rays })
    }

    /// Whether no more photons can be shot, however many were asked for: the buckets hold what they can count.
    pub fn is_full(&self) -> bool {
        has_room(&self.buckets, self.pool.photons()).is_err()
    }

    fn finish(pool: Pool, mut shooting: Shooting, progress: &mut dyn FnMut(u64, u64) -> bool) -> Option<Solution> {
        while shooting.photons() < pool.photons() {
            let rays = shooting.work.rays;
            let shot = shooting.shoot(pool.photons() - shooting.photons());
            if shot.is_err() || !progress(shooting.photons(), shooting.work.rays - rays) {
                break;
            }
        }
        Solution::of(pool, shooting)
    }

    /// What was shot is the whole pool, perhaps smaller than `pool`. `None` if it is less than the groups need.
    pub fn of(pool: Pool, shooting: Shooting) -> Option<Solution> {
        let pool = pool.shrunk(shooting.photons())?;
        let Shooting { rules, world, buckets, tallies, .. } = shooting;
        let groups = pool.groups() as usize;
        let past = Past { world: world.clone(), changed: Difference::default(), reaching: Arc::default(), groups };
        let mut shuffled: Vec<GroupId> = (0..pool.groups()).map(GroupId).collect();
        shuffle(&mut shuffled);
        Some(Solution {
            pool,
            rules,
            buckets,
            tallies,
            world,
            pasts: vec![past],
            past_of: vec![0; groups],
            priority: vec![0; groups],
            view: Visibility { hits: vec![0; groups], ..Visibility::default() },
            urgency: Urgency::new((0..groups).map(|_| None)),
            shuffled: shuffled.into(),
            turn: 0,
        })
    }

    /// The pool.
    pub fn pool(&self) -> &Pool {
        &self.pool
    }

    /// How photons become paths.
    pub fn rules(&self) -> &Arc<Rules> {
        &self.rules
    }

    /// The light.
    pub fn buckets(&self) -> &Buckets {
        &self.buckets
    }

    /// How paths ended, per lamp.
    pub fn tallies(&self) -> &[Tally] {
        &self.tallies
    }

    /// Whether another solution holds the same light to the bit: buckets and how paths ended.
    pub fn equals(&self, other: &Solution) -> bool {
        let slots = self.tallies.len().max(other.tallies.len());
        let tally = |s: &Solution, lamp: usize| s.tallies.get(lamp).copied().unwrap_or_default();
        self.buckets == other.buckets && (0..slots).all(|lamp| tally(self, lamp) == tally(other, lamp))
    }

    /// The world that stale groups are brought to.
    pub fn world(&self) -> &Arc<World> {
        &self.world
    }

    /// From now on, stale groups are brought to this world. Nothing is traced yet.
    pub fn change(&mut self, world: Arc<World>) {
        self.buckets.grow(world.configuration());
        self.tallies.resize(self.tallies.len().max(world.configuration().lamp_slots()), Tally::default());
        self.world = world;
        self.forget_unused_pasts();
        for past in &mut self.pasts {
            past.changed = past.world.difference(&self.world);
        }
        if self.stale_groups() > 0 {
            let segments = FirstSegments::new(&self.pool, &self.rules, &self.world);
            for past in self.pasts.iter_mut().filter(|past| !past.changed.is_empty()) {
                past.reaching = segments.reaching(&past.world, &past.changed).into();
            }
        }
        self.rank_all();
    }

    /// Drops worlds that no group was shot at any more.
    fn forget_unused_pasts(&mut self) {
        let mut number = 0;
        let numbers: Vec<u32> = self
            .pasts
            .iter()
            .map(|past| {
                let own = number;
                number += u32::from(past.groups > 0);
                own
            })
            .collect();
        for past in &mut self.past_of {
            *past = numbers[*past as usize];
        }
        self.pasts.retain(|past| past.groups > 0);
    }

    fn is_stale(&self, group: usize) -> bool {
        !self.pasts[self.past_of[group] as usize].changed.is_empty()
    }

    /// From now on the light is looked at like this: groups that matter most come first.
    pub fn look(&mut self, gaze: Option<Gaze>) {
        if self.view.gaze != gaze {
            self.view = Visibility { gaze, hits: vec![0; self.priority.len()], pilots: 0 };
            self.rank_all();
        }
    }

    /// V·P of a group, then P; `None` if it is not stale.
    fn key(&self, group: usize) -> Key {
        let past = &self.pasts[self.past_of[group] as usize];
        (!past.changed.is_empty()).then(|| {
            let p = PILOT * u64::from(self.priority[group]) + u64::from(past.reaching[group]);
            (self.view.importance(group) * p, p)
        })
    }

    fn rank_all(&mut self) {
        self.urgency = Urgency::new((0..self.past_of.len()).map(|group| self.key(group)));
    }

    /// Groups that hold phantoms.
    pub fn stale_groups(&self) -> usize {
        self.pasts.iter().filter(|past| !past.changed.is_empty()).map(|past| past.groups).sum()
    }

    /// The groups that hold phantoms, in order.
    pub fn stale(&self) -> impl Iterator<Item = GroupId> + '_ {
        (0..self.pool.groups()).map(GroupId).filter(|g| self.is_stale(g.0 as usize))
    }

    /// Photons of the groups that hold phantoms.
    pub fn stale_photons(&self) -> u64 {
        self.stale().map(|group| self.pool.photons_in(group)).sum()
    }

    /// The stale group of highest priority V·P; among equals that of higher P, then the first.
    pub fn most_urgent(&self) -> Option<GroupId> {
        self.urgency.first()
    }

    /// Brings the most urgent stale group up to date. `None` if none is stale. Which group comes next depends on state alone.
    pub fn repair_next(&mut self) -> Result<Option<Repaired>, Full> {
        self.most_urgent().map(|group| self.repair(group)).transpose()
    }

    /// Brings the next stale group of a fixed pseudo-random order up to date, going round: under edits that keep coming every group
    /// has its turn equally often. `None` if none is stale.
    pub fn repair_shuffled(&mut self) -> Result<Option<Repaired>, Full> {
        let groups = self.shuffled.len();
        let mut turns = (self.turn..self.turn + groups).map(|turn| turn % groups);
        let Some(turn) = turns.find(|turn| self.is_stale(self.shuffled[*turn].0 as usize)) else { return Ok(None) };
        self.turn = turn + 1;
        self.repair(self.shuffled[turn]).map(Some)
    }

    /// A round of headless work: repairs groups until `rays` were traced or nothing is stale. It ends with the group that reaches them,
    /// so that what a row of rounds does depends on state alone.
    pub fn repair_round(&mut self, rays: u64) -> Result<Work, Full> {
        let mut work = Work::default();
        while work.rays < rays {
            let Some(repaired) = self.repair_next()? else { break };
            work += repaired.work;
        }
        Ok(work)
    }

    /// Brings one group up to date; nothing changes if the light that it would bring does not fit.
    pub fn repair(&mut self, group: GroupId) -> Result<Repaired, Full> {
        let past = self.pasts[self.past_of[group.0 as usize] as usize].clone();
        let photons: Vec<PhotonIndex> = self.pool.photons_of(group).collect();
        let (work, findings) = self.reshoot(&past.world, &past.changed, &photons)?;
        let robust = self.view.is_robust();
        self.view.pilots += self.pool.pilots_per_group();
        if robust != self.view.is_robust() {
            self.rank_all();
        }
        for Finding { photon, touched, seen } in findings {
            if self.pool.is_pilot(photon) {
                let resembled = self.pool.resembled(photon);
                self.view.hits[resembled.0 as usize] += seen;
                self.raise(resembled, touched, &past.world);
                self.urgency.set(resembled, self.key(resembled.0 as usize));
            }
        }
        self.settle(group);
        Ok(Repaired { group, work })
    }

    /// A pilot that resembles the photons of `group` met something that changed: Δp = 1 if that group is stale on its account.
    fn raise(&mut self, group: GroupId, touched: Touched, shot_at: &World) {
        let past = &self.pasts[self.past_of[group.0 as usize] as usize];
        let concerns = match touched {
            Touched::Nothing => false,
            Touched::Object(id) => past.changed.objects.contains(&id),
            // Only if that group holds the very same phantom.
            Touched::Phantom(id) => past.changed.phantoms.contains(&id) && past.world.same_place(shot_at, id),
            Touched::Lamp(id) => past.changed.choice || past.changed.lamps.contains(&id),
        };
        if concerns {
            self.priority[group.0 as usize] += 1;
        }
    }

    /// `group` is up to date.
    fn settle(&mut self, id: GroupId) {
        let group = id.0 as usize;
        self.pasts[self.past_of[group] as usize].groups -= 1;
        let current = self.pasts.iter().position(|past| Arc::ptr_eq(&past.world, &self.world)).unwrap_or_else(|| {
            self.pasts.push(Past {
                world: self.world.clone(),
                changed: Difference::default(),
                reaching: Arc::default(),
                groups: 0,
            });
            self.pasts.len() - 1
        });
        self.pasts[current].groups += 1;
        self.past_of[group] = current as u32;
        self.priority[group] = 0;
        self.urgency.set(id, None);
    }

    /// Re-shoots photons from `before` to the current world; returns those that touched what changed, and pilots that the camera may see.
    fn reshoot(&mut self, before: &World, changed: &Difference, photons: &[PhotonIndex]) -> Result<(Work, Vec<Finding>), Full> {
        let lamps = self.tallies.len();
        if lamps == 0 {
            return Ok(Default::default());
        }
        let phantoms = before.phantoms(&changed.phantoms);
        let tasks: Vec<_> = photons
            .par_chunks(TASK as usize)
            .map(|photons| {
                let (mut old, mut new) = (Outcome::new(lamps, true), Outcome::new(lamps, false));
                let (mut rays, mut findings) = (0, Vec::new());
                for photon in photons {
                    let gaze = self.view.gaze.as_ref().filter(|_| self.pool.is_pilot(*photon));
                    let mut common = Watch { gaze, ..Watch::default() };
                    let mut watch = common;
                    let worlds = [before, &*self.world];
                    let mut both = (&mut new, &mut watch);
                    let touched = trace_both(&self.rules, worlds, changed, &phantoms, *photon, &mut common, &mut old, &mut both);
                    let seen = common.seen + watch.seen;
                    rays += common.rays;
                    if touched != Touched::Nothing || seen > 0 {
                        findings.push(Finding { photon: *photon, touched, seen });
                    }
                }
                (old, new, rays, findings)
            })
            .collect();
        book(tasks.iter().flat_map(|(old, new, ..)| [old, new]), &mut self.buckets, &mut self.tallies)?;
        let mut work = Work { photons: photons.len() as u64, rays: 0 };
        let mut findings = Vec::new();
        for (old, new, rays, found) in tasks {
            work.rays += old.rays + new.rays + rays;
            findings.extend(found);
        }
        Ok((work, findings))
    }

    /// Repairs photons in any other order than Algorithm 1's: for comparisons. All groups must have been shot at one earlier world,
    /// and after the last call [`settle_all`](Self::settle_all) says that every relevant photon was among them.
    pub fn repair_photons(&mut self, photons: &[PhotonIndex]) -> Result<Work, Full> {
        let past = self.pasts[self.past_of[0] as usize].clone();
        Ok(self.reshoot(&past.world, &past.changed, photons)?.0)
    }

    /// Declares all groups up to date.
    pub fn settle_all(&mut self) {
        for group in 0..self.pool.groups() {
            self.settle(GroupId(group));
        }
    }
}
