//! Rows of the table of hard cases, and the document that holds them.
//!
//! `LIGHTMEND_UPDATE=1 cargo test --release -p lightmend-tests --test hard` (frames: `-p lightmend --test command_line hard`) writes what was measured
//! into `docs/hard-cases.md`, group by group; with `LIGHTMEND_THOROUGH=1` as well into its thorough tables.

use std::{
    fmt::Display,
    path::PathBuf,
    sync::{Mutex, PoisonError},
};

/// What became of a row.
#[derive(Debug, Clone, PartialEq)]
enum Verdict {
    Pass,
    Fail,
    /// Cannot be met, and why.
    Documented(String),
}

/// A quantity of a case: what is right and what was measured.
#[derive(Debug, Clone)]
pub struct Row {
    case: String,
    quantity: String,
    right: String,
    source: String,
    measured: String,
    tolerance: String,
    verdict: Verdict,
}

/// A few digits, as many as tell something.
pub fn digits(x: f64) -> String {
    match x.abs() {
        0.0 => "0".into(),
        a if (1e-3..1e7).contains(&a) => {
            let places = (5 - a.log10().floor() as i32).clamp(0, 9) as usize;
            let text = format!("{x:.places$}");
            if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
        }
        _ => format!("{x:.2e}"),
    }
}

impl Row {
    fn new(case: &str, quantity: &str, right: String, source: &str, measured: String, tolerance: String, met: bool) -> Row {
        let verdict = if met { Verdict::Pass } else { Verdict::Fail };
        Row { case: case.into(), quantity: quantity.into(), right, source: source.into(), measured, tolerance, verdict }
    }

    /// What must be so exactly.
    pub fn exactly<T: PartialEq + Display>(case: &str, quantity: &str, right: T, source: &str, measured: T) -> Row {
        let met = right == measured;
        Row::new(case, quantity, right.to_string(), source, measured.to_string(), "none".into(), met)
    }

    /// What must be right to a share of it.
    pub fn near(case: &str, quantity: &str, right: f64, source: &str, measured: f64, tolerance: f64) -> Row {
        let met = (measured - right).abs() <= tolerance * right.abs();
        Row::new(case, quantity, digits(right), source, digits(measured), format!("± {} %", digits(100.0 * tolerance)), met)
    }

    /// What must not be more.
    pub fn at_most(case: &str, quantity: &str, source: &str, measured: f64, most: f64) -> Row {
        Row::new(case, quantity, "0".into(), source, digits(measured), format!("≤ {}", digits(most)), measured <= most)
    }

    /// A row that cannot be met for a reason: it stays in the table as long as it is not met. `most` is what it may be off, as a share of what
    /// is right, before something else is wrong.
    pub fn documented(mut self, why: &str, within: bool) -> Row {
        if self.verdict == Verdict::Fail && within {
            self.verdict = Verdict::Documented(why.into());
        } else {
            self.verdict = Verdict::Fail;
        }
        self
    }

    fn line(&self) -> String {
        let verdict = match &self.verdict {
            Verdict::Pass => "pass".to_owned(),
            Verdict::Fail => "**FAIL**".to_owned(),
            Verdict::Documented(why) => format!("documented: {why}"),
        };
        let Row { case, quantity, right, source, measured, tolerance, .. } = self;
        format!("| {case} | {quantity} | {right} | {source} | {measured} | {tolerance} | {verdict} |")
    }
}

const HEAD: &str =
    "| case | quantity | right | where that comes from | measured | tolerance | |\n|---|---|---|---|---|---|---|\n";

static DOCUMENT: Mutex<()> = Mutex::new(());

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs/hard-cases.md")
}

/// The first two cells of a line.
fn title(line: &str) -> Option<(&str, &str)> {
    let mut cells = line.split(" | ");
    Some((cells.next()?.trim_start_matches("| "), cells.next()?))
}

/// Prints the rows of a group, keeps them in the document or sees that its table has the same rows, and fails if a row does.
pub fn hold(group: &str, rows: &[Row]) {
    let table: String = rows.iter().map(|row| row.line() + "\n").collect();
    println!("{table}");
    let thorough = std::env::var_os("LIGHTMEND_THOROUGH").is_some();
    let update = std::env::var_os("LIGHTMEND_UPDATE").is_some();
    let name = if thorough { format!("{group}, thorough") } else { group.to_owned() };
    let (begin, end) = (format!("<!-- {name} -->\n"), format!("<!-- end of {name} -->\n"));
    {
        let _one_at_a_time = DOCUMENT.lock().unwrap_or_else(PoisonError::into_inner);
        let document = std::fs::read_to_string(path()).unwrap();
        let (before, rest) = document.split_once(&begin).unwrap_or_else(|| panic!("docs/hard-cases.md has no {begin}"));
        let (old, after) = rest.split_once(&end).unwrap_or_else(|| panic!("docs/hard-cases.md has no {end}"));
        if update {
            let beside = path().with_extension("md.new");
            std::fs::write(&beside, format!("{before}{begin}{HEAD}{table}{end}{after}")).unwrap();
            std::fs::rename(beside, path()).unwrap();
        } else if !thorough {
            let [old, new]: [Vec<_>; 2] = [old.strip_prefix(HEAD).unwrap_or(old), &table].map(|t| t.lines().map(title).collect());
            assert!(old == new, "docs/hard-cases.md has other rows of {group}: write it anew (tests/support/table.rs says how)");
        }
    }
    let failed: Vec<String> = rows.iter().filter(|row| row.verdict == Verdict::Fail).map(Row::line).collect();
    assert!(failed.is_empty(), "{} of {} rows fail:\n{}", failed.len(), rows.len(), failed.join("\n"));
}
