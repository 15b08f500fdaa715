//! Textures at every size: texel for texel, and from afar their mean in linear light.

use crate::leave_errors;
use glam::{DVec2, DVec3, Vec3};
use image::{Rgb, RgbImage};
use lightmend_raster::{Parts, Renderer, side_light};
use lightmend_scene::{Configuration, Scene, Texture, View};
use lightmend_tests::{
    Builder,
    pixels::{Pixel, draw, pixels, renderer},
};
use std::sync::Arc;

const SIZE: u32 = 150;

/// Of white. A texel holds square roots in 10 bits or more: half a step of 1/1023 is 0.1 % of white.
const EXACT: f64 = 0.005;

/// A rectangle of `size` metres in the plane z = 0 whose texture repeats `times`, from `start` on.
struct Textured {
    renderer: Renderer,
    configuration: Configuration,
    texture: Arc<Texture>,
    size: DVec2,
    start: DVec2,
    times: DVec2,
}

impl Textured {
    fn new(image: &RgbImage, size: DVec2, start: DVec2, times: DVec2) -> Textured {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("texture.png");
        image.save(&path).unwrap();
        let at = |x: f64, y: f64| start + times * DVec2::new(x, y);
        let [a, b, c, d] = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
        let builder = Builder::default()
            .rectangle("rectangle", 1.0, [-size.x / 2.0, -size.y / 2.0, 0.0], [size.x, 0.0, 0.0], [0.0, size.y, 0.0])
            .texture(&path, vec![[a, b, c], [a, c, d]]);
        let scene: Arc<Scene> = builder.build(&[]);
        let configuration = Configuration::initial(&scene);
        let mut renderer = renderer();
        renderer.show(&configuration).unwrap();
        // π lux everywhere: what is seen is the reflectance.
        renderer.light(&vec![[Some(side_light(&[[std::f32::consts::PI; 3]; 6])), None]]).unwrap();
        let texture = scene.objects[0].materials[0].texture.clone().unwrap();
        Textured { renderer, configuration, texture, size, start, times }
    }

    /// The reflectances that are seen, with their pixels.
    fn see(&mut self, view: &View) -> Vec<(Pixel, DVec3)> {
        let light = draw(&mut self.renderer, view, SIZE, Parts::RADIANCE);
        let pixels = pixels(&self.renderer, &self.configuration, view, SIZE);
        pixels.into_iter().map(|pixel| (pixel, DVec3::from_slice(&light[pixel.index].map(f64::from)[..3]))).collect()
    }

    fn uv(&self, point: DVec3) -> DVec2 {
        self.start + self.times * (point.truncate() / self.size + 0.5)
    }

    fn sample(&self, uv: DVec2) -> Vec3 {
        self.texture.sample(uv.rem_euclid(DVec2::ONE).as_vec2().to_array())
    }

    fn mean(&self) -> DVec3 {
        let [width, height] = self.texture.size();
        self.texture.linear().map(|t| t.as_dvec3()).sum::<DVec3>() / f64::from(width * height)
    }

    /// The mean of the texture over a pixel of a picture of `view`: all texels that rays through it meet.
    fn footprint(&self, view: &View, pixel: &Pixel, rays: u32) -> DVec3 {
        let camera = lightmend_raster::camera::Camera::new(view, self.configuration.scene().up, 1.0, self.configuration.reach());
        let (x, y) = (f64::from(pixel.index as u32 % SIZE), f64::from(pixel.index as u32 / SIZE));
        let mut sum = DVec3::ZERO;
        for k in 0..rays * rays {
            let part = |k: u32| (f64::from(k) + 0.5) / f64::from(rays);
            let at = (DVec2::new(x + part(k % rays), y + part(k / rays))) * 2.0 / f64::from(SIZE) - 1.0;
            let ray = camera.ray(DVec2::new(at.x, -at.y));
            sum += self.sample(self.uv(view.eye - ray * (view.eye.z / ray.z))).as_dvec3();
        }
        sum / f64::from(rays * rays)
    }
}

/// Straight down on a square metre that fills the picture at height 1.
fn above(height: f64) -> View {
    View { eye: DVec3::Z * height, target: DVec3::ZERO, fov: 2.0 * 0.5f64.atan().to_degrees() }
}

/// The same numbers every time.
fn noise(x: u32, y: u32) -> u32 {
    let h = (x.wrapping_mul(2654435761) ^ y.wrapping_mul(2246822519)).wrapping_mul(3266489917);
    (h ^ (h >> 15)).wrapping_mul(668265263) >> 8
}

/// Every byte in every channel.
fn coloured(width: u32, height: u32) -> RgbImage {
    RgbImage::from_fn(width, height, |x, y| {
        let n = noise(x, y);
        Rgb([n as u8, (n >> 8) as u8, (x * 255 / width) as u8])
    })
}

#[test]
fn texels_are_seen_as_they_are() {
    // One pixel a texel and four pixels a texel, between texels, over the seams, and in textures that are no powers of two.
    for (width, height, times, start) in [
        (SIZE, SIZE, 1.0, DVec2::ZERO),
        (SIZE, SIZE, 1.0, DVec2::new(0.3, 0.7) / f64::from(SIZE)),
        (SIZE / 2, SIZE / 3, 1.0, DVec2::new(-0.4, 7.55)),
        (64, 37, 0.5, DVec2::new(0.8, -3.9)),
    ] {
        let mut textured = Textured::new(&coloured(width, height), DVec2::ONE, start, DVec2::splat(times));
        let mut errors = Vec::new();
        for (pixel, got) in textured.see(&above(1.0)) {
            let error = got - textured.sample(textured.uv(pixel.point)).as_dvec3();
            errors.push((
                pixel.index,
                if error.max_element() > -error.min_element() { error.max_element() } else { error.min_element() },
            ));
        }
        assert_eq!(errors.len() as u32, SIZE * SIZE);
        let worst = errors.iter().map(|(_, e)| e.abs()).fold(0.0, f64::max);
        println!("{width} × {height} texels, {times} times: off by {:.3} % of white", worst * 100.0);
        if worst > EXACT {
            panic!("{worst}, see {}", leave_errors(&format!("texels {width} × {height}"), SIZE, EXACT, errors.into_iter()));
        }
    }
}

#[test]
fn from_afar_a_texture_is_its_mean() {
    let checks = RgbImage::from_fn(128, 128, |x, y| Rgb([if (x + y) % 2 == 0 { 255 } else { 0 }; 3]));
    // Whose last column and row would be lost by careless halving.
    let rim = RgbImage::from_fn(31, 29, |x, y| Rgb([if x == 30 || y == 28 { 255 } else { 0 }; 3]));
    for (name, image, least) in [("checks", &checks, 0.0), ("rim", &rim, 1.0), ("noise", &coloured(200, 123), 1.0)] {
        for texels in [4.0, 7.3, 31.0, 150.0, 1000.0] {
            // So many texels a pixel; where less than the whole image falls into one, only even images are their mean.
            let repeated = texels * f64::from(SIZE) / f64::from(image.width());
            if repeated < least * f64::from(SIZE) {
                continue;
            }
            let mut textured = Textured::new(image, DVec2::ONE, DVec2::new(0.1, 0.2), DVec2::splat(repeated));
            let mean = textured.mean();
            let seen = textured.see(&above(1.0));
            let worst = seen.iter().map(|(_, got)| ((got - mean).abs() / mean).max_element()).fold(0.0, f64::max);
            println!("{name}, {texels} texels a pixel: off its mean {:.3} by {:.3} % at most", mean.x, worst * 100.0);
            assert!(worst < 0.02, "{name}, {texels} texels a pixel: {worst}");
        }
    }
}

#[test]
fn a_texture_seen_at_a_grazing_angle_has_no_more_contrast_than_its_footprints() {
    let stripes = RgbImage::from_fn(128, 128, |x, y| Rgb([if (x / 4 + y / 4) % 2 == 0 { 240 } else { 20 }; 3]));
    for (name, image) in [("checks", &stripes), ("noise", &coloured(128, 96))] {
        // Two metres of texture each time, the eye 1 m over the plane, to the horizon.
        let mut textured = Textured::new(image, DVec2::splat(400.0), DVec2::ZERO, DVec2::splat(200.0));
        let view = View { eye: DVec3::new(0.3, -190.0, 1.0), target: DVec3::new(20.0, 0.0, 0.0), fov: 40.0 };
        let seen = textured.see(&view);
        let mean = textured.mean();
        let (mut far, mut worst_far, mut squares, mut bias, mut count) = (0, 0.0f64, 0.0, DVec3::ZERO, 0);
        let mut errors = Vec::new();
        for (pixel, got) in &seen {
            let distance = pixel.point.distance(view.eye);
            let expected = textured.footprint(&view, pixel, 12);
            let error = *got - expected;
            if distance > 100.0 {
                // Pixels reach over more than a repetition: nothing is left but the mean.
                far += 1;
                worst_far = worst_far.max(((*got - mean).abs() / mean).max_element());
            } else {
                count += 1;
                squares += error.length_squared() / 3.0;
                bias += error;
            }
            errors.push((pixel.index, error.x));
        }
        let (rms, bias) = ((squares / f64::from(count)).sqrt(), (bias / f64::from(count) / mean).abs().max_element());
        println!(
            "{name}, grazing: off the footprints by {rms:.4} RMS, {:.3} % on the whole; {far} far pixels off the mean by {:.3} %",
            bias * 100.0,
            worst_far * 100.0
        );
        if !(far > 200 && worst_far < 0.02 && bias < 0.02 && rms < 0.04) {
            panic!("{name}, see {}", leave_errors(&format!("grazing {name}"), SIZE, 0.1, errors.into_iter()));
        }
    }
}
