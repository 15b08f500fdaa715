//! How much the error shows: mean FLIP of the frame that the first camera sees, against that lit by the reference.

use crate::{Common, failure::Failure, indirect::IndirectLight};
use lightmend_perception::compare;
use lightmend_photon::{accuracy::Reference, bucket::Buckets, irradiance::Scale, world::World};
use lightmend_raster::{Device, Look, Parts, RasterError, Renderer, Settings};
use lightmend_scene::{Direct, View};

const WIDTH: u32 = 640;
const HEIGHT: u32 = 480;

/// A renderer; without a device that can draw, a warning and none.
pub fn renderer(common: &Common) -> Option<Renderer> {
    let made = Device::headless().and_then(|device| Renderer::new(device.into()));
    made.map_err(|e| {
        if !common.quiet {
            eprintln!("warning: {e}: FLIP of frames is left out");
        }
    })
    .ok()
}

/// Frames of one state.
pub struct Frames<'a> {
    renderer: &'a mut Renderer,
    world: &'a World,
    view: View,
    settings: Settings,
    right: image::RgbImage,
}

impl<'a> Frames<'a> {
    /// Draws the frame that the reference lights; its exposure is that of all others. `None` if photons draw the direct light of a
    /// lamp, which is not in the buckets that are measured.
    pub fn new(
        renderer: &'a mut Renderer,
        world: &'a World,
        view: View,
        reference: &Reference,
        reader: &mut IndirectLight,
    ) -> Result<Option<Frames<'a>>, Failure> {
        let configuration = world.configuration();
        if configuration.lamps().any(|(_, lamp)| lamp.direct == Direct::Photons) {
            return Ok(None);
        }
        renderer.show(configuration)?;
        let look = Look::Photograph { exposure: None };
        let settings = Settings { width: WIDTH, height: HEIGHT, grid: 1, parts: Parts::RADIANCE, look };
        let right = image::RgbImage::new(WIDTH, HEIGHT);
        let mut frames = Frames { renderer, world, view, settings, right };
        let scale = Scale::new(world, reference.photons);
        frames.draw(reader, &reference.buckets, &scale)?;
        let exposure = frames.renderer.exposure()?;
        frames.settings.look = Look::Photograph { exposure: Some(exposure) };
        frames.right = frames.draw(reader, &reference.buckets, &scale)?;
        Ok(Some(frames))
    }

    /// Mean FLIP of the frame that this light lights.
    pub fn flip(&mut self, reader: &mut IndirectLight, light: &Buckets, scale: &Scale) -> Result<f64, Failure> {
        let picture = self.draw(reader, light, scale)?;
        Ok(compare(&self.right, &picture).map_err(Failure::failed)?.mean)
    }

    fn draw(&mut self, reader: &mut IndirectLight, light: &Buckets, scale: &Scale) -> Result<image::RgbImage, Failure> {
        let configuration = self.world.configuration();
        let indirect = reader.read(configuration, light, scale, configuration.lamp_slots());
        let drawn: Result<Vec<[u8; 3]>, RasterError> = (|| {
            self.renderer.light(&indirect)?;
            self.renderer.draw(&self.view, &self.settings)?;
            self.renderer.finish()?;
            self.renderer.picture()
        })();
        let picture = image::RgbImage::from_raw(WIDTH, HEIGHT, drawn?.into_flattened());
        picture.ok_or_else(|| Failure::failed("the frame has no pixels"))
    }
}
