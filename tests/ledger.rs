//! The ledger misses no photon that an edit makes wrong, and drains to the bits of the stateless way and of a fresh solution.

use glam::DVec3;
use lightmend_photon::{
    body::TreePreset,
    halton::Scrambling,
    ledger::{LedgerSolution, Refused},
    path::FirstHits,
    pool::Pool,
    recovery::Relevant,
    solution::Solution,
    visible::Visible,
    world::World,
};
use lightmend_scene::{Configuration, Edit, Scene};
use lightmend_tests::{
    Builder, count,
    edits::{edit, step},
    own_scene, pool, shoot, world,
};
use proptest::{
    prelude::*,
    test_runner::{RngAlgorithm, TestRng, TestRunner},
};
use std::{collections::HashSet, sync::Arc};

const PLENTY: u64 = 1 << 32;

fn ledger(pool: Pool, world: &Arc<World>) -> LedgerSolution {
    LedgerSolution::shoot(pool, world.clone(), FirstHits::AsLampsSay, PLENTY, &mut |_, _| true).unwrap()
}

/// Repairs what the next so many steps repair.
fn drain(ledger: &mut LedgerSolution, steps: usize) -> HashSet<u64> {
    (0..steps).map_while(|_| ledger.repair_next().unwrap()).flat_map(|mended| mended.photons).map(|photon| photon.0).collect()
}

fn fresh(pool: Pool, configuration: &Configuration) -> Solution {
    shoot(pool, &Arc::new(World::new(configuration, TreePreset::Fast)), FirstHits::AsLampsSay)
}

fn runner(cases: u32) -> TestRunner {
    let config = ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() };
    TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha))
}

/// A yard: nothing above it, and what is moved soon stands outside of all that was there.
fn yard() -> Arc<Scene> {
    let mut builder = Builder::default()
        .rectangle("floor", 0.6, [0.0; 3], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0])
        .rectangle("wall", 0.5, [0.0; 3], [0.0, 3.0, 0.0], [0.0, 0.0, 2.0])
        .cuboid("box", 0.4, [0.4, 0.4, 0.0], [0.9, 0.9, 0.6], false)
        .cuboid("shelf", 0.7, [2.0, 1.0, 0.8], [2.6, 2.0, 0.9], false)
        .cuboid("post", 0.3, [1.4, 2.6, 0.0], [1.5, 2.7, 2.1], false)
        .lamp([1.5, 1.5, 1.9], 50.0)
        .lamp([0.5, 2.5, 1.2], 20.0);
    builder.file.cell = 0.25;
    builder.file.objects.iter_mut().skip(2).for_each(|object| object.movable = true);
    builder.build(&[])
}

fn scenes() -> [(Arc<Scene>, u64); 4] {
    [
        (yard(), count(60, 1000)),
        (own_scene("cornell"), count(40, 600)),
        (own_scene("room"), count(40, 600)),
        (own_scene("house"), count(6, 100)),
    ]
}

#[test]
fn no_relevant_photon_is_missed() {
    let pool = pool(20_000);
    for (scene, cases) in scenes() {
        let home = world(&scene);
        let start = ledger(pool, &home);
        runner(cases as u32)
            .run(&prop::collection::vec(step(), 1..3), |steps| {
                let mut configuration = Configuration::initial(&scene);
                for (number, step) in steps.iter().enumerate() {
                    // The yard's meshes are in no file, so nothing can be added to it.
                    let Ok(next) = configuration.apply(&edit(&configuration, step, number)) else { continue };
                    configuration = next;
                }
                let after = Arc::new(home.moved_to(&configuration));
                let rules = start.to_solution().unwrap().rules().clone();
                let relevant = Relevant::find(&pool, &rules, &home, &after);
                let mut ledger = start.clone();
                ledger.change(after).unwrap();
                while !ledger.scan(100) {}
                let marked = ledger.outstanding_photons();
                let repaired = drain(&mut ledger, usize::MAX);
                prop_assert_eq!(marked, repaired.len() as u64);
                let missed: Vec<_> = relevant.photons().filter(|photon| !repaired.contains(&photon.0)).collect();
                prop_assert!(missed.is_empty(), "{:?} were not found in {}", missed, scene.name);
                prop_assert!(ledger.is_exact());
                Ok(())
            })
            .unwrap();
    }
}

#[test]
fn mixed_edits_drain_to_the_stateless_and_to_a_fresh_solution() {
    let threads = [1, 2].map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap());
    let pool = pool(20_000);
    for (scene, cases) in scenes() {
        let home = world(&scene);
        let start = ledger(pool, &home);
        assert!(start.to_solution().unwrap().equals(&shoot(pool, &home, FirstHits::AsLampsSay)));
        runner(cases as u32)
            .run(&prop::collection::vec(step(), 1..8), |steps| {
                let (mut ledger, mut stateless) = (start.clone(), start.to_solution().unwrap());
                let mut configuration = Configuration::initial(&scene);
                for (number, step) in steps.iter().enumerate() {
                    // The yard's meshes are in no file, so nothing can be added to it.
                    let Ok(next) = configuration.apply(&edit(&configuration, step, number)) else { continue };
                    configuration = next;
                    let next = Arc::new(ledger.world().moved_to(&configuration));
                    stateless.change(next.clone());
                    // Sometimes nothing is scanned before the next edit, sometimes a part, sometimes all.
                    threads[number % 2].install(|| {
                        ledger.change(next).unwrap();
                        ledger.scan(step.groups * 3);
                        if let (true, Some((_, view))) = (number % 3 == 0, scene.cameras.first()) {
                            ledger.look(&Visible::new(ledger.world(), view).importance(ledger.world()));
                        }
                        drain(&mut ledger, step.groups / 8);
                        // It grows whatever is still wrong; an edit may come before a slab is complete.
                        if number % 3 != 2 {
                            ledger.grow(ledger.photons() + 40 * step.groups as u64, 2 * step.groups).unwrap();
                        }
                    });
                }
                while !ledger.scan(1000) {}
                drain(&mut ledger, usize::MAX);
                while stateless.repair_next().unwrap().is_some() {}
                let photons = ledger.photons();
                prop_assert!(stateless.grow(photons - stateless.pool().photons()).is_some());
                let solution = ledger.to_solution().unwrap();
                prop_assert!(solution.equals(&stateless), "the stateless way gives other light in {}", scene.name);
                prop_assert!(
                    solution.equals(&fresh(self::pool(photons), &configuration)),
                    "a fresh one differs in {}",
                    scene.name
                );
                ledger.change(home.clone()).unwrap();
                stateless.change(home.clone());
                prop_assert_eq!(stateless.grow(1).is_some(), stateless.stale_groups() == 0);
                while !ledger.scan(1000) {}
                drain(&mut ledger, usize::MAX);
                while stateless.repair_next().unwrap().is_some() {}
                let back = ledger.to_solution().unwrap();
                prop_assert!(back.equals(&shoot(self::pool(photons), &home, FirstHits::AsLampsSay)), "undoing leaves a trace");
                let more = stateless.pool().photons();
                prop_assert!(stateless.equals(&shoot(self::pool(more), &home, FirstHits::AsLampsSay)), "growth leaves a trace");
                Ok(())
            })
            .unwrap();
    }
}

#[test]
fn copies_of_the_sequence_and_odd_pools_are_kept() {
    let scene = own_scene("cornell");
    for (photons, copies) in [(5000, 1), (80_001, 8), (74_000, 64)] {
        let pool = Pool::new(photons, 2, 4, Scrambling::Seed(1)).unwrap().in_copies(copies).unwrap();
        let mut ledger = ledger(pool, &world(&scene));
        let edit = Edit::Move { object: "short box".into(), to: DVec3::new(0.3, 0.1, 0.0) };
        let configuration = Configuration::initial(&scene).apply(&edit).unwrap();
        ledger.change(Arc::new(ledger.world().moved_to(&configuration))).unwrap();
        while !ledger.scan(7) {}
        drain(&mut ledger, usize::MAX);
        assert!(ledger.to_solution().unwrap().equals(&fresh(pool, &configuration)), "{photons} in {copies}");
    }
}

#[test]
fn several_edits_before_a_repair_cost_one_trace_and_going_home_costs_none() {
    let scene = own_scene("room");
    let mut ledger = ledger(pool(50_000), &world(&scene));
    let home = Configuration::initial(&scene);
    let from = home.object(home.object_id("table").unwrap()).pose.position;
    let mut rays = Vec::new();
    for steps in [1, 5] {
        for step in (0..steps).rev() {
            let to = from + DVec3::X * (0.2 + 0.05 * f64::from(step));
            let configuration = home.apply(&Edit::Move { object: "table".into(), to }).unwrap();
            ledger.change(Arc::new(ledger.world().moved_to(&configuration))).unwrap();
            ledger.scan(usize::MAX);
        }
        rays.push(std::iter::from_fn(|| ledger.repair_next().unwrap()).map(|mended| mended.work.rays).sum::<u64>());
        ledger.change(world(&scene)).unwrap();
        ledger.scan(usize::MAX);
        drain(&mut ledger, usize::MAX);
    }
    // What the table touched on its way and no longer touches is cleared by replaying it.
    assert!(rays[1] == rays[0] && rays[0] > 0, "{rays:?}");
    let away = home.apply(&Edit::Remove { object: "table".into() }).unwrap();
    ledger.change(Arc::new(ledger.world().moved_to(&away))).unwrap();
    ledger.scan(usize::MAX);
    assert!(ledger.outstanding_photons() > 0);
    ledger.change(world(&scene)).unwrap();
    ledger.scan(usize::MAX);
    let rays: u64 = std::iter::from_fn(|| ledger.repair_next().unwrap()).map(|mended| mended.work.rays).sum();
    assert!(rays == 0 && ledger.is_exact());
}

#[test]
fn a_slice_and_all_the_rest_are_a_whole_scan() {
    let scene = own_scene("cornell");
    let mut ledger = ledger(pool(50_000), &world(&scene));
    let away = Configuration::initial(&scene).apply(&Edit::Remove { object: "tall box".into() }).unwrap();
    ledger.change(Arc::new(ledger.world().moved_to(&away))).unwrap();
    assert!(!ledger.scan(1) && ledger.scan(usize::MAX));
    drain(&mut ledger, usize::MAX);
    assert!(ledger.is_exact() && ledger.buckets() == fresh(pool(50_000), &away).buckets());
}

#[test]
fn too_little_memory_is_told() {
    let scene = own_scene("cornell");
    let refused = LedgerSolution::shoot(pool(20_000), world(&scene), FirstHits::AsLampsSay, 100_000, &mut |_, _| true).err();
    assert!(matches!(refused, Some(Refused::Memory { photons: 20_000, needed: 200_000.., limit: 100_000 })), "{refused:?}");
}

#[test]
fn a_name_whose_mesh_was_replaced_keeps_its_records_apart() {
    // A small object goes, a larger one takes its name, and back: all before anything is repaired.
    let scene = own_scene("room");
    let pool = pool(20_000);
    let mut ledger = ledger(pool, &world(&scene));
    let mut configuration = Configuration::initial(&scene);
    let at = configuration.object(configuration.object_id("box under bed").unwrap()).pose.position;
    for other in ["table", "cup west", "bed"] {
        let gone = configuration.apply(&Edit::Remove { object: "box under bed".into() }).unwrap();
        let to = at + DVec3::new(-1.5, 0.3, 0.1);
        configuration = gone.apply(&Edit::Duplicate { object: other.into(), name: "box under bed".into(), to }).unwrap();
        ledger.change(Arc::new(ledger.world().moved_to(&configuration))).unwrap();
        ledger.scan(150);
        drain(&mut ledger, 2);
    }
    while !ledger.scan(100) {}
    drain(&mut ledger, usize::MAX);
    assert!(ledger.to_solution().unwrap().equals(&fresh(pool, &configuration)));
}
