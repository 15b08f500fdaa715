//! Lamps that shine alike in all directions: candela · cos θ / d² at every pixel.

use crate::leave_errors;
use glam::DVec3;
use lightmend_raster::Parts;
use lightmend_scene::{Configuration, Scene, Up, View};
use lightmend_tests::{
    Builder,
    pixels::{all_around, draw, pixels, renderer},
};
use std::sync::Arc;

const SIZE: u32 = 160;

/// What the comparison allows. Single precision alone errs by some 10⁻⁵ here; a factor of 1.01 must fail.
const TOLERANCE: f64 = 0.005;

/// Below this cosine nothing is compared: the rounding of positions turns the angle itself.
const GRAZING: f64 = 1e-3;

/// What was compared and how far off it was.
#[derive(Debug, Default)]
struct Compared {
    lit: usize,
    shadowed: usize,
    averted: usize,
    grazing: usize,
    worst: f64,
    nearest: f64,
    smallest_cosine: f64,
}

/// One lamp at a time against the closed form.
fn compare(name: &str, scene: &Arc<Scene>, views: &[View], factor: f64) -> Compared {
    let mut renderer = renderer();
    let configuration = Configuration::initial(scene);
    renderer.show(&configuration).unwrap();
    assert_eq!(renderer.drawn_lamps().count(), 1);
    let id = renderer.drawn_lamps().next().unwrap();
    let lamp = configuration.lamp_motion(id).translation.as_vec3().as_dvec3();
    let candela = configuration.lamp(id).intensity;
    let mut found = Compared { nearest: f64::INFINITY, smallest_cosine: 1.0, ..Compared::default() };
    for (v, view) in views.iter().enumerate() {
        let light = draw(&mut renderer, view, SIZE, Parts::DIRECT_IRRADIANCE);
        let mask = renderer.mask(0).unwrap();
        let mut errors = Vec::new();
        for pixel in pixels(&renderer, &configuration, view, SIZE) {
            let [r, g, b, seen] = light[pixel.index];
            let got = DVec3::new(r.into(), g.into(), b.into());
            assert_eq!(seen, 1.0);
            let to_lamp = lamp - pixel.point;
            let distance = to_lamp.length();
            let cosine = pixel.normal.dot(to_lamp) / distance;
            if cosine.abs() < GRAZING {
                found.grazing += 1;
                continue;
            }
            if cosine < 0.0 || !mask[pixel.index] {
                assert_eq!(got, DVec3::ZERO, "{name}: light on what is averted or in shadow");
                *if cosine < 0.0 { &mut found.averted } else { &mut found.shadowed } += 1;
                continue;
            }
            let expected = candela * cosine / (distance * distance) * factor;
            let error = (got - expected) / expected.max(DVec3::splat(f64::MIN_POSITIVE));
            let error = if error.max_element() > -error.min_element() { error.max_element() } else { error.min_element() };
            errors.push((pixel.index, error));
            found.lit += 1;
            found.worst = found.worst.max(error.abs());
            found.nearest = found.nearest.min(distance);
            found.smallest_cosine = found.smallest_cosine.min(cosine);
        }
        if errors.iter().any(|(_, e)| e.abs() > TOLERANCE) && factor == 1.0 {
            println!("{}", leave_errors(&format!("isotropic, {name}, {v}"), SIZE, TOLERANCE, errors.into_iter()));
        }
    }
    println!("{name}: {found:?}");
    found
}

/// A room with a tilted plate and a box in it; the lamp's candela differ per channel by up to 1000.
fn furnished(up: Up, lamp: [f64; 3], candela: DVec3) -> Arc<Scene> {
    let mut builder = Builder::default()
        .cuboid("room", 0.5, [0.0; 3], [4.0, 3.0, 2.5], true)
        .cuboid("box", 0.5, [2.6, 0.4, 0.3], [3.3, 1.2, 1.1], false)
        .rectangle("plate", 0.5, [0.5, 1.7, 0.7], [1.1, 0.4, 0.35], [-0.2, 0.7, 0.5])
        .lamp(lamp, 1.0);
    builder.file.up = up;
    builder.file.lamps[0].intensity = candela;
    builder.build(&[])
}

#[test]
fn irradiance_is_candela_times_cosine_over_squared_distance() {
    for (up, name) in [(Up::Z, "z"), (Up::Y, "y")] {
        for (lamp, candela) in [
            ([1.7, 1.1, 1.6], DVec3::new(100.0, 100.0, 100.0)),
            // A lamp of 10⁷ cd, coloured, in a corner.
            ([3.9, 2.9, 2.4], DVec3::new(1e7, 3e5, 1e4)),
            // 1 cm under the plate of the room's floor corner, and of one colour only.
            ([1.4, 0.8, 0.01], DVec3::new(0.0, 55.0, 0.0)),
        ] {
            let scene = furnished(up, lamp, candela);
            let views: Vec<View> =
                [[1.0, 0.9, 1.3], [3.5, 2.4, 0.6]].into_iter().flat_map(|eye| all_around(eye.into())).collect();
            let found = compare(&format!("room, {name} up, lamp at {lamp:?}"), &scene, &views, 1.0);
            assert!(found.lit > 50_000 && found.worst <= TOLERANCE, "{found:?}");
            assert!(found.shadowed > 100 && found.averted > 1000, "{found:?}");
        }
    }
}

/// A floor of 20 m, at an odd place and tilt if `tilted`, and a lamp over its middle.
fn floor(tilted: bool, height: f64, aside: f64, candela: f64) -> (Arc<Scene>, View) {
    let (u, v) = if tilted {
        (DVec3::new(0.8, 0.36, 0.48) * 20.0, DVec3::new(-0.6, 0.48, 0.64) * 20.0)
    } else {
        (DVec3::X * 20.0, DVec3::Y * 20.0)
    };
    let normal = u.cross(v).normalize();
    let corner = DVec3::new(-7.0, -11.0, 3.0);
    let middle = corner + u / 2.0 + v / 2.0;
    let lamp = middle + normal * height + u.normalize() * aside;
    let scene =
        Builder::default().rectangle("floor", 0.5, corner.into(), u.into(), v.into()).lamp(lamp.into(), candela).build(&[]);
    (scene, View { eye: middle + normal * 9.0 - u * 0.1, target: middle, fov: 100.0 })
}

#[test]
fn the_law_holds_very_near_and_very_far_and_at_grazing_angles() {
    for (tilted, height, aside, candela) in [
        (false, 0.01, 0.0, 5.0),
        (true, 0.01, 0.0, 5.0),
        (false, 1000.0, 0.0, 2e8),
        (true, 1000.0, 0.0, 2e8),
        // A kilometre away and at 0.1° over the horizon.
        (false, 2.0, 1000.0, 1e9),
        (true, 2.0, 1000.0, 1e9),
    ] {
        let (scene, view) = floor(tilted, height, aside, candela);
        // From high above, and from near the lamp's foot.
        let foot = View { eye: view.target + (view.eye - view.target) * 0.03, ..view };
        let found =
            compare(&format!("floor, tilted {tilted}, lamp {height} m over it, {aside} m aside"), &scene, &[view, foot], 1.0);
        assert!(found.lit > 20_000 && found.worst <= TOLERANCE, "{found:?}");
        // The rim of the floor itself may fall either way.
        assert!(found.shadowed * 10_000 <= found.lit, "{found:?}");
        assert!(height > 1.0 || found.nearest < 0.0105, "{found:?}");
        assert!(height > 10.0 || found.smallest_cosine < 2.1e-3, "{found:?}");
    }
}

#[test]
fn a_factor_of_one_per_cent_is_found() {
    let found = compare("wrong on purpose", &furnished(Up::Z, [1.7, 1.1, 1.6], DVec3::ONE), &all_around(DVec3::ONE), 1.01);
    assert!(found.worst > TOLERANCE, "{found:?}");
}
