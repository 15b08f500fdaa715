//! Directions from random numbers, to the same bits on every machine.

use glam::Vec3;
use lightmend_scene::trig::sin_cos;
use std::f64::consts::TAU;

/// A direction about `normal` with density cos θ / π, of unit length to rounding. `u`, `v` in [0, 1).
#[inline(always)]
pub fn cosine_hemisphere(normal: Vec3, u: f64, v: f64) -> Vec3 {
    let (sine, cosine) = sin_cos(TAU * v);
    let radius = u.sqrt();
    let (x, y, z) = ((radius * cosine) as f32, (radius * sine) as f32, (1.0 - u).sqrt() as f32);
    let (tangent, bitangent) = orthonormal(normal);
    tangent * x + bitangent * y + normal * z
}

/// Two unit vectors that make a right-handed frame with `normal` (Duff et al. 2017).
#[inline(always)]
pub fn orthonormal(normal: Vec3) -> (Vec3, Vec3) {
    let sign = 1f32.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    (
        Vec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
    )
}

/// A direction uniform over the sphere, unit. `u` chooses the height, downwards as it grows; `v` the azimuth.
#[inline(always)]
pub fn uniform_sphere(u: f64, v: f64) -> glam::DVec3 {
    let (sine, cosine) = sin_cos(TAU * v);
    let z = 1.0 - 2.0 * u;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    glam::DVec3::new(radius * cosine, radius * sine, z)
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
