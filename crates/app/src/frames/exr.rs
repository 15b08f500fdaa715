//! Frames as OpenEXR: linear light in cd/m² per linear Rec. 709 channel, 32-bit floats.
//!
//! `R G B` is the radiance, `direct.*` and `indirect.*` its parts; `mask.LAMP` is 1 where that lamp is in sight. Names of lamps are UTF-8,
//! with `_` for a dot, which would begin a layer of its own; where two would be the same, a number follows.

use crate::{failure::Failure, output};
use exr::prelude::*;
use lightmend_raster::{Parts, Renderer, Settings};
use lightmend_scene::{Configuration, View};
use std::{io::Cursor, path::Path};

/// Draws `view` again, part by part, and writes what is read.
pub fn write(
    path: &Path,
    renderer: &mut Renderer,
    view: &View,
    settings: &Settings,
    configuration: &Configuration,
) -> std::result::Result<(), Failure> {
    let mut channels = SmallVec::<[AnyChannel<FlatSamples>; 4]>::new();
    let mut add = |name: String, samples: Vec<f32>| channels.push(AnyChannel::new(text(&name), FlatSamples::F32(samples)));
    for (prefix, parts) in [("direct.", Parts::DIRECT_RADIANCE), ("indirect.", Parts::INDIRECT_RADIANCE), ("", Parts::RADIANCE)] {
        renderer.draw(view, &Settings { parts, ..*settings })?;
        let samples = renderer.samples()?;
        for (c, name) in ["R", "G", "B"].iter().enumerate() {
            let channel = samples.iter().map(|s| s[c]).collect::<Vec<f32>>();
            add(format!("{prefix}{name}"), averaged(&channel, settings));
        }
    }
    let names = mask_names(renderer.drawn_lamps().map(|lamp| configuration.lamp(lamp).name.as_str()));
    for (n, name) in names.into_iter().enumerate() {
        let mask: Vec<f32> = renderer.mask(n)?.into_iter().map(|lit| f32::from(u8::from(lit))).collect();
        add(name, averaged(&mask, settings));
    }
    let size = (settings.width as usize, settings.height as usize);
    let image = Image::from_layer(Layer::new(
        size,
        LayerAttributes::named("radiance"),
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(channels),
    ));
    let mut bytes = Cursor::new(Vec::new());
    image.write().non_parallel().to_buffered(&mut bytes).map_err(|e| Failure::failed(format!("{}: {e}", path.display())))?;
    // The picture that a reader of the renderer expects is the one that was asked for.
    renderer.draw(view, settings)?;
    output::write(path, |file| std::io::Write::write_all(file, bytes.get_ref()))
}

/// The crate makes Latin-1 of `str`; the format's names are UTF-8.
fn text(name: &str) -> Text {
    Text::from_bytes_unchecked(name.bytes().collect())
}

/// Bytes of a lamp's name that are kept; the format allows 255 for a channel's.
const LONGEST: usize = 200;

/// A channel for each lamp.
fn mask_names<'a>(lamps: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for lamp in lamps {
        let short = &lamp[..lamp.floor_char_boundary(LONGEST)];
        let plain = format!("mask.{}", short.replace(|c: char| c == '.' || c.is_control(), "_"));
        let numbered = (2..).map(|n| format!("{plain}_{n}"));
        let free = std::iter::once(plain.clone()).chain(numbered).find(|n| !names.contains(n));
        names.extend(free);
    }
    names
}

/// The mean over the samples of each pixel.
fn averaged(samples: &[f32], settings: &Settings) -> Vec<f32> {
    let [grid, width, height] = [settings.grid, settings.width, settings.height].map(|n| n as usize);
    if grid == 1 {
        return samples.to_vec();
    }
    let pixel = |k: usize| {
        let (x, y) = (k % width * grid, k / width * grid);
        let rows = (y..y + grid).map(|row| &samples[row * width * grid + x..][..grid]);
        rows.flatten().sum::<f32>() / (grid * grid) as f32
    };
    (0..width * height).map(pixel).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_have_names_of_their_own() {
        let long = "ä".repeat(300);
        let names = mask_names(["a.b", "a_b", "a_b_2", "灯/1", &long].into_iter());
        assert_eq!(names[..4], ["mask.a_b", "mask.a_b_2", "mask.a_b_2_2", "mask.灯/1"]);
        assert_eq!(names[4].len(), "mask.".len() + LONGEST);
    }
}
