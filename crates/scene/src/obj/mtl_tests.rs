//! What MTL files contain besides what they should.

use super::*;

/// Loads `m` from a material file of this text, beside the images.
fn material(mtl: &str) -> (Option<MtlMaterial>, Vec<String>) {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("maps")).expect("a folder");
    for name in ["a.mtl", "wood.jpg", "red wood.jpg", "maps/oak 1.jpg"] {
        std::fs::write(folder.path().join(name), if name == "a.mtl" { mtl } else { "" }).expect("a file");
    }
    let mut warnings = Vec::new();
    let obj = folder.path().join("a.obj");
    let found = load(&obj, &["a.mtl".into()], &["m"], Strictness::Import, &mut warnings).pop();
    let root = folder.path().display().to_string();
    let texture = |p: &PathBuf| p.strip_prefix(folder.path()).expect("inside").to_owned();
    let found = found.map(|m| MtlMaterial { texture: m.texture.as_ref().map(texture), ..m });
    (found, warnings.iter().map(|w| w.0.replace(&root, "")).collect())
}

#[test]
fn one_number_is_grey() {
    let expected = MtlMaterial { reflectance: [0.25; 3], ..MtlMaterial::undefined("m") };
    assert_eq!(material("newmtl m\nKd .25\nillum\nNs\n"), (Some(expected), vec![]));
}

#[test]
fn reflectance_outside_of_its_range_is_clamped() {
    let (found, warnings) = material("newmtl m\n  Kd 1.5 -1 0.5 # no\nKe 17 12 4\n");
    let found = found.expect("a material");
    assert_eq!((found.reflectance, found.emission), ([1.0, 0.0, 0.5], [17.0, 12.0, 4.0]));
    assert_eq!(warnings, ["/a.mtl:1: material `m`: Kd [1.5, -1.0, 0.5] is outside of 0..1 and becomes [1.0, 0.0, 0.5]"]);
}

#[test]
fn unusable_reflectance_is_grey() {
    for mtl in ["newmtl m\nKe 0 0 0", "newmtl m\nKd spectral a.rfl 1", "newmtl m\nKd nan 0 0", "newmtl m\nKd 1 1"] {
        let (found, warnings) = material(mtl);
        assert_eq!(found, Some(MtlMaterial::undefined("m")));
        assert!(warnings.len() == 1 && warnings[0].contains("0.5 grey"), "{warnings:?}");
    }
}

#[test]
fn unusable_emission_is_none() {
    for ke in ["-1 0 0", "nan", ""] {
        let (found, warnings) = material(&format!("newmtl m\nKd 0 0 0\nKe {ke}\n"));
        assert_eq!(found.map(|m| m.emission), Some([0.0; 3]));
        assert!(warnings.len() == 1 && warnings[0].contains("does not emit"), "{warnings:?}");
    }
}

#[test]
fn leading_spaces_before_newmtl() {
    let (found, _) = material("\t newmtl   m \nKd 1 0 0\n newmtl n\nKd 0 1 0\n");
    assert_eq!(found.map(|m| m.reflectance), Some([1.0, 0.0, 0.0]));
}

#[test]
fn a_later_definition_wins() {
    let (found, _) = material("newmtl m\nKd 1 0 0\nnewmtl m\nKd 0 1 0\n");
    assert_eq!(found.map(|m| m.reflectance), Some([0.0, 1.0, 0.0]));
}

#[test]
fn texture_options_and_spaces() {
    for (argument, file) in [
        ("wood.jpg", "wood.jpg"),
        ("red wood.jpg ", "red wood.jpg"),
        ("\"red wood.jpg\"", "red wood.jpg"),
        ("-s 1 1 1 wood.jpg", "wood.jpg"),
        ("-s 2 -o 0.5 0.5 -clamp on red wood.jpg", "red wood.jpg"),
        ("-mm 0 1 -texres 512 -type sphere wood.jpg", "wood.jpg"),
        ("wood.jpg -bm 1.5", "wood.jpg"),
        ("maps\\oak 1.jpg", "maps/oak 1.jpg"),
        ("C:\\Users\\x\\wood.jpg", "wood.jpg"),
    ] {
        let (found, warnings) = material(&format!("newmtl m\nKd 1 1 1\nmap_Kd {argument}\n"));
        assert_eq!(found.and_then(|m| m.texture), Some(PathBuf::from(file)), "{argument}");
        assert_eq!(warnings, [""; 0]);
    }
}

#[test]
fn a_missing_texture_is_named() {
    for argument in ["elm.jpg", "-s 1 1 1 elm.jpg", "", "-s", "-s 1"] {
        let (found, warnings) = material(&format!("newmtl m\nKd 1 1 1\nmap_Kd {argument}\n"));
        assert_eq!(found.map(|m| m.texture), Some(None));
        assert!(warnings.len() == 1 && warnings[0].contains("is not there"), "{warnings:?}");
    }
    assert!(material("newmtl m\nKd 1 1 1\nmap_Kd -s 1 1 1 elm.jpg").1[0].contains("`elm.jpg`"));
}

#[test]
fn several_libraries_in_a_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let names = |list| file_names(folder.path(), list);
    assert_eq!(names("a.mtl b.MTL  c.mtl"), ["a.mtl", "b.MTL", "c.mtl"]);
    assert_eq!(names("my box.mtl"), ["my box.mtl"]);
    assert_eq!(names("my\\ box.mtl b.mtl"), ["my box.mtl", "b.mtl"]);
    assert_eq!(names("./head_materials.txt"), ["./head_materials.txt"]);
    std::fs::write(folder.path().join("a.mtl b.mtl"), "").expect("a file");
    assert_eq!(names("a.mtl b.mtl"), ["a.mtl b.mtl"]);
}
