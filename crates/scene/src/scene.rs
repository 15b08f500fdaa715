//! A scene, checked and complete: every name resolved, every mesh read, every triangle cut into cells.

use crate::{
    Lamp, Lattice, Material, Mesh, Pose, SceneError, Up, View, Warning,
    format::{ObjectEntry, SceneFile, read_ron},
    load::{Loader, Materials},
};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

/// An object: a mesh at a pose.
#[derive(Debug, Clone)]
pub struct Object {
    /// Unique.
    pub name: String,
    /// Its triangles, in its own space.
    pub mesh: Arc<Mesh>,
    /// Its mesh elements.
    pub lattice: Arc<Lattice>,
    /// For each of the mesh's materials, what it is made of.
    pub materials: Vec<Arc<Material>>,
    /// Whether edits may move it.
    pub movable: bool,
    /// Whether it can ever be elsewhere: it is movable or rides on what is.
    pub dynamic: bool,
    /// The object it rides on.
    pub carrier: Option<usize>,
    /// Cameras look through it.
    pub hidden_from_camera: bool,
    /// Where it stands, relative to its carrier.
    pub pose: Pose,
    /// What a scene file says of it, but for its pose.
    pub entry: ObjectEntry,
}

/// Whether two shared things are the same or equal.
pub(crate) fn same<T: PartialEq>(a: &Arc<T>, b: &Arc<T>) -> bool {
    Arc::ptr_eq(a, b) || a == b
}

impl Object {
    /// The material of triangle `t` of its mesh.
    #[inline]
    pub fn material(&self, t: usize) -> &Material {
        &self.materials[usize::from(self.mesh.material_of[t])]
    }

    /// What a scene file says of it.
    pub fn stated(&self) -> ObjectEntry {
        ObjectEntry { position: self.pose.position, rotation: self.pose.rotation, ..self.entry.clone() }
    }

    /// Whether another object has the same surfaces, wherever it stands.
    pub fn same_surfaces(&self, other: &Object) -> bool {
        let materials = self.materials.iter().zip(&other.materials);
        self.name == other.name
            && same(&self.mesh, &other.mesh)
            && self.materials.len() == other.materials.len()
            && materials.fold(true, |all, (a, b)| all && same(a, b))
    }
}

impl PartialEq for Object {
    /// Equal in all that a scene file can say.
    fn eq(&self, other: &Self) -> bool {
        self.pose == other.pose
            && (self.carrier, &self.entry.material) == (other.carrier, &other.entry.material)
            && (self.movable, self.hidden_from_camera) == (other.movable, other.hidden_from_camera)
            && self.same_surfaces(other)
    }
}

/// Everything that a scene file says.
#[derive(Debug)]
pub struct Scene {
    /// Where it was read from.
    pub path: PathBuf,
    /// Its name.
    pub name: String,
    /// Its up axis.
    pub up: Up,
    /// Materials by name.
    pub materials: BTreeMap<String, Arc<Material>>,
    /// What meshes' own files say of those that the scene file does not define.
    pub(crate) of_meshes: Materials,
    /// Objects, in order of their names.
    pub objects: Vec<Arc<Object>>,
    /// Lamps, in order of their names.
    pub lamps: Vec<Arc<Lamp>>,
    /// Cameras by name, in the file's order.
    pub cameras: Vec<(String, View)>,
    /// The file as typed.
    pub file: SceneFile,
}

impl Scene {
    /// Reads a scene file and all that it names.
    pub fn read(path: &Path) -> Result<(Arc<Scene>, Vec<Warning>), SceneError> {
        let file: SceneFile = read_ron(path)?;
        let mut loader = Loader::new(path);
        let scene = loader.scene(file)?;
        Ok((Arc::new(scene), loader.warnings))
    }

    /// Mesh elements of the scene, counted once (not per side).
    pub fn cells(&self) -> u64 {
        self.objects.iter().map(|o| u64::from(o.lattice.cells())).sum()
    }

    /// Source triangles of the scene.
    pub fn triangles(&self) -> usize {
        self.objects.iter().map(|o| o.mesh.triangles.len()).sum()
    }
}

/// "there is no table 'tabel'; did you mean 'table'?"
pub fn unknown<'a>(kind: &str, name: &str, known: impl Iterator<Item = &'a str>) -> String {
    let nearest = known.map(|k| (strsim::damerau_levenshtein(k, name), k)).min();
    match nearest {
        Some((distance, near)) if distance <= 2.max(name.chars().count() / 3) => {
            format!("there is no {kind} '{name}'; did you mean '{near}'?")
        }
        _ => format!("there is no {kind} '{name}'"),
    }
}
