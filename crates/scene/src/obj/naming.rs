//! Which part and which material each face belongs to.
//!
//! `o` names parts; in a file without any `o`, `g` does; faces before the first name belong to a part of the file's
//! name. A name that returns is the same part. Materials persist until the next `usemtl`, across parts.
//!
//! One repair: some files put the faces of a group before its `g` line (the McGuire archive's Cornell box: `usemtl
//! shortBox`, six faces, `g shortBox`, no faces). Read to the letter, each box would belong to its predecessor.

use std::collections::HashMap;

use super::scan::Statement;

/// The material of faces before any `usemtl`.
pub const NO_MATERIAL: &str = "default";

/// Consecutive faces of one part and one material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// Index into [`Naming::parts`].
    pub part: usize,
    /// Index into [`Naming::materials`].
    pub material: usize,
    /// Number of faces.
    pub faces: usize,
}

/// Names in the order of their first face.
#[derive(Debug, Default)]
pub struct Naming {
    pub parts: Vec<String>,
    pub materials: Vec<String>,
    /// In file order; together all faces of the file.
    pub runs: Vec<Run>,
    /// The groups that got faces written before their `g` line.
    pub late_groups: Vec<String>,
}

/// Gives all faces of a file their names; `stem` is for those without.
pub fn assign(statements: &[Statement], stem: &str) -> Naming {
    let has_objects = statements.iter().any(|s| matches!(s, Statement::Object(_)));
    let mut naming = Naming::default();
    let (mut part_ids, mut material_ids) = (HashMap::new(), HashMap::new());
    let (mut part, mut material) = (stem, NO_MATERIAL);
    let mut named = false;
    for (at, statement) in statements.iter().enumerate() {
        match statement {
            Statement::Object(name) => (part, named) = (or(name, stem), true),
            Statement::Group(name) if !has_objects => (part, named) = (or(name, stem), true),
            Statement::Group(_) => {}
            Statement::Material(name) => material = or(name, NO_MATERIAL),
            Statement::Faces(faces) => {
                let may_be_late = !has_objects && (!named || part_ids.contains_key(part)) && material != part;
                let owner = if may_be_late && closes_with_group(&statements[at + 1..], material) {
                    naming.late_groups.push(material.to_owned());
                    material
                } else {
                    part
                };
                let part = id(&mut part_ids, &mut naming.parts, owner);
                let material = id(&mut material_ids, &mut naming.materials, material);
                naming.runs.push(Run { part, material, faces: *faces });
            }
        }
    }
    naming
}

/// Whether a `g` of this name follows at once and gets no faces of its own in this material.
fn closes_with_group(next: &[Statement], name: &str) -> bool {
    let Some(Statement::Group(group)) = next.first() else { return false };
    let repeats = |s: &&Statement| matches!(s, Statement::Material(m) if m == name);
    group == name && !matches!(next[1..].iter().find(|s| !repeats(s)), Some(Statement::Faces(_)))
}

fn or<'a>(name: &'a str, otherwise: &'a str) -> &'a str {
    if name.is_empty() { otherwise } else { name }
}

fn id<'a>(ids: &mut HashMap<&'a str, usize>, names: &mut Vec<String>, name: &'a str) -> usize {
    *ids.entry(name).or_insert_with(|| {
        names.push(name.to_owned());
        names.len() - 1
    })
}

#[cfg(test)]
mod tests {
    use super::Statement::{Faces, Group, Material, Object};
    use super::*;

    fn named(statements: &[Statement]) -> Vec<(String, String, usize)> {
        let naming = assign(statements, "file");
        let name = |r: &Run| (naming.parts[r.part].clone(), naming.materials[r.material].clone(), r.faces);
        naming.runs.iter().map(name).collect()
    }

    fn expect(statements: &[Statement], runs: &[(&str, &str, usize)]) {
        let runs: Vec<_> = runs.iter().map(|&(p, m, n)| (p.to_owned(), m.to_owned(), n)).collect();
        assert_eq!(named(statements), runs);
    }

    fn g(name: &str) -> Statement {
        Group(name.into())
    }

    fn m(name: &str) -> Statement {
        Material(name.into())
    }

    #[test]
    fn objects_win_over_groups() {
        let o = |name: &str| Object(name.into());
        expect(
            &[g("x"), Faces(1), o("a"), g("y"), m("red"), Faces(2), o("b"), Faces(3), o("a"), Faces(4), o(""), Faces(5)],
            &[("file", "default", 1), ("a", "red", 2), ("b", "red", 3), ("a", "red", 4), ("file", "red", 5)],
        );
    }

    #[test]
    fn groups_name_parts_where_there_are_no_objects() {
        expect(
            &[Faces(1), m("red"), g("a"), Faces(2), m("blue"), Faces(3), g("b"), Faces(4)],
            &[("file", "default", 1), ("a", "red", 2), ("a", "blue", 3), ("b", "blue", 4)],
        );
    }

    #[test]
    fn a_group_line_after_its_faces_gets_them() {
        expect(
            &[g("wall"), m("wall"), Faces(1), m("box"), Faces(6), g("box"), m("box"), m("lamp"), Faces(2), g("lamp")],
            &[("wall", "wall", 1), ("box", "box", 6), ("lamp", "lamp", 2)],
        );
    }

    #[test]
    fn a_group_with_faces_of_its_own_takes_no_others() {
        expect(
            &[g("a"), m("a"), Faces(1), m("b"), Faces(2), g("b"), m("b"), Faces(3)],
            &[("a", "a", 1), ("a", "b", 2), ("b", "b", 3)],
        );
        expect(&[g("a"), m("b"), Faces(2), g("b"), m("c"), Faces(3)], &[("a", "b", 2), ("b", "c", 3)]);
    }
}
