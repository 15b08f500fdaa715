//! Things that stand in a room: well made, badly made, and other people's.

use crate::places::{Numbers, extent, lamps};
use glam::{DMat3, DVec3};
use lightmend_scene::{
    Mesh, Scene,
    obj::{Strictness, read_obj},
};
use lightmend_tests::{Builder, sphere};
use std::{path::Path, sync::Arc};

/// Positions and triangles.
#[derive(Default, Clone)]
struct Shape(Vec<DVec3>, Vec<[u32; 3]>);

impl Shape {
    fn and(mut self, other: Shape) -> Shape {
        let first = self.0.len() as u32;
        self.0.extend(other.0);
        self.1.extend(other.1.iter().map(|t| t.map(|i| i + first)));
        self
    }

    fn flipped(mut self, which: impl Fn(usize) -> bool) -> Shape {
        self.1.iter_mut().enumerate().filter(|(t, _)| which(*t)).for_each(|(_, triangle)| triangle.swap(1, 2));
        self
    }

    /// Without some of its triangles.
    fn without(mut self, which: impl Fn(usize) -> bool) -> Shape {
        let mut t = 0;
        self.1.retain(|_| {
            t += 1;
            !which(t - 1)
        });
        self
    }

    fn moved(mut self, place: impl Fn(DVec3) -> DVec3) -> Shape {
        self.0.iter_mut().for_each(|p| *p = place(*p));
        self
    }

    /// Turned by odd angles about a point.
    fn turned(self, about: DVec3) -> Shape {
        let turn = DMat3::from_rotation_z(0.4137) * DMat3::from_rotation_y(0.7311) * DMat3::from_rotation_x(-0.2893);
        self.moved(|p| about + turn * (p - about))
    }

    /// Every triangle with corners of its own, off by up to `off` metres.
    fn loose(&self, off: f64) -> Shape {
        let mut numbers = Numbers(3);
        let mut jitter = move || DVec3::from_array(std::array::from_fn(|_| (2.0 * numbers.next() - 1.0) * off));
        let corners = self.1.as_flattened().iter().map(|i| self.0[*i as usize] + jitter()).collect();
        Shape(corners, (0..self.1.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect())
    }
}

/// A rectangle cut into n × m pairs of triangles, with vertices of its own.
fn sheet(corner: DVec3, u: DVec3, v: DVec3, n: u32, m: u32) -> Shape {
    let points = (0..=m).flat_map(|j| (0..=n).map(move |i| (f64::from(i) / f64::from(n), f64::from(j) / f64::from(m))));
    let positions = points.map(|(s, t)| corner + u * s + v * t).collect();
    let quads = (0..m).flat_map(|j| (0..n).map(move |i| j * (n + 1) + i));
    let triangles = quads.flat_map(|a| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]).collect();
    Shape(positions, triangles)
}

/// A box: bottom, top, front, back, left, right, two triangles each; eight vertices.
fn cuboid(low: [f64; 3], high: [f64; 3]) -> Shape {
    let corner = |k: usize| DVec3::from_array(std::array::from_fn(|a| if k >> a & 1 == 1 { high[a] } else { low[a] }));
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    Shape((0..8).map(corner).collect(), triangles)
}

/// A box whose faces are cut differently finely: T-junctions along its edges.
fn patchwork(low: [f64; 3], high: [f64; 3], cuts: [u32; 6]) -> Shape {
    let Shape(p, _) = cuboid(low, high);
    let quads: [[usize; 3]; 6] = [[0, 2, 1], [4, 5, 6], [0, 1, 4], [2, 6, 3], [0, 4, 2], [1, 3, 5]];
    let faces = quads.iter().zip(cuts).map(|([o, u, v], n)| sheet(p[*o], p[*u] - p[*o], p[*v] - p[*o], n, n));
    faces.fold(Shape::default(), Shape::and)
}

/// An open ring of a cone: a lampshade without thickness.
fn shade(middle: DVec3, lower: f64, upper: f64, height: f64, lid: bool) -> Shape {
    let n = 24u32;
    let ring = |radius: f64, z: f64| {
        (0..n).map(move |k| {
            let (s, c) = (f64::from(k) * std::f64::consts::TAU / f64::from(n)).sin_cos();
            middle + DVec3::new(radius * c, radius * s, z)
        })
    };
    let mut positions: Vec<DVec3> = ring(lower, 0.0).chain(ring(upper, height)).collect();
    let mut triangles: Vec<[u32; 3]> =
        (0..n).map(|k| (k, (k + 1) % n)).flat_map(|(a, b)| [[a, b, n + b], [a, n + b, n + a]]).collect();
    if lid {
        positions.push(middle + DVec3::Z * height);
        triangles.extend((0..n).map(|k| [n + k, n + (k + 1) % n, 2 * n]));
    }
    Shape(positions, triangles)
}

/// What surrounds the thing, 6 m × 5 m × 2.8 m.
const ROOM: [[f64; 3]; 2] = [[-3.0, -2.5, 0.0], [3.0, 2.5, 2.8]];

/// The room with these things in it.
fn room(things: &[Shape], adapt: impl FnOnce(Builder) -> Builder) -> Arc<Scene> {
    let [low, high] = extent(things.iter().flat_map(|Shape(p, _)| p.iter().copied()));
    let mut builder = Builder::default().cuboid("room", 0.5, ROOM[0], ROOM[1], true);
    for (n, Shape(positions, triangles)) in things.iter().enumerate() {
        builder = builder.object(&format!("thing {n}"), 0.5, positions.clone(), triangles.clone());
    }
    for (name, place) in lamps([low, high]) {
        builder = builder.lamp(place.to_array(), 100.0);
        builder.file.lamps.last_mut().unwrap().name = format!("lamp {name}");
    }
    adapt(builder).build(&[])
}

fn hide(mut builder: Builder, name: &str) -> Builder {
    builder.file.objects.iter_mut().filter(|o| o.name == name).for_each(|o| o.hidden_from_camera = true);
    builder
}

/// A table: a top on four legs, in contact with one another and with the floor.
fn table() -> Vec<Shape> {
    let leg = |x: f64, y: f64| cuboid([x - 0.03, y - 0.03, 0.0], [x + 0.03, y + 0.03, 0.7]);
    let legs = leg(-0.6, -0.3).and(leg(0.6, -0.3)).and(leg(-0.6, 0.3)).and(leg(0.6, 0.3));
    vec![cuboid([-0.7, -0.4, 0.7], [0.7, 0.4, 0.74]), legs]
}

/// Everything that we build, each in a room.
pub fn all() -> Vec<(&'static str, Arc<Scene>)> {
    let (low, high) = ([-0.5, -0.4, 0.3], [0.6, 0.45, 1.1]);
    let closed = || cuboid(low, high);
    let hover = DVec3::new(0.0, 0.0, 1.0);
    let flat = || sheet(DVec3::new(-0.7, -0.6, 0.8), DVec3::X * 1.3, DVec3::Y * 1.1, 1, 1);
    let plain = |things: Vec<Shape>| room(&things, |b| b);
    let fan = |k: f64| {
        let (s, c) = (0.3 + k * std::f64::consts::TAU / 3.0).sin_cos();
        let (a, b) = (DVec3::new(0.0, -0.6, 0.9), DVec3::new(0.0, 0.6, 0.9));
        let out = DVec3::new(c, 0.0, s) * 0.7;
        vec![a, b, b + out, a + out]
    };
    let three_sheets = {
        let mut positions = vec![DVec3::new(0.0, -0.6, 0.9), DVec3::new(0.0, 0.6, 0.9)];
        (0..3).for_each(|k| positions.extend(&fan(f64::from(k))[2..]));
        Shape(positions, (0..3).flat_map(|k| [[0, 1, 2 + 2 * k], [0, 2 + 2 * k, 3 + 2 * k]]).collect())
    };
    let halves = || cuboid([-0.7, -0.4, 0.3], [0.0, 0.4, 1.0]).and(cuboid([0.0, -0.4, 0.3], [0.8, 0.4, 1.0]));
    let needles = {
        // Slivers along the box's top edges, and one that sticks out into the room.
        let sliver = |a: DVec3, b: DVec3, off: DVec3| Shape(vec![a, b, (a + b) / 2.0 + off], vec![[0, 1, 2]]);
        let [a, b, c] = [DVec3::new(-0.5, -0.4, 1.1), DVec3::new(0.6, -0.4, 1.1), DVec3::new(0.6, 0.45, 1.1)];
        closed()
            .and(sliver(a, b, DVec3::Z * 1e-6))
            .and(sliver(b, c, DVec3::X * 1e-5))
            .and(sliver(a, DVec3::new(1.6, -0.9, 1.5), DVec3::Z * 1e-4))
            .and(sliver(c, DVec3::new(1.5, 1.2, 0.4), DVec3::Y * 1e-7))
    };
    let ball = {
        let (points, triangles) = sphere(3);
        Shape(points, triangles).flipped(|_| true).moved(|p| hover + p * 0.55)
    };
    let wardrobe = || vec![cuboid([-0.9, 1.9, 0.0], [0.9, 2.5, 2.1])];
    let rug = || sheet(DVec3::new(-1.0, -0.7, 0.0), DVec3::X * 2.0, DVec3::Y * 1.4, 3, 2);
    let fine = || patchwork(low, high, [1, 7, 3, 2, 5, 11]);
    vec![
        ("closed box", plain(vec![closed()])),
        ("closed box, turned", plain(vec![closed().turned(hover)])),
        ("box without a top", plain(vec![closed().without(|t| t / 2 == 1)])),
        ("box without a bottom", plain(vec![closed().without(|t| t / 2 == 0)])),
        ("box without a side, turned", plain(vec![closed().without(|t| t / 2 == 3).turned(hover)])),
        ("sheet", plain(vec![flat()])),
        ("sheet, turned", plain(vec![flat().turned(hover)])),
        ("three sheets at an edge", plain(vec![three_sheets])),
        ("two boxes that share a face", plain(vec![halves()])),
        ("the same, with one face for both", plain(vec![halves().without(|t| t == 10 || t == 11)])),
        ("a box listed twice", plain(vec![closed().and(closed())])),
        ("two boxes in one another", plain(vec![closed(), closed()])),
        ("overlapping boxes of one object", plain(vec![closed().and(cuboid([0.0, -0.1, 0.5], [0.9, 0.2, 1.4]))])),
        ("T-junctions", plain(vec![fine()])),
        ("T-junctions, turned", plain(vec![fine().turned(hover)])),
        ("T-junctions, turned, off by 1e-7", plain(vec![fine().turned(hover).loose(1e-7)])),
        ("T-junctions, a face missing, turned", plain(vec![fine().without(|t| t >= 178).turned(hover)])),
        ("some triangles flipped", plain(vec![closed().flipped(|t| t % 3 == 0)])),
        ("T-junctions, some triangles flipped", plain(vec![fine().turned(hover).flipped(|t| t % 5 == 0)])),
        ("box inside out", plain(vec![closed().flipped(|_| true)])),
        ("needles", plain(vec![needles])),
        ("coincident sheets", plain(vec![flat(), flat(), flat().flipped(|_| true)])),
        ("coincident sheets of one object", plain(vec![flat().and(flat()).and(flat().flipped(|_| true))])),
        ("coincident sheets, cut otherwise", plain(vec![flat().turned(hover), flatly_cut(flat()).turned(hover)])),
        ("vertices off by 1e-7", plain(vec![closed().loose(1e-7)])),
        ("ball", plain(vec![ball.clone()])),
        ("half a ball", plain(vec![ball.without(|t| t % 2 == 0 && t % 7 < 3 || t < 320)])),
        ("lampshade", plain(vec![shade(DVec3::new(0.3, 0.2, 0.9), 0.35, 0.15, 0.4, false)])),
        ("lampshade with a lid", plain(vec![shade(DVec3::new(0.3, 0.2, 0.9), 0.35, 0.15, 0.4, true)])),
        ("table", plain(table())),
        ("wardrobe at the wall", plain(wardrobe())),
        ("rug in the floor's plane", plain(vec![rug()])),
        ("rug and table", plain(table().into_iter().chain([rug()]).collect())),
        ("hidden box", room(&[closed(), table().remove(0).moved(|p| p + DVec3::new(0.9, 0.6, -0.3))], |b| hide(b, "thing 0"))),
        ("hidden sheet", room(&[flat(), closed().moved(|p| p + DVec3::new(0.8, 0.7, 0.2))], |b| hide(b, "thing 0"))),
        (
            "hidden box without a top",
            room(&[closed().without(|t| t / 2 == 1), flat().moved(|p| p - DVec3::Z * 0.6)], |b| hide(b, "thing 0")),
        ),
        (
            "hidden T-junctions, turned",
            room(&[fine().turned(hover), flat().moved(|p| p - DVec3::Z * 0.7)], |b| hide(b, "thing 0")),
        ),
        ("hidden room", room(&table(), |b| hide(b, "room"))),
        ("hidden wall", hidden_wall()),
        ("room outwards", room(&[closed()], |b| reshell(b, false, |s| s))),
        ("room of T-junctions", room(&[closed()], |b| reshell(b, true, |s| s))),
        ("room without a wall", room(&[closed()], |b| reshell(b, true, |s| s.without(|t| t >= 170)))),
    ]
}

/// A sheet cut along its other diagonal.
fn flatly_cut(sheet: Shape) -> Shape {
    Shape(sheet.0, vec![[0, 1, 2], [1, 3, 2]])
}

/// The room in another making.
fn reshell(mut builder: Builder, inwards: bool, change: impl Fn(Shape) -> Shape) -> Builder {
    builder.file.objects.retain(|o| o.name != "room");
    let shell = change(patchwork(ROOM[0], ROOM[1], [5, 2, 1, 3, 6, 4]));
    let Shape(positions, triangles) = shell.flipped(|_| inwards);
    builder.object("shell", 0.5, positions, triangles)
}

/// A room whose wall behind the cameras is a hidden sheet of its own, with a wardrobe against it.
fn hidden_wall() -> Arc<Scene> {
    let thing = cuboid([-0.9, -2.5, 0.0], [0.9, -1.9, 2.1]);
    room(&[thing], |builder| {
        let mut builder = builder;
        builder.file.objects.retain(|o| o.name != "room");
        let Shape(positions, triangles) = cuboid(ROOM[0], ROOM[1]).flipped(|_| true).without(|t| t / 2 == 2);
        let wall = sheet(DVec3::from(ROOM[0]), DVec3::X * 6.0, DVec3::Z * 2.8, 1, 1);
        let builder = builder.object("shell", 0.5, positions, triangles).object("wall", 0.5, wall.0, wall.1);
        hide(builder, "wall")
    })
}

/// Files of the corpus, and how long the longest side is to be, metres.
const FURNITURE: [(&str, f64); 24] = [
    ("kaykit_obj/bed_double_B.obj", 2.1),
    ("kaykit_obj/chair_C.obj", 0.9),
    ("kaykit_obj/lamp_standing.obj", 1.6),
    ("l3d_luminaires/example_002/head/head.obj", 0.6),
    ("l3d_luminaires/example_004/luminaire/luminaire.obj", 1.2),
    ("l3d_luminaires/example_006/head/head.obj", 0.7),
    ("sh3d_BlendSwap-CC-0/antiqueChair/antiqueChair.obj", 1.0),
    ("sh3d_BlendSwap-CC-0/armchair2/armchair2.obj", 1.0),
    ("sh3d_BlendSwap-CC-0/bookcase/bookcase.obj", 1.5),
    ("sh3d_BlendSwap-CC-0/couch2/couch2.obj", 2.3),
    ("sh3d_BlendSwap-CC-0/desklamp/desklamp.obj", 0.5),
    ("sh3d_BlendSwap-CC-0/largeFridge/largeFridge.obj", 1.8),
    ("sh3d_BlendSwap-CC-0/oakTable/oakTable.obj", 1.2),
    ("sh3d_BlendSwap-CC-0/pianoAQueue/pianoAQueue.obj", 1.5),
    ("sh3d_BlendSwap-CC-0/thonet/thonet.obj", 0.8),
    ("sh3d_BlendSwap-CC-BY/campingLamp/campingLamp.obj", 0.6),
    ("sh3d_BlendSwap-CC-BY/coffeeTable/coffeeTable.obj", 1.2),
    ("sh3d_BlendSwap-CC-BY/hangingLight/hangingLight.obj", 0.9),
    ("sh3d_BlendSwap-CC-BY/tvStand/tvStand.obj", 1.4),
    ("sh3d_BlendSwap-CC-BY/wardrobe2/wardrobe2.obj", 2.1),
    ("sh3d_KatorLegaz/full-bookcase/full-bookcase.obj", 2.0),
    ("sh3d_KatorLegaz/glass-dining-table/glass-dining-table.obj", 1.8),
    ("sh3d_KatorLegaz/hanging-restaurant-light/hanging-restaurant-light.obj", 0.9),
    ("sh3d_Scopia/turn-window/turn-window.obj", 1.0),
];

/// Other people's furniture, each piece standing in the middle of the room's floor.
pub fn furniture(corpus: &Path) -> impl Iterator<Item = (String, Arc<Scene>)> {
    FURNITURE.iter().map(move |(file, longest)| {
        let path = corpus.join("furniture").join(file);
        let (model, _) = read_obj(&path, Strictness::Import).unwrap();
        let Mesh { positions, triangles, .. } = Mesh::merged(model.parts.iter().map(|p| &p.mesh));
        // y is up there.
        let shape = Shape(positions, triangles).moved(|p| DVec3::new(p.x, -p.z, p.y));
        let [low, high] = extent(shape.0.iter().copied());
        let scale = longest / (high - low).max_element();
        let foot = ((low + high) / 2.0).with_z(low.z);
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        (name, room(&[shape.moved(|p| (p - foot) * scale)], |b| b))
    })
}
