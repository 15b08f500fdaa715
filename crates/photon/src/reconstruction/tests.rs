use super::*;
use crate::{
    accuracy::relative_errors,
    body::TreePreset,
    bucket::{Address, Bucket, ENERGY_BITS},
    field::Field,
    halton::Scrambling,
    path::FirstHits,
    pool::Pool,
    solution::Solution,
    world::World,
};
use lightmend_scene::{Lattice, Object, Scene};
use std::{path::Path, sync::Arc};

/// A mesh alone in the Cornell box's scene, and its cells' light from the only lamp.
struct Lit {
    lattice: Arc<Lattice>,
    points: LatticePoints,
    configuration: Configuration,
    shapes: Shapes,
    buckets: Buckets,
    scale: Scale,
}

impl Lit {
    fn new(mesh: Mesh, cell: f64) -> Lit {
        let cornell = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cornell/cornell.ron");
        let mut scene = Arc::into_inner(Scene::read(&cornell).unwrap().0).unwrap();
        let lattice = Arc::new(Lattice::new(&mesh, cell).unwrap());
        let points = LatticePoints::new(&mesh, &lattice);
        let shape = Object { mesh: Arc::new(mesh), lattice: lattice.clone(), ..(*scene.objects[0]).clone() };
        scene.objects = vec![Arc::new(shape)];
        let configuration = Configuration::initial(&Arc::new(scene));
        let buckets = Buckets::new(&configuration);
        // A large pool, so that rounding to whole units of energy does not matter.
        let scale = Scale::new(&World::new(&configuration, TreePreset::Fast), 1 << 30);
        let shapes = Shapes::of(&configuration);
        Lit { lattice, points, configuration, shapes, buckets, scale }
    }

    /// Gives the front of a cell an irradiance, lux, by so many hits that none of it is chance.
    fn light(&mut self, cell: u32, lux: [f64; 3]) {
        let units = DVec3::from_array(lux) * self.lattice.area(cell) / self.scale.lumens(0);
        self.hit(cell, lux, (units.max_element() / f64::from(1 << 10)) as i64 + 1);
    }

    /// The same by this number of hits.
    fn hit(&mut self, cell: u32, lux: [f64; 3], hits: i64) {
        let units = DVec3::from_array(lux) * self.lattice.area(cell) / self.scale.lumens(0);
        let to = Address { object: 0, cell, side: 0, lamp: 0 };
        self.buckets.set(to, Bucket { energy: units.to_array().map(|e| e.round() as i64), hits });
    }

    fn side(&self, side: usize) -> Option<Vec<[f32; 3]>> {
        Reconstruction::new(&self.shapes, &self.configuration, &self.buckets, &self.scale, 1).vertices(0, side)
    }

    /// Irradiance of the front's points.
    fn front(&self) -> Vec<[f32; 3]> {
        self.side(0).unwrap()
    }

    /// Whether any of the points of triangle `t` is lit.
    fn reaches(&self, t: usize) -> bool {
        let front = self.front();
        self.points.points_of(t).any(|p| front[p as usize] != [0.0; 3])
    }
}

fn mesh(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    let material_of = vec![0; triangles.len()];
    Mesh { positions, triangles, material_of, materials: vec!["m".into()], uvs: vec![] }
}

/// A box of `size` metres with one corner at the origin; faces −x, +x, −y, +y, −z, +z, two triangles each.
fn cuboid(size: DVec3) -> Mesh {
    let corners = (0..8).map(|c| DVec3::new((c & 1) as f64, (c >> 1 & 1) as f64, (c >> 2) as f64) * size);
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    mesh(corners.collect(), faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

/// Two unit squares with a common edge, bent by `degrees` out of one plane, two triangles each.
fn bend(degrees: f64) -> Mesh {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let xz = [(-1.0, 0.0), (0.0, 0.0), (cos, sin)];
    let positions = [0.0, 1.0].into_iter().flat_map(|y| xz.map(|(x, z)| DVec3::new(x, y, z))).collect();
    mesh(positions, vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
}

/// Interpolated light of the front, integrated over the cells, lumens.
fn flux(lit: &Lit) -> DVec3 {
    let front = lit.front();
    let at = |p: u32| DVec3::from_array(front[p as usize].map(f64::from));
    let triangle = |t: usize| {
        lit.points.cells_points(t).map(|p| p.map(at).into_iter().sum::<DVec3>()).sum::<DVec3>() * lit.lattice.area_in(t) / 3.0
    };
    (0..lit.points.triangles()).map(triangle).sum()
}

fn close(a: DVec3, b: DVec3, relative: f64) -> bool {
    (a - b).abs().max_element() <= relative * b.max_element()
}

const LUX: [f64; 3] = [300.0, 200.0, 100.0];

#[test]
fn what_is_the_same_everywhere_stays_so() {
    let slivers = mesh(
        vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1e-4, 0.0), DVec3::new(0.3, 2e-4, 0.0), DVec3::X * 0.5],
        vec![[0, 1, 2], [0, 2, 3], [0, 4, 1]], // the last has no area
    );
    for (mesh, cell) in [
        (cuboid(DVec3::ONE), 3.0),
        (cuboid(DVec3::ONE), 0.05),
        (cuboid(DVec3::new(2.0, 1e-3, 0.7)), 0.04),
        (slivers.clone(), 3.0),
        (slivers, 0.03),
    ] {
        let mut lit = Lit::new(mesh, cell);
        (0..lit.lattice.cells()).for_each(|cell| lit.light(cell, LUX));
        let front = lit.front();
        assert_eq!(front.len(), lit.points.count() as usize);
        for t in 0..lit.points.triangles() {
            let expected = if lit.lattice.area_in(t) > 0.0 { DVec3::from_array(LUX) } else { DVec3::ZERO };
            for p in lit.points.points_of(t) {
                let found = DVec3::from_array(front[p as usize].map(f64::from));
                // Single precision, and whole units of energy in the smallest cells.
                assert!(close(found, expected, 1e-6), "{found} at point {p}, cells of {cell} m");
            }
        }
    }
}

#[test]
fn light_does_not_leak_over_the_edges_of_a_box() {
    let mut lit = Lit::new(cuboid(DVec3::ONE), 0.1);
    for cell in [10, 11].into_iter().flat_map(|t| lit.lattice.cells_of(t)).collect::<Vec<_>>() {
        lit.light(cell, LUX);
    }
    assert!((0..10).all(|t| !lit.reaches(t)));
    let front = lit.front();
    for p in lit.points.first(10)..lit.points.count() {
        let found = DVec3::from_array(front[p as usize].map(f64::from));
        assert!(close(found, DVec3::from_array(LUX), 1e-6), "up to the edges: {found}");
    }
}

#[test]
fn a_shallow_bend_shares_its_light_and_a_crease_does_not() {
    for (degrees, shares) in [(0.0, true), (20.0, true), (-20.0, true), (40.0, false), (-40.0, false)] {
        let mut lit = Lit::new(bend(degrees), 0.1);
        for cell in [0, 1].into_iter().flat_map(|t| lit.lattice.cells_of(t)).collect::<Vec<_>>() {
            lit.light(cell, LUX);
        }
        assert_eq!(lit.reaches(3), shares, "{degrees}°");
        // Amid the common edge three cells of each square meet: half of the light.
        let n = lit.lattice.divisions(0);
        let amid = lit.points.first(0) + LatticePoints::index(n, n / 2, n - n / 2);
        let half = if shares { 0.5 } else { 1.0 };
        let found = DVec3::from_array(lit.front()[amid as usize].map(f64::from));
        assert!(close(found, DVec3::from_array(LUX) * half, 1e-6), "{degrees}°: {found}");
    }
}

#[test]
fn interpolation_keeps_the_flux() {
    let square = mesh(vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y], vec![[0, 1, 2], [0, 2, 3]]);
    // One cell amid a square, then light from cell to cell as it comes, also up to edges, creases and unequal neighbours.
    for (mesh, cell, everywhere) in
        [(square, 0.03, false), (bend(20.0), 0.1, true), (cuboid(DVec3::new(2.0, 0.01, 0.7)), 0.2, true)]
    {
        let mut lit = Lit::new(mesh, cell);
        let mut sum = DVec3::ZERO;
        for cell in 0..lit.lattice.cells() {
            let part = if everywhere { f64::from(cell * 7919 % 101) / 100.0 } else { f64::from(u8::from(cell == 700)) };
            lit.light(cell, LUX.map(|lux| lux * part));
            sum += DVec3::from_array(LUX) * part * lit.lattice.area(cell);
        }
        let found = flux(&lit);
        assert!(sum.min_element() > 0.0 && close(found, sum, 1e-6), "{found} of {sum}");
    }
}

/// Root mean square deviation from 1 of a square's points, lit by `mean` hits a cell on average, as chance (here a hash) has it.
fn noise(mean: f64) -> (f64, Lit) {
    let square = mesh(vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y], vec![[0, 1, 2], [0, 2, 3]]);
    let mut lit = Lit::new(square, 0.03);
    for cell in 0..lit.lattice.cells() {
        // The sum of twelve uniform numbers is nearly normal.
        let uniform = |k: u64| f64::from((crate::hash::mix(u64::from(cell) * 12 + k) >> 32) as u32) / f64::from(u32::MAX);
        let normal = (0..12).map(uniform).sum::<f64>() - 6.0;
        let hits = (mean + normal * mean.sqrt()).round().max(0.0);
        lit.hit(cell, [hits / mean; 3], hits as i64);
    }
    let front = lit.front();
    let square = |e: &[f32; 3]| f64::from(e[0] - 1.0) * f64::from(e[0] - 1.0);
    ((front.iter().map(square).sum::<f64>() / front.len() as f64).sqrt(), lit)
}

#[test]
fn noise_is_calmed_and_large_pools_are_left_alone() {
    // A point has six cells around it.
    let raw = |mean: f64| 1.0 / (6.0 * mean).sqrt();
    let (few, lit) = noise(4.0);
    assert!(few < 0.5 * raw(4.0), "{few} of {}", raw(4.0));
    let (many, _) = noise(4000.0);
    assert!((0.9..1.1).contains(&(many / raw(4000.0))), "{many} of {}", raw(4000.0));
    // None is lost.
    let (kept, sum) =
        (flux(&lit), lit.buckets.lit().map(|(_, bucket)| bucket.energy[0] as f64).sum::<f64>() * lit.scale.lumens(0).x);
    assert!((kept.x / sum - 1.0).abs() < 1e-6);
}

#[test]
fn a_significant_edge_stays_sharp() {
    // A shadow's edge through the middle of a square, at the corner between two rows of cells, 100 hits a cell against 10.
    let mut lit = Lit::new(bend(0.0), 0.05);
    for t in 0..4 {
        for cell in lit.lattice.cells_of(t) {
            let (lux, hits) = if t < 2 { (1.0, 100) } else { (0.1, 10) };
            lit.hit(cell, [lux; 3], hits);
        }
    }
    let front = lit.front();
    let n = lit.lattice.divisions(0);
    // Two rows away from the edge on either side.
    let at = |t: usize, i: u32, j: u32| front[(lit.points.first(t) + LatticePoints::index(n, i, j)) as usize][0];
    let (bright, dark) = (at(0, n / 2, n / 2 - 3), at(2, n / 2, n / 2 - 3));
    assert!((bright - 1.0).abs() < 0.1 && (dark - 0.1).abs() < 0.1, "{bright} {dark}");
}

#[test]
fn a_side_that_no_light_reached_has_none() {
    let mut lit = Lit::new(cuboid(DVec3::ONE), 0.5);
    assert_eq!((lit.side(0), lit.side(1)), (None, None));
    lit.light(3, LUX);
    assert!(lit.side(0).is_some());
    assert_eq!(lit.side(1), None);
}

#[test]
fn a_point_has_the_flux_around_it_over_the_area() {
    // One triangle, one cell, one whole unit of energy a channel.
    let mut lit = Lit::new(mesh(vec![DVec3::ZERO, DVec3::X * 2.0, DVec3::Y], vec![[0, 1, 2]]), 9.0);
    let to = Address { object: 0, cell: 0, side: 0, lamp: 0 };
    lit.buckets.set(to, Bucket { energy: [1 << ENERGY_BITS; 3], hits: 1 });
    let irradiance = lit.scale.irradiance(&lit.buckets, 0, 0, 0, 1.0);
    assert_eq!(lit.front(), [irradiance.value.as_vec3().to_array(); 3], "the triangle has 1 m²");
}

#[test]
fn the_stated_median_error_is_the_true_one() {
    let room = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/room/room.ron");
    let world = Arc::new(World::new(&Configuration::initial(&Scene::read(&room).unwrap().0), TreePreset::default()));
    let shapes = Shapes::of(world.configuration());
    let shoot = |photons, seed| {
        let pool = Pool::new(photons, 288, 16, Scrambling::Seed(seed)).unwrap();
        let solution = Solution::shoot(pool, world.clone(), FirstHits::Never, &mut |_, _| true).unwrap();
        (solution.buckets().clone(), Scale::new(&world, photons))
    };
    let (exact, exact_scale) = shoot(8_000_000, 2);
    let reference = Field::raw(&world, &exact, &exact_scale);
    for photons in [100_000, 400_000] {
        let (buckets, scale) = shoot(photons, 1);
        let light = Reconstruction::new(&shapes, world.configuration(), &buckets, &scale, world.configuration().lamp_slots());
        let field = Field::reconstructed(&world, &light);
        let [measured] = relative_errors(&field, &reference, [0.5]);
        let stated = light.median_error();
        println!("{photons} photons: stated {stated:.4}, measured {measured:.4}");
        // 8 million photons err by some 1.2 % themselves.
        let both = stated.hypot(0.012);
        assert!((both / measured - 1.0).abs() < 0.15, "{photons} photons: stated {stated}, measured {measured}");
    }
}
