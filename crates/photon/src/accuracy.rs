//! How far light is from a reference: nRMSE, relMSE and quantiles of the relative error, over all element sides by their area.
//!
//! A [`Reference`] is two solutions of other scrambles with many more photons. Their difference tells its own error, which is
//! taken out of the means of squares: errors of independent photons add in squares.

use crate::{
    bucket::{Buckets, Full},
    field::{Field, Side},
    halton::Scrambling,
    irradiance::Scale,
    path::{FirstHits, Rules},
    pool::Pool,
    shooting::Shooting,
    world::World,
};
use lightmend_scene::luminance;
use std::sync::Arc;

/// Sides count for the relative error if their light exceeds this share of its mean.
pub(crate) const DIM: f64 = 0.05;

/// How far a field is from a reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measures {
    /// RMS of the error ÷ RMS of the reference, by area, three channels together.
    pub nrmse: f64,
    /// Mean by area of error² ÷ (reference² + 0.01 · mean²), of illuminance, over the sides that the reference lights.
    pub relmse: f64,
    /// Median by area of |error| ÷ reference, of illuminance, over the sides where the reference exceeds 5 % of its mean.
    pub median: f64,
    /// 95th percentile of the same.
    pub percentile_95: f64,
}

impl Measures {
    /// Of a field against a reference of the same scene, whose own error counts with it.
    pub fn new(field: &Field, reference: &Field) -> Measures {
        let [median, percentile_95] = relative_errors(field, reference, [0.5, 0.95]);
        Measures { nrmse: nrmse(field, reference), relmse: relmse(field, reference), median, percentile_95 }
    }
}

/// √(Σ area · |error|² ÷ Σ area · |reference|²), three channels together; 0 in the dark.
pub fn nrmse(field: &Field, reference: &Field) -> f64 {
    let (mut error, mut square) = (0.0, 0.0);
    for (now, right) in field.sides().iter().zip(reference.sides()) {
        error += right.area * (now.irradiance - right.irradiance).length_squared();
        square += right.area * right.irradiance.length_squared();
    }
    if square > 0.0 { (error / square).sqrt() } else { 0.0 }
}

/// Mean by area of error² ÷ (reference² + 0.01 · mean²), of illuminance, over the sides that the reference lights; `mean` is that
/// of the reference over these. 0 in the dark.
pub fn relmse(field: &Field, reference: &Field) -> f64 {
    let (mean, area) = mean_illuminance(reference);
    let of = |(now, right): (&Side, &Side)| {
        let (now, right) = (luminance(now.irradiance), luminance(right.irradiance));
        (now - right).powi(2) / (right * right + 0.01 * mean * mean)
    };
    let lit = field.sides().iter().zip(reference.sides()).filter(|(_, right)| right.hits > 0);
    let sum: f64 = lit.map(|pair| pair.1.area * of(pair)).sum();
    if area > 0.0 && mean > 0.0 { sum / area } else { 0.0 }
}

/// Quantiles by area of |error| ÷ reference, of illuminance, over the sides where the reference exceeds 5 % of its mean over the
/// sides that it lights: the smallest relative error that so much of their area does not exceed. 0 in the dark.
pub fn relative_errors<const N: usize>(field: &Field, reference: &Field, quantiles: [f64; N]) -> [f64; N] {
    let (mean, _) = mean_illuminance(reference);
    let of = |(now, right): (&Side, &Side)| {
        let (now, level) = (luminance(now.irradiance), luminance(right.irradiance));
        (right.hits > 0 && level > DIM * mean).then(|| ((now - level).abs() / level, right.area))
    };
    quantiles_by_area(field.sides().iter().zip(reference.sides()).filter_map(of).collect(), quantiles)
}

/// Quantiles of errors that count with their area: the smallest that so much of all area does not exceed. 0 without any.
pub(crate) fn quantiles_by_area<const N: usize>(mut errors: Vec<(f64, f64)>, quantiles: [f64; N]) -> [f64; N] {
    errors.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let total: f64 = errors.iter().map(|(_, area)| area).sum();
    quantiles.map(|quantile| {
        let mut below = 0.0;
        let reached = errors.iter().find(|(_, area)| {
            below += area;
            below >= quantile * total
        });
        reached.or(errors.last()).map_or(0.0, |(error, _)| *error)
    })
}

/// By area over the sides that are lit, and their area.
fn mean_illuminance(field: &Field) -> (f64, f64) {
    let (mut sum, mut area) = (0.0, 0.0);
    for side in field.sides().iter().filter(|side| side.hits > 0) {
        sum += side.area * luminance(side.irradiance);
        area += side.area;
    }
    if area > 0.0 { (sum / area, area) } else { (0.0, 0.0) }
}

/// An error measured against a reference that errs by `own` itself, without the latter: squares are taken out of each other.
pub fn without_own(error: f64, own: f64) -> f64 {
    (error * error - own * own).max(0.0).sqrt()
}

/// What light is measured against.
pub struct Reference {
    /// The mean of both halves.
    pub field: Field,
    /// [`field`](Self::field) off by as much as it probably is: half of the halves' difference.
    pub off: Field,
    /// How far it is itself from what endless photons would bring.
    pub own: Measures,
    /// The light of both halves together.
    pub buckets: Buckets,
    /// Photons of both halves.
    pub photons: u64,
}

impl Reference {
    /// Shoots `photons` in two halves, scrambled otherwise than `pool` and each other, in as many copies. `progress` hears of the
    /// photons so far and may end the work by returning `false`: `None`. Refused if they bring more light than can be counted.
    pub fn shoot(
        world: &Arc<World>,
        pool: &Pool,
        photons: u64,
        first_hits: FirstHits,
        progress: &mut dyn FnMut(u64) -> bool,
    ) -> Result<Option<Reference>, Full> {
        let seed = if let Scrambling::Seed(seed) = pool.scrambling { seed } else { 0 };
        let half = photons.div_ceil(2);
        let mut shoot = |seed, before| {
            let mut pool = *pool;
            pool.scrambling = Scrambling::Seed(seed);
            let rules = Rules { sequence: pool.sequence(), first_hits };
            let mut shooting = Shooting::new(Arc::new(rules), world.clone());
            while shooting.photons() < half {
                shooting.shoot(half - shooting.photons())?;
                if !progress(before + shooting.photons()) {
                    return Ok(None);
                }
            }
            Ok(Some(shooting))
        };
        let Some(a) = shoot(seed.wrapping_add(101), 0)? else { return Ok(None) };
        let Some(b) = shoot(seed.wrapping_add(202), half)? else { return Ok(None) };
        let scale = Scale::new(world, half);
        let [first, second] = [&a, &b].map(|half| Field::raw(world, half.buckets(), &scale));
        let field = first.mean(&second);
        let off = field.off_by_half(&first, &second);
        let own = Measures::new(&off, &field);
        let mut buckets = a.buckets().clone();
        buckets.merge(b.buckets())?;
        Ok(Some(Reference { field, off, own, buckets, photons: 2 * half }))
    }

    /// How far a field is from the truth: the reference's own error is taken out of nRMSE and relMSE; quantiles keep it.
    pub fn measure(&self, field: &Field) -> Measures {
        let all = Measures::new(field, &self.field);
        let nrmse = without_own(all.nrmse, self.own.nrmse);
        Measures { nrmse, relmse: (all.relmse - self.own.relmse).max(0.0), ..all }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn field(sides: &[(f64, f64)]) -> Field {
        Field::of(
            sides
                .iter()
                .map(|(lux, area)| Side { irradiance: DVec3::splat(*lux), area: *area, hits: i64::from(*lux > 0.0) })
                .collect(),
        )
    }

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-12
    }

    /// Two lit sides of 1 and 3 m², a dim one and a dark one: the mean is (10 + 60 + 0.5) / 5 = 14.1 lux, 5 % of it 0.705.
    const REFERENCE: [(f64, f64); 4] = [(10.0, 1.0), (20.0, 3.0), (0.5, 1.0), (0.0, 2.0)];

    #[test]
    fn measures_by_hand() {
        let reference = field(&REFERENCE);
        let now = field(&[(12.0, 1.0), (19.0, 3.0), (1.0, 1.0), (0.25, 2.0)]);
        // Errors 2, −1, 0.5, 0.25: Σ area·e² = 4 + 3 + 0.25 + 0.125 and Σ area·E² = 100 + 1200 + 0.25 per channel.
        assert!(close(nrmse(&now, &reference), (7.375f64 / 1300.25).sqrt()));
        let floor = 0.01 * 14.1 * 14.1;
        let relative = 4.0 / (100.0 + floor) + 3.0 / (400.0 + floor) + 0.25 / (0.25 + floor);
        assert!(close(relmse(&now, &reference), relative / 5.0));
        // 0.05 over 3 m² and 0.2 over 1 m²; the dim and the dark side do not count.
        let quantiles = relative_errors(&now, &reference, [0.5, 0.75, 0.76, 0.95, 1.0]);
        assert!(quantiles.iter().zip([0.05, 0.05, 0.2, 0.2, 0.2]).all(|(a, b)| close(*a, b)), "{quantiles:?}");
    }

    #[test]
    fn channels_count_together_in_nrmse_and_as_illuminance_elsewhere() {
        let side = |irradiance| Side { irradiance, area: 1.0, hits: 1 };
        let reference = Field::of(vec![side(DVec3::new(3.0, 4.0, 0.0))]);
        let now = Field::of(vec![side(DVec3::new(3.0, 4.0, 2.0))]);
        assert!(close(nrmse(&now, &reference), 2.0 / 5.0));
        let right = 0.2126 * 3.0 + 0.7152 * 4.0;
        let off: f64 = 0.0722 * 2.0;
        assert!(close(relative_errors(&now, &reference, [0.5])[0], off / right));
        assert!(close(relmse(&now, &reference), off * off / (1.01 * right * right)));
    }

    #[test]
    fn nothing_is_wrong_in_the_dark() {
        let dark = field(&[(0.0, 1.0)]);
        let measured = Measures::new(&field(&[(1.0, 1.0)]), &dark);
        assert_eq!(measured, Measures { nrmse: 0.0, relmse: 0.0, median: 0.0, percentile_95: 0.0 });
        assert!(close(without_own(0.5, 0.3), 0.4));
        assert_eq!(without_own(0.3, 0.5), 0.0);
    }

    #[test]
    fn nothing_shot_is_wholly_wrong() {
        let nothing = field(&REFERENCE.map(|(_, area)| (0.0, area)));
        let measured = Measures::new(&nothing, &field(&REFERENCE));
        assert!([measured.nrmse, measured.median, measured.percentile_95].iter().all(|m| close(*m, 1.0)), "{measured:?}");
    }
}
