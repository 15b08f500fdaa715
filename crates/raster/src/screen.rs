//! A window's surface: where pictures are shown. What draws into it is the same device, found by the same rules, as without a window.

use crate::device::{Device, RasterError, instance};
use std::{fmt::Debug, sync::Arc};
use wgpu::{CurrentSurfaceTexture, TextureFormat, rwh::HasDisplayHandle};

/// The surface of one window.
#[derive(Debug)]
pub struct Screen {
    surface: wgpu::Surface<'static>,
    configuration: wgpu::SurfaceConfiguration,
    /// A side is 0: there is nothing to draw into.
    minimised: bool,
}

/// Pictures are sRGB already: a format that encodes them once more is the last choice, as is one of linear half floats.
fn format(offered: &[TextureFormat]) -> Option<TextureFormat> {
    let wanted = [TextureFormat::Bgra8Unorm, TextureFormat::Rgba8Unorm, TextureFormat::Rgb10a2Unorm];
    wanted.into_iter().find(|format| offered.contains(format)).or(offered.first().copied())
}

impl Screen {
    /// The surface of a window of `size` pixels, for instance of an `Arc<winit::window::Window>`, and the device that draws into it.
    /// `WGPU_BACKEND` and `WGPU_ADAPTER_NAME` choose as in [`Device::headless`].
    pub fn new<W>(target: W, size: [u32; 2]) -> Result<(Arc<Device>, Screen), RasterError>
    where
        W: Into<wgpu::SurfaceTarget<'static>> + HasDisplayHandle + Clone + Debug + Send + Sync + 'static,
    {
        // OpenGL must know the display before there is a surface.
        let (instance, backends) = instance(Some(Box::new(target.clone())));
        let surface = match instance.create_surface(target) {
            Ok(surface) => surface,
            Err(e) => {
                // Without a driver that is the reason, not the window.
                pollster::block_on(Device::find(&instance, backends, None))?;
                return Err(RasterError::Window(e.to_string()));
            }
        };
        let (device, adapter) = pollster::block_on(Device::find(&instance, backends, Some(&surface)))?;
        let offered = surface.get_capabilities(&adapter);
        let format = format(&offered.formats).ok_or_else(|| RasterError::Window(format!("{} offers no format", device.name)))?;
        // The newest picture at the next refresh, and no waiting for it; or in turn, which all drivers have.
        let mailbox = offered.present_modes.contains(&wgpu::PresentMode::Mailbox);
        let configuration = wgpu::SurfaceConfiguration {
            // What need not be drawn anew can then be copied.
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | (offered.usages & wgpu::TextureUsages::COPY_DST),
            format,
            color_space: wgpu::SurfaceColorSpace::Auto,
            width: 1,
            height: 1,
            present_mode: if mailbox { wgpu::PresentMode::Mailbox } else { wgpu::PresentMode::Fifo },
            desired_maximum_frame_latency: 1,
            alpha_mode: wgpu::CompositeAlphaMode::Auto,
            view_formats: Vec::new(),
        };
        let mut screen = Screen { surface, configuration, minimised: false };
        let [width, height] = size.map(|side| side.clamp(1, device.largest_side()));
        (screen.configuration.width, screen.configuration.height) = (width, height);
        screen.minimised = size.contains(&0);
        screen.surface.configure(&device.device, &screen.configuration);
        device.check()?;
        Ok((Arc::new(device), screen))
    }

    /// What its textures are made of, for pipelines that draw into them.
    pub fn format(&self) -> TextureFormat {
        self.configuration.format
    }

    /// Whether other textures can be copied into its own.
    pub fn takes_copies(&self) -> bool {
        self.configuration.usage.contains(wgpu::TextureUsages::COPY_DST)
    }

    /// Pixels; at least 1 even where the window has none.
    pub fn size(&self) -> [u32; 2] {
        [self.configuration.width, self.configuration.height]
    }

    /// The window now has so many pixels. Where a side is 0, as when it is minimised, [`frame`](Self::frame) has nothing to draw into. No
    /// texture of it may be held.
    pub fn resize(&mut self, device: &Device, size: [u32; 2]) {
        self.minimised = size.contains(&0);
        let size = size.map(|side| side.clamp(1, device.largest_side()));
        if !self.minimised && size != self.size() {
            [self.configuration.width, self.configuration.height] = size;
            self.surface.configure(&device.device, &self.configuration);
        }
    }

    /// What the next picture is drawn into, to be given to [`present`](Self::present) after that was submitted. `None` if the window
    /// cannot be drawn into just now. After [`RasterError::Lost`], device, screen and renderer are to be made anew.
    pub fn frame(&self, device: &Device) -> Result<Option<wgpu::SurfaceTexture>, RasterError> {
        device.check()?;
        if self.minimised {
            return Ok(None);
        }
        let mut got = self.surface.get_current_texture();
        if matches!(got, CurrentSurfaceTexture::Outdated | CurrentSurfaceTexture::Lost) {
            self.surface.configure(&device.device, &self.configuration);
            got = self.surface.get_current_texture();
        }
        let why = match got {
            CurrentSurfaceTexture::Success(texture) | CurrentSurfaceTexture::Suboptimal(texture) => return Ok(Some(texture)),
            CurrentSurfaceTexture::Timeout | CurrentSurfaceTexture::Occluded | CurrentSurfaceTexture::Outdated => {
                return Ok(None);
            }
            CurrentSurfaceTexture::Lost => "the window's surface is gone",
            CurrentSurfaceTexture::Validation => "the window's surface gave no texture",
        };
        // Where the device has gone, that is why; it may not have been told yet.
        device.wait()?;
        Err(RasterError::Lost(why.into()))
    }

    /// Shows what was drawn into a texture of [`frame`](Self::frame).
    pub fn present(&self, device: &Device, texture: wgpu::SurfaceTexture) {
        device.queue.present(texture);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_that_take_srgb_as_it_is_come_first() {
        let usual = [TextureFormat::Bgra8UnormSrgb, TextureFormat::Rgba16Float, TextureFormat::Bgra8Unorm];
        assert_eq!(format(&usual), Some(TextureFormat::Bgra8Unorm));
        assert_eq!(format(&usual[..2]), Some(TextureFormat::Bgra8UnormSrgb));
        assert_eq!(format(&[]), None);
    }
}
