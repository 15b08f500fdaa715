//! Points of surfaces as CSV, and the light that was found there.

use crate::failure::Failure;
use glam::DVec3;
use lightmend_photon::{
    probe::{Place, locate},
    world::World,
};
use lightmend_scene::{SceneError, luminance};
use std::{
    io::{self, Write},
    path::{Path, PathBuf},
};

/// Where the points come from and where their light goes: what `probe` and `reference` have in common.
#[derive(clap::Args)]
pub struct Files {
    /// Scene file
    pub scene: PathBuf,
    /// Points: a CSV file with the header x,y,z,nx,ny,nz (metres; unit normals, whose side counts)
    #[arg(long, value_name = "IN.csv")]
    pub points: PathBuf,
    /// The CSV file to write; `probe` and `reference` have the same columns
    #[arg(long, value_name = "OUT.csv")]
    pub out: PathBuf,
}

/// The points of a file.
pub struct Points {
    path: PathBuf,
    /// Line numbers, points and unit normals, whose side counts.
    lines: Vec<(usize, DVec3, DVec3)>,
}

impl Points {
    /// Reads the columns x, y, z, nx, ny, nz.
    pub fn read(path: &Path) -> Result<Points, Failure> {
        let text = std::fs::read_to_string(path).map_err(|e| SceneError::read(path, e))?;
        let mut lines = text.lines().enumerate().map(|(n, line)| (n + 1, line.trim()));
        let header = lines.next().map_or("", |(_, line)| line.trim_start_matches('\u{feff}'));
        if header.split(',').map(str::trim).ne("x,y,z,nx,ny,nz".split(',')) {
            return Err(SceneError::line(path, 1, "the header must be x,y,z,nx,ny,nz").into());
        }
        let mut points = Points { path: path.to_owned(), lines: Vec::new() };
        for (number, line) in lines.filter(|(_, line)| !line.is_empty()) {
            let values: Result<Vec<f64>, _> = line.split(',').map(|v| v.trim().parse::<f64>()).collect();
            let fault = |what: &str| Failure::from(SceneError::line(path, number, what));
            let v = values.map_err(|_| fault("not six numbers"))?;
            let [x, y, z, nx, ny, nz] = v[..] else { return Err(fault("not six numbers")) };
            let (point, normal) = (DVec3::new(x, y, z), DVec3::new(nx, ny, nz));
            if !point.is_finite() || !normal.is_finite() || (normal.length() - 1.0).abs() >= 1e-3 {
                return Err(fault("the normal must have length 1 and all must be numbers"));
            }
            points.lines.push((number, point, normal.normalize()));
        }
        Ok(points)
    }

    /// Where they lie in a world; refuses those that lie on no surface.
    pub fn locate(&self, world: &World) -> Result<Vec<Place>, Failure> {
        let origin = world.configuration().scene().file.origin;
        let place = |(line, point, normal): &(usize, DVec3, DVec3)| {
            locate(world, *point - origin, *normal).ok_or_else(|| {
                let what = format!("no surface facing {normal} is near the point {point}: move the point onto one");
                SceneError::line(&self.path, *line, what).into()
            })
        };
        self.lines.iter().map(place).collect()
    }
}

/// Irradiance at a point, lux per channel.
pub struct Light {
    /// Of the lamps themselves; exact.
    pub direct: DVec3,
    /// Of all surfaces.
    pub indirect: DVec3,
    /// One standard error of the indirect.
    pub standard_error: DVec3,
}

/// Writes points with their light; `origin` is the scene's.
pub fn write(out: &mut impl Write, origin: DVec3, lit: impl IntoIterator<Item = (Place, Light)>) -> io::Result<()> {
    writeln!(
        out,
        "x,y,z,nx,ny,nz,direct_r,direct_g,direct_b,indirect_r,indirect_g,indirect_b,\
         indirect_se_r,indirect_se_g,indirect_se_b,illuminance"
    )?;
    for (Place { point: p, normal: n, .. }, light) in lit {
        let p = p + origin;
        write!(out, "{},{},{},{},{},{}", p.x, p.y, p.z, n.x, n.y, n.z)?;
        for v in [light.direct, light.indirect, light.standard_error] {
            write!(out, ",{:.6},{:.6},{:.6}", v.x, v.y, v.z)?;
        }
        writeln!(out, ",{:.6}", luminance(light.direct + light.indirect))?;
    }
    Ok(())
}
