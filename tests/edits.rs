//! All kinds of edits, mixed and interrupted, drain to the bits of a fresh solution, and of a fresh reading of the edited scene.

use glam::DVec3;
use lightmend_photon::{
    body::TreePreset,
    path::FirstHits,
    recovery::{Order, Relevant, recover},
    solution::Solution,
    world::World,
};
use lightmend_scene::{
    Configuration, Edit, Scene,
    format::{LampEntry, ObjectEntry, write_ron},
};
use lightmend_tests::{
    Builder, count,
    edits::{Named, edit, step},
    own_scene, pool, shoot, world,
};
use proptest::{
    prelude::*,
    test_runner::{RngAlgorithm, TestRng, TestRunner},
};
use std::sync::Arc;

fn drain(solution: &mut Solution, groups: usize) {
    (0..groups).map_while(|_| solution.repair_next().unwrap()).for_each(drop);
}

#[test]
fn mixed_edits_drain_to_a_fresh_solution() {
    for (name, cases) in [("cornell", count(40, 400)), ("room", count(40, 400)), ("house", count(5, 100))] {
        let cases = cases as u32;
        let scene = own_scene(name);
        let start = shoot(pool(30_000), &world(&scene), FirstHits::AsLampsSay);
        let config = ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() };
        let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
        runner
            .run(&prop::collection::vec(step(), 1..8), |steps| {
                let mut solution = start.clone();
                let mut configuration = Configuration::initial(&scene);
                for (number, step) in steps.iter().enumerate() {
                    configuration = configuration.apply(&edit(&configuration, step, number)).unwrap();
                    let next = Arc::new(solution.world().moved_to(&configuration));
                    solution.change(next);
                    drain(&mut solution, step.groups);
                }
                drain(&mut solution, usize::MAX);
                let fresh = shoot(*start.pool(), &Arc::new(World::new(&configuration, TreePreset::Fast)), FirstHits::AsLampsSay);
                prop_assert!(solution.equals(&fresh), "the light differs from a fresh solution's");
                let emitted: i64 = solution.tallies().iter().map(|t| t.absorbed + t.escaped + t.cut).sum();
                prop_assert_eq!(emitted, 30_000, "emitted = absorbed + escaped + cut");
                prop_assert!(
                    dump(&solution) == dump_of(30_000, &reread_scene(&scene, &configuration)),
                    "the written scene gives other light"
                );
                let mut home = solution;
                home.change(world(&scene));
                drain(&mut home, usize::MAX);
                prop_assert!(home.equals(&start), "undoing everything leaves a trace");
                Ok(())
            })
            .unwrap();
    }
}

fn dump(solution: &Solution) -> String {
    let mut text = Vec::new();
    solution.buckets().dump(solution.world().configuration(), &mut text).unwrap();
    String::from_utf8(text).unwrap()
}

/// The edited scene, written to a file and read again as any other.
fn reread_scene(scene: &Arc<Scene>, configuration: &Configuration) -> Arc<Scene> {
    let folder = tempfile::tempdir().unwrap();
    let mut file = configuration.to_file();
    file.relocate(scene.path.parent().unwrap(), folder.path()).unwrap();
    let path = folder.path().join("edited.ron");
    write_ron(&path, &file).unwrap();
    Scene::read(&path).unwrap().0
}

fn dump_of(photons: u64, scene: &Arc<Scene>) -> String {
    dump(&shoot(pool(photons), &world(scene), FirstHits::AsLampsSay))
}

#[test]
fn dimming_switching_and_recolouring_trace_nothing() {
    let scene = own_scene("room");
    let mut solution = shoot(pool(30_000), &world(&scene), FirstHits::AsLampsSay);
    let mut configuration = Configuration::initial(&scene);
    for edit in [
        Edit::Light { lamp: "pendant".into(), intensity: DVec3::new(0.1, 0.5, 0.2) },
        Edit::Switch { lamp: "washer".into(), on: false },
        Edit::Light { lamp: "ceiling light".into(), intensity: DVec3::ZERO },
    ] {
        configuration = configuration.apply(&edit).unwrap();
        let next = Arc::new(solution.world().moved_to(&configuration));
        solution.change(next);
        assert_eq!(solution.stale_groups(), 0, "{edit:?}");
    }
    let fresh = shoot(pool(30_000), &Arc::new(World::new(&configuration, TreePreset::Fast)), FirstHits::AsLampsSay);
    assert!(solution.equals(&fresh));
}

#[test]
fn a_lamp_rides_on_its_stand_and_leaves_with_it() {
    let scene = own_scene("room");
    let start = shoot(pool(30_000), &world(&scene), FirstHits::AsLampsSay);
    let (_, reading) =
        Configuration::initial(&scene).lamps().find(|(_, l)| l.carrier.is_some()).map(|(n, l)| (n, l.name.clone())).unwrap();
    let carrier = scene.lamps.iter().find(|l| l.name == reading).and_then(|l| l.carrier).unwrap();
    let stand = scene.objects[carrier].clone();
    let mut solution = start.clone();
    for edit in [
        Edit::Move { object: stand.name.clone(), to: stand.pose.position + DVec3::new(-0.3, 0.2, 0.0) },
        Edit::Remove { object: stand.name.clone() },
    ] {
        let configuration = solution.world().configuration().apply(&edit).unwrap();
        let next = Arc::new(solution.world().moved_to(&configuration));
        solution.change(next);
        assert_eq!(solution.stale_groups(), 288);
        drain(&mut solution, usize::MAX);
        let fresh = shoot(pool(30_000), &Arc::new(World::new(&configuration, TreePreset::Medium)), FirstHits::AsLampsSay);
        assert!(solution.equals(&fresh), "{edit:?}");
    }
    assert!(solution.world().configuration().lamps().all(|(_, lamp)| lamp.name != reading));
}

#[test]
fn what_is_put_on_the_floor_and_back_takes_its_riders_along() {
    let scene = own_scene("room");
    let start = shoot(pool(30_000), &world(&scene), FirstHits::AsLampsSay);
    let home = Configuration::initial(&scene);
    let bowl = home.object(home.object_id("bowl").unwrap()).stated();
    assert_eq!(bowl.on.as_deref(), Some("table"));
    let put =
        |on: Option<&str>, to: DVec3, rotation: DVec3| Edit::Put { object: "bowl".into(), on: on.map(Into::into), to, rotation };
    let mut solution = start.clone();
    for edit in [
        put(None, DVec3::new(3.0, 2.0, 0.0), DVec3::Z * 30.0),
        put(Some("nightstand"), DVec3::new(0.0, 0.0, 0.5), DVec3::ZERO),
        // It rides: what carries it takes it, and the fruit in it, away.
        Edit::Move { object: "nightstand".into(), to: DVec3::new(4.0, 3.0, 0.0) },
        Edit::Move { object: "nightstand".into(), to: scene.objects[home.object_id("nightstand").unwrap()].pose.position },
        put(bowl.on.as_deref(), bowl.position, bowl.rotation),
    ] {
        let before = solution.world().configuration().clone();
        let configuration = before.apply(&edit).unwrap();
        let fruit = configuration.object_id("fruit").unwrap();
        assert_ne!(configuration.object_motion(fruit), before.object_motion(fruit), "{edit:?}");
        let next = Arc::new(solution.world().moved_to(&configuration));
        solution.change(next);
        drain(&mut solution, usize::MAX);
        let fresh = shoot(pool(30_000), &Arc::new(World::new(&configuration, TreePreset::Medium)), FirstHits::AsLampsSay);
        assert!(solution.equals(&fresh), "{edit:?}");
        assert!(dump(&solution) == dump_of(30_000, &reread_scene(&scene, &configuration)), "{edit:?}");
    }
    assert!(*solution.world().configuration() == home && solution.equals(&start));
}

#[test]
fn a_dark_scene_can_be_lit() {
    let scene = own_scene("cornell");
    let dark = Configuration::initial(&scene).apply(&Edit::RemoveLamp { lamp: scene.lamps[0].name.clone() }).unwrap();
    let mut solution = shoot(pool(10_000), &Arc::new(World::new(&dark, TreePreset::Medium)), FirstHits::AsLampsSay);
    assert_eq!(solution.buckets().lit().count(), 0);
    let bulb = LampEntry { name: "bulb".into(), position: DVec3::new(1.0, 1.0, 1.5), ..scene.lamps[0].entry.clone() };
    let lit = dark.apply(&Edit::AddLamp(bulb)).unwrap();
    let next = Arc::new(solution.world().moved_to(&lit));
    solution.change(next);
    drain(&mut solution, usize::MAX);
    assert!(solution.equals(&shoot(pool(10_000), &Arc::new(World::new(&lit, TreePreset::Fast)), FirstHits::AsLampsSay)));
    assert!(solution.buckets().lit().count() > 0);
}

#[test]
fn a_photon_that_ends_otherwise_is_relevant() {
    // Regression: with another reflectance a photon may meet the same walls and then escape instead of being absorbed.
    let builder = Builder::default()
        .rectangle("floor", 0.6, [0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0])
        .rectangle("wall", 0.3, [0.0; 3], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0])
        .lamp([1.0, 1.0, 1.0], 50.0);
    let scene = builder.build(&[]);
    let drained = shoot(pool(20_000), &world(&scene), FirstHits::AsLampsSay);
    let edit = Edit::Reflect { material: "of floor".into(), to: DVec3::new(0.2, 0.3, 0.1) };
    let after = Arc::new(drained.world().moved_to(&Configuration::initial(&scene).apply(&edit).unwrap()));
    let relevant = Relevant::find(drained.pool(), drained.rules(), drained.world(), &after);
    let oracle = recover(&drained, &after, Order::Oracle, &relevant, &mut |_| true).unwrap();
    assert!(oracle.solution.equals(&shoot(*drained.pool(), &after, FirstHits::AsLampsSay)));
}

#[test]
fn a_fixed_object_that_comes_back_elsewhere_has_moved() {
    // Regression: two fixed objects of one mesh; one is taken away and the other's copy takes its name at once.
    let mut builder = Builder::default()
        .cuboid("room", 0.6, [0.0; 3], [3.0, 3.0, 2.5], true)
        .cuboid("chair 1", 0.4, [0.4, 0.4, 0.0], [0.8, 0.8, 0.5], false)
        .lamp([1.5, 1.5, 2.2], 50.0);
    let twin = ObjectEntry { position: DVec3::new(1.5, 0.0, 0.0), ..builder.file.objects[1].clone() };
    builder.file.objects.push(twin.named("chair 2".into()));
    let scene = builder.build(&[]);
    let mut solution = shoot(pool(20_000), &world(&scene), FirstHits::AsLampsSay);
    let gone = Configuration::initial(&scene).apply(&Edit::Remove { object: "chair 1".into() }).unwrap();
    let copy = Edit::Duplicate { object: "chair 2".into(), name: "chair 1".into(), to: DVec3::new(0.0, 1.5, 0.0) };
    let back = gone.apply(&copy).unwrap();
    let next = Arc::new(solution.world().moved_to(&back));
    solution.change(next);
    assert_eq!(solution.stale_groups(), 288);
    drain(&mut solution, usize::MAX);
    let fresh = shoot(pool(20_000), &Arc::new(World::new(&back, TreePreset::Fast)), FirstHits::AsLampsSay);
    assert!(solution.equals(&fresh));
}

#[test]
fn what_an_edit_names_or_asks_is_checked() {
    let scene = own_scene("cornell");
    let home = Configuration::initial(&scene);
    let refused = |edit: Edit, told: &str| {
        let error = home.apply(&edit).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(told), "{error}");
    };
    let copy = |name: &str| Edit::Duplicate { object: "short box".into(), name: name.into(), to: DVec3::ONE };
    refused(copy(""), "printable");
    refused(copy("a\tb"), "printable");
    refused(copy("tall box"), "already");
    let drag = Edit::Drag { object: "short box".into(), to: DVec3::ONE, step: 1e-9, seconds: 1.0 };
    assert!(drag.steps(&home).unwrap_err().to_string().contains("make its step longer"));
}
