//! The room's part of the window, as a test that points at things must know it.

use super::{
    program::Desk,
    screen::{Screen, keys},
};
use glam::{DVec2, DVec3};
use image::RgbImage;
use lightmend_raster::camera::Camera;
use lightmend_scene::{Configuration, Scene};

/// The room's part of the window, and the camera that it shows.
pub struct Room {
    place: [f64; 4],
    camera: Camera,
}

impl Room {
    /// As a run that ends at once tells it, for one of the scene's cameras.
    pub fn learn(desk: &Desk, screen: &Screen, scene: &str, camera: usize) -> Room {
        let program = desk.view(screen, &format!("{scene} --summary first.json"));
        screen.key(&[keys::CONTROL], u32::from(b'q'));
        assert_eq!(program.end().0, Some(0));
        let place: Vec<f64> =
            desk.json("first.json")["room_in_window"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        let scene = Scene::read(&desk.path(scene)).unwrap().0;
        let reach = Configuration::initial(&scene).reach();
        let camera = Camera::new(&scene.cameras[camera].1, scene.up, place[2] / place[3], reach);
        Room { place: [place[0], place[1], place[2], place[3]], camera }
    }

    /// The pixel of the screen where a point of the world is.
    pub fn pixel(&self, point: DVec3) -> [i32; 2] {
        let DVec2 { x, y } = self.camera.project(point).unwrap();
        let [left, top, width, height] = self.place;
        [(left + (1.0 + x) / 2.0 * width).round() as i32, (top + (1.0 - y) / 2.0 * height).round() as i32]
    }

    /// How much two pictures of the screen differ there: mean over pixels and channels, of 255.
    pub fn difference(&self, a: &RgbImage, b: &RgbImage) -> f64 {
        let [left, top, width, height] = self.place.map(|v| v as u32);
        let places = (left..left + width).flat_map(|x| (top..top + height).map(move |y| (x, y)));
        let apart = |(x, y)| (0..3).map(|c| f64::from(a.get_pixel(x, y)[c].abs_diff(b.get_pixel(x, y)[c]))).sum::<f64>();
        places.map(apart).sum::<f64>() / f64::from(3 * width * height)
    }
}
