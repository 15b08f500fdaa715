//! The solver in the background: takes edits, cameras and controls without blocking its caller, and publishes snapshots.
//!
//! The user never waits: an edit replaces the wanted configuration and returns; the worker notices it between two groups, so a row
//! of edits costs one re-trace to the newest pose. The user sets how long an iteration takes and how many there are to a frame, after
//! which a snapshot is published (Dmitriev et al. 2002, §3). What the worker does with its time: `solver/worker.rs`.
//!
//! A snapshot that nobody took is not replaced until the light comes to rest. One that is held shares the pages of buckets that have not
//! changed since: it costs a copy of those that have.
//!
//! Wrong photons are found by a [ledger](crate::ledger) where memory allows and anything can be moved, else by the seed's groups.
//! While nothing is wrong the pool may grow: its first photons are those of the smaller pool, so that light only sharpens.

mod light;
mod worker;

use crate::{
    bucket::Buckets,
    courtesy,
    irradiance::Scale,
    ledger::{Pending, Refused},
    path::FirstHits,
    pool::Pool,
    shooting::Work,
    world::World,
};
use lightmend_scene::{Configuration, View};
use std::{
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    thread::JoinHandle,
    time::Duration,
};

/// What the solver is made with.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// The photons that are shot at once, and how they are grouped; [`Controls::error`] may ask for more.
    pub pool: Pool,
    /// Bytes that a ledger of paths may take (see [`crate::ledger`]): some 27 for a photon at a reflectance of 0.5. If the pool needs
    /// more, or the scene has nothing movable, it is repaired the stateless way; growth stops where they are full.
    pub ledger_bytes: u64,
    /// Which hits deposit.
    pub first_hits: FirstHits,
    /// Threads that trace.
    pub threads: usize,
    /// Whether these threads give way to all others of the process: on Linux they get the lowest priority (nice 19), elsewhere nothing.
    pub courteous: bool,
    /// How it begins to work.
    pub controls: Controls,
}

/// How the solver works; can change while it does.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Controls {
    /// Nothing is traced. Edits and cameras are taken up all the same: snapshots say what is stale, and the light of lamps that were
    /// dimmed is worth what it is now.
    pub paused: bool,
    /// Which stale group comes next.
    pub order: Order,
    /// Time of an iteration: edits and cameras are taken up between two. Longer: more photons a second; shorter: light follows an edit
    /// sooner. 5 to 20 ms do well. At least one group is repaired in each.
    pub iteration: Duration,
    /// The pool grows while nothing is wrong, until the [`median_error`](crate::reconstruction::Reconstruction::median_error) of the light is no more than this, or the
    /// ledger is full. `None`: it stays as large as it was begun. 0.01 takes some ten times the seed's pool.
    pub error: Option<f64>,
    /// Iterations per frame: a snapshot is published after so many, if the last one was taken, or when there is nothing left to do. At least 1.
    pub iterations: u32,
}

impl Default for Controls {
    fn default() -> Self {
        Controls { paused: false, order: Order::default(), iteration: Duration::from_millis(10), error: None, iterations: 2 }
    }
}

/// The order in which wrong photons are repaired. The light in the end is the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Order {
    /// Groups by V·P: Algorithm 1 (Dmitriev et al. 2002, §5.2); with a ledger, what the camera sees first, once all is scanned.
    Urgent,
    /// In a fixed pseudo-random order, going round.
    Shuffled,
    /// With a ledger `Shuffled`: what was repaired then tells what is [expected](Snapshot::expected) of the rest. Without, `Shuffled` while edits keep
    /// coming, `Urgent` when they have rested for 0.3 s. Under a drag, taking back visible old light first looks worse: on average 0.80 of
    /// the change was outstanding then, against 0.51.
    #[default]
    Adaptive,
}

/// How photons that an edit made wrong are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// By the records of their paths.
    Ledger {
        /// Memory of the records.
        bytes: u64,
    },
    /// Group by group, by pilots.
    Groups {
        /// Groups that still hold light of an earlier configuration.
        stale: usize,
        /// Why there is no ledger, if one was wanted.
        refused: Option<Refused>,
    },
}

/// The light as it was known at one moment.
pub struct Snapshot {
    /// What the light is being repaired for.
    pub world: Arc<World>,
    /// Its light.
    pub buckets: Buckets,
    /// What energy is worth, with the lamps of `world`.
    pub scale: Scale,
    /// Photons shot.
    pub photons: u64,
    /// Photons that were wanted at once: more than `photons` while the pool is shot for the first time, less when it has grown.
    pub pool_photons: u64,
    /// How wrong photons are found.
    pub method: Method,
    /// Photons that may hold light of an earlier configuration, and those of the pool that were not shot yet.
    pub outstanding_photons: u64,
    /// What the repair will still bring, as far as it can be told: with a ledger and a whole pool, while somebody [looks](Solver::look).
    pub pending: Option<Pending>,
    /// Whether more photons than the pool's will be shot once nothing is wrong.
    pub grows: bool,
    /// What was done since the solver was started.
    pub work: Work,
    /// The number of the last [`edit`](Solver::edit) or [`start_over`](Solver::start_over) that `world` reflects; 0 before the first.
    pub edits: u64,
    /// Whether this is to the bit what a fresh solution of `configuration` with `photons` photons gives: nothing is outstanding.
    pub exact: bool,
}

impl Snapshot {
    /// The configuration that the light is being repaired for.
    pub fn configuration(&self) -> &Configuration {
        self.world.configuration()
    }

    /// What to show of the light: what is [expected](Pending::expected) of it once all is repaired; the same as `buckets` when it is `exact`,
    /// and without a ledger. Copies all that changed since the repair began: some milliseconds for 10⁵ mesh elements.
    pub fn expected(&self) -> Buckets {
        self.pending.as_ref().map_or_else(|| self.buckets.clone(), |pending| pending.expected(&self.buckets))
    }
}

#[derive(Clone)]
struct Wanted {
    configuration: Configuration,
    /// Calls of `edit` and `start_over`.
    edits: u64,
    /// Which of them was the last `start_over`.
    started_over: u64,
    view: Option<View>,
    controls: Controls,
    /// Callers in `wait_until_exact`: while there are any, a pause does not count.
    waiting: u32,
    stop: bool,
    /// Counts everything that the worker must wake up for.
    version: u64,
}

#[derive(Default)]
struct Published {
    light: Option<Arc<Snapshot>>,
    taken: bool,
}

struct Shared {
    wanted: Mutex<Wanted>,
    changed: Condvar,
    published: Mutex<Published>,
    news: Condvar,
}

impl Shared {
    /// Changes what is wanted and wakes the worker.
    fn want<T>(&self, change: impl FnOnce(&mut Wanted) -> T) -> T {
        let mut wanted = lock(&self.wanted);
        let result = change(&mut wanted);
        wanted.version += 1;
        self.changed.notify_all();
        result
    }
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
        let give_way = move || {
            if settings.courteous {
                courtesy::give_way(courtesy::WHOLLY);
            }
        };
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(settings.threads)
            .thread_name(|n| format!("light-{n}"))
            .start_handler(move |_| give_way())
            .build()
            .map_err(std::io::Error::other)?;
        let wanted = Wanted {
            configuration: configuration.clone(),
            edits: 0,
            started_over: 0,
            view: None,
            controls: settings.controls,
            waiting: 0,
            stop: false,
            version: 0,
        };
        let shared = Arc::new(Shared {
            wanted: Mutex::new(wanted),
            changed: Condvar::new(),
            published: Mutex::default(),
            news: Condvar::new(),
        });
        let worker = {
            let shared = shared.clone();
            std::thread::Builder::new().name("light-solver".into()).spawn(move || {
                give_way();
                pool.install(|| worker::work(&shared, &configuration, &settings));
            })?
        };
        Ok(Solver { shared, worker: Some(worker) })
    }

    /// From now on the light of `configuration` is wanted. Returns at once; the number of this call (see [`Snapshot::edits`]).
    ///
    /// What was shot is repaired before more is. Without a ledger, while the pool is shot for the first time: if little was shot (an eighth of the pool, with what earlier edits threw away), the
    /// shooting begins again; otherwise it goes on where it began and is repaired afterwards. So edits that keep coming cost an eighth of a pool at most.
    pub fn edit(&self, configuration: Configuration) -> u64 {
        self.shared.want(|wanted| {
            wanted.configuration = configuration;
            wanted.edits += 1;
            wanted.edits
        })
    }

    /// Throws the light away and shoots the pool anew at the wanted configuration; a paused solver stays dark until it goes on. Returns
    /// at once; the number of this call (see [`Snapshot::edits`]).
    pub fn start_over(&self) -> u64 {
        self.shared.want(|wanted| {
            wanted.edits += 1;
            wanted.started_over = wanted.edits;
            wanted.edits
        })
    }

    /// From now on it works like this. Returns at once.
    pub fn control(&self, controls: Controls) {
        self.shared.want(|wanted| wanted.controls = controls);
    }

    /// How it works.
    pub fn controls(&self) -> Controls {
        lock(&self.shared.wanted).controls
    }

    /// From now on the light is looked at from here. Returns at once.
    pub fn look(&self, view: View) {
        lock(&self.shared.wanted).view = Some(view);
    }

    /// Where the light is looked at from.
    pub fn view(&self) -> Option<View> {
        lock(&self.shared.wanted).view
    }

    /// The latest light; `None` until the first photons have landed (a solver that starts paused is dark instead). Taking it asks for the next one: after a while in which nobody
    /// did, it is as old as that, unless the light has come to rest.
    pub fn snapshot(&self) -> Option<Arc<Snapshot>> {
        let mut published = lock(&self.shared.published);
        published.taken = true;
        published.light.clone()
    }

    /// Waits until the light of the wanted configuration is exact. While somebody waits here, a pause does not count: the work is
    /// done, and the solver pauses again.
    pub fn wait_until_exact(&self) -> Arc<Snapshot> {
        let edits = self.shared.want(|wanted| {
            wanted.waiting += 1;
            wanted.edits
        });
        let mut published = lock(&self.shared.published);
        let light = loop {
            if let Some(light) = published.light.as_ref().filter(|light| light.exact && light.edits >= edits) {
                break light.clone();
            }
            published = self.shared.news.wait(published).unwrap_or_else(PoisonError::into_inner);
        };
        drop(published);
        self.shared.want(|wanted| wanted.waiting -= 1);
        light
    }
}

impl Drop for Solver {
    fn drop(&mut self) {
        self.shared.want(|wanted| wanted.stop = true);
        if let Some(worker) = self.worker.take()
            && let Err(panic) = worker.join()
            && !std::thread::panicking()
        {
            std::panic::resume_unwind(panic);
        }
    }
}
