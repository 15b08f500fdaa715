//! Directions from random numbers, to the same bits on every machine.

use crate::lanes::{Arithmetic, One, scaled};
use glam::Vec3;
use lightmend_scene::trig::{Double, sin_cos};
use std::f64::consts::TAU;

/// A direction about `normal` with density cos θ / π, of unit length to rounding. `u`, `v` in [0, 1).
pub fn cosine_hemisphere(normal: Vec3, u: f64, v: f64) -> Vec3 {
    cosine_hemispheres(One, normal.to_array(), u, v).into()
}

/// [`cosine_hemisphere`], coordinate by coordinate.
#[inline(always)]
pub(crate) fn cosine_hemispheres<A: Arithmetic>(a: A, normal: [A::Numbers; 3], u: A::Doubles, v: A::Doubles) -> [A::Numbers; 3] {
    let (sine, cosine) = sin_cos(v.constant(TAU) * v);
    let radius = u.sqrt();
    let (x, y, z) = (a.narrow(radius * cosine), a.narrow(radius * sine), a.narrow((u.constant(1.0) - u).sqrt()));
    let [tangent, bitangent] = frames(a, normal);
    let ([tx, ty, tz], [bx, by, bz], [nx, ny, nz]) = (scaled(a, tangent, x), scaled(a, bitangent, y), scaled(a, normal, z));
    [a.add(a.add(tx, bx), nx), a.add(a.add(ty, by), ny), a.add(a.add(tz, bz), nz)]
}

/// Two unit vectors that make a right-handed frame with `normal` (Duff et al. 2017).
pub fn orthonormal(normal: Vec3) -> (Vec3, Vec3) {
    let [tangent, bitangent] = frames(One, normal.to_array());
    (tangent.into(), bitangent.into())
}

/// [`orthonormal`], coordinate by coordinate.
#[inline(always)]
fn frames<A: Arithmetic>(a: A, [x, y, z]: [A::Numbers; 3]) -> [[A::Numbers; 3]; 2] {
    let one = a.splat(1.0);
    let sign = a.copysign(one, z);
    let k = a.div(a.splat(-1.0), a.add(sign, z));
    let xy = a.mul(a.mul(x, y), k);
    [
        [a.add(one, a.mul(a.mul(a.mul(sign, x), x), k)), a.mul(sign, xy), a.mul(a.negative(sign), x)],
        [xy, a.add(sign, a.mul(a.mul(y, y), k)), a.negative(y)],
    ]
}

/// A direction uniform over the sphere, unit. `u` chooses the height, downwards as it grows; `v` the azimuth.
#[inline(always)]
pub fn uniform_sphere<D: Double>(u: D, v: D) -> [D; 3] {
    let (sine, cosine) = sin_cos(v.constant(TAU) * v);
    let z = u.constant(1.0) - u.constant(2.0) * u;
    // Not below 0: u is at most 1, and z² rounds to at most 1.
    let radius = (u.constant(1.0) - z * z).sqrt();
    [radius * cosine, radius * sine, z]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal() {
        for normal in [Vec3::Z, -Vec3::Z, Vec3::X, Vec3::new(0.6, -0.8, 0.0), Vec3::new(-0.48, 0.6, -0.64)] {
            let (t, b) = orthonormal(normal);
            assert!((t.cross(b) - normal).length() < 1e-6 && t.dot(b).abs() < 1e-6);
        }
    }

    #[test]
    fn the_mean_cosine_of_lambert_is_two_thirds() {
        let n = 200;
        let middles = || (0..n).map(|i| (f64::from(i) + 0.5) / f64::from(n));
        let mean = middles()
            .flat_map(|u| middles().map(move |v| (u, v)))
            .map(|(u, v)| f64::from(cosine_hemisphere(Vec3::X, u, v).x))
            .sum::<f64>()
            / f64::from(n * n);
        assert!((mean - 2.0 / 3.0).abs() < 1e-4);
    }
}
