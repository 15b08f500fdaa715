//! Hard numerical cases: what is right by a closed form or by invariance, and what was measured.
//!
//! One file per group, each of which makes the rows of its table in `docs/hard-cases.md`. To add a case, return one more [`lightmend_tests::table::Row`] from a
//! group, and write the document anew (`tests/support/table.rs` says how). A bug that a case finds gets a test of its own name in `regressions.rs`.

mod accumulation;
mod files;
mod gaps;
mod lamps;
mod long_paths;
mod moves;
mod regressions;
mod scale;
mod sequence;
mod sound;
mod thin;
mod triangles;
mod views;

use lightmend_tests::table::hold;

#[test]
fn long_paths() {
    hold("long paths", &long_paths::rows());
}

#[test]
fn thin_and_touching() {
    hold("thin and touching", &thin::rows());
}

#[test]
fn lamps() {
    hold("lamps", &lamps::rows());
}

#[test]
fn scale_and_offset() {
    hold("scale and offset", &scale::rows());
}

#[test]
fn bad_triangles() {
    hold("bad triangles", &triangles::rows());
}

#[test]
fn gaps() {
    hold("gaps", &gaps::rows());
}

#[test]
fn moves() {
    hold("moves", &moves::rows());
}

#[test]
fn degenerate_views() {
    hold("degenerate views", &views::rows());
}

#[test]
fn sequence() {
    hold("sequence", &sequence::rows());
}

#[test]
fn accumulation() {
    hold("accumulation", &accumulation::rows());
}

#[test]
fn files() {
    hold("files", &files::rows());
}
