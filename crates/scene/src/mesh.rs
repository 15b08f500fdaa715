//! An object's triangles, in the object's own space.

use glam::{DVec2, DVec3};

/// Triangles of one object, in metres, before its pose.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Vertices, metres.
    pub positions: Vec<DVec3>,
    /// Indices into `positions`, three a triangle; counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Per triangle, an index into `materials`.
    pub material_of: Vec<u16>,
    /// The names of the materials used.
    pub materials: Vec<String>,
    /// Texture coordinates of each triangle's corners (v = 0 at the image's bottom); empty where the file has none.
    pub uvs: Vec<[DVec2; 3]>,
}

impl Mesh {
    /// The corners of triangle `t`, metres.
    pub fn corners(&self, t: usize) -> [DVec3; 3] {
        self.triangles[t].map(|i| self.positions[i as usize])
    }
}

impl Mesh {
    /// One mesh of several, in their order; materials of the same name become one.
    pub fn merged<'a>(meshes: impl Iterator<Item = &'a Mesh> + Clone) -> Mesh {
        let mut all = Mesh::default();
        let textured = meshes.clone().any(|m| !m.uvs.is_empty());
        for mesh in meshes {
            let first = all.positions.len() as u32;
            all.positions.extend_from_slice(&mesh.positions);
            all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|i| i + first)));
            let number: Vec<u16> = mesh
                .materials
                .iter()
                .map(|name| {
                    let known = all.materials.iter().position(|m| m == name);
                    known.unwrap_or_else(|| {
                        all.materials.push(name.clone());
                        all.materials.len() - 1
                    }) as u16
                })
                .collect();
            all.material_of.extend(mesh.material_of.iter().map(|m| number[usize::from(*m)]));
            if textured {
                let blank = [[DVec2::ZERO; 3]];
                let uvs = if mesh.uvs.is_empty() { blank.repeat(mesh.triangles.len()) } else { mesh.uvs.clone() };
                all.uvs.extend(uvs);
            }
        }
        all
    }
}
