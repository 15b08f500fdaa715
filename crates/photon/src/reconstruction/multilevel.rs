//! Irradiance of patches from noisy sums of photons, from coarse to fine.
//!
//! A patch is predicted from the next coarser level: the irradiance there plus its gradient, fitted to the neighbours (local linear
//! estimate: Walter 1998). The step from the patch above to this one, as the photons say it, differs from the predicted step by noise, whose
//! variance is known (Poisson), and by detail, whose variance τ² is what remains of the squared differences around it. (The photons of the
//! whole patch above were judged there; their noise, counted again, would pass for detail of each of its parts.) Detail is believed to
//! the share τ² / (τ² + noise) (Wiener filter with a local empirical variance: Mıhçak et al. 1999). As photons grow the noise vanishes and every detail is believed:
//! the estimate is consistent. The parts of a patch keep its flux.

use super::patches::{Grid, Level, Patches};
use glam::{DMat3, DVec3};
use lightmend_scene::luminance;

/// Photons' sums on a patch.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sum {
    /// Lumens per channel.
    pub flux: DVec3,
    /// Σ lm² of luminous flux over hits: the variance of the luminous flux, if hits are independent.
    pub squares: f64,
}

/// What is known of a patch's irradiance.
#[derive(Debug, Clone, Copy, Default)]
pub struct Estimate {
    /// Lux per channel.
    pub value: DVec3,
    /// Of illuminance, lux².
    pub variance: f64,
    /// Variance of detail about the prediction, lux².
    pub detail: f64,
}

/// Detail is thought to be this share of the light, before anything is known.
const PRIOR_DETAIL: f64 = 0.03;
/// As if it had been seen in so many patches.
const PRIOR_PATCHES: f64 = 8.0;
/// Detail is thought to have this share of the variance that it had on the next coarser level.
const INHERITED: f64 = 0.25;
/// Light is thought to change by this share of itself over the width of a patch, before anything is known.
const PRIOR_GRADIENT: f64 = 1.0;

/// Irradiance of the level-0 patches of one side of a mesh, from their `sums`.
pub fn estimate(patches: &Patches, sums: &[Sum]) -> Vec<Estimate> {
    let part = 1.0 / patches.grids.len() as f64;
    let grids: Vec<Vec<Estimate>> = patches.grids.iter().map(|grid| in_grid(&patches.cells, grid, sums)).collect();
    let mean = |p: usize| {
        let mut mean = Estimate::default();
        for one in grids.iter().map(|estimates| estimates[p]) {
            mean.value += one.value * part;
            mean.variance += one.variance * part;
            mean.detail += one.detail * part;
        }
        // What the grids differ by is error that their mean is rid of: of estimates that share nothing, all but one part.
        let light = luminance(mean.value);
        let apart: f64 = grids.iter().map(|estimates| (luminance(estimates[p].value) - light).powi(2) * part).sum();
        mean.variance = (mean.variance - apart).max(mean.variance * part);
        mean
    };
    (0..sums.len()).map(mean).collect()
}

fn in_grid(cells: &Level, grid: &Grid, sums: &[Sum]) -> Vec<Estimate> {
    // From fine to coarse: sums are exact.
    let mut all = vec![sums.to_vec()];
    for (parents, level) in grid.parents.iter().zip(&grid.levels) {
        let mut next = vec![Sum::default(); level.count()];
        for (sum, parent) in all[all.len() - 1].iter().zip(parents) {
            next[*parent as usize].flux += sum.flux;
            next[*parent as usize].squares += sum.squares;
        }
        all.push(next);
    }
    let whole = |(sum, area): (&Sum, &f64)| Estimate {
        value: sum.flux / *area,
        variance: sum.squares / (area * area),
        detail: (PRIOR_DETAIL * luminance(sum.flux) / area).powi(2),
    };
    let top = grid.levels.last().unwrap_or(cells);
    let mut estimates: Vec<Estimate> = all[all.len() - 1].iter().zip(&top.area).map(whole).collect();
    for k in (0..grid.levels.len()).rev() {
        let level = if k == 0 { cells } else { &grid.levels[k - 1] };
        estimates = refine([level, &grid.levels[k]], &grid.parents[k], [&all[k], &all[k + 1]], &estimates);
    }
    estimates
}

/// Gradient of irradiance at patch `p`, lux per metre for each channel, fitted to its neighbours.
fn gradient(level: &Level, estimates: &[Estimate], p: usize) -> [DVec3; 3] {
    let here = &estimates[p];
    let light = luminance(here.value);
    let prior = level.area[p] / (PRIOR_GRADIENT * light).powi(2).max(f64::MIN_POSITIVE);
    let mut normal = DMat3::from_diagonal(DVec3::splat(prior));
    let mut right = [DVec3::ZERO; 3];
    for q in level.beside(p) {
        let there = &estimates[*q as usize];
        let step = level.centre[*q as usize] - level.centre[p];
        let weight = 1.0 / (here.variance + there.variance + (here.detail + there.detail) / 2.0).max(f64::MIN_POSITIVE);
        normal += DMat3::from_cols(step * step.x, step * step.y, step * step.z) * weight;
        let rise = (there.value - here.value) * weight;
        right.iter_mut().zip(rise.to_array()).for_each(|(sum, rise)| *sum += step * rise);
    }
    let inverse = normal.inverse();
    right.map(|r| inverse * r)
}

/// The estimates of a level from those of the one above it, `coarse`.
fn refine([level, above]: [&Level; 2], parents: &[u32], [sums, sums_above]: [&[Sum]; 2], coarse: &[Estimate]) -> Vec<Estimate> {
    let gradients: Vec<Option<[DVec3; 3]>> =
        (0..above.count()).map(|p| (luminance(coarse[p].value) > 0.0).then(|| gradient(above, coarse, p))).collect();
    /// What photons say beyond the prediction.
    #[derive(Clone, Copy, Default)]
    struct Detail {
        predicted: DVec3,
        /// Lux per channel.
        difference: DVec3,
        /// Of the difference's illuminance, lux²: how much is noise.
        noise: f64,
        /// Variance of the prediction, lux².
        variance: f64,
    }
    let detail = |p: usize| {
        let parent = parents[p] as usize;
        let Some(gradient) = &gradients[parent] else { return Detail::default() };
        let from = &coarse[parent];
        let step = level.centre[p] - above.centre[parent];
        let light = luminance(from.value);
        let mut predicted = from.value + DVec3::from_array(gradient.map(|g| g.dot(step)));
        let least = 0.05 * light;
        if luminance(predicted) < least || predicted.min_element() < 0.0 {
            predicted = from.value * (luminance(predicted).max(least) / light);
        }
        let sum = &sums[p];
        let area = level.area[p];
        // Lumens per hit.
        let per_hit = sums_above[parent].squares / luminance(sums_above[parent].flux).max(f64::MIN_POSITIVE);
        let share = (1.0 - area / above.area[parent]).max(0.0);
        let step_by_photons = sum.flux / area - sums_above[parent].flux / above.area[parent];
        Detail {
            predicted,
            difference: step_by_photons - (predicted - from.value),
            noise: luminance(predicted) * per_hit / area * share,
            variance: from.variance,
        }
    };
    let details: Vec<Detail> = (0..level.count()).map(detail).collect();
    let believed = |p: usize| {
        let here = &details[p];
        let parent = parents[p] as usize;
        if here.noise <= 0.0 {
            return coarse[parent];
        }
        let prior = (PRIOR_DETAIL * luminance(coarse[parent].value)).powi(2) + INHERITED * coarse[parent].detail;
        // Squares are worth as much as they are certain.
        let worth = |d: &Detail| (d.noise + prior).powi(-2);
        let beside = level.beside(p).iter().map(|q| &details[*q as usize]).filter(|d| d.noise > 0.0);
        let (mut sum, mut weights) = (PRIOR_PATCHES * worth(here) * prior, PRIOR_PATCHES * worth(here));
        for d in beside.chain([here]) {
            sum += worth(d) * (luminance(d.difference).powi(2) - d.noise);
            weights += worth(d);
        }
        let tau = (sum / weights).max(0.0);
        let belief = tau / (tau + here.noise);
        Estimate { value: here.predicted + here.difference * belief, variance: here.variance + here.noise * belief, detail: tau }
    };
    let mut fine: Vec<Estimate> = (0..level.count()).map(believed).collect();

    // The parts of a patch keep its flux: what is too much is taken where least is known.
    let mut excess = vec![DVec3::ZERO; above.count()];
    let mut doubt = vec![0.0; above.count()];
    for (p, parent) in parents.iter().enumerate() {
        let variance = fine[p].variance - coarse[*parent as usize].variance;
        excess[*parent as usize] += fine[p].value * level.area[p];
        doubt[*parent as usize] += level.area[p] * level.area[p] * variance.max(0.0);
    }
    excess.iter_mut().enumerate().for_each(|(p, e)| *e -= coarse[p].value * above.area[p]);
    for (p, parent) in parents.iter().enumerate() {
        let parent = *parent as usize;
        let variance = (fine[p].variance - coarse[parent].variance).max(0.0);
        if doubt[parent] > 0.0 {
            let corrected = fine[p].value - excess[parent] * (level.area[p] * variance / doubt[parent]);
            fine[p].value = corrected.max(DVec3::ZERO);
        }
    }
    fine
}
