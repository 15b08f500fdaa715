//! Threshold elevations on disk, by the content that they were made of: a texture is looked at once, not at every start.

use crate::{
    bands::Luminance,
    masking::{Masking, MeshLimit},
};
use etcetera::{BaseStrategy, choose_base_strategy};
use lightmend_scene::format::write_atomically;
use std::{
    io::Write,
    path::{Path, PathBuf},
};

/// Changes whenever a formula or a constant does.
const VERSION: &str = "lightmend threshold elevation 1";

/// The user's folder for what can be made again; `None` where there is none.
pub fn cache_folder() -> Option<PathBuf> {
    Some(choose_base_strategy().ok()?.cache_dir().join("lightmend"))
}

impl Masking {
    /// As [`new`](Masking::new), from `folder` if it is known there; otherwise it is put there. A file that cannot be read or written, or
    /// is not whole, costs no more than the work.
    pub fn cached(picture: &Luminance, limit: MeshLimit, folder: Option<&Path>) -> Masking {
        let Some(folder) = folder else { return Masking::new(picture, limit) };
        let path = folder.join(format!("{}.masking", name(picture, limit)));
        let known = std::fs::read_to_string(&path).ok().and_then(|text| read(&text));
        known.unwrap_or_else(|| {
            let masking = Masking::new(picture, limit);
            if std::fs::create_dir_all(folder).is_ok() {
                // Without it the work is done again next time, and nothing else.
                let _ = write_atomically(&path, |file| file.write_all(written(&masking).as_bytes()));
            }
            masking
        })
    }
}

fn name(picture: &Luminance, limit: MeshLimit) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(VERSION.as_bytes());
    hasher.update(&(picture.width as u64).to_le_bytes());
    hasher.update(&limit.octave().to_le_bytes());
    picture.values.iter().for_each(|value| {
        hasher.update(&value.to_le_bytes());
    });
    hasher.finalize().to_hex().to_string()
}

fn written(masking: &Masking) -> String {
    let levels: Vec<String> = masking.levels.iter().map(|level| format!("{:08x}", level.to_bits())).collect();
    let levels = levels.join(" ");
    format!("{VERSION}\n{levels}\n{}\n", blake3::hash(levels.as_bytes()).to_hex())
}

fn read(text: &str) -> Option<Masking> {
    let [version, levels, hash] = text.lines().collect::<Vec<_>>().try_into().ok()?;
    (version == VERSION && blake3::hash(levels.as_bytes()).to_hex().as_str() == hash).then_some(())?;
    let level = |level| Some(f32::from_bits(u32::from_str_radix(level, 16).ok()?));
    Some(Masking { levels: levels.split(' ').map(level).collect::<Option<_>>()? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bands::tests::gratings;

    #[test]
    fn what_is_cached_is_what_was_made_and_damage_is_mended() {
        let folder = tempfile::tempdir().unwrap();
        let inside = folder.path().join("not there yet");
        let (picture, limit) = (gratings(32, 32, &[(3.0, 2.0, 0.5)]), MeshLimit::of_cells(1.0));
        let right = Masking::new(&picture, limit);
        assert_eq!(Masking::cached(&picture, limit, None), right);
        assert_eq!(Masking::cached(&picture, limit, Some(&inside)), right);
        let file = std::fs::read_dir(&inside).unwrap().next().unwrap().unwrap().path();
        let whole = std::fs::read_to_string(&file).unwrap();
        // It is read and not made again: another table under the same name comes back.
        let other = Masking { levels: vec![2.0; 3] };
        std::fs::write(&file, written(&other)).unwrap();
        assert_eq!(Masking::cached(&picture, limit, Some(&inside)), other);
        for damaged in ["", &whole[..40], &whole.replace(' ', "  "), &whole.replacen("3f", "40", 1)] {
            std::fs::write(&file, damaged).unwrap();
            assert_eq!(Masking::cached(&picture, limit, Some(&inside)), right);
            assert_eq!(std::fs::read_to_string(&file).unwrap(), whole, "mended");
        }
        // A folder that cannot be made is no obstacle.
        assert_eq!(Masking::cached(&picture, limit, Some(&file.join("below"))), right);
        let names = [name(&picture, limit), name(&picture, MeshLimit::of_cells(2.0)), name(&gratings(32, 32, &[]), limit)];
        assert!(names[0] != names[1] && names[0] != names[2]);
    }
}
