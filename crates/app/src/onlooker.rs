//! Whether anyone who looks from a camera could notice how far the light is from what it will be.
//!
//! An error could be noticed in a pixel if its luminance is off by more than the step that is just seen on a plain surface
//! (Ward Larson et al. 1997) times the threshold elevation of the texture there. The light is the indirect one as frames show it,
//! reconstructed, each pixel in the colour of its element. The eye is taken to be adapted to the indirect light of the pixel alone: direct light would only hide more.
//! The light is complete for the eye when errors could be noticed in no more than [`TOLERATED`] of the pixels.

use crate::{failure::Failure, figure, indirect::IndirectLight, masking::Maskings};
use lightmend_perception::threshold_step;
use lightmend_photon::{bucket::Buckets, irradiance::Scale, ledger::Pending, visible::Visible, world::World};
use lightmend_scene::{Configuration, View, luminance};

/// Share of the picture's pixels in which an error may be noticed that counts as none.
pub const TOLERATED: f64 = 1e-3;

/// The same while what is to come is only foreseen, at two looks in a row: at one look alone more than tolerated was left in two of 42 repairs. Lower: said later.
pub const TOLERATED_FORESEEN: f64 = TOLERATED / 2.0;

/// Somebody who looks from a camera.
pub struct Onlooker {
    visible: Visible,
    /// Of the threshold, by what is seen.
    elevations: Vec<f64>,
    /// Objects that are seen, by number.
    objects: Vec<bool>,
}

impl Onlooker {
    /// Looks at `world`.
    pub fn new(world: &World, view: &View, maskings: &mut Maskings) -> Onlooker {
        let configuration = world.configuration();
        let visible = Visible::new(world, view);
        let mut objects = vec![false; configuration.object_slots()];
        visible.seen().for_each(|seen| objects[seen.object] = true);
        let elevations = visible
            .seen()
            .map(|seen| maskings.elevation(configuration.object(seen.object), seen.triangle, seen.footprint))
            .collect();
        Onlooker { visible, elevations, objects }
    }

    /// What is seen.
    pub fn visible(&self) -> &Visible {
        &self.visible
    }

    /// Luminance of what is seen, candela per m², in the order of [`Visible::seen`].
    pub fn luminances(&self, irradiance: &[[f32; 3]]) -> Vec<f64> {
        self.visible.radiance(irradiance).iter().map(|radiance| luminance(radiance.as_dvec3())).collect()
    }

    /// The same, of light as frames show it.
    pub fn shown(&self, reader: &mut IndirectLight, configuration: &Configuration, light: &Buckets, scale: &Scale) -> Vec<f64> {
        let light = reader.reconstruct_some(configuration, light, scale, |object| self.objects.get(object) == Some(&true));
        self.luminances(&self.visible.values_by(|object, cell, side| light.cell(object, cell, side).value))
    }

    /// Share of the pixels in which one could notice that luminances are `now` and not `right`.
    pub fn noticed(&self, now: &[f64], right: &[f64]) -> f64 {
        let (width, height, pixels) = self.visible.picture();
        let off = |seen: &usize| self.excess(now, right, *seen) > 1.0;
        pixels.flatten().filter(off).count() as f64 / f64::from(width * height)
    }

    /// The same of what a repair will still change of `light`, of which `now` is [shown](Self::shown), as foreseen; `None`
    /// as long as less was repaired than is left.
    pub fn foreseen(
        &self,
        reader: &mut IndirectLight,
        configuration: &Configuration,
        (light, now, pending): (&Buckets, &[f64], &Pending),
        scale: &Scale,
    ) -> Option<f64> {
        // Of more than was repaired too little is known.
        if pending.ratio() > 1.0 {
            return None;
        }
        let then = pending.draw(light, |object| self.objects.get(object) == Some(&true));
        Some(self.noticed(now, &self.shown(reader, configuration, &then, scale)))
    }

    /// The difference in multiples of the one that is just noticed.
    fn excess(&self, now: &[f64], right: &[f64], seen: usize) -> f64 {
        (now[seen] - right[seen]).abs() / self.threshold(right, seen)
    }

    fn threshold(&self, right: &[f64], seen: usize) -> f64 {
        threshold_step(right[seen]) * self.elevations[seen]
    }

    /// Two maps beside each other: the difference from `right` that could be noticed, black none and white as much as there is; and the
    /// difference of `now`, white as large as could be noticed, red above.
    pub fn map(&self, now: &[f64], right: &[f64]) -> Result<image::RgbImage, Failure> {
        let (width, height, pixels) = self.visible.picture();
        let pixels: Vec<Option<usize>> = pixels.collect();
        let grey = |share: f64| image::Rgb([(share.clamp(0.0, 1.0) * 255.0).round() as u8; 3]);
        let pixel = |x: u32, y: u32| {
            if y >= height {
                return image::Rgb([255; 3]);
            }
            match pixels[(y * width + x % width) as usize] {
                None => image::Rgb([0; 3]),
                Some(seen) if x < width => grey(self.threshold(right, seen) / right[seen].max(1e-30)),
                Some(seen) => match self.excess(now, right, seen) {
                    excess if excess > 1.0 => image::Rgb([255, 40, 40]),
                    excess => grey(excess),
                },
            }
        };
        let notes = [
            ("just noticed ÷ luminance, white: 1".to_owned(), [4, height + 4]),
            (format!("red: could be noticed, {:.2} %", self.noticed(now, right) * 100.0), [width + 4, height + 4]),
        ];
        figure::with_text(image::RgbImage::from_fn(2 * width, height + 24, pixel), &notes)
    }
}
