//! The scenes: room and house as they are, of finer elements or triangles, and a hall of a thousand chairs.

use crate::point::{Grown, Point};
use glam::DVec3;
use lightmend_scene::{
    Configuration, Edit, Lattice, Mesh, Object, Scene, Up,
    format::{LampEntry, MaterialEntry, ObjectEntry, SceneFile, write_ron},
};
use std::{
    collections::{HashMap, hash_map::Entry},
    error::Error,
    fs,
    path::Path,
    sync::Arc,
};

/// The scene of a point, from the folder of our scenes; what has to be written is written into `out`.
pub fn make(point: &Point, scenes: &Path, out: &Path) -> Result<Arc<Scene>, Box<dyn Error>> {
    let read = |path: &Path| -> Result<Arc<Scene>, Box<dyn Error>> { Ok(Scene::read(path)?.0) };
    let ours = || read(&scenes.join(point.scene).join(format!("{}.ron", point.scene)));
    match point.grown {
        Grown::Pool => ours(),
        Grown::Elements(cell) => remade(ours()?, |object| {
            let lattice = Lattice::new(&object.mesh, cell).ok_or("too many elements")?;
            Ok((object.mesh.clone(), Arc::new(lattice)))
        }),
        Grown::Triangles(n) => {
            let scene = ours()?;
            let cell = scene.file.cell;
            remade(scene, |object| {
                let mesh = cut(&object.mesh, n);
                let lattice = Lattice::new(&mesh, cell).ok_or("too many elements")?;
                Ok((Arc::new(mesh), Arc::new(lattice)))
            })
        }
        Grown::Movables(movables) => read(&hall(movables, scenes, out)?),
    }
}

/// A mesh and its elements.
type Cut = (Arc<Mesh>, Arc<Lattice>);

/// The same objects with other meshes and elements; what was shared still is.
fn remade(mut scene: Arc<Scene>, of: impl Fn(&Object) -> Result<Cut, Box<dyn Error>>) -> Result<Arc<Scene>, Box<dyn Error>> {
    let mut made: HashMap<*const Mesh, (Cut, Arc<Mesh>)> = HashMap::new();
    for object in &mut Arc::get_mut(&mut scene).ok_or("the scene is in use")?.objects {
        let (mesh, lattice) = match made.entry(Arc::as_ptr(&object.mesh)) {
            Entry::Occupied(known) => known.get().0.clone(),
            // The old mesh is kept as well, so that no other one comes to lie in its place.
            Entry::Vacant(new) => new.insert((of(object)?, object.mesh.clone())).0.clone(),
        };
        *object = Arc::new(Object { mesh, lattice, ..Object::clone(object) });
    }
    Ok(scene)
}

/// Every triangle cut into n² alike. Neighbours compute the points of their common edge to the same bits: of three summands one is 0.
fn cut(mesh: &Mesh, n: u32) -> Mesh {
    let mut fine = Mesh { materials: mesh.materials.clone(), ..Mesh::default() };
    for (t, material) in mesh.material_of.iter().enumerate() {
        let first = fine.positions.len() as u32;
        let weights = |i: u32, j: u32| [n - i - j, i, j].map(f64::from);
        let corners = mesh.corners(t);
        for i in 0..=n {
            for j in 0..=n - i {
                let [a, b, c] = weights(i, j);
                fine.positions.push((corners[0] * a + corners[1] * b + corners[2] * c) / f64::from(n));
            }
        }
        // Row i has n + 1 - i points.
        let at = |[i, j]: [u32; 2]| first + i * (2 * (n + 1) - i + 1) / 2 + j;
        for i in 0..n {
            for j in 0..n - i {
                let upright = [[i, j], [i + 1, j], [i, j + 1]];
                let inverted = [[i + 1, j], [i + 1, j + 1], [i, j + 1]];
                for cell in [upright, inverted].into_iter().take(if i + j + 1 < n { 2 } else { 1 }) {
                    fine.triangles.push(cell.map(at));
                    fine.material_of.push(*material);
                    if let Some(uvs) = mesh.uvs.get(t) {
                        fine.uvs.push(cell.map(|[i, j]| {
                            let [a, b, c] = weights(i, j);
                            (uvs[0] * a + uvs[1] * b + uvs[2] * c) / f64::from(n)
                        }));
                    }
                }
            }
        }
    }
    fine
}

/// Chairs in the hall, and in one of its rows.
const CHAIRS: usize = 1000;
const IN_A_ROW: usize = 40;
/// Width, depth and height of the hall, metres.
const HALL: [f64; 3] = [26.0, 21.0, 4.0];

/// Writes the hall. Its surfaces are the same to the bit however many of its chairs are movable, evenly spread.
fn hall(movables: usize, scenes: &Path, out: &Path) -> Result<std::path::PathBuf, Box<dyn Error>> {
    let folder = out.join("hall");
    fs::create_dir_all(&folder)?;
    let corner = |k: usize| std::array::from_fn::<_, 3, _>(|axis| if k >> axis & 1 == 1 { HALL[axis] } else { 0.0 });
    let vertices = (0..8).map(corner).map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    // Seen from inside.
    let faces = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"].map(|corners| format!("f {corners}\n"));
    let shell: String = vertices.chain(["usemtl wall\n".into()]).chain(faces).collect();
    fs::write(folder.join("shell.obj"), shell)?;

    let chair = fs::canonicalize(scenes.join("room/meshes/chair.obj"))?;
    let fixed = ObjectEntry {
        name: "shell".into(),
        mesh: "shell.obj".into(),
        part: None,
        position: DVec3::ZERO,
        rotation: DVec3::ZERO,
        on: None,
        movable: false,
        material: None,
        hidden_from_camera: false,
    };
    let chairs = (0..CHAIRS).map(|k| ObjectEntry {
        name: name_of(k),
        mesh: chair.to_string_lossy().into_owned(),
        position: DVec3::new(1.3 + 0.6 * (k % IN_A_ROW) as f64, 1.5 + 0.75 * (k / IN_A_ROW) as f64, 0.0),
        movable: movables > 0 && k % (CHAIRS / movables) == 0,
        material: Some("wood".into()),
        ..fixed.clone()
    });
    let lamps = (0..4).map(|k| LampEntry {
        name: format!("lamp {k}"),
        position: DVec3::new(HALL[0] * (0.25 + 0.5 * f64::from(k % 2)), HALL[1] * (0.25 + 0.5 * f64::from(k / 2)), 3.5),
        rotation: DVec3::ZERO,
        on: None,
        intensity: DVec3::splat(400.0),
        rated: None,
        off: false,
        photometry: None,
        direct: Default::default(),
    });
    let material = |reflectance| MaterialEntry { reflectance: DVec3::splat(reflectance), texture: None };
    let file = SceneFile {
        name: "hall".into(),
        up: Up::Z,
        cell: 0.5,
        reach: None,
        origin: DVec3::ZERO,
        materials: [("wall".into(), material(0.7)), ("wood".into(), material(0.4))].into(),
        objects: [fixed.clone()].into_iter().chain(chairs).collect(),
        lamps: lamps.collect(),
        cameras: Vec::new(),
    };
    let path = folder.join(format!("hall_{movables}.ron"));
    write_ron(&path, &file)?;
    Ok(path)
}

fn name_of(chair: usize) -> String {
    format!("chair {chair:03}")
}

/// Two edits of a configuration, one of something small and one of something large: a cup and the table with all that is on it; in the
/// hall one chair, and all that are movable at once. Where nothing is movable there is none.
pub fn edits(point: &Point, home: &Configuration) -> Result<Vec<(&'static str, Configuration)>, Box<dyn Error>> {
    let moved = |from: &Configuration, name: &str, by: f64| -> Result<Configuration, Box<dyn Error>> {
        let to = from.object(from.object_id(name)?).pose.position + DVec3::X * by;
        Ok(from.apply(&Edit::Move { object: name.into(), to })?)
    };
    Ok(match point.scene {
        "hall" => {
            let movable: Vec<&str> = home.objects().filter(|(_, o)| o.movable).map(|(_, o)| o.name.as_str()).collect();
            if movable.is_empty() {
                return Ok(Vec::new());
            }
            let all = movable.iter().try_fold(home.clone(), |moving, name| moved(&moving, name, 0.05))?;
            vec![("small", moved(home, &name_of(CHAIRS / 2), 0.1)?), ("large", all)]
        }
        "house" => vec![("small", moved(home, "table: cup west", 0.3)?), ("large", moved(home, "table", 0.5)?)],
        _ => vec![("small", moved(home, "cup west", 0.3)?), ("large", moved(home, "table", 0.5)?)],
    })
}
