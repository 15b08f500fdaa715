//! The solver in the background: takes edits and cameras without blocking its caller, and publishes snapshots.
//!
//! The user never waits: an edit replaces the wanted configuration and returns; the worker notices it between two groups, so a row
//! of edits costs one re-trace to the newest pose. The user sets how long an iteration takes and how many there are to a frame, after which a
//! snapshot is published (Dmitriev et al. 2002, §3).

use crate::{
    body::TreePreset, bucket::Buckets, irradiance::Scale, path::FirstHits, pool::Pool, solution::Solution, visible::Frustum,
    world::World,
};
use lightmend_scene::{Configuration, View};
use std::{
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    thread::JoinHandle,
    time::{Duration, Instant},
};

/// How the solver works.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// The photons.
    pub pool: Pool,
    /// Which hits deposit.
    pub first_hits: FirstHits,
    /// Time of an iteration: edits and cameras are taken up between two. Longer: more photons a second; shorter: light follows an edit
    /// sooner. 5 to 20 ms do well.
    pub iteration: Duration,
    /// Iterations per frame: a snapshot is published after so many, or when nothing is stale. At least 1.
    pub iterations: u32,
    /// Threads that trace.
    pub threads: usize,
}

/// The light as it was known at one moment.
pub struct Snapshot {
    /// The configuration that the light is being repaired for.
    pub configuration: Configuration,
    /// Its light.
    pub buckets: Buckets,
    /// What energy is worth.
    pub scale: Scale,
    /// Photons shot.
    pub photons: u64,
    /// Groups repaired since the snapshot before.
    pub repaired_groups: u32,
    /// Groups that still hold light of an earlier configuration.
    pub stale_groups: usize,
    /// Whether this is to the bit what a fresh solution of `configuration` gives.
    pub exact: bool,
}

/// Width of pictures over their height, for what a camera may see.
const ASPECT: f64 = 16.0 / 9.0;

struct Wanted {
    configuration: Configuration,
    view: Option<View>,
    stop: bool,
}

struct Shared {
    wanted: Mutex<Wanted>,
    changed: Condvar,
    snapshot: Mutex<Option<Arc<Snapshot>>>,
    published: Condvar,
}

/// A pool of photons that is kept right for a scene that changes.
pub struct Solver {
    shared: Arc<Shared>,
    worker: Option<JoinHandle<()>>,
}

/// The worker never panics while it holds a lock; were it to, what it left is still whole.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Solver {
    /// Starts to solve `configuration` in the background. Errors if threads cannot be made.
    pub fn start(configuration: Configuration, settings: Settings) -> std::io::Result<Solver> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.threads).build().map_err(std::io::Error::other)?;
        let shared = Arc::new(Shared {
            wanted: Mutex::new(Wanted { configuration: configuration.clone(), view: None, stop: false }),
            changed: Condvar::new(),
            snapshot: Mutex::new(None),
            published: Condvar::new(),
        });
        let worker = {
            let shared = shared.clone();
            std::thread::Builder::new()
                .name("lightmend-solver".into())
                .spawn(move || pool.install(|| work(&shared, configuration, settings)))?
        };
        Ok(Solver { shared, worker: Some(worker) })
    }

    /// From now on the light of `configuration` is wanted. Returns at once.
    pub fn edit(&self, configuration: Configuration) {
        lock(&self.shared.wanted).configuration = configuration;
        self.shared.changed.notify_all();
    }

    /// From now on the light is looked at from here. Returns at once.
    pub fn look(&self, view: View) {
        lock(&self.shared.wanted).view = Some(view);
    }

    /// Where the light is looked at from.
    pub fn view(&self) -> Option<View> {
        lock(&self.shared.wanted).view
    }

    /// The latest light; `None` until the first photons have landed.
    pub fn snapshot(&self) -> Option<Arc<Snapshot>> {
        lock(&self.shared.snapshot).clone()
    }

    /// Waits until the light of the wanted configuration is exact.
    pub fn wait_until_exact(&self) -> Arc<Snapshot> {
        let wanted = lock(&self.shared.wanted).configuration.clone();
        let mut snapshot = lock(&self.shared.snapshot);
        loop {
            if let Some(light) = snapshot.as_ref()
                && light.exact
                && light.configuration == wanted
            {
                return light.clone();
            }
            snapshot = self.shared.published.wait(snapshot).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl Drop for Solver {
    fn drop(&mut self) {
        lock(&self.shared.wanted).stop = true;
        self.shared.changed.notify_all();
        if let Some(worker) = self.worker.take()
            && let Err(panic) = worker.join()
            && !std::thread::panicking()
        {
            std::panic::resume_unwind(panic);
        }
    }
}

fn work(shared: &Shared, configuration: Configuration, settings: Settings) {
    let mut world = Arc::new(World::new(&configuration, TreePreset::default()));
    let stopped = || lock(&shared.wanted).stop;
    let Some(mut solution) = Solution::shoot(settings.pool, world.clone(), settings.first_hits, &mut |_, _| !stopped()) else {
        return; // stopped before enough photons were shot
    };
    let mut repaired = 0;
    loop {
        publish(shared, &solution, repaired);
        repaired = 0;
        let mut wanted = lock(&shared.wanted);
        while solution.stale_groups() == 0 && !wanted.stop && wanted.configuration == *world.configuration() {
            wanted = shared.changed.wait(wanted).unwrap_or_else(PoisonError::into_inner);
        }
        drop(wanted);
        for _ in 0..settings.iterations.max(1) {
            let (stop, configuration, view) = {
                let wanted = lock(&shared.wanted);
                (wanted.stop, wanted.configuration.clone(), wanted.view)
            };
            if stop {
                return;
            }
            if let Some(view) = view {
                solution.look(Some(Frustum::new(&view, configuration.scene().up, ASPECT)));
            }
            if configuration != *world.configuration() {
                world = Arc::new(world.moved_to(&configuration));
                solution.change(world.clone());
            }
            let iteration = Instant::now();
            while iteration.elapsed() < settings.iteration && solution.repair_next().is_some() {
                repaired += 1;
            }
        }
    }
}

fn publish(shared: &Shared, solution: &Solution, repaired_groups: u32) {
    let configuration = solution.world().configuration().clone();
    let photons = solution.pool().photons();
    let stale_groups = solution.stale_groups();
    let snapshot = Snapshot {
        scale: Scale::new(solution.world(), photons),
        configuration,
        buckets: solution.buckets().clone(),
        photons,
        repaired_groups,
        stale_groups,
        exact: stale_groups == 0,
    };
    *lock(&shared.snapshot) = Some(Arc::new(snapshot));
    shared.published.notify_all();
}
