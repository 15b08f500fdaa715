//! How time and memory grow with the pool, with mesh elements and triangles, and with movable objects.
//!
//! ```text
//! cargo run --release -p lightmend-photon --example scaling -- scenes OUT [--threads N] [--only START]
//! ```
//!
//! Every point is measured by a process of its own, so that its peak of memory is its own, and kept in OUT/points. `--only` measures the points whose
//! names start so (`pool_room_1`; `none` for none of them). OUT/scaling.csv and the pictures are of all points that were ever measured, with
//! the exponents that least squares find in logarithms. docs/performance.md reads them. Linux only: proc(5).

mod measure;
#[path = "../support/picture.rs"]
mod picture;
mod plots;
mod point;
mod process;
mod scenes;
#[path = "../support/times.rs"]
mod times;

use measure::{BUDGET, Row, measure};
use point::Point;
use std::{
    collections::BTreeMap,
    error::Error,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

const USAGE: &str = "usage: scaling SCENES OUT [--threads N] [--only START]";

struct Arguments {
    scenes: PathBuf,
    out: PathBuf,
    /// 0: as many as there are processors.
    threads: usize,
    only: String,
    /// Measure this one, in this process.
    point: Option<String>,
}

impl Arguments {
    fn parse(mut next: impl Iterator<Item = String>) -> Result<Arguments, Box<dyn Error>> {
        let (scenes, out) = (next.next().ok_or(USAGE)?.into(), next.next().ok_or(USAGE)?.into());
        let mut arguments = Arguments { scenes, out, threads: 0, only: String::new(), point: None };
        while let Some(name) = next.next() {
            let value = next.next().ok_or_else(|| format!("{name} lacks its value; {USAGE}"))?;
            match name.as_str() {
                "--threads" => arguments.threads = value.parse()?,
                "--only" => arguments.only = value,
                "--point" => arguments.point = Some(value),
                _ => return Err(format!("{name} is unknown; {USAGE}").into()),
            }
        }
        Ok(arguments)
    }
}

/// What was measured of a point.
pub struct Measured {
    /// It.
    pub point: Point,
    /// By column; seconds and bytes.
    pub values: BTreeMap<String, f64>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse(std::env::args().skip(1))?;
    let Arguments { scenes, out, threads, only, point } = &arguments;
    if let Some(name) = point {
        rayon::ThreadPoolBuilder::new().num_threads(*threads).build_global()?;
        let point = Point::all().into_iter().find(|point| point.name() == *name).ok_or("there is no such point")?;
        let row = measure(&point, scenes, out)?;
        let lines: String = row.iter().map(|(column, value)| format!("{column}\t{value}\n")).collect();
        return Ok(fs::write(file_of(out, &point), lines)?);
    }
    fs::create_dir_all(out.join("points"))?;
    for point in Point::all().iter().filter(|point| point.name().starts_with(only)) {
        println!("{} …", point.name());
        let status = Command::new(std::env::current_exe()?)
            .args([scenes.as_os_str(), out.as_os_str(), "--threads".as_ref(), threads.to_string().as_ref()])
            .args(["--point", &point.name()])
            .status()?;
        if !status.success() {
            return Err(format!("{} failed", point.name()).into());
        }
    }
    let mut measured = Vec::new();
    for point in Point::all() {
        let Ok(text) = fs::read_to_string(file_of(out, &point)) else { continue };
        let row: Row = text
            .lines()
            .filter_map(|line| line.split_once('\t'))
            .map(|(column, value)| Ok((column.to_owned(), value.parse()?)))
            .collect::<Result<_, std::num::ParseFloatError>>()?;
        measured.push(Measured { point, values: row.into_iter().collect() });
    }
    fs::write(out.join("scaling.csv"), table(&measured))?;
    for Measured { point, values } in &measured {
        if let Some(peak) = values.get("peak bytes").filter(|peak| **peak > BUDGET) {
            println!("{}: {:.2} GB at its peak, more than {:.0}", point.name(), peak / 1e9, BUDGET / 1e9);
        }
    }
    plots::draw(out, &measured)
}

fn file_of(out: &Path, point: &Point) -> PathBuf {
    out.join("points").join(format!("{}.tsv", point.name()))
}

/// All that was measured, in columns that some point has.
fn table(measured: &[Measured]) -> String {
    let mut columns: Vec<&String> = measured.iter().flat_map(|m| m.values.keys()).collect();
    columns.sort_unstable();
    columns.dedup();
    let heads = columns.iter().map(|column| column.replace(' ', "_"));
    let mut text = ["axis".into(), "scene".into()].into_iter().chain(heads).collect::<Vec<String>>().join(",") + "\n";
    for Measured { point, values } in measured {
        let cells = columns.iter().map(|column| values.get(*column).map_or_else(String::new, f64::to_string));
        let cells = [point.axis().to_owned(), point.scene.to_owned()].into_iter().chain(cells);
        text += &(cells.collect::<Vec<String>>().join(",") + "\n");
    }
    text
}
