//! A picture of a solution by casting a ray per sample: slow, simple, and right wherever the rasteriser must be.
//!
//! Direct light of rasteriser-drawn lamps by shadow rays, all other light from the element that is met, untouched by any filter:
//! what the buckets hold is what is seen.

use crate::{failure::Failure, output};
use glam::DVec3;
use lightmend_photon::{bucket::Buckets, irradiance::Scale, path, probe, visible::Lens, world::World};
use lightmend_scene::{Direct, Scene, View, luminance};
use rayon::prelude::*;
use std::path::Path;

const WIDTH: u32 = 640;
const HEIGHT: u32 = 480;
/// Samples per pixel, along each side.
const GRID: u32 = 2;

/// A file name for the picture of each camera: its name where a file can be called so, numbered where two would be the same, or the
/// same as one that is `taken`.
pub fn file_names(scene: &Scene, taken: &[&str]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (name, _) in &scene.cameras {
        let plain: String = name.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect();
        let numbered = (2..).map(|n| format!("{plain}_{n}.png"));
        let free =
            std::iter::once(format!("{plain}.png")).chain(numbered).find(|n| !names.contains(n) && !taken.contains(&n.as_str()));
        names.extend(free);
    }
    names
}

/// Writes a PNG of what `view` sees.
pub fn write(path: &Path, world: &World, buckets: &Buckets, scale: &Scale, view: &View) -> Result<(), Failure> {
    let radiance = render(world, buckets, scale, view);
    let exposure = exposure(&radiance);
    let pixels: Vec<u8> = radiance.iter().flat_map(|r| encode(*r * exposure)).collect();
    let image = image::RgbImage::from_raw(WIDTH, HEIGHT, pixels).ok_or_else(|| Failure::failed("the picture has no pixels"))?;
    output::png(path, &image)
}

fn render(world: &World, buckets: &Buckets, scale: &Scale, view: &View) -> Vec<DVec3> {
    let lens = Lens::new(view, world.configuration().scene().up);
    (0..HEIGHT * WIDTH)
        .into_par_iter()
        .map(|pixel| {
            let mut sum = DVec3::ZERO;
            for sample in 0..GRID * GRID {
                let x = f64::from(pixel % WIDTH) + (f64::from(sample % GRID) + 0.5) / f64::from(GRID);
                let y = f64::from(pixel / WIDTH) + (f64::from(sample / GRID) + 0.5) / f64::from(GRID);
                let (x, y) = ((2.0 * x - f64::from(WIDTH)) / f64::from(HEIGHT), 1.0 - 2.0 * y / f64::from(HEIGHT));
                sum += radiance(world, buckets, scale, &lens, x, y);
            }
            sum / f64::from(GRID * GRID)
        })
        .collect()
}

/// Radiance that arrives at (x, y) of the picture.
fn radiance(world: &World, buckets: &Buckets, scale: &Scale, lens: &Lens, x: f64, y: f64) -> DVec3 {
    let Some((hit, direction)) = lens.see(world, x, y) else { return DVec3::ZERO };
    let (object, t) = (hit.triangle.object(), hit.triangle.in_mesh());
    let normal = hit.triangle.normal;
    let back = normal.dot(direction) > 0.0;
    let normal = (if back { -normal } else { normal }).as_dvec3();
    let area = world.object(object).lattice.area_in(t);
    let from_photons = scale.irradiance(buckets, object, path::cell(&hit), usize::from(back), area).value;
    let point = hit.triangle.point(hit.weights).as_dvec3();
    let direct = probe::direct_of(world, point, normal, |lamp| world.configuration().lamp(lamp).direct == Direct::Rasteriser);
    path::reflectance(world, &hit).as_dvec3() * (from_photons + direct) / std::f64::consts::PI
}

/// Middle grey (0.18) for the logarithmic mean of what is not black.
fn exposure(radiance: &[DVec3]) -> f64 {
    let bright: Vec<f64> = radiance.iter().map(|r| luminance(*r)).filter(|l| *l > 0.0).collect();
    if bright.is_empty() {
        return 1.0;
    }
    0.22 / (bright.iter().map(|l| l.ln()).sum::<f64>() / bright.len() as f64).exp()
}

/// Reinhard's curve on luminance with a white point of 4, then sRGB.
fn encode(radiance: DVec3) -> [u8; 3] {
    let l = luminance(radiance);
    let scaled = if l > 0.0 { radiance * ((1.0 + l / 16.0) / (1.0 + l)) } else { radiance };
    scaled.to_array().map(|c| {
        let c = c.clamp(0.0, 1.0);
        let s = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (s * 255.0).round() as u8
    })
}
