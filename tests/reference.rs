//! Path-traced irradiance against closed forms: what the photons are held against must be right by itself.

use glam::{DVec2, DVec3};
use lightmend_photon::{
    reference::{Estimate, PathTracer, Plan},
    world::World,
};
use lightmend_tests::{Builder, count, sphere, world};
use std::sync::atomic::{AtomicU64, Ordering};

fn trace(world: &World, points: &[(DVec3, DVec3)], plan: Plan) -> Vec<Estimate> {
    let mut reference = PathTracer::new(world, points.to_vec(), plan);
    while reference.paths_ahead() > 0 {
        reference.round(&|_| true);
    }
    reference.estimates().to_vec()
}

/// Deviations from `expected` in standard errors, red channel.
fn deviations(estimates: &[Estimate], expected: f64) -> Vec<f64> {
    estimates.iter().map(|e| (e.value().x - expected) / e.standard_error().x).collect()
}

/// Middles of some of the triangles of a unit sphere that is seen from inside.
fn points_inside(points: &[DVec3], triangles: &[[u32; 3]], some: usize) -> Vec<(DVec3, DVec3)> {
    let middle = |t: &[u32; 3]| t.iter().map(|i| points[*i as usize]).sum::<DVec3>() / 3.0;
    triangles.iter().step_by(triangles.len() / some).map(|t| (middle(t), -middle(t).normalize())).collect()
}

#[test]
fn a_sphere_is_lit_evenly_by_its_reflectance_series() {
    // Φ / A · ρ / (1 − ρ) at every point, wherever the lamp is and however it shines; the triangles take 0.05 % off.
    let diagram =
        std::fs::read_to_string(lightmend_tests::own_scene_path("room").with_file_name("ies").join("pendant.ies")).unwrap();
    let mut all = Vec::new();
    for reflectance in [0.2, 0.5, 0.8] {
        for (lamp, file) in [([0.0, 0.0, 0.0], None), ([0.5, 0.2, -0.3], None), ([0.5, 0.2, -0.3], Some("lamp.ies"))] {
            let (points, triangles) = sphere(5);
            let inside = points_inside(&points, &triangles, 20);
            let mut builder = Builder::default().object("sphere", reflectance, points, triangles).lamp(lamp, 100.0);
            builder.file.lamps[0].photometry = file.map(str::to_owned);
            builder.file.lamps[0].rotation = DVec3::new(20.0, -35.0, 110.0);
            let scene = builder.build(&[("lamp.ies", &diagram)]);
            let area: f64 = (0..scene.objects[0].mesh.triangles.len()).map(|t| scene.objects[0].lattice.area_in(t)).sum();
            let expected = scene.lamps[0].flux().x / area * reflectance / (1.0 - reflectance);
            let estimates = trace(&world(&scene), &inside, Plan::of_paths(count(2048, 262_144), 1));
            let mean = estimates.iter().map(|e| e.value().x).sum::<f64>() / estimates.len() as f64;
            let noise = estimates.iter().map(|e| e.standard_error().x.powi(2)).sum::<f64>().sqrt() / estimates.len() as f64;
            println!("ρ {reflectance}, lamp {lamp:?} {file:?}: {mean:.3} ± {noise:.3}, closed form {expected:.3}");
            assert!((mean - expected).abs() < 3.0 * noise + 5e-4 * expected, "{mean} ± {noise} for {expected}");
            all.extend(deviations(&estimates, expected));
        }
    }
    // The standard errors are right: with 32 batches or more each deviation follows Student's t, whose variance is 1.07 or less.
    let rms = (all.iter().map(|d| d * d).sum::<f64>() / all.len() as f64).sqrt();
    let worst = all.iter().fold(0.0f64, |worst, d| worst.max(d.abs()));
    println!("{} points: RMS deviation {rms:.3} standard errors, worst {worst:.2}", all.len());
    assert!((0.88..1.16).contains(&rms) && worst < 4.5, "RMS {rms}, worst {worst}");
}

/// A lamp of 100 cd one metre above a wide floor, and a small black plate just above the lamp, looking down.
fn lamp_above_floor(reflectance: f64, front_up: bool) -> Builder {
    let (u, v) = ([80.0, 0.0, 0.0], [0.0, 80.0, 0.0]);
    let (u, v) = if front_up { (u, v) } else { (v, u) };
    Builder::default()
        .rectangle("plate", 0.0, [-0.1, -0.1, 1.0005], [0.0, 0.2, 0.0], [0.2, 0.0, 0.0])
        .rectangle("floor", reflectance, [-40.0, -40.0, 0.0], u, v)
        .lamp([0.0, 0.0, 1.0], 100.0)
}

#[test]
fn one_bounce_off_a_floor() {
    // Over the floor: ρ/π · I h / (h² + r²)^(3/2) · h² / (h² + r²)² · 2π r dr, from 0 to ∞: 2 ρ I / (5 h²). The plate's 0.5 mm and
    // the floor's edge take less than 0.1 % off.
    let texture = tempfile::tempdir().unwrap();
    let picture = texture.path().join("halves.png");
    // sRGB 188 is 0.5028 in linear light; between the two texels reflectance is linear, so opposite points add up to their sum.
    image::RgbImage::from_fn(2, 1, |x, _| image::Rgb([if x == 0 { 255 } else { 188 }; 3])).save(&picture).unwrap();
    let corner = |x: f64, y: f64| DVec2::new(x, y);
    let uvs =
        vec![[corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0)], [corner(0.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)]];
    for (what, builder, reflectance) in [
        ("front", lamp_above_floor(0.7, true), 0.7),
        ("back", lamp_above_floor(0.7, false), 0.7),
        ("texture", lamp_above_floor(0.7, true).texture(&picture, uvs), 0.7 * (1.0 + 0.502_886) / 2.0),
    ] {
        let scene = builder.build(&[]);
        let plan = Plan::of_paths(count(65_536, 4_194_304), 1);
        let estimate = trace(&world(&scene), &[(DVec3::new(0.0, 0.0, 1.0005), DVec3::NEG_Z)], plan)[0];
        let expected = 2.0 * reflectance * 100.0 / 5.0;
        let (value, noise) = (estimate.value().x, estimate.standard_error().x);
        println!("{what}: {value:.4} ± {noise:.4}, closed form {expected:.4}");
        assert!(noise < 2e-3 * expected && (value - expected).abs() < 4.0 * noise + 1e-3 * expected, "{what}: {value} ± {noise}");
    }
}

#[test]
fn black_surfaces_and_empty_space_bring_nothing() {
    let scene = lamp_above_floor(0.0, true).build(&[]);
    let down = (DVec3::new(0.0, 0.0, 1.0005), DVec3::NEG_Z);
    let up = (DVec3::new(0.0, 0.0, 1.0005), DVec3::Z);
    for estimate in trace(&world(&scene), &[down, up], Plan::of_paths(1024, 1)) {
        assert_eq!((estimate.value(), estimate.standard_error(), estimate.relative_error()), (DVec3::ZERO, DVec3::ZERO, 0.0));
    }
}

#[test]
fn a_closed_room_that_absorbs_nothing_ends() {
    let room = Builder::default().cuboid("room", 1.0, [0.0; 3], [3.0, 4.0, 2.5], true).lamp([1.0, 1.0, 1.5], 100.0).build(&[]);
    let estimate = trace(&world(&room), &[(DVec3::new(2.0, 2.0, 0.0), DVec3::Z)], Plan::of_paths(32, 1))[0];
    assert!(estimate.value().is_finite() && estimate.value().x > 0.0);
}

/// A room whose left half is lit and three of its points, one of them dark and noisy.
fn room() -> (std::sync::Arc<lightmend_scene::Scene>, Vec<(DVec3, DVec3)>) {
    let scene = Builder::default()
        .cuboid("room", 0.6, [0.0; 3], [4.0, 3.0, 2.5], true)
        .cuboid("screen", 0.3, [1.9, 0.0, 0.0], [2.0, 2.5, 2.5], false)
        .lamp([0.7, 1.0, 1.5], 100.0)
        .build(&[]);
    let point = |x, y| (DVec3::new(x, y, 0.0), DVec3::Z);
    (scene, vec![point(0.5, 0.5), point(1.5, 2.0), point(3.8, 0.2)])
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let (scene, points) = room();
    let world = world(&scene);
    for plan in [Plan::of_paths(2000, 7), Plan::to_error(0.02, 30_000, 7)] {
        let with = |threads| {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| trace(&world, &points, plan))
        };
        let one = with(1);
        assert!(one == with(3) && one == with(8));
        let other = trace(&world, &points, Plan { seed: 8, ..plan });
        assert!(one.iter().zip(&other).all(|(a, b)| a.value() != b.value()), "another seed, another estimate");
    }
}

#[test]
fn paths_go_where_the_error_is() {
    let (scene, points) = room();
    let estimates = trace(&world(&scene), &points, Plan::to_error(0.02, 1 << 22, 1));
    assert!(estimates.iter().all(|e| e.relative_error() <= 0.02), "{estimates:?}");
    assert!(estimates[2].batches() > 4 * estimates[0].batches(), "the dark corner is noisier: {estimates:?}");
    let capped = trace(&world(&scene), &points, Plan::to_error(1e-4, 20_000, 1));
    assert!(capped.iter().all(|e| e.batches() == 20_000u32.div_ceil(256)), "{capped:?}");
}

#[test]
fn what_is_finished_is_kept() {
    let (scene, points) = room();
    let world = world(&scene);
    let plan = Plan::of_paths(32 * 1024, 1);
    let mut reference = PathTracer::new(&world, points.clone(), plan);
    let told = AtomicU64::new(0);
    reference.round(&|paths| told.fetch_add(paths, Ordering::Relaxed) + paths < 40 * 1024);
    let kept: u64 = reference.estimates().iter().map(|e| u64::from(e.batches())).sum();
    assert_eq!(kept * plan.paths_in_batch(), told.into_inner());
    assert!((40..96).contains(&kept), "{kept}");
    assert!(reference.estimates().iter().any(|e| !e.is_known()));
    assert_eq!(reference.paths_ahead(), 0, "batches are told apart by their number, of which some are now missing");
}
