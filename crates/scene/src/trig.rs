//! Sine and cosine with the same bits on every machine.
//!
//! The standard library's call the platform's libm, which differs in the last bit between systems; a photon path
//! that begins with such a bit is another path. Here are only `+ - *` and comparisons on IEEE 754 doubles, never fused.
//! Kernels on [-π/4, π/4]: minimax polynomials of fdlibm (`k_sin.c`, `k_cos.c`, Sun Microsystems 1993).
//! Reduction: degrees exactly; radians by Cody and Waite 1980 with π/2 in three parts of 33 bits.

use std::{
    f64::consts::{FRAC_2_PI, PI},
    ops::{Add, Div, Mul, Sub},
};

/// Adding and subtracting 1.5 · 2^52 rounds to the nearest integer, ties to even; without SSE 4.1 `f64::round` is a call.
const ROUND: f64 = 6755399441055744.0;

/// π/2 in parts of 33 bits: whole multiples up to 2^20 of the first two are exact.
const PI_2_HIGH: f64 = 1.57079632673412561417e+00;
const PI_2_MIDDLE: f64 = 6.07710050630396597660e-11;
const PI_2_LOW: f64 = 2.02226624879595063154e-21;

/// A double, or several of them side by side: each is computed with as by itself.
pub trait Double: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> {
    /// A constant, as often as there are numbers.
    fn constant(self, value: f64) -> Self;

    /// √x
    fn sqrt(self) -> Self;

    /// The pair turned by quarters of a circle, of which `rounded` holds the whole number in its lowest bits.
    fn turned(pair: (Self, Self), rounded: Self) -> (Self, Self);
}

impl Double for f64 {
    #[inline(always)]
    fn constant(self, value: f64) -> f64 {
        value
    }

    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }

    /// Without branches: the quarter is random in a sampler. Exchanged by their bits: a choice between them would become one.
    #[inline(always)]
    fn turned((sin, cos): (f64, f64), rounded: f64) -> (f64, f64) {
        let (q, sin, cos) = (rounded.to_bits(), sin.to_bits(), cos.to_bits());
        let exchange = (sin ^ cos) & (q & 1).wrapping_neg();
        let sign = |q: u64| (q & 2) << 62;
        (f64::from_bits(sin ^ exchange ^ sign(q)), f64::from_bits(cos ^ exchange ^ sign(q.wrapping_add(1))))
    }
}

/// (sin x, cos x), `x` in radians; absolute error below 1e-15 for |x| < 10^6, growing with |x| beyond; NaN for a non-finite `x`.
#[inline(always)]
pub fn sin_cos<D: Double>(x: D) -> (D, D) {
    let rounded = x * x.constant(FRAC_2_PI) + x.constant(ROUND);
    let quarters = rounded - x.constant(ROUND);
    let rest = ((x - quarters * x.constant(PI_2_HIGH)) - quarters * x.constant(PI_2_MIDDLE)) - quarters * x.constant(PI_2_LOW);
    D::turned(kernel(rest), rounded)
}

/// (sin d, cos d), `d` in degrees; absolute error below 1e-15 for |d| < 10^12; exactly 0 and ±1 at whole multiples
/// of 90; NaN for a non-finite `d`.
#[inline]
pub fn sin_cos_degrees(d: f64) -> (f64, f64) {
    let rounded = d * (1.0 / 90.0) + ROUND;
    // Exact: both are multiples of the last place of d, and the difference is no larger than d.
    let rest = d - (rounded - ROUND) * 90.0;
    f64::turned(kernel(rest * (PI / 180.0)), rounded)
}

/// (sin x, cos x) for |x| ≤ π/4 and a little more.
#[inline(always)]
fn kernel<D: Double>(x: D) -> (D, D) {
    let z = x * x;
    let s = x.constant(8.33333333332248946124e-03)
        + z * (x.constant(-1.98412698298579493134e-04)
            + z * (x.constant(2.75573137070700676789e-06)
                + z * (x.constant(-2.50507602534068634195e-08) + z * x.constant(1.58969099521155010221e-10))));
    let sin = x + x * z * (x.constant(-1.66666666666666324348e-01) + z * s);
    let c = x.constant(4.16666666666666019037e-02)
        + z * (x.constant(-1.38888888888741095749e-03)
            + z * (x.constant(2.48015872894767294178e-05)
                + z * (x.constant(-2.75573143513906633035e-07)
                    + z * (x.constant(2.08757232129817482790e-09) + z * x.constant(-1.13596475577881948265e-11)))));
    // 1 - z/2 loses bits; they are put back.
    let half = x.constant(0.5) * z;
    let w = x.constant(1.0) - half;
    (sin, w + (((x.constant(1.0) - w) - half) + z * z * c))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_standard_library() {
        for k in -400_000..=400_000 {
            let x = k as f64 * 1.234567e-4;
            let (s, c) = sin_cos(x);
            assert!((s - x.sin()).abs() < 1e-15 && (c - x.cos()).abs() < 1e-15, "{x}: {s} {c}");
            let x = k as f64 * 2.3456;
            let (s, c) = sin_cos(x);
            assert!((s - x.sin()).abs() < 1e-15 && (c - x.cos()).abs() < 1e-15, "{x}: {s} {c}");
        }
    }

    #[test]
    fn degrees_agree_with_the_standard_library_in_every_quarter() {
        for k in -4500..=4500 {
            let d = k as f64 * 0.01;
            let (sin, cos) = d.to_radians().sin_cos();
            for turn in -8..=8 {
                // The rounding of d + 90 turn is not an error of ours.
                let whole = d + 90.0 * turn as f64;
                let slack = 1e-15 + ((whole - 90.0 * turn as f64) - d).abs() * 0.0175;
                let (s, c) = sin_cos_degrees(whole);
                let (ws, wc) = [(sin, cos), (cos, -sin), (-sin, -cos), (-cos, sin)][(turn + 8) as usize % 4];
                assert!((s - ws).abs() < slack && (c - wc).abs() < slack, "{whole}: {s} {c}");
            }
        }
    }

    #[test]
    fn quarter_turns_are_exact() {
        for turn in -1000_i32..=1000 {
            let want = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][turn.rem_euclid(4) as usize];
            assert_eq!(sin_cos_degrees(90.0 * turn as f64), want);
        }
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
    }

    /// Bits that another machine must reproduce.
    #[test]
    fn bits_are_fixed() {
        let mut hash = 0xcbf29ce484222325_u64;
        for k in 0..10_000 {
            let (a, b) = sin_cos_degrees(k as f64 * 0.0371);
            let (c, d) = sin_cos(k as f64 * 0.0113 - 50.0);
            for x in [a, b, c, d] {
                hash = (hash ^ x.to_bits()).wrapping_mul(0x100000001b3);
            }
        }
        assert_eq!(hash, 15750483063112443532);
    }

    #[test]
    fn non_finite_is_nan() {
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(sin_cos(x).0.is_nan() && sin_cos(x).1.is_nan());
            assert!(sin_cos_degrees(x).0.is_nan() && sin_cos_degrees(x).1.is_nan());
        }
    }
}
