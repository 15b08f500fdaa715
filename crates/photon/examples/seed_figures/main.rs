//! The experiments of the seed paper's §7 (Dmitriev et al. 2002), with its plain Halton sequence: Figure 5 (N_g), Figure 6 (two
//! groups drawn), Figure 7 (R) as SVG and PNG, and what tracing changed paths twice costs as a table.
//!
//! ```text
//! cargo run --release -p lightmend-photon --example seed_figures -- scenes/room/room.ron OUT_DIR --photons 1152000 \
//!     --groups 288,10080 --direct scenes/room/moves/table.ron --indirect scenes/room/moves/bed_box.ron
//! ```
//!
//! `--direct` and `--indirect` (each as often as wanted) are moves of objects that lamps light or do not, `--other` moves are only
//! counted. `--groups` is the seed's N_g and the finer one, `--ratios` the pilots' ratios of Figure 7, the rest use 16.
//! docs/seed-figures.md reads the results.

mod chart;
mod curves;
mod measure;
mod paths;
mod twice;

use chart::Panels;
use curves::{Course, against_rays, against_time, row};
use lightmend_photon::{body::TreePreset, halton::Scrambling, path::FirstHits, pool::Pool, solution::Solution, world::World};
use lightmend_scene::{Configuration, Moves, Scene};
use measure::{Fact, course, facts, perfect_pilots, relevant};
use std::{error::Error, path::PathBuf, sync::Arc};
use twice::Twice;

/// The seed's ratio.
const RATIO: u32 = 16;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Lit {
    Directly,
    OnlyIndirectly,
    /// Counted, not drawn.
    Other,
}

struct Arguments {
    scene: PathBuf,
    out: PathBuf,
    moves: Vec<(Lit, PathBuf)>,
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
                "--direct" => arguments.moves.push((Lit::Directly, value.into())),
                "--indirect" => arguments.moves.push((Lit::OnlyIndirectly, value.into())),
                "--other" => arguments.moves.push((Lit::Other, value.into())),
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
    lit: Lit,
    name: String,
    after: Arc<World>,
    facts: Vec<Fact>,
}

struct Study {
    arguments: Arguments,
    scene: Arc<Scene>,
    before: Arc<World>,
    /// Light before the moves, one per way to group the pool.
    drained: Vec<((u32, u32), Solution)>,
}

impl Study {
    fn new(arguments: Arguments) -> Result<Study, Box<dyn Error>> {
        let (scene, _) = Scene::read(&arguments.scene)?;
        let before = Arc::new(World::new(&Configuration::initial(&scene), TreePreset::default()));
        let [coarse, fine] = arguments.groups;
        let mut ways = vec![(coarse, RATIO), (fine, RATIO)];
        ways.extend(arguments.ratios.iter().filter(|ratio| **ratio != RATIO).map(|ratio| (coarse, *ratio)));
        let mut drained = Vec::new();
        for (groups, ratio) in ways {
            let pool = Pool::new(arguments.photons, groups, ratio, Scrambling::None)?;
            drained.push(((groups, ratio), shoot(pool, before.clone())?));
        }
        Ok(Study { arguments, scene, before, drained })
    }

    fn drained(&self, groups: u32, ratio: u32) -> &Solution {
        let found = self.drained.iter().find(|(way, _)| *way == (groups, ratio));
        &found.expect("every way to group was shot at the start").1
    }

    fn case(&self, lit: Lit, path: &PathBuf) -> Result<Case, Box<dyn Error>> {
        let (moves, _) = Moves::read(path, &self.scene)?;
        let mut configuration = Configuration::initial(&self.scene);
        for timed in &moves.edits {
            configuration = configuration.apply(&timed.edit)?;
        }
        let after = Arc::new(self.before.moved_to(&configuration));
        let any = &self.drained[0].1;
        let facts = facts(any.pool(), any.rules(), &self.before, &after);
        let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().replace('_', " "));
        Ok(Case { lit, name, after, facts })
    }

    /// Repairs after a move, with groups of one kind, and checks that the light ends as if shot afresh.
    fn course(&self, case: &Case, groups: u32, ratio: u32, name: String, fresh: &Solution) -> Result<Course, Box<dyn Error>> {
        let drained = self.drained(groups, ratio);
        let (moments, solution) = course(drained, &case.after, &case.facts)?;
        if !solution.equals(fresh) {
            return Err(format!("{}, {name}: the repaired light is not that of a fresh solution", case.name).into());
        }
        Ok(Course { name, moments, perfect: perfect_pilots(drained.pool(), &case.facts) })
    }
}

fn shoot(pool: Pool, world: Arc<World>) -> Result<Solution, Box<dyn Error>> {
    Ok(Solution::shoot(pool, world, FirstHits::AsLampsSay, &mut |_, _| true).ok_or("the pool was not shot")?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let study = Study::new(Arguments::read(std::env::args().skip(1))?)?;
    let Arguments { out, moves, groups: [coarse, fine], ratios, .. } = &study.arguments;
    std::fs::create_dir_all(out)?;
    let scene = &study.scene.name;
    println!("{scene}: {} photons, {} elements\n", study.arguments.photons, study.scene.cells());
    let (mut panels, mut rays_table, mut twice_table) = (Vec::new(), Vec::new(), Vec::new());
    let mut overheads = Vec::new();
    let mut drawn = false;
    for (lit, path) in moves {
        let case = study.case(*lit, path)?;
        let count = relevant(&case.facts);
        let fresh = shoot(*study.drained(*coarse, RATIO).pool(), case.after.clone())?;
        let run = |groups: u32, ratio: u32, name: String| study.course(&case, groups, ratio, name, &fresh);
        let courses = [run(*coarse, RATIO, format!("Ng = {coarse}"))?, run(*fine, RATIO, format!("Ng = {fine}"))?];
        let twice = Twice::of(&case.facts);
        overheads.push(twice.over_new());
        twice_table.push(twice.row(&case.name, &courses[0]));
        rays_table.extend(courses.iter().map(|course| format!("{} | {count} | {}", case.name, row(course, count))));
        let how = match case.lit {
            Lit::Directly => "lit directly and indirectly",
            Lit::OnlyIndirectly => "lit only indirectly",
            Lit::Other => continue,
        };
        let title = format!("{scene}, {}: {how}", case.name);
        panels.push(against_time(&title, &courses, count));
        panels.push(against_rays(&title, &courses, count, true));
        if case.lit == Lit::Directly && !drawn {
            drawn = true;
            let solution = study.drained(*fine, RATIO);
            let bundles = paths::best_two(solution.pool(), &case.facts, solution.rules(), &case.after, *coarse);
            let title =
                format!("{scene}, {}: two of {fine} groups, first segments and first bounces (plan; elevation)", case.name);
            chart::write(out, &format!("figure6_{scene}"), &paths::Plan::new(title, &study.before, &case.after, bundles))?;
            let title = format!("{scene}, {}, Ng = {coarse}", case.name);
            let name = |ratio: u32| format!("R = {ratio} (Np = {})", study.drained(*coarse, ratio).pool().pilots_per_group());
            let courses = ratios.iter().map(|ratio| run(*coarse, *ratio, name(*ratio))).collect::<Result<Vec<_>, _>>()?;
            let figure = vec![against_time(&title, &courses, count), against_rays(&title, &courses, count, false)];
            chart::write(out, &format!("figure7_{scene}"), &Panels { columns: 2, panels: figure })?;
            rays_table.extend(courses.iter().map(|course| format!("{} | {count} | {}", case.name, row(course, count))));
        }
    }
    if !panels.is_empty() {
        chart::write(out, &format!("figure5_{scene}"), &Panels { columns: 2, panels })?;
    }
    table(
        "move | relevant | groups | % of all rays until 25 / 50 / 75 / 90 % repaired | if pilots knew all | s in all",
        &rays_table,
    );
    table(
        "move | relevant | first met on segment 1 / 2 / 3 / 4+, % | L old | L new | both, beginnings once | over new alone, %: \
         beginnings twice | once | saved by once, % | over all work until 50 / 90 / 100 %",
        &twice_table,
    );
    println!(
        "mean over the moves of \"once\" over new alone: {:.0} %",
        overheads.iter().sum::<f64>() / overheads.len().max(1) as f64
    );
    Ok(())
}

fn table(head: &str, rows: &[String]) {
    println!("| {head} |\n|{}", "---|".repeat(head.split(" | ").count()));
    rows.iter().for_each(|row| println!("| {row} |"));
    println!();
}
