//! The signature invariant: after any sequence of edits, once nothing is stale, every bucket equals that of a fresh solution of the
//! edited scene to the bit, at any thread count, in any order of work, with any tree.

use glam::DVec3;
use lightmend_photon::{
    body::TreePreset,
    halton::Scrambling,
    irradiance::Scale,
    path::FirstHits,
    pool::{GroupId, Pool},
    recovery::{Order, Relevant, recover},
    solution::Solution,
    solver::{self, Controls, Settings, Snapshot, Solver},
    visible::Frustum,
    world::World,
};
use lightmend_scene::{Configuration, Edit, Moves, Scene};
use lightmend_tests::{count, own_scene, own_scene_path, pool, shoot, world};
use proptest::{
    prelude::*,
    strategy::ValueTree,
    test_runner::{RngAlgorithm, TestRng, TestRunner},
};
use std::{
    sync::Arc,
    time::{Duration, Instant},
};

/// One random step: which movable object, where to, and how many groups are repaired before the next step.
#[derive(Debug, Clone)]
struct Step {
    object: prop::sample::Index,
    by: [f64; 3],
    turn: Option<f64>,
    groups: usize,
}

fn step() -> impl Strategy<Value = Step> {
    let by = prop::array::uniform3(-0.4f64..0.4);
    let turn = prop::option::of(prop_oneof![Just(90.0), Just(-180.0), -30.0..30.0]);
    (any::<prop::sample::Index>(), by, turn, 0usize..150).prop_map(|(object, by, turn, groups)| Step { object, by, turn, groups })
}

fn edit(configuration: &Configuration, step: &Step) -> Edit {
    let movable: Vec<_> = configuration.objects().filter(|(_, object)| object.movable).map(|(_, object)| object).collect();
    let object = movable[step.object.index(movable.len())];
    let (name, pose) = (object.name.clone(), object.pose);
    match step.turn {
        Some(degrees) => Edit::Turn { object: name, to: pose.rotation + DVec3::Z * degrees },
        None => Edit::Move { object: name, to: pose.position + DVec3::from_array(step.by) },
    }
}

/// Repairs at most `groups` groups; which ones, in order.
fn repair(solution: &mut Solution, groups: usize) -> Vec<GroupId> {
    (0..groups).map_while(|_| solution.repair_next().map(|r| r.group)).collect()
}

fn assert_equal(solution: &Solution, fresh: &Solution) {
    assert!(solution.equals(fresh), "the light differs from a fresh solution's");
}

#[test]
fn drained_buckets_equal_a_fresh_solution() {
    // Fifty sequences per scene; always the same fifty, so that a failure can be met again.
    let cases = count(50, 200) as u32;
    let threads: Vec<rayon::ThreadPool> =
        [1, 2, 4].map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap()).into();
    for name in ["cornell", "room"] {
        let scene = own_scene(name);
        let start = shoot(pool(50_000), &world(&scene), FirstHits::AsLampsSay);
        let config = ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() };
        let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
        let strategy = prop::collection::vec(step(), 1..6);
        runner
            .run(&strategy, |steps| {
                let runs: Vec<(Solution, Vec<GroupId>)> =
                    threads.iter().map(|threads| threads.install(|| interrupted_repairs(&scene, &start, &steps))).collect();
                let configuration = runs[0].0.world().configuration().clone();
                let fresh = shoot(*start.pool(), &Arc::new(World::new(&configuration, TreePreset::Fast)), FirstHits::AsLampsSay);
                for (solution, order) in &runs {
                    assert_equal(solution, &fresh);
                    prop_assert_eq!(order, &runs[0].1, "the order of groups must not depend on threads");
                }
                // And home again, from wherever it was.
                let mut home = runs[0].0.clone();
                home.change(world(&scene));
                repair(&mut home, usize::MAX);
                assert_equal(&home, &start);
                Ok(())
            })
            .unwrap();
    }
}

fn interrupted_repairs(scene: &Arc<Scene>, start: &Solution, steps: &[Step]) -> (Solution, Vec<GroupId>) {
    let mut solution = start.clone();
    let mut configuration = Configuration::initial(scene);
    let mut order = Vec::new();
    for step in steps {
        configuration = configuration.apply(&edit(&configuration, step)).unwrap();
        let moved = Arc::new(solution.world().moved_to(&configuration));
        solution.change(moved);
        order.extend(repair(&mut solution, step.groups));
    }
    order.extend(repair(&mut solution, usize::MAX));
    assert_eq!(solution.stale_groups(), 0);
    (solution, order)
}

#[test]
fn there_and_back_costs_nothing_if_nothing_was_repaired() {
    let scene = own_scene("cornell");
    let mut solution = shoot(pool(50_000), &world(&scene), FirstHits::AsLampsSay);
    let before = solution.clone();
    let home = Configuration::initial(&scene);
    let away = home.apply(&Edit::Move { object: "short box".into(), to: DVec3::new(1.0, 0.3, 0.0) }).unwrap();
    solution.change(Arc::new(solution.world().moved_to(&away)));
    assert_eq!(solution.stale_groups(), 288);
    solution.change(Arc::new(solution.world().moved_to(&home)));
    assert_eq!(solution.stale_groups(), 0, "absolute poses: the way back makes every phantom vanish");
    assert_equal(&solution, &before);
}

#[test]
fn two_trees_give_the_same_bits() {
    for name in ["cornell", "room"] {
        let scene = own_scene(name);
        let configuration = Configuration::initial(&scene);
        let pool = pool(count(500_000, 20_000_000));
        let [a, b] = [TreePreset::Fast, TreePreset::Medium]
            .map(|preset| shoot(pool, &Arc::new(World::new(&configuration, preset)), FirstHits::AsLampsSay));
        assert_equal(&a, &b);
    }
}

#[test]
fn every_order_drains_to_the_same_bits_and_local_repair_is_cheaper_than_a_restart() {
    // The full pool when thorough.
    for (name, script) in [("cornell", "short_box"), ("room", "table"), ("room", "cup")] {
        let scene = own_scene(name);
        let (moves, _) = Moves::read(&own_scene_path(name).with_file_name(format!("moves/{script}.ron")), &scene).unwrap();
        let drained = shoot(pool(count(50_000, 1_152_000)), &world(&scene), FirstHits::AsLampsSay);
        let configuration = Configuration::initial(&scene).apply(&moves.edits[0].edit).unwrap();
        let after = Arc::new(drained.world().moved_to(&configuration));
        let relevant = Relevant::find(drained.pool(), drained.rules(), drained.world(), &after);
        assert!(relevant.count() > 0);
        let fresh = shoot(*drained.pool(), &Arc::new(World::new(&configuration, TreePreset::Fast)), FirstHits::AsLampsSay);
        let rays = [Order::Stateless, Order::Random, Order::Oracle, Order::Restart].map(|order| {
            let recovery = recover(&drained, &after, order, &relevant, FirstHits::AsLampsSay, &mut |_| true).unwrap();
            assert_equal(&recovery.solution, &fresh);
            let last = recovery.moments.last().unwrap();
            assert_eq!(last.repaired, relevant.count(), "{order:?}");
            last.work.rays
        });
        let [stateless, random, oracle, restart] = rays;
        println!("{name} {script}: rays: stateless {stateless}, random {random}, oracle {oracle}, restart {restart}");
        assert!(oracle < restart / 2, "repair, not restart");
    }
}

#[test]
fn scrambled_or_not_and_any_grouping() {
    let scene = own_scene("cornell");
    let world = world(&scene);
    let configuration =
        Configuration::initial(&scene).apply(&Edit::Turn { object: "tall box".into(), to: DVec3::Z * 40.0 }).unwrap();
    let pools = [
        (50_000, 10_080, 4, 1, Scrambling::None),
        (50_003, 7, 100, 1, Scrambling::Seed(5)),
        (4_608, 288, 16, 1, Scrambling::None),
        (100_003, 288, 16, 16, Scrambling::Seed(5)),
    ];
    for (photons, groups, ratio, copies, scrambling) in pools {
        let pool = Pool::new(photons, groups, ratio, scrambling).unwrap().in_copies(copies).unwrap();
        let mut solution = shoot(pool, &world, FirstHits::AsLampsSay);
        solution.change(Arc::new(world.moved_to(&configuration)));
        repair(&mut solution, usize::MAX);
        assert_equal(&solution, &shoot(pool, &Arc::new(World::new(&configuration, TreePreset::Medium)), FirstHits::AsLampsSay));
    }
}

#[test]
fn a_camera_changes_the_order_and_not_the_bits() {
    let scene = own_scene("room");
    let start = shoot(pool(100_000), &world(&scene), FirstHits::AsLampsSay);
    let (moves, _) = Moves::read(&own_scene_path("room").with_file_name("moves/wardrobe.ron"), &scene).unwrap();
    let configuration = Configuration::initial(&scene).apply(&moves.edits[0].edit).unwrap();
    let after = Arc::new(start.world().moved_to(&configuration));
    let orders: Vec<Vec<GroupId>> = [None, Some(&scene.cameras[1].1), Some(&scene.cameras[2].1)]
        .into_iter()
        .map(|view| {
            let mut solution = start.clone();
            solution.look(view.map(|v| Frustum::new(v, scene.up, 1.5)));
            solution.change(after.clone());
            let order = repair(&mut solution, usize::MAX);
            assert_equal(&solution, &shoot(*start.pool(), &after, FirstHits::AsLampsSay));
            order
        })
        .collect();
    assert!(orders[0] != orders[1] && orders[1] != orders[2]);
}

fn settings(pool: Pool, iteration: Duration) -> Settings {
    let controls = Controls { iteration, ..Controls::default() };
    Settings { pool, first_hits: FirstHits::AsLampsSay, threads: 2, courteous: false, controls }
}

#[test]
fn the_background_solver_ends_with_the_same_bits() {
    let scene = own_scene("room");
    let (moves, _) = Moves::read(&own_scene_path("room").with_file_name("moves/drag.ron"), &scene).unwrap();
    let pool = pool(50_000);
    let settings = settings(pool, Duration::from_millis(5));
    let mut configuration = Configuration::initial(&scene);
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
    assert!(light.exact && *light.configuration() == configuration);
    let fresh = shoot(pool, &Arc::new(World::new(&configuration, TreePreset::Medium)), FirstHits::AsLampsSay);
    assert!(light.buckets == *fresh.buckets());
}

#[test]
fn a_caller_that_edits_sixty_times_a_second_drains_to_the_same_bits() {
    // How long the calls take while the solver works on all cores is printed (`--nocapture`): time is no test.
    let scene = own_scene("room");
    let pool = pool(200_000);
    let settings = settings(pool, Duration::from_millis(10));
    let home = Configuration::initial(&scene);
    let solver = Solver::start(home.clone(), settings).unwrap();
    let from = home.object(home.object_id("table").unwrap()).pose.position;
    let mut configuration = home;
    let mut longest: Vec<Duration> = Vec::new();
    for step in 0..count(300, 3600) {
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
    let light = solver.wait_until_exact();
    let fresh = shoot(pool, &Arc::new(World::new(&configuration, TreePreset::Fast)), FirstHits::AsLampsSay);
    assert!(light.buckets == *fresh.buckets());
}

#[test]
fn whatever_is_asked_of_the_background_solver_it_ends_with_the_same_bits() {
    let scene = own_scene("room");
    let home = Configuration::initial(&scene);
    let pool = pool(50_000);
    for seed in 0..count(2, 20) {
        let mut runner =
            TestRunner::new_with_rng(ProptestConfig::default(), TestRng::from_seed(RngAlgorithm::ChaCha, &[seed as u8; 32]));
        let steps = prop::collection::vec((0u8..12, step(), 0u64..6), 300).new_tree(&mut runner).unwrap().current();
        let solver = Solver::start(home.clone(), settings(pool, Duration::from_millis(5))).unwrap();
        let mut configuration = home.clone();
        let mut edits = 0;
        std::thread::scope(|scope| {
            scope.spawn(|| {
                for (kind, step, pause) in &steps {
                    let lamp = scene.lamps[step.object.index(scene.lamps.len())].name.clone();
                    let controls = solver.controls();
                    match kind {
                        0 => solver.control(Controls { paused: !controls.paused, ..controls }),
                        1 => {
                            let orders = [solver::Order::Urgent, solver::Order::Shuffled, solver::Order::Adaptive];
                            solver.control(Controls { order: *step.object.get(&orders), ..controls });
                        }
                        2 => {
                            let iteration = Duration::from_micros(step.groups as u64 * 50);
                            solver.control(Controls { iteration, iterations: step.groups as u32 % 4, ..controls });
                        }
                        3 if step.groups < 30 => edits = solver.start_over(),
                        4 => {
                            let intensity = DVec3::from_array(step.by).abs() * 100.0;
                            configuration = configuration.apply(&Edit::Light { lamp, intensity }).unwrap();
                            edits = solver.edit(configuration.clone());
                        }
                        5 => solver.look(*step.object.get(&scene.cameras.iter().map(|(_, view)| *view).collect::<Vec<_>>())),
                        6 => {
                            let to = scene.lamps[step.object.index(scene.lamps.len())].pose.position
                                + DVec3::from_array(step.by) * 0.2;
                            configuration = configuration.apply(&Edit::MoveLamp { lamp, to }).unwrap();
                            edits = solver.edit(configuration.clone());
                        }
                        7 => {
                            let light = solver.snapshot();
                            assert!(
                                light.is_none_or(|light| light.edits <= edits && light.exact == (light.outstanding_photons == 0))
                            );
                        }
                        _ => {
                            configuration = configuration.apply(&edit(&configuration, step)).unwrap();
                            edits = solver.edit(configuration.clone());
                        }
                    }
                    std::thread::sleep(Duration::from_millis(*pause));
                }
            });
        });
        solver.control(Controls::default());
        let light = solver.wait_until_exact();
        assert!(light.exact && light.edits == edits && *light.configuration() == configuration);
        assert_eq!((light.photons, light.stale_groups, light.outstanding_photons), (50_000, 0, 0));
        let fresh = shoot(pool, &Arc::new(World::new(&configuration, TreePreset::Fast)), FirstHits::AsLampsSay);
        assert!(light.buckets == *fresh.buckets());
    }
}

/// Takes snapshots until one reflects edit number `edits` and is as wanted.
fn until(solver: &Solver, edits: u64, wanted: impl Fn(&Snapshot) -> bool) -> Arc<Snapshot> {
    loop {
        if let Some(light) = solver.snapshot().filter(|light| light.edits >= edits && wanted(light)) {
            return light;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_paused_solver_counts_what_is_stale_and_reads_dimmed_lamps() {
    let scene = own_scene("room");
    let home = Configuration::initial(&scene);
    let pool = pool(50_000);
    let solver = Solver::start(home.clone(), settings(pool, Duration::from_millis(5))).unwrap();
    let whole = solver.wait_until_exact();
    solver.control(Controls { paused: true, ..solver.controls() });
    let moved = home.apply(&Edit::Turn { object: "table".into(), to: DVec3::Z * 30.0 }).unwrap();
    let light = until(&solver, solver.edit(moved.clone()), |_| true);
    assert_eq!((light.stale_groups, light.outstanding_photons, light.exact), (288, 50_000, false));
    let (lamp, _) = home.lamps().next().unwrap();
    let dim = Edit::Light { lamp: scene.lamps[lamp].name.clone(), intensity: DVec3::splat(7.0) };
    let dimmed = moved.apply(&dim).unwrap();
    let light = until(&solver, solver.edit(dimmed.clone()), |_| true);
    std::thread::sleep(Duration::from_millis(50));
    let later = until(&solver, 2, |_| true);
    assert_eq!((later.stale_groups, later.work), (288, whole.work), "nothing is traced");
    assert!(later.buckets == whole.buckets);
    assert_eq!(light.scale.lumens(lamp), Scale::new(&World::new(&dimmed, TreePreset::Fast), 50_000).lumens(lamp));
    assert!(light.scale.lumens(lamp) != whole.scale.lumens(lamp));
    // Home again but for the lamp: nothing is stale, nothing was traced.
    let light = until(&solver, solver.edit(home.apply(&dim).unwrap()), |_| true);
    assert_eq!((light.stale_groups, light.exact, light.work), (0, true, whole.work));
    // Who waits for exact light gets it, though paused; then it is paused again.
    solver.edit(moved.clone());
    let light = solver.wait_until_exact();
    assert!(light.exact && solver.controls().paused && *light.configuration() == moved);
    let light = until(&solver, solver.edit(home), |_| true);
    assert_eq!(light.stale_groups, 288);
    let dark = until(&solver, solver.start_over(), |_| true);
    assert_eq!((dark.photons, dark.stale_groups, dark.outstanding_photons, dark.exact), (0, 0, 50_000, false));
}

#[test]
fn the_first_shooting_shows_what_it_has_and_bears_edits() {
    let scene = own_scene("room");
    let home = Configuration::initial(&scene);
    // More than can be shot in this test.
    let solver = Solver::start(home.clone(), settings(pool(1 << 31), Duration::from_millis(5))).unwrap();
    let light = until(&solver, 0, |light| light.photons > 10_000);
    assert!(!light.exact && light.outstanding_photons == light.pool_photons - light.photons && light.stale_groups == 0);
    let prefix = shoot(pool(light.photons), &world(&scene), FirstHits::AsLampsSay);
    assert!(light.buckets == *prefix.buckets(), "any prefix is the light of a smaller pool");
    // Little was shot: it begins again.
    let moved = home.apply(&Edit::Turn { object: "table".into(), to: DVec3::Z * 30.0 }).unwrap();
    let light = until(&solver, solver.edit(moved.clone()), |light| light.photons > 0);
    assert!(light.stale_groups == 0 && light.photons < light.work.photons);
    let light = until(&solver, solver.start_over(), |_| true);
    assert_eq!(*light.configuration(), moved);
    let dropping = Instant::now();
    drop(solver);
    println!("dropped in {:?}", dropping.elapsed());

    // Edits without end: it is whole all the same.
    let solver = Solver::start(home.clone(), settings(pool(100_000), Duration::from_millis(2))).unwrap();
    let mut configuration = home.clone();
    for step in 0.. {
        let to = DVec3::Z * f64::from(step);
        configuration = home.apply(&Edit::Turn { object: "table".into(), to }).unwrap();
        solver.edit(configuration.clone());
        if solver.snapshot().is_some_and(|light| light.photons == 100_000) {
            break;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let light = solver.wait_until_exact();
    let fresh = shoot(pool(100_000), &Arc::new(World::new(&configuration, TreePreset::Fast)), FirstHits::AsLampsSay);
    assert!(light.buckets == *fresh.buckets());
}
