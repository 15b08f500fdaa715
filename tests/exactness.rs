//! The signature invariant: after any sequence of edits, once nothing is stale, every bucket equals that of a fresh solution of the
//! edited scene to the bit, at any thread count, in any order of work, with any tree.

use glam::DVec3;
use lightmend_photon::{
    body::TreePreset,
    halton::Scrambling,
    importance::{Gaze, UNIT, Unmasked},
    path::FirstHits,
    pool::{GroupId, Pool},
    recovery::{Order, Relevant, recover},
    solution::Solution,
    visible::Frustum,
    world::World,
};
use lightmend_scene::{Configuration, Edit, Moves, Scene};
use lightmend_tests::{count, own_scene, own_scene_path, pool, shoot, world};
use proptest::{
    prelude::*,
    test_runner::{RngAlgorithm, TestRng, TestRunner},
};
use std::sync::Arc;

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
    (0..groups).map_while(|_| solution.repair_next().unwrap().map(|r| r.group)).collect()
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
            let recovery = recover(&drained, &after, order, &relevant, &mut |_| true).unwrap();
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
    let eye = |camera: usize| Frustum::new(&scene.cameras[camera].1, scene.up, 1.5);
    // A texture that hides nine tenths of any error wherever one is.
    let hidden = |id: usize| vec![UNIT / 10; after.object(id).mesh.triangles.len()].into();
    let unmasked = Unmasked((0..after.configuration().object_slots()).map(hidden).collect());
    let gazes = [None, Some(Gaze::Frustum(eye(1))), Some(Gaze::Frustum(eye(2))), Some(Gaze::Masked(eye(1), Arc::new(unmasked)))];
    let orders: Vec<Vec<GroupId>> = gazes
        .into_iter()
        .map(|gaze| {
            let mut solution = start.clone();
            solution.look(gaze);
            solution.change(after.clone());
            let order = repair(&mut solution, usize::MAX);
            assert_equal(&solution, &shoot(*start.pool(), &after, FirstHits::AsLampsSay));
            order
        })
        .collect();
    // Masking that is everywhere alike changes nothing; all else does.
    assert_eq!(orders[1], orders[3]);
    for (a, b) in [(0, 1), (1, 2)] {
        assert_ne!(orders[a], orders[b], "{a}, {b}");
    }
}
