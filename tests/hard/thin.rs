//! 3. Thin and touching: walls of a tenth of a millimetre, sheets, coplanar and coincident surfaces. No leak into sealed space.

use crate::{
    long_paths::foretold,
    sound::{self, Space},
};
use glam::DVec3;
use lightmend_photon::{
    irradiance::Scale,
    path::FirstHits,
    reconstruction::{Reconstruction, Shapes},
    solution::Solution,
};
use lightmend_scene::{Pose, Scene, luminance};
use lightmend_tests::{Builder, count, pool, shoot, table::Row, world};
use std::sync::Arc;

const ROOM: [[f64; 3]; 2] = [[0.0; 3], [4.0, 3.0, 2.5]];

/// The closed room that all of this stands in.
pub fn room() -> Builder {
    Builder::default().cuboid("room", 0.7, ROOM[0], ROOM[1], true)
}

/// All light, direct light too.
pub fn lit(scene: &Arc<Scene>) -> Solution {
    shoot(pool(count(100_000, 8_000_000)), &world(scene), FirstHits::Always)
}

/// Hits on some sides of an object.
pub fn hits(solution: &Solution, object: &str, sides: &[u8]) -> i64 {
    let id = solution.world().configuration().object_id(object).unwrap() as u32;
    solution.buckets().lit().filter(|(at, _)| at.object == id && sides.contains(&at.side)).map(|(_, b)| b.hits).sum()
}

const BOTH: &[u8] = &[0, 1];

/// A double wall about sealed space.
fn shell(builder: Builder, thickness: f64) -> Builder {
    let (low, high) = ([1.0, 1.0, 0.3], [1.8, 1.7, 0.9]);
    builder.cuboid("outer", 0.7, low, high, false).cuboid(
        "inner",
        0.7,
        low.map(|x| x + thickness),
        high.map(|x| x - thickness),
        true,
    )
}

/// Turns objects about odd axes, so that `middle` comes to stand in the middle of the room.
fn turned(mut builder: Builder, names: &[&str], middle: DVec3) -> Builder {
    let rotation = DVec3::new(17.0, -31.0, 23.0);
    let moved = Pose { position: DVec3::ZERO, rotation }.motion().point(middle);
    for object in builder.file.objects.iter_mut().filter(|o| names.contains(&o.name.as_str())) {
        (object.rotation, object.position) = (rotation, DVec3::new(2.0, 1.5, 1.25) - moved);
    }
    builder
}

pub fn rows() -> Vec<Row> {
    let mut rows = walls();
    rows.extend(sheets());
    rows.extend(touching());
    rows.extend(coincident());
    rows
}

fn walls() -> Vec<Row> {
    let mut rows = Vec::new();
    let middle = DVec3::new(1.4, 1.35, 0.6);
    for (name, thickness) in [("1 mm", 1e-3), ("0.1 mm", 1e-4), ("0.01 mm", 1e-5)] {
        for (how, odd) in [("", false), (", turned by odd angles", true)] {
            let made = |lamp: [f64; 3]| {
                let builder = shell(room(), thickness);
                let builder = if odd { turned(builder, &["outer", "inner"], middle) } else { builder };
                builder.lamp(lamp, 100.0).build(&[])
            };
            let case = format!("box of walls of {name}{how}");
            let outside = lit(&made([3.4, 2.4, 2.2]));
            rows.push(Row::exactly(
                &case,
                "lamp outside: hits inside and in the wall",
                0,
                "sealed",
                hits(&outside, "inner", BOTH) + hits(&outside, "outer", &[1]),
            ));
            let scene = made([0.0; 3]);
            let inner = scene.objects.iter().find(|o| o.name == "inner").unwrap();
            let inside = lit(&made(inner.pose.motion().point(middle).to_array()));
            let strayed = hits(&inside, "room", BOTH) + hits(&inside, "outer", BOTH) + hits(&inside, "inner", &[1]);
            rows.push(Row::exactly(&case, "lamp inside: hits outside and in the wall", 0, "sealed", strayed));
        }
    }
    let scene = shell(room(), 1e-4).lamp([3.4, 2.4, 2.2], 100.0).build(&[]);
    rows.push(sound::row("box of walls of 0.1 mm, soundness", &scene, Space::Closed));
    rows
}

fn sheets() -> Vec<Row> {
    let mut rows = Vec::new();
    // A sheet across the room, sealed to its walls: two rooms.
    let across = |x: f64| ([x, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 2.5]);
    let (corner, u, v) = across(2.0);
    let halves =
        room().rectangle("sheet", 0.6, corner, u, v).lamp([1.0, 1.5, 1.2], 100.0).lamp([3.0, 1.5, 1.2], 100.0).build(&[]);
    let solution = lit(&halves);
    let of = |side: u8, lamp: u16| {
        let id = solution.world().configuration().object_id("sheet").unwrap() as u32;
        solution
            .buckets()
            .lit()
            .filter(|(at, _)| (at.object, at.side, at.lamp) == (id, side, lamp))
            .map(|(_, b)| b.hits)
            .sum::<i64>()
    };
    let case = "a sheet that parts the room, a lamp on each side";
    rows.push(Row::exactly(
        case,
        "hits of each lamp on the other's side",
        0,
        "sealed",
        of(0, 0).min(of(1, 0)) + of(0, 1).min(of(1, 1)),
    ));
    let [a, b] = [0, 1].map(|lamp| (of(0, lamp) + of(1, lamp)) as f64);
    rows.push(Row::near(
        case,
        "hits of one lamp ÷ the other's",
        1.0,
        "symmetry; 4 standard errors",
        a / b,
        4.0 * (3.0 / a + 3.0 / b).sqrt(),
    ));
    rows.push(sound::row(case, &halves, Space::Closed));
    // Each sheet has vertices of its own: seams.
    let (low, size) = (DVec3::new(1.1, 0.9, 0.37), DVec3::new(0.73, 0.61, 0.53));
    let names: Vec<String> = (0..6).map(|n| format!("side {n}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    for (how, odd) in [("", false), (", turned by odd angles", true)] {
        let builder = six(&names, low, size);
        let builder = if odd { turned(builder, &names, low + size / 2.0) } else { builder };
        let solution = lit(&builder.build(&[]));
        let inside: i64 = names.iter().map(|name| hits(&solution, name, &[1])).sum();
        rows.push(Row::exactly(
            &format!("a box of six single sheets{how}"),
            "hits inside",
            0,
            "edges are the same numbers",
            inside,
        ));
    }
    rows
}

/// A box of sheets, front outwards.
fn six(names: &[&str], low: DVec3, size: DVec3) -> Builder {
    let mut builder = room().lamp([3.4, 2.4, 2.2], 100.0);
    for (n, name) in names.iter().enumerate() {
        let (axis, far) = (n / 2, n % 2 == 1);
        let [mut u, mut v] = [DVec3::ZERO; 2];
        (u[(axis + 1) % 3], v[(axis + 2) % 3]) = (size[(axis + 1) % 3], size[(axis + 2) % 3]);
        let mut corner = low;
        corner[axis] += if far { size[axis] } else { 0.0 };
        let (u, v) = if far { (u, v) } else { (v, u) };
        builder = builder.rectangle(name, 0.6, corner.to_array(), u.to_array(), v.to_array());
    }
    builder
}

fn touching() -> Vec<Row> {
    let lamp = [3.3, 2.2, 2.1];
    let mut rows = Vec::new();
    let mut sealed = |case: &str, builder: Builder, inside: &[(&str, &[u8])]| {
        let scene = builder.lamp(lamp, 100.0).build(&[]);
        let solution = lit(&scene);
        let strayed: i64 = inside.iter().map(|(name, sides)| hits(&solution, name, sides)).sum();
        rows.push(Row::exactly(case, "hits in sealed space", 0, "sealed", strayed));
        rows.push(sound::row(case, &scene, Space::Closed));
    };
    let legs = |mut b: Builder| {
        for (n, (x, y)) in [(1.0, 1.0), (2.0, 1.0), (1.0, 1.6), (2.0, 1.6)].into_iter().enumerate() {
            b = b.cuboid(&format!("leg {n}"), 0.6, [x, y, 0.0], [x + 0.05, y + 0.05, 0.7], false);
        }
        b.cuboid("top", 0.6, [0.9, 0.9, 0.7], [2.15, 1.75, 0.74], false)
    };
    let inside_legs: Vec<(&str, &[u8])> = vec![("leg 0", &[1]), ("leg 1", &[1]), ("leg 2", &[1]), ("leg 3", &[1]), ("top", &[1])];
    sealed("a table standing exactly on the floor", legs(room()), &inside_legs);
    let twins = room().cuboid("left", 0.6, [1.0, 1.0, 0.0], [1.5, 1.4, 0.6], false).cuboid(
        "right",
        0.6,
        [1.5, 1.0, 0.0],
        [2.1, 1.4, 0.6],
        false,
    );
    sealed("two boxes that share a face, on the floor", twins, &[("left", &[1]), ("right", &[1])]);
    let wardrobe = room().cuboid("wardrobe", 0.6, [1.0, 2.4, 0.0], [2.0, 3.0, 2.0], false);
    sealed("a wardrobe flush with the wall and the floor", wardrobe, &[("wardrobe", &[1])]);
    // What stands beyond the wall is a box of its own, so that its hits can be told.
    let pushed = room().cuboid("pushed", 0.6, [-0.3, 1.0, 0.5], [0.4, 1.6, 1.1], false).rectangle(
        "beyond",
        0.6,
        [-0.2, 1.1, 0.6],
        [0.0, 0.4, 0.0],
        [0.0, 0.0, 0.4],
    );
    sealed("a box pushed half-way into a wall", pushed, &[("pushed", &[1]), ("beyond", BOTH), ("room", &[1])]);
    let wedge = {
        let lid = vec![
            DVec3::new(1.0, 0.5, 0.8),
            DVec3::new(3.0, 0.5, 0.8 + 2.0 * 0.1f64.to_radians().tan()),
            DVec3::new(3.0, 2.0, 0.8 + 2.0 * 0.1f64.to_radians().tan()),
            DVec3::new(1.0, 2.0, 0.8),
        ];
        room().cuboid("block", 0.9, [1.0, 0.5, 0.3], [3.0, 2.0, 0.8], false).object("lid", 0.9, lid, vec![[0, 1, 2], [0, 2, 3]])
    };
    sealed("a wedge of 0.1° between a block and a lid", wedge, &[("block", &[1])]);
    rows
}

fn coincident() -> Vec<Row> {
    let lamp = [1.3, 1.2, 2.1];
    let mut rows = Vec::new();
    let rug_at = |z: f64, name: &str, b: Builder| b.rectangle(name, 0.7, [0.8, 0.7, z], [2.0, 0.0, 0.0], [0.0, 1.4, 0.0]);
    let rug = |name: &str, b: Builder| rug_at(0.0, name, b);
    let one = rug("rug", room());
    let two = rug("rug two", rug("rug", room()));
    let above = lit(&rug_at(1e-4, "rug", room()).lamp(lamp, 100.0).build(&[]));
    let above = hits(&above, "rug", &[0]) as f64;
    for (case, builder) in
        [("a rug coplanar with the floor, of the floor's reflectance", one), ("two coincident rugs on the floor", two)]
    {
        let scene = builder.lamp(lamp, 100.0).build(&[]);
        let solution = lit(&scene);
        // One reflectance everywhere: the photons' numbers alone say how often they hit something.
        let right = foretold(solution.pool(), DVec3::splat(0.7)).hits;
        let all = solution.buckets().lit().map(|(_, bucket)| bucket.hits).sum();
        rows.push(Row::exactly(case, "hits of all surfaces", right, "the photons' random numbers alone", all));
        let below: i64 = ["rug", "rug two"]
            .iter()
            .filter(|n| scene.objects.iter().any(|o| o.name == **n))
            .map(|n| hits(&solution, n, &[1]))
            .sum();
        rows.push(Row::exactly(case, "hits below a rug", 0, "nothing is between", below));
        rows.push(Row::exactly(case, "hits outside of the room", 0, "sealed", hits(&solution, "room", &[1])));
        let on = hits(&solution, "rug", &[0]) as f64;
        let quantity = "hits on the rug ÷ those on a rug 0.1 mm higher";
        let split = Row::near(case, quantity, 1.0, "the same light", on / above, 4.0 * (3.0 / above).sqrt());
        let why = "which of two surfaces in one plane a photon meets is a matter of rounding, photon by photon. Their sum is right: a probe adds them up, but a picture shows the part of the one that it draws. A rug raised by 0.1 mm has all of it";
        rows.push(split.documented(why, on > 0.0 && on < above));
        rows.push(sound::row(case, &scene, Space::Closed));
    }
    let twice = sheet(true);
    let case = "one mesh with a triangle three times, once turned over";
    let [(once, right), (copies, all)] = [&sheet(false), &twice].map(upper);
    rows.push(Row::exactly(case, "hits", right, "the same surface", all));
    for (t, [lux, plain]) in copies.into_iter().zip(once).map(|(a, b)| [a, b]).enumerate() {
        let quantity = format!("illuminance of triangle {t} from above, reconstructed, lux");
        rows.push(Row::exactly(case, &quantity, plain, "that of the mesh that has it once", lux));
    }
    rows.push(sound::row(case, &twice, Space::Closed));
    rows
}

/// A sheet of two triangles above a floor; the first also twice more, once turned over.
pub fn sheet(copies: bool) -> Arc<Scene> {
    let corners = [[1.0, 1.0], [2.0, 1.1], [1.9, 2.0], [0.9, 1.9]].map(|[x, y]| DVec3::new(x, y, 0.9)).to_vec();
    let mut triangles = vec![[0, 1, 2], [0, 2, 3]];
    triangles.extend([[0, 1, 2], [2, 1, 0]].iter().filter(|_| copies));
    room().object("sheet", 0.6, corners, triangles).lamp([1.3, 1.2, 2.1], 100.0).build(&[])
}

/// Of a sheet, the illuminance of each triangle on the side that looks up, reconstructed, lux; and hits on both sides.
pub fn upper(scene: &Arc<Scene>) -> (Vec<f64>, i64) {
    let solution = lit(scene);
    let configuration = solution.world().configuration();
    let scale = Scale::new(solution.world(), solution.pool().photons());
    let shapes = Shapes::of(configuration);
    let light = Reconstruction::new(&shapes, configuration, solution.buckets(), &scale, configuration.lamp_slots());
    let id = configuration.object_id("sheet").unwrap();
    let object = configuration.object(id);
    let lux = |t: usize| {
        let [a, b, c] = object.mesh.corners(t);
        let side = usize::from((b - a).cross(c - a).z < 0.0);
        let cells = object.lattice.cells_of(t);
        let count = cells.clone().count() as f64;
        cells.map(|cell| luminance(light.cell(id, cell, side).value)).sum::<f64>() / count
    };
    ((0..object.mesh.triangles.len()).map(lux).collect(), hits(&solution, "sheet", BOTH))
}
