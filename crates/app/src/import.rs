//! `lightmend import`: a scene file of OBJ models, which have neither lamps nor cameras.
//!
//! The meshes are cleaned and written beside the scene file, in metres, so that the scene stands on its own.

use crate::{
    Common,
    failure::Failure,
    output::{self, say},
};
use glam::DVec3;
use lightmend_scene::{
    Direct, FARTHEST, Lattice, Mesh, SceneError, Up,
    format::{CameraEntry, LampEntry, MaterialEntry, ObjectEntry, SceneFile, write_ron},
    obj::{MtlMaterial, Strictness, read_obj, write_obj},
    unknown, within_reach,
};
use std::{
    collections::BTreeMap,
    io::Write,
    path::{Path, PathBuf},
};

/// Mesh elements as fine as the shadows of furniture, metres (docs/accuracy.md, how to choose).
const FURNITURE: f64 = 0.15;
/// More elements than this are asked for, not taken.
const MOST_ELEMENTS: u64 = 400_000;

#[derive(clap::Args)]
pub struct Arguments {
    /// OBJ files
    #[arg(required = true)]
    models: Vec<PathBuf>,
    /// The scene file to write; the meshes go beside it
    #[arg(long, value_name = "SCENE")]
    out: PathBuf,
    /// Metres per unit of the models
    #[arg(long, value_name = "F", default_value_t = 1.0, allow_negative_numbers = true)]
    scale: f64,
    /// The models' up axis
    #[arg(long, value_name = "AXIS", default_value = "y")]
    up: UpArgument,
    /// A point lamp: position in metres (after --scale), luminous intensity in candela
    #[arg(long, value_name = "x,y,z,cd", value_parser = numbers::<4>, allow_hyphen_values = true)]
    lamp: Vec<[f64; 4]>,
    /// Reflectance of a material or an object (linear, 0 to 1), over what the models say
    #[arg(long, value_name = "NAME=r,g,b", value_parser = named_reflectance)]
    reflectance: Vec<(String, [f64; 3])>,
    /// An object that may be moved; `all` for every one
    #[arg(long, value_name = "NAME")]
    movable: Vec<String>,
    /// Longest edge of a mesh element, metres; by default 0.15 or less, more where that were over 400,000 elements
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    cell: Option<f64>,
    #[command(flatten)]
    common: Common,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum UpArgument {
    Y,
    Z,
}

fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let values: Result<Vec<f64>, _> = text.split(',').map(|v| v.trim().parse::<f64>()).collect();
    let values = values.ok().filter(|v| v.iter().all(|x| x.is_finite()));
    values.and_then(|v| v.try_into().ok()).ok_or_else(|| format!("'{text}' is not {N} numbers separated by commas"))
}

fn named_reflectance(text: &str) -> Result<(String, [f64; 3]), String> {
    let (name, values) = text.rsplit_once('=').ok_or("must be NAME=r,g,b")?;
    let values: [f64; 3] = numbers(values)?;
    if values.iter().any(|v| !(0.0..=1.0).contains(v)) {
        return Err("reflectances are within 0 to 1".into());
    }
    Ok((name.to_owned(), values))
}

/// The models under way to a scene.
#[derive(Default)]
struct Import {
    objects: Vec<(String, Mesh)>,
    materials: BTreeMap<String, MaterialEntry>,
    /// Images by the name they will have beside the scene file.
    textures: BTreeMap<String, Vec<u8>>,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let common = &arguments.common;
    if !(arguments.scale.is_finite() && arguments.scale > 0.0) {
        return Err(Failure::input(format!("--scale {}: must be positive", arguments.scale)));
    }
    if let Some([.., candela]) = arguments.lamp.iter().find(|l| l[3] < 0.0) {
        return Err(Failure::input(format!("--lamp: {candela} candela are below 0")));
    }
    if arguments.cell.is_some_and(|c| !(c.is_finite() && c > 0.0)) {
        return Err(Failure::input("--cell must be a positive length in metres"));
    }
    let (mesh_path, folder) = (arguments.out.with_extension("obj"), arguments.out.parent().unwrap_or(Path::new("")));
    output::file(&arguments.out)?;
    output::file(&mesh_path)?;
    if mesh_path == arguments.out {
        return Err(Failure::input(format!("{}: this is where the meshes go; let --out end in .ron", mesh_path.display())));
    }
    if arguments.models.iter().any(|m| m.canonicalize().is_ok_and(|m| mesh_path.canonicalize().is_ok_and(|p| p == m))) {
        return Err(Failure::input(format!(
            "{}: the meshes would overwrite this model; give --out another name",
            mesh_path.display()
        )));
    }
    let mut import = Import::default();
    for model in &arguments.models {
        import.model(model, arguments)?;
    }
    if import.objects.iter().flat_map(|(_, m)| &m.positions).any(|p| !within_reach(*p)) {
        let what = format!("--scale {}: the models then reach farther than {FARTHEST:e} m from the origin", arguments.scale);
        return Err(Failure::input(what));
    }
    let changed = import.reflectances(&arguments.reflectance)?;
    let file = import.scene_file(arguments, &changed)?;
    for (name, image) in &import.textures {
        let path = folder.join(name);
        // What is there already is the same image.
        if !path.exists() {
            output::write(&path, |out| out.write_all(image))?;
        }
    }
    let meshes: Vec<(String, &Mesh)> = import.objects.iter().map(|(name, mesh)| (name.clone(), mesh)).collect();
    output::write(&mesh_path, |out| write_obj(out, &meshes))?;
    write_ron(&arguments.out, &file)?;
    let triangles: usize = import.objects.iter().map(|(_, m)| m.triangles.len()).sum();
    if common.json {
        let summary = serde_json::json!({ "scene": arguments.out, "objects": import.objects.len(), "triangles": triangles });
        output::json(None, &summary, true)?;
    } else if common.talks() {
        say(&format!(
            "{} objects, {triangles} triangles: {} and {}",
            import.objects.len(),
            arguments.out.display(),
            mesh_path.display()
        ));
        if arguments.lamp.is_empty() {
            say("there is no lamp yet: add one to the scene file, or give --lamp x,y,z,cd");
        }
    }
    Ok(())
}

impl Import {
    fn model(&mut self, path: &Path, arguments: &Arguments) -> Result<(), Failure> {
        let (model, warnings) = read_obj(path, Strictness::Import)?;
        arguments.common.warn(&warnings);
        let mut renamed = BTreeMap::new();
        for material in &model.materials {
            renamed.insert(material.name.clone(), self.material(path, material, arguments)?);
        }
        for mut part in model.parts {
            for name in &mut part.mesh.materials {
                *name = renamed.get(name).unwrap_or(name).clone();
                let grey = || MaterialEntry { reflectance: DVec3::splat(0.5), texture: None };
                self.materials.entry(name.clone()).or_insert_with(grey);
            }
            part.mesh.positions.iter_mut().for_each(|p| *p *= arguments.scale);
            let name = self.free_name(&part.name);
            self.objects.push((name, part.mesh));
        }
        Ok(())
    }

    /// Takes over a material; returns its name, numbered if another model means something else by it.
    fn material(&mut self, path: &Path, material: &MtlMaterial, arguments: &Arguments) -> Result<String, Failure> {
        if material.emission.iter().any(|e| *e > 0.0) && !arguments.common.quiet {
            let what = "it glows (Ke), but lamps are points: it becomes a plain surface; give --lamp x,y,z,cd for its light";
            eprintln!("warning: {}: material '{}': {what}", path.display(), material.name);
        }
        let folder = arguments.out.parent().unwrap_or(Path::new(""));
        let texture = material.texture.as_ref().map(|t| self.texture(t, folder)).transpose()?;
        let entry = MaterialEntry { reflectance: material.reflectance.into(), texture };
        let numbered = (2..).map(|k| format!("{} {k}", material.name));
        let fits = |name: &String| self.materials.get(name).is_none_or(|known| *known == entry);
        let name = std::iter::once(material.name.clone()).chain(numbered).find(fits).unwrap_or_default();
        self.materials.insert(name.clone(), entry);
        Ok(name)
    }

    /// Keeps an image for `folder`, and returns a name that no other image has, neither here nor there already.
    fn texture(&mut self, path: &Path, folder: &Path) -> Result<String, Failure> {
        let image = std::fs::read(path).map_err(|e| SceneError::read(path, e))?;
        let part = |p: Option<&std::ffi::OsStr>| p.unwrap_or_default().to_string_lossy().into_owned();
        let (whole, stem, extension) = (part(path.file_name()), part(path.file_stem()), part(path.extension()));
        let numbered = (2..).map(|k| format!("{stem} {k}.{extension}"));
        let other = |name: &String| match self.textures.get(name) {
            Some(known) => *known != image,
            None => folder.join(name).exists() && std::fs::read(folder.join(name)).ok().as_ref() != Some(&image),
        };
        let name = std::iter::once(whole).chain(numbered).find(|n| !other(n)).unwrap_or_default();
        self.textures.insert(name.clone(), image);
        Ok(name)
    }

    /// `name`, or `name 2` and so on if another model has it already.
    fn free_name(&self, name: &str) -> String {
        let taken = |n: &str| self.objects.iter().any(|(known, _)| known == n);
        let name = if name.trim().is_empty() { "object" } else { name };
        let numbered = (2..).map(|k| format!("{name} {k}"));
        std::iter::once(name.to_owned()).chain(numbered).find(|n| !taken(n)).unwrap_or_default()
    }

    /// Applies --reflectance; returns the objects that get a material of their own.
    fn reflectances(&mut self, given: &[(String, [f64; 3])]) -> Result<Vec<String>, Failure> {
        let mut own = Vec::new();
        for (name, reflectance) in given {
            let entry = MaterialEntry { reflectance: (*reflectance).into(), texture: None };
            if self.materials.contains_key(name) {
                self.materials.insert(name.clone(), entry);
            } else if self.objects.iter().any(|(n, _)| n == name) {
                self.materials.insert(name.clone(), entry);
                own.push(name.clone());
            } else {
                let known = self.materials.keys().chain(self.objects.iter().map(|(n, _)| n)).map(String::as_str);
                return Err(Failure::input(format!("--reflectance: {}", unknown("material or object", name, known))));
            }
        }
        Ok(own)
    }

    fn scene_file(&self, arguments: &Arguments, own_material: &[String]) -> Result<SceneFile, Failure> {
        let all = arguments.movable.iter().any(|m| m == "all");
        for name in arguments.movable.iter().filter(|m| *m != "all") {
            if !self.objects.iter().any(|(n, _)| n == name) {
                let known = self.objects.iter().map(|(n, _)| n.as_str());
                return Err(Failure::input(format!("--movable: {}", unknown("object", name, known))));
            }
        }
        let name = arguments.out.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mesh = arguments.out.with_extension("obj").file_name().unwrap_or_default().to_string_lossy().into_owned();
        let objects = self.objects.iter().map(|(name, _)| ObjectEntry {
            name: name.clone(),
            mesh: mesh.clone(),
            part: Some(name.clone()),
            position: DVec3::ZERO,
            rotation: DVec3::ZERO,
            on: None,
            movable: all || arguments.movable.contains(name),
            material: own_material.contains(name).then(|| name.clone()),
            hidden_from_camera: false,
        });
        let lamps = arguments.lamp.iter().enumerate().map(|(n, [x, y, z, candela])| LampEntry {
            name: format!("lamp {}", n + 1),
            position: DVec3::new(*x, *y, *z),
            rotation: DVec3::ZERO,
            on: None,
            intensity: DVec3::splat(*candela),
            rated: None,
            off: false,
            photometry: None,
            direct: Direct::Rasteriser,
        });
        let up = if arguments.up == UpArgument::Y { Up::Y } else { Up::Z };
        let (low, high) = self.bounds();
        Ok(SceneFile {
            name,
            up,
            reach: None,
            origin: DVec3::ZERO,
            cell: arguments.cell.unwrap_or_else(|| self.default_cell()),
            materials: self.materials.clone(),
            objects: objects.collect(),
            lamps: lamps.collect(),
            cameras: self.inside(up, low, high).into_iter().chain([camera(up, low, high)]).collect(),
        })
    }

    /// A camera in the room, if the model is one: seen from in front, a closed room is black. It looks from a corner across the middle.
    fn inside(&self, up: Up, low: DVec3, high: DVec3) -> Option<CameraEntry> {
        let middle = (low + high) / 2.0;
        let around = (-1..=1).flat_map(|x| {
            (-1..=1).flat_map(move |y| (-1..=1).map(move |z| DVec3::new(f64::from(x), f64::from(y), f64::from(z))))
        });
        let closed = around.filter(|way| *way != DVec3::ZERO).all(|way| self.nearest(middle, way.normalize()).is_some());
        let upwards = up.axis();
        let corner = (low - middle) * (DVec3::ONE - upwards) + (high - middle) * upwards * 0.4;
        let free = self.nearest(middle, corner.normalize()).filter(|_| closed)?;
        let eye = middle + corner.normalize() * free * 0.85;
        let target = middle + (middle - eye) * (DVec3::ONE - upwards * 2.0) * 0.3;
        (eye != target).then(|| CameraEntry { name: "inside".into(), eye, target, fov: 70.0 })
    }

    /// Distance to the nearest triangle (Möller and Trumbore 1997). A few rays: all triangles are tried.
    fn nearest(&self, from: DVec3, along: DVec3) -> Option<f64> {
        let meet = |[a, b, c]: [DVec3; 3]| {
            let (u, v) = (b - a, c - a);
            let p = along.cross(v);
            let determinant = u.dot(p);
            let q = (from - a).cross(u);
            let [s, t, distance] = [(from - a).dot(p), along.dot(q), v.dot(q)].map(|x| x / determinant);
            (s >= 0.0 && t >= 0.0 && s + t <= 1.0 && distance > 1e-9).then_some(distance)
        };
        let triangles = self.objects.iter().flat_map(|(_, mesh)| (0..mesh.triangles.len()).map(|t| mesh.corners(t)));
        triangles.filter_map(meet).min_by(f64::total_cmp)
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        let points = || self.objects.iter().flat_map(|(_, m)| m.positions.iter().copied());
        (points().fold(DVec3::INFINITY, DVec3::min), points().fold(DVec3::NEG_INFINITY, DVec3::max))
    }

    /// Fine enough for the shadows of furniture and for 12,000 right-angled elements over all surfaces, if not too many come of it; to two digits.
    fn default_cell(&self) -> f64 {
        let triangles = || self.objects.iter().flat_map(|(_, m)| (0..m.triangles.len()).map(|t| m.corners(t)));
        let area: f64 = triangles().map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum();
        // None: more than can be numbered.
        let elements = |cell: f64| -> Option<u64> {
            self.objects.iter().map(|(_, mesh)| Lattice::new(mesh, cell).map(|lattice| u64::from(lattice.cells()))).sum()
        };
        // However large they are, triangles have one element each at least.
        let most = MOST_ELEMENTS.max(2 * triangles().count() as u64);
        let mut cell = (4.0 * area / 12_000.0).sqrt().clamp(1e-6, FURNITURE);
        while elements(cell).is_none_or(|elements| elements > most) {
            cell *= 1.1;
        }
        let digit = 10f64.powf(cell.log10().floor() - 1.0);
        (cell / digit).round() * digit
    }
}

/// In front of the model, looking at its middle; front is towards +z with y up and towards −y with z up.
fn camera(up: Up, low: DVec3, high: DVec3) -> CameraEntry {
    let middle = (low + high) / 2.0;
    let size = high - low;
    let eye = match up {
        Up::Y => middle + DVec3::Z * (size.z / 2.0 + size.x.max(size.y) * 1.3),
        Up::Z => middle - DVec3::Y * (size.y / 2.0 + size.x.max(size.z) * 1.3),
    };
    CameraEntry { name: "front".into(), eye, target: middle, fov: 45.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of 4 × 3 × 2 m, with or without its side towards −y.
    fn walls(open: bool) -> Import {
        let positions = (0..8).map(|n| DVec3::new([0.0, 4.0][n & 1], [0.0, 3.0][n >> 1 & 1], [0.0, 2.0][n >> 2])).collect();
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let sides = sides.into_iter().filter(|side| !(open && *side == [0, 1, 5, 4]));
        let triangles: Vec<[u32; 3]> = sides.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let mesh =
            Mesh { material_of: vec![0; triangles.len()], positions, triangles, materials: vec!["grey".into()], uvs: Vec::new() };
        Import { objects: vec![("room".into(), mesh)], ..Import::default() }
    }

    #[test]
    fn elements_are_as_fine_as_furniture_needs_and_not_too_many() {
        let cell = |scale: f64| {
            let mut import = walls(false);
            import.objects[0].1.positions.iter_mut().for_each(|p| *p *= scale);
            import.default_cell()
        };
        // 52 m² in 12,000 right-angled elements.
        assert_eq!(cell(1.0), 0.13);
        // As many for 468 m² had 0.39 m.
        assert_eq!(cell(3.0), FURNITURE);
        // 60 × 45 × 30 m at 0.15 m had 2.3 million; 12,000 had 2 m.
        assert!((0.34..0.42).contains(&cell(15.0)), "{}", cell(15.0));
        // Triangles that are long and thin have many elements for their area: 4 km × 3 mm.
        let mut slivers = walls(false);
        slivers.objects[0].1.positions.iter_mut().for_each(|p| *p *= DVec3::new(1000.0, 0.001, 0.001));
        assert!((16.0..21.0).contains(&slivers.default_cell()), "{}", slivers.default_cell());
    }

    #[test]
    fn closed_rooms_are_seen_from_inside() {
        let (low, high) = walls(false).bounds();
        for up in [Up::Y, Up::Z] {
            let camera = walls(false).inside(up, low, high).unwrap();
            assert!(camera.eye.cmpgt(low).all() && camera.eye.cmplt(high).all() && camera.view().fault().is_none());
            assert!((camera.target - camera.eye).dot((low + high) / 2.0 - camera.eye) > 0.0, "it looks across the middle");
            assert!(walls(true).inside(up, low, high).is_none(), "in front of an open one is where one sees it from");
        }
    }
}
