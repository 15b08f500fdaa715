//! What is to be measured: scenes with their pools and their moves, all read and tried before any work.

use super::Arguments;
use crate::failure::Failure;
use lightmend_photon::{halton::INDEX_LIMIT, path::FirstHits, pool::Pool};
use lightmend_scene::{Moves, Scene, SceneError};
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

/// Direct light is the rasteriser's matter: errors are of indirect irradiance alone.
pub const FIRST_HITS: FirstHits = FirstHits::Never;

/// Photons of the reference per photon of the pool: its own error is then a quarter of the pool's.
const REFERENCE: u64 = 16;

/// A scene to measure.
pub struct Job {
    /// The scene.
    pub scene: Arc<Scene>,
    /// How its files are called.
    pub stem: String,
    /// Its photons.
    pub pool: Pool,
    /// Photons per pilot photon.
    pub ratio: u32,
    /// Photons of the reference of each state.
    pub reference_photons: u64,
    /// Moves and their names.
    pub scripts: Vec<(String, Moves)>,
}

/// Reads all scenes and moves.
pub fn read(arguments: &Arguments) -> Result<Vec<Job>, Failure> {
    let common = &arguments.common;
    let mut jobs: Vec<Job> = Vec::new();
    for file in &arguments.scenes {
        let scene = common.read_scene(file)?;
        let pool = arguments.pool.pool(&scene)?;
        let reference_photons = arguments.reference_photons.unwrap_or(pool.photons().saturating_mul(REFERENCE));
        if reference_photons < pool.photons() || reference_photons > 2 * INDEX_LIMIT {
            let (least, most) = (pool.photons(), 2 * INDEX_LIMIT);
            let what = format!("--reference-photons {reference_photons}: between the pool's {least} and {most} are possible");
            return Err(Failure::input(what));
        }
        let files = if arguments.script.is_empty() { own_moves(file)? } else { arguments.script.clone() };
        let mut scripts = Vec::new();
        for path in files {
            let (moves, warnings) = Moves::read(&path, &scene)?;
            common.warn(&warnings);
            scripts.push((unused(&stem(&path), |name| scripts.iter().any(|(known, _)| known == name)), moves));
        }
        let stem = unused(&plain(&scene.name), |name| jobs.iter().any(|job| job.stem == name));
        jobs.push(Job { scene, stem, pool, ratio: arguments.pool.r, reference_photons, scripts });
    }
    Ok(jobs)
}

/// The moves of a scene `NAME/NAME.ron`: those in `NAME/moves`, in order of their names; none of other scenes.
fn own_moves(scene: &Path) -> Result<Vec<PathBuf>, Failure> {
    let whole = std::path::absolute(scene).map_err(|e| SceneError::read(scene, e))?;
    let Some(folder) = whole.parent().filter(|folder| folder.file_name() == whole.file_stem()) else { return Ok(Vec::new()) };
    let folder = scene.parent().filter(|p| !p.as_os_str().is_empty()).map_or(folder.to_owned(), Path::to_owned).join("moves");
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let entries = std::fs::read_dir(&folder).map_err(|e| SceneError::read(&folder, e))?;
    let mut files = Vec::new();
    for entry in entries {
        files.push(entry.map_err(|e| SceneError::read(&folder, e))?.path());
    }
    files.retain(|path| path.extension().is_some_and(|e| e == "ron"));
    files.sort();
    Ok(files)
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "moves".to_owned(), |stem| plain(&stem.to_string_lossy()))
}

/// Where a file can be called so.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect()
}

/// A name that is not taken: itself, or with a number.
fn unused(name: &str, taken: impl Fn(&str) -> bool) -> String {
    let numbered = (2..).map(|n| format!("{name}_{n}"));
    std::iter::once(name.to_owned()).chain(numbered).find(|name| !taken(name)).unwrap_or_default()
}
