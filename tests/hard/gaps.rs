//! 6. Gaps: light that comes only through a slit, a keyhole, or a door ajar.

use crate::{
    sound::{self, Space},
    table::Row,
    thin::hits,
};
use glam::DVec3;
use lightmend_photon::path::FirstHits;
use lightmend_tests::{Builder, count, pool, shoot, world};
use std::f64::consts::PI;

/// A room parted at x = 2 m by a wall with a hole `width` × `height` in its middle; a black screen behind it.
fn parted(reflectance: f64, width: f64, height: f64) -> Builder {
    let (y, z) = ([1.5 - width / 2.0, 1.5 + width / 2.0], [1.25 - height / 2.0, 1.25 + height / 2.0]);
    let piece = |b: Builder, name: &str, low: [f64; 2], high: [f64; 2]| {
        if high[0] <= low[0] || high[1] <= low[1] {
            return b;
        }
        b.rectangle(name, reflectance, [2.0, low[0], low[1]], [0.0, high[0] - low[0], 0.0], [0.0, 0.0, high[1] - low[1]])
    };
    let mut b = Builder::default().cuboid("room", reflectance, [0.0; 3], [4.0, 3.0, 2.5], true);
    b = piece(b, "left", [0.0, 0.0], [y[0], 2.5]);
    b = piece(b, "right", [y[1], 0.0], [3.0, 2.5]);
    b = piece(b, "below", [y[0], 0.0], [y[1], z[0]]);
    b = piece(b, "above", [y[0], z[1]], [y[1], 2.5]);
    b.rectangle("screen", 0.0, [2.2, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 2.5]).lamp([1.0, 1.5, 1.25], 100.0)
}

pub fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    let photons = count(1_000_000, 50_000_000);
    for (case, width, height) in [
        ("a slit of 1 cm from floor to ceiling", 0.01, 2.5),
        ("a keyhole of 1 cm × 2 cm", 0.01, 0.02),
        ("a pinhole of 1 mm", 0.001, 0.001),
    ] {
        let scene = parted(0.0, width, height).build(&[]);
        let solution = shoot(pool(photons), &world(&scene), FirstHits::Always);
        let got = hits(&solution, "screen", &[0, 1]) as f64;
        // What comes through further up or down meets ceiling or floor before the screen, 1.2 m from the lamp.
        let (a, b) = (width / 2.0, (height / 2.0).min(1.25 / 1.2));
        let share = 4.0 * (a * b / ((a * a + 1.0) * (b * b + 1.0)).sqrt()).asin() / (4.0 * PI);
        let right = share * photons as f64;
        // Four standard errors of random points, and one photon.
        rows.push(Row::near(
            case,
            "photons that come through to the screen",
            right,
            "solid angle of the hole; 4 standard errors",
            got,
            (4.0 * right.sqrt() + 1.0) / right,
        ));
        let bright = parted(0.8, width, height).build(&[]);
        rows.push(sound::row(case, &bright, Space::Closed));
    }
    for (case, degrees) in [("a door, shut", 0.0), ("a door, ajar by 1°", 1.0)] {
        let mut builder = parted(0.8, 0.9, 2.5).rectangle("door", 0.8, [2.0, 1.05, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 2.5]);
        // About its hinge at y = 1.05 m.
        let door = builder.file.objects.iter_mut().find(|o| o.name == "door").unwrap();
        let hinge = DVec3::new(2.0, 1.05, 0.0);
        door.rotation = DVec3::new(0.0, 0.0, degrees);
        door.position = hinge - lightmend_scene::Pose { position: DVec3::ZERO, rotation: door.rotation }.motion().point(hinge);
        let scene = builder.build(&[]);
        let solution = shoot(pool(photons / 10), &world(&scene), FirstHits::Always);
        let through = hits(&solution, "screen", &[0, 1]);
        let (right, source) = if degrees == 0.0 { (0, "sealed") } else { (1, "some light must come through its 1.6 cm") };
        rows.push(Row::exactly(
            case,
            if degrees == 0.0 { "photons that come through" } else { "whether photons come through" },
            right,
            source,
            if degrees == 0.0 { through } else { i64::from(through > 0) },
        ));
        rows.push(sound::row(case, &scene, Space::Closed));
    }
    rows
}
