//! The sampler against closed forms, its own integrals, and fixed bits.

use super::super::{Photometry, Symmetry, place};
use glam::DVec3;
use std::f64::consts::PI;

/// 0, and the largest number below 1, and points between.
fn unit(n: usize) -> impl Iterator<Item = f64> {
    (0..n).map(move |k| k as f64 / n as f64).chain([1e-300, 1e-17, super::BELOW_ONE])
}

fn gamma(d: DVec3) -> f64 {
    d.x.hypot(d.y).atan2(-d.z)
}

fn turn(d: DVec3) -> f64 {
    d.y.atan2(d.x).to_degrees().rem_euclid(360.0)
}

/// I0 cos^n γ, tabled each degree.
fn lobe(n: i32) -> Photometry {
    let vertical: Vec<f64> = (0..=90).map(f64::from).collect();
    let candela = vertical.iter().flat_map(|g| [700.0 * g.to_radians().cos().max(0.0).powi(n); 2]).collect();
    Photometry::new(vertical, vec![0.0, 360.0], candela, Symmetry::Axial)
}

/// Uneven rows and columns, dark cells, dark rows, dark columns, a row of darkness in the midst.
fn ragged() -> Photometry {
    let vertical = vec![5.0, 6.0, 20.0, 50.0, 90.0, 90.001, 140.0, 171.0, 180.0];
    let horizontal = vec![0.0, 10.0, 90.0, 100.0, 200.0, 359.0, 360.0];
    let candela = [
        [3.0, 0.0, 0.0, 2.0, 9.0, 4.0, 3.0],
        [3.0, 0.0, 0.0, 1.0, 1.0, 7.0, 3.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 8.0, 0.0, 0.0, 6.0, 0.0, 0.0],
        [1e-20, 5.0, 1.0, 2.0, 6.0, 1e9, 1e-20],
        [0.0, 0.0, 0.0, 0.0, 0.0, 9.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    ];
    Photometry::new(vertical, horizontal, candela.concat(), Symmetry::Full)
}

/// The share of the flux below γ (radians) by the closed form [-(a + bγ) cos γ + b sin γ] of each row interval.
fn share_below(p: &Photometry, gamma: f64) -> f64 {
    let around: Vec<f64> = (0..p.vertical.len()).map(|row| turned_to(p, row, 0.0, 360.0).to_radians()).collect();
    let sum = |end: f64| {
        let mut sum = 0.0;
        for row in 0..p.vertical.len() - 1 {
            let (from, to) = (p.vertical[row].to_radians(), p.vertical[row + 1].to_radians());
            let b = (around[row + 1] - around[row]) / (to - from);
            let a = around[row] - b * from;
            let antiderivative = |g: f64| -(a + b * g) * g.cos() + b * g.sin();
            sum += antiderivative(end.clamp(from, to)) - antiderivative(from);
        }
        sum
    };
    assert!((sum(PI) / p.luminous_flux() - 1.0).abs() < 1e-10);
    sum(gamma) / sum(PI)
}

/// Integral of the intensity over C from 0 to `c` degrees, at `t` between a row and the next, candela degrees.
fn turned_to(p: &Photometry, row: usize, t: f64, c: f64) -> f64 {
    let n = p.horizontal.len();
    let at = |k: usize| {
        let below = p.candela[row * n + k];
        if t == 0.0 { below } else { (1.0 - t) * below + t * p.candela[(row + 1) * n + k] }
    };
    (1..n)
        .map(|k| {
            let (from, to) = (p.horizontal[k - 1], p.horizontal[k]);
            let x = c.clamp(from, to) - from;
            at(k - 1) * x + (at(k) - at(k - 1)) * x * x / (2.0 * (to - from))
        })
        .sum()
}

#[test]
fn lobes_follow_their_closed_form() {
    for n in [0, 1, 2, 5, 20, 100] {
        let p = lobe(n);
        // The chord below a cosine lobe's arc: the table, not the sampler, is off by about n (1°)² / 12.
        let chord = 3e-5 * (n + 1) as f64;
        assert!((p.luminous_flux() * (n + 1) as f64 / (2.0 * PI * 700.0) - 1.0).abs() < chord, "{n}");
        for u in unit(1000) {
            let g = gamma(p.sample(u, 0.25));
            assert!((share_below(&p, g) - u).abs() < 1e-12, "{n}: {u} {g}");
            assert!((1.0 - g.cos().powi(n + 1) - u).abs() < chord, "{n}: {u} {g}");
        }
        let d = p.sample(0.5, 0.25);
        assert!(d.x.abs() < 1e-15 && d.y > 0.0 && d.is_normalized());
    }
}

#[test]
fn both_distributions_are_inverted_to_rounding() {
    let p = ragged();
    for u in unit(300) {
        for v in unit(100) {
            let d = p.sample(u, v);
            assert!(d.is_normalized() && p.candela(d) > 0.0, "{u} {v} {d}");
            assert!((share_below(&p, gamma(d)) - u).abs() < 1e-10, "{u} {}", gamma(d));
            let (row, t) = place(&p.vertical, gamma(d).to_degrees());
            let share = turned_to(&p, row, t, turn(d)) / turned_to(&p, row, t, 360.0);
            assert!((share - v).abs() < 1e-8, "{u} {v}: {share}");
        }
    }
}

#[test]
fn gamma_grows_with_u_and_c_with_v() {
    for p in [lobe(3), ragged()] {
        let (mut below, mut before) = (0.0, 0.0);
        for k in 0..1_000_000 {
            let u = k as f64 * 1e-6;
            let g = gamma(p.sample(u, 0.5));
            assert!(g >= below, "{u}: {g} after {below}");
            let c = turn(p.sample(0.3, u));
            assert!(c >= before, "{u}: {c} after {before}");
            (below, before) = (g, c);
        }
    }
}

/// Bits that another machine must reproduce.
#[test]
fn bits_are_fixed() {
    let mut hash = 0xcbf29ce484222325_u64;
    // No library cosine in these tables.
    let axial = Photometry::new(vec![0.0, 30.0, 90.0], vec![0.0, 360.0], vec![5.0, 5.0, 8.0, 8.0, 0.0, 0.0], Symmetry::Axial);
    for p in [ragged(), axial] {
        for k in 0..10_000 {
            let d = p.sample(k as f64 * 1e-4, (k as f64 * 0.618033988749895) % 1.0);
            for x in d.to_array() {
                hash = (hash ^ x.to_bits()).wrapping_mul(0x100000001b3);
            }
        }
    }
    assert_eq!(hash, 223443682006068804);
}
