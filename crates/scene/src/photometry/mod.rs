//! Goniometric lamps: luminous intensity as a table over directions, as a goniophotometer measured it.
//!
//! LM-63 type C angles: γ from straight below the lamp (0°) to straight above (180°), C around the vertical. In the
//! lamp's own axes γ = 0 is -z, C = 0 the half plane of +x, C = 90 the half plane of +y. Between the measured angles the
//! intensity is bilinear in degrees of (C, γ), as Radiance's `ies2rad` and the lighting programs read it; outside the
//! measured γ it is 0.
//!
//! [`lm63`] reads a file, [`circle`] unfolds its symmetry, [`sampling`] sends photons out of the table.

mod circle;
#[cfg(test)]
mod corpus_tests;
mod lm63;
mod numbers;
mod sampling;

pub use circle::Symmetry;

use glam::DVec3;
use sampling::Sampler;

/// The luminous intensity of a lamp over all directions, candela; from an IESNA LM-63 file.
#[derive(Debug, Clone, PartialEq)]
pub struct Photometry {
    /// γ, degrees, strictly increasing within 0..=180.
    vertical: Vec<f64>,
    /// C, degrees, strictly increasing, from 0 to 360.
    horizontal: Vec<f64>,
    /// Candela, `[vertical][horizontal]`: a row is one cone around the lamp's axis.
    candela: Vec<f64>,
    symmetry: Symmetry,
    max_candela: f64,
    sampler: Sampler,
}

impl Photometry {
    /// From a table that covers the circle. At least two angles each way, strictly increasing, the horizontal ones
    /// from 0 to 360; `candela` is `[vertical][horizontal]`, finite and not negative.
    fn new(vertical: Vec<f64>, horizontal: Vec<f64>, candela: Vec<f64>, symmetry: Symmetry) -> Self {
        debug_assert_eq!(candela.len(), vertical.len() * horizontal.len());
        let sampler = Sampler::new(&vertical, &horizontal, &candela, symmetry == Symmetry::Axial);
        let max_candela = candela.iter().copied().fold(0.0, f64::max);
        Self { vertical, horizontal, candela, symmetry, max_candela, sampler }
    }

    /// Luminous intensity towards `direction` (lamp's axes, any length but 0), candela.
    pub fn candela(&self, direction: DVec3) -> f64 {
        let c = direction.y.atan2(direction.x).to_degrees();
        let gamma = direction.x.hypot(direction.y).atan2(-direction.z).to_degrees();
        self.candela_at(c, gamma)
    }

    /// Luminous intensity at C (degrees, any turn) and γ (degrees), candela; 0 outside the measured γ.
    pub fn candela_at(&self, c_degrees: f64, gamma_degrees: f64) -> f64 {
        let inside = self.vertical[0] <= gamma_degrees && gamma_degrees <= self.vertical[self.vertical.len() - 1];
        if !inside || !c_degrees.is_finite() {
            return 0.0;
        }
        let (row, t) = place(&self.vertical, gamma_degrees);
        let (column, s) = place(&self.horizontal, c_degrees.rem_euclid(360.0));
        let n = self.horizontal.len();
        let along = |row: usize| {
            let k = row * n + column;
            self.candela[k] + s * (self.candela[k + 1] - self.candela[k])
        };
        along(row) + t * (along(row + 1) - along(row))
    }

    /// Luminous flux, lumens: the integral of the bilinear intensity over the sphere, exact to rounding and with the
    /// same bits on every machine.
    pub fn luminous_flux(&self) -> f64 {
        self.sampler.flux()
    }

    /// A unit direction (lamp's axes) with the density candela / flux per steradian, from `u` and `v` in [0, 1).
    ///
    /// γ grows with `u` and C with `v`, continuously where the intensity is positive, so that a low-discrepancy set
    /// keeps its evenness. Directions of zero intensity never come out. The same bits on every machine. A lamp
    /// without flux answers -z: leave such lamps out.
    pub fn sample(&self, u: f64, v: f64) -> DVec3 {
        let [direction] = self.sample_each([u], [v]);
        direction
    }

    /// [`sample`](Self::sample) of several pairs; in less time than one after the other.
    #[inline(always)]
    pub fn sample_each<const N: usize>(&self, u: [f64; N], v: [f64; N]) -> [DVec3; N] {
        self.sampler.sample_each(&self.horizontal, &self.candela, u, v)
    }

    /// The measured γ, degrees, strictly increasing within 0..=180.
    pub fn vertical(&self) -> &[f64] {
        &self.vertical
    }

    /// C of the columns after the symmetry is unfolded, degrees, strictly increasing from 0 to 360 (both included).
    pub fn horizontal(&self) -> &[f64] {
        &self.horizontal
    }

    /// The largest intensity, candela; 0 for a dark lamp.
    pub fn max_candela(&self) -> f64 {
        self.max_candela
    }

    /// The symmetry that the file states.
    pub fn symmetry(&self) -> Symmetry {
        self.symmetry
    }
}

/// The interval of `knots` that holds `x` and how far into it, 0..=1; the ends for an `x` outside.
fn place(knots: &[f64], x: f64) -> (usize, f64) {
    let k = knots.partition_point(|&knot| knot <= x).clamp(1, knots.len() - 1) - 1;
    (k, ((x - knots[k]) / (knots[k + 1] - knots[k])).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// 3 x 5 values, all different.
    fn quadrant() -> Photometry {
        let text = "TILT=NONE\n1 -1 1 5 3 1 1 0 0 0\n1 1 0\n0 20 40 60 80\n0 30 90\n\
            10 11 12 13 14\n10 21 22 23 24\n10 31 32 33 34\n";
        Photometry::parse(text.as_bytes(), Path::new("q.ies")).unwrap().0
    }

    #[test]
    fn intensity_at_knots_between_and_beyond() {
        let p = quadrant();
        assert_eq!(p.candela_at(0.0, 20.0), 11.0);
        assert_eq!(p.candela_at(90.0, 80.0), 34.0);
        assert_eq!(p.candela_at(15.0, 30.0), 0.25 * (11.0 + 21.0 + 12.0 + 22.0));
        for (c, folded) in [(150.0, 30.0), (210.0, 30.0), (330.0, 30.0), (-30.0, 30.0), (690.0, 30.0), (360.0, 0.0)] {
            assert_eq!(p.candela_at(c, 50.0), p.candela_at(folded, 50.0), "{c}");
        }
        assert_eq!(p.candela_at(0.0, 80.000001), 0.0);
        assert_eq!(p.candela_at(0.0, f64::NAN), 0.0);
        assert_eq!(p.max_candela(), 34.0);
    }

    #[test]
    fn directions_in_the_axes_of_the_lamp() {
        let p = quadrant();
        assert_eq!(p.candela(DVec3::NEG_Z), 10.0);
        assert_eq!(p.candela(DVec3::Z), 0.0);
        let down = |x: f64, y: f64| DVec3::new(x, y, -1.0);
        assert!((p.candela(down(1.0, 0.0) * 7.0) - p.candela_at(0.0, 45.0)).abs() < 1e-12);
        assert!((p.candela(down(0.0, 1.0)) - p.candela_at(90.0, 45.0)).abs() < 1e-12);
        assert!((p.candela(down(-3.0, 3.0)) - p.candela_at(135.0, 18.0_f64.sqrt().atan().to_degrees())).abs() < 1e-12);
    }

    /// Even intensity over the sphere: 4π; over the lower half: 2π.
    #[test]
    fn flux_of_even_intensity() {
        for (last, want) in [(90, 2.0), (180, 4.0)] {
            let text = format!("TILT=NONE\n1 -1 3 2 1 1 1 0 0 0\n.5 1 0\n0 {last}\n0\n2 2\n");
            let p = Photometry::parse(text.as_bytes(), Path::new("even.ies")).unwrap().0;
            assert!((p.luminous_flux() / (3.0 * want * std::f64::consts::PI) - 1.0).abs() < 1e-15);
        }
    }
}
