//! From what a scene file says to a scene: every name looked up, every file read, every fault told in one line.

use crate::{
    FARTHEST, Lamp, Lattice, Material, Mesh, Object, Photometry, Pose, Scene, SceneError, Texture, Warning,
    format::{LampEntry, MaterialEntry, ObjectEntry, SceneFile},
    lamp::luminance,
    obj::{MtlMaterial, ObjFile, Strictness, read_obj},
    unknown, within_reach,
};
use glam::DVec3;
use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
    sync::Arc,
};

/// Objects' numbers by name.
pub(crate) type Index = BTreeMap<String, usize>;

/// A page of buckets holds 32 bytes for each; more would not fit a workstation's memory with a few lamps.
pub(crate) const MOST_CELLS: u64 = 50_000_000;

/// A mesh and its mesh elements.
type CutMesh = (Arc<Mesh>, Arc<Lattice>);

/// Reads what a scene file names, each file once.
pub(crate) struct Loader<'a> {
    path: &'a Path,
    folder: PathBuf,
    models: BTreeMap<PathBuf, Arc<ObjFile>>,
    /// By file and part.
    meshes: BTreeMap<(PathBuf, Option<String>), CutMesh>,
    /// Names of the materials that the scene file defines.
    pub own: BTreeSet<String>,
    /// Materials in use, by name.
    pub materials: BTreeMap<String, Arc<Material>>,
    pub warnings: Vec<Warning>,
}

impl<'a> Loader<'a> {
    /// For the scene file `path`.
    pub fn new(path: &'a Path) -> Loader<'a> {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let (models, meshes, materials) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        Loader { path, folder, models, meshes, own: BTreeSet::new(), materials, warnings: Vec::new() }
    }

    fn fault(&self, what: impl ToString) -> SceneError {
        SceneError::content(self.path, what)
    }

    /// A file that cannot be read, with what names it in the scene file; faults inside of a file name that file alone.
    fn named_by(&self, what: &str, error: SceneError) -> SceneError {
        if matches!(error, SceneError::Read { .. }) { self.fault(format!("{what}: {error}")) } else { error }
    }

    fn warn(&mut self, what: String) {
        let warning = Warning(format!("{}: {what}", self.path.display()));
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }

    pub fn scene(&mut self, file: SceneFile) -> Result<Scene, SceneError> {
        if !(file.cell.is_finite() && file.cell > 0.0) {
            return Err(self.fault(format!("cell is {}; it must be a positive length in metres", file.cell)));
        }
        if let Some(reach) = file.reach.filter(|r| !(r.is_finite() && *r > 0.0)) {
            return Err(self.fault(format!("reach is {reach}; it must be a positive length in metres")));
        }
        self.unique("object", file.objects.iter().map(|o| &o.name))?;
        self.unique("lamp", file.lamps.iter().map(|l| &l.name))?;
        self.unique("camera", file.cameras.iter().map(|c| &c.name))?;
        self.own = file.materials.keys().cloned().collect();
        for (name, entry) in &file.materials {
            let material = self.material(name, entry)?;
            self.materials.insert(name.clone(), Arc::new(material));
        }
        let mut entries: Vec<&ObjectEntry> = file.objects.iter().collect();
        entries.sort_by(|a, b| a.name.cmp(&b.name));
        let index: Index = entries.iter().enumerate().map(|(i, e)| (e.name.clone(), i)).collect();
        let mut drafts = Vec::new();
        for entry in &entries {
            drafts.push(self.object(entry, &index, file.cell)?);
        }
        self.carriers(&mut drafts)?;
        let cells: u64 = drafts.iter().map(|object| u64::from(object.lattice.cells())).sum();
        if cells > MOST_CELLS {
            let what =
                format!("there would be {cells} mesh elements, more than {MOST_CELLS}; make `cell` larger than {} m", file.cell);
            return Err(self.fault(what));
        }
        let mut lamps = Vec::new();
        for entry in &file.lamps {
            lamps.push(Arc::new(self.lamp(entry, &index)?));
        }
        lamps.sort_by(|a, b| a.name.cmp(&b.name));
        if lamps.is_empty() {
            self.warn("there is no lamp: the scene is dark".into());
        }
        let mut cameras = Vec::new();
        for camera in &file.cameras {
            if let Some(fault) = camera.view().fault() {
                return Err(self.fault(format!("camera '{}': {fault}", camera.name)));
            }
            cameras.push((camera.name.clone(), camera.view()));
        }
        let objects = drafts.into_iter().map(Arc::new).collect();
        let materials = self.materials.clone();
        Ok(Scene { path: self.path.to_owned(), name: file.name.clone(), up: file.up, materials, objects, lamps, cameras, file })
    }

    fn unique<'n>(&self, kind: &str, names: impl Iterator<Item = &'n String>) -> Result<(), SceneError> {
        let mut seen = std::collections::BTreeSet::new();
        for name in names {
            if !printable(name) {
                return Err(self.fault(format!("the name {name:?} of a {kind}: names must be printable and not empty")));
            }
            if !seen.insert(name) {
                return Err(self.fault(format!("two {kind}s are called '{name}'; give one another name")));
            }
        }
        Ok(())
    }

    fn pose(&self, what: String, position: DVec3, rotation: DVec3) -> Result<Pose, SceneError> {
        if !(within_reach(position) && rotation.is_finite()) {
            let why = format!("is not a number, or farther than {FARTHEST:e} m from the origin");
            return Err(self.fault(format!("{what}: its position {position} or rotation {rotation} {why}")));
        }
        Ok(Pose { position, rotation })
    }

    pub fn material(&mut self, name: &str, entry: &MaterialEntry) -> Result<Material, SceneError> {
        let r = entry.reflectance;
        if !(r.is_finite() && r.min_element() >= 0.0 && r.max_element() <= 1.0) {
            return Err(self.fault(format!("material '{name}': reflectance {r} must be within 0 to 1")));
        }
        let texture = entry.texture.as_ref().map(|t| Texture::read(&self.folder.join(t)).map(Arc::new)).transpose();
        let texture = texture.map_err(|e| self.named_by(&format!("material '{name}'"), e))?;
        Ok(Material { name: name.to_owned(), reflectance: r.as_vec3(), texture, texture_path: entry.texture.clone() })
    }

    /// An object; `index` numbers those that can carry it. Whether it is dynamic on their account is not looked at.
    pub fn object(&mut self, entry: &ObjectEntry, index: &Index, cell: f64) -> Result<Object, SceneError> {
        let what = format!("object '{}'", entry.name);
        let pose = self.pose(what.clone(), entry.position, entry.rotation)?;
        let carrier = self.carrier(&what, &entry.on, index)?;
        let model = self.model(&self.folder.join(&entry.mesh)).map_err(|e| self.named_by(&what, e))?;
        let (mesh, lattice) = self.mesh(entry, &model, cell)?;
        let names = match &entry.material {
            Some(name) => {
                if !self.materials.contains_key(name) {
                    let known = self.materials.keys().map(String::as_str);
                    return Err(self.fault(format!("{what}: {}", unknown("material", name, known))));
                }
                vec![name.clone(); mesh.materials.len()]
            }
            None => mesh.materials.clone(),
        };
        let mut names = names;
        if entry.material.is_none() {
            for name in &mut names {
                *name = self.material_of_mesh(name, &what, &entry.mesh, &model)?;
            }
        }
        let textured = names.iter().any(|n| self.materials[n].texture.is_some());
        if textured && mesh.uvs.is_empty() {
            self.warn(format!(
                "{what}: its material has a texture but {} has no texture coordinates: it shows one point of the image",
                entry.mesh
            ));
        }
        Ok(Object {
            name: entry.name.clone(),
            mesh,
            lattice,
            materials: names.iter().map(|name| self.materials[name].clone()).collect(),
            movable: entry.movable,
            dynamic: entry.movable,
            carrier,
            hidden_from_camera: entry.hidden_from_camera,
            pose,
            entry: entry.clone(),
        })
    }

    fn carrier(&self, what: &str, on: &Option<String>, index: &Index) -> Result<Option<usize>, SceneError> {
        let Some(name) = on else { return Ok(None) };
        let id = index.get(name).ok_or_else(|| {
            self.fault(format!("{what} stands on '{name}': {}", unknown("object", name, index.keys().map(String::as_str))))
        })?;
        Ok(Some(*id))
    }

    /// Refuses rings of carriers, and lets what rides on a movable object be dynamic.
    fn carriers(&self, drafts: &mut [Object]) -> Result<(), SceneError> {
        for id in 0..drafts.len() {
            let (mut at, mut steps, mut dynamic) = (id, 0, drafts[id].movable);
            while let Some(carrier) = drafts[at].carrier {
                (at, steps) = (carrier, steps + 1);
                dynamic |= drafts[at].movable;
                if steps > drafts.len() {
                    return Err(self.fault(format!("object '{}' carries itself, by way of `on`", drafts[id].name)));
                }
            }
            drafts[id].dynamic = dynamic;
        }
        Ok(())
    }

    fn model(&mut self, path: &Path) -> Result<Arc<ObjFile>, SceneError> {
        if let Some(model) = self.models.get(path) {
            return Ok(model.clone());
        }
        let (file, warnings) = read_obj(path, Strictness::Scene)?;
        for warning in warnings {
            if !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
        let model = Arc::new(file);
        self.models.insert(path.to_owned(), model.clone());
        Ok(model)
    }

    fn mesh(&mut self, entry: &ObjectEntry, model: &ObjFile, cell: f64) -> Result<CutMesh, SceneError> {
        let key = (self.folder.join(&entry.mesh), entry.part.clone());
        if let Some(known) = self.meshes.get(&key) {
            return Ok(known.clone());
        }
        let mesh = match &entry.part {
            None => Mesh::merged(model.parts.iter().map(|p| &p.mesh)),
            Some(name) => {
                let part = model.parts.iter().find(|p| p.name == *name).ok_or_else(|| {
                    let known = model.parts.iter().map(|p| p.name.as_str());
                    self.fault(format!("object '{}': in {} {}", entry.name, entry.mesh, unknown("part", name, known)))
                })?;
                part.mesh.clone()
            }
        };
        if !mesh.positions.iter().all(|p| within_reach(*p)) {
            let what =
                format!("object '{}': {} has a vertex farther than {FARTHEST:e} m from the origin", entry.name, entry.mesh);
            return Err(self.fault(format!("{what}; lengths are metres")));
        }
        let lattice = Lattice::new(&mesh, cell).ok_or_else(|| {
            self.fault(format!("object '{}' would have more mesh elements than can be numbered; make `cell` larger", entry.name))
        })?;
        let made = (Arc::new(mesh), Arc::new(lattice));
        self.meshes.insert(key, made.clone());
        Ok(made)
    }

    /// The name under which the scene has a mesh's material: the scene's own of that name, or the mesh's, or grey. Where another mesh's
    /// MTL file means something else by the name, the mesh's file is added to it.
    fn material_of_mesh(&mut self, name: &str, what: &str, mesh: &str, model: &ObjFile) -> Result<String, SceneError> {
        if self.own.contains(name) {
            return Ok(name.to_owned());
        }
        let material = match model.materials.iter().find(|m| m.name == name) {
            Some(MtlMaterial { reflectance, texture, .. }) => Material {
                name: name.to_owned(),
                reflectance: DVec3::from_array(*reflectance).as_vec3(),
                texture: texture.as_ref().map(|t| Texture::read(t).map(Arc::new)).transpose()?,
                texture_path: texture.as_ref().map(|t| t.strip_prefix(&self.folder).unwrap_or(t).to_string_lossy().into_owned()),
            },
            None if self.materials.contains_key(name) => return Ok(name.to_owned()),
            None => {
                self.warn(format!("{what}: its material '{name}' is defined nowhere: it is grey, reflectance 0.5"));
                Material { name: name.to_owned(), reflectance: glam::Vec3::splat(0.5), texture: None, texture_path: None }
            }
        };
        let qualified = format!("{name} ({mesh})");
        for key in [name.to_owned(), qualified.clone()] {
            match self.materials.get(&key) {
                Some(known) if **known == (Material { name: key.clone(), ..material.clone() }) => return Ok(key),
                Some(_) => {}
                None => {
                    if key == qualified {
                        self.warn(format!("{what}: another mesh has a material '{name}' too: this one is called '{key}'"));
                    }
                    self.materials.insert(key.clone(), Arc::new(Material { name: key.clone(), ..material }));
                    return Ok(key);
                }
            }
        }
        Ok(qualified)
    }

    /// A lamp; `index` numbers the objects that can carry it.
    pub fn lamp(&mut self, entry: &LampEntry, index: &Index) -> Result<Lamp, SceneError> {
        let what = format!("lamp '{}'", entry.name);
        let pose = self.pose(what.clone(), entry.position, entry.rotation)?;
        let carrier = self.carrier(&what, &entry.on, index)?;
        let rated = entry.rated.unwrap_or(entry.intensity);
        for intensity in [entry.intensity, rated] {
            if !(intensity.is_finite() && intensity.min_element() >= 0.0) {
                return Err(self.fault(format!("{what}: intensity {intensity} must be candela, not below 0 and a number")));
            }
        }
        let photometry = entry.photometry.as_ref().map(|file| self.photometry(&what, file)).transpose()?;
        let lamp = Lamp {
            name: entry.name.clone(),
            intensity: entry.intensity,
            rated,
            lit: !entry.off,
            photometry,
            direct: entry.direct,
            carrier,
            pose,
            entry: entry.clone(),
        };
        if !(lamp.flux().is_finite() && lamp.rated_flux().is_finite()) {
            return Err(self.fault(format!("{what}: intensity {} is more than can be counted", entry.intensity)));
        }
        if luminance(lamp.rated_flux()) == 0.0 {
            self.warn(format!("{what} gives no light; its share of the photons is wasted"));
        }
        Ok(lamp)
    }

    /// The photometric file of a lamp.
    pub fn photometry(&mut self, what: &str, file: &str) -> Result<Arc<Photometry>, SceneError> {
        let read = Photometry::read(&self.folder.join(file));
        let (photometry, warnings) = read.map_err(|e| self.named_by(what, e))?;
        for warning in warnings {
            if !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
        Ok(Arc::new(photometry))
    }
}

/// What a name must be.
pub(crate) fn printable(name: &str) -> bool {
    !name.is_empty() && !name.chars().any(char::is_control)
}
