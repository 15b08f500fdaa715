//! The scenes of `scenes/hard`, as they are opened in the window.

use crate::{
    sound::{self, Space},
    thin::{hits, lit},
};
use lightmend_scene::Scene;
use lightmend_tests::table::Row;
use std::path::PathBuf;

pub fn rows() -> Vec<Row> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../scenes/hard");
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut scenes: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|e| e == "ron")).collect();
    scenes.sort();
    let mut rows = Vec::new();
    for path in scenes {
        let (scene, warnings) = Scene::read(&path).unwrap();
        let case = format!("scenes/hard/{}.ron", scene.name);
        rows.push(Row::exactly(&case, "warnings", 0, "a scene that is right", warnings.len()));
        rows.push(sound::row(&case, &scene, Space::Closed));
        let strayed: i64 = match scene.name.as_str() {
            "thin" => {
                let sealed: [(&str, &[u8]); 5] =
                    [("inner", &[0, 1]), ("outer", &[1]), ("left", &[1]), ("right", &[1]), ("wardrobe", &[1])];
                let solution = lit(&scene);
                sealed.iter().map(|(name, sides)| hits(&solution, name, sides)).sum()
            }
            // Light of the lamp in the shade, anywhere else.
            "lamps" => {
                let shade = scene.objects.iter().position(|o| o.name == "shade").unwrap() as u32;
                let lamp = scene.lamps.iter().position(|l| l.name == "in the shade").unwrap() as u16;
                let solution = lit(&scene);
                let outside = solution.buckets().lit().filter(|(at, _)| at.lamp == lamp && (at.object, at.side) != (shade, 1));
                outside.map(|(_, bucket)| bucket.hits).sum()
            }
            _ => continue,
        };
        rows.push(Row::exactly(&case, "hits where no light can come", 0, "sealed", strayed));
    }
    rows
}
