//! The scenes that Lightmend ships with, as a program: nothing in them was drawn by hand or taken from elsewhere.
//!
//! `shapes` makes closed `solid`s, `furniture` and `shell` join them to `mesh`es (OBJ), `refine` cuts those of the house finer. `room`,
//! `house` and `cornell` place them in a `scene` (RON) under lamps with `photometry` (LM-63) and write its moves. [`files`] returns
//! everything as bytes; the program only writes it. The same source writes the same bytes everywhere: sorted, at most five decimals.

pub mod cornell;
pub mod furniture;
pub mod house;
pub mod mesh;
pub mod photometry;
pub mod refine;
pub mod room;
pub mod scene;
pub mod shapes;
pub mod shell;
pub mod solid;
pub mod texture;

/// A file to write.
pub struct File {
    /// Relative to the folder of all scenes, with `/`.
    pub path: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

impl File {
    /// A file of text.
    pub fn text(path: &str, text: String) -> Self {
        File { path: path.to_string(), bytes: text.into_bytes() }
    }
}

/// All scenes.
pub fn scenes() -> [scene::Scene; 3] {
    [cornell::scene(), room::scene(), house::scene()]
}

/// All files of all scenes.
///
/// # Errors
/// When the encoder of pictures fails.
pub fn files() -> Result<Vec<File>, image::ImageError> {
    let mut files = Vec::new();
    for scene in scenes() {
        let folder = scene.name;
        files.push(File::text(&format!("{folder}/{folder}.ron"), scene.ron()));
        for mesh in &scene.meshes.1 {
            files.push(File::text(&format!("{folder}/{}{}.obj", scene.meshes.0, mesh.name), mesh.obj()));
        }
    }
    files.push(File::text("room/fine.ron", room::fine().ron()));
    let papered = room::papered();
    files.push(File::text("room/papered.ron", papered.ron()));
    let shell = papered.meshes.1.iter().filter(|mesh| mesh.name == "papered_shell");
    files.extend(shell.map(|mesh| File::text("room/meshes/papered_shell.obj", mesh.obj())));
    files.push(File { path: "room/textures/checks.png".to_string(), bytes: texture::checks()? });
    files.extend(cornell::scripts());
    files.extend(room::moves::scripts());
    files.extend(house::moves::scripts());
    for (scene, diagrams) in [("room", photometry::room()), ("house", photometry::house())] {
        for diagram in diagrams {
            files.push(File::text(&format!("{scene}/ies/{}.ies", diagram.name), diagram.ies()));
        }
    }
    files.push(File { path: "room/textures/rug.png".to_string(), bytes: texture::rug()? });
    files.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(files)
}
