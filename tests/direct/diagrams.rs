//! Goniometric diagrams: files made by hand, our scenes' and the corpus's, and their cube maps against them.

use glam::DVec3;
use lightmend_raster::goniometric::{CubeMap, FINEST};
use lightmend_scene::Photometry;
use std::path::{Path, PathBuf};

/// The text of a photometric file.
fn ies(gammas: &[f64], planes: &[f64], candela: impl Fn(f64, f64) -> f64) -> String {
    let row = |values: &mut dyn Iterator<Item = f64>| values.map(|v| format!("{v:.4}")).collect::<Vec<_>>().join("\n");
    let table = planes.iter().map(|c| row(&mut gammas.iter().map(|gamma| candela(*c, *gamma)))).collect::<Vec<_>>().join("\n");
    let [gamma, c] = [gammas, planes].map(|angles| row(&mut angles.iter().copied()));
    format!("IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 {} {} 1 2 0 0 0\n1 1 10\n{gamma}\n{c}\n{table}\n", gammas.len(), planes.len())
}

fn every(step: usize, from: usize, to: usize) -> Vec<f64> {
    (from..=to).step_by(step).map(|x| x as f64).collect()
}

/// All that differs between planes and cones, but the same in all planes at the poles.
fn lopsided(c: f64, gamma: f64) -> f64 {
    let away = gamma.to_radians().sin();
    900.0 + 300.0 * away * (c - 25.0).to_radians().cos() + 150.0 * away * away * (3.0 * c + 40.0).to_radians().sin() - 2.0 * gamma
}

/// Files made by hand: a name and the text.
pub fn hand_made() -> Vec<(String, String)> {
    let beam = |width: f64| move |_: f64, gamma: f64| 20_000.0 * (-(gamma / width) * (gamma / width)).exp();
    let files = [
        ("narrow beam in steps of 1°", ies(&every(1, 0, 90), &[0.0], beam(4.0))),
        ("light up to the edge at 90°", ies(&[0.0, 30.0, 60.0, 90.0], &[0.0], |_, gamma| 80.0 + gamma)),
        ("hole at the pole", ies(&every(6, 12, 150), &[0.0], |_, gamma| 300.0 - gamma)),
        ("light upwards only", ies(&every(10, 90, 180), &every(30, 0, 180), lopsided)),
        ("full circle", ies(&every(15, 0, 180), &every(45, 0, 360), lopsided)),
        ("full circle left open", ies(&every(15, 0, 180), &every(24, 0, 336), lopsided)),
        ("quadrant", ies(&every(10, 0, 120), &every(30, 0, 90), lopsided)),
        ("bilateral", ies(&every(10, 0, 90), &every(30, 0, 180), lopsided)),
        ("bilateral across", ies(&every(10, 0, 90), &every(45, 90, 270), lopsided)),
        (
            "another candela in each plane at the pole",
            ies(&every(15, 0, 90), &every(45, 0, 360), |c, _| 500.0 + c.min(360.0 - c)),
        ),
    ];
    files.into_iter().map(|(name, text)| (name.to_owned(), text)).collect()
}

/// Narrower than any map can hold.
pub fn laser() -> String {
    ies(&[0.0, 0.12, 0.25, 90.0], &[0.0], |_, gamma| if gamma < 0.2 { 1e6 } else { 0.0 })
}

/// The files of our own scenes.
pub fn own() -> Vec<PathBuf> {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes");
    let mut found = Vec::new();
    for scene in ["room", "house"] {
        files_below(&scenes.join(scene).join("ies"), &mut found);
    }
    assert!(found.len() >= 6);
    found
}

/// The files of the corpus.
pub fn corpus() -> Vec<PathBuf> {
    let mut found = Vec::new();
    match std::env::var_os("LIGHTMEND_CORPUS").map(PathBuf::from) {
        Some(folder) => files_below(&folder.join("ies"), &mut found),
        None => println!("skipped: LIGHTMEND_CORPUS is not set"),
    }
    found
}

fn files_below(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files_below(&path, found);
        } else if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ies")) {
            found.push(path);
        }
    }
    found.sort();
}

/// Intensities compared with a diagram's, direction by direction.
pub struct Verdict<'p> {
    photometry: &'p Photometry,
    /// Directions compared.
    pub compared: usize,
    /// Directions so near to the sharp edge of the measured range that rounding decides.
    pub edge: usize,
    /// Directions by a pole of which the file says something else in each plane.
    pub pole: usize,
    /// The largest error, as a share of the peak, and its direction.
    pub worst: (f64, DVec3),
}

/// Of the peak, everywhere.
pub const MOST: f64 = 0.01;

/// Single precision turns directions by no more than this, radians.
const ROUNDING: f64 = 1e-5;

/// As near as this, degrees, to a pole of which the file says something else in each plane, any plane is as good as another.
const BY_THE_POLE: f64 = 1.0;

impl Verdict<'_> {
    pub fn new(photometry: &Photometry) -> Verdict<'_> {
        Verdict { photometry, compared: 0, edge: 0, pole: 0, worst: (0.0, DVec3::ZERO) }
    }

    /// Adds what was found for a direction in the lamp's axes; returns the error as a share of the peak.
    pub fn add(&mut self, d: DVec3, found: f64) -> f64 {
        let p = self.photometry;
        let peak = p.max_candela();
        let gamma = d.x.hypot(d.y).atan2(-d.z).to_degrees();
        let (first, last) = (p.vertical()[0], p.vertical()[p.vertical().len() - 1]);
        let ends = [first, last].into_iter().filter(|gamma| *gamma > 0.0 && *gamma < 180.0);
        if ends.into_iter().any(|end| (gamma - end).abs().to_radians() < ROUNDING) {
            self.edge += 1;
            return 0.0;
        }
        let mut error = (found - p.candela(d)) / peak;
        let pole = if gamma < BY_THE_POLE { 0.0 } else { 180.0 };
        if (gamma - pole).abs() < BY_THE_POLE && self.spread(pole).1 > self.spread(pole).0 + 1e-6 * peak {
            self.pole += 1;
            let (low, high) = self.spread(gamma);
            error = error.signum() * error.abs().min((found - high).max(low - found).max(0.0) / peak);
        }
        self.compared += 1;
        if error.abs() > self.worst.0 {
            self.worst = (error.abs(), d);
        }
        error
    }

    /// The least and the most candela of all planes at γ.
    fn spread(&self, gamma: f64) -> (f64, f64) {
        let around = || self.photometry.horizontal().iter().map(|c| self.photometry.candela_at(*c, gamma));
        (around().fold(f64::INFINITY, f64::min), around().fold(0.0, f64::max))
    }

    /// One line.
    pub fn line(&self) -> String {
        let (error, d) = self.worst;
        let (c, gamma) = (d.y.atan2(d.x).to_degrees(), d.x.hypot(d.y).atan2(-d.z).to_degrees());
        let left = format!("{} at the edge, {} by a pole", self.edge, self.pole);
        format!("worst {:.3} % of the peak at C {c:.2}°, γ {gamma:.2}° of {} directions ({left})", 100.0 * error, self.compared)
    }
}

/// Evenly spread directions (a Fibonacci lattice).
fn directions(count: u32) -> impl Iterator<Item = DVec3> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count).map(move |k| {
        let z = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(count);
        let (sin, cos) = (golden * f64::from(k)).sin_cos();
        DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z)
    })
}

fn check(name: &str, photometry: &Photometry) {
    let map = CubeMap::new(photometry, FINEST);
    let mut verdict = Verdict::new(photometry);
    for d in directions(100_000) {
        verdict.add(d, map.candela(d));
    }
    println!("{name}: {}; {} intervals, by its own account {:.3} %", verdict.line(), map.intervals, 100.0 * map.error);
    // Of bad maps the frame warns.
    assert!(verdict.worst.0 <= MOST || map.bad(), "{name}: the map errs without a warning: {}", verdict.line());
    assert!(verdict.edge < 100 && verdict.pole < 100);
}

#[test]
fn cube_maps_hold_diagrams_to_one_per_cent() {
    for (name, text) in hand_made() {
        check(&name, &Photometry::parse(text.as_bytes(), Path::new("made.ies")).unwrap().0);
    }
    for file in own() {
        check(&file.file_name().unwrap().to_string_lossy(), &Photometry::read(&file).unwrap().0);
    }
    check("laser", &Photometry::parse(laser().as_bytes(), Path::new("laser.ies")).unwrap().0);
}

#[test]
fn cube_maps_hold_the_diagrams_of_the_corpus() {
    for file in corpus() {
        // One is malformed on purpose, some are of another type.
        let Ok((photometry, _)) = Photometry::read(&file) else { continue };
        check(&file.file_name().unwrap().to_string_lossy(), &photometry);
    }
}

#[test]
fn a_diagram_of_another_plane_is_found_out() {
    let file = |text: String| Photometry::parse(text.as_bytes(), Path::new("made.ies")).unwrap().0;
    let planes = every(45, 0, 360);
    let turned = file(ies(&every(15, 0, 180), &planes, |c, gamma| lopsided(-c, gamma)));
    let right = file(ies(&every(15, 0, 180), &planes, lopsided));
    let map = CubeMap::new(&turned, FINEST);
    let mut verdict = Verdict::new(&right);
    for d in directions(1000) {
        verdict.add(d, map.candela(d));
    }
    assert!(verdict.worst.0 > 10.0 * MOST);
}
