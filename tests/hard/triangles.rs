//! 4. Bad triangles: needles, no area, repeated vertices, T-junctions, flipped windings, tiny cells.

use crate::{
    sound::{self, Space},
    thin::{hits, lit, room},
};
use glam::{DVec3, Vec3Swizzles};
use lightmend_tests::{Builder, table::Row};

const LAMP: [f64; 3] = [1.3, 1.2, 2.1];

/// The room's six sides, each cut into its own number of squares.
fn patchwork(cuts: [u32; 6], flipped: impl Fn(usize) -> bool) -> Builder {
    let high = DVec3::new(4.1, 3.3, 2.7);
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for (side, n) in cuts.into_iter().enumerate() {
        let axis = side / 2;
        let far = side % 2 == 1;
        let first = points.len() as u32;
        for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
            let mut p = DVec3::ZERO;
            p[axis] = if far { high[axis] } else { 0.0 };
            p[(axis + 1) % 3] = high[(axis + 1) % 3] * f64::from(i) / f64::from(n);
            p[(axis + 2) % 3] = high[(axis + 2) % 3] * f64::from(j) / f64::from(n);
            points.push(p);
        }
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let at = |i: u32, j: u32| first + i * (n + 1) + j;
            for [a, b, c] in [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]] {
                triangles.push(if far != flipped(triangles.len()) { [a, c, b] } else { [a, b, c] });
            }
        }
    }
    Builder::default().object("room", 0.7, points, triangles)
}

pub fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    let needle = |b: Builder, name: &str, a: DVec3, long: DVec3, wide: DVec3| {
        b.object(name, 0.6, vec![a, a + long, a + long / 2.0 + wide], vec![[0, 1, 2]])
    };
    let mut b = room();
    for (n, width) in [1e-3, 1e-6, 1e-9, 1e-12].into_iter().enumerate() {
        b = needle(
            b,
            &format!("needle {n}"),
            DVec3::new(1.0, 0.5 + 0.5 * n as f64, 0.9),
            DVec3::new(1.0, 0.3, 0.2),
            DVec3::new(0.0, 0.0, width),
        );
    }
    rows.push(sound::row("needles of 1:10³ to 1:10¹²", &b.lamp(LAMP, 100.0).build(&[]), Space::Closed));
    let [p, q, r] = [DVec3::new(1.0, 1.0, 0.9), DVec3::new(2.0, 1.2, 1.0), DVec3::new(1.4, 2.0, 1.1)];
    // What has no area at all is refused by the reader; these have some in double precision and none in single.
    let tiny = DVec3::new(1e-9, -2e-9, 3e-9);
    let corners = vec![p, q, r, p + tiny, (p + q) / 2.0 + tiny, p - tiny.yzx() * 0.7, q + tiny];
    let flat = room().object("flat", 0.6, corners, vec![[0, 1, 2], [0, 1, 4], [0, 3, 1], [0, 3, 5], [1, 6, 2]]);
    let case = "triangles whose area or corners vanish in single precision";
    rows.push(sound::row(case, &flat.lamp(LAMP, 100.0).build(&[]), Space::Closed));
    let cuts = [5, 3, 7, 4, 11, 6];
    let whole = patchwork(cuts, |_| false).lamp(LAMP, 100.0).build(&[]);
    rows.push(sound::row("a room of T-junctions", &whole, Space::Closed));
    let mixed = patchwork(cuts, |t| t % 3 == 0).lamp(LAMP, 100.0).build(&[]);
    rows.push(sound::row("a room with every third triangle turned over", &mixed, Space::Closed));
    let [a, b] = [lit(&whole), lit(&mixed)].map(|s| hits(&s, "room", &[0, 1]) as f64);
    rows.push(Row::near(
        "a room with every third triangle turned over",
        "hits on both sides ÷ those of the room without it",
        1.0,
        "both sides reflect alike; 4 standard errors",
        b / a,
        4.0 * (6.0 / a).sqrt(),
    ));
    for cell in [0.01, 0.001] {
        let mut b = room().rectangle("sheet", 0.6, [1.0, 1.0, 0.9], [0.4, 0.0, 0.0], [0.0, 0.3, 0.0]).lamp(LAMP, 100.0);
        b.file.objects.retain(|o| o.name != "room");
        b.file.cell = cell;
        rows.push(sound::row(
            &format!("a sheet of 40 cm in cells of {cell} m, most of them never hit"),
            &b.build(&[]),
            Space::Open,
        ));
    }
    rows
}
