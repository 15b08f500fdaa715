//! Goniometric lamps as they are drawn: intensity in every direction, however the lamp is turned and carried, and the whole flux.

use crate::{
    diagrams::{MOST, Verdict, corpus, hand_made, laser, own},
    leave_errors,
};
use glam::{DMat3, DVec3};
use lightmend_raster::{Parts, Renderer};
use lightmend_scene::{Configuration, Edit, Photometry, Scene, Up};
use lightmend_tests::{
    Builder,
    pixels::{all_around, draw, pixels, renderer},
};
use std::{path::Path, sync::Arc};

const SIZE: u32 = 160;

/// Of the flux. The maps' share is below 0.1 %; the rest is the sum over pixels where a diagram ends sharply.
const FLUX: f64 = 0.005;

const FACTORS: DVec3 = DVec3::new(1.08, 0.5, 0.02);

/// A closed box about a lamp on a carrier that stands outside of it.
fn closed(up: Up) -> Arc<Scene> {
    let mut builder = Builder::default()
        .cuboid("box", 0.5, [-1.0, -1.3, -0.9], [1.2, 1.0, 1.1], true)
        .cuboid("carrier", 0.5, [4.0; 3], [4.5; 3], false)
        .lamp([0.05, 0.1, -0.15], 1.0);
    builder.file.up = up;
    builder.file.objects[1].movable = true;
    builder.file.lamps[0].on = Some("carrier".into());
    builder.file.lamps[0].intensity = FACTORS;
    builder.build(&[])
}

/// How the lamp and its carrier are turned, degrees about x, y, z.
#[derive(Debug, Clone, Copy)]
struct Turned {
    lamp: DVec3,
    carrier: DVec3,
}

fn rotation(degrees: DVec3) -> DMat3 {
    let [x, y, z] = degrees.to_array().map(f64::to_radians);
    DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x)
}

const STRAIGHT: Turned = Turned { lamp: DVec3::ZERO, carrier: DVec3::ZERO };
const TURNS: [Turned; 3] = [
    STRAIGHT,
    Turned { lamp: DVec3::new(0.0, 0.0, 90.0), carrier: DVec3::ZERO },
    Turned { lamp: DVec3::new(30.0, -50.0, 110.0), carrier: DVec3::new(-20.0, 75.0, 200.0) },
];

/// From the world to the lamp's axes, as docs/scene-format.md says: γ = 0 is down, C = 0 is +x, C = 90 counter-clockwise from it
/// when seen from above.
fn lamp_axes(up: Up, turned: Turned, d: DVec3) -> DVec3 {
    let d = (rotation(turned.carrier) * rotation(turned.lamp)).transpose() * d;
    match up {
        Up::Z => d,
        Up::Y => DVec3::new(d.x, -d.z, d.y),
    }
}

/// Draws the lamp with a photometric file, turned in these ways, and compares every pixel and the flux; returns what it warned of.
fn check(name: &str, renderer: &mut Renderer, scene: &Arc<Scene>, file: &Path, turns: &[Turned]) -> Vec<String> {
    let photometry = Photometry::read(file).unwrap().0;
    let relamp = Edit::Relamp { lamp: "lamp 0".into(), photometry: Some(file.to_string_lossy().into()), intensity: None };
    let lamped = Configuration::initial(scene).apply(&relamp).unwrap();
    let (mut worst, mut worst_flux, mut warnings) = (0.0, 0.0f64, Vec::new());
    for turned in turns {
        let turn_lamp = Edit::TurnLamp { lamp: "lamp 0".into(), to: turned.lamp };
        let turn_carrier = Edit::Turn { object: "carrier".into(), to: turned.carrier };
        let configuration = lamped.apply(&turn_lamp).unwrap().apply(&turn_carrier).unwrap();
        renderer.show(&configuration).unwrap();
        warnings.extend(renderer.warnings());
        let at = (rotation(turned.carrier) * DVec3::new(0.05, 0.1, -0.15)).as_vec3().as_dvec3();
        let mut verdict = Verdict::new(&photometry);
        let mut flux = DVec3::ZERO;
        for (v, view) in all_around(at).iter().enumerate() {
            let light = draw(renderer, view, SIZE, Parts::DIRECT_IRRADIANCE);
            let mask = renderer.mask(0).unwrap();
            let mut errors = Vec::new();
            for pixel in pixels(renderer, &configuration, view, SIZE) {
                assert!(mask[pixel.index], "nothing stands between the lamp and the box");
                let away = pixel.point - at;
                let cosine = -pixel.normal.dot(away) / away.length();
                let [r, g, b, _] = light[pixel.index];
                let candela = DVec3::new(r.into(), g.into(), b.into()) / FACTORS * away.length_squared() / cosine;
                let d = lamp_axes(scene.up, *turned, away);
                let error = candela
                    .to_array()
                    .map(|i| verdict.add(d, i))
                    .into_iter()
                    .fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
                errors.push((pixel.index, error));
                flux += candela * (pixel.area * cosine / away.length_squared());
            }
            assert_eq!(errors.len() as u32, SIZE * SIZE);
            if verdict.worst.0 > MOST && warnings.is_empty() {
                println!("{}", leave_errors(&format!("goniometric, {name}, {v}"), SIZE, MOST, errors.into_iter()));
            }
        }
        let flux = flux / photometry.luminous_flux() - 1.0;
        let flux = if flux.max_element() > -flux.min_element() { flux.max_element() } else { flux.min_element() };
        if verdict.worst.0 > worst {
            println!("{name}, {:?} up, {turned:?}: {}", scene.up, verdict.line());
        }
        worst = verdict.worst.0.max(worst);
        worst_flux = if flux.abs() > worst_flux.abs() { flux } else { worst_flux };
    }
    println!("{name}, {:?} up: worst {:.3} % of the peak, flux {:+.4} %", scene.up, 100.0 * worst, 100.0 * worst_flux);
    assert!(worst <= MOST || !warnings.is_empty(), "{name}");
    assert!(worst_flux.abs() <= FLUX || !warnings.is_empty(), "{name}");
    warnings
}

#[test]
fn every_kind_of_diagram_is_drawn_as_its_file_says() {
    let folder = tempfile::tempdir().unwrap();
    let made = hand_made().into_iter().map(|(name, text)| {
        let path = folder.path().join(format!("{name}.ies"));
        std::fs::write(&path, text).unwrap();
        path
    });
    let files: Vec<_> = made.chain(own()).collect();
    let mut renderer = renderer();
    for up in [Up::Z, Up::Y] {
        let scene = closed(up);
        for file in &files {
            let warnings = check(&file.file_stem().unwrap().to_string_lossy(), &mut renderer, &scene, file, &TURNS);
            assert!(warnings.is_empty(), "{warnings:?}");
        }
    }
}

#[test]
fn the_corpus_is_drawn_as_its_files_say() {
    let (mut renderer, scene) = (renderer(), closed(Up::Y));
    for file in corpus().iter().filter(|file| Photometry::read(file).is_ok()) {
        check(&file.file_name().unwrap().to_string_lossy(), &mut renderer, &scene, file, &TURNS[2..]);
    }
}

#[test]
fn a_beam_too_narrow_for_a_map_is_told_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("laser.ies");
    std::fs::write(&path, laser()).unwrap();
    let warnings = check("laser", &mut renderer(), &closed(Up::Z), &path, &TURNS);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].starts_with("lamp 'lamp 0': its beam is narrower than a cube map can hold"), "{warnings:?}");
}
