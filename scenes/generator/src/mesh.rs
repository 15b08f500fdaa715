//! An OBJ file: named parts, each a list of solids.

use std::fmt::Write;

use crate::solid::Solid;

/// A named part of a mesh: one `o` of its OBJ file.
#[derive(Clone, Debug)]
pub struct Part {
    /// The name that a scene's `part` refers to.
    pub name: String,
    /// What it consists of.
    pub solids: Vec<Solid>,
}

/// One OBJ file.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// File name without its ending.
    pub name: String,
    /// In the order of the file.
    pub parts: Vec<Part>,
}

impl Mesh {
    /// A mesh of one part, which carries its name.
    pub fn new(name: &str, solids: Vec<Solid>) -> Self {
        Mesh { name: name.to_string(), parts: vec![Part { name: name.to_string(), solids }] }
    }

    /// All solids of all parts.
    pub fn solids(&self) -> impl Iterator<Item = &Solid> {
        self.parts.iter().flat_map(|p| &p.solids)
    }

    /// The number of mesh elements of the part `part` (all parts if none) for elements of `cell` metres.
    pub fn cells(&self, part: Option<&str>, cell: f64) -> usize {
        self.parts.iter().filter(|p| part.is_none_or(|n| n == p.name)).flat_map(|p| &p.solids).map(|s| s.cells(cell)).sum()
    }

    /// The text of the OBJ file, in metres, at most five decimals, so that it is the same on every machine.
    pub fn obj(&self) -> String {
        let mut text = String::from("# Written by lightmend-scenes; metres, z up.\n");
        let (mut points, mut uvs) = (1, 1);
        let mut material = "";
        for part in &self.parts {
            put(&mut text, format_args!("o {}", part.name));
            for s in &part.solids {
                if s.material != material {
                    put(&mut text, format_args!("usemtl {}", s.material));
                    material = s.material;
                }
                for p in &s.points {
                    put(&mut text, format_args!("v {} {} {}", number(p.x), number(p.y), number(p.z)));
                }
                for t in &s.uv {
                    put(&mut text, format_args!("vt {} {}", number(t.x), number(t.y)));
                }
                for t in &s.triangles {
                    let [a, b, c] = t.map(|i| match s.uv.is_empty() {
                        true => format!("{}", i + points),
                        false => format!("{}/{}", i + points, i + uvs),
                    });
                    put(&mut text, format_args!("f {a} {b} {c}"));
                }
                points += s.points.len();
                uvs += s.uv.len();
            }
        }
        text
    }
}

fn put(text: &mut String, line: std::fmt::Arguments) {
    // Writing to a String cannot fail.
    let _ = writeln!(text, "{line}");
}

/// A number with at most five decimals, without trailing zeros, never a negative zero.
pub fn number(x: f64) -> String {
    let s = format!("{x:.5}");
    let s = s.trim_end_matches('0').trim_end_matches('.');
    if s == "-0" { "0".to_string() } else { s.to_string() }
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_are_short() {
        assert_eq!(number(1.0), "1");
        assert_eq!(number(-0.000_001), "0");
        assert_eq!(number(10.0), "10");
        assert_eq!(number(0.123_456_7), "0.12346");
    }
}
