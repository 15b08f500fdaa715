//! What the whole-program tests share: scenes made on the spot, pools, and how thorough to be.

pub mod edits;
pub mod masks;
pub mod pixels;
pub mod rays;
pub mod table;

use glam::{DVec2, DVec3};
use lightmend_photon::{body::TreePreset, halton::Scrambling, path::FirstHits, pool::Pool, solution::Solution, world::World};
use lightmend_scene::{
    Configuration, Mesh, Scene, Up,
    format::{LampEntry, MaterialEntry, ObjectEntry, SceneFile, read_ron, write_ron},
    obj::write_obj,
};
use std::{
    collections::BTreeMap,
    fs::File,
    io::BufWriter,
    path::{Path, PathBuf},
    sync::Arc,
};

/// `usual`, or `thorough` when `./check --thorough` runs.
pub fn count(usual: u64, thorough: u64) -> u64 {
    if std::env::var_os("LIGHTMEND_THOROUGH").is_some() { thorough } else { usual }
}

/// One of our own scenes.
pub fn own_scene(name: &str) -> Arc<Scene> {
    Scene::read(&own_scene_path(name)).unwrap().0
}

/// Its file.
pub fn own_scene_path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("../scenes/{name}/{name}.ron"))
}

/// One of our own scenes without its textures.
pub fn own_scene_untextured(name: &str) -> Arc<Scene> {
    let path = own_scene_path(name);
    let mut file: SceneFile = read_ron(&path).unwrap();
    file.materials.values_mut().for_each(|m| m.texture = None);
    let folder = tempfile::tempdir().unwrap();
    file.relocate(path.parent().unwrap(), folder.path()).unwrap();
    let path = folder.path().join("untextured.ron");
    write_ron(&path, &file).unwrap();
    Scene::read(&path).unwrap().0
}

/// A pool of the usual groups.
pub fn pool(photons: u64) -> Pool {
    Pool::new(photons, 288, 16, Scrambling::Seed(1)).unwrap()
}

/// The world of a scene as its file states it.
pub fn world(scene: &Arc<Scene>) -> Arc<World> {
    Arc::new(World::new(&Configuration::initial(scene), TreePreset::default()))
}

/// A solution of it.
pub fn shoot(pool: Pool, world: &Arc<World>, first_hits: FirstHits) -> Solution {
    Solution::shoot(pool, world.clone(), first_hits, &mut |_, _| true).unwrap()
}

/// A scene under construction.
pub struct Builder {
    /// The file to be.
    pub file: SceneFile,
    meshes: Vec<(String, Mesh)>,
}

impl Default for Builder {
    fn default() -> Self {
        let (materials, objects) = (BTreeMap::new(), Vec::new());
        let file = SceneFile {
            name: "built".into(),
            up: Up::Z,
            cell: 1e6,
            reach: None,
            origin: DVec3::ZERO,
            materials,
            objects,
            lamps: Vec::new(),
            cameras: Vec::new(),
        };
        Builder { file, meshes: Vec::new() }
    }
}

impl Builder {
    /// Adds a fixed object of one grey material.
    pub fn object(mut self, name: &str, reflectance: f64, positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Self {
        let entry = MaterialEntry { reflectance: DVec3::splat(reflectance), texture: None };
        self.file.materials.insert(format!("of {name}"), entry);
        self.file.objects.push(ObjectEntry {
            name: name.into(),
            mesh: "built.obj".into(),
            part: Some(name.into()),
            position: DVec3::ZERO,
            rotation: DVec3::ZERO,
            on: None,
            movable: false,
            material: None,
            hidden_from_camera: false,
        });
        let material_of = vec![0; triangles.len()];
        let materials = vec![format!("of {name}")];
        self.meshes.push((name.into(), Mesh { positions, triangles, material_of, materials, uvs: Vec::new() }));
        self
    }

    /// Adds an axis-parallel box, its front outwards or inwards.
    pub fn cuboid(self, name: &str, reflectance: f64, low: [f64; 3], high: [f64; 3], inwards: bool) -> Self {
        let corner = |k: usize| DVec3::from_array(std::array::from_fn(|a| if k >> a & 1 == 1 { high[a] } else { low[a] }));
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads
            .iter()
            .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
            .map(|[a, b, c]| if inwards { [a, c, b] } else { [a, b, c] })
            .collect();
        self.object(name, reflectance, (0..8).map(corner).collect(), triangles)
    }

    /// Adds a rectangle; its front is where `u × v` points.
    pub fn rectangle(self, name: &str, reflectance: f64, corner: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Self {
        let [o, u, v] = [corner, u, v].map(DVec3::from_array);
        self.object(name, reflectance, vec![o, o + u, o + u + v, o + v], vec![[0, 1, 2], [0, 2, 3]])
    }

    /// Gives the object that was added last a texture and its triangles' corners places in it.
    pub fn texture(mut self, path: &Path, uvs: Vec<[DVec2; 3]>) -> Self {
        if let Some((name, mesh)) = self.meshes.last_mut() {
            mesh.uvs = uvs;
            let material = self.file.materials.get_mut(&format!("of {name}"));
            material.into_iter().for_each(|m| m.texture = Some(path.to_string_lossy().into()));
        }
        self
    }

    /// Adds a lamp of `candela`, without a photometric file.
    pub fn lamp(mut self, position: [f64; 3], candela: f64) -> Self {
        self.file.lamps.push(LampEntry {
            name: format!("lamp {}", self.file.lamps.len()),
            position: position.into(),
            rotation: DVec3::ZERO,
            on: None,
            intensity: DVec3::splat(candela),
            rated: None,
            off: false,
            photometry: None,
            direct: Default::default(),
        });
        self
    }

    /// Writes the scene to a temporary folder and reads it as any other.
    pub fn build(self, extra_files: &[(&str, &str)]) -> Arc<Scene> {
        let folder = tempfile::tempdir().unwrap();
        let meshes: Vec<(String, &Mesh)> = self.meshes.iter().map(|(name, mesh)| (name.clone(), mesh)).collect();
        let mut out = BufWriter::new(File::create(folder.path().join("built.obj")).unwrap());
        write_obj(&mut out, &meshes).unwrap();
        drop(out);
        for (name, text) in extra_files {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let path = folder.path().join("built.ron");
        write_ron(&path, &self.file).unwrap();
        Scene::read(&path).unwrap().0
    }
}

/// A sphere of radius 1 about the origin, front inwards: an icosahedron whose triangles are quartered `levels` times.
pub fn sphere(levels: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let mut points: Vec<DVec3> = Vec::new();
    for (a, b) in [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)] {
        points.extend([DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]);
    }
    points.iter_mut().for_each(|p| *p = p.normalize());
    let near = |a: usize, b: usize| points[a].distance(points[b]) < 1.1;
    let mut triangles = Vec::new();
    for a in 0..12usize {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(a, c) {
                    let outwards = (points[b] - points[a]).cross(points[c] - points[a]).dot(points[a]) > 0.0;
                    triangles.push(if outwards { [a, c, b] } else { [a, b, c] }.map(|i| i as u32));
                }
            }
        }
    }
    for _ in 0..levels {
        let mut middles: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        let mut quarters = Vec::new();
        for [a, b, c] in triangles {
            let mut middle = |p: u32, q: u32| {
                *middles.entry([p.min(q), p.max(q)]).or_insert_with(|| {
                    points.push(((points[p as usize] + points[q as usize]) / 2.0).normalize());
                    points.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            quarters.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = quarters;
    }
    (points, triangles)
}
