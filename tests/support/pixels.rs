//! What every pixel of the rasteriser's picture shows, found apart from the shaders: the exact point where its ray meets the triangle.

use glam::{DVec2, DVec3};
use lightmend_raster::{Device, Look, Parts, Renderer, Settings, camera::Camera};
use lightmend_scene::{Configuration, View};
use std::sync::{Arc, LazyLock};

/// A pixel that sees something.
#[derive(Debug, Clone, Copy)]
pub struct Pixel {
    /// Its number, row by row from the top.
    pub index: usize,
    /// The object's number.
    pub object: usize,
    /// The triangle of its mesh.
    pub triangle: usize,
    /// Barycentric weights of the second and third corner.
    pub weights: [f64; 2],
    /// Metres.
    pub point: DVec3,
    /// Unit, on the side that is seen.
    pub normal: DVec3,
    /// 0: front, 1: back.
    pub side: usize,
    /// What the pixel covers of the surface, m².
    pub area: f64,
}

static DEVICE: LazyLock<Arc<Device>> = LazyLock::new(|| Arc::new(Device::headless().unwrap()));

/// A renderer; all share one device.
pub fn renderer() -> Renderer {
    Renderer::new(DEVICE.clone()).unwrap()
}

/// Draws `parts` of what a square picture sees and reads the light of each pixel.
pub fn draw(renderer: &mut Renderer, view: &View, size: u32, parts: Parts) -> Vec<[f32; 4]> {
    renderer.draw(view, &Settings { width: size, height: size, grid: 1, parts, look: Look::Plain }).unwrap();
    renderer.samples().unwrap()
}

/// The pixels of the picture that was just drawn of `view`, `size` pixels wide and high.
pub fn pixels(renderer: &Renderer, configuration: &Configuration, view: &View, size: u32) -> Vec<Pixel> {
    let camera = Camera::new(view, configuration.scene().up, 1.0, configuration.reach());
    let on_plane = 4.0 * camera.right.length() * camera.above.length() / f64::from(size * size);
    let mut pixels = Vec::new();
    for (index, seen) in renderer.seen().unwrap().into_iter().enumerate() {
        let Some((object, triangle)) = seen else { continue };
        let (x, y) = (index as u32 % size, index as u32 / size);
        let middle = |k: u32| (2.0 * f64::from(k) + 1.0) / f64::from(size) - 1.0;
        let ray = camera.ray(DVec2::new(middle(x), -middle(y)));
        let motion = configuration.object_motion(object);
        // As drawn: corners in the world, in single precision.
        let [a, b, c] = configuration.object(object).mesh.corners(triangle).map(|p| motion.point(p).as_vec3().as_dvec3());
        let (u, v) = (b - a, c - a);
        let normal = u.cross(v).normalize();
        let along = normal.dot(ray);
        let distance = normal.dot(a - camera.eye) / along;
        let point = camera.eye + ray * distance;
        let d = point - a;
        let determinant = u.dot(u) * v.dot(v) - u.dot(v) * u.dot(v);
        let weights = [
            (v.dot(v) * u.dot(d) - u.dot(v) * v.dot(d)) / determinant,
            (u.dot(u) * v.dot(d) - u.dot(v) * u.dot(d)) / determinant,
        ];
        pixels.push(Pixel {
            index,
            object,
            triangle,
            weights,
            point,
            normal: if along > 0.0 { -normal } else { normal },
            side: usize::from(along > 0.0),
            area: on_plane * distance * distance / along.abs(),
        });
    }
    pixels
}

/// Six views from a point that together see all directions, 90° each.
pub fn all_around(eye: DVec3) -> [View; 6] {
    [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z].map(|d| View { eye, target: eye + d, fov: 90.0 })
}
