//! The solver's light made ready for the rasteriser, by a thread of its own: reading the buckets takes longer than a frame may.
//!
//! It sleeps while the light is exact and nothing changes.

use super::{
    recovery::{REST, Recovery, Trace},
    session::Start,
};
use crate::{
    failure::Failure,
    frames::Show,
    indirect::{IndirectLight, drawn},
    masking::Maskings,
    onlooker::{Onlooker, TOLERATED_FORESEEN},
};
use lightmend_photon::{
    body::TreePreset,
    bucket::Buckets,
    courtesy::give_way,
    irradiance::Scale,
    path::FirstHits,
    pool::Pool,
    solution::Solution,
    solver::{Snapshot, Solver},
    world::World,
};
use lightmend_raster::Indirect;
use lightmend_scene::{Configuration, View};
use std::{
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    thread::JoinHandle,
    time::{Duration, Instant},
};

/// Light that can be drawn, and what is known of it.
pub struct Ready {
    /// What it was read from.
    pub snapshot: Arc<Snapshot>,
    /// For the renderer.
    pub indirect: Indirect,
    /// The estimated median of the relative error of indirect illuminance.
    pub median_error: f64,
    /// Whether, as far as can be foreseen, nobody who looks from here will see the rest of the repair.
    pub complete_for_the_eye: bool,
    /// How the last edit is being repaired.
    pub trace: Trace,
}

#[derive(Clone)]
struct Wanted {
    configuration: Configuration,
    edits: u64,
    /// When the last of them was.
    edited: Instant,
    /// Counts actions: a drag is one.
    action: u64,
    view: View,
    show: Show,
    stop: bool,
    /// Counts the changes of all this.
    version: u64,
}

struct Shared {
    wanted: Mutex<Wanted>,
    changed: Condvar,
    ready: Mutex<Option<Arc<Ready>>>,
}

/// Reads the solver's light in the background.
pub struct LightReader {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

/// The reader holds a lock only to copy; what it left is whole.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// How much its threads give way: between those that draw and those that trace.
const HALFWAY: i32 = 10;

/// While light is repaired it is looked for this often.
const OFTEN: Duration = Duration::from_millis(25);

/// Share of its time that the thread reads, at most: the rest is for frames and photons.
const BUSY: u32 = 4;

impl LightReader {
    /// Reads the light of `solver`, which was started so. `wake` is called whenever something new is ready.
    pub fn start(
        solver: Arc<Solver>,
        start: Start,
        configuration: Configuration,
        view: View,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Result<LightReader, Failure> {
        let wanted = Wanted {
            configuration,
            edits: 0,
            edited: Instant::now(),
            action: 0,
            view,
            show: Show::Radiance,
            stop: false,
            version: 0,
        };
        let shared = Arc::new(Shared { wanted: Mutex::new(wanted), changed: Condvar::new(), ready: Mutex::new(None) });
        let fault = |e: &dyn std::fmt::Display| Failure::failed(format!("threads cannot be started: {e}"));
        // Drawing comes first, then this, then photons.
        let threads = rayon::ThreadPoolBuilder::new()
            .num_threads(start.threads)
            .start_handler(|_| give_way(HALFWAY))
            .build()
            .map_err(|e| fault(&e))?;
        let thread = {
            let shared = shared.clone();
            let read = move || threads.install(|| Reader::new(&shared, &solver, start.pool).run(&wake));
            std::thread::Builder::new().name("lightmend-light".into()).spawn(read).map_err(|e| fault(&e))?
        };
        Ok(LightReader { shared, thread: Some(thread) })
    }

    fn want(&self, change: impl FnOnce(&mut Wanted)) {
        let mut wanted = lock(&self.shared.wanted);
        change(&mut wanted);
        wanted.version += 1;
        self.shared.changed.notify_all();
    }

    /// An action begins: from here on its change is measured.
    pub fn begins(&self) {
        self.want(|wanted| wanted.action += 1);
    }

    /// The scene is now this; the solver calls it number `edits`.
    pub fn edited(&self, configuration: &Configuration, edits: u64) {
        self.want(|wanted| {
            (wanted.configuration, wanted.edits, wanted.edited) = (configuration.clone(), edits, Instant::now());
        });
    }

    /// The solver was told something else: to go on, to start over.
    pub fn nudge(&self) {
        self.want(|_| {});
    }

    /// Looked at from here.
    pub fn looks(&self, view: View) {
        // Where one looks from changes no light: nothing is read anew for it.
        lock(&self.shared.wanted).view = view;
    }

    /// What is drawn.
    pub fn show(&self, show: Show) {
        self.want(|wanted| wanted.show = show);
    }

    /// The newest light.
    pub fn ready(&self) -> Option<Arc<Ready>> {
        lock(&self.shared.ready).clone()
    }
}

impl Drop for LightReader {
    fn drop(&mut self) {
        lock(&self.shared.wanted).stop = true;
        self.shared.changed.notify_all();
        if let Some(thread) = self.thread.take()
            && let Err(panic) = thread.join()
            && !std::thread::panicking()
        {
            std::panic::resume_unwind(panic);
        }
    }
}

/// The thread's own.
struct Reader<'a> {
    shared: &'a Shared,
    solver: &'a Solver,
    pool: Pool,
    light: IndirectLight,
    recovery: Recovery,
    maskings: Maskings,
    /// Who looks at which world from where, and whether it was foreseen to be complete at the last look.
    onlooker: Option<(Arc<World>, View, Onlooker, bool)>,
    /// When it was estimated last.
    median_error: (Option<Instant>, f64),
    /// For what is still wrong: a pool shot at the newest scene.
    exact: Option<Solution>,
}

impl<'a> Reader<'a> {
    fn new(shared: &'a Shared, solver: &'a Solver, pool: Pool) -> Reader<'a> {
        Reader {
            shared,
            solver,
            pool,
            light: IndirectLight::default(),
            recovery: Recovery::default(),
            maskings: Maskings::new(),
            onlooker: None,
            median_error: (None, 0.0),
            exact: None,
        }
    }

    fn run(&mut self, wake: &dyn Fn()) {
        let mut last: Option<(u64, Arc<Snapshot>)> = None;
        loop {
            let wanted = lock(&self.shared.wanted).clone();
            if wanted.stop {
                return;
            }
            let start = Instant::now();
            let mut rest = OFTEN;
            let snapshot = self.solver.snapshot();
            let known =
                |s: &Arc<Snapshot>| last.as_ref().is_some_and(|(version, l)| *version == wanted.version && Arc::ptr_eq(l, s));
            if let Some(snapshot) = snapshot.filter(|s| !known(s)) {
                let ready = self.read(&wanted, snapshot.clone());
                // Nobody waits at the lock while the old one is freed.
                let old = lock(&self.shared.ready).replace(Arc::new(ready));
                drop(old);
                wake();
                // What is still wrong is not known until its comparison was shot.
                let known = wanted.show != Show::Stale || self.compared_with(&wanted.configuration, snapshot.photons);
                last = known.then_some((wanted.version, snapshot));
                rest = rest.max(start.elapsed() * (BUSY - 1));
            }
            let settled = last.as_ref().is_some_and(|(version, s)| {
                let rests = (s.exact && !s.grows) || self.solver.controls().paused;
                *version == wanted.version && rests && s.edits >= wanted.edits
            });
            let now = lock(&self.shared.wanted);
            if settled && now.version == wanted.version && !now.stop {
                drop(self.shared.changed.wait(now));
            } else if !now.stop {
                // Not cut short by every step of a drag.
                drop(now);
                std::thread::sleep(rest);
            }
        }
    }

    fn read(&mut self, wanted: &Wanted, snapshot: Arc<Snapshot>) -> Ready {
        let configuration = &wanted.configuration;
        // Dimming shows at once, whatever the solver is at. New lamps have no light yet.
        let world = &snapshot.world;
        let same_lamps = world.configuration().lamp_slots() == configuration.lamp_slots();
        let scale = match same_lamps {
            true => Scale::new(&world.moved_to(configuration), snapshot.photons),
            false => Scale::new(world, snapshot.photons),
        };
        let lamps = world.configuration().lamp_slots().min(configuration.lamp_slots());
        let expected = snapshot.expected();
        let indirect = match wanted.show {
            Show::Elements => Vec::new(),
            Show::Stale => match self.exact(wanted, snapshot.photons) {
                Some(exact) => {
                    let right = (exact.buckets().clone(), Scale::new(exact.world(), exact.pool().photons()));
                    self.light.outstanding(configuration, (&expected, &scale), (&right.0, &right.1), lamps)
                }
                None => Vec::new(),
            },
            _ => {
                let light = self.light.reconstruct(configuration, &expected, &scale, lamps);
                // It changes slowly, and all elements are sorted for it.
                if self.median_error.0.is_none_or(|at| at.elapsed() > Duration::from_millis(700) || snapshot.exact) {
                    self.median_error = (Some(Instant::now()), light.median_error());
                }
                drawn(configuration, &light)
            }
        };
        let current = snapshot.edits >= wanted.edits;
        let complete_for_the_eye =
            wanted.edited.elapsed() > REST && self.is_complete_for_the_eye(wanted.view, &snapshot, &expected);
        let seen = (&snapshot, &expected, &scale);
        let trace = self.recovery.look(wanted.action, wanted.edited, current, complete_for_the_eye, wanted.view, seen);
        Ready { snapshot, indirect, median_error: self.median_error.1, complete_for_the_eye, trace }
    }

    /// Whether what a repair will still bring will not be seen.
    fn is_complete_for_the_eye(&mut self, view: View, snapshot: &Snapshot, expected: &Buckets) -> bool {
        let Some(pending) = &snapshot.pending else {
            self.onlooker = None;
            return false;
        };
        let Snapshot { world, buckets, scale, .. } = snapshot;
        let known = self.onlooker.take().filter(|(known, from, ..)| Arc::ptr_eq(known, world) && *from == view);
        let look = || (world.clone(), view, Onlooker::new(world, &view, &mut self.maskings), false);
        let (.., onlooker, foreseen) = self.onlooker.insert(known.unwrap_or_else(look));
        let now = onlooker.shown(&mut self.light, world.configuration(), expected, scale);
        let share = onlooker.foreseen(&mut self.light, world.configuration(), (buckets, &now, pending), scale);
        std::mem::replace(foreseen, share.is_some_and(|share| share <= TOLERATED_FORESEEN)) && *foreseen
    }

    /// Whether the pool that light is compared with was shot at this scene and is of this size.
    fn compared_with(&self, configuration: &Configuration, photons: u64) -> bool {
        self.exact.as_ref().is_some_and(|s| s.world().configuration() == configuration && s.pool().photons() == photons)
    }

    /// A pool of so many photons shot at the newest scene once nothing moves: what the repair comes to in the end.
    fn exact(&mut self, wanted: &Wanted, photons: u64) -> Option<&Solution> {
        if !self.compared_with(&wanted.configuration, photons) && wanted.edited.elapsed() > Duration::from_millis(200) {
            let world = Arc::new(World::new(&wanted.configuration, TreePreset::default()));
            let stopped = || {
                let now = lock(&self.shared.wanted);
                now.stop || now.edits != wanted.edits || now.show != Show::Stale
            };
            // The same groups for any number of photons.
            self.exact = self
                .pool
                .grown(photons)
                .shrunk(photons)
                .and_then(|pool| Solution::shoot(pool, world, FirstHits::AsLampsSay, &mut |_, _| !stopped()))
                .filter(|s| s.pool().photons() == photons);
        }
        self.exact.as_ref().filter(|_| self.compared_with(&wanted.configuration, photons))
    }
}
