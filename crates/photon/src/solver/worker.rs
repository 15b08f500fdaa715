//! What the solver does in the background: shoot the pool, repair it, let it grow, an iteration at a time.

use super::{
    Controls, Method, Order, Settings, Shared, Snapshot, Wanted,
    light::{Grown, Light},
    lock,
};
use crate::{
    body::TreePreset,
    importance::Gaze,
    irradiance::Scale,
    ledger::{LedgerSolution, Refused},
    path::Rules,
    reconstruction::{Reconstruction, Shapes},
    shooting::{Shooting, Work},
    visible::{Frustum, Visible},
    world::World,
};
use lightmend_scene::{Configuration, View};
use std::{
    sync::{Arc, PoisonError},
    time::{Duration, Instant},
};

/// Width of pictures over their height, for what a camera may see.
const ASPECT: f64 = 16.0 / 9.0;

/// Edits keep coming if the last one is no older than this. Longer: what is visible comes first later; shorter: a slow hand counts as rest.
const RECENT: Duration = Duration::from_millis(300);

/// What the camera sees of a ledger's light is not looked up more often than this: it casts a ray for each of 76,800 pixels and reads the
/// marked photons of a whole pool.
const LOOK: Duration = Duration::from_millis(500);

/// Edits may throw away one so-many-th of a pool during its first shooting. Higher: light of the old place is seen for longer; lower: more
/// work is thrown away, and noise returns.
const LITTLE: u64 = 8;

/// While nothing is wrong, a snapshot is due when it has this share of photons more than the last one: its noise is 3 % lower.
const MORE: u64 = 16;

/// Chunks scanned between two looks at the clock: some three milliseconds on a thread.
const SCAN: usize = 1024;

struct Worker<'s> {
    shared: &'s Shared,
    settings: Settings,
    rules: Arc<Rules>,
    light: Light,
    /// Why there is no ledger though one was wanted.
    refused: Option<Refused>,
    /// The wanted one.
    world: Arc<World>,
    /// For the error of its light.
    shapes: Shapes,
    /// Where the light is looked at from.
    view: Option<View>,
    /// Where the ledger looked from last, and when; not since the last edit.
    looked: Option<(View, Instant)>,
    /// The number of the last edit that was taken up.
    edits: u64,
    /// When the last one came that changed anything.
    edited: Option<Instant>,
    work: Work,
    /// Photons between two looks at the clock while shooting.
    slab: u64,
    /// Photons of a first shooting that edits threw away.
    thrown: u64,
    /// Whether the last iteration repaired.
    repaired: bool,
    /// Photons there will be before the error is estimated again.
    goal: u64,
    /// So many photons were enough for this error after this edit.
    enough: Option<(u64, f64, u64)>,
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
        settings: *settings,
        light: Light::shoot(&rules, &world),
        refused: None,
        rules,
        world,
        shapes: Shapes::default(),
        view: None,
        looked: None,
        edits: 0,
        edited: None,
        work: Work::default(),
        slab: Shooting::LEAST,
        thrown: 0,
        repaired: false,
        goal: 0,
        enough: None,
        published: 0,
        news: true,
    };
    worker.start_over();
    let mut iterations = 0;
    while let Some(controls) = worker.take_up() {
        worker.iterate(&controls);
        iterations += 1;
        if iterations >= controls.iterations && worker.is_due() {
            worker.publish(&controls);
            iterations = 0;
        }
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
            if let Some(view) = &wanted.view {
                self.view = Some(*view);
                let frustum = Frustum::new(view, wanted.configuration.scene().up, ASPECT);
                if let Light::Groups(solution) = &mut self.light {
                    solution.look(Some(Gaze::Frustum(frustum)));
                }
            }
            let paused = wanted.controls.paused && wanted.waiting == 0;
            if !paused && (self.outstanding() > 0 || self.grows(&wanted.controls)) {
                return Some(wanted.controls);
            }
            if self.news {
                self.publish(&wanted.controls);
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
            self.looked = None;
            if let Err(refused) = self.light.change(&self.world) {
                self.go_without_ledger(refused);
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
        let Settings { pool, first_hits, ledger_bytes, .. } = self.settings;
        // What a scene does not contain costs it nothing: where nothing moves there is no ledger.
        let moves = self.world.configuration().objects().any(|(_, object)| object.dynamic);
        let begun = (moves && ledger_bytes > 0)
            .then(|| LedgerSolution::begin(pool, self.world.clone(), first_hits, ledger_bytes))
            .transpose();
        self.refused = begun.as_ref().err().copied();
        self.light = match begun {
            Ok(Some(ledger)) => Light::Ledger(Box::new(ledger)),
            _ => Light::shoot(&self.rules, &self.world),
        };
        (self.published, self.goal, self.looked) = (0, pool.photons(), None);
    }

    /// The ledger cannot go on: what it has is thrown away unless all of it is right.
    fn go_without_ledger(&mut self, refused: Refused) {
        self.refused = Some(refused);
        let right = if let Light::Ledger(ledger) = &self.light { ledger.to_shooting() } else { None };
        self.light = match right {
            Some(shooting) => Light::Shooting { shooting: Box::new(shooting), stale: false },
            None => Light::shoot(&self.rules, &self.world),
        };
        self.published = self.published.min(self.light.photons());
        self.light.finish(self.settings.pool, &self.world);
    }

    /// Photons that may be wrong, and those of the pool that are missing.
    fn outstanding(&self) -> u64 {
        self.light.outstanding() + self.settings.pool.photons().saturating_sub(self.light.photons())
    }

    /// Whether more photons than the pool's are wanted. Nothing is outstanding.
    fn grows(&mut self, controls: &Controls) -> bool {
        let photons = self.light.photons();
        let Some(error) = controls.error.filter(|_| self.light.has_room()) else { return false };
        if photons < self.goal {
            return true;
        }
        if self.enough == Some((photons, error, self.edits)) {
            return false;
        }
        let (configuration, scale) = (self.world.configuration(), Scale::new(&self.world, photons));
        self.shapes.learn(configuration);
        let lamps = configuration.lamp_slots();
        let now = Reconstruction::new(&self.shapes, configuration, self.light.buckets(), &scale, lamps).median_error();
        if now <= error {
            self.enough = Some((photons, error, self.edits));
            return false;
        }
        // Noise falls with the root of the number of photons.
        self.goal = (photons as f64 * (now / error).powi(2).clamp(1.0 + 1.0 / MORE as f64, 2.0)).ceil() as u64;
        true
    }

    /// Shoots or repairs for the time of an iteration.
    fn iterate(&mut self, controls: &Controls) {
        let pool = self.settings.pool;
        if let Light::Shooting { shooting, stale: true } = &self.light
            && self.thrown + shooting.photons() < pool.photons() / LITTLE
        {
            self.thrown += shooting.photons();
            self.light = Light::shoot(&self.rules, &self.world);
            self.published = 0;
        }
        // Under edits that keep coming a pool becomes whole all the same: every other iteration shoots.
        self.repaired = self.light.is_wrong() && !(self.repaired && self.light.photons() < pool.photons());
        if self.repaired {
            self.repair(controls);
        } else {
            self.shoot(controls);
        }
        self.news = true;
    }

    fn shoot(&mut self, controls: &Controls) {
        let start = Instant::now();
        let goal = self.goal.max(self.settings.pool.photons());
        match self.light.shoot_more(self.slab, goal) {
            Grown::By(work) => self.work += work,
            Grown::Refused(refused) => return self.go_without_ledger(refused),
            // What there is is the whole pool from now on; so many hits are more than any groups need.
            Grown::Full => {
                self.settings.pool = self.settings.pool.resized(self.light.photons()).unwrap_or(self.settings.pool);
            }
        }
        // What does not fit is foreseen.
        if let Light::Ledger(ledger) = &self.light
            && let Err(refused) = ledger.admits(self.settings.pool.photons())
        {
            return self.go_without_ledger(refused);
        }
        self.light.finish(self.settings.pool, &self.world);
        // A slab takes an iteration: half to one and a half.
        if start.elapsed() < controls.iteration / 2 {
            self.slab = (self.slab * 2).min(Shooting::SLAB);
        } else if start.elapsed() > controls.iteration * 3 / 2 {
            self.slab = (self.slab / 2).max(Shooting::LEAST);
        }
    }

    fn repair(&mut self, controls: &Controls) {
        let start = Instant::now();
        while start.elapsed() < controls.iteration {
            let moving = self.edited.is_some_and(|edited| edited.elapsed() < RECENT);
            let visible_first = match controls.order {
                Order::Adaptive => !moving && !matches!(self.light, Light::Ledger(_)),
                Order::Shuffled => false,
                Order::Urgent => true,
            };
            let work = match &mut self.light {
                Light::Shooting { .. } => Ok(None),
                Light::Groups(solution) if visible_first => solution.repair_next().map(|next| next.map(|repaired| repaired.work)),
                Light::Groups(solution) => solution.repair_shuffled().map(|next| next.map(|repaired| repaired.work)),
                Light::Ledger(ledger) => {
                    if self.view.is_some() {
                        ledger.watch();
                    }
                    if visible_first && !ledger.scan(SCAN) {
                        continue;
                    }
                    if let (true, Some(view)) = (visible_first, self.view)
                        && self.looked.is_none_or(|(last, when)| last != view && when.elapsed() > LOOK)
                    {
                        ledger.look(&Visible::new(&self.world, &view).importance(&self.world));
                        self.looked = Some((view, Instant::now()));
                    }
                    ledger.repair_next().map(|next| next.map(|mended| mended.work))
                }
            };
            let work = match work {
                Ok(Some(work)) => work,
                Ok(None) => break,
                // Brighter than so many photons can be counted in: shot anew, as many as can be.
                Err(full) => {
                    self.refused = Some(full.into());
                    self.light = Light::shoot(&self.rules, &self.world);
                    (self.published, self.goal) = (0, self.settings.pool.photons());
                    return;
                }
            };
            self.work += work;
            if let Light::Ledger(ledger) = &self.light
                && ledger.is_too_large()
            {
                let (photons, needed, limit) = (ledger.photons(), ledger.bytes(), self.settings.ledger_bytes);
                return self.go_without_ledger(Refused::Memory { photons, needed, limit });
            }
        }
    }

    /// Whether the next snapshot is awaited and worth its while. Exact light is always: somebody may wait for it.
    fn is_due(&self) -> bool {
        let published = lock(&self.shared.published);
        let photons = self.light.photons();
        let Some(last) = &published.light else { return photons > 0 };
        if self.outstanding() == 0 && !(last.exact && last.edits == self.edits) {
            return true;
        }
        let more = self.light.is_wrong() || photons * MORE >= self.published * (MORE + 1);
        published.taken && photons > 0 && more
    }

    fn publish(&mut self, controls: &Controls) {
        let (outstanding_photons, photons) = (self.outstanding(), self.light.photons());
        let method = match &self.light {
            Light::Ledger(ledger) => Method::Ledger { bytes: ledger.bytes() },
            light => Method::Groups { stale: light.stale_groups(self.settings.pool), refused: self.refused },
        };
        let pending = match &self.light {
            Light::Ledger(ledger) if outstanding_photons > 0 && photons >= self.settings.pool.photons() => ledger.pending(),
            _ => None,
        };
        let snapshot = Arc::new(Snapshot {
            world: self.world.clone(),
            buckets: self.light.buckets().clone(),
            scale: Scale::new(&self.world, photons),
            photons,
            pool_photons: self.settings.pool.photons(),
            method,
            outstanding_photons,
            pending,
            grows: outstanding_photons == 0 && self.grows(controls),
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
