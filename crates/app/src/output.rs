//! Where results go: a folder that is tried before the work begins, and files that are never half-written.

use crate::failure::Failure;
use lightmend_scene::format::{is_stream, write_atomically};
use serde::Serialize;
use std::{
    fs,
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
};

/// A folder for results, made if need be, that can take `files`. Fails before the work, not after it.
pub fn folder(path: &Path, files: &[String]) -> Result<PathBuf, Failure> {
    let fault = |e: io::Error| Failure::input(format!("{}: results cannot be written there: {e}", path.display()));
    fs::create_dir_all(path).map_err(fault)?;
    let trial = path.join(format!(".lightmend.{}", std::process::id()));
    fs::write(&trial, b"").map_err(fault)?;
    fs::remove_file(&trial).map_err(fault)?;
    for name in files {
        refuse_folder(&path.join(name))?;
    }
    Ok(path.to_owned())
}

/// A file for results: its folder must take files and it must not be a folder itself. Fails before the work, not after it.
pub fn file(path: &Path) -> Result<(), Failure> {
    if is_stream(path) {
        return Ok(());
    }
    refuse_folder(path)?;
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !parent.is_dir() {
        return Err(Failure::input(format!("{}: cannot be written: there is no folder {}", path.display(), parent.display())));
    }
    folder(parent, &[]).map(|_| ())
}

fn refuse_folder(path: &Path) -> Result<(), Failure> {
    if path.is_dir() {
        return Err(Failure::input(format!("{}: cannot be written: it is a folder", path.display())));
    }
    Ok(())
}

/// Writes a file beside its place and renames it; a device or a pipe is written into.
pub fn write(path: &Path, write: impl FnOnce(&mut BufWriter<fs::File>) -> io::Result<()>) -> Result<(), Failure> {
    Ok(write_atomically(path, write)?)
}

/// Writes a picture as PNG.
pub fn png(path: &Path, picture: &image::RgbImage) -> Result<(), Failure> {
    let mut bytes = io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).map_err(|e| Failure::failed(format!("{}: {e}", path.display())))?;
    write(path, |file| file.write_all(bytes.get_ref()))
}

/// Writes a value as JSON, and prints it if `print`.
pub fn json(path: Option<&Path>, value: &impl Serialize, print: bool) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value).map_err(Failure::failed)?;
    if let Some(path) = path {
        write(path, |out| writeln!(out, "{text}"))?;
    }
    if print {
        say(&text);
    }
    Ok(())
}

/// Prints a line; a reader that has gone away is no failure.
pub fn say(line: &str) {
    let _ = writeln!(io::stdout(), "{line}");
}
