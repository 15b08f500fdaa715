//! What is not saved yet is kept in a file beside the scene's, so that nothing is lost when the program ends in a bad way.
//!
//! Written beside its place and renamed, by a thread of its own: the disk never holds up a frame, and a file is never half-written. The
//! scene's own file is not touched by it.

use lightmend_scene::Configuration;
use std::{
    path::{Path, PathBuf},
    sync::mpsc::{Receiver, Sender, channel},
    thread::JoinHandle,
    time::{Duration, Instant},
};

/// Changes are kept this long after the last of them, so that a drag is not written step by step.
const QUIET: Duration = Duration::from_millis(400);

/// And at least so often while they go on.
const LONGEST: Duration = Duration::from_millis(1500);

enum Order {
    Write(Configuration),
    Remove,
}

/// Keeps changes.
pub struct Autosave {
    path: PathBuf,
    orders: Option<Sender<Order>>,
    results: Receiver<Result<(), String>>,
    /// Orders that nobody has told the end of; several may be done as one.
    under_way: bool,
    writer: Option<JoinHandle<()>>,
    first_change: Option<Instant>,
    last_change: Instant,
    /// The file holds what was kept of an earlier run, and nobody has said yet what is to become of that.
    asked: bool,
}

/// The autosave of an earlier run beside the scene file at `scene`, if it holds anything else than that.
pub fn earlier(scene: &Path) -> Option<PathBuf> {
    let autosave = path_beside(scene);
    let differs = std::fs::read(&autosave).ok().is_some_and(|kept| std::fs::read(scene).ok().is_none_or(|file| file != kept));
    differs.then_some(autosave)
}

/// Where the autosave of a scene file is: `room.autosave.ron` beside `room.ron`.
fn path_beside(scene: &Path) -> PathBuf {
    scene.with_extension("autosave.ron")
}

impl Autosave {
    /// For the scene file at `scene`.
    pub fn beside(scene: &Path) -> Autosave {
        let asked = earlier(scene).is_some();
        let path = path_beside(scene);
        let (orders, taken) = channel();
        let (told, results) = channel();
        let writer = {
            let path = path.clone();
            std::thread::spawn(move || {
                while let Ok(order) = taken.recv() {
                    // Only the newest counts.
                    let order = std::iter::successors(Some(order), |_| taken.try_recv().ok()).last();
                    let result = match order {
                        Some(Order::Write(configuration)) => configuration.write(&path).map_err(|e| e.to_string()),
                        Some(Order::Remove) => std::fs::remove_file(&path).or_else(|e| match e.kind() {
                            std::io::ErrorKind::NotFound => Ok(()),
                            _ => Err(format!("{}: cannot be removed: {e}", path.display())),
                        }),
                        None => Ok(()),
                    };
                    // Nobody listens any more at the very end.
                    let _ = told.send(result.map_err(|fault| format!("changes are not kept: {fault}")));
                }
            })
        };
        Autosave {
            path,
            orders: Some(orders),
            results,
            under_way: false,
            writer: Some(writer),
            first_change: None,
            last_change: Instant::now(),
            asked,
        }
    }

    fn order(&mut self, order: Order) {
        if let Some(orders) = &self.orders {
            self.under_way = true;
            // The writer ends only with this end of the channel.
            let _ = orders.send(order);
        }
    }

    /// Whether what was kept of an earlier run waits for an answer.
    pub fn is_asked(&self) -> bool {
        self.asked
    }

    /// What was kept of an earlier run is here now: it may be written over.
    pub fn taken_over(&mut self) {
        self.asked = false;
    }

    /// Something changed.
    pub fn changed(&mut self) {
        self.last_change = Instant::now();
        self.first_change.get_or_insert(self.last_change);
    }

    /// Keeps what changed, when it is time; what went wrong with that.
    pub fn tick(&mut self, configuration: &Configuration, unsaved: bool) -> Option<String> {
        if let Some(first) = self.first_change
            && !self.asked
            && (self.last_change.elapsed() > QUIET || first.elapsed() > LONGEST)
        {
            self.first_change = None;
            self.order(if unsaved { Order::Write(configuration.clone()) } else { Order::Remove });
        }
        let result = self.results.try_recv().ok()?;
        self.under_way = false;
        // What could not be written is tried again.
        result.err().inspect(|_| self.changed())
    }

    /// Whether a change waits to be kept.
    pub fn waits(&self) -> bool {
        (self.first_change.is_some() || self.under_way) && !self.asked
    }

    /// Keeps the changes at once; where they are.
    pub fn write_now(&mut self, configuration: &Configuration) -> Result<PathBuf, String> {
        self.first_change = None;
        self.settle();
        // What was kept before is not written over unasked.
        let numbered = (2..).map(|n| self.path.with_extension(format!("{n}.ron")));
        let path = match self.asked {
            false => self.path.clone(),
            true => numbered.clone().find(|path| !path.exists()).unwrap_or_default(),
        };
        configuration.write(&path).map(|()| path).map_err(|e| e.to_string())
    }

    /// Nothing needs to be kept.
    pub fn remove(&mut self) {
        (self.first_change, self.asked) = (None, false);
        self.order(Order::Remove);
    }

    /// Waits for what was ordered.
    fn settle(&mut self) {
        self.orders = None;
        if let Some(writer) = self.writer.take() {
            // It never panics: what goes wrong is told.
            let _ = writer.join();
        }
    }
}

impl Drop for Autosave {
    fn drop(&mut self) {
        self.settle();
    }
}
