//! Photons are neither lost nor made.

use lightmend_photon::{balance::Balance, path::FirstHits, record::Tally};
use lightmend_scene::Configuration;
use lightmend_tests::{Builder, count, own_scene, own_scene_untextured, pool, shoot, world};

fn total(tallies: &[Tally], what: fn(&Tally) -> i64) -> u64 {
    tallies.iter().map(what).sum::<i64>() as u64
}

#[test]
fn no_photon_leaves_a_closed_room() {
    for name in ["cornell", "room", "house"] {
        let scene = own_scene(name);
        let photons = if name == "house" { count(1_000_000, 20_000_000) } else { count(5_000_000, 100_000_000) };
        let solution = shoot(pool(photons), &world(&scene), FirstHits::Always);
        let tallies = solution.tallies();
        let (absorbed, escaped, cut) = (total(tallies, |t| t.absorbed), total(tallies, |t| t.escaped), total(tallies, |t| t.cut));
        println!("{name}: {photons} photons: absorbed {absorbed}, escaped {escaped}, cut {cut}");
        assert_eq!(absorbed + escaped + cut, photons);
        assert_eq!(escaped + cut, 0);
    }
}

#[test]
fn energy_is_conserved_per_channel() {
    // Absorbed by all surfaces, Σ (1 − ρ) · incident from the buckets, is emitted − escaped − cut, within 4 standard errors of the
    // photons' own scatter. The open box lets light out.
    let open = Builder::default()
        .rectangle("floor", 0.6, [0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0])
        .rectangle("wall", 0.3, [0.0; 3], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0])
        .lamp([1.0, 1.0, 1.0], 50.0)
        .build(&[]);
    for scene in [own_scene("cornell"), own_scene_untextured("room"), open] {
        let photons = count(1_000_000, 10_000_000);
        let world = world(&scene);
        let solution = shoot(pool(photons), &world, FirstHits::Always);
        let unit = f64::from(1u32 << lightmend_photon::bucket::ENERGY_BITS);
        assert!(Balance::trace(solution.rules(), &world, photons).is_held_by(solution.buckets()), "{}", scene.name);
        let mut kept = [0.0; 3];
        for (at, bucket) in solution.buckets().lit() {
            let object = world.object(at.object as usize);
            let triangle = object.lattice.triangle_of(at.cell);
            let material = object.material(triangle);
            for c in 0..3 {
                kept[c] += bucket.energy[c] as f64 / unit * f64::from(1.0 - material.reflectance[c]);
            }
        }
        // The scatter of a photon's balance about 1, from a share of the pool.
        let sample = Balance::trace(solution.rules(), &world, photons.min(200_000));
        assert!(sample.is_whole());
        for c in 0..3 {
            let lost: i64 = solution.tallies().iter().map(|t| t.escaped_energy[c] + t.cut_energy[c]).sum();
            let given = photons as f64 - lost as f64 / unit;
            let standard_error = sample.standard_error[c] * (sample.photons as f64 * photons as f64).sqrt();
            println!("{} channel {c}: kept {:.1} of {given:.1} photons, standard error {standard_error:.1}", scene.name, kept[c]);
            assert!((kept[c] - given).abs() < 4.0 * standard_error, "{}, channel {c}", scene.name);
        }
    }
}

#[test]
fn nothing_passes_a_sealed_wall_of_a_millimetre() {
    let scene = Builder::default()
        .cuboid("room", 0.8, [0.0; 3], [3.0, 2.5, 2.2], true)
        .cuboid("outer", 0.7, [1.0, 1.0, 0.0], [1.8, 1.7, 0.6], false)
        .cuboid("inner", 0.7, [1.001, 1.001, 0.001], [1.799, 1.699, 0.599], true)
        .lamp([0.5, 0.5, 2.0], 100.0)
        .build(&[]);
    let photons = count(5_000_000, 100_000_000);
    let solution = shoot(pool(photons), &world(&scene), FirstHits::Always);
    let built = Configuration::initial(&scene);
    let inner = built.object_id("inner").unwrap();
    assert!(solution.buckets().get(inner, 0, 0).is_none() && solution.buckets().get(inner, 1, 0).is_none());
    let outer = built.object_id("outer").unwrap();
    assert!(solution.buckets().get(outer, 0, 0).is_some() && solution.buckets().get(outer, 1, 0).is_none());
    assert_eq!(total(solution.tallies(), |t| t.escaped), 0);
}
