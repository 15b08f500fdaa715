//! From what a scene file says to a scene: every name looked up, every file read, every fault told in one line.

use crate::{
    FARTHEST, Lamp, Lattice, Material, Mesh, Object, Photometry, Pose, Scene, SceneError, Texture, Warning,
    format::{LampEntry, MaterialEntry, ObjectEntry, SceneFile, plain},
    lamp::luminance,
    obj::{MtlMaterial, ObjFile, Strictness, read_obj},
    unknown, within_reach,
};
use glam::DVec3;
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

/// Objects' numbers by name.
pub(crate) type Index = BTreeMap<String, usize>;

/// A page of buckets holds 32 bytes for each; more would not fit a workstation's memory with a few lamps.
pub(crate) const MOST_CELLS: u64 = 50_000_000;

/// Materials by name.
pub(crate) type Materials = BTreeMap<String, Arc<Material>>;

/// A mesh and its mesh elements.
type CutMesh = (Arc<Mesh>, Arc<Lattice>);

/// Reads what a scene file names, each file once.
pub(crate) struct Loader<'a> {
    path: &'a Path,
    folder: PathBuf,
    models: BTreeMap<PathBuf, Arc<ObjFile>>,
    /// By file and part.
    meshes: BTreeMap<(PathBuf, Option<String>), CutMesh>,
    /// Images by their path, relative to the folder.
    textures: BTreeMap<String, Arc<Texture>>,
    /// Materials in use, by name.
    pub materials: Materials,
    /// What meshes' own files say of those that the scene does not define.
    pub of_meshes: Materials,
    pub warnings: Vec<Warning>,
}

impl<'a> Loader<'a> {
    /// For the scene file `path`.
    pub fn new(path: &'a Path) -> Loader<'a> {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let (models, meshes, textures) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        let (materials, of_meshes) = (BTreeMap::new(), BTreeMap::new());
        Loader { path, folder, models, meshes, textures, materials, of_meshes, warnings: Vec::new() }
    }

    /// Images of these materials need not be read again.
    pub fn knows<'m>(&mut self, materials: impl IntoIterator<Item = &'m Materials>) {
        let materials = materials.into_iter().flat_map(BTreeMap::values);
        let images = materials.filter_map(|m| m.texture_path.clone().zip(m.texture.clone()));
        self.textures.extend(images);
    }

    /// Whether a material is defined by the scene, not by a mesh's own files.
    fn own(&self, name: &str) -> bool {
        self.materials.contains_key(name) && !self.of_meshes.contains_key(name)
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

    pub fn scene(&mut self, mut file: SceneFile) -> Result<Scene, SceneError> {
        if !(file.cell.is_finite() && file.cell > 0.0) {
            return Err(self.fault(format!("cell is {}; it must be a positive length in metres", file.cell)));
        }
        if let Some(reach) = file.reach.filter(|r| !(r.is_finite() && *r > 0.0)) {
            return Err(self.fault(format!("reach is {reach}; it must be a positive length in metres")));
        }
        if !within_reach(file.origin) {
            return Err(self.fault(format!("origin is {}; it must be three numbers of metres up to {FARTHEST:e}", file.origin)));
        }
        self.unique("object", file.objects.iter().map(|o| &o.name))?;
        self.unique("lamp", file.lamps.iter().map(|l| &l.name))?;
        self.unique("camera", file.cameras.iter().map(|c| &c.name))?;
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
        if let Some(origin) = far_from_origin(&drafts).filter(|_| file.origin == DVec3::ZERO) {
            let how_far = format!("it lies {:.0} m from the origin, too far for rays in single precision", origin.length());
            self.warn(format!("{how_far}: positions are counted from {origin}, also in what is saved (`origin`)"));
            file.recentre(origin);
            return self.scene(file);
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
        let (path, name, up) = (self.path.to_owned(), file.name.clone(), file.up);
        let (materials, of_meshes) = (self.materials.clone(), self.of_meshes.clone());
        Ok(Scene { path, name, up, materials, of_meshes, objects, lamps, cameras, file })
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
        let texture = entry.texture.as_ref().map(|file| self.texture(&format!("material '{name}'"), file)).transpose()?;
        Ok(Material { name: name.to_owned(), reflectance: r.as_vec3(), texture, texture_path: entry.texture.clone() })
    }

    /// The image of what is named by `what`.
    pub fn texture(&mut self, what: &str, file: &str) -> Result<Arc<Texture>, SceneError> {
        if let Some(known) = self.textures.get(file) {
            return Ok(known.clone());
        }
        let read = Texture::read(&self.folder.join(file)).map_err(|e| self.named_by(what, e))?;
        let texture = Arc::new(read);
        self.textures.insert(file.to_owned(), texture.clone());
        Ok(texture)
    }

    /// An object; `index` numbers those that can carry it. Whether it is dynamic on their account is not looked at.
    pub fn object(&mut self, entry: &ObjectEntry, index: &Index, cell: f64) -> Result<Object, SceneError> {
        let what = format!("object '{}'", entry.name);
        let pose = self.pose(what.clone(), entry.position, entry.rotation)?;
        let carrier = self.carrier(&what, &entry.on, index)?;
        let model = self.model(&self.folder.join(&entry.mesh)).map_err(|e| self.named_by(&what, e))?;
        let (mesh, lattice) = self.mesh(entry, &model, cell)?;
        let materials = self.materials_of(entry, &mesh)?;
        Ok(Object {
            name: entry.name.clone(),
            mesh,
            lattice,
            materials,
            movable: entry.movable,
            dynamic: entry.movable,
            carrier,
            hidden_from_camera: entry.hidden_from_camera,
            pose,
            entry: entry.clone(),
        })
    }

    /// What each material of an object's mesh is made of.
    pub fn materials_of(&mut self, entry: &ObjectEntry, mesh: &Mesh) -> Result<Vec<Arc<Material>>, SceneError> {
        let what = format!("object '{}'", entry.name);
        let mut names = mesh.materials.clone();
        if let Some(name) = &entry.material {
            if !self.materials.contains_key(name) {
                let known = self.materials.keys().map(String::as_str);
                return Err(self.fault(format!("{what}: {}", unknown("material", name, known))));
            }
            names.fill(name.clone());
        } else {
            let model = self.model(&self.folder.join(&entry.mesh)).map_err(|e| self.named_by(&what, e))?;
            for name in &mut names {
                *name = self.material_of_mesh(name, &what, &entry.mesh, &model)?;
            }
        }
        let materials: Vec<_> = names.iter().map(|name| self.materials[name].clone()).collect();
        if materials.iter().any(|m| m.texture.is_some()) && mesh.uvs.is_empty() {
            self.warn_of_blank(entry);
        }
        Ok(materials)
    }

    /// Of an object with a texture, but without texture coordinates.
    pub fn warn_of_blank(&mut self, ObjectEntry { name, mesh, .. }: &ObjectEntry) {
        let why = format!("its material has a texture but {mesh} has no texture coordinates");
        self.warn(format!("object '{name}': {why}: it shows one point of the image"));
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
        let (mesh, copies) = mesh.without_copies();
        if copies > 0 {
            let what = format!("triangles that are there already ({copies}), turned over or not, are left out");
            self.warn(format!("object '{}': in {}, {what}", entry.name, entry.mesh));
        }
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
    /// MTL file means something else by the name, the mesh's file is added to it. What edits made of a material does not count here.
    fn material_of_mesh(&mut self, name: &str, what: &str, mesh: &str, model: &ObjFile) -> Result<String, SceneError> {
        let qualified = own_name(name, mesh);
        if self.own(&qualified) {
            return Ok(qualified);
        }
        if self.own(name) && !self.materials.contains_key(&qualified) {
            return Ok(name.to_owned());
        }
        let material = match model.materials.iter().find(|m| m.name == name) {
            Some(MtlMaterial { reflectance, texture, .. }) => {
                let texture_path =
                    texture.as_ref().map(|path| plain(path.strip_prefix(&self.folder).unwrap_or(path), &self.folder));
                Material {
                    name: name.to_owned(),
                    reflectance: DVec3::from_array(*reflectance).as_vec3(),
                    texture: texture_path.as_ref().map(|file| self.texture(what, file)).transpose()?,
                    texture_path,
                }
            }
            None if self.materials.contains_key(name) => return Ok(name.to_owned()),
            None => {
                self.warn(format!("{what}: its material '{name}' is defined nowhere: it is grey, reflectance 0.5"));
                Material { name: name.to_owned(), reflectance: glam::Vec3::splat(0.5), texture: None, texture_path: None }
            }
        };
        for key in [&*qualified, name] {
            let means = |known: &Arc<Material>| **known == Material { name: key.to_owned(), ..material.clone() };
            if self.materials.contains_key(key) && self.of_meshes.get(key).is_some_and(means) {
                return Ok(key.to_owned());
            }
        }
        if self.own(name) {
            return Ok(name.to_owned());
        }
        let key = if self.materials.contains_key(name) { qualified } else { name.to_owned() };
        if key != name {
            self.warn(format!("{what}: another mesh has a material '{name}' too: this one is called '{key}'"));
        }
        if !self.materials.contains_key(&key) {
            let new = Arc::new(Material { name: key.clone(), ..material });
            self.materials.insert(key.clone(), new.clone());
            self.of_meshes.insert(key.clone(), new);
        }
        Ok(key)
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

/// A scene is far from the origin if it lies so many times its size away: paths step back by 10⁻⁵ of the largest coordinate, which is
/// then a thousandth of its size. At 100 times the ROOM still lost no photon, at 1,000 times it did.
const FAR: f64 = 64.0;

/// Where a scene should be counted from, whole metres; `None` if it is near enough. What stands fixed decides, if anything does: no move
/// changes it.
fn far_from_origin(drafts: &[Object]) -> Option<DVec3> {
    let bounds = |fixed: bool| {
        let objects = drafts.iter().filter(|o| o.carrier.is_none() && (!fixed || !o.dynamic));
        let points = objects.flat_map(|o| {
            let motion = o.pose.motion();
            o.mesh.positions.iter().map(move |p| motion.point(*p))
        });
        points.fold(None, |box_: Option<[DVec3; 2]>, p| Some(box_.map_or([p, p], |[low, high]| [low.min(p), high.max(p)])))
    };
    let [low, high] = bounds(true).or_else(|| bounds(false))?;
    let (centre, size) = ((low + high) / 2.0, (high - low).max_element());
    (centre.abs().max_element() > FAR * size && size > 0.0).then(|| centre.round())
}

/// What a mesh's material is called where another mesh means something else by its name.
pub(crate) fn own_name(name: &str, mesh: &str) -> String {
    format!("{name} ({mesh})")
}

/// What a name must be.
pub(crate) fn printable(name: &str) -> bool {
    !name.is_empty() && !name.chars().any(char::is_control)
}
