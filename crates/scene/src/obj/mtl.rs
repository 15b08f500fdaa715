//! The material files of an OBJ file: diffuse reflectance, diffuse texture, emission.
//!
//! <http://paulbourke.net/dataformats/mtl/>. Not read by `tobj`, whose reader gives up a whole file for one bad
//! statement of no concern here and panics on `Kd 0.5`, which means 0.5 0.5 0.5.

use std::path::{Path, PathBuf};

use super::{MtlMaterial, Strictness, quoted, text};
use crate::error::Warning;

/// Finds the materials `used` by the file `obj` in its `libraries`, the arguments of its `mtllib` statements.
///
/// A name without definition is missing from the result. An import is warned of that; a scene may define the name itself,
/// and warns if it does not.
pub fn load(
    obj: &Path,
    libraries: &[String],
    used: &[&str],
    strictness: Strictness,
    warnings: &mut Vec<Warning>,
) -> Vec<MtlMaterial> {
    let (mut drafts, mut missing): (Vec<Draft>, Vec<String>) = Default::default();
    let mut read: Vec<PathBuf> = Vec::new();
    for name in libraries.iter().flat_map(|list| file_names(text::folder(obj), list)) {
        let found = text::resolve(text::folder(obj), &name);
        let content = found.as_ref().map(|path| text::read(path));
        match (found, content) {
            (Some(path), _) if read.contains(&path) => {}
            (Some(path), Some(Ok(content))) => {
                if path != text::folder(obj).join(&name) {
                    let (obj, name, path) = (obj.display(), name.escape_debug(), path.display());
                    warnings.push(Warning(format!("{obj}: `{name}` is not there; {path} is read instead")));
                }
                parse(&path, &content, &mut drafts);
                read.push(path);
            }
            _ if missing.contains(&name) => {}
            _ => missing.push(name),
        }
    }
    let find = |name: &&str| drafts.iter().rev().find(|d| d.name == *name);
    let undefined: Vec<&str> = used.iter().copied().filter(|name| find(name).is_none()).collect();
    if !missing.is_empty() || !undefined.is_empty() && strictness == Strictness::Import {
        let cause = match (missing.is_empty(), libraries.is_empty()) {
            (false, _) => format!("cannot read the material file {}", quoted(&missing)),
            (true, false) => "its material files do not define all that it uses".to_owned(),
            (true, true) => "it names no material file".to_owned(),
        };
        let consequence = if undefined.is_empty() {
            "the materials in use are defined elsewhere".to_owned()
        } else if strictness == Strictness::Scene {
            format!("the scene file must define {}", quoted(&undefined))
        } else {
            format!("0.5 grey stands in for {}", quoted(&undefined))
        };
        warnings.push(Warning(format!("{}: {cause}; {consequence}", obj.display())));
    }
    used.iter().filter_map(find).map(|draft| draft.finish(warnings)).collect()
}

/// The files of one `mtllib`, which may be several in a line or one whose name has spaces, escaped or not: words up
/// to one that ends in `.mtl` make a name, unless the whole line is a file.
fn file_names(folder: &Path, list: &str) -> Vec<String> {
    if text::resolve(folder, list).is_some() {
        return vec![list.to_owned()];
    }
    let mut names = vec![String::new()];
    for word in list.split_inclusive(char::is_whitespace) {
        if let Some(name) = names.last_mut() {
            name.push_str(word);
        }
        if word.trim_end().to_ascii_lowercase().ends_with(".mtl") {
            names.push(String::new());
        }
    }
    names.iter().map(|n| n.trim().replace("\\ ", " ")).filter(|n| !n.is_empty()).collect()
}

/// A material as its file has it, not yet judged: only those in use are worth a warning.
struct Draft {
    name: String,
    file: PathBuf,
    line: u32,
    reflectance: Option<Result<[f64; 3], String>>,
    emission: Option<Result<[f64; 3], String>>,
    texture: Option<String>,
}

fn parse(path: &Path, content: &str, drafts: &mut Vec<Draft>) {
    let first = drafts.len();
    for statement in text::statements(content) {
        let keyword = statement.keyword().to_ascii_lowercase();
        if keyword == "newmtl" {
            drafts.push(Draft {
                name: statement.rest().to_owned(),
                file: path.to_owned(),
                line: statement.line,
                reflectance: None,
                emission: None,
                texture: None,
            });
        } else if let Some(draft) = drafts[first..].last_mut() {
            match &keyword[..] {
                "kd" => draft.reflectance = Some(colour(&statement)),
                "ke" => draft.emission = Some(colour(&statement)),
                "map_kd" => draft.texture = Some(statement.rest().to_owned()),
                _ => {}
            }
        }
    }
}

/// Three numbers, or one for all channels. Spectral files and CIE XYZ are given back as text.
fn colour(statement: &text::Statement) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> = statement.words().map(|w| w.parse().ok().filter(|x: &f64| x.is_finite())).collect();
    match numbers.as_deref() {
        Some(&[grey]) => Ok([grey; 3]),
        Some(&[r, g, b, ..]) => Ok([r, g, b]),
        _ => Err(format!("{} {}", statement.keyword(), statement.rest()).trim_end().to_owned()),
    }
}

impl Draft {
    fn finish(&self, warnings: &mut Vec<Warning>) -> MtlMaterial {
        let place = format!("{}:{}: material `{}`", self.file.display(), self.line, self.name.escape_debug());
        let mut warn = |what: String| warnings.push(Warning(format!("{place}: {what}")));
        let undefined = MtlMaterial::undefined(&self.name);
        let reflectance = match &self.reflectance {
            Some(Ok(kd)) => {
                let clamped = kd.map(|x| x.clamp(0.0, 1.0));
                if clamped != *kd {
                    warn(format!("Kd {kd:?} is outside of 0..1 and becomes {clamped:?}"));
                }
                clamped
            }
            Some(Err(kd)) => {
                warn(format!("`{}` is not three numbers; it becomes 0.5 grey", kd.escape_debug()));
                undefined.reflectance
            }
            None => {
                warn("has no Kd; it becomes 0.5 grey".to_owned());
                undefined.reflectance
            }
        };
        let emission = match &self.emission {
            Some(Ok(ke)) if ke.iter().all(|&x| x >= 0.0) => *ke,
            Some(ke) => {
                let ke = ke.as_ref().map_or_else(|text| text.escape_debug().to_string(), |ke| format!("Ke {ke:?}"));
                warn(format!("`{ke}` is not three numbers from 0 up; it does not emit"));
                undefined.emission
            }
            None => undefined.emission,
        };
        let texture = self.texture.as_ref().and_then(|argument| {
            let (name, found) = texture_file(text::folder(&self.file), argument);
            if found.is_none() {
                warn(format!("texture `{}` is not there; its Kd alone is used", name.escape_debug()));
            }
            found
        });
        MtlMaterial { name: self.name.clone(), reflectance, texture, emission }
    }
}

/// The file name in the argument of `map_Kd`, after its options, and the file if it exists.
fn texture_file<'a>(folder: &Path, argument: &'a str) -> (&'a str, Option<PathBuf>) {
    let mut name = argument.trim();
    while let Some((option, rest)) = name.split_once(char::is_whitespace).filter(|(o, _)| o.starts_with('-')) {
        // At least one word is left for the name.
        let values = match &option.to_ascii_lowercase()[..] {
            // u, and perhaps v and w.
            "-o" | "-s" | "-t" => rest.split_whitespace().take(3).take_while(|w| w.parse::<f64>().is_ok()).count(),
            "-mm" => 2,
            "-blendu" | "-blendv" | "-bm" | "-boost" | "-cc" | "-clamp" | "-colorspace" | "-imfchan" | "-texres" | "-type" => 1,
            // A name that starts with a minus.
            _ => break,
        };
        let mut after = rest.trim_start();
        for _ in 0..values {
            match after.split_once(char::is_whitespace) {
                Some((_, rest)) => after = rest.trim_start(),
                None => break,
            }
        }
        name = after;
    }
    let name = name.strip_prefix('"').and_then(|n| n.strip_suffix('"')).unwrap_or(name);
    // Some programs write options behind the name.
    let bare = name.split(" -").next().unwrap_or(name).trim_end();
    (name, text::resolve(folder, name).or_else(|| text::resolve(folder, bare)))
}

#[cfg(test)]
#[path = "mtl_tests.rs"]
mod tests;
