//! The experiments of the seed paper's §7 (Dmitriev et al. 2002), with its plain Halton sequence: Figure 5 (N_g), Figure 6 (two
//! groups drawn), Figure 7 (R) as SVG and PNG, and what tracing changed paths twice costs as a table.
//!
//! ```text
//! cargo run --release -p lightmend-photon --example seed_figures -- scenes/room/room.ron OUT_DIR --photons 1152000 \
//!     --groups 288,10080 --direct scenes/room/moves/table.ron --indirect scenes/room/moves/bed_box.ron
//! ```
//!
//! `--direct` and `--indirect` (each as often as wanted) are moves of objects that lamps light or do not; Figures 6 and 7 show the first
//! direct one; `--other` moves are only counted. `--groups` is the seed's N_g and the finer one, `--ratios` the pilots' ratios of
//! Figure 7, the rest use 16. Edits before the time of a file's last one prepare the scene.
//! docs/seed-figures.md reads the results.

#[path = "../support/chart.rs"]
mod chart;
mod curves;
mod measure;
mod paths;
#[path = "../support/picture.rs"]
mod picture;
mod twice;

use chart::Panels;
use curves::{Course, against_rays, against_time, row};
use lightmend_photon::{body::TreePreset, halton::Scrambling, path::FirstHits, pool::Pool, solution::Solution, world::World};
use lightmend_scene::{Configuration, Moves, Scene};
use measure::{Fact, course, facts, perfect_pilots, pilots_first, relevant};
use std::{
    collections::BTreeMap,
    error::Error,
    path::{Path, PathBuf},
    sync::Arc,
};
use twice::Twice;

/// The seed's ratio.
const RATIO: u32 = 16;

/// What a move is there for: the seed's two kinds, and moves that are counted but not drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Direct,
    Indirect,
    Other,
}

struct Arguments {
    scene: PathBuf,
    out: PathBuf,
    moves: Vec<(Kind, PathBuf)>,
    photons: u64,
    groups: [u32; 2],
    ratios: Vec<u32>,
}

const USAGE: &str = "usage: seed_figures SCENE OUT_DIR --direct MOVES [--indirect MOVES] [--other MOVES] [--photons N] \
     [--groups COARSE,FINE] [--ratios R,R,...]";

impl Arguments {
    fn read(mut given: impl Iterator<Item = String>) -> Result<Arguments, Box<dyn Error>> {
        let mut next = || given.next();
        let mut arguments = Arguments {
            scene: next().ok_or(USAGE)?.into(),
            out: next().ok_or(USAGE)?.into(),
            moves: Vec::new(),
            photons: 1_152_000,
            groups: [288, 10_080],
            ratios: vec![8, 16, 32, 64],
        };
        let numbers = |list: &str| list.split(',').map(str::parse).collect::<Result<Vec<u32>, _>>();
        while let Some(name) = next() {
            let value = next().ok_or_else(|| format!("{name} lacks its value; {USAGE}"))?;
            match name.as_str() {
                "--direct" => arguments.moves.push((Kind::Direct, value.into())),
                "--indirect" => arguments.moves.push((Kind::Indirect, value.into())),
                "--other" => arguments.moves.push((Kind::Other, value.into())),
                "--photons" => arguments.photons = value.parse()?,
                "--groups" => {
                    arguments.groups = numbers(&value)?.try_into().map_err(|_| format!("--groups wants two; {USAGE}"))?
                }
                "--ratios" => arguments.ratios = numbers(&value)?,
                _ => return Err(format!("{name} is unknown; {USAGE}").into()),
            }
        }
        Ok(arguments)
    }
}

/// One scripted move, ready to be measured.
struct Case {
    kind: Kind,
    name: String,
    before: Arc<World>,
    after: Arc<World>,
    facts: Vec<Fact>,
    relevant: u64,
    /// Light after the move, shot afresh.
    fresh: Solution,
    /// Light before it, one per way to group the pool.
    drained: BTreeMap<(u32, u32), Solution>,
}

impl Case {
    /// Reads a move; edits before the last one's time only prepare the scene for it.
    fn new(kind: Kind, path: &Path, arguments: &Arguments, scene: &Arc<Scene>) -> Result<Case, Box<dyn Error>> {
        let (moves, _) = Moves::read(path, scene)?;
        let last = moves.edits.last().ok_or_else(|| format!("{} has no edits", path.display()))?.at;
        let mut configurations = [Configuration::initial(scene), Configuration::initial(scene)];
        for timed in &moves.edits {
            configurations[1] = configurations[1].apply(&timed.edit)?;
            if timed.at < last {
                configurations[0] = configurations[1].clone();
            }
        }
        let [before, after] = configurations.map(|configuration| Arc::new(World::new(&configuration, TreePreset::default())));
        let [coarse, fine] = arguments.groups;
        let mut ways = vec![(coarse, RATIO), (fine, RATIO)];
        if kind == Kind::Direct {
            ways.extend(arguments.ratios.iter().map(|ratio| (coarse, *ratio)));
        }
        let mut drained = BTreeMap::new();
        for (groups, ratio) in ways {
            let pool = Pool::new(arguments.photons, groups, ratio, Scrambling::None)?;
            drained.insert((groups, ratio), shoot(pool, before.clone())?);
        }
        let fresh = shoot(*drained[&(coarse, RATIO)].pool(), after.clone())?;
        let facts = facts(fresh.pool(), fresh.rules(), &before, &after);
        let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().replace('_', " "));
        Ok(Case { kind, name, before, after, relevant: relevant(&facts), facts, fresh, drained })
    }

    /// Repairs the light after the move, and checks that it ends as if shot afresh.
    fn course(&self, groups: u32, ratio: u32, name: String) -> Result<Course, Box<dyn Error>> {
        let drained = &self.drained[&(groups, ratio)];
        let times = if self.kind == Kind::Other { 1 } else { 3 };
        let (moments, solution) = course(drained, &self.after, &self.facts, times)?;
        if !solution.equals(&self.fresh) {
            return Err(format!("{}, {name}: the repaired light is not that of a fresh solution", self.name).into());
        }
        let (perfect, pilots_first) = (perfect_pilots(drained.pool(), &self.facts), pilots_first(drained.pool(), &self.facts));
        Ok(Course { name, moments, perfect, pilots_first })
    }

    /// What the panels are called: how much of the object's light comes straight from lamps is measured, not promised.
    fn title(&self, scene: &str) -> String {
        let direct = self.facts.iter().filter(|fact| fact.relevant && fact.met_on == 1).count() as f64;
        format!(
            "{scene}, {}: {:.0} % of the relevant photons come straight from a lamp",
            self.name,
            100.0 * direct / self.relevant.max(1) as f64
        )
    }
}

fn shoot(pool: Pool, world: Arc<World>) -> Result<Solution, Box<dyn Error>> {
    Ok(Solution::shoot(pool, world, FirstHits::AsLampsSay, &mut |_, _| true).ok_or("the pool was not shot")?)
}

/// What the tables say, a line each.
#[derive(Default)]
struct Tables {
    rays: Vec<String>,
    twice: Vec<String>,
    over_new: Vec<f64>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::read(std::env::args().skip(1))?;
    std::fs::create_dir_all(&arguments.out)?;
    let (scene, _) = Scene::read(&arguments.scene)?;
    println!("{}: {} photons, {} elements\n", scene.name, arguments.photons, scene.cells());
    let (mut panels, mut tables) = (Vec::new(), Tables::default());
    let [coarse, fine] = arguments.groups;
    let mut first = true;
    for (kind, path) in &arguments.moves {
        let case = Case::new(*kind, path, &arguments, &scene)?;
        let courses =
            [(coarse, RATIO), (fine, RATIO)].map(|(groups, ratio)| case.course(groups, ratio, format!("Ng = {groups}")));
        let courses = courses.into_iter().collect::<Result<Vec<_>, _>>()?;
        let rows = |courses: &[Course]| -> Vec<String> {
            courses.iter().map(|course| format!("{} | {} | {}", case.name, case.relevant, row(course, case.relevant))).collect()
        };
        let twice = Twice::of(&case.facts);
        tables.over_new.push(twice.over_new());
        tables.twice.push(twice.row(&case.name, &courses[0]));
        tables.rays.extend(rows(&courses));
        if case.kind == Kind::Other {
            continue;
        }
        let title = case.title(&scene.name);
        panels.push(against_time(&title, &courses, case.relevant));
        panels.push(against_rays(&title, &courses, case.relevant, true));
        if case.kind == Kind::Direct && std::mem::take(&mut first) {
            draw_groups(&case, &arguments, &scene.name)?;
            tables.rays.extend(rows(&draw_ratios(&case, &arguments, &scene.name)?));
        }
    }
    if !panels.is_empty() {
        picture::write(&arguments.out, &format!("figure5_{}", scene.name), &Panels { columns: 2, panels })?;
    }
    tables.print();
    Ok(())
}

/// Figure 6.
fn draw_groups(case: &Case, arguments: &Arguments, scene: &str) -> Result<(), Box<dyn Error>> {
    let [coarse, fine] = arguments.groups;
    let solution = &case.drained[&(fine, RATIO)];
    let bundles = paths::best_two(solution.pool(), &case.facts, solution.rules(), &case.after, coarse);
    let title = format!("{scene}, {}: two of {fine} groups, first segments and first bounces, in plan and elevation", case.name);
    let plan = paths::Plan::new(title, &case.before, &case.after, bundles);
    picture::write(&arguments.out, &format!("figure6_{scene}"), &plan)
}

/// Figure 7.
fn draw_ratios(case: &Case, arguments: &Arguments, scene: &str) -> Result<Vec<Course>, Box<dyn Error>> {
    let coarse = arguments.groups[0];
    let name = |ratio: u32| format!("R = {ratio} (Np = {})", case.drained[&(coarse, ratio)].pool().pilots_per_group());
    let courses =
        arguments.ratios.iter().map(|ratio| case.course(coarse, *ratio, name(*ratio))).collect::<Result<Vec<_>, _>>()?;
    let title = format!("{scene}, {}, Ng = {coarse}", case.name);
    let panels = vec![against_time(&title, &courses, case.relevant), against_rays(&title, &courses, case.relevant, false)];
    picture::write(&arguments.out, &format!("figure7_{scene}"), &Panels { columns: 2, panels })?;
    Ok(courses)
}

impl Tables {
    fn print(&self) {
        table(
            "move | relevant | groups | % of all rays until 25 / 50 / 75 / 90 % are repaired | if all pilots came first | \
             if pilots knew all | s in all",
            &self.rays,
        );
        table(
            "move | relevant | first met on segment 1 / 2 / 3 / 4+, % | L old | L new | both, beginnings once | over new alone, %: \
             beginnings twice | once | saved by once, % | over all work until 50 / 90 / 100 %",
            &self.twice,
        );
        let mean = self.over_new.iter().sum::<f64>() / self.over_new.len().max(1) as f64;
        println!("mean over the moves of \"once\" over new alone: {mean:.0} %");
    }
}

fn table(head: &str, rows: &[String]) {
    println!("| {head} |\n|{}", "---|".repeat(head.split(" | ").count()));
    rows.iter().for_each(|row| println!("| {row} |"));
    println!();
}
