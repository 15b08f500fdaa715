//! Every OBJ file of the outside corpus: read or refused in one line, and some counted by hand.

use std::path::{Path, PathBuf};

use super::*;

/// The corpus, if there is one.
fn corpus() -> Option<PathBuf> {
    let folder = std::env::var_os("LIGHTMEND_CORPUS").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: LIGHTMEND_CORPUS is unset");
    }
    folder
}

fn obj_files(folder: &Path, found: &mut Vec<PathBuf>) -> std::io::Result<()> {
    let mut entries = std::fs::read_dir(folder)?.map(|e| e.map(|e| e.path())).collect::<Result<Vec<_>, _>>()?;
    entries.sort();
    for path in entries {
        if path.is_dir() {
            obj_files(&path, found)?;
        } else if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj")) {
            found.push(path);
        }
    }
    Ok(())
}

#[test]
fn all_files_are_read_or_refused_in_a_line() -> std::io::Result<()> {
    let Some(corpus) = corpus() else { return Ok(()) };
    let mut files = Vec::new();
    obj_files(&corpus, &mut files)?;
    assert!(!files.is_empty());
    let mut refused = Vec::new();
    for path in files {
        let name = path.strip_prefix(&corpus).unwrap_or(&path).display().to_string();
        match read_obj(&path, Strictness::Import) {
            Ok((file, warnings)) => {
                let triangles: usize = file.parts.iter().map(|p| p.mesh.triangles.len()).sum();
                println!("{name}: {} parts, {triangles} triangles, {} materials", file.parts.len(), file.materials.len());
                for warning in warnings {
                    println!("    {}", warning.0.replace(&format!("{}/", corpus.display()), ""));
                    assert_eq!(warning.0.lines().count(), 1);
                }
            }
            Err(error) => {
                println!("{name}: {}", error.to_string().replace(&format!("{}/", corpus.display()), ""));
                assert_eq!(error.to_string().lines().count(), 1);
                refused.push(name);
            }
        }
    }
    let outside_hostile: Vec<_> = refused.iter().filter(|name| !name.starts_with("hostile")).collect();
    assert!(outside_hostile.is_empty(), "{outside_hostile:?}");
    Ok(())
}

/// A part's name, materials and number of triangles.
type PartSummary = (String, String, usize);

/// Reads a corpus file for import.
fn summary(file: &str) -> Option<(Vec<PartSummary>, ObjFile, Vec<Warning>)> {
    let (file, warnings) = read_obj(&corpus()?.join(file), Strictness::Import).expect("a readable file");
    let part = |p: &ObjPart| (p.name.clone(), p.mesh.materials.join(" "), p.mesh.triangles.len());
    Some((file.parts.iter().map(part).collect(), file, warnings))
}

fn assert_parts(found: &[PartSummary], expected: &[(&str, &str, usize)]) {
    let expected: Vec<_> = expected.iter().map(|&(n, m, t)| (n.to_owned(), m.to_owned(), t)).collect();
    assert_eq!(found, expected);
}

#[test]
fn cornell_box_of_mcguire() {
    let Some((parts, file, warnings)) = summary("scenes/cornell_mcguire/CornellBox-Original.obj") else { return };
    let boxed = |name| (name, name, 12);
    let plane = |name| (name, name, 2);
    assert_parts(
        &parts,
        &[
            plane("floor"),
            plane("ceiling"),
            plane("backWall"),
            plane("rightWall"),
            plane("leftWall"),
            boxed("shortBox"),
            boxed("tallBox"),
            plane("light"),
        ],
    );
    let height = |i: usize| file.parts[i].mesh.positions.iter().map(|p| p.y).fold(0.0, f64::max);
    assert_eq!([height(5), height(6)], [0.6, 1.2]);
    let light = file.materials.last().expect("a lamp");
    assert_eq!((&light.name[..], light.reflectance, light.emission), ("light", [0.78; 3], [17.0, 12.0, 4.0]));
    let left = file.materials.iter().find(|m| m.name == "leftWall").expect("the wall");
    assert_eq!(left.reflectance, [0.63, 0.065, 0.05]);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
}

#[test]
fn cornell_boxes_of_embree_and_tobj() {
    let room = |white| {
        [
            ("floor", white, 6),
            ("light", "light", 2),
            ("ceiling", white, 2),
            ("back_wall", white, 2),
            ("green_wall", "green", 2),
            ("red_wall", "red", 2),
            ("short_block", white, 10),
            ("tall_block", white, 10),
        ]
    };
    let Some((parts, file, warnings)) = summary("scenes/cornell_embree/cornell_box.obj") else { return };
    let unlit: Vec<_> = room("white").into_iter().filter(|part| part.0 != "light").collect();
    assert_parts(&parts, &unlit);
    let names: Vec<_> = file.materials.iter().map(|m| (&m.name[..], m.reflectance)).collect();
    assert_eq!(names, [("white", [1.0; 3]), ("green", [0.0, 1.0, 0.0]), ("red", [1.0, 0.0, 0.0])]);
    assert_eq!(warnings, []);

    let Some((parts, file, warnings)) = summary("scenes/cornell_tobj/cornell_box.obj") else { return };
    assert_parts(&parts, &room("white"));
    assert_eq!(file.materials.iter().map(|m| &m.name[..]).collect::<Vec<_>>(), ["white", "red"]);
    // The second of its material files is not in the corpus, nor is red's texture.
    assert_eq!(warnings.len(), 2);
    assert!(warnings[0].0.contains("`cornell_box2.mtl`; 0.5 grey stands in for `light`, `green`"), "{}", warnings[0]);
}

#[test]
fn cornell_box_of_lajolla() {
    let mut triangles = Vec::new();
    for name in ["back", "ceiling", "floor", "greenwall", "largebox", "luminaire", "redwall", "smallbox"] {
        let Some((parts, ..)) = summary(&format!("scenes/cbox_lajolla/meshes/cbox_{name}.obj")) else { return };
        triangles.push(parts.iter().map(|p| p.2).sum::<usize>());
    }
    assert_eq!(triangles, [2, 4, 2, 2, 12, 2, 2, 12]);
}

#[test]
fn furniture_of_kaykit() {
    for (file, name, triangles) in [
        ("bed_double_B", "bed_double_B_Cube.001", 600),
        ("chair_C", "chair_C_Cube.031", 288),
        ("lamp_standing", "lamp_standing_Sphere.002", 320),
    ] {
        let Some((parts, file, warnings)) = summary(&format!("furniture/kaykit_obj/{file}.obj")) else { return };
        assert_parts(&parts, &[(name, "furniture_texture", triangles)]);
        let material = &file.materials[0];
        let texture = material.texture.as_ref().and_then(|t| t.file_name()).expect("an image");
        assert_eq!((material.reflectance, texture.to_str()), ([1.0; 3], Some("furniturebits_texture.png")));
        assert_eq!(file.parts[0].mesh.uvs.len(), triangles);
        assert_eq!(warnings, []);
    }
}

#[test]
fn reading_what_was_written_changes_nothing() -> std::io::Result<()> {
    let Some(corpus) = corpus() else { return Ok(()) };
    let mut files = Vec::new();
    obj_files(&corpus, &mut files)?;
    let folder = tempfile::tempdir()?;
    let copy = folder.path().join("copy.obj");
    for path in files {
        let Ok((file, _)) = read_obj(&path, Strictness::Import) else { continue };
        let parts: Vec<_> = file.parts.iter().map(|p| (p.name.clone(), &p.mesh)).collect();
        write_obj(&mut std::io::BufWriter::new(std::fs::File::create(&copy)?), &parts)?;
        let (again, _) = read_obj(&copy, Strictness::Scene).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        assert!(again.parts == file.parts, "{}", path.display());
    }
    Ok(())
}
