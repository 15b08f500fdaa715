//! Exact importance sampling of a goniometric table by inversion, γ first and then C.
//!
//! 1. The intensity integrated over C is piecewise linear in γ, m(γ). The table is cut into bands of γ, none wider than
//!    2.5°. In a band that begins at g, the flux up to g + h is F(h) = ∫ m(g + x) sin(g + x) dx: closed form
//!    [-(a + bγ) cos γ + b sin γ], which cancels badly in narrow bands; its Taylor polynomial of degree 9 in h does not
//!    and, at 2.5°, is exact to rounding. `u` picks the band (guide table of Chen and Asau 1974), Halley's iteration inverts F.
//! 2. At that γ the intensity is piecewise linear in C and its integral up to a column is linear in γ: `v` picks the
//!    column by bisection in the two rows' interpolated integrals, and a quadratic gives C.
//!
//! Only `+ - * /`, square roots and [`crate::trig`]: the same bits on every machine.

use crate::trig::sin_cos_degrees;
use glam::DVec3;

/// Widest band, degrees: at 2.5 the terms left out of F are below 1e-16 of it. Narrower bands gained no speed.
const BAND: f64 = 2.5;
/// Terms of F: h^1 to h^9.
const TERMS: usize = 9;
/// Samples stay this far inside their cell, degrees: rounding of the direction must not carry them over an edge
/// beyond which there is no light. A thousand times the rounding, and no measurable loss.
const INSIDE: f64 = 1e-11;
/// Bands below this share of the flux are left out: `u` cannot resolve them.
const LEAST: f64 = 1e-20;
const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;
const RADIAN: f64 = std::f64::consts::PI / 180.0;

/// A band of γ with flux in it.
#[derive(Debug, Clone, PartialEq)]
struct Band {
    /// Shares of the flux below the band and below its end.
    share: (f64, f64),
    /// γ at the begin, degrees.
    gamma: f64,
    /// Width, radians and degrees.
    width: f64,
    width_degrees: f64,
    /// The row of the table at or before the band, how far the band begins from it towards the next row (0..1),
    /// and the same per degree.
    row: usize,
    offset: f64,
    per_degree: f64,
    /// Coefficients of h^1, h^2, ... (h in radians) in F, lumens.
    terms: [f64; TERMS],
    /// The h^2 coefficient of the parabola with F's begin, slope there and end: the iteration starts on it.
    bend: f64,
}

/// The tables of the method.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sampler {
    axial: bool,
    flux: f64,
    bands: Vec<Band>,
    /// First band that can hold `u` in [k / n, (k + 1) / n); n a power of two.
    guide: Vec<u32>,
    /// Integral of the intensity over C from 0 to each column, candela degrees, `[vertical][horizontal]`.
    around: Vec<f64>,
}

impl Sampler {
    /// Of a table as `Photometry` keeps it.
    pub(super) fn new(vertical: &[f64], horizontal: &[f64], candela: &[f64], axial: bool) -> Self {
        let columns = horizontal.len();
        let mut around = Vec::with_capacity(candela.len());
        for row in candela.chunks_exact(columns) {
            let mut sum = 0.0;
            around.push(sum);
            for k in 1..columns {
                sum += 0.5 * (row[k - 1] + row[k]) * (horizontal[k] - horizontal[k - 1]);
                around.push(sum);
            }
        }
        let full_turn = |row: usize| around[(row + 1) * columns - 1] * RADIAN;

        let mut bands: Vec<(Band, f64)> = Vec::new();
        for row in 0..vertical.len() - 1 {
            let span = vertical[row + 1] - vertical[row];
            let cuts = (span / BAND).ceil().max(1.0);
            let (begin, rise) = (full_turn(row), full_turn(row + 1) - full_turn(row));
            for cut in 0..cuts as usize {
                let offset = cut as f64 / cuts;
                let band = Band::new(vertical[row] + span * offset, span / cuts, begin + rise * offset, rise / (span * RADIAN));
                let lumens = band.up_to(band.width).max(0.0);
                bands.push((Band { row, offset, per_degree: 1.0 / span, ..band }, lumens));
            }
        }
        let flux: f64 = bands.iter().map(|b| b.1).sum();
        bands.retain(|b| b.1 > flux * LEAST);

        let mut below = 0.0;
        for (band, lumens) in &mut bands {
            let begin = below;
            below += *lumens;
            band.share = (begin / flux, below / flux);
        }
        let mut bands: Vec<Band> = bands.into_iter().map(|b| b.0).collect();
        if let Some(last) = bands.last_mut() {
            last.share.1 = 1.0;
        }
        let guide = guide(&bands);
        Self { axial, flux, bands, guide, around }
    }

    pub(super) fn flux(&self) -> f64 {
        self.flux
    }

    /// See `Photometry::sample_each`; the columns and the table are those that `new` saw.
    #[inline(always)]
    pub(super) fn sample_each<const N: usize>(
        &self,
        horizontal: &[f64],
        candela: &[f64],
        u: [f64; N],
        v: [f64; N],
    ) -> [DVec3; N] {
        let Some(last) = self.bands.len().checked_sub(1) else { return [DVec3::NEG_Z; N] };
        // The bands of u, and γ in them.
        let bands = u.map(|u| {
            let u = u.min(BELOW_ONE);
            let mut k = self.guide[(u * self.guide.len() as f64) as usize] as usize;
            while k < last && self.bands[k].share.1 <= u {
                k += 1;
            }
            &self.bands[k]
        });
        let lumens: [f64; N] = std::array::from_fn(|k| (u[k].min(BELOW_ONE) - bands[k].share.0) * self.flux);
        let h = invert_each(bands, lumens);
        std::array::from_fn(|k| {
            let (band, v) = (bands[k], v[k].min(BELOW_ONE));
            let ahead = (h[k] * (1.0 / RADIAN)).max(INSIDE).min(band.width_degrees - INSIDE);
            let c = match self.axial {
                true => 360.0 * v,
                false => self.turn(horizontal, candela, band.row, band.offset + ahead * band.per_degree, v),
            };
            let (sin_gamma, cos_gamma) = sin_cos_degrees(band.gamma + ahead);
            let (sin_c, cos_c) = sin_cos_degrees(c);
            DVec3::new(sin_gamma * cos_c, sin_gamma * sin_c, -cos_gamma)
        })
    }

    /// C, degrees, for `v`, at `t` (0..1) between the row and the next.
    fn turn(&self, horizontal: &[f64], candela: &[f64], row: usize, t: f64, v: f64) -> f64 {
        let n = horizontal.len();
        let at = |table: &[f64], column: usize| {
            let k = row * n + column;
            table[k] + t * (table[k + n] - table[k])
        };
        // The column where the integral passes the target. A column without light has equal integrals at both
        // ends, so it cannot be the one.
        let target = v * at(&self.around, n - 1);
        let (mut low, mut high) = (0, n - 1);
        while high - low > 1 {
            let middle = (low + high) / 2;
            let beyond = at(&self.around, middle) > target;
            (low, high) = if beyond { (low, middle) } else { (middle, high) };
        }
        let width = horizontal[high] - horizontal[low];
        let (p, q) = (at(candela, low), at(candela, high));
        // p s + (q - p) s² / 2 = rest, in the form that does not cancel.
        let rest = (target - at(&self.around, low)) / width;
        // 0 / 0 where the light begins; `max` takes that for the begin of the column.
        let s = 2.0 * rest / (p + (p * p + 2.0 * (q - p) * rest).max(0.0).sqrt());
        horizontal[low] + (s * width).max(INSIDE).min(width - INSIDE)
    }
}

impl Band {
    /// `gamma` and `width` in degrees; `m` the intensity integrated over C at the begin, candela radians;
    /// `slope` its growth per radian.
    fn new(gamma: f64, width: f64, m: f64, slope: f64) -> Self {
        // sin(g + x) = Σ series_n x^n
        let (sin, cos) = sin_cos_degrees(gamma);
        let mut series = [0.0; TERMS];
        let mut factorial = 1.0;
        for n in 0..TERMS {
            factorial *= n.max(1) as f64;
            series[n] = [sin, cos, -sin, -cos][n % 4] / factorial;
        }
        let mut terms = [0.0; TERMS];
        for n in 0..TERMS {
            let before = if n == 0 { 0.0 } else { series[n - 1] };
            terms[n] = (m * series[n] + slope * before) / (n + 1) as f64;
        }
        let radians = width * RADIAN;
        let mut band = Self {
            share: (0.0, 0.0),
            gamma,
            width: radians,
            width_degrees: width,
            row: 0,
            offset: 0.0,
            per_degree: 0.0,
            terms,
            bend: 0.0,
        };
        band.bend = (band.up_to(radians) - terms[0] * radians) / (radians * radians);
        band
    }

    /// Flux up to `h` radians into the band, lumens.
    fn up_to(&self, h: f64) -> f64 {
        h * self.terms.iter().rev().fold(0.0, |p, term| p * h + term)
    }
}

/// In each band h, radians, where the flux up to it is `lumens`: Halley's iteration, with bisection when it leaves the bracket. All go on
/// until the last is there, so that they need not wait for one another's results.
#[inline(always)]
fn invert_each<const N: usize>(bands: [&Band; N], lumens: [f64; N]) -> [f64; N] {
    let mut h: [f64; N] = std::array::from_fn(|k| {
        let (band, lumens) = (bands[k], lumens[k]);
        let a = band.terms[0];
        let root = (a * a + 4.0 * band.bend * lumens).max(0.0).sqrt();
        if lumens <= 0.0 { 0.0 } else { (2.0 * lumens / (a + root)).min(band.width) }
    });
    let mut there = lumens.map(|lumens| lumens <= 0.0);
    let (mut low, mut high) = ([0.0; N], bands.map(|band| band.width));
    // Bisection alone would need 53 steps; Halley takes 2, seldom 3.
    for _ in 0..53 {
        // F = h P: the Horner schemes of P, P' and P'' / 2 side by side.
        let (mut p, mut first, mut second) = ([0.0; N], [0.0; N], [0.0; N]);
        for term in (0..TERMS).rev() {
            for k in 0..N {
                second[k] = second[k] * h[k] + first[k];
                first[k] = first[k] * h[k] + p[k];
                p[k] = p[k] * h[k] + bands[k].terms[term];
            }
        }
        for k in 0..N {
            let (value, slope, curvature) = (p[k] * h[k], first[k] * h[k] + p[k], 2.0 * (second[k] * h[k] + first[k]));
            let excess = value - lumens[k];
            let beyond = excess > 0.0;
            high[k] = if beyond { h[k] } else { high[k] };
            low[k] = if beyond { low[k] } else { h[k] };
            let halley = h[k] - 2.0 * excess * slope / (2.0 * slope * slope - excess * curvature);
            let next = if (low[k] <= halley) & (halley <= high[k]) { halley } else { 0.5 * (low[k] + high[k]) };
            let moved = (next - h[k]).abs();
            h[k] = if there[k] { h[k] } else { next };
            // The error left is the cube of the step's share of the way to F's zeros, which lie beyond the ends:
            // below rounding.
            there[k] |= moved <= h[k].min(bands[k].width - h[k]) * 2e-6;
        }
        if there.iter().all(|there| *there) {
            break;
        }
    }
    h
}

/// For each of n equal steps of u, the first band that reaches beyond the step's begin.
fn guide(bands: &[Band]) -> Vec<u32> {
    let n = (2 * bands.len()).next_power_of_two();
    let mut k = 0;
    (0..n)
        .map(|step| {
            while k + 1 < bands.len() && bands[k].share.1 <= step as f64 / n as f64 {
                k += 1;
            }
            k as u32
        })
        .collect()
}

#[cfg(test)]
mod tests;
