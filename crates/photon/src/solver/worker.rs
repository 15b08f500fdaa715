//! What the solver does in the background: shoot the pool, then repair it, an iteration at a time.

use super::{Controls, Order, Settings, Shared, Snapshot, Wanted, lock};
use crate::{
    body::TreePreset,
    irradiance::Scale,
    path::Rules,
    pool::Pool,
    solution::{Shooting, Solution, Work},
    visible::Frustum,
    world::World,
};
use lightmend_scene::Configuration;
use std::{
    sync::{Arc, PoisonError},
    time::{Duration, Instant},
};

/// Width of pictures over their height, for what a camera may see.
const ASPECT: f64 = 16.0 / 9.0;

/// Edits keep coming if the last one is no older than this. Longer: what is visible comes first later; shorter: a slow hand counts as rest.
const RECENT: Duration = Duration::from_millis(300);

/// Edits may throw away one so-many-th of a pool during its first shooting. Higher: light of the old place is seen for longer; lower: more
/// work is thrown away, and noise returns.
const LITTLE: u64 = 8;

/// While the pool is shot for the first time, a snapshot is due when it has this share of photons more than the last one: its noise is 3 % lower.
const MORE: u64 = 16;

enum Light {
    /// Shot for the first time, perhaps at an earlier world than the wanted one.
    Shooting {
        shooting: Box<Shooting>,
        stale: bool,
    },
    Whole(Box<Solution>),
}

struct Worker<'s> {
    shared: &'s Shared,
    pool: Pool,
    rules: Arc<Rules>,
    light: Light,
    /// The wanted one.
    world: Arc<World>,
    /// The number of the last edit that was taken up.
    edits: u64,
    /// When the last one came that changed anything.
    edited: Option<Instant>,
    work: Work,
    /// Photons between two looks at the clock in the first shooting.
    slab: u64,
    /// Photons of a first shooting that edits threw away.
    thrown: u64,
    /// Photons of the last snapshot, since the shooting began.
    published: u64,
    /// Whether there is anything to publish.
    news: bool,
}

/// Works until it is stopped.
pub fn work(shared: &Shared, configuration: &Configuration, settings: &Settings) {
    let world = Arc::new(World::new(configuration, TreePreset::default()));
    let rules = Arc::new(Rules { sequence: settings.pool.sequence(), first_hits: settings.first_hits });
    let mut worker = Worker {
        shared,
        pool: settings.pool,
        light: Light::shoot(&rules, &world),
        rules,
        world,
        edits: 0,
        edited: None,
        work: Work::default(),
        slab: Shooting::LEAST,
        thrown: 0,
        published: 0,
        news: true,
    };
    let mut iterations = 0;
    while let Some(controls) = worker.take_up() {
        worker.iterate(&controls);
        iterations += 1;
        if iterations >= controls.iterations && worker.is_due() {
            worker.publish();
            iterations = 0;
        }
    }
}

impl Light {
    fn shoot(rules: &Arc<Rules>, world: &Arc<World>) -> Light {
        Light::Shooting { shooting: Box::new(Shooting::new(rules.clone(), world.clone())), stale: false }
    }

    fn photons(&self) -> u64 {
        match self {
            Light::Shooting { shooting, .. } => shooting.photons(),
            Light::Whole(solution) => solution.pool().photons(),
        }
    }

    fn is_exact(&self) -> bool {
        matches!(self, Light::Whole(solution) if solution.stale_groups() == 0)
    }
}

impl Worker<'_> {
    /// Takes up what is wanted; waits as long as there is nothing to do. `None`: it is to stop.
    fn take_up(&mut self) -> Option<Controls> {
        let shared = self.shared;
        loop {
            let wanted = lock(&shared.wanted).clone();
            if wanted.stop {
                return None;
            }
            if wanted.edits != self.edits {
                self.edit(&wanted);
            }
            if let (Some(view), Light::Whole(solution)) = (&wanted.view, &mut self.light) {
                solution.look(Some(Frustum::new(view, wanted.configuration.scene().up, ASPECT)));
            }
            let paused = wanted.controls.paused && wanted.waiting == 0;
            if !paused && !self.light.is_exact() {
                return Some(wanted.controls);
            }
            if self.news {
                self.publish();
            }
            let latest = lock(&shared.wanted);
            let same = |latest: &mut Wanted| latest.version == wanted.version;
            drop(shared.changed.wait_while(latest, same).unwrap_or_else(PoisonError::into_inner));
        }
    }

    fn edit(&mut self, wanted: &Wanted) {
        if wanted.configuration != *self.world.configuration() {
            self.world = Arc::new(self.world.moved_to(&wanted.configuration));
            self.edited = Some(Instant::now());
            match &mut self.light {
                Light::Shooting { shooting, stale } => {
                    *stale = !shooting.world().difference(&self.world).is_empty();
                    if !*stale {
                        shooting.change(self.world.clone());
                    }
                }
                Light::Whole(solution) => solution.change(self.world.clone()),
            }
        }
        if wanted.started_over > self.edits {
            self.thrown = 0;
            self.start_over();
        }
        self.edits = wanted.edits;
        self.news = true;
    }

    fn start_over(&mut self) {
        self.light = Light::shoot(&self.rules, &self.world);
        self.published = 0;
    }

    /// Shoots or repairs for the time of an iteration.
    fn iterate(&mut self, controls: &Controls) {
        let little = self.pool.photons() / LITTLE;
        if let Light::Shooting { shooting, stale: true } = &self.light
            && self.thrown + shooting.photons() < little
        {
            self.thrown += shooting.photons();
            self.start_over();
        }
        match &mut self.light {
            Light::Shooting { shooting, stale } => {
                let (before, start) = (shooting.work, Instant::now());
                shooting.shoot(self.slab.min(self.pool.photons() - shooting.photons()));
                // A slab takes an iteration: half to one and a half.
                if start.elapsed() < controls.iteration / 2 {
                    self.slab = (self.slab * 2).min(Shooting::SLAB);
                } else if start.elapsed() > controls.iteration * 3 / 2 {
                    self.slab = (self.slab / 2).max(Shooting::LEAST);
                }
                self.work += Work { photons: shooting.work.photons - before.photons, rays: shooting.work.rays - before.rays };
                if shooting.photons() == self.pool.photons()
                    && let Some(mut solution) = Solution::of(self.pool, Shooting::clone(shooting))
                {
                    if *stale {
                        solution.change(self.world.clone());
                    }
                    self.light = Light::Whole(Box::new(solution));
                }
            }
            Light::Whole(solution) => {
                let start = Instant::now();
                loop {
                    let moving = self.edited.is_some_and(|edited| edited.elapsed() < RECENT);
                    let repaired = match controls.order {
                        Order::Adaptive if moving => solution.repair_shuffled(),
                        Order::Shuffled => solution.repair_shuffled(),
                        Order::Adaptive | Order::Urgent => solution.repair_next(),
                    };
                    let Some(repaired) = repaired else { break };
                    self.work += repaired.work;
                    if start.elapsed() >= controls.iteration {
                        break;
                    }
                }
            }
        }
        self.news = true;
    }

    /// Whether the next snapshot is awaited and worth its while.
    fn is_due(&self) -> bool {
        let published = lock(&self.shared.published);
        let more = match self.light {
            Light::Shooting { .. } => self.light.photons() * MORE >= self.published * (MORE + 1),
            Light::Whole(_) => true,
        };
        published.light.is_none() || (published.taken && more)
    }

    fn publish(&mut self) {
        let (pool_photons, photons) = (self.pool.photons(), self.light.photons());
        let (buckets, stale_groups, outstanding_photons) = match &self.light {
            Light::Shooting { shooting, stale: false } => (shooting.buckets(), 0, pool_photons - photons),
            Light::Shooting { shooting, stale: true } => (shooting.buckets(), self.pool.groups() as usize, pool_photons),
            Light::Whole(solution) => (solution.buckets(), solution.stale_groups(), solution.stale_photons()),
        };
        let snapshot = Arc::new(Snapshot {
            world: self.world.clone(),
            buckets: buckets.clone(),
            scale: Scale::new(&self.world, photons),
            photons,
            pool_photons,
            stale_groups,
            outstanding_photons,
            work: self.work,
            edits: self.edits,
            exact: outstanding_photons == 0,
        });
        self.published = photons;
        self.news = false;
        // Nobody waits at the lock while the old one is freed.
        let old = {
            let mut published = lock(&self.shared.published);
            published.taken = false;
            published.light.replace(snapshot)
        };
        drop(old);
        self.shared.news.notify_all();
    }
}
