//! 7. Moves: tiny and huge, many, half repaired, turned by whole turns, everything at once, taken back.

use glam::DVec3;
use lightmend_photon::{body::TreePreset, ledger::LedgerSolution, path::FirstHits, solution::Solution, world::World};
use lightmend_scene::{Configuration, Edit, Scene};
use lightmend_tests::{count, own_scene, pool, shoot, table::Row, world};
use std::sync::Arc;

const PHOTONS: u64 = 10_000;

/// The two ways of repair, side by side.
struct Both {
    groups: Solution,
    ledger: LedgerSolution,
}

impl Both {
    fn new(scene: &Arc<Scene>) -> Both {
        let world = world(scene);
        let groups = shoot(pool(PHOTONS), &world, FirstHits::AsLampsSay);
        let ledger = LedgerSolution::shoot(pool(PHOTONS), world, FirstHits::AsLampsSay, 1 << 32, &mut |_, _| true).unwrap();
        Both { groups, ledger }
    }

    fn change(&mut self, configuration: &Configuration) {
        let next = Arc::new(self.groups.world().moved_to(configuration));
        self.groups.change(next.clone());
        self.ledger.change(next).unwrap();
    }

    /// Repairs a part: so many groups, and chunks.
    fn repair(&mut self, steps: usize) {
        (0..steps).map_while(|_| self.groups.repair_next().unwrap()).for_each(drop);
        self.ledger.scan(steps);
        (0..steps / 8).map_while(|_| self.ledger.repair_next().unwrap()).for_each(drop);
    }

    /// Repairs all; which of the two ways differ from a fresh solution.
    fn differ(&mut self, configuration: &Configuration) -> usize {
        while self.groups.repair_next().unwrap().is_some() {}
        while !self.ledger.scan(usize::MAX) {}
        while self.ledger.repair_next().unwrap().is_some() {}
        let fresh = shoot(pool(PHOTONS), &Arc::new(World::new(configuration, TreePreset::Fast)), FirstHits::AsLampsSay);
        usize::from(!self.groups.equals(&fresh)) + usize::from(!self.ledger.to_solution().unwrap().equals(&fresh))
    }
}

fn row(case: &str, differ: usize) -> Row {
    Row::exactly(
        case,
        "ways of repair (groups, ledger) whose bits differ from a fresh solution's",
        0,
        "the signature invariant",
        differ,
    )
}

fn position(scene: &Arc<Scene>, object: &str) -> DVec3 {
    let home = Configuration::initial(scene);
    home.object(home.object_id(object).unwrap()).pose.position
}

fn moved(object: &str, to: DVec3) -> Edit {
    Edit::Move { object: object.into(), to }
}

pub fn rows() -> Vec<Row> {
    let cornell = own_scene("cornell");
    let home = Configuration::initial(&cornell);
    let start = Both::new(&cornell);
    let again = || Both { groups: start.groups.clone(), ledger: start.ledger.clone() };
    let from = position(&cornell, "short box");
    let mut rows = Vec::new();
    for (case, by) in [("a move by 10⁻⁶ m", 1e-6), ("a move by 100 m", 100.0), ("a move by 10⁵ m", 1e5)] {
        let mut both = again();
        let there = home.apply(&moved("short box", from + DVec3::X * by)).unwrap();
        both.change(&there);
        rows.push(row(case, both.differ(&there)));
        both.change(&home);
        rows.push(row(&format!("{case}, and back"), both.differ(&home) + usize::from(!both.groups.equals(&start.groups))));
    }
    let edits = count(300, 10_000);
    let mut both = again();
    let mut now = home.clone();
    for n in 0..edits {
        let t = n as f64 * 0.1;
        let to = from + DVec3::new(0.3 * t.sin(), 0.2 * (1.7 * t).cos(), 0.0);
        now = now.apply(&moved(if n % 3 == 0 { "tall box" } else { "short box" }, to)).unwrap();
        both.change(&now);
        both.repair((n % 40) as usize);
    }
    rows.push(row(&format!("{edits} edits, each while the last is half repaired"), both.differ(&now)));
    let mut both = again();
    let [a, b] = [DVec3::X * 0.2, DVec3::Y * 0.2].map(|by| home.apply(&moved("short box", from + by)).unwrap());
    for n in 0..20 {
        both.change([&a, &b, &home][n % 3]);
        both.repair(60);
    }
    rows.push(row("back and forth while groups hold three pasts", both.differ([&a, &b, &home][19 % 3])));
    let turn = |degrees: f64| home.apply(&Edit::Turn { object: "short box".into(), to: DVec3::new(0.0, 0.0, degrees) }).unwrap();
    for (case, degrees, like) in [
        ("turned by 360°", 360.0 - 17.0, -17.0),
        ("turned by 90°, eight times", 720.0, 0.0),
        ("turned by −3,600,000°", -3_600_000.0, 0.0),
    ] {
        let mut both = again();
        both.change(&turn(degrees));
        let fresh = shoot(pool(PHOTONS), &Arc::new(World::new(&turn(like), TreePreset::Fast)), FirstHits::AsLampsSay);
        let mut differ = both.differ(&turn(degrees));
        // Whole turns of an angle of no exact sine are another rounding of it: only multiples of 90° are the same to the bit.
        if like == 0.0 {
            differ += usize::from(!both.groups.equals(&fresh));
        }
        rows.push(row(case, differ));
    }
    let mut both = again();
    let away = home.apply(&Edit::Remove { object: "tall box".into() }).unwrap();
    both.change(&away);
    both.repair(30);
    both.change(&home);
    rows.push(row("removed, half repaired, and back", both.differ(&home) + usize::from(!both.groups.equals(&start.groups))));
    rows.push(everything());
    rows
}

/// All that can be moved in the ROOM, its lamps and its floor at once.
fn everything() -> Row {
    let scene = own_scene("room");
    let mut now = Configuration::initial(&scene);
    for object in scene.objects.iter().filter(|o| o.movable) {
        now = now.apply(&moved(&object.name, object.pose.position + DVec3::new(0.05, -0.03, 0.02))).unwrap();
    }
    for lamp in &scene.lamps {
        now = now
            .apply(&Edit::MoveLamp { lamp: lamp.name.clone(), to: lamp.pose.position + DVec3::new(-0.02, 0.03, -0.04) })
            .unwrap();
    }
    now = now.apply(&Edit::Remove { object: "floor".into() }).unwrap();
    let mut both = Both::new(&scene);
    both.change(&now);
    row("ROOM: everything movable and all lamps moved, the floor taken away, at once", both.differ(&now))
}
