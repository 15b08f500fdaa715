//! What is drawn into: sample by sample depth and stencil, triangle numbers, masks and light; pixel by pixel the picture.

use crate::device::{Device, RasterError};
use wgpu::{TextureFormat, TextureUsages};

/// Reversed depth, and the stencil that counts shadow volumes.
pub const DEPTH: TextureFormat = TextureFormat::Depth32FloatStencil8;
/// Number of the triangle seen, and one; 0 for none.
pub const IDS: TextureFormat = TextureFormat::R32Uint;
/// Four lamps to a layer: 1 where lit.
pub const MASKS: TextureFormat = TextureFormat::Rgba8Unorm;
/// Linear light. Not half floats: candela near a lamp exceed their range.
pub const LIGHT: TextureFormat = TextureFormat::Rgba32Float;
/// sRGB.
pub const PICTURE: TextureFormat = TextureFormat::Rgba8Unorm;

/// The textures of one size of picture.
pub struct Targets {
    /// Pixels.
    pub size: [u32; 2],
    /// Samples along each side of a pixel.
    pub grid: u32,
    /// Layers of masks.
    pub mask_layers: u32,
    /// [`DEPTH`].
    pub depth: wgpu::Texture,
    /// [`IDS`].
    pub ids: wgpu::Texture,
    /// [`MASKS`].
    pub masks: wgpu::Texture,
    /// [`LIGHT`].
    pub light: wgpu::Texture,
    /// [`PICTURE`].
    pub picture: wgpu::Texture,
    /// Exposure, then what it is measured from.
    pub tiles: wgpu::Buffer,
}

impl Targets {
    /// For a picture of `size` pixels with `grid`² samples each and so many lamps; refuses what the driver cannot hold.
    pub fn new(device: &Device, size: [u32; 2], grid: u32, lamps: usize) -> Result<Targets, RasterError> {
        let most = device.largest_side();
        let [width, height] = size;
        let fits = |side: u32| side > 0 && grid > 0 && side.checked_mul(grid).is_some_and(|samples| samples <= most);
        if !(fits(width) && fits(height)) {
            return Err(RasterError::Size { width, height, grid, most: most / grid.max(1) });
        }
        let samples = [width * grid, height * grid];
        let mask_layers = lamps.div_ceil(4) as u32;
        let texture = |label: &str, [width, height]: [u32; 2], layers: u32, format: TextureFormat| {
            let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC;
            device.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: if format == DEPTH { TextureUsages::RENDER_ATTACHMENT } else { usage },
                view_formats: &[],
            })
        };
        // Without lamps there is no mask: one texel stands in for it.
        let mask_size = if mask_layers == 0 { [1, 1] } else { samples };
        let tiles = samples.map(|s| u64::from(s.div_ceil(16)));
        Ok(Targets {
            size,
            grid,
            mask_layers,
            depth: texture("depth", samples, 1, DEPTH),
            ids: texture("triangle numbers", samples, 1, IDS),
            masks: texture("masks", mask_size, mask_layers.max(1), MASKS),
            light: texture("light", samples, 1, LIGHT),
            picture: texture("picture", size, 1, PICTURE),
            tiles: device.buffer(
                "exposure",
                (1 + tiles[0] * tiles[1]) * 8,
                wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            )?,
        })
    }

    /// Whether they are for this picture.
    pub fn fit(&self, size: [u32; 2], grid: u32, lamps: usize) -> bool {
        (self.size, self.grid, self.mask_layers) == (size, grid, lamps.div_ceil(4) as u32)
    }

    /// Samples.
    pub fn samples(&self) -> [u32; 2] {
        self.size.map(|pixels| pixels * self.grid)
    }
}

/// The bytes of one layer of a texture, row by row from the top.
pub fn read(device: &Device, texture: &wgpu::Texture, layer: u32) -> Result<Vec<u8>, RasterError> {
    let (width, height) = (texture.width(), texture.height());
    // All our colour formats have one block a texel.
    let texel = texture.format().block_copy_size(None).unwrap_or(4);
    let pitch = (width * texel).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let size = u64::from(pitch) * u64::from(height);
    let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
    let most = device.device.limits().max_buffer_size;
    if size > most {
        return Err(RasterError::TooLarge { what: "reading the picture", bytes: size, most, driver: device.name.clone() });
    }
    let buffer =
        device.device.create_buffer(&wgpu::BufferDescriptor { label: Some("read"), size, usage, mapped_at_creation: false });
    let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
            aspect: wgpu::TextureAspect::All,
        },
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(pitch), rows_per_image: Some(height) },
        },
        wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
    );
    device.queue.submit([encoder.finish()]);
    let bytes = mapped(device, &buffer)?;
    Ok(bytes.chunks_exact(pitch as usize).flat_map(|row| &row[..(width * texel) as usize]).copied().collect())
}

/// The content of a buffer that can be mapped, once all that was submitted is done.
pub fn mapped(device: &Device, buffer: &wgpu::Buffer) -> Result<Vec<u8>, RasterError> {
    let (told, heard) = std::sync::mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // Nobody listens any more when the wait below has failed.
        let _ = told.send(result);
    });
    device.wait()?;
    // Another thread that shares the device may have been given our callback to run.
    match heard.recv() {
        Ok(Ok(())) => {}
        Ok(Err(e)) => return Err(RasterError::Lost(e.to_string())),
        Err(e) => return Err(RasterError::Lost(e.to_string())),
    }
    let view = buffer.get_mapped_range(..).map_err(|e| RasterError::Lost(e.to_string()))?;
    Ok(view.to_vec())
}
