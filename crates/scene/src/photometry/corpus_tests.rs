//! Every LM-63 file of the outside corpus (`LIGHTMEND_CORPUS`): read, integrated and sampled.

use crate::Photometry;
use glam::DVec3;
use std::path::{Path, PathBuf};

/// Zones of 10° in γ by 45° in C.
const ZONES: usize = 18 * 8;
/// Midpoints of the quadrature: 0.1° in γ by 1° in C, whole numbers of them in a zone.
const FINE: (usize, usize) = (1800, 360);
const SAMPLES: usize = 200_000;

fn corpus() -> Option<PathBuf> {
    let folder = std::env::var_os("LIGHTMEND_CORPUS").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: LIGHTMEND_CORPUS is not set");
    }
    folder
}

/// The `.ies` files below a folder, sorted.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ies")) {
                found.push(path);
            }
        }
    }
    found.sort();
    assert!(!found.is_empty());
    found
}

fn readable(corpus: &Path) -> Vec<(PathBuf, Photometry)> {
    let read = files(&corpus.join("ies")).into_iter().filter_map(|f| Photometry::read(&f).ok().map(|p| (f, p.0)));
    read.collect()
}

fn zone(c: f64, gamma: f64) -> usize {
    (gamma / 10.0).min(17.0) as usize * 8 + (c / 45.0).min(7.0) as usize
}

/// Flux per zone and flux times direction, lumens, by midpoints.
fn quadrature(p: &Photometry) -> (Vec<f64>, DVec3) {
    let (step, turn) = (180.0 / FINE.0 as f64, 360.0 / FINE.1 as f64);
    let mut flux = vec![0.0; ZONES];
    let mut mean = DVec3::ZERO;
    let around: Vec<(f64, f64)> = (0..FINE.1).map(|k| ((k as f64 + 0.5) * turn).to_radians().sin_cos()).collect();
    for row in 0..FINE.0 {
        let gamma = (row as f64 + 0.5) * step;
        let (sin, cos) = gamma.to_radians().sin_cos();
        for (k, (sin_c, cos_c)) in around.iter().enumerate() {
            let c = (k as f64 + 0.5) * turn;
            let lumens = p.candela_at(c, gamma) * sin * step.to_radians() * turn.to_radians();
            flux[zone(c, gamma)] += lumens;
            mean += lumens * DVec3::new(sin * cos_c, sin * sin_c, -cos);
        }
    }
    (flux, mean)
}

/// Only the file that is there to be malformed fails, and says where.
#[test]
fn the_corpus_is_read() {
    let Some(corpus) = corpus() else { return };
    for file in files(&corpus.join("ies")) {
        match Photometry::read(&file) {
            Ok((p, warnings)) => {
                assert!(p.luminous_flux() > 0.0, "{}", file.display());
                warnings.iter().for_each(|w| println!("{w}"));
            }
            Err(error) => {
                println!("{error}");
                assert!(file.ends_with("test_file_format_error.ies"), "{error}");
                assert!(error.to_string().contains("test_file_format_error.ies:3: "), "{error}");
            }
        }
    }
}

/// The corpus lists the flux that another reader found: `| ies/file | ... | flux (ninth cell) | ...`, one decimal.
#[test]
fn flux_agrees_with_the_list_of_the_corpus() {
    let Some(corpus) = corpus() else { return };
    let list = std::fs::read_to_string(corpus.join("MANIFEST.md")).unwrap();
    let mut compared = 0;
    for line in list.lines().filter(|line| line.starts_with("| ies/")) {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let (true, Some(Ok(want))) = (cells[1].ends_with(".ies"), cells.get(8).map(|c| c.parse::<f64>())) else { continue };
        let flux = Photometry::read(&corpus.join(cells[1])).unwrap().0.luminous_flux();
        assert!((flux - want).abs() < 0.051 + 5e-5 * want, "{}: {flux}, listed {want}", cells[1]);
        compared += 1;
    }
    assert!(compared >= 30, "{compared}");
}

/// Flux and samples against the quadrature. Shares: 4 standard errors of independent samples, which these even ones
/// do not reach, plus the quadrature's own error. Mean direction: likewise, each component within [-1, 1].
#[test]
fn samples_follow_the_intensity() {
    let Some(corpus) = corpus() else { return };
    for (file, p) in readable(&corpus) {
        let (zones, mean) = quadrature(&p);
        let flux = p.luminous_flux();
        assert!((zones.iter().sum::<f64>() / flux - 1.0).abs() < 1e-3, "{}: {flux}", file.display());

        let mut counts = vec![0_usize; ZONES];
        let mut sum = DVec3::ZERO;
        for k in 0..SAMPLES {
            // The plane's R2 sequence (Roberts 2018).
            let (u, v) = ((0.5 + k as f64 * 0.7548776662466927) % 1.0, (0.5 + k as f64 * 0.5698402909980532) % 1.0);
            let d = p.sample(u, v);
            assert!(d.is_normalized() && p.candela(d) > 0.0, "{}: ({u}, {v}) {d}", file.display());
            sum += d;
            let c = d.y.atan2(d.x).to_degrees().rem_euclid(360.0);
            counts[zone(c, d.x.hypot(d.y).atan2(-d.z).to_degrees())] += 1;
        }
        for (k, (&count, &lumens)) in counts.iter().zip(&zones).enumerate() {
            let (share, want) = (count as f64 / SAMPLES as f64, lumens / flux);
            let slack = 4.0 * (want * (1.0 - want) / SAMPLES as f64).sqrt() + 2e-4 * want;
            assert!(want < 0.01 || (share - want).abs() < slack, "{}: zone {k} {share} {want}", file.display());
        }
        let off = (sum / SAMPLES as f64 - mean / flux).abs().max_element();
        assert!(off < 4.0 / (SAMPLES as f64).sqrt(), "{}: mean direction off by {off}", file.display());
    }
}
