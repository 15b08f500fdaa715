//! Wavefront OBJ and MTL: parts with names, triangles and materials.
//!
//! The format: <http://paulbourke.net/dataformats/obj/> and <http://paulbourke.net/dataformats/mtl/>.
//! The reader of numbers and faces is `tobj`. What it gets wrong is settled before it sees the text, so that every
//! fault has a line number and nothing in it can fail or panic; each trap has a test of its name in `traps.rs`:
//!
//! | `tobj` 4.0                                                | here |
//! |-----------------------------------------------------------|------|
//! | cuts polygons into fans, wrong for concave ones           | it hands over polygons; `polygon` cuts them |
//! | forgets `usemtl` names when the MTL is missing            | `scan` keeps the names; `tobj` sees none |
//! | one model per `usemtl`, names shifted when it precedes `g`| `naming` gives each face its part and material |
//! | takes an index of 0 as "none", wraps indices before the first | `scan` checks indices, with the line |
//! | reads `nan` and `inf` as coordinates                      | `scan` checks vertices, with the line |
//! | divides by `v`'s fourth number, fails on partial colours  | `scan` passes three numbers |
//! | renumbers vertices by first use, invents missing `vt`     | `build` undoes the first, `scan` marks the second |
//! | fails on bytes that are not UTF-8, on `\` at a line's end | `text` decodes and joins |
//! | panics on `Kd 0.5`, drops a whole MTL for one bad line    | `mtl` reads the few statements that count |
//!
//! A path through the files: `text` → `scan` → `naming` → `build` (→ `polygon`) → `mtl`; back out: `write`.

mod build;
#[cfg(test)]
mod corpus;
mod mtl;
mod naming;
mod polygon;
mod scan;
mod text;
#[cfg(test)]
mod traps;
mod write;

use std::path::{Path, PathBuf};

use crate::error::{SceneError, Warning};
use crate::mesh::Mesh;
pub use write::write_obj;

/// What an OBJ file holds, in the file's own units and axes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ObjFile {
    /// In the order of their first face; names are unique, every mesh has triangles.
    pub parts: Vec<ObjPart>,
    /// The materials that parts use *and* a material file defines, in the order of their first face; names are
    /// unique. For a name that is not here, [`MtlMaterial::undefined`] is what the warnings announce.
    pub materials: Vec<MtlMaterial>,
}

/// All faces of one name.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjPart {
    /// The `o` name, or the `g` name in a file without `o`; the file's stem for faces outside of any.
    pub name: String,
    /// Triangles in file order, vertices in file order (only those used), materials in the order of their first face.
    pub mesh: Mesh,
}

/// What light needs of an MTL material.
#[derive(Debug, Clone, PartialEq)]
pub struct MtlMaterial {
    /// The `newmtl` name.
    pub name: String,
    /// `Kd`: diffuse reflectance, linear Rec. 709 channels in 0..=1.
    pub reflectance: [f64; 3],
    /// `map_Kd`: an image file that exists; it multiplies `reflectance`.
    pub texture: Option<PathBuf>,
    /// `Ke`: emission, linear Rec. 709 channels, at least 0, without a unit.
    pub emission: [f64; 3],
}

impl MtlMaterial {
    /// The stand-in for a material without definition: half grey, dark.
    pub fn undefined(name: &str) -> Self {
        Self { name: name.to_owned(), reflectance: [0.5; 3], texture: None, emission: [0.0; 3] }
    }
}

/// What happens to triangles without area. They have no normal and receive no light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Strictness {
    /// A zero-area triangle is an error that names file, object and triangle.
    Scene,
    /// Zero-area triangles and polygons are dropped, with one warning.
    Import,
}

/// Reads an OBJ file and the material files that it names.
///
/// # Errors
/// A file that cannot be read, a malformed or not finite vertex, a face with an index that is 0 or beyond the
/// vertices, no triangles at all, or (with [`Strictness::Scene`]) a triangle without area.
pub fn read_obj(path: &Path, strictness: Strictness) -> Result<(ObjFile, Vec<Warning>), SceneError> {
    let text = text::read(path).map_err(|why| SceneError::read(path, why))?;
    let mut warnings = Vec::new();
    let scan = scan::scan(path, &text, &mut warnings)?;
    drop(text);
    let stem = path.file_stem().map_or_else(|| "object".into(), |s| s.to_string_lossy().into_owned());
    let naming = naming::assign(&scan.statements, &stem);
    if !naming.late_groups.is_empty() {
        warnings.push(Warning(format!(
            "{}: faces of {} come before their `g` line; they are put into the group of their material's name",
            path.display(),
            quoted(&naming.late_groups)
        )));
    }
    let libraries = scan.libraries.clone();
    let parts = build::parts(path, scan, &naming, strictness, &mut warnings)?;
    let used: Vec<&str> = naming
        .materials
        .iter()
        .map(String::as_str)
        .filter(|name| parts.iter().any(|part| part.mesh.materials.iter().any(|used| used == name)))
        .collect();
    let materials = mtl::load(path, &libraries, &used, strictness, &mut warnings);
    Ok((ObjFile { parts, materials }, warnings))
}

/// `a`, `b`, `c` and 4 more: names for a message of one line.
fn quoted<S: AsRef<str>>(names: &[S]) -> String {
    const SHOWN: usize = 8;
    let list = names.iter().take(SHOWN).map(|n| format!("`{}`", n.as_ref().escape_debug())).collect::<Vec<_>>();
    match names.len().saturating_sub(SHOWN) {
        0 => list.join(", "),
        more => format!("{} and {more} more", list.join(", ")),
    }
}
