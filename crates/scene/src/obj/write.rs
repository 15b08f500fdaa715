//! Writes meshes as OBJ text that [`read_obj`](super::read_obj) turns into the same meshes, bit for bit.

use std::collections::{HashMap, HashSet};
use std::io::{self, Write};

use crate::mesh::Mesh;

/// Writes each part as an `o` with its vertices, texture coordinates if it has any, and triangles under their
/// `usemtl`. Numbers are the shortest decimals that read back as the same bits.
///
/// What OBJ cannot say is not kept: vertices that no triangle uses, and an order of `materials` other than that of
/// their first triangle.
///
/// # Errors
/// What `out` reports; [`io::ErrorKind::InvalidInput`] for names that are empty, doubled, have a line break or a blank
/// at an end, or end in `\`, and for numbers that are not finite.
pub fn write_obj(out: &mut impl Write, parts: &[(String, &Mesh)]) -> io::Result<()> {
    let (mut vertices, mut uvs) = (0, 0);
    let mut names = HashSet::new();
    for (name, mesh) in parts {
        if !names.insert(name) {
            return Err(invalid(format!("two objects are named `{}`", name.escape_debug())));
        }
        writeln!(out, "o {}", writable(name)?)?;
        for p in &mesh.positions {
            writeln!(out, "v {} {} {}", Decimal::new(p.x)?, Decimal::new(p.y)?, Decimal::new(p.z)?)?;
        }
        // Equal texture coordinates are written once.
        let mut places = HashMap::new();
        for uv in mesh.uvs.iter().flatten() {
            let next = uvs + places.len() + 1;
            let place = *places.entry([uv.x.to_bits(), uv.y.to_bits()]).or_insert(next);
            if place == next {
                writeln!(out, "vt {} {}", Decimal::new(uv.x)?, Decimal::new(uv.y)?)?;
            }
        }
        let mut current = None;
        for (t, (triangle, &material)) in mesh.triangles.iter().zip(&mesh.material_of).enumerate() {
            if current != Some(material) {
                writeln!(out, "usemtl {}", writable(&mesh.materials[material as usize])?)?;
                current = Some(material);
            }
            write!(out, "f")?;
            for corner in 0..3 {
                write!(out, " {}", vertices + triangle[corner] as usize + 1)?;
                if let Some(uv) = mesh.uvs.get(t).map(|uvs| uvs[corner]) {
                    write!(out, "/{}", places[&[uv.x.to_bits(), uv.y.to_bits()]])?;
                }
            }
            writeln!(out)?;
        }
        vertices += mesh.positions.len();
        uvs += places.len();
    }
    Ok(())
}

fn invalid(what: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, what)
}

/// A name that a reader finds again as the rest of its line.
fn writable(name: &str) -> io::Result<&str> {
    if name.is_empty() || name.trim() != name || name.contains(['\n', '\r']) || name.ends_with('\\') {
        return Err(invalid(format!("`{}` cannot be a name in an OBJ file", name.escape_debug())));
    }
    Ok(name)
}

/// The shortest decimal of a finite number: with an exponent where zeros would be most of it.
struct Decimal(f64);

impl Decimal {
    fn new(number: f64) -> io::Result<Self> {
        if number.is_finite() { Ok(Self(number)) } else { Err(invalid(format!("{number} is not a coordinate"))) }
    }
}

impl std::fmt::Display for Decimal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0 == 0.0 || (1e-5..1e16).contains(&self.0.abs()) { write!(f, "{}", self.0) } else { write!(f, "{:e}", self.0) }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};
    use proptest::prelude::*;

    use super::super::polygon::has_no_area;
    use super::super::{ObjFile, ObjPart, Strictness, read_obj};
    use super::*;

    fn read_back(parts: &[(String, &Mesh)]) -> ObjFile {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.obj");
        let mut text = Vec::new();
        write_obj(&mut text, parts).expect("writable parts");
        std::fs::write(&path, &text).expect("a file");
        let (file, warnings) = read_obj(&path, Strictness::Scene).expect("a readable file");
        assert_eq!(warnings, []);
        file
    }

    /// `==` takes -0 for 0; their bits differ.
    fn bits(mesh: &Mesh) -> Vec<u64> {
        let uvs = mesh.uvs.iter().flatten().flat_map(|uv| uv.to_array());
        mesh.positions.iter().flat_map(|p| p.to_array()).chain(uvs).map(f64::to_bits).collect()
    }

    fn number() -> impl Strategy<Value = f64> {
        prop_oneof![-10.0..10.0, -1e-7..1e-7, -1e200..1e200, Just(-0.0), Just(f64::MIN_POSITIVE), Just(5e-324)]
    }

    prop_compose! {
        /// Any mesh without unused vertices, unused materials and flat triangles.
        fn mesh()(
            points in prop::collection::vec([number(), number(), number()], 12..30),
            uvs in prop::option::of(prop::collection::vec([number(), number()], 90)),
            materials in prop::collection::vec(0..3_u16, 30),
        ) -> Mesh {
            let points: Vec<DVec3> = points.into_iter().map(DVec3::from).collect();
            let mut mesh = Mesh::default();
            let corner = |i: usize, c: usize| DVec2::from(uvs.as_ref().map_or([0.0; 2], |uvs| uvs[3 * i + c]));
            for (i, triangle) in points.chunks_exact(3).enumerate() {
                let triangle = [triangle[2], triangle[0], triangle[1]];
                if has_no_area(triangle) {
                    continue;
                }
                let name = format!("m {}", materials[i]);
                let known = mesh.materials.iter().position(|m| *m == name);
                mesh.material_of.push(known.unwrap_or(mesh.materials.len()) as u16);
                if known.is_none() {
                    mesh.materials.push(name);
                }
                let base = mesh.positions.len() as u32;
                mesh.positions.extend(triangle);
                // Not the order of first use.
                mesh.triangles.push([base + 2, base, base + 1]);
                if uvs.is_some() {
                    mesh.uvs.push([corner(i, 0), corner(i, 1), corner(i, 2)]);
                }
            }
            mesh
        }
    }

    fn with_triangles() -> impl Strategy<Value = Mesh> {
        mesh().prop_filter("no triangles", |mesh| !mesh.triangles.is_empty())
    }

    proptest! {
        #[test]
        fn reads_back_bit_for_bit(first in with_triangles(), second in with_triangles()) {
            let file = read_back(&[("a b".into(), &first), ("# ü/1".into(), &second)]);
            let parts = [("a b", &first), ("# ü/1", &second)];
            let parts = parts.map(|(name, mesh)| ObjPart { name: name.into(), mesh: mesh.clone() });
            prop_assert_eq!(&file.parts, &parts);
            for (read, written) in file.parts.iter().zip(&parts) {
                prop_assert_eq!(bits(&read.mesh), bits(&written.mesh));
            }
        }
    }

    #[test]
    fn refuses_what_obj_cannot_say() {
        let mesh = Mesh::default();
        for name in ["", " a", "a\nb", "a\\"] {
            let error = write_obj(&mut Vec::new(), &[(name.into(), &mesh)]).expect_err("an unwritable name");
            assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
        }
        assert!(write_obj(&mut Vec::new(), &[("a".into(), &mesh), ("a".into(), &mesh)]).is_err());
        let mesh = Mesh { positions: vec![DVec3::NAN], ..Mesh::default() };
        assert!(write_obj(&mut Vec::new(), &[("a".into(), &mesh)]).is_err());
    }
}
