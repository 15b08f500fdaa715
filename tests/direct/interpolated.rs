//! Indirect light between lattice points.

use crate::leave_errors;
use glam::{DMat3, DVec3};
use lightmend_raster::{Indirect, Parts, Renderer, side_light};
use lightmend_scene::{Configuration, Edit, LatticePoints, Scene, View};
use lightmend_tests::{
    Builder,
    pixels::{all_around, draw, pixels, renderer},
};
use std::sync::Arc;

const SIZE: u32 = 160;

/// Of the range of values: what is linear stays so but for single precision.
const TOLERANCE: f64 = 1e-4;

/// A closed room with slanting plates in it, cut into mesh elements of `cell` metres, one of them movable.
fn plates(cell: f64) -> Arc<Scene> {
    let mut builder = Builder::default()
        .cuboid("room", 0.5, [0.0; 3], [4.0, 3.0, 2.5], true)
        .rectangle("plate", 0.5, [0.5, 1.7, 0.7], [1.1, 0.4, 0.35], [-0.2, 0.7, 0.5])
        .rectangle("other plate", 0.5, [0.1, -0.3, 0.2], [0.02, 0.4, 0.35], [-0.2, 0.7, -0.5])
        .object("splinter", 0.5, [[3.0, 2.0, 1.0], [3.9, 2.1, 1.1], [3.0, 2.02, 1.3]].map(DVec3::from).into(), vec![[2, 0, 1]]);
    builder.file.cell = cell;
    builder.file.objects[2].movable = true;
    builder.build(&[])
}

/// Where every lattice point of an object is in the world.
fn points(configuration: &Configuration, id: usize) -> Vec<DVec3> {
    let (object, motion) = (configuration.object(id), configuration.object_motion(id));
    let mut points = Vec::new();
    for t in 0..object.mesh.triangles.len() {
        let [a, b, c] = object.mesh.corners(t).map(|p| motion.point(p));
        let n = object.lattice.divisions(t);
        for i in 0..=n {
            for j in 0..=n - i {
                points.push(a + (b - a) * (f64::from(i) / f64::from(n)) + (c - a) * (f64::from(j) / f64::from(n)));
            }
        }
    }
    assert_eq!(points.len() as u32, LatticePoints::new(&object.mesh, &object.lattice).count());
    points
}

/// Lux that are linear in the place, one function for each side of each object.
fn linear(id: usize, side: usize, p: DVec3) -> DVec3 {
    let turn = DMat3::from_rotation_z(1.3 * id as f64 + 0.4) * DMat3::from_rotation_x(0.7 * side as f64 + 0.2);
    DVec3::new(50.0, 70.0, 90.0) + turn * p * 7.0 + DVec3::splat(200.0 * side as f64)
}

/// Values at all lattice points of the sides that `lit` names.
fn indirect(configuration: &Configuration, lit: impl Fn(usize, usize) -> bool) -> Indirect {
    let side = |id: usize, side: usize| {
        let values: Vec<_> = points(configuration, id).into_iter().map(|p| linear(id, side, p).as_vec3().to_array()).collect();
        lit(id, side).then(|| side_light(&values))
    };
    (0..configuration.object_slots()).map(|id| [side(id, 0), side(id, 1)]).collect()
}

/// The largest error as a share of the range of values, and how many pixels saw each side of each object.
fn compare(
    name: &str,
    renderer: &mut Renderer,
    configuration: &Configuration,
    lit: impl Fn(usize, usize) -> bool,
) -> (f64, Vec<[usize; 2]>) {
    const RANGE: f64 = 250.0;
    let mut seen = vec![[0; 2]; configuration.object_slots()];
    let mut worst = 0.0f64;
    for (v, view) in
        [[1.0, 0.9, 1.3], [3.5, 2.4, 0.6], [0.4, 2.8, 2.3]].into_iter().flat_map(|eye| all_around(eye.into())).enumerate()
    {
        let light = draw(renderer, &view, SIZE, Parts::INDIRECT_IRRADIANCE);
        let mut errors = Vec::new();
        for pixel in pixels(renderer, configuration, &view, SIZE) {
            let got = DVec3::from_slice(&light[pixel.index].map(f64::from)[..3]);
            let expected =
                if lit(pixel.object, pixel.side) { linear(pixel.object, pixel.side, pixel.point) } else { DVec3::ZERO };
            seen[pixel.object][pixel.side] += 1;
            errors.push((pixel.index, (got - expected).abs().max_element() / RANGE));
        }
        let here = errors.iter().map(|(_, e)| *e).fold(0.0, f64::max);
        worst = worst.max(here);
        if here > TOLERANCE {
            println!("{}", leave_errors(&format!("interpolated, {name}, {v}"), SIZE, TOLERANCE, errors.into_iter()));
        }
    }
    println!("{name}: off by {worst:.2e} of the range; seen {seen:?}");
    (worst, seen)
}

#[test]
fn linear_light_is_interpolated_linearly_on_both_sides() {
    let mut renderer = renderer();
    for cell in [1e6, 1.0, 0.37, 0.05] {
        let scene = plates(cell);
        let turn = Edit::Turn { object: "other plate".into(), to: DVec3::new(15.0, -30.0, 40.0) };
        let place = Edit::Move { object: "other plate".into(), to: DVec3::new(2.2, 1.1, 0.9) };
        let configuration = Configuration::initial(&scene).apply(&turn).unwrap().apply(&place).unwrap();
        renderer.show(&configuration).unwrap();
        renderer.light(&indirect(&configuration, |_, _| true)).unwrap();
        let (worst, seen) = compare(&format!("cells of {cell} m"), &mut renderer, &configuration, |_, _| true);
        assert!(worst <= TOLERANCE);
        // The room is closed: nobody sees its outside.
        let room = configuration.object_id("room").unwrap();
        assert!(seen.iter().enumerate().all(|(id, [front, back])| *front > 30 && (id == room || *back > 30)), "{seen:?}");
    }
}

#[test]
fn a_side_without_light_is_black() {
    let mut renderer = renderer();
    let configuration = Configuration::initial(&plates(0.2));
    let lit = |id: usize, side: usize| (id + side).is_multiple_of(2);
    renderer.show(&configuration).unwrap();
    renderer.light(&indirect(&configuration, |_, _| true)).unwrap();
    renderer.light(&indirect(&configuration, lit)).unwrap();
    assert!(compare("half of the sides", &mut renderer, &configuration, lit).0 <= TOLERANCE);
    renderer.light(&indirect(&configuration, |_, _| false)).unwrap();
    assert_eq!(compare("none", &mut renderer, &configuration, |_, _| false).0, 0.0);
}

#[test]
fn light_on_the_wrong_side_is_found_out() {
    let mut renderer = renderer();
    let configuration = Configuration::initial(&plates(0.2));
    renderer.show(&configuration).unwrap();
    let mut swapped = indirect(&configuration, |_, _| true);
    swapped.iter_mut().for_each(|sides| sides.swap(0, 1));
    renderer.light(&swapped).unwrap();
    let view = View { eye: DVec3::new(1.0, 0.9, 1.3), target: DVec3::new(2.0, 1.0, 1.0), fov: 90.0 };
    let light = draw(&mut renderer, &view, SIZE, Parts::INDIRECT_IRRADIANCE);
    for pixel in pixels(&renderer, &configuration, &view, SIZE) {
        let got = DVec3::from_slice(&light[pixel.index].map(f64::from)[..3]);
        assert!((got - linear(pixel.object, pixel.side, pixel.point)).length() > 10.0);
    }
}
