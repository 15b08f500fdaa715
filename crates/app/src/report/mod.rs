//! `lightmend report`: speed against error, from the cold start and after every edit, in several orders, as one page.
//!
//! Scenes and moves are read ([`jobs`]) before any work. Each state of a scene gets a reference and a fresh solution ([`judge`],
//! [`frames`]); the light is followed there in every order, looked at now and then with the clock stopped ([`curve`], [`state`]).
//! What came of it becomes tables ([`table`]), plots ([`plot`]) and the page ([`page`]).

mod curve;
mod frames;
mod jobs;
mod judge;
mod page;
mod plot;
mod readout;
mod state;
mod table;

use crate::{
    Common, PoolArguments,
    failure::Failure,
    indirect::IndirectLight,
    masking::Maskings,
    output::{self, say},
    progress,
    replay::without_doubles,
};
use curve::OrderArgument;
use jobs::Job;
use judge::Instruments;
use serde_json::json;
use state::{Measurer, State};
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Arguments {
    /// Scene files
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Moves file, instead of those in the folder moves/ beside a scene NAME/NAME.ron; may be given several times
    #[arg(long, value_name = "MOVES")]
    script: Vec<PathBuf>,
    /// Folder for index.html, table.csv, curves.csv, summary.json, and each figure as SVG and PNG
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    pool: PoolArguments,
    /// Orders to compare: ledger, stateless, random, restart
    #[arg(long, value_name = "ORDERS", value_delimiter = ',', default_value = "ledger,stateless,random,restart")]
    orders: Vec<OrderArgument>,
    /// Photons of each state's reference, 16 times the pool by default. More: errors far below the pool's can be told, longer work
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    reference_photons: Option<u64>,
    #[command(flatten)]
    common: Common,
}

/// What was measured in a scene.
pub struct Section {
    /// The scene and its pool.
    pub job: Job,
    /// The cold start, then the edits.
    pub states: Vec<State>,
}

/// What all figures share.
pub struct Machine {
    /// Threads that traced.
    pub threads: usize,
    /// The processor's name.
    pub processor: String,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let common = &arguments.common;
    common.set_up()?;
    let jobs = jobs::read(arguments)?;
    let orders = without_doubles(&arguments.orders);
    let out = output::folder(&arguments.out, &["index.html", "table.csv", "curves.csv", "summary.json"].map(str::to_owned))?;
    let machine = Machine { threads: rayon::current_num_threads(), processor: processor() };

    let mut instruments =
        Instruments { renderer: frames::renderer(common), reader: IndirectLight::default(), maskings: Maskings::new() };
    let mut sections = Vec::new();
    for job in jobs {
        if progress::interrupted() {
            break;
        }
        let measurer = Measurer { job: &job, orders: &orders, common };
        let mut states = Vec::new();
        let ended = measurer.measure(&mut instruments, &mut |state| {
            if common.talks() {
                say(&table::text(&job, &state));
            }
            states.push(state);
        });
        sections.push(Section { job, states });
        ended?;
    }
    let states = || sections.iter().flat_map(|section| &section.states);
    if states().next().is_none() {
        return Err(Failure::failed("interrupted before the first state was measured; nothing was written"));
    }
    write(&out, &machine, &sections, common)?;
    if let Some(state) = states().find(|state| !state.holds()) {
        let what = format!("{}: light or its balance is not that of a fresh solution: this is a bug in Lightmend", state.title);
        return Err(Failure::failed(what));
    }
    match (progress::interrupted(), states().count()) {
        (true, number) => Err(Failure::failed(format!("interrupted; what {number} states showed was kept"))),
        (false, _) => Ok(()),
    }
}

fn write(out: &std::path::Path, machine: &Machine, sections: &[Section], common: &Common) -> Result<(), Failure> {
    output::write(&out.join("table.csv"), |file| table::write_table(file, sections))?;
    output::write(&out.join("curves.csv"), |file| table::write_curves(file, sections))?;
    let figures = plot::write(out, machine, sections)?;
    output::write(&out.join("index.html"), |file| page::write(file, machine, sections, &figures))?;
    let summary = json!({
        "threads": machine.threads, "processor": machine.processor, "interrupted": progress::interrupted(),
        "scenes": sections.iter().map(table::json).collect::<Vec<_>>(),
    });
    output::json(Some(&out.join("summary.json")), &summary, common.json)?;
    if common.talks() {
        say(&format!("page: {}", out.join("index.html").display()));
    }
    Ok(())
}

/// The name of the processor, where the system tells it; of its kind otherwise.
fn processor() -> String {
    let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = told.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    name.map_or(std::env::consts::ARCH, |(_, name)| name.trim()).to_owned()
}
