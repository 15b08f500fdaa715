//! One pass over an OBJ text: checks each vertex and index with its line, keeps the names, and writes what is left,
//! vertices and polygons alone, in the form that `tobj` cannot misread.

use std::fmt::Write;
use std::path::Path;

use super::text;
use crate::error::{SceneError, Warning};

/// The order of names and faces in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Statement {
    /// `o`, with a name that may be empty.
    Object(String),
    /// `g`, with a name that may be empty.
    Group(String),
    /// `usemtl`, with a name that may be empty.
    Material(String),
    /// A number of polygons in sequence.
    Faces(usize),
}

/// What a polygon is besides its corners.
#[derive(Debug, Clone, Copy)]
pub struct Face {
    /// One-based line of its `f`.
    pub line: u32,
    /// Every corner has a texture coordinate.
    pub has_uvs: bool,
}

/// A checked file.
#[derive(Debug, Default)]
pub struct Scan {
    /// `v`, `vt` and `f` statements for `tobj`; all corners have a vertex, all indices are in range.
    pub text: String,
    /// Number of `v`.
    pub vertices: usize,
    /// The polygons of three and more corners.
    pub faces: Vec<Face>,
    /// Names and faces in file order.
    pub statements: Vec<Statement>,
    /// What follows each `mtllib`.
    pub libraries: Vec<String>,
}

/// The largest index of a kind and its line: whether it is in range is known at the end of the file.
#[derive(Default)]
struct Largest {
    index: usize,
    line: u32,
}

/// Checks `text`, the content of `path`.
pub fn scan(path: &Path, text: &str, warnings: &mut Vec<Warning>) -> Result<Scan, SceneError> {
    let mut scan = Scan { text: String::with_capacity(text.len()), ..Scan::default() };
    let (mut uvs, mut bad_uvs) = (0, Lines::default());
    let (mut flat, mut curved) = (Lines::default(), Lines::default());
    let mut largest = [Largest::default(), Largest::default()];
    for statement in text::statements(text) {
        let line = statement.line;
        match statement.keyword() {
            "v" => {
                vertex(&mut scan.text, &statement).map_err(|what| SceneError::line(path, line, what))?;
                scan.vertices += 1;
            }
            "vt" => {
                if !texture_coordinate(&mut scan.text, &statement) {
                    bad_uvs.add(line);
                }
                uvs += 1;
            }
            // `fo` is the old spelling of `f`.
            "f" | "fo" => {
                let start = scan.text.len();
                let face = polygon(&mut scan.text, &statement, [scan.vertices, uvs], &mut largest);
                let (corners, has_uvs) = face.map_err(|what| SceneError::line(path, line, what))?;
                if corners < 3 {
                    scan.text.truncate(start);
                    flat.add(line);
                    continue;
                }
                scan.faces.push(Face { line, has_uvs });
                match scan.statements.last_mut() {
                    Some(Statement::Faces(count)) => *count += 1,
                    _ => scan.statements.push(Statement::Faces(1)),
                }
            }
            "o" => scan.statements.push(Statement::Object(statement.rest().to_owned())),
            "g" => scan.statements.push(Statement::Group(statement.rest().to_owned())),
            "usemtl" => scan.statements.push(Statement::Material(statement.rest().to_owned())),
            "mtllib" => scan.libraries.push(statement.rest().to_owned()),
            "p" | "l" => flat.add(line),
            "curv" | "curv2" | "surf" => curved.add(line),
            // Normals come from the triangles; smoothing groups, line widths and the like carry no light.
            _ => {}
        }
    }
    for (largest, count, kind) in [(&largest[0], scan.vertices, "vertices"), (&largest[1], uvs, "texture coordinates")] {
        if largest.index > count {
            let what = format!("a face uses index {}, but the file has {count} {kind}", largest.index);
            return Err(SceneError::line(path, largest.line, what));
        }
    }
    if scan.vertices.max(uvs) > u32::MAX as usize {
        return Err(SceneError::content(path, "more than 2³² vertices: split the file"));
    }
    if scan.faces.is_empty() {
        return Err(SceneError::content(path, "no triangles: the file has no `f` statement with three corners"));
    }
    flat.warn(path, "points and lines", "are left out: they have no surface", warnings);
    curved.warn(path, "curves and free-form surfaces", "are left out: export them as polygons", warnings);
    bad_uvs.warn(path, "malformed texture coordinates", "are taken as 0 0: textures will be misplaced", warnings);
    Ok(scan)
}

/// How often something was met, and where first.
#[derive(Default)]
struct Lines {
    count: usize,
    first: u32,
}

impl Lines {
    fn add(&mut self, line: u32) {
        if self.count == 0 {
            self.first = line;
        }
        self.count += 1;
    }

    fn warn(&self, path: &Path, what: &str, consequence: &str, warnings: &mut Vec<Warning>) {
        if self.count > 0 {
            let (count, first) = (self.count, self.first);
            warnings.push(Warning(format!("{}:{first}: {what} ({count}) {consequence}", path.display())));
        }
    }
}

/// Copies a vertex's three coordinates. What may follow is a colour, which some programs add, or a weight, which
/// counts for curves alone.
fn vertex(out: &mut String, statement: &text::Statement) -> Result<(), String> {
    out.push('v');
    let mut words = statement.words();
    for axis in ["x", "y", "z"] {
        let word = words.next().ok_or_else(|| format!("a vertex without {axis}: three numbers must follow `v`"))?;
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => {
                out.push(' ');
                out.push_str(word);
            }
            _ => return Err(format!("vertex {axis} = `{}` is not a finite number", word.escape_debug())),
        }
    }
    out.push('\n');
    Ok(())
}

/// Copies u and v, v being optional; whether both were finite numbers.
fn texture_coordinate(out: &mut String, statement: &text::Statement) -> bool {
    let mut words = statement.words();
    let (u, v) = (words.next().unwrap_or_default(), words.next().unwrap_or("0"));
    let good = [u, v].iter().all(|w| w.parse::<f64>().is_ok_and(f64::is_finite));
    let (u, v) = if good { (u, v) } else { ("0", "0") };
    out.extend(["vt ", u, " ", v, "\n"]);
    good
}

/// Copies a polygon with one-based indices from the file's start; how many corners it has, and whether all have a
/// texture coordinate. `counts` are the vertices and texture coordinates so far.
fn polygon(
    out: &mut String,
    statement: &text::Statement,
    counts: [usize; 2],
    largest: &mut [Largest; 2],
) -> Result<(usize, bool), String> {
    out.push('f');
    let (mut corners, mut has_uvs) = (0, true);
    for word in statement.words() {
        let fault = |what: &str| format!("face corner `{}`: {what}", word.escape_debug());
        let mut indices = [None; 2];
        for (kind, digits) in word.split('/').enumerate() {
            // The third index is the normal's, which is not used.
            if kind > 2 {
                return Err(fault("at most three indices, vertex/texture/normal, make a corner"));
            }
            if kind == 2 || digits.is_empty() {
                continue;
            }
            let index = digits.parse::<i64>().map_err(|_| fault("not a number"))?;
            let absolute = match index {
                0 => return Err(fault("index 0; the first is 1, the last is -1")),
                1.. => usize::try_from(index).ok(),
                _ => counts[kind].checked_add_signed(index as isize).map(|i| i + 1),
            };
            let absolute = absolute
                .filter(|&i| i > 0)
                .ok_or_else(|| fault(&format!("there are only {} of its kind above this line", counts[kind])))?;
            if absolute > largest[kind].index {
                largest[kind] = Largest { index: absolute, line: statement.line };
            }
            indices[kind] = Some(absolute);
        }
        let [Some(vertex), uv] = indices else { return Err(fault("no vertex index")) };
        // Writing to a String cannot fail.
        let _ = match uv {
            Some(uv) => write!(out, " {vertex}/{uv}"),
            None => write!(out, " {vertex}"),
        };
        has_uvs &= uv.is_some();
        corners += 1;
    }
    out.push('\n');
    Ok((corners, has_uvs))
}
