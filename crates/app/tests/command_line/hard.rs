//! The hard scenes as their users see them: frames of `scenes/hard`, number by number. Their rows are a table of `docs/hard-cases.md`.

use crate::desk::Desk;
use lightmend_tests::{
    count,
    table::{Row, hold},
};
use std::{collections::BTreeMap, path::PathBuf};

#[test]
fn frames_of_hard_scenes_are_numbers() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenes/hard");
    let entries = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
    let mut scenes: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|e| e == "ron")).collect();
    scenes.sort();
    let photons = count(50_000, 1_000_000);
    let size = if count(0, 1) == 0 { "160x120" } else { "640x480" };
    let desk = Desk::new();
    let mut rows = Vec::new();
    for path in scenes {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        desk.done(&format!("frames {} --size {size} --photons {photons} --quiet --exr --out {name}", path.display()));
        let (mut broken, mut negative) = (0, 0);
        let mut brightest = BTreeMap::new();
        for entry in std::fs::read_dir(desk.path(&name)).unwrap() {
            let file = entry.unwrap().file_name().into_string().unwrap();
            if !file.ends_with(".exr") {
                continue;
            }
            for numbers in desk.channels(&format!("{name}/{file}")).values() {
                broken += numbers.iter().filter(|x| !x.is_finite()).count();
                negative += numbers.iter().filter(|x| **x < 0.0).count();
                let most = brightest.entry(file.trim_end_matches(".exr").to_owned()).or_insert(0.0f32);
                *most = numbers.iter().fold(*most, |a, b| a.max(*b));
            }
        }
        let case = format!("scenes/hard/{name}.ron as EXR");
        let quantity = "numbers not finite; below zero, in all channels";
        rows.push(Row::exactly(&case, quantity, "0; 0".to_owned(), "light", format!("{broken}; {negative}")));
        assert!(!brightest.is_empty(), "{name}: no EXR");
        for (camera, most) in brightest {
            if camera.contains("inside") {
                let case = format!("{case}, camera {camera}");
                rows.push(Row::exactly(&case, "brightest number", 0.0, "the camera is in sealed space", most));
            } else {
                rows.push(Row::exactly(&case, "whether there is light", true, "the lamps", most > 0.0));
            }
        }
    }
    hold("frames", &rows);
}
