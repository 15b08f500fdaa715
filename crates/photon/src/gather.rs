//! Indirect irradiance at a point, gathered from all that the point sees.
//!
//! Final gathering (Reichert 1992; Jensen 1996, *Global Illumination Using Photon Maps*, §4): the indirect irradiance at x is the mean, over directions with density
//! cos θ / π, of ρ(y) · (direct + indirect irradiance at y), y being what is seen from x there. Direct light at y is computed, indirect
//! light at y is the photons'. So nothing depends on the size of the element that x lies in or on how few photons hit it, and what is
//! wrong in single elements averages out over all that are seen. What is nearer than the width of its own element would be seen too
//! coarsely: there the path goes on by another ray.

use crate::{
    bucket::Buckets,
    irradiance::{Irradiance, Scale},
    path::{cell, reflectance},
    probe::{Place, direct},
    random::Random,
    reconstruction::Reconstruction,
    sampling::cosine_hemisphere,
    triangle::{Hit, Ray},
    world::World,
};
use glam::DVec3;
use lightmend_scene::luminance;

/// Rays of a batch: so many strata of height by as many of azimuth, one ray in each. More: less noise for the same rays, but
/// fewer batches, from whose scatter the standard error comes.
const STRATA: u32 = 16;

/// Fewer batches than this say too little of their scatter.
const LEAST_BATCHES: u32 = 8;

/// After so many surfaces in a row that were too near, their elements' light is taken all the same: between two sheets that touch, a path would not end.
const NEAR: u32 = 8;

/// Gathers the light of one state of a scene.
pub struct Gather<'w> {
    /// What is there.
    pub world: &'w World,
    /// Indirect light only.
    pub light: &'w Reconstruction<'w>,
    /// What it was made of.
    pub buckets: &'w Buckets,
    /// The worth of their energy.
    pub scale: &'w Scale,
    /// Rays per point, rounded up to whole batches. More: less noise (half for four times as many), longer work.
    pub rays: u32,
}

/// One side of an element.
type Side = (usize, u32, usize);

/// What rays gathered: light, and how much of which element side was in it.
#[derive(Default)]
struct Gathered {
    light: DVec3,
    /// With the share of its illuminance.
    from: Vec<(Side, f64)>,
}

impl Gather<'_> {
    /// Indirect irradiance at the place that is number `number` of those asked for. Hits are not counted.
    pub fn at(&self, place: &Place, number: usize) -> Irradiance {
        let batches = self.rays.div_ceil(STRATA * STRATA).max(LEAST_BATCHES);
        let count = f64::from(batches);
        let (mut sum, mut square) = (DVec3::ZERO, 0.0);
        // Even and odd batches: independent of each other.
        let mut halves = [Vec::new(), Vec::new()];
        for batch in 0..batches {
            let Gathered { light, from } = self.batch(place, Random::new("gather", [number as u64, batch.into()]));
            sum += light;
            square += luminance(light).powi(2);
            halves[(batch % 2) as usize].extend(from);
        }
        let value = sum / count;
        let illuminance = luminance(value);
        let sampling = (square / count - illuminance * illuminance).max(0.0) / (count - 1.0);
        let noise = self.noise(halves.map(|half| shares(half, 2.0 / count)));
        let relative = if illuminance > 0.0 { (sampling + noise).sqrt() / illuminance } else { 0.0 };
        Irradiance { value, standard_error: value * relative, hits: 0 }
    }

    /// The mean of one ray through every stratum.
    fn batch(&self, place: &Place, mut random: Random) -> Gathered {
        let mut gathered = Gathered::default();
        let strata = f64::from(STRATA);
        let part = 1.0 / (strata * strata);
        for row in 0..STRATA {
            for column in 0..STRATA {
                let u = (f64::from(row) + random.unit()) / strata;
                let v = (f64::from(column) + random.unit()) / strata;
                self.path(place, [u, v], part, &mut random, &mut gathered);
            }
        }
        gathered
    }

    fn path(&self, place: &Place, [mut u, mut v]: [f64; 2], part: f64, random: &mut Random, gathered: &mut Gathered) {
        let step = f64::from(self.world.reach().step_back());
        let (mut from, mut normal, mut throughput) = (place.point, place.normal, DVec3::splat(part));
        for surfaces in 1.. {
            let ray = Ray::new((from + normal * step).as_vec3(), cosine_hemisphere(normal.as_vec3(), u, v), None, 0.0);
            let Some(hit) = self.world.nearest(&ray) else { return };
            throughput *= reflectance(self.world, &hit).as_dvec3();
            if throughput == DVec3::ZERO {
                return;
            }
            from = hit.triangle.point(hit.weights).as_dvec3();
            normal = hit.triangle.normal.as_dvec3();
            if normal.dot(ray.direction.as_dvec3()) > 0.0 {
                normal = -normal;
            }
            gathered.light += throughput * direct(self.world, from, normal);
            let lattice = &self.world.object(hit.triangle.object()).lattice;
            let width = (2.0 * lattice.area_in(hit.triangle.in_mesh())).sqrt();
            if f64::from(hit.distance) >= width || surfaces == NEAR {
                return self.indirect(&ray, hit, throughput, gathered);
            }
            [u, v] = [random.unit(), random.unit()];
        }
    }

    /// Adds the photons' light at a hit: that of all surfaces that lie in one another there.
    fn indirect(&self, ray: &Ray, hit: Hit, throughput: DVec3, gathered: &mut Gathered) {
        for hit in self.world.layers(ray, hit) {
            let (object, cell) = (hit.triangle.object(), cell(&hit));
            let side = usize::from(hit.triangle.normal.dot(ray.direction) > 0.0);
            let light = self.light.cell(object, cell, side).value;
            gathered.light += throughput * light;
            gathered.from.push(((object, cell, side), luminance(throughput * light) / luminance(light).max(f64::MIN_POSITIVE)));
        }
    }

    /// Variance of illuminance from the photons' own noise, lux²: each element side's, by the square of its share. The product of two independent estimates
    /// of a share is its square without the square of their noise.
    fn noise(&self, [a, b]: [Vec<(Side, f64)>; 2]) -> f64 {
        let mut b = b.iter().peekable();
        let mut variance = 0.0;
        for ((object, cell, side), share) in a {
            while b.next_if(|(other, _)| *other < (object, cell, side)).is_some() {}
            let Some((_, again)) = b.next_if(|(other, _)| *other == (object, cell, side)) else { continue };
            let area = self.world.object(object).lattice.area(cell);
            let light = self.scale.irradiance(self.buckets, object, cell, side, area);
            // Where nothing was hit its error is a bound, not an estimate.
            if light.hits > 0 {
                variance += share * again * luminance(light.standard_error).powi(2);
            }
        }
        variance
    }
}

/// The shares of all element sides, in order, times `part`.
fn shares(mut from: Vec<(Side, f64)>, part: f64) -> Vec<(Side, f64)> {
    from.sort_unstable_by_key(|(side, _)| *side);
    let whole = |same: &[(Side, f64)]| (same[0].0, same.iter().map(|(_, share)| share).sum::<f64>() * part);
    from.chunk_by(|a, b| a.0 == b.0).map(whole).collect()
}
