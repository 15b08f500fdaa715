//! Many lamps are the sum of single ones, and only those that are lit and left to the rasteriser are drawn.

use glam::DVec3;
use lightmend_raster::Parts;
use lightmend_scene::{Configuration, Direct, Edit, Scene, View};
use lightmend_tests::{
    Builder,
    pixels::{draw, renderer},
};
use std::sync::Arc;

const SIZE: u32 = 240;

/// Of the sum: half precision, in which a frame buffer might hold it.
const HALF: f64 = 1.0 / 2048.0;

/// Half of the circle more than the other half.
const LOPSIDED: &str = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 4 3 1 2 0 0 0\n1 1 10\n0 30 60 120\n0 90 180\n\
    100 90 80 10\n100 60 40 30\n100 50 20 5\n";

/// A room with things that throw shadows, and lamps of both kinds among them, coloured, of intensities from 1 to 300 cd.
fn furnished(lamps: usize) -> Builder {
    let mut builder = Builder::default()
        .cuboid("room", 0.7, [0.0; 3], [4.0, 3.0, 2.5], true)
        .cuboid("box", 0.5, [2.6, 0.4, 0.0], [3.3, 1.2, 1.1], false)
        .cuboid("cube", 0.3, [1.2, 1.3, 0.6], [1.5, 1.6, 0.9], false)
        .rectangle("plate", 0.6, [0.5, 1.7, 0.7], [1.1, 0.4, 0.35], [-0.2, 0.7, 0.5]);
    for n in 0..lamps {
        let part = |k: f64| (k * (n as f64 + 1.0)).fract();
        builder = builder.lamp([0.3 + 3.4 * part(0.618), 0.3 + 2.4 * part(0.755), 1.3 + part(0.57)], 1.0);
        let lamp = &mut builder.file.lamps[n];
        lamp.intensity = DVec3::new(1.0 + part(0.3), 0.2 + part(0.41), 0.1 + part(0.7)) * 100f64.powf(part(0.83));
        if n % 3 == 1 {
            lamp.photometry = Some("lopsided.ies".into());
            lamp.rotation = DVec3::new(20.0, -50.0, 77.0) * part(0.37);
        }
    }
    builder
}

fn room(lamps: usize) -> Arc<Scene> {
    furnished(lamps).build(&[("lopsided.ies", LOPSIDED)])
}

fn views() -> [View; 2] {
    let view = |eye: [f64; 3], target: [f64; 3]| View { eye: eye.into(), target: target.into(), fov: 75.0 };
    [view([0.2, 0.2, 1.6], [2.5, 2.0, 0.8]), view([3.8, 2.8, 2.2], [1.0, 1.0, 0.6])]
}

/// Switches all lamps but those of `lit`.
fn switched(configuration: &Configuration, lit: impl Fn(usize) -> bool) -> Configuration {
    let lamps: Vec<_> = configuration.lamps().map(|(id, lamp)| Edit::Switch { lamp: lamp.name.clone(), on: lit(id) }).collect();
    lamps.iter().fold(configuration.clone(), |c, edit| c.apply(edit).unwrap())
}

#[test]
fn five_eight_and_thirteen_lamps_are_the_sum_of_single_ones() {
    let mut renderer = renderer();
    for lamps in [0, 1, 4, 5, 8, 13] {
        let all = Configuration::initial(&room(lamps));
        let mut worst = 0.0f64;
        let mut lit = 0;
        for view in views() {
            let mut sum = vec![DVec3::ZERO; (SIZE * SIZE) as usize];
            for n in 0..lamps {
                renderer.show(&switched(&all, |id| id == n)).unwrap();
                assert_eq!(renderer.drawn_lamps().collect::<Vec<_>>(), [n]);
                let light = draw(&mut renderer, &view, SIZE, Parts::RADIANCE);
                let mut alone = 0;
                for (sum, [r, g, b, _]) in sum.iter_mut().zip(light) {
                    *sum += DVec3::new(r.into(), g.into(), b.into());
                    alone += usize::from(r > 0.0);
                }
                assert!(alone > 1000 && alone < (SIZE * SIZE) as usize, "each lamp lights something and throws shadows: {alone}");
            }
            renderer.show(&all).unwrap();
            assert_eq!(renderer.drawn_lamps().count(), lamps);
            for (sum, got) in sum.iter().zip(draw(&mut renderer, &view, SIZE, Parts::RADIANCE)) {
                let got = DVec3::from_slice(&got.map(f64::from)[..3]);
                let error = (got - *sum).abs().max_element() / sum.max_element().max(f64::MIN_POSITIVE);
                worst = worst.max(error);
                lit += usize::from(sum.x > 0.0);
            }
        }
        println!("{lamps} lamps: off the sum by {worst:.2e}, {lit} pixels lit");
        assert!(worst <= HALF, "{worst}");
        assert_eq!(lit > 0, lamps > 0);
    }
}

#[test]
fn a_missing_lamp_is_found_out() {
    // The weakest of 13 lamps is more than half precision in most of what it lights.
    let mut renderer = renderer();
    let all = Configuration::initial(&room(13));
    renderer.show(&all).unwrap();
    let with = draw(&mut renderer, &views()[0], SIZE, Parts::RADIANCE);
    for missing in 0..13 {
        renderer.show(&switched(&all, |id| id != missing)).unwrap();
        let without = draw(&mut renderer, &views()[0], SIZE, Parts::RADIANCE);
        let differs = |(a, b): &(&[f32; 4], &[f32; 4])| f64::from(a[0] - b[0]) > HALF * f64::from(a[0]);
        assert!(with.iter().zip(&without).filter(differs).count() > 1000, "lamp {missing}");
    }
}

#[test]
fn lamps_that_are_off_or_left_to_the_photons_are_not_drawn() {
    let mut renderer = renderer();
    let off = switched(&Configuration::initial(&room(5)), |_| false);
    renderer.show(&off).unwrap();
    assert_eq!(renderer.drawn_lamps().count(), 0);
    let light = draw(&mut renderer, &views()[0], SIZE, Parts::RADIANCE);
    assert!(light.iter().all(|texel| *texel == [0.0, 0.0, 0.0, 1.0]), "black, but seen");

    let mut builder = furnished(5);
    builder.file.lamps[1].direct = Direct::Photons;
    builder.file.lamps[3].direct = Direct::Photons;
    let by_photons = builder.build(&[("lopsided.ies", LOPSIDED)]);
    let mixed = Configuration::initial(&by_photons);
    renderer.show(&mixed).unwrap();
    assert_eq!(renderer.drawn_lamps().collect::<Vec<_>>(), [0, 2, 4]);
    let drawn = draw(&mut renderer, &views()[0], SIZE, Parts::RADIANCE);
    renderer.show(&switched(&mixed, |id| id % 2 == 0)).unwrap();
    assert_eq!(draw(&mut renderer, &views()[0], SIZE, Parts::RADIANCE), drawn, "switching them changes nothing");
    renderer.show(&switched(&mixed, |id| id % 2 == 1)).unwrap();
    let light = draw(&mut renderer, &views()[0], SIZE, Parts::RADIANCE);
    assert!(light.iter().all(|texel| *texel == [0.0, 0.0, 0.0, 1.0]));
}
