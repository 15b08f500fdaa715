//! 7. Moves: tiny and huge, many, half repaired, turned by whole turns, everything at once, taken back.

use glam::DVec3;
use lightmend_photon::{body::TreePreset, ledger::LedgerSolution, path::FirstHits, solution::Solution, world::World};
use lightmend_scene::{Configuration, Direct, Edit, Scene};
use lightmend_tests::{Builder, count, own_scene, pool, shoot, table::Row};
use std::sync::Arc;

const PHOTONS: u64 = 10_000;

/// The two ways of repair, side by side.
struct Both {
    groups: Solution,
    ledger: LedgerSolution,
}

impl Both {
    fn new(scene: &Arc<Scene>) -> Both {
        Both::of(&Configuration::initial(scene))
    }

    fn of(configuration: &Configuration) -> Both {
        let world = Arc::new(World::new(configuration, TreePreset::default()));
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

    /// Which of the two ways differ from these bits.
    fn differ_from(&self, right: &Solution) -> usize {
        usize::from(!self.groups.equals(right)) + usize::from(!self.ledger.to_solution().unwrap().equals(right))
    }

    /// Repairs all; which of the two ways differ from a fresh solution.
    fn differ(&mut self, configuration: &Configuration) -> usize {
        while self.groups.repair_next().unwrap().is_some() {}
        while !self.ledger.scan(usize::MAX) {}
        while self.ledger.repair_next().unwrap().is_some() {}
        let fresh = shoot(pool(PHOTONS), &Arc::new(World::new(configuration, TreePreset::Fast)), FirstHits::AsLampsSay);
        self.differ_from(&fresh)
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

/// A row about coming back to where it began: `configuration`, of which `before` was the light.
fn back(case: &str, both: &mut Both, configuration: &Configuration, before: &Solution) -> Row {
    Row::exactly(
        case,
        "ways of repair (groups, ledger) whose bits differ from a fresh solution's; from those before",
        "0; 0".to_owned(),
        "the same place is the same light",
        format!("{}; {}", both.differ(configuration), both.differ_from(before)),
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
        rows.push(back(&format!("{case}, and back"), &mut both, &home, &start.groups));
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
    rows.extend(turns(&cornell));
    let remove = Edit::Remove { object: "tall box".into() };
    let away = home.apply(&remove).unwrap();
    let mut both = again();
    both.change(&away);
    both.repair(30);
    both.change(&home);
    rows.push(back("removed, half repaired, and back", &mut both, &home, &start.groups));
    let mut both = again();
    both.change(&away);
    rows.push(row("removed", both.differ(&away)));
    let undone = remove.inverse(&home).unwrap().iter().fold(away, |now, edit| now.apply(edit).unwrap());
    both.change(&undone);
    rows.push(back("removed and undone", &mut both, &home, &start.groups));
    rows.extend(floor());
    rows.extend(everything());
    rows
}

/// Whole turns and quarters of them, of the box that stands at −17°.
fn turns(cornell: &Arc<Scene>) -> Vec<Row> {
    let home = Configuration::initial(cornell);
    let turned = |degrees: f64| {
        let turn = Edit::Turn { object: "short box".into(), to: DVec3::new(0.0, 0.0, degrees) };
        home.apply(&turn).unwrap()
    };
    let mut rows = Vec::new();
    for (case, start, steps) in [
        ("turned by 360°", -17.0, vec![343.0]),
        ("turned by 90°, eight times, each half repaired", -17.0, (1..=8).map(|n| -17.0 + 90.0 * f64::from(n)).collect()),
        ("turned by 90° from 0°, four times, each half repaired", 0.0, vec![90.0, 180.0, 270.0, 360.0]),
        ("turned by −3,600,000°", -17.0, vec![-3_600_017.0]),
    ] {
        let mut both = Both::of(&turned(start));
        let before = both.groups.clone();
        for degrees in &steps {
            both.repair(40);
            both.change(&turned(*degrees));
        }
        rows.push(back(case, &mut both, &turned(steps[steps.len() - 1]), &before));
    }
    // The double next to 377.3 is not the one next to 17.3 and 360 more.
    let corners = |at: &Configuration| {
        let id = at.object_id("short box").unwrap();
        let motion = at.object_motion(id);
        at.object(id).mesh.positions.iter().map(|p| motion.point(*p)).collect::<Vec<_>>()
    };
    let [before, after] = [17.3, 17.3 + 360.0].map(turned);
    let off = corners(&before).iter().zip(corners(&after)).map(|(a, b)| a.distance(b)).fold(0.0, f64::max);
    let case = "turned by 360° from 17.3°";
    rows.push(Row::at_most(case, "a corner is off by, metres", "half the last place of 377.3°, and of metres", off, 1e-15));
    let mut both = Both::of(&before);
    both.change(&after);
    rows.push(row(case, both.differ(&after)));
    rows
}

/// A floor that is an object by itself.
fn floor() -> Vec<Row> {
    let (low, high) = ([0.0; 3], [4.0, 3.0, 2.5]);
    let corner = |k: usize| DVec3::from_array(std::array::from_fn(|a| if k >> a & 1 == 1 { high[a] } else { low[a] }));
    let quads = [[4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let walls = quads.iter().flat_map(|[a, b, c, d]| [[*a, *c, *b], [*a, *d, *c]]).collect();
    let mut builder = Builder::default()
        .object("walls", 0.7, (0..8).map(corner).collect(), walls)
        .rectangle("floor", 0.6, low, [4.0, 0.0, 0.0], [0.0, 3.0, 0.0])
        .cuboid("box", 0.5, [1.0, 1.0, 0.0], [1.6, 1.5, 0.8], false)
        .lamp([2.4, 1.2, 2.0], 100.0);
    builder.file.objects.iter_mut().filter(|o| o.name == "floor").for_each(|o| o.movable = true);
    builder.file.lamps[0].direct = Direct::Photons;
    let home = Configuration::initial(&builder.build(&[]));
    let start = Both::of(&home);
    let mut rows = Vec::new();
    for (case, to) in [("the floor moved up by 0.4 m", 0.4), ("the floor moved down by 10⁻⁶ m", -1e-6)] {
        let there = home.apply(&moved("floor", DVec3::Z * to)).unwrap();
        let mut both = Both { groups: start.groups.clone(), ledger: start.ledger.clone() };
        both.change(&there);
        rows.push(row(case, both.differ(&there)));
        let mut both = Both { groups: start.groups.clone(), ledger: start.ledger.clone() };
        both.change(&there);
        both.repair(100);
        both.change(&home);
        rows.push(back(&format!("{case}, half repaired, and back"), &mut both, &home, &start.groups));
    }
    rows
}

/// All that can be moved in the ROOM, its lamps and its floor at once.
fn everything() -> Vec<Row> {
    let scene = own_scene("room");
    let home = Configuration::initial(&scene);
    let mut now = home.clone();
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
    let start = both.groups.clone();
    both.change(&now);
    let case = "ROOM: everything movable and all lamps moved, the floor taken away, at once";
    let mut rows = vec![row(case, both.differ(&now))];
    both.change(&home);
    both.repair(100);
    both.change(&now);
    both.repair(50);
    both.change(&home);
    rows.push(back(&format!("{case}; back, and there again, half repaired, and back"), &mut both, &home, &start));
    rows
}
