//! What can change: an immutable state of the scene. Edits ([`crate::Edit`]) lead from one to the next.
//!
//! Objects and lamps keep their number for good: what is removed leaves its place empty and takes it again when it comes back, so
//! that buckets and trees can be told by number.

use crate::{
    Direct, Lamp, Material, Motion, Object, Pose, Scene, SceneError,
    format::{SceneFile, write_ron},
    lamp_rotation,
    load::Materials,
    scene::same,
    unknown,
};
use std::{collections::BTreeSet, path::Path, sync::Arc};

/// The state of everything that edits can change. Immutable; a clone costs a pointer.
#[derive(Debug, Clone)]
pub struct Configuration {
    scene: Arc<Scene>,
    state: Arc<State>,
}

/// A numbered place for an object or a lamp.
#[derive(Debug)]
pub(crate) struct Slot<T> {
    pub thing: Arc<T>,
    pub present: bool,
}

impl<T> Clone for Slot<T> {
    fn clone(&self) -> Self {
        Slot { thing: self.thing.clone(), present: self.present }
    }
}

#[derive(Debug, Clone)]
pub(crate) struct State {
    pub objects: Vec<Slot<Object>>,
    pub lamps: Vec<Slot<Lamp>>,
    pub materials: Materials,
    /// What meshes' own files say of those that the scene does not define, also of some that are forgotten.
    pub of_meshes: Materials,
}

fn slots_equal<T: PartialEq>(a: &[Slot<T>], b: &[Slot<T>]) -> bool {
    let absent = |slots: &[Slot<T>]| slots.iter().all(|s| !s.present);
    let common = a.len().min(b.len());
    let equal = |(a, b): (&Slot<T>, &Slot<T>)| a.present == b.present && (!a.present || same(&a.thing, &b.thing));
    a.iter().zip(b).all(equal) && absent(&a[common..]) && absent(&b[common..])
}

impl PartialEq for State {
    /// What is removed does not count.
    fn eq(&self, other: &Self) -> bool {
        slots_equal(&self.objects, &other.objects)
            && slots_equal(&self.lamps, &other.lamps)
            && self.materials.len() == other.materials.len()
            && self.materials.iter().zip(&other.materials).all(|(a, b)| a.0 == b.0 && same(a.1, b.1))
    }
}

impl PartialEq for Configuration {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.scene, &other.scene) && (Arc::ptr_eq(&self.state, &other.state) || self.state == other.state)
    }
}

fn present<T>(slots: &[Slot<T>]) -> impl Iterator<Item = (usize, &T)> {
    slots.iter().enumerate().filter(|(_, slot)| slot.present).map(|(id, slot)| (id, &*slot.thing))
}

impl State {
    pub fn object_id(&self, name: &str) -> Result<usize, SceneError> {
        let names = || present(&self.objects).map(|(_, o)| o.name.as_str());
        let found = present(&self.objects).find(|(_, o)| o.name == name).map(|(id, _)| id);
        found.ok_or_else(|| SceneError::Edit(unknown("object", name, names())))
    }

    pub fn lamp_id(&self, name: &str) -> Result<usize, SceneError> {
        let names = || present(&self.lamps).map(|(_, l)| l.name.as_str());
        let found = present(&self.lamps).find(|(_, l)| l.name == name).map(|(id, _)| id);
        found.ok_or_else(|| SceneError::Edit(unknown("lamp", name, names())))
    }
}

impl Configuration {
    /// The scene as its file states it.
    pub fn initial(scene: &Arc<Scene>) -> Configuration {
        let objects = scene.objects.iter().map(|o| Slot { thing: o.clone(), present: true }).collect();
        let lamps = scene.lamps.iter().map(|l| Slot { thing: l.clone(), present: true }).collect();
        let state = State { objects, lamps, materials: scene.materials.clone(), of_meshes: scene.of_meshes.clone() };
        Configuration { scene: scene.clone(), state: Arc::new(state) }
    }

    pub(crate) fn state(&self) -> &State {
        &self.state
    }

    pub(crate) fn with(&self, state: State) -> Configuration {
        Configuration { scene: self.scene.clone(), state: Arc::new(state) }
    }

    /// The scene whose state this is.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// The objects that are there, with their numbers.
    pub fn objects(&self) -> impl Iterator<Item = (usize, &Object)> {
        present(&self.state.objects)
    }

    /// How many numbers of objects are given away, also to objects that are gone.
    pub fn object_slots(&self) -> usize {
        self.state.objects.len()
    }

    /// Object number `id`, whether it is there or not.
    #[inline]
    pub fn object(&self, id: usize) -> &Object {
        &self.state.objects[id].thing
    }

    /// Whether object number `id` is there.
    pub fn has_object(&self, id: usize) -> bool {
        self.state.objects.get(id).is_some_and(|slot| slot.present)
    }

    /// The number of the object called `name`.
    pub fn object_id(&self, name: &str) -> Result<usize, SceneError> {
        self.state.object_id(name)
    }

    /// The lamps that are there, with their numbers.
    pub fn lamps(&self) -> impl Iterator<Item = (usize, &Lamp)> {
        present(&self.state.lamps)
    }

    /// How many numbers of lamps are given away, also to lamps that are gone.
    pub fn lamp_slots(&self) -> usize {
        self.state.lamps.len()
    }

    /// Lamp number `id`, whether it is there or not.
    #[inline]
    pub fn lamp(&self, id: usize) -> &Lamp {
        &self.state.lamps[id].thing
    }

    /// Whether lamp number `id` is there.
    pub fn has_lamp(&self, id: usize) -> bool {
        self.state.lamps.get(id).is_some_and(|slot| slot.present)
    }

    /// All materials, in order of their names.
    pub fn materials(&self) -> impl Iterator<Item = &Material> {
        self.state.materials.values().map(|material| &**material)
    }

    /// Where object `id` is in the world.
    pub fn object_motion(&self, id: usize) -> Motion {
        let object = self.object(id);
        self.carried(object.pose, object.carrier)
    }

    /// Where lamp `id` is in the world.
    pub fn lamp_motion(&self, id: usize) -> Motion {
        let lamp = self.lamp(id);
        self.carried(lamp.pose, lamp.carrier)
    }

    fn carried(&self, pose: Pose, mut carrier: Option<usize>) -> Motion {
        let mut motion = pose.motion();
        // The scene's loader made sure that carriers form no ring.
        while let Some(id) = carrier {
            let object = self.object(id);
            motion = motion.carried_by(&object.pose.motion());
            carrier = object.carrier;
        }
        motion
    }

    /// How far the scene reaches, metres: what the rounding of rays is measured against. From what never moves, as the scene file states
    /// it (without anything fixed, from the meshes themselves), so that a path depends on no object's history.
    pub fn reach(&self) -> f64 {
        self.scene.file.reach.unwrap_or_else(|| Configuration::initial(&self.scene).extent())
    }

    /// What [`reach`](Self::reach) would be if this were a scene file.
    fn extent(&self) -> f64 {
        let fixed = self.farthest(|object| !object.dynamic, |id| self.object_motion(id));
        let any = || self.farthest(|_| true, |_| Pose::default().motion());
        // An empty scene may be furnished yet: a metre.
        [fixed].into_iter().chain(std::iter::once_with(any)).find(|metres| *metres > 0.0).unwrap_or(1.0)
    }

    /// The largest coordinate of some objects.
    fn farthest(&self, counts: impl Fn(&Object) -> bool, motion: impl Fn(usize) -> Motion) -> f64 {
        let objects = self.objects().filter(|(_, object)| counts(object));
        let vertices = objects.flat_map(|(id, object)| {
            let motion = motion(id);
            object.mesh.positions.iter().map(move |p| motion.point(*p).abs().max_element())
        });
        vertices.fold(0.0, f64::max)
    }

    /// A hash of all that photons' paths depend on: geometry, materials, lamps and how they share the photons. Not of what is read-out
    /// only (dimming, switching), and not of names of files.
    pub fn content_hash(&self) -> [u8; 32] {
        let mut hasher = blake3::Hasher::new();
        let mut numbers = |values: &[f64]| {
            for value in values {
                hasher.update(&value.to_le_bytes());
            }
        };
        numbers(&[self.reach()]);
        let mut objects: Vec<_> = self.objects().collect();
        objects.sort_by(|a, b| a.1.name.cmp(&b.1.name));
        for (id, object) in objects {
            let (motion, mesh) = (self.object_motion(id), &object.mesh);
            numbers(&motion.rotation.to_cols_array());
            numbers(&motion.translation.to_array());
            numbers(&[mesh.positions.len() as f64, mesh.triangles.len() as f64, mesh.uvs.len() as f64]);
            mesh.positions.iter().for_each(|p| numbers(&p.to_array()));
            for (t, triangle) in mesh.triangles.iter().enumerate() {
                numbers(&triangle.map(f64::from));
                numbers(&[f64::from(mesh.material_of[t]), f64::from(object.lattice.divisions(t))]);
            }
            mesh.uvs.iter().flatten().for_each(|uv| numbers(&uv.to_array()));
            for material in &object.materials {
                numbers(&material.reflectance.to_array().map(f64::from));
                if let Some(texture) = &material.texture {
                    texture.numbers(&mut numbers);
                }
            }
        }
        let mut lamps: Vec<_> = self.lamps().collect();
        lamps.sort_by(|a, b| a.1.name.cmp(&b.1.name));
        for (id, lamp) in lamps {
            let motion = self.lamp_motion(id);
            numbers(&lamp_rotation(self.scene.up, &motion).to_cols_array());
            numbers(&motion.translation.to_array());
            numbers(&lamp.rated.to_array());
            numbers(&[f64::from(u8::from(lamp.direct == Direct::Photons))]);
            if let Some(photometry) = &lamp.photometry {
                for c in photometry.horizontal() {
                    photometry.vertical().iter().for_each(|gamma| numbers(&[*c, *gamma, photometry.candela_at(*c, *gamma)]));
                }
            }
        }
        // Names decide ties between hits.
        let mut names: Vec<&str> = self.objects().map(|(_, object)| object.name.as_str()).collect();
        names.sort_unstable();
        for name in names {
            hasher.update(name.as_bytes()).update(&[0]);
        }
        *hasher.finalize().as_bytes()
    }

    /// Writes the scene file that says this state to `path`; what it names is found from there too.
    pub fn write(&self, path: &Path) -> Result<(), SceneError> {
        let folder = |path: &Path| path.parent().unwrap_or(Path::new("")).to_owned();
        let mut file = self.to_file();
        file.relocate(&folder(&self.scene.path), &folder(path))?;
        write_ron(path, &file)
    }

    /// The scene file that says this state.
    pub fn to_file(&self) -> SceneFile {
        let mut file = self.scene.file.clone();
        if self.reach() != self.extent() {
            file.reach = Some(self.reach());
        }
        file.objects = self.objects().map(|(_, object)| object.stated()).collect();
        file.lamps = self.lamps().map(|(_, lamp)| lamp.stated()).collect();
        let materials = &self.state.materials;
        let changed = |name: &str| {
            let says = |all: &Materials| all.get(name).map(|material| material.stated());
            says(&self.scene.materials) != says(materials)
        };
        let painted = |name: &str| self.objects().any(|(_, object)| object.entry.material.as_deref() == Some(name));
        file.materials.retain(|name, _| materials.contains_key(name));
        let ours = |name: &&String| changed(name) || (!file.materials.contains_key(*name) && painted(name));
        let ours: BTreeSet<&str> = materials.keys().filter(ours).map(String::as_str).collect();
        // A mesh's own material of that name would otherwise be taken for the one that is now the scene's.
        let shadowed = |name: &str| ours.iter().any(|own| name.strip_prefix(own).is_some_and(|rest| rest.starts_with(" (")));
        let written = materials.iter().filter(|(name, _)| ours.contains(name.as_str()) || shadowed(name));
        let written: Vec<_> = written.map(|(name, material)| (name.clone(), material.stated())).collect();
        file.materials.extend(written);
        file
    }
}
