//! An object's triangles, in the object's own space.

use glam::{DVec2, DVec3};
use std::collections::HashSet;

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

    /// The mesh without triangles that have the corners of an earlier one, in whatever order, and how many those were. Which of such copies a ray
    /// meets is a matter of rounding, so each would have a part of the light, and show it as if it were all.
    pub fn without_copies(mut self) -> (Mesh, usize) {
        let mut seen = HashSet::new();
        let is_new = |t: usize| {
            let mut corners = self.corners(t).map(|p| (p + 0.0).to_array().map(f64::to_bits));
            corners.sort_unstable();
            seen.insert(corners)
        };
        let new: Vec<bool> = (0..self.triangles.len()).map(is_new).collect();
        let copies = new.iter().filter(|new| !**new).count();
        if copies > 0 {
            keep(&mut self.triangles, &new);
            keep(&mut self.material_of, &new);
            keep(&mut self.uvs, &new);
        }
        (self, copies)
    }
}

/// Those of `all` that `which` says; all lists are as long or empty.
fn keep<T>(all: &mut Vec<T>, which: &[bool]) {
    let mut which = which.iter();
    all.retain(|_| which.next().is_some_and(|keep| *keep));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_of_a_triangle_are_left_out() {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, -DVec3::X, -DVec3::ZERO];
        let triangles = vec![[0, 1, 2], [2, 3, 0], [1, 2, 4], [2, 1, 0], [4, 3, 1]];
        let uvs: Vec<[DVec2; 3]> = (0..5).map(|t| [DVec2::splat(f64::from(t)); 3]).collect();
        let materials = vec!["a".to_owned(), "b".to_owned()];
        let mesh = Mesh { positions, triangles, material_of: vec![0, 1, 1, 0, 0], materials, uvs: uvs.clone() };
        let (once, copies) = mesh.clone().without_copies();
        assert_eq!(
            (copies, &once.triangles[..], &once.material_of[..]),
            (2, &[[0, 1, 2], [2, 3, 0], [4, 3, 1]][..], &[0, 1, 0][..])
        );
        assert_eq!(once.uvs, [uvs[0], uvs[1], uvs[4]]);
        let plain = Mesh { uvs: Vec::new(), ..mesh };
        assert_eq!(plain.without_copies().0.uvs, Vec::<[DVec2; 3]>::new());
        assert_eq!(once.clone().without_copies(), (once, 0));
    }
}
