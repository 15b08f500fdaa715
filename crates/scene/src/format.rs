//! Scene files as they are typed: RON, before anything is checked against anything else.

use crate::{Direct, SceneError, View, load::own_name};
use glam::DVec3;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::{
    collections::BTreeMap,
    io::Write,
    path::{Component, Path, PathBuf},
};

/// Which axis points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Up {
    /// +y.
    Y,
    /// +z.
    Z,
}

impl Up {
    /// Unit, upwards.
    pub fn axis(self) -> DVec3 {
        match self {
            Up::Y => DVec3::Y,
            Up::Z => DVec3::Z,
        }
    }
}

/// A scene file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// The scene's name.
    pub name: String,
    /// Its up axis.
    pub up: Up,
    /// Longest edge of a mesh element, metres.
    pub cell: f64,
    /// See [`crate::Configuration::reach`]; written where fixed objects were added or removed, so that photons' paths stay the same.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reach: Option<f64>,
    /// Where positions count from, metres. The loader sets it where a scene lies so far from the origin that rays in single precision would miss.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub origin: DVec3,
    /// Materials by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub materials: BTreeMap<String, MaterialEntry>,
    /// Objects.
    pub objects: Vec<ObjectEntry>,
    /// Lamps.
    #[serde(default)]
    pub lamps: Vec<LampEntry>,
    /// Cameras.
    #[serde(default)]
    pub cameras: Vec<CameraEntry>,
}

/// A material of a scene file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialEntry {
    /// Linear Rec. 709, 0 to 1.
    pub reflectance: DVec3,
    /// An image that multiplies it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub texture: Option<String>,
}

/// An object of a scene file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectEntry {
    /// Unique name.
    pub name: String,
    /// OBJ file.
    pub mesh: String,
    /// One part of that file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// Metres.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub position: DVec3,
    /// Degrees about x, y, z.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rotation: DVec3,
    /// The object that carries it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub on: Option<String>,
    /// Whether edits may move it.
    #[serde(default, skip_serializing_if = "is_false")]
    pub movable: bool,
    /// One material for all of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Cameras look through it.
    #[serde(default, skip_serializing_if = "is_false")]
    pub hidden_from_camera: bool,
}

/// A lamp of a scene file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LampEntry {
    /// Unique name.
    pub name: String,
    /// Metres.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub position: DVec3,
    /// Degrees about x, y, z.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rotation: DVec3,
    /// The object that carries it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub on: Option<String>,
    /// Candela, or the factor of the photometric file's.
    pub intensity: DVec3,
    /// The intensity that the lamp's share of the photons follows; `intensity` unless it was dimmed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rated: Option<DVec3>,
    /// Switched off.
    #[serde(default, skip_serializing_if = "is_false")]
    pub off: bool,
    /// LM-63 file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub photometry: Option<String>,
    /// Who draws its direct light.
    #[serde(default)]
    pub direct: Direct,
}

/// A camera of a scene file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraEntry {
    /// Unique name.
    pub name: String,
    /// Metres.
    pub eye: DVec3,
    /// Metres.
    pub target: DVec3,
    /// Vertical, degrees.
    pub fov: f64,
}

impl CameraEntry {
    /// The camera without its name.
    pub fn view(&self) -> View {
        View { eye: self.eye, target: self.target, fov: self.fov }
    }
}

pub(crate) fn is_zero(v: &DVec3) -> bool {
    *v == DVec3::ZERO
}

fn is_false(b: &bool) -> bool {
    !b
}

fn ron_options() -> ron::Options {
    ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME)
}

/// Reads a RON file; a mistake is reported with line and column.
pub fn read_ron<T: DeserializeOwned>(path: &Path) -> Result<T, SceneError> {
    let bytes = std::fs::read(path).map_err(|e| SceneError::read(path, e))?;
    let text = String::from_utf8(bytes).map_err(|_| SceneError::content(path, "not a text file in UTF-8"))?;
    let text = text.trim_start_matches('\u{feff}');
    ron_options().from_str(text).map_err(|e| {
        let place = format!("{}:{}", e.span.start.line, e.span.start.col);
        SceneError::line(path, place, e.code.to_string().replace('\n', " "))
    })
}

/// Writes a RON file beside its place and renames it there, so that nothing is ever half-written.
pub fn write_ron<T: Serialize>(path: &Path, value: &T) -> Result<(), SceneError> {
    let pretty = ron::ser::PrettyConfig::new().depth_limit(3).extensions(ron::extensions::Extensions::IMPLICIT_SOME);
    // IMPLICIT_SOME is this format's default: the header that would say so is left out.
    let text = ron_options().to_string_pretty(value, pretty).map_err(|e| SceneError::content(path, e))?;
    let text = text.strip_prefix("#![enable(implicit_some)]").unwrap_or(&text).trim_start();
    write_atomically(path, |out| writeln!(out, "{text}"))
}

/// Whether a device or a pipe is at `path`: it is written into, never replaced.
pub fn is_stream(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir())
}

/// Writes a file beside its place, then renames it.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut std::io::BufWriter<std::fs::File>) -> std::io::Result<()>,
) -> Result<(), SceneError> {
    let fault = |e: std::io::Error| SceneError::content(path, format!("cannot be written: {e}"));
    let name = path.file_name().ok_or_else(|| SceneError::content(path, "is not a file name"))?;
    if is_stream(path) {
        let stream = std::fs::OpenOptions::new().write(true).open(path).map_err(fault)?;
        let mut out = std::io::BufWriter::new(stream);
        return write(&mut out).and_then(|()| out.flush()).map_err(fault);
    }
    let beside = path.with_file_name(format!(".{}.{}.part", name.to_string_lossy(), std::process::id()));
    let result = (|| {
        let mut out = std::io::BufWriter::new(std::fs::File::create(&beside)?);
        write(&mut out)?;
        out.flush()?;
        out.get_ref().sync_all()?;
        std::fs::rename(&beside, path)
    })();
    if result.is_err() {
        // The failed part is of no use; if it cannot be removed either, the first error says more.
        let _ = std::fs::remove_file(&beside);
    }
    result.map_err(fault)
}

impl SceneFile {
    /// From now on positions count from `origin`, which is where they counted from and some metres more.
    pub(crate) fn recentre(&mut self, origin: DVec3) {
        let by = self.origin - origin;
        self.objects.iter_mut().filter(|o| o.on.is_none()).for_each(|o| o.position += by);
        self.lamps.iter_mut().filter(|l| l.on.is_none()).for_each(|l| l.position += by);
        for camera in &mut self.cameras {
            (camera.eye, camera.target) = (camera.eye + by, camera.target + by);
        }
        self.origin = origin;
    }

    /// Rewrites the paths of a file that stood in folder `from` for one that will stand in folder `to`.
    pub fn relocate(&mut self, from: &Path, to: &Path) -> Result<(), SceneError> {
        let textures = self.materials.values_mut().filter_map(|m| m.texture.as_mut());
        let photometry = self.lamps.iter_mut().filter_map(|l| l.photometry.as_mut());
        textures.chain(photometry).try_for_each(|path| relocate(path, from, to))?;
        let mut meshes = BTreeMap::new();
        for object in &mut self.objects {
            let before = object.mesh.clone();
            relocate(&mut object.mesh, from, to)?;
            meshes.insert(before, object.mesh.clone());
        }
        // Where meshes disagree on a material, its name has the mesh in it.
        let renamed = |name: &String| {
            let of_mesh = meshes.iter().find_map(|(before, after)| Some((name.strip_suffix(&own_name("", before))?, after)));
            of_mesh.map_or_else(|| name.clone(), |(plain, mesh)| own_name(plain, mesh))
        };
        self.materials = std::mem::take(&mut self.materials).into_iter().map(|(name, entry)| (renamed(&name), entry)).collect();
        self.objects.iter_mut().filter_map(|o| o.material.as_mut()).for_each(|name| *name = renamed(name));
        Ok(())
    }
}

/// Rewrites a path of a file that stood in folder `from` for one that will stand in folder `to`. Absolute ones are right everywhere.
pub(crate) fn relocate(path: &mut String, from: &Path, to: &Path) -> Result<(), SceneError> {
    let absolute = |folder: &Path| {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        folder.canonicalize().map_err(|e| SceneError::read(folder, e))
    };
    let (from, to) = (absolute(from)?, absolute(to)?);
    if from != to && Path::new(path).is_relative() {
        *path = relative(Path::new(&plain(&from.join(&*path), &from)), &to);
    }
    Ok(())
}

/// How a file in folder `folder` names the file at `path`.
pub fn path_from(folder: &Path, path: &Path) -> Result<String, SceneError> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let absolute = |path: &Path| path.canonicalize().map_err(|e| SceneError::read(path, e));
    Ok(relative(&absolute(path)?, &absolute(folder)?))
}

/// `path` as seen from folder `base`; both absolute.
fn relative(path: &Path, base: &Path) -> String {
    let common = path.components().zip(base.components()).take_while(|(a, b)| a == b).count();
    let up = base.components().skip(common).map(|_| "..".to_owned());
    let down = path.components().skip(common).map(|c| c.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

/// A path, relative to `folder` or absolute, that enters no folder only to leave it again, but for symbolic links.
pub(crate) fn plain(path: &Path, folder: &Path) -> String {
    let mut plain = PathBuf::new();
    for part in path.components() {
        let leaves = part == Component::ParentDir && matches!(plain.components().next_back(), Some(Component::Normal(_)));
        if leaves && !folder.join(&plain).is_symlink() {
            plain.pop();
        } else if part != Component::CurDir {
            plain.push(part);
        }
    }
    plain.to_string_lossy().into_owned()
}
