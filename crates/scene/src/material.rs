//! Diffuse materials, plain or textured.

use glam::Vec3;
use image::ImageReader;
use std::{io::Cursor, path::Path, sync::Arc};

use crate::{SceneError, format::MaterialEntry};

/// A diffuse material; both sides of a surface reflect.
#[derive(Debug, Clone)]
pub struct Material {
    /// Its name in the scene or MTL file.
    pub name: String,
    /// Reflectance per linear Rec. 709 channel, 0 to 1; multiplies the texture.
    pub reflectance: Vec3,
    /// An image over the surface.
    pub texture: Option<Arc<Texture>>,
    /// Its file, relative to the scene's folder.
    pub texture_path: Option<String>,
}

impl PartialEq for Material {
    fn eq(&self, other: &Self) -> bool {
        let textures = match (&self.texture, &other.texture) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b) || a == b,
            (a, b) => a.is_none() && b.is_none(),
        };
        self.name == other.name && self.reflectance == other.reflectance && textures
    }
}

impl Material {
    /// What a scene file says of it.
    pub(crate) fn stated(&self) -> MaterialEntry {
        MaterialEntry { reflectance: self.reflectance.as_dvec3(), texture: self.texture_path.clone() }
    }
}

/// An sRGB image, repeated over the plane; read in linear light.
#[derive(Debug, PartialEq)]
pub struct Texture {
    width: u32,
    height: u32,
    /// sRGB bytes, row by row from the top.
    texels: Vec<[u8; 3]>,
    linear: Box<[f32; 256]>,
}

impl Texture {
    /// Reads a PNG or JPEG.
    pub fn read(path: &Path) -> Result<Texture, SceneError> {
        let bytes = std::fs::read(path).map_err(|e| SceneError::read(path, e))?;
        let image = ImageReader::new(Cursor::new(bytes))
            .with_guessed_format()
            .map_err(|e| SceneError::read(path, e))?
            .decode()
            .map_err(|e| SceneError::content(path, format!("not a readable PNG or JPEG: {e}")))?
            .into_rgb8();
        let (width, height) = image.dimensions();
        if width == 0 || height == 0 {
            return Err(SceneError::content(path, "the image is empty"));
        }
        let linear = std::array::from_fn(|i| srgb_to_linear(i as f64 / 255.0) as f32);
        Ok(Texture { width, height, texels: image.pixels().map(|p| p.0).collect(), linear: Box::new(linear) })
    }

    /// The image as numbers, for hashing.
    pub(crate) fn numbers(&self, take: &mut impl FnMut(&[f64])) {
        take(&[f64::from(self.width), f64::from(self.height)]);
        self.texels.iter().for_each(|texel| take(&texel.map(f64::from)));
    }

    /// Width and height, texels.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// All texels in linear light, row by row from the top.
    pub fn linear(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.texels.iter().map(|texel| Vec3::from_array(texel.map(|b| self.linear[b as usize])))
    }

    /// Bilinear, in linear light; (0, 0) is the lower left corner of the image.
    pub fn sample(&self, [u, v]: [f32; 2]) -> Vec3 {
        let x = u.rem_euclid(1.0) * self.width as f32 - 0.5;
        let y = (1.0 - v).rem_euclid(1.0) * self.height as f32 - 0.5;
        let (x0, y0) = (x.floor(), y.floor());
        let texel = |dx: i64, dy: i64| {
            let column = (x0 as i64 + dx).rem_euclid(i64::from(self.width)) as usize;
            let row = (y0 as i64 + dy).rem_euclid(i64::from(self.height)) as usize;
            Vec3::from_array(self.texels[row * self.width as usize + column].map(|b| self.linear[b as usize]))
        };
        let (fx, fy) = (x - x0, y - y0);
        let top = texel(0, 0) * (1.0 - fx) + texel(1, 0) * fx;
        let bottom = texel(0, 1) * (1.0 - fx) + texel(1, 1) * fx;
        top * (1.0 - fy) + bottom * fy
    }
}

/// The sRGB transfer function (IEC 61966-2-1), 0 to 1.
pub fn srgb_to_linear(s: f64) -> f64 {
    if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_are_read_in_linear_light_from_the_lower_left() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("two.png");
        // Above: white. Below: sRGB 188, which is half in linear light.
        image::RgbImage::from_fn(2, 2, |_, y| image::Rgb(if y == 0 { [255; 3] } else { [188; 3] })).save(&path).unwrap();
        let texture = Texture::read(&path).unwrap();
        assert!((texture.sample([0.5, 0.25]).x - 0.5028).abs() < 1e-3);
        assert_eq!(texture.sample([0.5, 0.75]), Vec3::ONE);
        assert_eq!(texture.sample([7.5, -0.25]), Vec3::ONE, "repeats");
    }
}
