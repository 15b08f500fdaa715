//! Long lists that pixels look things up in: texels of a two-dimensional texture, row by row.
//!
//! Storage buffers would read plainer. But lavapipe fetches them one number and one pixel at a time, which took two thirds of composition;
//! texels it gathers for eight pixels at once. On graphics cards there is no difference. `frame.wgsl` (`entry`) is the other half.

use crate::device::{Device, RasterError};
use wgpu::{TextureFormat, TextureUsages};

/// Entries in a row; the same in `frame.wgsl`.
const WIDTH: u32 = 2048;

/// A list on the device.
pub struct Table {
    texture: wgpu::Texture,
    /// To be bound.
    pub view: wgpu::TextureView,
}

impl Table {
    /// With room for so many entries, which are 0 at first.
    pub fn new(device: &Device, what: &'static str, entries: u64, format: TextureFormat) -> Result<Table, RasterError> {
        let rows = entries.div_ceil(u64::from(WIDTH)).max(1);
        let bytes = |rows: u64| rows * u64::from(WIDTH) * u64::from(format.block_copy_size(None).unwrap_or(4));
        let most = u64::from(device.largest_side());
        if rows > most {
            return Err(RasterError::TooLarge { what, bytes: bytes(rows), most: bytes(most), driver: device.name.clone() });
        }
        let texture = device.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(what),
            size: wgpu::Extent3d { width: WIDTH, height: rows as u32, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Ok(Table { texture, view })
    }

    /// How many entries a list can have.
    pub fn most(device: &Device) -> u64 {
        u64::from(WIDTH) * u64::from(device.largest_side())
    }

    /// With this content.
    pub fn filled<T: bytemuck::NoUninit>(
        device: &Device,
        what: &'static str,
        content: &[T],
        format: TextureFormat,
    ) -> Result<Table, RasterError> {
        let content: &[u8] = bytemuck::cast_slice(content);
        let entry = format.block_copy_size(None).unwrap_or(4);
        let table = Table::new(device, what, content.len() as u64 / u64::from(entry), format)?;
        table.write(device, 0, content);
        Ok(table)
    }

    /// How many entries it has room for.
    pub fn entries(&self) -> u64 {
        u64::from(self.texture.height()) * u64::from(WIDTH)
    }

    /// Writes entries from number `first` on.
    pub fn write(&self, device: &Device, mut first: u64, mut content: &[u8]) {
        let entry = self.texture.format().block_copy_size(None).unwrap_or(4);
        while !content.is_empty() {
            let count = content.len() as u64 / u64::from(entry);
            let (row, column) = ((first / u64::from(WIDTH)) as u32, (first % u64::from(WIDTH)) as u32);
            // A beginning or an end of a row, or as many whole rows as there are.
            let (width, height) = if column == 0 && count >= u64::from(WIDTH) {
                (WIDTH, (count / u64::from(WIDTH)) as u32)
            } else {
                (count.min(u64::from(WIDTH - column)) as u32, 1)
            };
            let (now, later) = content.split_at((width * height * entry) as usize);
            device.queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture: &self.texture,
                    mip_level: 0,
                    origin: wgpu::Origin3d { x: column, y: row, z: 0 },
                    aspect: wgpu::TextureAspect::All,
                },
                now,
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * entry), rows_per_image: Some(height) },
                wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            );
            first += u64::from(width) * u64::from(height);
            content = later;
        }
    }
}
