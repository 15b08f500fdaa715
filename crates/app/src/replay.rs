//! `lightmend replay`: after each scripted edit, repair the light in several orders and say what each order cost.

use crate::{
    Common, PoolArguments,
    failure::Failure,
    figure,
    output::{self, say},
    progress,
};
use lightmend_photon::{
    body::TreePreset,
    path::FirstHits,
    recovery::{Moment, Order, Recovery, Relevant, recover},
    solution::Solution,
    world::World,
};
use lightmend_scene::{Configuration, Moves, ScriptedEdit};
use serde_json::{Map, Value, json};
use std::{io::Write, path::PathBuf, sync::Arc};

#[derive(clap::Args)]
pub struct Arguments {
    /// Scene file
    scene: PathBuf,
    /// Moves file
    #[arg(long, value_name = "MOVES")]
    script: PathBuf,
    /// Folder for recovery.csv, recovery.svg, recovery.png and summary.json
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    pool: PoolArguments,
    /// Orders to compare: stateless, random, oracle, restart
    #[arg(long, value_name = "ORDERS", value_delimiter = ',', default_value = "stateless,random,oracle,restart")]
    orders: Vec<OrderArgument>,
    /// Write the integer buckets after the last edit
    #[arg(long, value_name = "FILE")]
    dump: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum OrderArgument {
    Stateless,
    Random,
    Oracle,
    Restart,
}

impl OrderArgument {
    fn order(self) -> (Order, &'static str) {
        match self {
            OrderArgument::Stateless => (Order::Stateless, "stateless"),
            OrderArgument::Random => (Order::Random, "random"),
            OrderArgument::Oracle => (Order::Oracle, "oracle"),
            OrderArgument::Restart => (Order::Restart, "restart"),
        }
    }
}

/// One order's way back to exact light after one edit.
pub struct Track {
    /// The order's name.
    pub order: &'static str,
    /// Its course.
    pub recovery: Recovery,
    bit_equal: bool,
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
}

impl Chapter {
    /// Rays of the oracle, the unit of comparison, if it ran.
    pub fn oracle_rays(&self) -> Option<u64> {
        let oracle = self.tracks.iter().find(|t| t.order == "oracle")?;
        oracle.recovery.moments.last().map(|m| m.work.rays).filter(|r| *r > 0)
    }
}

const SHARES: [(&str, f64); 4] = [("50", 0.5), ("90", 0.9), ("99", 0.99), ("100", 1.0)];

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let common = &arguments.common;
    common.set_up()?;
    let pool = arguments.pool.pool()?;
    let scene = common.read_scene(&arguments.scene)?;
    let moves = Moves::read(&arguments.script, &scene)?;
    arguments.dump.as_deref().map_or(Ok(()), output::file)?;
    let files = ["recovery.csv", "recovery.svg", "recovery.png", "summary.json"].map(String::from);
    let out = output::folder(&arguments.out, &files)?;
    let mut orders = Vec::new();
    for order in &arguments.orders {
        if !orders.contains(order) {
            orders.push(*order);
        }
    }

    let mut configuration = Configuration::initial(&scene);
    let world = Arc::new(World::new(&configuration, TreePreset::default()));
    let mut drained = shoot(&pool, world, "initial light", common.quiet)?;
    let mut chapters = Vec::new();
    for (number, timed) in moves.edits.iter().enumerate() {
        configuration = configuration.apply(&timed.edit.last())?;
        let title = title(&timed.edit);
        match chapter(&drained, &configuration, &orders, format!("edit {number}: {title}"), common.quiet)? {
            Some((chapter, fresh)) => {
                if common.talks() {
                    print_chapter(&chapter);
                }
                chapters.push(chapter);
                drained = fresh;
            }
            None => break, // interrupted: what is done is kept
        }
    }

    output::write(&out.join("recovery.csv"), |file| write_csv(file, &chapters))?;
    figure::recovery(&out, &scene.name, &chapters)?;
    let threads = rayon::current_num_threads();
    let edits: Vec<Value> = chapters.iter().enumerate().map(|(n, c)| chapter_json(n, c)).collect();
    let summary = json!({
        "scene": scene.name, "photons": pool.photons(), "threads": threads, "ng": arguments.pool.ng, "r": arguments.pool.r,
        "cells": scene.cells(), "interrupted": progress::interrupted(), "edits": edits,
    });
    output::json(Some(&out.join("summary.json")), &summary, common.json)?;
    if let Some(path) = &arguments.dump {
        output::write(path, |file| drained.buckets().dump(&scene, file))?;
    }
    if common.talks() {
        say(&format!("figure: {}", out.join("recovery.png").display()));
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

fn title(edit: &ScriptedEdit) -> String {
    let at = |to: &glam::DVec3| format!("({}, {}, {})", to.x, to.y, to.z);
    match edit {
        ScriptedEdit::Move { object, to } => format!("{object} to {}", at(to)),
        ScriptedEdit::Turn { object, to } => format!("{object} turned to {}", at(to)),
        ScriptedEdit::Drag { object, to, .. } => format!("{object} dragged to {}", at(to)),
    }
}

/// `None` if interrupted.
fn chapter(
    drained: &Solution,
    configuration: &Configuration,
    orders: &[OrderArgument],
    title: String,
    quiet: bool,
) -> Result<Option<(Chapter, Solution)>, Failure> {
    let pool = *drained.pool();
    let after = Arc::new(drained.world().moved_to(configuration));
    let relevant = Relevant::find(&pool, drained.rules(), drained.world(), &after);
    let mut tracks = Vec::new();
    for (order, name) in orders.iter().map(|o| o.order()) {
        let bar = progress::bar(1000, &format!("{title}, {name}"), quiet);
        let recovery = recover(drained, &after, order, &relevant, FirstHits::AsLampsSay, &mut |share| {
            bar.set_position((share * 1000.0) as u64);
            !progress::interrupted()
        });
        bar.finish_and_clear();
        let Some(recovery) = recovery else { return Ok(None) };
        tracks.push(Track { order: name, recovery, bit_equal: false });
    }
    // The judge starts from nothing, with other trees.
    let fresh_world = Arc::new(World::new(configuration, TreePreset::Fast));
    let Ok(fresh) = shoot(&pool, fresh_world, "fresh solution", quiet) else { return Ok(None) };
    for track in &mut tracks {
        let solution = &track.recovery.solution;
        track.bit_equal = solution.buckets() == fresh.buckets() && solution.tallies() == fresh.tallies();
    }
    let chapter = Chapter { title, relevant: relevant.count(), photons: pool.photons(), tracks };
    Ok(Some((chapter, fresh)))
}

fn print_chapter(chapter: &Chapter) {
    let share = chapter.relevant as f64 / chapter.photons as f64 * 100.0;
    say(&format!("\n{}: {} relevant photons ({share:.3} %)", chapter.title, chapter.relevant));
    let unit = chapter.oracle_rays();
    say(&format!(
        "{:<10} {:>36}  {:>8}  bits",
        "order",
        if unit.is_some() { "rays to 50/90/99/100 %, × oracle" } else { "rays to 50/90/99/100 %" },
        "seconds"
    ));
    for track in &chapter.tracks {
        let multiples: Vec<String> = SHARES
            .iter()
            .map(|(_, share)| {
                let rays = track.recovery.reached(*share, chapter.relevant).work.rays as f64;
                unit.map_or(format!("{rays}"), |u| format!("{:.2}", rays / (u as f64 * share)))
            })
            .collect();
        let seconds = track.recovery.moments.last().map_or(0.0, |m| m.seconds);
        let bits = if track.bit_equal { "equal" } else { "DIFFER" };
        say(&format!("{:<10} {:>36}  {seconds:>8.2}  {bits}", track.order, multiples.join(" / ")));
    }
}

fn chapter_json(number: usize, chapter: &Chapter) -> Value {
    let orders: Map<String, Value> = chapter
        .tracks
        .iter()
        .map(|track| {
            let of = |value: fn(&Moment) -> Value| -> Map<String, Value> {
                SHARES.iter().map(|(name, share)| (name.to_string(), value(&track.recovery.reached(*share, chapter.relevant)))).collect()
            };
            let value = json!({
                "photons": of(|m| m.work.photons.into()), "rays": of(|m| m.work.rays.into()), "seconds": of(|m| m.seconds.into()),
                "drained": track.recovery.moments.last().map(|m| json!({ "photons": m.work.photons, "rays": m.work.rays, "seconds": m.seconds })),
                "bit_equal_to_fresh": track.bit_equal,
            });
            (track.order.to_owned(), value)
        })
        .collect();
    json!({ "edit": number, "title": chapter.title, "relevant_photons": chapter.relevant, "orders": orders })
}

fn write_csv(out: &mut impl Write, chapters: &[Chapter]) -> std::io::Result<()> {
    writeln!(out, "edit,order,photons,rays,seconds,repaired,relevant")?;
    for (number, chapter) in chapters.iter().enumerate() {
        for track in &chapter.tracks {
            for m in &track.recovery.moments {
                let Moment { work, seconds, repaired } = m;
                writeln!(
                    out,
                    "{number},{},{},{},{seconds:.6},{repaired},{}",
                    track.order, work.photons, work.rays, chapter.relevant
                )?;
            }
        }
    }
    Ok(())
}
