//! `lightmend replay`: after each scripted edit, repair the light in several orders and say what each order cost.

mod drag;
mod report;
mod views;

use crate::{Common, PoolArguments, failure::Failure, masking::Maskings, output, progress};
use lightmend_photon::{
    body::TreePreset,
    ledger::{LedgerSolution, Refused},
    path::FirstHits,
    recovery::{Kept, Moment, Order, Relevant, recover},
    solution::Solution,
    world::World,
};
use lightmend_scene::{Configuration, Edit, Moves, TimedEdit};
use serde_json::json;
use std::{path::PathBuf, sync::Arc};

#[derive(clap::Args)]
pub struct Arguments {
    /// Scene file
    scene: PathBuf,
    /// Moves file
    #[arg(long, value_name = "MOVES")]
    script: PathBuf,
    /// Folder for recovery.csv, .svg and .png, for the same of drag if the script has a drag, and for summary.json
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    pool: PoolArguments,
    /// Orders to compare: ledger, stateless, random, oracle, restart
    #[arg(long, value_name = "ORDERS", value_delimiter = ',', default_value = "ledger,stateless,random,oracle,restart")]
    orders: Vec<OrderArgument>,
    /// Write the integer buckets after the last edit
    #[arg(long, value_name = "FILE")]
    dump: Option<PathBuf>,
    /// Rays traced per frame while a drag is played step by step
    #[arg(long, value_name = "N", default_value_t = 200_000, value_parser = clap::value_parser!(u64).range(1..))]
    work: u64,
    /// Follow also what each of the scene's cameras sees, with these ways to tell what matters to it, all if none is named: views.csv, .svg and .png
    #[arg(long, value_name = "WAYS", value_delimiter = ',', num_args = 0..=1, require_equals = true,
        default_missing_value = "p,v,v-masked,items")]
    views: Option<Vec<views::Way>>,
    #[command(flatten)]
    common: Common,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum OrderArgument {
    Ledger,
    Stateless,
    Random,
    Oracle,
    Restart,
}

/// The orders and their names; without that of the ledger if there is none.
fn orders_of<'a>(
    orders: &'a [OrderArgument],
    ledger: Option<&'a LedgerSolution>,
) -> impl Iterator<Item = (Order<'a>, &'static str)> {
    orders.iter().filter_map(move |order| {
        Some(match order {
            OrderArgument::Ledger => (Order::Ledger(ledger?), "ledger"),
            OrderArgument::Stateless => (Order::Stateless, "stateless"),
            OrderArgument::Random => (Order::Random, "random"),
            OrderArgument::Oracle => (Order::Oracle, "oracle"),
            OrderArgument::Restart => (Order::Restart, "restart"),
        })
    })
}

/// Each order once, as first named.
pub fn without_doubles<O: Copy + PartialEq>(orders: &[O]) -> Vec<O> {
    let mut unique = Vec::new();
    for order in orders {
        if !unique.contains(order) {
            unique.push(*order);
        }
    }
    unique
}

/// Bytes that the ledger may take; above it that order is left out.
pub const LEDGER_LIMIT: u64 = 8 << 30;

/// One order's way back to exact light after one edit.
pub struct Track {
    /// The order's name.
    pub order: &'static str,
    /// Its course, the edit first.
    pub moments: Vec<Moment>,
    /// Whether it ended with the bits of a fresh solution.
    pub bit_equal: bool,
    /// What the ledger did beside, if it was its.
    pub beside: Option<Beside>,
}

/// What a ledger did beside tracing.
pub struct Beside {
    /// Seconds of its scan.
    pub scan_seconds: f64,
    /// Photons that it marked.
    pub marked: u64,
    /// Memory of its records.
    pub bytes: u64,
}

/// One edit and how every order recovered from it.
pub struct Chapter {
    /// What was done.
    pub title: String,
    /// Photons that the edit made wrong.
    pub relevant: u64,
    /// Photons in all.
    pub photons: u64,
    /// The orders.
    pub tracks: Vec<Track>,
    /// The edit step by step, if it is a drag.
    pub drag: Option<drag::Drag>,
    /// What cameras saw of it, if that was asked for.
    pub views: Vec<views::Sight>,
    /// When its last step is done, seconds since its first.
    pub last_step: f64,
}

impl Chapter {
    /// Rays of the oracle, the unit of comparison, if it ran.
    pub fn oracle_rays(&self) -> Option<u64> {
        let oracle = self.tracks.iter().find(|t| t.order == "oracle")?;
        oracle.moments.last().map(|m| m.work.rays).filter(|r| *r > 0)
    }
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let common = &arguments.common;
    common.set_up()?;
    let scene = common.read_scene(&arguments.scene)?;
    let pool = arguments.pool.pool(&scene)?;
    let (moves, warnings) = Moves::read(&arguments.script, &scene)?;
    common.warn(&warnings);
    arguments.dump.as_deref().map_or(Ok(()), output::file)?;
    let files = [
        "recovery.csv",
        "recovery.svg",
        "recovery.png",
        "drag.csv",
        "drag.svg",
        "drag.png",
        "views.csv",
        "views.svg",
        "views.png",
        "summary.json",
    ];
    let files = files.map(String::from);
    let out = output::folder(&arguments.out, &files)?;
    let orders = without_doubles(&arguments.orders);

    let mut configuration = Configuration::initial(&scene);
    let world = Arc::new(World::new(&configuration, TreePreset::default()));
    let mut drained = shoot(&pool, world, "initial light", common.quiet)?;
    let mut ledger = match orders.contains(&OrderArgument::Ledger) {
        true => begin_ledger(&drained, common.quiet)?,
        false => None,
    };
    let mut chapters = Vec::new();
    let mut maskings = Maskings::new();
    for (number, timed) in moves.edits.iter().enumerate() {
        configuration = configuration.apply(&timed.edit)?;
        let Some((mut chapter, fresh, next)) =
            chapter(&drained, ledger.as_ref(), &configuration, &orders, number, timed, common.quiet)?
        else {
            break; // interrupted: what is done is kept
        };
        if matches!(timed.edit, Edit::Drag { .. }) {
            chapter.drag = drag::play(&moves, timed, &drained, ledger.as_ref(), &fresh, arguments.work, &orders, common.quiet)?;
        }
        if let Some(ways) = &arguments.views {
            chapter.views = views::follow(&mut maskings, &drained, ledger.as_ref(), &fresh, &orders, ways, common.quiet)?;
        }
        if common.talks() {
            report::print(&chapter);
            views::print(&chapter.views);
        }
        chapters.push(chapter);
        (drained, ledger) = (fresh, next);
    }

    let summary = json!({
        "scene": scene.name, "photons": pool.photons(), "threads": rayon::current_num_threads(),
        "ng": pool.groups(), "r": arguments.pool.r, "work": arguments.work, "cells": scene.cells(),
        "interrupted": progress::interrupted(), "edits": report::json(&chapters),
    });
    report::write(&out, &scene.name, &chapters, arguments.work, common)?;
    output::json(Some(&out.join("summary.json")), &summary, common.json)?;
    if let Some(path) = &arguments.dump {
        output::write(path, |file| drained.buckets().dump(&configuration, file))?;
    }
    if chapters.iter().flat_map(|c| &c.tracks).any(|t| !t.bit_equal) {
        return Err(Failure::failed("a repaired solution differs from a fresh one: this is a bug in Lightmend"));
    }
    if progress::interrupted() { Err(Failure::failed(format!("interrupted after {} edits", chapters.len()))) } else { Ok(()) }
}

fn shoot(pool: &lightmend_photon::pool::Pool, world: Arc<World>, what: &str, quiet: bool) -> Result<Solution, Failure> {
    let bar = progress::bar(pool.photons(), what, quiet);
    let solution = Solution::shoot(*pool, world, FirstHits::AsLampsSay, &mut |photons, _| {
        bar.set_position(photons);
        !progress::interrupted()
    });
    bar.finish_and_clear();
    solution
        .filter(|s| s.pool().photons() == pool.photons())
        .ok_or_else(|| Failure::failed("interrupted before the initial light was done"))
}

/// The ledger of the initial light; without it the other orders go on.
fn begin_ledger(drained: &Solution, quiet: bool) -> Result<Option<LedgerSolution>, Failure> {
    let pool = *drained.pool();
    let bar = progress::bar(pool.photons(), "ledger", quiet);
    let begun = LedgerSolution::shoot(pool, drained.world().clone(), FirstHits::AsLampsSay, LEDGER_LIMIT, &mut |photons, _| {
        bar.set_position(photons);
        !progress::interrupted()
    });
    bar.finish_and_clear();
    match begun {
        Ok(ledger) => Ok(Some(ledger)),
        Err(Refused::Stopped) => Err(Failure::failed("interrupted before the ledger was begun")),
        Err(refused) => {
            if !quiet {
                eprintln!("warning: {refused}: the order \"ledger\" is left out");
            }
            Ok(None)
        }
    }
}

/// What an edit does, in a few words.
pub fn title(edit: &Edit) -> String {
    let at = |to: &glam::DVec3| format!("({}, {}, {})", to.x, to.y, to.z);
    match edit {
        Edit::Move { object, to } => format!("{object} to {}", at(to)),
        Edit::Turn { object, to } => format!("{object} turned to {}", at(to)),
        Edit::Drag { object, to, .. } => format!("{object} dragged to {}", at(to)),
        Edit::Put { object, on: Some(on), to, .. } => format!("{object} put on {on} at {}", at(to)),
        Edit::Put { object, on: None, to, .. } => format!("{object} put down at {}", at(to)),
        Edit::Paint { object, material: Some(material) } => format!("{object} made of {material}"),
        Edit::Paint { object, material: None } => format!("{object} made of its own materials"),
        Edit::Texture { material, texture: Some(texture) } => format!("{material} shows {texture}"),
        Edit::Texture { material, texture: None } => format!("{material} shows no image"),
        Edit::AddMaterial { name, .. } => format!("material {name} added"),
        Edit::RemoveMaterial { material } => format!("material {material} removed"),
        Edit::Reflect { material, to } => format!("{material} reflects {}", at(to)),
        Edit::Add(entry) => format!("{} added", entry.name),
        Edit::Duplicate { object, name, .. } => format!("{object} duplicated as {name}"),
        Edit::Remove { object } => format!("{object} removed"),
        Edit::MoveLamp { lamp, to } => format!("{lamp} to {}", at(to)),
        Edit::TurnLamp { lamp, to } => format!("{lamp} turned to {}", at(to)),
        Edit::Light { lamp, intensity } => format!("{lamp} set to {}", at(intensity)),
        Edit::Switch { lamp, on } => format!("{lamp} switched {}", if *on { "on" } else { "off" }),
        Edit::Relamp { lamp, photometry: Some(photometry), .. } => format!("{lamp} shines as {photometry}"),
        Edit::Relamp { lamp, photometry: None, .. } => format!("{lamp} shines alike in all directions"),
        Edit::AddLamp(entry) => format!("{} added", entry.name),
        Edit::DuplicateLamp { lamp, name, .. } => format!("{lamp} duplicated as {name}"),
        Edit::RemoveLamp { lamp } => format!("{lamp} removed"),
    }
}

/// `None` if interrupted.
fn chapter(
    drained: &Solution,
    ledger: Option<&LedgerSolution>,
    configuration: &Configuration,
    orders: &[OrderArgument],
    number: usize,
    timed: &TimedEdit,
    quiet: bool,
) -> Result<Option<(Chapter, Solution, Option<LedgerSolution>)>, Failure> {
    let pool = *drained.pool();
    let title = format!("edit {number}: {}", title(&timed.edit));
    let after = Arc::new(drained.world().moved_to(configuration));
    let relevant = Relevant::find(&pool, drained.rules(), drained.world(), &after);
    let mut recoveries = Vec::new();
    for (order, name) in orders_of(orders, ledger) {
        let bar = progress::bar(1000, &format!("{title}, {name}"), quiet);
        let recovery = recover(drained, &after, order, &relevant, &mut |share| {
            bar.set_position((share * 1000.0) as u64);
            !progress::interrupted()
        });
        bar.finish_and_clear();
        let Some(recovery) = recovery else {
            let refused = Failure::failed(format!("{title}: the ledger has no room for it; leave the order \"ledger\" out"));
            return if progress::interrupted() { Ok(None) } else { Err(refused) };
        };
        recoveries.push((name, recovery));
    }
    // The judge starts from nothing, with other trees.
    let fresh_world = Arc::new(World::new(configuration, TreePreset::Fast));
    let Ok(fresh) = shoot(&pool, fresh_world, "fresh solution", quiet) else { return Ok(None) };
    let mut next = None;
    let tracks = recoveries
        .into_iter()
        .map(|(order, recovery)| {
            let bit_equal = recovery.solution.equals(&fresh);
            let beside = recovery.kept.map(|Kept { ledger, scan_seconds, marked }| {
                let bytes = ledger.bytes();
                next = Some(ledger);
                Beside { scan_seconds, marked, bytes }
            });
            Track { order, moments: recovery.moments, bit_equal, beside }
        })
        .collect();
    let steps = timed.edit.steps(drained.world().configuration())?;
    let last_step = steps.last().map_or(0.0, |(at, _)| at - steps[0].0);
    let chapter =
        Chapter { title, relevant: relevant.count(), photons: pool.photons(), tracks, drag: None, views: Vec::new(), last_step };
    Ok(Some((chapter, fresh, next)))
}
