//! Irradiance at points by path tracing: what the photons are held against.
//!
//! Kajiya 1986, *The Rendering Equation*, for diffuse surfaces: the indirect irradiance at x is the mean, over directions with density
//! cos θ / π, of ρ(y) · (direct + indirect irradiance at y), y being what is seen from x there. So a path adds, at every surface that it
//! meets, the product of the reflectances so far times the lamps' direct light there, and goes on by Russian roulette on the
//! reflectance. Nothing is clamped and no path is cut: the mean of any number of paths is right, however few they are.
//!
//! With the photons it shares the scene (poses, reflectance, candela: [`reflectance`], [`direct`]) and what a ray meets
//! ([`World::nearest`], [`World::sees`]). Random numbers, directions, the step off a surface and the sum are its own, and it knows
//! nothing of emission, elements and buckets.

use crate::{path::reflectance, probe::direct, random::Random, triangle::Ray, world::World};
use glam::{DVec3, DVec4};
use lightmend_scene::{luminance, trig::sin_cos};
use rayon::prelude::*;
use std::{
    f64::consts::TAU,
    sync::atomic::{AtomicBool, Ordering},
};

/// Fewer independent batches than this say too little of their scatter: with 32 the standard error is itself uncertain by 1/8.
pub const LEAST_BATCHES: u32 = 32;

/// A path goes on with its surface's largest reflectance as the chance, but never with more than this, so that it ends even between
/// surfaces that reflect everything; the scatter stays finite up to a reflectance of 0.9995.
const LIKELIEST: f64 = 0.999;

/// How many paths, and from which random numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// The first directions of a batch are stratified in this many steps of height by as many of azimuth, one path in each. More:
    /// less noise for the same paths, but fewer batches.
    pub strata: u32,
    /// Batches per point; at most so many if `error` is given.
    pub batches: u32,
    /// A point is done when the relative standard error of its indirect illuminance is at most this. Stopping by an estimate favours
    /// low ones where light is rare; without it (`None`) the result is unbiased.
    pub error: Option<f64>,
    /// Other seeds give independent results.
    pub seed: u64,
}

impl Plan {
    /// At least `paths` per point, of [`LEAST_BATCHES`] or more batches.
    pub fn of_paths(paths: u64, seed: u64) -> Plan {
        let strata = (paths as f64 / f64::from(LEAST_BATCHES)).sqrt().floor().clamp(1.0, 64.0) as u32;
        let batches = paths.div_ceil(u64::from(strata * strata)).clamp(LEAST_BATCHES.into(), u32::MAX.into()) as u32;
        Plan { strata, batches, error: None, seed }
    }

    /// As many paths as a relative standard error of `error` takes, about `paths` per point at most.
    pub fn to_error(error: f64, paths: u64, seed: u64) -> Plan {
        // Batches small enough for points in even light.
        let strata: u32 = 16;
        let batches = paths.div_ceil(u64::from(strata * strata)).clamp(LEAST_BATCHES.into(), u32::MAX.into()) as u32;
        Plan { strata, batches, error: Some(error), seed }
    }

    /// Paths in a batch.
    pub fn paths_in_batch(&self) -> u64 {
        u64::from(self.strata).pow(2)
    }
}

/// Indirect irradiance at a point, from batches of paths that are independent of each other.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Estimate {
    batches: u32,
    /// Mean of the batches: per channel, and illuminance.
    mean: DVec4,
    /// Sum of squared deviations from it.
    scatter: DVec4,
}

impl Estimate {
    /// Welford 1962.
    fn add(&mut self, batch: DVec3) {
        let value = batch.extend(luminance(batch));
        self.batches += 1;
        let before = value - self.mean;
        self.mean += before / f64::from(self.batches);
        self.scatter += before * (value - self.mean);
    }

    /// Batches that it is the mean of.
    pub fn batches(&self) -> u32 {
        self.batches
    }

    /// Whether there are enough batches to say how sure it is.
    pub fn is_known(&self) -> bool {
        self.batches >= LEAST_BATCHES
    }

    /// Lux per linear Rec. 709 channel.
    pub fn value(&self) -> DVec3 {
        self.mean.truncate()
    }

    fn errors(&self) -> DVec4 {
        let n = f64::from(self.batches.max(2));
        (self.scatter / (n * (n - 1.0))).map(f64::sqrt)
    }

    /// One standard error of [`value`](Self::value), from the scatter of the batches.
    pub fn standard_error(&self) -> DVec3 {
        self.errors().truncate()
    }

    /// The standard error of illuminance as a share of it; 0 in the dark.
    pub fn relative_error(&self) -> f64 {
        if self.mean.w > 0.0 { self.errors().w / self.mean.w } else { 0.0 }
    }
}

/// Estimates at points, under way.
pub struct PathTracer<'w> {
    world: &'w World,
    plan: Plan,
    /// Points and unit normals on the side that counts.
    points: Vec<(DVec3, DVec3)>,
    estimates: Vec<Estimate>,
    stopped: bool,
}

impl<'w> PathTracer<'w> {
    /// Nothing is traced yet. Each point, metres, has a unit normal on the side that counts and lies on a surface. A point's paths follow
    /// from the plan's seed and its place in the list.
    pub fn new(world: &'w World, points: Vec<(DVec3, DVec3)>, plan: Plan) -> PathTracer<'w> {
        PathTracer { world, plan, estimates: vec![Estimate::default(); points.len()], points, stopped: false }
    }

    /// What is known, point by point.
    pub fn estimates(&self) -> &[Estimate] {
        &self.estimates
    }

    /// Batches that the point's next round takes: all at once, or twice as many as before until the error is small enough.
    fn next(&self, estimate: &Estimate) -> u32 {
        let left = self.plan.batches - estimate.batches;
        match self.plan.error {
            None => left,
            Some(error) if estimate.is_known() && estimate.relative_error() <= error => 0,
            Some(_) => left.min(estimate.batches.max(LEAST_BATCHES)),
        }
    }

    /// Paths of the next round, of all points together; 0 when all is done, or was stopped.
    pub fn paths_ahead(&self) -> u64 {
        if self.stopped {
            return 0;
        }
        self.estimates.iter().map(|estimate| u64::from(self.next(estimate))).sum::<u64>() * self.plan.paths_in_batch()
    }

    /// Traces a round. `go_on` hears of every finished batch how many paths it had; once it says no, none is begun, what is
    /// finished is kept, and there is no further round.
    pub fn round(&mut self, go_on: &(dyn Fn(u64) -> bool + Sync)) {
        let stop = AtomicBool::new(false);
        let added: Vec<Estimate> = (0..self.points.len())
            .into_par_iter()
            .map(|point| {
                let mut estimate = self.estimates[point];
                let batches = estimate.batches..estimate.batches + self.next(&estimate);
                let one = |batch| {
                    let light = (!stop.load(Ordering::Relaxed)).then(|| self.batch(point, batch));
                    if light.is_some() && !go_on(self.plan.paths_in_batch()) {
                        stop.store(true, Ordering::Relaxed);
                    }
                    light
                };
                let lights: Vec<Option<DVec3>> = batches.into_par_iter().map(one).collect();
                // In order, whichever was finished first.
                lights.into_iter().flatten().for_each(|light| estimate.add(light));
                estimate
            })
            .collect();
        self.estimates = added;
        self.stopped = stop.into_inner();
    }

    /// Mean light of one path through every stratum.
    fn batch(&self, point: usize, batch: u32) -> DVec3 {
        let mut random = Random::new("", [self.plan.seed, point as u64, batch.into()]);
        let (place, normal) = self.points[point];
        let strata = f64::from(self.plan.strata);
        let mut sum = DVec3::ZERO;
        for row in 0..self.plan.strata {
            for column in 0..self.plan.strata {
                let u = (f64::from(row) + random.unit()) / strata;
                let v = (f64::from(column) + random.unit()) / strata;
                sum += self.path(place, normal, lambertian(normal, u, v), &mut random);
            }
        }
        sum / (strata * strata)
    }

    /// What one path that leaves a surface brings there.
    fn path(&self, mut from: DVec3, mut normal: DVec3, mut direction: DVec3, random: &mut Random) -> DVec3 {
        let step = f64::from(self.world.reach().step_back());
        let (mut light, mut throughput) = (DVec3::ZERO, DVec3::ONE);
        loop {
            let ray = Ray::new((from + normal * step).as_vec3(), direction.as_vec3(), None, 0.0);
            let Some(hit) = self.world.nearest(&ray) else { return light };
            let reflectance = reflectance(self.world, &hit).as_dvec3();
            throughput *= reflectance;
            if throughput == DVec3::ZERO {
                return light;
            }
            from = hit.triangle.point(hit.weights).as_dvec3();
            normal = hit.triangle.normal.as_dvec3();
            if normal.dot(direction) > 0.0 {
                normal = -normal;
            }
            light += throughput * direct(self.world, from, normal);
            let survival = reflectance.max_element().min(LIKELIEST);
            if random.unit() >= survival {
                return light;
            }
            throughput /= survival;
            direction = lambertian(normal, random.unit(), random.unit());
        }
    }
}

/// A direction with density cos θ / π about unit `normal`: that of the normal plus a point of the unit sphere. Keeps areas of the
/// square of `u` and `v`.
fn lambertian(normal: DVec3, u: f64, v: f64) -> DVec3 {
    let height = 1.0 - 2.0 * u;
    let (sine, cosine) = sin_cos(TAU * v);
    let radius = (1.0 - height * height).max(0.0).sqrt();
    // Opposite to the normal the sum has no direction; that point has no area either.
    (normal + DVec3::new(radius * cosine, radius * sine, height)).try_normalize().unwrap_or(normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_follow_the_cosine() {
        // Moments of cos θ / π: mean cosine 2/3, mean squared cosine 1/2; about any normal, and stratified as paths are.
        for normal in [DVec3::Z, DVec3::NEG_Z, DVec3::new(0.48, -0.6, 0.64)] {
            let n = 400;
            let middles = || (0..n).map(|i| (f64::from(i) + 0.5) / f64::from(n));
            let all = || middles().flat_map(|u| middles().map(move |v| lambertian(normal, u, v)));
            let mean = all().sum::<DVec3>() / f64::from(n * n);
            let square = all().map(|d| d.dot(normal).powi(2)).sum::<f64>() / f64::from(n * n);
            assert!((mean - normal * (2.0 / 3.0)).length() < 1e-4, "{mean}");
            assert!((square - 0.5).abs() < 1e-4, "{square}");
            assert!(all().all(|d| d.dot(normal) >= 0.0));
        }
    }

    #[test]
    fn standard_errors_are_those_of_the_mean() {
        let mut estimate = Estimate::default();
        [1.0, 2.0, 3.0, 6.0].into_iter().for_each(|v| estimate.add(DVec3::new(v, 2.0 * v, 0.0)));
        assert_eq!(estimate.value(), DVec3::new(3.0, 6.0, 0.0));
        // Variance 14/3 of one, a fourth of it of their mean.
        let expected = (14.0f64 / 12.0).sqrt();
        assert!((estimate.standard_error() - DVec3::new(expected, 2.0 * expected, 0.0)).length() < 1e-12);
        assert!((estimate.relative_error() - expected / 3.0).abs() < 1e-12);
    }

    #[test]
    fn plans_give_the_paths_that_were_asked_for() {
        for paths in [1, 31, 32, 1000, 32_768, 1 << 20, 1 << 24] {
            let plan = Plan::of_paths(paths, 1);
            let given = plan.paths_in_batch() * u64::from(plan.batches);
            assert!(plan.batches >= LEAST_BATCHES && given >= paths && given < paths.max(64) * 2, "{paths}: {plan:?}");
        }
        assert_eq!(Plan::of_paths(32_768, 1), Plan { strata: 32, batches: 32, error: None, seed: 1 });
    }
}
