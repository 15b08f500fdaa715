//! `lightmend-scenes FOLDER`: writes all scenes into FOLDER (of this repository: `scenes`) and says how many mesh elements they have.

use std::path::PathBuf;
use std::process::ExitCode;

use lightmend_scenes::{files, scenes};

fn main() -> ExitCode {
    let mut arguments = std::env::args_os().skip(1);
    let (Some(folder), None) = (arguments.next(), arguments.next()) else {
        eprintln!("usage: lightmend-scenes FOLDER");
        return ExitCode::from(2);
    };
    match write(&PathBuf::from(folder)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("lightmend-scenes: {message}");
            ExitCode::FAILURE
        }
    }
}

fn write(folder: &std::path::Path) -> Result<(), String> {
    for file in files().map_err(|e| e.to_string())? {
        let path = folder.join(&file.path);
        let said = |e: std::io::Error| format!("{}: {e}", path.display());
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(said)?;
        }
        std::fs::write(&path, &file.bytes).map_err(said)?;
    }
    for scene in scenes() {
        println!("{}: {} mesh elements, {} movable objects", scene.name, scene.elements(), scene.movables().count());
    }
    Ok(())
}
