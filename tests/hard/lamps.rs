//! 5. Lamps: on surfaces, edges and corners, enclosed, narrow, with odd diagrams, many, and of very unequal strength.

use crate::{
    sound::{self, Space},
    thin::{hits, lit, room},
};
use glam::DVec3;
use lightmend_photon::{irradiance::Scale, path::FirstHits, probe, solution::Solution};
use lightmend_scene::Scene;
use lightmend_tests::{Builder, count, pool, shoot, sphere, table::Row, world};
use std::{f64::consts::PI, sync::Arc};

const BOTH: &[u8] = &[0, 1];

/// Flux that arrives directly, all surfaces of black rooms together, by lamp; lumens of the first channel.
fn direct_flux(solution: &Solution, photons: u64) -> Vec<f64> {
    let scale = Scale::new(solution.world(), photons);
    let mut flux = vec![0.0; solution.world().configuration().lamp_slots()];
    for (at, bucket) in solution.buckets().lit() {
        let lamp = usize::from(at.lamp);
        flux[lamp] += bucket.energy[0] as f64 * scale.lumens(lamp).x;
    }
    flux
}

pub fn rows() -> Vec<Row> {
    let mut rows = places();
    rows.extend(enclosed());
    rows.extend(near());
    rows.extend(diagrams());
    rows.extend(many());
    rows
}

/// A box in the room, with the lamp somewhere on it.
fn places() -> Vec<Row> {
    let cube = || room().cuboid("box", 0.5, [1.0, 1.0, 0.0], [1.6, 1.5, 0.8], false);
    let places = [
        ("1 mm above a surface", [1.3, 1.2, 0.801]),
        ("1 mm beside the wall", [0.001, 1.2, 0.801]),
        ("exactly on a surface", [1.3, 1.2, 0.8]),
        ("exactly on an edge", [1.3, 1.0, 0.8]),
        ("exactly on a vertex", [1.0, 1.0, 0.8]),
        ("in the plane of a wall", [0.0, 1.2, 1.3]),
        ("in a corner of the room", [0.0, 0.0, 0.0]),
        ("in the plane of a box's top, beside it", [2.2, 1.2, 0.8]),
    ];
    let mut rows = Vec::new();
    for (place, at) in places {
        let scene = cube().lamp(at, 100.0).build(&[]);
        let case = format!("lamp {place}");
        let solution = lit(&scene);
        let escaped: i64 = solution.tallies().iter().map(|t| t.escaped).sum();
        if place == "in the plane of a wall" || place == "in a corner of the room" {
            // A lamp in a surface shines to both of its sides.
            let share = escaped as f64 / solution.pool().photons() as f64;
            let right = if place == "in a corner of the room" { 0.875 } else { 0.5 };
            let source = "directions that lead out: ½ of a wall's, ⅞ of a corner's";
            rows.push(Row::near(&case, "share of photons that leave the room", right, source, share, 0.01));
            rows.push(sound::row(&case, &scene, Space::Open));
        } else {
            rows.push(Row::exactly(&case, "photons that leave the room", 0, "closed", escaped));
            rows.push(sound::row(&case, &scene, Space::Closed));
        }
    }
    let share = share_above_a_box();
    let case = "lamp exactly on the top of a black box";
    rows.push(Row::near(case, "share of photons that reach the room", 0.5, "directions above the top", share, 0.01));
    rows
}

/// Of the photons of a lamp on the top of a black box, those that reach the black room.
pub fn share_above_a_box() -> f64 {
    // Half of the directions of a lamp on the top of a box lead up. It hovers: what lies in the floor may count as the floor's.
    let scene = Builder::default()
        .cuboid("room", 0.0, [0.0; 3], [4.0, 3.0, 2.5], true)
        .cuboid("box", 0.0, [1.0, 1.0, 0.1], [1.6, 1.5, 0.8], false)
        .lamp([1.3, 1.2, 0.8], 100.0)
        .build(&[]);
    let solution = lit(&scene);
    hits(&solution, "room", BOTH) as f64 / solution.pool().photons() as f64
}

/// A lamp that its shade or an object hides.
fn enclosed() -> Vec<Row> {
    let mut rows = Vec::new();
    let (points, triangles) = sphere(2);
    let points: Vec<DVec3> = points.into_iter().map(|p| DVec3::new(2.0, 1.5, 1.4) + p * 0.15).collect();
    let shade = room().object("shade", 0.6, points, triangles).lamp([2.02, 1.51, 1.38], 100.0).build(&[]);
    let solution = lit(&shade);
    rows.push(Row::exactly(
        "lamp in a closed lampshade",
        "hits outside",
        0,
        "sealed",
        hits(&solution, "room", BOTH) + hits(&solution, "shade", &[1]),
    ));
    rows.push(sound::row("lamp in a closed lampshade", &shade, Space::Closed));
    let inside = room().cuboid("box", 0.5, [1.0, 1.0, 0.1], [1.6, 1.5, 0.8], false).lamp([1.3, 1.2, 0.3], 100.0).build(&[]);
    let solution = lit(&inside);
    rows.push(Row::exactly(
        "lamp inside a box that hovers above the floor",
        "hits outside",
        0,
        "sealed",
        hits(&solution, "room", BOTH) + hits(&solution, "box", &[0]),
    ));
    rows.push(sound::row("lamp inside a box that hovers above the floor", &inside, Space::Closed));
    rows
}

/// Inverse squares close to a surface, and how they meet form factors.
fn near() -> Vec<Row> {
    let mut rows = Vec::new();
    let scene = |height: f64| {
        Builder::default()
            .rectangle("floor", 0.0, [-2.0, -2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0])
            .lamp([0.0, 0.0, height], 100.0)
            .build(&[])
    };
    for height in [1.0, 0.01, 0.001] {
        let scene = scene(height);
        let world = world(&scene);
        let case = format!("lamp of 100 cd, {height} m above a floor");
        let got = probe::direct(&world, DVec3::new(0.0, 0.0, 0.0), DVec3::Z).x;
        rows.push(Row::near(&case, "direct illuminance below it, lux", 100.0 / (height * height), "I / h²", got, 1e-6));
        let photons = count(300_000, 10_000_000);
        let solution = shoot(pool(photons), &world, FirstHits::Always);
        let flux = direct_flux(&solution, photons)[0];
        // Solid angle of a rectangle of half sides a above whose middle the lamp stands: 4 asin(a² / (a² + h²)).
        let a2 = 4.0;
        let right = 100.0 * 4.0 * (a2 / (a2 + height * height)).asin();
        let share = right / (400.0 * PI);
        let tolerance = 4.0 * ((1.0 - share) / share / photons as f64).sqrt();
        rows.push(Row::near(
            &case,
            "flux on the floor, lumens",
            right,
            "solid angle of the floor; 4 standard errors",
            flux,
            tolerance,
        ));
    }
    rows
}

const HEAD: &str = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1";

/// A black sphere about a lamp with a diagram: all light arrives, and where it should.
fn diagrams() -> Vec<Row> {
    let files = [
        ("a beam of 1°", format!("{HEAD} 3 1 1 2 0 0 0\n1 1 10\n0 0.5 0.51\n0\n10000 10000 0\n")),
        ("a diagram with one plane", format!("{HEAD} 4 1 1 2 0 0 0\n1 1 10\n0 30 60 90\n0\n1000 800 300 0\n")),
        ("a diagram with a hole at the pole", format!("{HEAD} 5 1 1 2 0 0 0\n1 1 10\n0 5 10 45 90\n0\n0 0 500 400 0\n")),
        (
            "a diagram of two halves, one dark",
            format!("{HEAD} 3 4 1 2 0 0 0\n1 1 10\n0 45 90\n0 90 270 360\n800 600 0\n0 0 0\n0 0 0\n800 600 0\n"),
        ),
    ];
    let mut rows = Vec::new();
    for (case, file) in files {
        let (points, triangles) = sphere(5);
        let mut builder = Builder::default().object("sphere", 0.0, points, triangles).lamp([0.0; 3], 1.0);
        builder.file.lamps[0].photometry = Some("lamp.ies".into());
        builder.file.lamps[0].rotation = DVec3::new(20.0, -35.0, 110.0);
        let scene = builder.build(&[("lamp.ies", &file)]);
        let photons = count(200_000, 10_000_000);
        let world = world(&scene);
        let solution = shoot(pool(photons), &world, FirstHits::Always);
        let flux = scene.lamps[0].flux().x;
        let got = direct_flux(&solution, photons)[0];
        rows.push(Row::near(case, "flux on a sphere about it, lumens", flux, "the file's lumens, integrated", got, 1e-9));
        // Hits where the file shines nothing, by the middle of the sphere's triangle, less its width.
        let lamp = &scene.lamps[0];
        let to_lamp_axes = world.lamps()[0].rotation.transpose();
        let object = &scene.objects[0];
        let dark = solution.buckets().lit().filter(|(at, _)| {
            let [a, b, c] = object.mesh.corners(object.lattice.triangle_of(at.cell));
            // Any of the triangle's points may have been hit.
            let weights = (0..=8).flat_map(|i| (0..=8 - i).map(move |j| (f64::from(i) / 8.0, f64::from(j) / 8.0)));
            let mut points = weights.map(|(u, v)| a * (1.0 - u - v) + b * u + c * v);
            points.all(|p| lamp.candela(to_lamp_axes * p).x == 0.0) && !narrower_than_a_triangle(case)
        });
        rows.push(Row::exactly(case, "hits where it shines nothing", 0, "the file", dark.map(|(_, b)| b.hits).sum::<i64>()));
        rows.push(sound::row(case, &scene, Space::Closed));
    }
    rows.extend(zero());
    rows
}

/// A beam of 1° hits a few triangles of the sphere: it is looked at by its angle instead.
fn narrower_than_a_triangle(case: &str) -> bool {
    case.contains("beam")
}

/// A lamp that gives nothing beside one that does, and alone.
fn zero() -> Vec<Row> {
    let mut rows = Vec::new();
    let make = |both: bool| {
        let builder = room().lamp([1.0, 1.0, 2.0], 0.0);
        if both { builder.lamp([2.5, 1.5, 1.7], 100.0) } else { builder }.build(&[])
    };
    for (case, both) in [("a lamp of zero flux beside one of 100 cd", true), ("a lamp of zero flux alone", false)] {
        let scene = make(both);
        let photons = count(200_000, 10_000_000);
        let solution = shoot(pool(photons), &world(&scene), FirstHits::Always);
        let flux: Vec<f64> = direct_flux(&solution, photons);
        rows.push(Row::exactly(case, "flux of the dark lamp, lumens", 0.0, "0 cd", flux[0]));
        if both {
            // Everything that the room's surfaces of reflectance 0.7 receive.
            let held = f64::from(0.7f32);
            let share = solution.world().choice().chance(1);
            let tolerance = 4.0 / (photons as f64 * share / held).sqrt();
            rows.push(Row::near(
                case,
                "flux on all surfaces, lumens",
                400.0 * PI / (1.0 - held),
                "Φ / (1 − ρ); 4 standard errors",
                flux[1],
                tolerance,
            ));
        }
        rows.push(sound::row(case, &scene, Space::Closed));
    }
    rows
}

/// A hundred lamps; two whose flux differs by a million.
fn many() -> Vec<Row> {
    let mut rows = Vec::new();
    let mut builder = room();
    for n in 0..100 {
        builder = builder.lamp(
            [0.2 + 0.036 * f64::from(n), 0.3 + 2.4 * (f64::from(n) * 0.618).fract(), 2.0 + 0.4 * (f64::from(n) * 0.37).fract()],
            5.0 + f64::from(n % 7),
        );
    }
    let scene: Arc<Scene> = builder.build(&[]);
    let photons = count(200_000, 10_000_000);
    let solution = shoot(pool(photons), &world(&scene), FirstHits::Always);
    let held = f64::from(0.7f32);
    let lumens: f64 = scene.lamps.iter().map(|l| l.flux().x).sum();
    let flux: f64 = direct_flux(&solution, photons).iter().sum();
    rows.push(Row::near(
        "a hundred lamps",
        "flux on all surfaces, lumens",
        lumens / (1.0 - held),
        "Σ Φ / (1 − ρ); 4 standard errors",
        flux,
        4.0 * (held / photons as f64).sqrt() * 1.2,
    ));
    rows.push(sound::row("a hundred lamps", &scene, Space::Closed));
    let scene = room().lamp([1.0, 1.0, 2.0], 1e-4).lamp([2.5, 1.5, 1.7], 100.0).build(&[]);
    let solution = shoot(pool(photons), &world(&scene), FirstHits::Always);
    let flux = direct_flux(&solution, photons);
    for (lamp, name) in ["weak", "strong"].into_iter().enumerate() {
        let right = scene.lamps[lamp].flux().x / (1.0 - held);
        let share = solution.world().choice().chance(lamp);
        let tolerance = 4.0 * (held / (photons as f64 * share)).sqrt();
        rows.push(Row::near(
            "two lamps, one of a millionth of the other's flux",
            &format!("flux of the {name} one on all surfaces, lumens"),
            right,
            "Φ / (1 − ρ); 4 standard errors",
            flux[lamp],
            tolerance,
        ));
    }
    rows.push(sound::row("two lamps, one of a millionth of the other's flux", &scene, Space::Closed));
    rows
}
