//! A drag played step by step: how much of the change is outstanding at each frame, order against order.
//!
//! Every frame has the same amount of work, counted in rays, so that frame *k* shows the light after exactly *k* × that work,
//! everywhere and every time. A round ends with the group that reaches it; the next one is shorter by as much.

use crate::{
    bucket::Buckets,
    hash::mix,
    importance::{Gaze, Importance},
    irradiance::Scale,
    ledger::LedgerSolution,
    recovery::Order,
    shooting::Shooting,
    solution::Solution,
    visible::{Frustum, Visible},
    world::World,
};
use std::sync::Arc;

/// One frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Seconds of the script.
    pub time: f64,
    /// Rays traced so far.
    pub rays: u64,
    /// Visible error ÷ visible error at the beginning, both against the drained end.
    pub outstanding: f64,
}

/// What is played.
pub struct Play<'a> {
    /// The drained light before the drag.
    pub start: &'a Solution,
    /// Seconds and the world from then on, in order.
    pub steps: &'a [(f64, Arc<World>)],
    /// The light of the last step, drained.
    pub end: &'a Solution,
    /// What the camera sees of it.
    pub visible: &'a Visible,
    /// Through which the stateless order looks: V·P instead of P.
    pub frustum: Option<Frustum>,
    /// Frames a second.
    pub fps: f64,
    /// Rays a frame.
    pub work: u64,
}

/// The light that is shown while work goes on.
enum Worker {
    /// Repair in groups; `random` in random order, otherwise in Algorithm 1's.
    Repair { solution: Box<Solution>, random: bool, rays: u64 },
    /// Repair with a ledger: in pseudo-random order while something moves, what is visible first when it rests.
    Ledger { solution: Box<LedgerSolution>, importance: Importance, rays: u64 },
    /// A new pool for the newest world, shown when it is complete.
    Restart { shown: Buckets, shown_world: Arc<World>, shooting: Option<Box<Shooting>>, rays: u64 },
}

impl Play<'_> {
    /// Plays until the light is that of `end`, or for `limit` frames. `None` if `progress` returns `false` or a step is refused.
    pub fn run(&self, order: Order<'_>, limit: usize, progress: &mut dyn FnMut(usize) -> bool) -> Option<Vec<Frame>> {
        let scale = Scale::new(self.start.world(), self.start.pool().photons());
        let error = |light: &Buckets| self.visible.error(light, self.end.buckets(), &scale);
        let whole = error(self.start.buckets());
        let mut worker = match order {
            Order::Restart => Worker::Restart {
                shown: self.start.buckets().clone(),
                shown_world: self.start.world().clone(),
                shooting: None,
                rays: 0,
            },
            Order::Ledger(ledger) => {
                let importance = self.visible.importance(self.end.world());
                Worker::Ledger { solution: Box::new(ledger.clone()), importance, rays: 0 }
            }
            _ => {
                let mut solution = Box::new(self.start.clone());
                solution.look(self.frustum.map(Gaze::Frustum));
                Worker::Repair { solution, random: matches!(order, Order::Random), rays: 0 }
            }
        };
        let mut world = self.start.world().clone();
        let mut steps = self.steps.iter().peekable();
        let mut frames = vec![Frame { time: 0.0, rays: 0, outstanding: 1.0 }];
        for number in 1..=limit {
            let time = number as f64 / self.fps;
            while let Some((_, next)) = steps.next_if(|(at, _)| *at < time - 1e-9) {
                world = next.clone();
            }
            let done = worker.work(self.start, &world, number as u64 * self.work)?;
            let outstanding = if whole > 0.0 { error(worker.light()) / whole } else { 0.0 };
            frames.push(Frame { time, rays: worker.rays(), outstanding });
            if done && steps.peek().is_none() {
                break;
            }
            if !progress(number) {
                return None;
            }
        }
        Some(frames)
    }
}

impl Worker {
    fn light(&self) -> &Buckets {
        match self {
            Worker::Repair { solution, .. } => solution.buckets(),
            Worker::Ledger { solution, .. } => solution.buckets(),
            Worker::Restart { shown, .. } => shown,
        }
    }

    fn rays(&self) -> u64 {
        match self {
            Worker::Repair { rays, .. } | Worker::Ledger { rays, .. } | Worker::Restart { rays, .. } => *rays,
        }
    }

    /// Works towards `world` until `until` rays were traced in all; whether the light shown is then that of `world`. `None` if a step
    /// is refused.
    fn work(&mut self, start: &Solution, world: &Arc<World>, until: u64) -> Option<bool> {
        Some(match self {
            Worker::Ledger { solution, importance, rays } => {
                if !Arc::ptr_eq(solution.world(), world) {
                    solution.change(world.clone()).ok()?;
                    solution.scan(usize::MAX);
                } else {
                    solution.look(importance);
                }
                while *rays < until {
                    let Some(mended) = solution.repair_next().ok()? else { break };
                    *rays += mended.work.rays;
                }
                solution.is_exact()
            }
            Worker::Repair { solution, random, rays } => {
                if !Arc::ptr_eq(solution.world(), world) {
                    solution.change(world.clone());
                }
                if *random {
                    while *rays < until {
                        let Some(group) = random_stale(solution, *rays) else { return Some(true) };
                        *rays += solution.repair(group).ok()?.work.rays;
                    }
                } else {
                    *rays += solution.repair_round(until.saturating_sub(*rays)).ok()?.rays;
                }
                solution.stale_groups() == 0
            }
            Worker::Restart { shown, shown_world, shooting, rays } => {
                while *rays < until {
                    if shooting.is_none() && Arc::ptr_eq(shown_world, world) {
                        return Some(true);
                    }
                    let current = shooting.get_or_insert_with(|| Box::new(Shooting::new(start.rules().clone(), world.clone())));
                    let before = current.work.rays;
                    current.shoot((start.pool().photons() - current.photons()).min(Shooting::SLAB / 4)).ok()?;
                    *rays += current.work.rays - before;
                    if current.photons() == start.pool().photons() {
                        (*shown, *shown_world) = (current.buckets().clone(), current.world().clone());
                        *shooting = None;
                    }
                }
                shooting.is_none() && Arc::ptr_eq(shown_world, world)
            }
        })
    }
}

fn random_stale(solution: &Solution, state: u64) -> Option<crate::pool::GroupId> {
    let stale: Vec<_> = solution.stale().collect();
    (!stale.is_empty()).then(|| stale[(mix(state) % stale.len() as u64) as usize])
}
