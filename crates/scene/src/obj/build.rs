//! Meshes from a scanned file: `tobj` reads vertices and polygons, which are then cut and dealt out to their parts.

use std::path::Path;

use glam::{DVec2, DVec3};

use super::naming::Naming;
use super::polygon::{Cutter, has_no_area};
use super::scan::{Face, Scan};
use super::{ObjPart, Strictness, quoted};
use crate::error::{SceneError, Warning};
use crate::mesh::Mesh;

/// The parts of a file; `naming` must cover all faces of `scan`.
pub fn parts(
    path: &Path,
    scan: Scan,
    naming: &Naming,
    strictness: Strictness,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<ObjPart>, SceneError> {
    let polygons = Polygons::read(path, &scan)?;
    let mut drafts: Vec<Draft> = naming.parts.iter().map(|_| Draft::new(naming.materials.len())).collect();
    let mut cutter = Cutter::default();
    let (mut corners, mut cut) = (Vec::new(), Vec::new());
    let mut faces = scan.faces.iter().zip(polygons.iter());
    for run in &naming.runs {
        let draft = &mut drafts[run.part];
        for (face, (vertices, uvs)) in faces.by_ref().take(run.faces) {
            corners.clear();
            corners.extend(vertices.iter().map(|&v| polygons.positions[v as usize]));
            cut.clear();
            cutter.cut(&corners, &mut cut);
            for &triangle in &cut {
                if !has_no_area(triangle.map(|i| corners[i as usize])) {
                    draft.add(triangle, face, vertices, uvs, run.material);
                } else if strictness == Strictness::Import {
                    draft.dropped += 1;
                } else {
                    let (name, number) = (&naming.parts[run.part], draft.triangles.len() + 1);
                    let what = format!(
                        "object `{}`, triangle {number} has no area; `lightmend import` cleans the file",
                        name.escape_debug()
                    );
                    return Err(SceneError::line(path, face.line, what));
                }
            }
        }
    }
    warn_of_losses(path, naming, &drafts, warnings);

    let mut local = vec![u32::MAX; polygons.positions.len()];
    let mut parts = Vec::new();
    for (name, draft) in naming.parts.iter().zip(drafts) {
        if !draft.triangles.is_empty() {
            let mesh = draft.finish(path, name, &polygons, &naming.materials, &mut local)?;
            parts.push(ObjPart { name: name.clone(), mesh });
        }
    }
    if parts.is_empty() {
        return Err(SceneError::content(path, "no triangles: all of its faces are points or lines without area"));
    }
    Ok(parts)
}

/// One warning for dropped triangles, one for missing texture coordinates.
fn warn_of_losses(path: &Path, naming: &Naming, drafts: &[Draft], warnings: &mut Vec<Warning>) {
    let names = |lost: &dyn Fn(&Draft) -> bool| {
        let of = naming.parts.iter().zip(drafts).filter(|(_, draft)| lost(draft));
        quoted(&of.map(|(name, _)| name).collect::<Vec<_>>())
    };
    let dropped: usize = drafts.iter().map(|d| d.dropped).sum();
    if dropped > 0 {
        let objects = names(&|d| d.dropped > 0);
        let path = path.display();
        warnings.push(Warning(format!("{path}: zero-area triangles ({dropped}) are dropped, in {objects}")));
    }
    let untextured: usize = drafts.iter().map(Draft::lacking_uvs).sum();
    if untextured > 0 {
        let objects = names(&|d| d.lacking_uvs() > 0);
        warnings.push(Warning(format!(
            "{}: triangles without texture coordinates ({untextured}), in {objects}, get one colour of their texture",
            path.display()
        )));
    }
}

/// What `tobj` read: vertices in file order and polygons that index them.
struct Polygons {
    positions: Vec<DVec3>,
    uvs: Vec<DVec2>,
    /// Per polygon its number of corners.
    corners: Vec<u32>,
    vertex_indices: Vec<u32>,
    /// As long as `vertex_indices`; empty if the file has no texture coordinates.
    uv_indices: Vec<u32>,
}

impl Polygons {
    fn read(path: &Path, scan: &Scan) -> Result<Self, SceneError> {
        // A first face through all vertices: `tobj` numbers vertices by first use, which thereby is file order.
        let mut all = String::from("f");
        for vertex in 1..=scan.vertices {
            all.push(' ');
            all.push_str(&vertex.to_string());
        }
        all.push('\n');
        let mut reader = std::io::Read::chain(all.as_bytes(), scan.text.as_bytes());
        let read = tobj::load_obj_buf(&mut reader, &tobj::LoadOptions::default(), |_| Ok(Default::default()));
        let (models, _) = read.map_err(|why| SceneError::content(path, format!("tobj: {why}")))?;
        // Without `o`, `g` and `usemtl` all is one model.
        let mut mesh = models.into_iter().next().map(|model| model.mesh).unwrap_or_default();
        let mut corners = mesh.face_arities;
        if corners.is_empty() {
            // The way `tobj` says that all are triangles.
            corners = vec![3; mesh.indices.len() / 3];
        }
        corners.drain(..1.min(corners.len()));
        mesh.indices.drain(..scan.vertices.min(mesh.indices.len()));
        mesh.texcoord_indices.drain(..scan.vertices.min(mesh.texcoord_indices.len()));
        let polygons = Self {
            positions: mesh.positions.chunks_exact(3).map(DVec3::from_slice).collect(),
            uvs: mesh.texcoords.chunks_exact(2).map(DVec2::from_slice).collect(),
            corners,
            vertex_indices: mesh.indices,
            uv_indices: mesh.texcoord_indices,
        };
        if polygons.corners.len() != scan.faces.len() || polygons.positions.len() != scan.vertices {
            return Err(SceneError::content(path, "tobj lost faces or vertices; please report this file"));
        }
        Ok(polygons)
    }

    /// Per polygon the indices of its vertices and of its texture coordinates, if the file has any.
    fn iter(&self) -> impl Iterator<Item = (&[u32], &[u32])> {
        self.corners.iter().scan(0, |start, &count| {
            let range = *start..*start + count as usize;
            *start = range.end;
            Some((&self.vertex_indices[range.clone()], self.uv_indices.get(range).unwrap_or_default()))
        })
    }
}

/// A part while its faces come in, with the file's own indices.
struct Draft {
    triangles: Vec<[u32; 3]>,
    /// Indices of texture coordinates, `None` for triangles without.
    uvs: Vec<Option<[u32; 3]>>,
    any_uvs: bool,
    material_of: Vec<usize>,
    /// The file's materials in this part, in the order of their first face.
    materials: Vec<usize>,
    /// The file's material → its place in `materials`.
    place: Vec<Option<usize>>,
    dropped: usize,
}

impl Draft {
    fn new(materials: usize) -> Self {
        Self {
            triangles: Vec::new(),
            uvs: Vec::new(),
            any_uvs: false,
            material_of: Vec::new(),
            materials: Vec::new(),
            place: vec![None; materials],
            dropped: 0,
        }
    }

    /// Adds a triangle given by corners of a polygon.
    fn add(&mut self, triangle: [u32; 3], face: &Face, vertices: &[u32], uvs: &[u32], material: usize) {
        self.triangles.push(triangle.map(|i| vertices[i as usize]));
        let uv = (face.has_uvs && !uvs.is_empty()).then(|| triangle.map(|i| uvs[i as usize]));
        self.any_uvs |= uv.is_some();
        self.uvs.push(uv);
        let place = *self.place[material].get_or_insert_with(|| {
            self.materials.push(material);
            self.materials.len() - 1
        });
        self.material_of.push(place);
    }

    /// Triangles without texture coordinates among those of materials that have them elsewhere in this part.
    fn lacking_uvs(&self) -> usize {
        let mut textured = vec![false; self.materials.len()];
        let triangles = || self.material_of.iter().zip(&self.uvs);
        triangles().for_each(|(material, uv)| textured[*material] |= uv.is_some());
        triangles().filter(|(material, uv)| textured[**material] && uv.is_none()).count()
    }

    /// The mesh, with the vertices that it uses alone. `local` is scratch, all `u32::MAX` before and after.
    fn finish(
        self,
        path: &Path,
        name: &str,
        polygons: &Polygons,
        materials: &[String],
        local: &mut [u32],
    ) -> Result<Mesh, SceneError> {
        let mut used: Vec<u32> = self.triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        for (new, &old) in (0..).zip(&used) {
            local[old as usize] = new;
        }
        let triangles = self.triangles.iter().map(|t| t.map(|i| local[i as usize])).collect();
        used.iter().for_each(|&old| local[old as usize] = u32::MAX);

        let material_of = self.material_of.iter().map(|&m| u16::try_from(m)).collect::<Result<_, _>>();
        let material_of = material_of.map_err(|_| {
            let what = format!("object `{}` has more than 65536 materials: split it", name.escape_debug());
            SceneError::content(path, what)
        })?;
        let at = |i: u32| polygons.uvs[i as usize];
        Ok(Mesh {
            positions: used.iter().map(|&i| polygons.positions[i as usize]).collect(),
            triangles,
            material_of,
            materials: self.materials.iter().map(|&m| materials[m].clone()).collect(),
            uvs: if self.any_uvs {
                self.uvs.iter().map(|uv| uv.map_or([DVec2::ZERO; 3], |uv| uv.map(at))).collect()
            } else {
                Vec::new()
            },
        })
    }
}
