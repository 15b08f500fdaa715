//! `lightmend probe`: irradiance at points of surfaces.

use crate::{
    Common, PoolArguments,
    failure::Failure,
    output::{self, say},
    progress,
};
use glam::DVec3;
use lightmend_photon::{
    body::TreePreset,
    irradiance::Scale,
    path::FirstHits,
    probe::{Reading, locate, read},
    solution::Solution,
    world::World,
};
use lightmend_scene::{Configuration, SceneError, luminance};
use std::{
    io::Write,
    path::{Path, PathBuf},
    sync::Arc,
};

#[derive(clap::Args)]
pub struct Arguments {
    /// Scene file
    scene: PathBuf,
    /// Points: a CSV file with the header x,y,z,nx,ny,nz (metres; unit normals, whose side counts)
    #[arg(long, value_name = "IN.csv")]
    points: PathBuf,
    /// The CSV file to write
    #[arg(long, value_name = "OUT.csv")]
    out: PathBuf,
    #[command(flatten)]
    pool: PoolArguments,
    #[command(flatten)]
    common: Common,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let common = &arguments.common;
    common.set_up()?;
    let points = read_points(&arguments.points)?;
    let scene = common.read_scene(&arguments.scene)?;
    let pool = arguments.pool.pool(&scene)?;
    output::file(&arguments.out)?;
    let world = Arc::new(World::new(&Configuration::initial(&scene), TreePreset::default()));
    let mut places = Vec::new();
    for (line, (point, normal)) in &points {
        places.push(locate(&world, *point, *normal).ok_or_else(|| {
            let what = format!("no surface facing {normal} is near the point {point}: move the point onto one");
            Failure::from(SceneError::line(&arguments.points, line, what))
        })?);
    }
    let bar = progress::bar(pool.photons(), "shooting photons", common.quiet);
    // Buckets of indirect light alone: the direct part is computed at the points.
    let solution = Solution::shoot(pool, world.clone(), FirstHits::Never, &mut |photons, _| {
        bar.set_position(photons);
        !progress::interrupted()
    });
    bar.finish_and_clear();
    let solution = solution.ok_or_else(|| Failure::failed("interrupted before there were enough photons to keep"))?;
    let photons = solution.pool().photons();
    let scale = Scale::new(&world, photons);
    let readings: Vec<Reading> = places.iter().map(|place| read(&world, solution.buckets(), &scale, place)).collect();
    output::write(&arguments.out, |file| write_readings(file, &points, &readings))?;
    if common.json {
        output::json(None, &serde_json::json!({ "points": points.len(), "photons": photons, "out": arguments.out }), true)?;
    } else if common.talks() {
        say(&format!("{} points read from {photons} photons: {}", points.len(), arguments.out.display()));
    }
    if progress::interrupted() { Err(Failure::failed(format!("interrupted; {photons} photons were kept"))) } else { Ok(()) }
}

/// Line numbers, points and normals.
type Points = Vec<(usize, (DVec3, DVec3))>;

fn read_points(path: &Path) -> Result<Points, Failure> {
    let text = std::fs::read_to_string(path).map_err(|e| SceneError::read(path, e))?;
    let mut lines = text.lines().enumerate().map(|(n, line)| (n + 1, line.trim()));
    let header = lines.next().map_or("", |(_, line)| line.trim_start_matches('\u{feff}'));
    if header.split(',').map(str::trim).ne("x,y,z,nx,ny,nz".split(',')) {
        return Err(SceneError::line(path, 1, "the header must be x,y,z,nx,ny,nz").into());
    }
    let mut points = Vec::new();
    for (number, line) in lines.filter(|(_, line)| !line.is_empty()) {
        let values: Result<Vec<f64>, _> = line.split(',').map(|v| v.trim().parse::<f64>()).collect();
        let fault = |what: &str| Failure::from(SceneError::line(path, number, what));
        let v = values.map_err(|_| fault("not six numbers"))?;
        let [x, y, z, nx, ny, nz] = v[..] else { return Err(fault("not six numbers")) };
        let (point, normal) = (DVec3::new(x, y, z), DVec3::new(nx, ny, nz));
        if !point.is_finite() || !normal.is_finite() || (normal.length() - 1.0).abs() >= 1e-3 {
            return Err(fault("the normal must have length 1 and all must be numbers"));
        }
        points.push((number, (point, normal.normalize())));
    }
    Ok(points)
}

fn write_readings(out: &mut impl Write, points: &Points, readings: &[Reading]) -> std::io::Result<()> {
    writeln!(
        out,
        "x,y,z,nx,ny,nz,direct_r,direct_g,direct_b,indirect_r,indirect_g,indirect_b,\
         indirect_se_r,indirect_se_g,indirect_se_b,illuminance"
    )?;
    for ((_, (p, n)), reading) in points.iter().zip(readings) {
        let Reading { direct, indirect } = reading;
        write!(out, "{},{},{},{},{},{}", p.x, p.y, p.z, n.x, n.y, n.z)?;
        for v in [*direct, indirect.value, indirect.standard_error] {
            write!(out, ",{:.6},{:.6},{:.6}", v.x, v.y, v.z)?;
        }
        writeln!(out, ",{:.6}", luminance(*direct + indirect.value))?;
    }
    Ok(())
}
