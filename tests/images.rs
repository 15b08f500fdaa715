//! Frames against golden pictures, and against themselves: same input, same bits.
//!
//! A picture fails when its mean FLIP error is above 0.02 or its 99.9th percentile above 0.3; it, the golden one and the error map are then
//! left in the folder that the message names. `LIGHTMEND_GOLDEN=write` replaces the golden pictures: look at them before you commit them.

use image::RgbImage;
use lightmend_perception::{GoldenError, check_against_golden};
use lightmend_photon::{
    irradiance::Scale,
    path::FirstHits,
    reconstruction::{Reconstruction, Shapes},
};
use lightmend_raster::{Device, Indirect, Look, Parts, Renderer, Settings, side_light};
use lightmend_scene::{Configuration, Edit};
use lightmend_tests::{own_scene, pool, shoot, world};
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

const WIDTH: u32 = 480;
const HEIGHT: u32 = 360;

/// A camera's picture of one of our scenes after edits, lit by the usual pool; drawn on a device of its own.
fn draw(scene: &str, camera: &str, edits: &[Edit]) -> RgbImage {
    let scene = own_scene(scene);
    let configuration = edits.iter().fold(Configuration::initial(&scene), |c, edit| c.apply(edit).unwrap());
    let world = world(&scene).moved_to(&configuration);
    let solution = shoot(pool(1_152_000), &Arc::new(world), FirstHits::AsLampsSay);
    let scale = Scale::new(solution.world(), solution.pool().photons());
    let lamps = configuration.lamp_slots();
    let shapes = Shapes::of(&configuration);
    let light = Reconstruction::new(&shapes, &configuration, solution.buckets(), &scale, lamps);
    let sides = |id| [0, 1].map(|side| Some(side_light(&light.vertices(id, side)?)));
    let indirect: Indirect = (0..configuration.object_slots()).map(sides).collect();
    let mut renderer = Renderer::new(Arc::new(Device::headless().unwrap())).unwrap();
    renderer.show(&configuration).unwrap();
    renderer.light(&indirect).unwrap();
    let view = scene.cameras.iter().find(|(name, _)| name == camera).unwrap().1;
    let look = Look::Photograph { exposure: None };
    renderer.draw(&view, &Settings { width: WIDTH, height: HEIGHT, grid: 2, parts: Parts::RADIANCE, look }).unwrap();
    assert_eq!(renderer.warnings(), Vec::<String>::new());
    RgbImage::from_raw(WIDTH, HEIGHT, renderer.picture().unwrap().into_flattened()).unwrap()
}

fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("golden").join(format!("{name}.png"))
}

fn left_behind() -> &'static Path {
    Path::new(env!("CARGO_TARGET_TMPDIR"))
}

fn check(name: &str, picture: &RgbImage) {
    if std::env::var("LIGHTMEND_GOLDEN").is_ok_and(|v| v == "write") {
        picture.save(golden(name)).unwrap();
    }
    match check_against_golden(name, &golden(name), picture, left_behind()) {
        Ok(c) => println!("{name}: mean FLIP {:.5}, 99.9th percentile {:.4}", c.mean, c.percentile_999),
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn the_cornell_box() {
    check("cornell_front", &draw("cornell", "front", &[]));
}

#[test]
fn the_room_and_a_cup_that_is_lost() {
    let table = draw("room", "table", &[]);
    check("room_table", &table);
    let lost = draw("room", "table", &[Edit::Remove { object: "cup west".into() }]);
    let error = check_against_golden("room_table_without_a_cup", &golden("room_table"), &lost, left_behind()).unwrap_err();
    assert!(matches!(error, GoldenError::Differs { percentile_999, .. } if percentile_999 > 0.3), "{error}");
    check("room_door", &draw("room", "door", &[]));
}

#[test]
fn the_room_after_its_table_was_moved() {
    let to = glam::DVec3::new(2.4, 3.0, 0.0);
    check("room_door_table_moved", &draw("room", "door", &[Edit::Move { object: "table".into(), to }]));
}

#[test]
fn the_house() {
    check("house_living_room", &draw("house", "living room", &[]));
    check("house_bedroom", &draw("house", "bedroom", &[]));
    check("house_kitchen_door", &draw("house", "kitchen door", &[]));
}

#[test]
fn two_devices_draw_the_same_bits() {
    let [a, b] = [0, 1].map(|_| draw("room", "bed", &[]));
    assert!(a == b);
}
