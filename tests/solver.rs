//! The background solver: whatever is asked of it, with a ledger or without, it ends with the bits of a fresh solution of as many photons.

use glam::DVec3;
use lightmend_photon::{
    body::TreePreset,
    irradiance::Scale,
    ledger::Refused,
    path::FirstHits,
    pool::Pool,
    reconstruction::{Reconstruction, Shapes},
    solver::{self, Controls, Method, Settings, Snapshot, Solver},
    world::World,
};
use lightmend_scene::{Configuration, Edit, Moves};
use lightmend_tests::{
    Builder, count,
    edits::{edit, step},
    own_scene, own_scene_path, pool, shoot, world,
};
use proptest::{
    prelude::*,
    strategy::ValueTree,
    test_runner::{RngAlgorithm, TestRng, TestRunner},
};
use std::{
    sync::Arc,
    time::{Duration, Instant},
};

/// No ledger, and one that any of these pools fits in.
const BOTH: [u64; 2] = [0, 1 << 30];

/// Whether `light` is to the bit that of a fresh solution of as many photons.
fn is_that_of_a_fresh_solution(light: &Snapshot) -> bool {
    let world = Arc::new(World::new(light.configuration(), TreePreset::Fast));
    light.exact
        && light.expected() == light.buckets
        && light.buckets == *shoot(pool(light.photons), &world, FirstHits::AsLampsSay).buckets()
}

fn settings(pool: Pool, ledger_bytes: u64, iteration: Duration) -> Settings {
    let controls = Controls { iteration, ..Controls::default() };
    Settings { pool, first_hits: FirstHits::AsLampsSay, ledger_bytes, threads: 2, courteous: false, controls }
}

#[test]
fn the_background_solver_ends_with_the_same_bits() {
    let scene = own_scene("room");
    let (moves, _) = Moves::read(&own_scene_path("room").with_file_name("moves/drag.ron"), &scene).unwrap();
    for ledger_bytes in BOTH {
        let mut configuration = Configuration::initial(&scene);
        let settings = settings(pool(100_000), ledger_bytes, Duration::from_millis(5));
        let solver = Solver::start(configuration.clone(), settings).unwrap();
        for timed in &moves.edits {
            for (_, edit) in timed.edit.steps(&configuration).unwrap() {
                configuration = configuration.apply(&edit).unwrap();
                solver.edit(configuration.clone());
                solver.look(scene.cameras[moves.edits.len() % 2].1);
                std::thread::sleep(Duration::from_millis(3));
            }
        }
        let light = solver.wait_until_exact();
        assert!(*light.configuration() == configuration && light.photons == 100_000);
        assert!(is_that_of_a_fresh_solution(&light));
        assert_eq!(matches!(light.method, Method::Ledger { bytes: 2_000_000.. }), ledger_bytes > 0);
    }
}

#[test]
fn a_caller_that_edits_sixty_times_a_second_drains_to_the_same_bits() {
    // How long the calls take while the solver works on all cores is printed (`--nocapture`): time is no test.
    let scene = own_scene("room");
    for ledger_bytes in BOTH {
        let settings = settings(pool(200_000), ledger_bytes, Duration::from_millis(10));
        let home = Configuration::initial(&scene);
        let solver = Solver::start(home.clone(), settings).unwrap();
        let from = home.object(home.object_id("table").unwrap()).pose.position;
        let mut configuration = home;
        let mut longest: Vec<Duration> = Vec::new();
        for step in 0..count(150, 3600) {
            let to = from + DVec3::X * (0.5 * (step as f64 * 0.05).sin());
            let call = Instant::now();
            configuration = configuration.apply(&Edit::Move { object: "table".into(), to }).unwrap();
            solver.edit(configuration.clone());
            solver.look(scene.cameras[step as usize % 3].1);
            drop(solver.snapshot());
            longest.push(call.elapsed());
            std::thread::sleep(Duration::from_micros(16_667).saturating_sub(call.elapsed()));
        }
        longest.sort();
        let [median, high, worst] = [0.5, 0.999, 1.0].map(|share| longest[(longest.len() as f64 * share) as usize - 1]);
        println!("calls: median {median:?}, 99.9th percentile {high:?}, longest {worst:?}");
        assert!(is_that_of_a_fresh_solution(&solver.wait_until_exact()));
    }
}

#[test]
fn whatever_is_asked_of_the_background_solver_it_ends_with_the_same_bits() {
    let scene = own_scene("room");
    let home = Configuration::initial(&scene);
    for seed in 0..count(4, 40) {
        let mut runner =
            TestRunner::new_with_rng(ProptestConfig::default(), TestRng::from_seed(RngAlgorithm::ChaCha, &[seed as u8; 32]));
        let by = prop::array::uniform3(-0.4f64..0.4);
        let strategy = (0u8..14, step(), any::<prop::sample::Index>(), by, 0u64..6);
        let steps = prop::collection::vec(strategy, 250).new_tree(&mut runner).unwrap().current();
        // None, plenty, one that is full after some growth, one that the pool does not fit in.
        let ledger_bytes = [0, 1 << 30, 3_000_000, 1_000_000][seed as usize % 4];
        let solver = Solver::start(home.clone(), settings(pool(50_000), ledger_bytes, Duration::from_millis(5))).unwrap();
        let mut configuration = home.clone();
        let mut edits = 0;
        for (number, (kind, step, which, by, pause)) in steps.iter().enumerate() {
            let controls = solver.controls();
            match kind {
                0 => solver.control(Controls { paused: !controls.paused, ..controls }),
                1 => {
                    let orders = [solver::Order::Urgent, solver::Order::Shuffled, solver::Order::Adaptive];
                    solver.control(Controls { order: *which.get(&orders), ..controls });
                }
                2 => {
                    let iteration = Duration::from_micros(step.groups as u64 * 50);
                    solver.control(Controls { iteration, iterations: step.groups as u32 % 4, ..controls });
                }
                3 if step.groups < 30 => edits = solver.start_over(),
                4 => solver.control(Controls { error: (by[0] > 0.0).then_some(0.05 + by[1].abs()), ..controls }),
                5 => solver.look(*which.get(&scene.cameras.iter().map(|(_, view)| *view).collect::<Vec<_>>())),
                6 => {
                    let light = solver.snapshot();
                    assert!(light.is_none_or(|light| light.edits <= edits && light.exact == (light.outstanding_photons == 0)));
                }
                _ => {
                    let Ok(next) = configuration.apply(&edit(&configuration, step, number)) else { continue };
                    configuration = next;
                    edits = solver.edit(configuration.clone());
                }
            }
            std::thread::sleep(Duration::from_millis(*pause));
        }
        solver.control(Controls::default());
        let light = solver.wait_until_exact();
        assert!(light.edits == edits && *light.configuration() == configuration);
        assert!(light.photons >= 50_000 && light.outstanding_photons == 0);
        assert!(is_that_of_a_fresh_solution(&light), "seed {seed}, {} photons", light.photons);
        println!("seed {seed}: {} photons, {:?}", light.photons, light.method);
        match light.method {
            Method::Ledger { bytes } => assert!(bytes <= ledger_bytes),
            Method::Groups { refused, .. } => assert_eq!(refused.is_some(), ledger_bytes > 0),
        }
    }
}

/// Takes snapshots until one reflects edit number `edits` and is as wanted.
fn until(solver: &Solver, edits: u64, mut wanted: impl FnMut(&Snapshot) -> bool) -> Arc<Snapshot> {
    loop {
        if let Some(light) = solver.snapshot().filter(|light| light.edits >= edits && wanted(light)) {
            return light;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_paused_solver_counts_what_is_stale_and_reads_dimmed_lamps() {
    for ledger_bytes in BOTH {
        let scene = own_scene("room");
        let home = Configuration::initial(&scene);
        let pool = pool(50_000);
        let solver = Solver::start(home.clone(), settings(pool, ledger_bytes, Duration::from_millis(5))).unwrap();
        let whole = solver.wait_until_exact();
        let is_stale = |light: &Snapshot| match light.method {
            Method::Ledger { .. } => light.outstanding_photons == 50_000,
            Method::Groups { stale, .. } => stale == 288 && light.outstanding_photons == 50_000,
        };
        solver.control(Controls { paused: true, ..solver.controls() });
        let moved = home.apply(&Edit::Turn { object: "table".into(), to: DVec3::Z * 30.0 }).unwrap();
        let light = until(&solver, solver.edit(moved.clone()), |_| true);
        assert!(is_stale(&light) && !light.exact);
        let (lamp, _) = home.lamps().next().unwrap();
        let dim = Edit::Light { lamp: scene.lamps[lamp].name.clone(), intensity: DVec3::splat(7.0) };
        let dimmed = moved.apply(&dim).unwrap();
        let light = until(&solver, solver.edit(dimmed.clone()), |_| true);
        std::thread::sleep(Duration::from_millis(50));
        let later = until(&solver, 2, |_| true);
        assert!(is_stale(&later) && later.work == whole.work, "nothing is traced");
        assert!(later.buckets == whole.buckets);
        assert_eq!(light.scale.lumens(lamp), Scale::new(&World::new(&dimmed, TreePreset::Fast), 50_000).lumens(lamp));
        assert!(light.scale.lumens(lamp) != whole.scale.lumens(lamp));
        // Home again but for the lamp: nothing is stale, nothing was traced.
        let light = until(&solver, solver.edit(home.apply(&dim).unwrap()), |_| true);
        assert!(light.outstanding_photons == 0 && light.exact && light.work == whole.work);
        // Who waits for exact light gets it, though paused; then it is paused again.
        solver.edit(moved.clone());
        let light = solver.wait_until_exact();
        assert!(light.exact && solver.controls().paused && *light.configuration() == moved);
        let light = until(&solver, solver.edit(home), |_| true);
        assert!(is_stale(&light));
        let dark = until(&solver, solver.start_over(), |_| true);
        assert_eq!((dark.photons, dark.outstanding_photons, dark.exact), (0, 50_000, false));
    }
}

#[test]
fn what_a_repair_will_bring_is_told_to_those_who_look() {
    let scene = own_scene("room");
    let start = Configuration::initial(&scene);
    let moved = start.apply(&Edit::Move { object: "table".into(), to: DVec3::new(2.4, 3.0, 0.0) }).unwrap();
    for looks in [false, true] {
        let mut settings = settings(pool(200_000), 1 << 30, Duration::from_millis(1));
        settings.controls.iterations = 1;
        let solver = Solver::start(start.clone(), settings).unwrap();
        if looks {
            solver.look(scene.cameras[0].1);
        }
        assert!(solver.wait_until_exact().pending.is_none(), "nothing is to come");
        // An edit that rests by the time its repair begins.
        solver.control(Controls { paused: true, ..settings.controls });
        let edits = solver.edit(moved.clone());
        until(&solver, edits, |light| light.outstanding_photons > 0);
        std::thread::sleep(Duration::from_millis(100));
        solver.control(settings.controls);
        let mut told = 0;
        let exact = until(&solver, edits, |light| {
            told += u32::from(light.pending.is_some());
            light.exact
        });
        assert!(exact.pending.is_none());
        assert_eq!(told > 0, looks);
    }
}

#[test]
fn the_first_shooting_shows_what_it_has_and_bears_edits() {
    let scene = own_scene("room");
    let home = Configuration::initial(&scene);
    for ledger_bytes in [0, 1 << 44] {
        // More than can be shot in this test.
        let solver = Solver::start(home.clone(), settings(pool(1 << 31), ledger_bytes, Duration::from_millis(5))).unwrap();
        let light = until(&solver, 0, |light| light.photons > 10_000);
        assert!(!light.exact && light.outstanding_photons == light.pool_photons - light.photons && light.photons < 1 << 31);
        let prefix = shoot(pool(light.photons), &world(&scene), FirstHits::AsLampsSay);
        assert!(light.buckets == *prefix.buckets(), "any prefix is the light of a smaller pool");
        let moved = home.apply(&Edit::Turn { object: "table".into(), to: DVec3::Z * 30.0 }).unwrap();
        let right = |light: &Snapshot| light.photons > 5000 && light.outstanding_photons == (1 << 31) - light.photons;
        let light = until(&solver, solver.edit(moved.clone()), right);
        let prefix = shoot(pool(light.photons), &light.world, FirstHits::AsLampsSay);
        assert!(light.buckets == *prefix.buckets());
        // Without a ledger it begins again if little was shot; with one, what was shot is repaired.
        assert!(light.photons < light.work.photons);
        let light = until(&solver, solver.start_over(), |_| true);
        assert_eq!(*light.configuration(), moved);
        let dropping = Instant::now();
        drop(solver);
        println!("dropped in {:?}", dropping.elapsed());

        // Edits without end: it is whole all the same.
        let solver = Solver::start(home.clone(), settings(pool(100_000), ledger_bytes, Duration::from_millis(2))).unwrap();
        for step in 0.. {
            let to = DVec3::Z * f64::from(step);
            solver.edit(home.apply(&Edit::Turn { object: "table".into(), to }).unwrap());
            if solver.snapshot().is_some_and(|light| light.photons == 100_000) {
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        assert!(is_that_of_a_fresh_solution(&solver.wait_until_exact()));
    }
}

#[test]
fn it_grows_until_the_error_is_as_asked_and_stays_exact_under_edits() {
    let scene = own_scene("cornell");
    let home = Configuration::initial(&scene);
    for ledger_bytes in BOTH {
        let settings = settings(pool(50_000), ledger_bytes, Duration::from_millis(5));
        let controls = Controls { error: Some(0.039), ..settings.controls };
        let solver = Solver::start(home.clone(), Settings { controls, ..settings }).unwrap();
        let mut edits = 0;
        for turn in 1..6 {
            until(&solver, edits, |light| light.photons > 40_000 * (turn + 1) || (light.exact && !light.grows));
            let to = DVec3::Z * (10 * turn) as f64;
            edits = solver.edit(home.apply(&Edit::Turn { object: "tall box".into(), to }).unwrap());
            let light = until(&solver, edits, |light| light.exact);
            assert!(is_that_of_a_fresh_solution(&light));
        }
        let light = until(&solver, edits, |light| light.exact && !light.grows);
        let configuration = light.world.configuration();
        let shapes = Shapes::of(configuration);
        let error = Reconstruction::new(&shapes, configuration, &light.buckets, &light.scale, 1).median_error();
        assert!(is_that_of_a_fresh_solution(&light) && light.photons > 100_000 && (0.033..=0.039).contains(&error), "{error}");
        // Content with less, it shoots nothing; more is wanted, it goes on.
        solver.control(Controls { error: Some(0.052), ..controls });
        std::thread::sleep(Duration::from_millis(30));
        assert_eq!(solver.snapshot().unwrap().photons, light.photons);
        solver.control(Controls { error: Some(0.0285), ..controls });
        let more = until(&solver, edits, |more| more.exact && !more.grows && more.photons > light.photons);
        assert!(is_that_of_a_fresh_solution(&more) && more.photons > light.photons * 3 / 2);
        let again = until(&solver, solver.start_over(), |light| light.exact && !light.grows);
        assert!(is_that_of_a_fresh_solution(&again));
    }
}

#[test]
fn memory_is_bounded_and_told() {
    let scene = own_scene("room");
    let home = Configuration::initial(&scene);
    let start = |ledger_bytes, error| {
        let settings = settings(pool(150_000), ledger_bytes, Duration::from_millis(5));
        let controls = Controls { error, ..settings.controls };
        Solver::start(home.clone(), Settings { controls, ..settings }).unwrap()
    };
    // Growth ends where the records are full, and they stay.
    let solver = start(8_000_000, Some(1e-6));
    let full = until(&solver, 0, |light| light.exact && !light.grows);
    assert!(matches!(full.method, Method::Ledger { bytes: 5_000_000..=8_000_000 }), "{:?}", full.method);
    assert!(full.photons > 200_000 && is_that_of_a_fresh_solution(&full));
    // Longer paths do not fit any more: without a ledger, it is said, and the light is right.
    let mut brighter = home.clone();
    for (material, _) in home.to_file().materials {
        brighter = brighter.apply(&Edit::Reflect { material, to: DVec3::splat(0.9) }).unwrap();
    }
    solver.edit(brighter);
    let light = solver.wait_until_exact();
    let refused = |light: &Snapshot| matches!(light.method, Method::Groups { refused: Some(Refused::Memory { .. }), .. });
    assert!(refused(&light) && is_that_of_a_fresh_solution(&light), "{:?}", light.method);
    // A pool that does not fit is foreseen: nothing is shot twice.
    let light = start(1_000_000, None).wait_until_exact();
    assert!(refused(&light) && light.work.photons == 150_000 && is_that_of_a_fresh_solution(&light));
}

#[test]
fn what_cannot_be_moved_has_no_ledger() {
    let scene = Builder::default()
        .rectangle("floor", 0.6, [0.0; 3], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0])
        .cuboid("block", 0.4, [1.0, 1.0, 0.0], [1.5, 1.5, 0.6], false)
        .lamp([1.5, 1.5, 1.9], 50.0)
        .build(&[]);
    let settings = settings(pool(20_000), 1 << 30, Duration::from_millis(5));
    let light = Solver::start(Configuration::initial(&scene), settings).unwrap().wait_until_exact();
    assert_eq!(light.method, Method::Groups { stale: 0, refused: None });
}
