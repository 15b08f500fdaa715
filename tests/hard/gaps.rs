//! 6. Gaps: light that comes only through a slit, a keyhole, or a door ajar.

use crate::{
    sound::{self, Space},
    thin::hits,
};
use glam::DVec3;
use lightmend_photon::path::FirstHits;
use lightmend_tests::{Builder, count, pool, shoot, table::Row, world};
use std::f64::consts::PI;

/// The wall that parts the room, and the black screen behind it, metres.
const WALL: f64 = 2.0;
const SCREEN: f64 = 2.2;

/// A room parted by a wall with a hole `width` × `height` in its middle; a lamp `away` from the hole.
fn parted(reflectance: f64, width: f64, height: f64, away: f64) -> Builder {
    let (y, z) = ([1.5 - width / 2.0, 1.5 + width / 2.0], [1.25 - height / 2.0, 1.25 + height / 2.0]);
    let piece = |b: Builder, name: &str, low: [f64; 2], high: [f64; 2]| {
        if high[0] <= low[0] || high[1] <= low[1] {
            return b;
        }
        b.rectangle(name, reflectance, [WALL, low[0], low[1]], [0.0, high[0] - low[0], 0.0], [0.0, 0.0, high[1] - low[1]])
    };
    let mut b = Builder::default().cuboid("room", reflectance, [0.0; 3], [4.0, 3.0, 2.5], true);
    b = piece(b, "left", [0.0, 0.0], [y[0], 2.5]);
    b = piece(b, "right", [y[1], 0.0], [3.0, 2.5]);
    b = piece(b, "below", [y[0], 0.0], [y[1], z[0]]);
    b = piece(b, "above", [y[0], z[1]], [y[1], 2.5]);
    b.rectangle("screen", 0.0, [SCREEN, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 2.5]).lamp([WALL - away, 1.5, 1.25], 100.0)
}

/// Share of a lamp's light that falls on a rectangle of the screen, `distance` from it: y and z from the lamp's foot, metres.
fn share_on(distance: f64, [left, right]: [f64; 2], [low, high]: [f64; 2]) -> f64 {
    // The solid angle of a rectangle with one corner at the foot.
    let corner = |y: f64, z: f64| (y * z / (distance * (distance * distance + y * y + z * z).sqrt())).atan();
    (corner(right, high) - corner(left, high) - corner(right, low) + corner(left, low)) / (4.0 * PI)
}

/// Photons that come through to the screen, from a lamp of which a `share` of the light does.
fn through(case: &str, builder: Builder, photons: u64, share: f64) -> Row {
    let solution = shoot(pool(photons), &world(&builder.build(&[])), FirstHits::Always);
    let right = share * photons as f64;
    let (quantity, source) = ("photons that come through to the screen", "solid angle of the hole; 4 standard errors");
    Row::near(case, quantity, right, source, hits(&solution, "screen", &[0, 1]) as f64, 4.0 / right.sqrt())
}

pub fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    let photons = count(1_000_000, 10_000_000);
    for (case, width, height, away) in [
        ("a slit of 1 cm from floor to ceiling", 0.01, 2.5, 0.01),
        ("a keyhole of 1 cm × 2 cm", 0.01, 0.02, 0.02),
        ("a pinhole of 1 mm", 0.001, 0.001, 0.001),
    ] {
        let distance = SCREEN - WALL + away;
        // What comes through further up or down meets ceiling or floor before the screen.
        let [y, z] = [width, height].map(|size| (size / 2.0 * distance / away).min(1.25));
        let share = share_on(distance, [-y, y], [-z, z]);
        rows.push(through(case, parted(0.0, width, height, away), photons, share));
        rows.push(sound::row(case, &parted(0.8, width, height, 1.0).build(&[]), Space::Closed));
    }
    for (case, degrees) in [("a door, shut", 0.0), ("a door, ajar by 1°", -1.0)] {
        let made = |reflectance: f64| {
            let mut builder = parted(reflectance, 0.9, 2.5, 0.05);
            builder = builder.rectangle("door", reflectance, [WALL, 1.05, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 2.5]);
            // About its hinge at y = 1.05 m, away from the lamp, which stands before the crack.
            let door = builder.file.objects.iter_mut().find(|o| o.name == "door").unwrap();
            let hinge = DVec3::new(WALL, 1.05, 0.0);
            door.rotation = DVec3::new(0.0, 0.0, degrees);
            let turned = lightmend_scene::Pose { position: DVec3::ZERO, rotation: door.rotation }.motion();
            door.position = hinge - turned.point(hinge);
            builder.file.lamps[0].position.y = 1.93;
            builder
        };
        if degrees == 0.0 {
            let solution = shoot(pool(photons), &world(&made(0.8).build(&[])), FirstHits::Always);
            let come = hits(&solution, "screen", &[0, 1]);
            rows.push(Row::exactly(case, "photons that come through", 0, "sealed", come));
        } else {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let (edge, jamb) = ([0.05 - 0.9 * sin, 1.05 + 0.9 * cos - 1.93], [0.05, 1.95 - 1.93]);
            let [left, right] = [edge, jamb].map(|[x, y]| y / x * 0.25);
            rows.push(through(case, made(0.0), photons, share_on(0.25, [left, right], [-1.25, 1.25])));
        }
        rows.push(sound::row(case, &made(0.8).build(&[]), Space::Closed));
    }
    rows
}
