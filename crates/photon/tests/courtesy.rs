//! A courteous solver's threads give way, and no others. Alone in its process, so that all threads are known.
#![cfg(target_os = "linux")]

use lightmend_photon::{
    halton::Scrambling,
    path::FirstHits,
    pool::Pool,
    solver::{Controls, Settings, Solver},
};
use lightmend_scene::{Configuration, Scene};
use std::{collections::BTreeMap, path::Path, time::Duration};

/// The niceness of each thread of this process, by thread id, with its name.
fn threads() -> BTreeMap<u32, (String, i64)> {
    let read = |entry: std::io::Result<std::fs::DirEntry>| {
        let entry = entry.ok()?;
        let stat = std::fs::read_to_string(entry.path().join("stat")).ok()?;
        let (name, fields) = stat.split_once('(')?.1.rsplit_once(") ")?;
        // proc(5): field 19; the first after the name is field 3.
        let nice = fields.split(' ').nth(16)?.parse().ok()?;
        Some((entry.file_name().to_str()?.parse().ok()?, (name.to_owned(), nice)))
    };
    std::fs::read_dir("/proc/self/task").unwrap().filter_map(read).collect()
}

#[test]
fn only_the_threads_of_a_courteous_solver_give_way() {
    let cornell = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell/cornell.ron");
    let home = Configuration::initial(&Scene::read(&cornell).unwrap().0);
    let before = threads();
    for courteous in [false, true] {
        let pool = Pool::new(50_000, 288, 16, Scrambling::Seed(1)).unwrap();
        let settings = Settings {
            pool,
            first_hits: FirstHits::AsLampsSay,
            ledger_bytes: 1 << 30,
            threads: 2,
            courteous,
            controls: Controls::default(),
        };
        let solver = Solver::start(home.clone(), settings).unwrap();
        solver.wait_until_exact();
        // A thread's name and priority are set by itself, when it first runs.
        std::thread::sleep(Duration::from_millis(100));
        let during = threads();
        let own: Vec<_> = during.iter().filter(|(id, _)| !before.contains_key(id)).map(|(_, thread)| thread).collect();
        assert_eq!(own.len(), 3, "{own:?}");
        assert!(own.iter().all(|(name, nice)| name.starts_with("light-") && (*nice == 19) == courteous), "{own:?}");
        assert!(before.iter().all(|(id, thread)| during.get(id).is_none_or(|now| now == thread)), "{before:?} {during:?}");
        drop(solver);
    }
}
