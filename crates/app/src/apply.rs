//! `lightmend apply`: the scene after scripted moves, as a scene file.

use crate::{Common, failure::Failure, output};
use lightmend_scene::{Configuration, Moves};
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Arguments {
    /// Scene file
    scene: PathBuf,
    /// Moves file
    #[arg(long, value_name = "MOVES")]
    script: PathBuf,
    /// The scene file to write
    #[arg(long, value_name = "SCENE2")]
    out: PathBuf,
    #[command(flatten)]
    common: Common,
}

pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let scene = arguments.common.read_scene(&arguments.scene)?;
    let (moves, warnings) = Moves::read(&arguments.script, &scene)?;
    arguments.common.warn(&warnings);
    output::file(&arguments.out)?;
    let mut configuration = Configuration::initial(&scene);
    for timed in &moves.edits {
        configuration = configuration.apply(&timed.edit)?;
    }
    configuration.write(&arguments.out)?;
    if arguments.common.json {
        output::json(None, &serde_json::json!({ "scene": arguments.out, "edits": moves.edits.len() }), true)?;
    } else if arguments.common.talks() {
        output::say(&format!("{} edits applied: {}", moves.edits.len(), arguments.out.display()));
    }
    Ok(())
}
