//! Goniometric diagrams as cube maps (Dmitriev et al. 2002, §6.1.2), in candela with the file's full range.
//!
//! Sampled from the same distribution that emits the photons. Samples lie on the edges of the faces too, so that interpolation never looks
//! across an edge and the planes γ = 90°, C = 0, 90, … fall on samples. Where the measured angles end the diagram jumps to 0; a cube map
//! would smear that, so the measured range is kept beside it and the map goes on beyond with its last value. As many samples are taken as
//! the diagram needs. `composition.wgsl` (`candela`) is the other half.

use glam::DVec3;
use lightmend_scene::Photometry;
use rayon::prelude::*;

/// Intervals along a face's edge, at first and at most. The finest takes 100 megabytes on the device, the next 25: it is for what would be
/// [`bad`](CubeMap::bad) otherwise.
const COARSEST: u32 = 16;
/// Intervals along a face's edge at most.
pub const FINEST: u32 = 1024;

/// In C the error is looked for at least so often, degrees; no divisor of a right angle, so that the faces are not met alike.
const DEGREES_APART: f64 = 3.7;

/// So near to a pole, degrees, a file that says something else in each plane there says nothing that a map must hold.
const TORN: f64 = 1.0;

/// A map is fine enough when it errs by no more than this share of the peak.
pub const TOLERANCE: f64 = 0.004;

/// A lamp's luminous intensity over all directions.
#[derive(Debug, Clone, PartialEq)]
pub struct CubeMap {
    /// Intervals along a face's edge.
    pub intervals: u32,
    /// Candela; six faces of (intervals + 1)² samples, row by row.
    pub candela: Vec<f32>,
    /// cos γ of the last and of the first measured angle: outside there is no light.
    pub measured: [f32; 2],
    /// The largest error found, as a share of the peak.
    pub error: f64,
}

/// The direction of a point of face `face`; `s` and `t` from −1 to 1. Faces are +x, −x, +y, −y, +z, −z.
fn direction(face: usize, s: f64, t: f64) -> DVec3 {
    let axis = face / 2;
    let mut d = DVec3::ZERO;
    d[axis] = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    d[(axis + 1) % 3] = s;
    d[(axis + 2) % 3] = t;
    d
}

/// C and γ of a direction in the lamp's axes, degrees.
fn angles(d: DVec3) -> (f64, f64) {
    (d.y.atan2(d.x).to_degrees(), d.x.hypot(d.y).atan2(-d.z).to_degrees())
}

/// The mean over C: at the poles a file may say something else in each plane.
fn mean_around(photometry: &Photometry, gamma: f64) -> f64 {
    let between = |c: &[f64]| (c[1] - c[0]) * (photometry.candela_at(c[0], gamma) + photometry.candela_at(c[1], gamma)) / 720.0;
    photometry.horizontal().windows(2).map(between).sum()
}

impl CubeMap {
    /// The diagram of a photometric file, in `finest` intervals at most.
    pub fn new(photometry: &Photometry, finest: u32) -> CubeMap {
        let mut intervals = COARSEST.min(finest);
        loop {
            let map = CubeMap::of(photometry, intervals);
            let enough = map.error <= TOLERANCE || (2 * intervals >= FINEST && !map.bad());
            if enough || 2 * intervals > finest {
                return map;
            }
            intervals *= 2;
        }
    }

    /// Whether it errs so much that it must be told.
    pub fn bad(&self) -> bool {
        self.error > 2.0 * TOLERANCE
    }

    fn of(photometry: &Photometry, intervals: u32) -> CubeMap {
        let gamma = photometry.vertical();
        let (first, last) = (gamma[0], gamma[gamma.len() - 1]);
        let side = intervals as usize + 1;
        let place = |k: usize| 2.0 * k as f64 / f64::from(intervals) - 1.0;
        let sample = |k: usize| {
            let (face, row, column) = (k / (side * side), k / side % side, k % side);
            let d = direction(face, place(column), place(row));
            let (c, gamma) = angles(d);
            let measured = gamma.clamp(first, last);
            let pole = d.x == 0.0 && d.y == 0.0;
            if pole { mean_around(photometry, measured) as f32 } else { photometry.candela_at(c, measured) as f32 }
        };
        let candela = (0..6 * side * side).into_par_iter().map(sample).collect();
        let cosine = |gamma: f64, open: f64| if (1e-9..180.0 - 1e-9).contains(&gamma) { gamma.to_radians().cos() } else { open };
        let measured = [cosine(last, -2.0) as f32, cosine(first, 2.0) as f32];
        let mut map = CubeMap { intervals, candela, measured, error: 0.0 };
        map.error = map.worst(photometry);
        map
    }

    /// The largest error at the measured angles, where the diagram bends, and between them; a share of the peak.
    fn worst(&self, photometry: &Photometry) -> f64 {
        let divided = |knots: &[f64], step: f64| -> Vec<f64> {
            let within = |w: &[f64]| {
                let (from, by) = (w[0], w[1] - w[0]);
                let parts = (by / step).ceil().max(2.0) as usize;
                (0..parts).map(move |k| from + by * k as f64 / parts as f64)
            };
            knots.windows(2).flat_map(within).chain(knots.last().copied()).collect()
        };
        // Along γ once a sample; around the axis so that bends meet the samples in every way, also where the file has one plane only.
        let gammas = divided(photometry.vertical(), 90.0 / f64::from(self.intervals));
        let cs = divided(photometry.horizontal(), DEGREES_APART);
        let torn = [0.0, 180.0].map(|pole| {
            let around = || photometry.horizontal().iter().map(|c| photometry.candela_at(*c, pole));
            around().fold(0.0, f64::max) - around().fold(f64::INFINITY, f64::min) > 1e-6 * photometry.max_candela()
        });
        let error = |gamma: &f64| {
            let at = |c: &f64| {
                let (sin_g, cos_g) = gamma.to_radians().sin_cos();
                let (sin_c, cos_c) = c.to_radians().sin_cos();
                let direction = DVec3::new(sin_g * cos_c, sin_g * sin_c, -cos_g);
                (self.interpolated(direction) - photometry.candela_at(*c, *gamma)).abs()
            };
            let by_a_torn_pole = (torn[0] && *gamma < TORN) || (torn[1] && 180.0 - gamma < TORN);
            if by_a_torn_pole { 0.0 } else { cs.iter().map(at).fold(0.0, f64::max) }
        };
        gammas.par_iter().map(error).reduce(|| 0.0, f64::max) / photometry.max_candela().max(f64::MIN_POSITIVE)
    }

    /// Candela towards a direction, whatever range was measured: the shader's twin.
    fn interpolated(&self, d: DVec3) -> f64 {
        let size = d.abs();
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let face = 2 * axis + usize::from(d[axis] < 0.0);
        let side = self.intervals as usize + 1;
        let at = |other: usize| {
            let x = (d[other % 3] / size[axis] + 1.0) / 2.0 * f64::from(self.intervals);
            let k = (x as usize).min(self.intervals as usize - 1);
            (k, x - k as f64)
        };
        let ((column, s), (row, t)) = (at(axis + 1), at(axis + 2));
        let value = |row: usize, column: usize| f64::from(self.candela[face * side * side + row * side + column]);
        let along = |row: usize| value(row, column) * (1.0 - s) + value(row, column + 1) * s;
        along(row) * (1.0 - t) + along(row + 1) * t
    }

    /// Candela towards a direction in the lamp's axes.
    pub fn candela(&self, d: DVec3) -> f64 {
        let cosine = -d.z / d.length();
        let [last, first] = self.measured.map(f64::from);
        if cosine < last || cosine > first { 0.0 } else { self.interpolated(d) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn lamp(text: &str) -> Photometry {
        Photometry::parse(text.as_bytes(), Path::new("test.ies")).unwrap().0
    }

    #[test]
    fn maps_hold_smooth_and_narrow_diagrams() {
        let even = lamp("TILT=NONE\n1 -1 1 2 1 1 1 0 0 0\n1 1 0\n0 180\n0\n7 7\n");
        let map = CubeMap::new(&even, FINEST);
        assert_eq!(map.intervals, COARSEST);
        assert!(map.candela.iter().all(|c| *c == 7.0));
        let spot = lamp("TILT=NONE\n1 -1 1 6 1 1 1 0 0 0\n1 1 0\n0 4 8 12 20 90\n0\n1000 800 300 50 0 0\n");
        let map = CubeMap::new(&spot, FINEST);
        assert!(!map.bad() && map.intervals > COARSEST, "{} at {}", map.error, map.intervals);
        assert_eq!(map.candela(DVec3::NEG_Z), 1000.0);
        assert_eq!(map.candela(DVec3::Z), 0.0);
    }

    #[test]
    fn the_measured_range_ends_sharply() {
        let half = lamp("TILT=NONE\n1 -1 1 2 1 1 1 0 0 0\n1 1 0\n0 60\n0\n5 5\n");
        let map = CubeMap::new(&half, FINEST);
        let towards = |gamma: f64| DVec3::new(gamma.to_radians().sin(), 0.0, -gamma.to_radians().cos());
        assert_eq!(map.candela(towards(59.999)), 5.0);
        assert_eq!(map.candela(towards(60.001)), 0.0);
    }

    #[test]
    fn the_circle_runs_the_right_way() {
        let text = "TILT=NONE\n1 -1 1 3 5 1 1 0 0 0\n1 1 0\n0 90 180\n0 90 180 270 360\n\
            1 10 1\n1 20 1\n1 30 1\n1 40 1\n1 10 1\n";
        let map = CubeMap::new(&lamp(text), FINEST);
        for (d, candela) in [(DVec3::X, 10.0), (DVec3::Y, 20.0), (DVec3::NEG_X, 30.0), (DVec3::NEG_Y, 40.0)] {
            assert!((map.candela(d) - candela).abs() < 1e-5, "{d}");
        }
    }
}
