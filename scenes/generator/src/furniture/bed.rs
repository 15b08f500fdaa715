//! The bed, its pillow, and the box that is kept under it.

use super::bar;
use crate::mesh::Mesh;
use crate::shapes::{cushion, grid_box, leg, soft_block, steps};
use crate::solid::{Solid, v};

/// The bed, 2.0 m long (its head at −x) and 1.5 m wide; 0.28 m are free under it.
pub fn bed() -> Mesh {
    const WOOD: &str = "oak";
    let mut s = vec![
        bar(WOOD, [-0.96, 0.98], [-0.75, -0.725], [0.28, 0.42]),
        bar(WOOD, [-0.96, 0.98], [0.725, 0.75], [0.28, 0.42]),
        bar(WOOD, [0.98, 1.005], [-0.755, 0.755], [0.28, 0.44]),
        soft_block(v(-1.03, -0.78, 0.2), v(-0.961, 0.78, 1.05), 0.03).of("headboard cloth"),
        soft_block(v(-0.95, -0.72, 0.3), v(0.97, 0.72, 0.53), 0.05).of("linen"),
        duvet(),
    ];
    for (x, y) in [(-0.99, -0.66), (-0.99, 0.66)] {
        s.push(bar(WOOD, [x - 0.03, x + 0.03], [y - 0.03, y + 0.03], [0.0, 0.1999]));
    }
    for y in [-0.68, 0.68] {
        s.push(leg(v(0.945, y, 0.0), v(0.94, y * 0.99, 0.2799), 0.05, 0.07).of(WOOD));
    }
    Mesh::new("bed", s)
}

/// The duvet: a slab 5 cm thick, bent over both sides of the mattress, folded back towards the head.
fn duvet() -> Solid {
    const TOP: f64 = 0.532;
    const ROUND: f64 = 0.055;
    const FLAT: f64 = 0.72 - 0.05;
    const ARC: f64 = ROUND * std::f64::consts::FRAC_PI_2;
    let side = [FLAT, FLAT + ARC / 2.0, FLAT + ARC, FLAT + ARC + 0.04];
    let mut ss: Vec<f64> = side.iter().rev().map(|s| -s).collect();
    ss.extend(steps(-FLAT, FLAT, 4).iter().skip(1).take(3));
    ss.extend(side);
    grid_box(&steps(-0.32, 0.965, 4), &ss, &[0.0, 0.05])
        .map(|p| {
            let over = (p.y.abs() - FLAT).max(0.0);
            let angle = (over / ROUND).min(std::f64::consts::FRAC_PI_2);
            let down = (over - ARC).max(0.0);
            // Down fills it unevenly: the upper side waves.
            let wave = if p.z > 0.0 && over == 0.0 {
                0.012 * (5.0 * p.x + 3.0 * p.y).sin() * (4.0 * p.y - 2.0 * p.x).cos()
            } else {
                0.0
            };
            let r = ROUND + p.z;
            let y = p.y.signum() * (p.y.abs().min(FLAT) + if over > 0.0 { r * angle.sin() } else { 0.0 });
            v(p.x, y, TOP - ROUND + r * angle.cos() - down + wave)
        })
        .of("duvet")
}

/// A pillow, its underside at z = 0.
pub fn pillow() -> Mesh {
    Mesh::new("pillow", vec![cushion(0.62, 0.42, 0.15).turn_z(90.0).at(v(0.0, 0.0, 0.075)).of("linen")])
}

/// A flat box with a lid, 0.5 × 0.4 × 0.18 m, that goes under the bed.
pub fn box_under_bed() -> Mesh {
    let s = vec![
        bar("cardboard", [-0.24, 0.24], [-0.19, 0.19], [0.0, 0.14]),
        bar("box lid", [-0.25, 0.25], [-0.2, 0.2], [0.1401, 0.18]),
    ];
    Mesh::new("box_under_bed", s)
}
