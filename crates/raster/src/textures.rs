//! Textures with mip maps, in linear light, in one buffer that every pixel can reach whichever textures it meets.
//!
//! A texel is the square roots of its linear values in 11, 11 and 10 bits: four bytes, and finer everywhere than the 8 bits of sRGB that
//! it comes from. Levels are means of 2 × 2 in linear light (Williams 1983). `composition.wgsl` (`texel`) is the other half.

use crate::frame::NONE;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use lightmend_scene::Texture;
use std::sync::Arc;

/// Where a texture lies among the texels.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct GpuTexture {
    first: u32,
    width: u32,
    height: u32,
    levels: u32,
}

/// All textures of a scene, each once.
#[derive(Debug, Default)]
pub struct Textures {
    known: Vec<Arc<Texture>>,
    /// Where they lie.
    pub entries: Vec<GpuTexture>,
    /// How often the finest level was left out, to fit.
    pub halvings: u32,
}

fn pack(linear: Vec3) -> u32 {
    let part = |x: f32, most: f32| (x.clamp(0.0, 1.0).sqrt() * most).round() as u32;
    part(linear.x, 2047.0) | part(linear.y, 2047.0) << 11 | part(linear.z, 1023.0) << 22
}

/// For each texel of a row of `to`, the texels of the finer row of `from` that it covers, and their shares.
fn shares(from: u32, to: u32) -> Vec<Vec<(u32, f32)>> {
    let covered = |x: u32| {
        // In units of 1 / `to` of a fine texel.
        let (low, high) = (x * from, (x + 1) * from);
        let share = move |k: u32| (k, (high.min((k + 1) * to) - low.max(k * to)) as f32 / from as f32);
        (low / to..high.div_ceil(to)).map(share).collect()
    };
    (0..to).map(covered).collect()
}

/// A level from the finer one: means of 2 × 2 texels, where their number is odd of the parts of 3 × 3 that a coarse texel covers, so that
/// the mean of the whole stays.
fn halved(width: u32, height: u32, fine: &[Vec3]) -> (u32, u32, Vec<Vec3>) {
    let (w, h) = ((width / 2).max(1), (height / 2).max(1));
    let (across, down) = (shares(width, w), shares(height, h));
    let row = |y: u32| &fine[(y * width) as usize..][..width as usize];
    let along = |y: u32, columns: &[(u32, f32)]| columns.iter().map(|(x, share)| row(y)[*x as usize] * *share).sum::<Vec3>();
    let texel = |rows: &[(u32, f32)], columns: &[(u32, f32)]| rows.iter().map(|(y, share)| along(*y, columns) * *share).sum();
    let texels = down.iter().flat_map(|rows| across.iter().map(move |columns| texel(rows, columns))).collect();
    (w, h, texels)
}

impl Textures {
    /// The textures of materials, each once.
    pub fn used<'a>(materials: impl Iterator<Item = &'a Arc<Texture>>) -> Vec<Arc<Texture>> {
        let mut used: Vec<Arc<Texture>> = Vec::new();
        for texture in materials {
            if !used.iter().any(|t| Arc::ptr_eq(t, texture)) {
                used.push(texture.clone());
            }
        }
        used
    }

    /// These textures, and all their texels; the finest levels of the last ones are left out while all would have more than `most`.
    pub fn new(used: Vec<Arc<Texture>>, most: usize) -> (Textures, Vec<u32>) {
        let (mut entries, mut texels, mut halvings) = (Vec::new(), Vec::new(), 0);
        for texture in &used {
            let [mut width, mut height] = texture.size();
            let mut level: Vec<Vec3> = texture.linear().collect();
            while texels.len() + level.len() * 4 / 3 + 32 > most && level.len() > 1 {
                (width, height, level) = halved(width, height, &level);
                halvings += 1;
            }
            let mut entry = GpuTexture { first: texels.len() as u32, width, height, levels: 1 };
            texels.extend(level.iter().copied().map(pack));
            while width.max(height) > 1 {
                (width, height, level) = halved(width, height, &level);
                texels.extend(level.iter().copied().map(pack));
                entry.levels += 1;
            }
            entries.push(entry);
        }
        (Textures { known: used, entries, halvings }, texels)
    }

    /// Whether they are these, in this order.
    pub fn are(&self, used: &[Arc<Texture>]) -> bool {
        self.known.len() == used.len() && self.known.iter().zip(used).all(|(a, b)| Arc::ptr_eq(a, b))
    }

    /// The number of one of them.
    pub fn number(&self, texture: &Arc<Texture>) -> u32 {
        self.known.iter().position(|t| Arc::ptr_eq(t, texture)).map_or(NONE, |number| number as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_means_in_linear_light() {
        let fine = vec![Vec3::ZERO, Vec3::ONE, Vec3::ONE, Vec3::ONE, Vec3::ZERO, Vec3::ZERO];
        let (w, h, mean) = halved(3, 2, &fine);
        assert_eq!((w, h), (1, 1));
        assert_eq!(mean[0], Vec3::splat(0.5));
        // Of odd sizes nothing is left out.
        let fine: Vec<Vec3> = (0..35).map(|k| Vec3::splat(if k % 7 == 6 || k > 27 { 1.0 } else { 0.0 })).collect();
        let (w, h, coarse) = halved(7, 5, &fine);
        assert_eq!((w, h), (3, 2));
        assert!((coarse.iter().map(|t| t.x).sum::<f32>() / 6.0 - 11.0 / 35.0).abs() < 1e-6);
        assert_eq!(halved(1, 3, &fine[4..7]).2, [Vec3::splat(1.0 / 3.0)]);
    }

    #[test]
    fn packing_is_finer_than_srgb() {
        for byte in 0..=255u32 {
            let linear = lightmend_scene::srgb_to_linear(f64::from(byte) / 255.0) as f32;
            let step = lightmend_scene::srgb_to_linear(f64::from(byte + 1) / 255.0) as f32 - linear;
            let packed = pack(Vec3::splat(linear));
            let red = (packed & 2047) as f32 / 2047.0;
            let blue = (packed >> 22) as f32 / 1023.0;
            assert!((red * red - linear).abs() < 0.3 * step && (blue * blue - linear).abs() < 0.6 * step, "{byte}");
        }
    }
}
