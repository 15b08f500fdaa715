//! The whole solver against closed forms.

use glam::DVec3;
use lightmend_photon::{
    gather::Gather,
    irradiance::Scale,
    path::FirstHits,
    probe,
    reconstruction::{Reconstruction, Shapes},
};
use lightmend_scene::Configuration;
use lightmend_tests::{Builder, count, pool, shoot, sphere, world};

/// Area-weighted mean direct and indirect irradiance of a sphere, and the photon hits of every element.
struct Sphere {
    direct: f64,
    indirect: f64,
    direct_hits: Vec<f64>,
    indirect_hits: Vec<f64>,
    areas: Vec<f64>,
}

fn solve_sphere(reflectance: f64, lamp: [f64; 3], photons: u64) -> Sphere {
    let (points, triangles) = sphere(5);
    assert!(triangles.len() >= 20_000);
    let scene = Builder::default().object("sphere", reflectance, points, triangles).lamp(lamp, 100.0).build(&[]);
    let world = world(&scene);
    let solve = |first_hits| {
        let solution = shoot(pool(photons), &world, first_hits);
        let scale = Scale::new(&world, photons);
        let lattice = &scene.objects[0].lattice;
        let mut lumens = 0.0;
        let mut hits = Vec::new();
        for cell in 0..lattice.cells() {
            let area = lattice.area(cell);
            let irradiance = scale.irradiance(solution.buckets(), 0, cell, 0, area);
            lumens += irradiance.value.x * area;
            hits.push(irradiance.hits as f64);
        }
        assert!(solution.buckets().get(0, 1, 0).is_none(), "no light behind the sphere");
        assert_eq!(solution.tallies()[0].escaped + solution.tallies()[0].cut, 0);
        (lumens, hits)
    };
    let (all, all_hits) = solve(FirstHits::Always);
    let (indirect, indirect_hits) = solve(FirstHits::Never);
    let areas: Vec<f64> = (0..scene.objects[0].lattice.cells()).map(|c| scene.objects[0].lattice.area(c)).collect();
    let total: f64 = areas.iter().sum();
    let direct_hits = all_hits.iter().zip(&indirect_hits).map(|(a, i)| a - i).collect();
    Sphere { direct: (all - indirect) / total, indirect: indirect / total, direct_hits, indirect_hits, areas }
}

/// Pearson's statistic of hits against their share by area, as standard deviations above its mean (Wilson and Hilferty 1931).
fn chi_squared_deviation(hits: &[f64], areas: &[f64]) -> f64 {
    let (total, area): (f64, f64) = (hits.iter().sum(), areas.iter().sum());
    let statistic: f64 = hits
        .iter()
        .zip(areas)
        .map(|(h, a)| {
            let e = total * a / area;
            (h - e) * (h - e) / e
        })
        .sum();
    let freedom = hits.len() as f64 - 1.0;
    let spread = 2.0 / (9.0 * freedom);
    ((statistic / freedom).cbrt() - (1.0 - spread)) / spread.sqrt()
}

#[test]
fn a_sphere_multiplies_light_by_its_reflectance_series() {
    // In any closed scene of one reflectance ρ: mean indirect / mean direct = ρ / (1 − ρ). Paths are cut after 65,536 hits:
    // at ρ = 0.8 the bias of that is below 10⁻⁶³⁰⁰.
    for reflectance in [0.2, 0.5, 0.8] {
        for lamp in [[0.0, 0.0, 0.0], [0.5, 0.2, -0.3]] {
            let sphere = solve_sphere(reflectance, lamp, count(2_000_000, 20_000_000));
            let ratio = sphere.indirect / sphere.direct;
            let expected = reflectance / (1.0 - reflectance);
            println!("reflectance {reflectance}, lamp {lamp:?}: indirect / direct {ratio:.6}, closed form {expected:.6}");
            assert!((ratio / expected - 1.0).abs() < 0.003, "reflectance {reflectance}, lamp {lamp:?}: {ratio} for {expected}");
        }
    }
}

#[test]
fn indirect_light_in_a_sphere_is_uniform() {
    // Wherever the lamp is, every point of a sphere sees every other with the same form factor.
    let sphere = solve_sphere(0.5, [0.5, 0.2, -0.3], count(2_000_000, 4_000_000));
    let indirect = chi_squared_deviation(&sphere.indirect_hits, &sphere.areas);
    let direct = chi_squared_deviation(&sphere.direct_hits, &sphere.areas);
    println!("χ² over {} elements, in standard deviations: indirect {indirect:.2}, direct {direct:.0}", sphere.areas.len());
    assert!(indirect < 3.09, "one-sided p > 0.001: {indirect}");
    assert!(direct > 100.0, "direct light of a lamp off the centre is not uniform: {direct}");
}

/// A photometric file that shines 10,000 cd within half a degree of its axis.
const BEAM: &str = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 3 1 1 2 0 0 0\n1 1 10\n0 0.25 0.5\n0\n10000 10000 0\n";

#[test]
fn a_beam_on_a_plate_lights_the_plate_above_it() {
    // Irradiance ρ Φ cos θ₁ cos θ₂ / (π r²) of a point source of Lambertian light (the lit spot).
    let (reflectance, distance, photons) = (0.7, 0.8, count(2_000_000, 20_000_000));
    let mut builder = Builder::default()
        .rectangle("lit", reflectance, [-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0])
        .rectangle("plate", 0.0, [-0.6, -0.9, distance], [0.0, 1.8, 0.0], [1.2, 0.0, 0.0])
        .lamp([0.0, 0.0, 0.3], 1.0);
    builder.file.cell = 0.25;
    builder.file.lamps[0].photometry = Some("beam.ies".into());
    let scene = builder.build(&[("beam.ies", BEAM)]);
    let flux = scene.lamps[0].flux().x;
    let world = world(&scene);
    let solution = shoot(pool(photons), &world, FirstHits::AsLampsSay);
    let scale = Scale::new(&world, photons);
    let plate = Configuration::initial(&scene).object_id("plate").unwrap();
    let (mesh, lattice) = (&scene.objects[plate].mesh, &scene.objects[plate].lattice);
    let mut total = (0.0, 0.0);
    let mut worst: f64 = 0.0;
    for t in 0..mesh.triangles.len() {
        for cell in lattice.cells_of(t) {
            let area = lattice.area(cell);
            let expected = mean_over_cell(&mesh.corners(t), lattice.divisions(t), cell - lattice.cells_of(t).start, |p| {
                let squared = p.length_squared();
                let cosine = p.z / squared.sqrt(); // of both angles: the plates are parallel
                reflectance * flux * cosine * cosine / (std::f64::consts::PI * squared)
            });
            let got = scale.irradiance(solution.buckets(), plate, cell, 0, area);
            let standard_error = expected / (expected * area / flux * photons as f64).sqrt();
            worst = worst.max(((got.value.x - expected) / standard_error).abs());
            total = (total.0 + got.value.x * area, total.1 + expected * area);
        }
    }
    let standard_error = total.1 / (total.1 / flux * photons as f64).sqrt();
    // The rectangle's form factor from the spot (Howell's catalogue, B-3: parallel, over a corner), four times.
    let (x, y): (f64, f64) = (0.6 / distance, 0.9 / distance);
    let (a, b) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    let quarter = (x / a * (y / a).atan() + y / b * (x / b).atan()) / (2.0 * std::f64::consts::PI);
    let closed = reflectance * flux * 4.0 * quarter;
    println!("{} cells, worst {worst:.2} standard errors; total {:.5} lm, closed form {closed:.5} lm", lattice.cells(), total.0);
    assert!((total.1 / closed - 1.0).abs() < 1e-4, "the test's own integral: {} for {closed}", total.1);
    assert!(worst < 4.0 && (total.0 - closed).abs() < 4.0 * standard_error, "worst {worst}, total {} for {closed}", total.0);
}

/// The mean of `f` over a cell of the barycentric lattice, by midpoints of a fine sublattice.
fn mean_over_cell(corners: &[DVec3; 3], divisions: u32, local: u32, f: impl Fn(DVec3) -> f64) -> f64 {
    let mut row = 0;
    while (row + 1) * (2 * divisions - row - 1) <= local {
        row += 1;
    }
    let place = local - row * (2 * divisions - row);
    let (column, inverted) = (place / 2, place % 2 == 1);
    let fine = 12;
    let mut sum = 0.0;
    for i in 0..fine {
        for j in 0..fine - i {
            for (third, exists) in [(1.0, true), (2.0, i + j + 1 < fine)] {
                if exists {
                    let (mut u, mut v) =
                        ((f64::from(i) + third / 3.0) / f64::from(fine), (f64::from(j) + third / 3.0) / f64::from(fine));
                    if inverted {
                        (u, v) = (1.0 - u, 1.0 - v);
                    }
                    let (b1, b2) = ((f64::from(row) + u) / f64::from(divisions), (f64::from(column) + v) / f64::from(divisions));
                    sum += f(corners[0] * (1.0 - b1 - b2) + corners[1] * b1 + corners[2] * b2);
                }
            }
        }
    }
    sum / f64::from(fine * fine)
}

#[test]
fn photons_leave_a_lamp_as_its_photometric_file_says() {
    // A black sphere about a lamp that is turned and tilted: its elements receive what the file shines towards them.
    let folder = lightmend_tests::own_scene_path("room").with_file_name("ies");
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= 4, "the room has four lamps with diagrams");
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        let (points, triangles) = sphere(5);
        let mut builder = Builder::default().object("sphere", 0.0, points, triangles).lamp([0.0; 3], 1.0);
        builder.file.lamps[0].photometry = Some("lamp.ies".into());
        builder.file.lamps[0].rotation = DVec3::new(20.0, -35.0, 110.0);
        let scene = builder.build(&[("lamp.ies", &text)]);
        let photons = count(1_000_000, 10_000_000);
        let world = world(&scene);
        let solution = shoot(pool(photons), &world, FirstHits::Always);
        let scale = Scale::new(&world, photons);
        let lamp = &scene.lamps[0];
        let to_lamp_axes = world.lamps()[0].rotation.transpose();
        let (mesh, lattice) = (&scene.objects[0].mesh, &scene.objects[0].lattice);
        // Zones of 15° in γ and 45° in C: lumens from photons and from the file's candela.
        let mut zones = vec![(0.0, 0.0); 12 * 8];
        for t in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(t);
            let middle = to_lamp_axes * ((a + b + c) / 3.0).normalize();
            let gamma = (-middle.z).clamp(-1.0, 1.0).acos().to_degrees();
            let azimuth = middle.y.atan2(middle.x).to_degrees().rem_euclid(360.0);
            let zone = &mut zones[(gamma / 15.0) as usize % 12 * 8 + (azimuth / 45.0) as usize % 8];
            let area = lattice.area_in(t);
            zone.0 += scale.irradiance(solution.buckets(), 0, lattice.cells_of(t).start, 0, area).value.x * area;
            // Mean candela over the triangle's solid angle (Van Oosterom and Strackee 1983), at four points.
            let solid = 2.0 * a.dot(b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a));
            let inner = [(a + b + c) / 3.0, (4.0 * a + b + c) / 6.0, (a + 4.0 * b + c) / 6.0, (a + b + 4.0 * c) / 6.0];
            zone.1 += inner.iter().map(|p| lamp.candela(to_lamp_axes * *p).x).sum::<f64>() / 4.0 * solid;
        }
        let flux = lamp.flux().x;
        let (from_photons, from_file) = zones.iter().fold((0.0, 0.0), |s, z| (s.0 + z.0, s.1 + z.1));
        println!(
            "{}: {flux:.2} lm, photons {from_photons:.2}, zones {from_file:.2}",
            file.file_name().unwrap().to_string_lossy()
        );
        assert!((from_photons / flux - 1.0).abs() < 0.005 && (from_file / flux - 1.0).abs() < 0.005);
        for (got, expected) in zones.into_iter().filter(|z| z.1 > 0.01 * flux) {
            let standard_error = (expected * flux / photons as f64).sqrt();
            assert!((got - expected).abs() < 4.0 * standard_error + 1e-3 * expected, "{}: {got} for {expected}", file.display());
        }
    }
}

#[test]
fn coincident_surfaces_share_the_light_of_their_place() {
    // Regression: where two walls lie in one another, rounding decides which one a photon meets; a ray that read only the one it
    // found would see a floor too dark. The second floor is the first one cut along the other diagonal.
    let corner = |x: f64, y: f64| DVec3::new(x, y, 0.37);
    let points = vec![corner(0.0, 0.0), corner(1.9, 0.1), corner(2.0, 2.1), corner(-0.1, 2.0)];
    let floor = |b: Builder, name: &str, triangles| b.object(name, 0.5, points.clone(), triangles);
    let walls = Builder::default().cuboid("room", 0.5, [-1.0, -1.0, 0.0], [3.0, 3.0, 2.0], true).lamp([1.0, 1.0, 1.5], 100.0);
    let single = floor(walls, "floor", vec![[0, 1, 2], [0, 2, 3]]);
    let walls = Builder::default().cuboid("room", 0.5, [-1.0, -1.0, 0.0], [3.0, 3.0, 2.0], true).lamp([1.0, 1.0, 1.5], 100.0);
    let double = floor(floor(walls, "floor", vec![[0, 1, 2], [0, 2, 3]]), "twin", vec![[1, 2, 3], [1, 3, 0]]);
    let photons = 1_000_000;
    let read = |builder: Builder| {
        let scene = builder.build(&[]);
        let world = world(&scene);
        let solution = shoot(pool(photons), &world, FirstHits::Never);
        let (shapes, scale) = (Shapes::of(world.configuration()), Scale::new(&world, photons));
        let light = Reconstruction::new(&shapes, world.configuration(), solution.buckets(), &scale, 1);
        let gather = Gather { world: &world, light: &light, buckets: solution.buckets(), scale: &scale, rays: 4096 };
        // The ceiling sees the floor: points above each of the four triangles that both cuts make.
        [(1.0, 0.5), (1.5, 1.0), (1.0, 1.6), (0.4, 1.0)]
            .map(|(x, y)| probe::locate(&world, DVec3::new(x, y, 2.0), DVec3::NEG_Z).unwrap())
            .map(|place| gather.at(&place, 0).value.x)
            .iter()
            .sum::<f64>()
    };
    let (one, two) = (read(single), read(double));
    assert!((two / one - 1.0).abs() < 0.01, "one floor {one}, two in one another {two}");
}
