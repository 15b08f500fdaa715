//! One test for each trap of `tobj` and of OBJ files, named after it.

use std::path::Path;

use proptest::prelude::*;

use super::*;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

/// Reads `a.obj` of this text, alone in its folder but for `others`; the folder is cut from messages.
fn read_with(obj: &[u8], others: &[(&str, &str)], strictness: Strictness) -> Result<(ObjFile, Vec<String>), String> {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in others {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, text).expect("a file");
    }
    let path = folder.path().join("a.obj");
    std::fs::write(&path, obj).expect("a file");
    let bare = |message: String| message.replace(&format!("{}/", folder.path().display()), "");
    match read_obj(&path, strictness) {
        Ok((file, warnings)) => Ok((file, warnings.into_iter().map(|w| bare(w.0)).collect())),
        Err(error) => Err(bare(error.to_string())),
    }
}

/// Reads for a scene, without any warning.
fn read(obj: &str) -> ObjFile {
    let (file, warnings) = read_with(obj.as_bytes(), &[], Strictness::Scene).expect("a readable file");
    assert_eq!(warnings, [""; 0]);
    file
}

fn error(obj: &str) -> String {
    read_with(obj.as_bytes(), &[], Strictness::Import).expect_err("an unusable file")
}

/// Name, materials and triangles of each part.
fn parts(file: &ObjFile) -> Vec<(&str, Vec<&str>, usize)> {
    file.parts
        .iter()
        .map(|part| {
            assert_eq!(part.mesh.material_of.len(), part.mesh.triangles.len());
            assert!(part.mesh.material_of.iter().all(|&m| usize::from(m) < part.mesh.materials.len()));
            let materials = part.mesh.materials.iter().map(String::as_str).collect();
            (&part.name[..], materials, part.mesh.triangles.len())
        })
        .collect()
}

#[test]
fn concave_polygons_are_not_cut_as_fans() {
    // The fan from the first corner would lay a triangle outside of the arrow.
    let mesh = &read("v 2 1 0\nv 0 0 0\nv 2 -1 0\nv 0.5 0 0\nf 1 2 3 4\n").parts[0].mesh;
    let areas = (0..2).map(|t| {
        let [a, b, c] = mesh.corners(t);
        (b - a).cross(c - a).z / 2.0
    });
    assert_eq!(areas.collect::<Vec<_>>(), [0.25, 0.25]);
}

#[test]
fn a_missing_mtl_keeps_geometry_and_names() {
    let obj = format!("mtllib gone.mtl\n{TRIANGLE}usemtl red\nf 1 2 3\nusemtl blue\nf 1 3 2\n");
    let (file, warnings) = read_with(obj.as_bytes(), &[], Strictness::Scene).expect("a readable file");
    assert_eq!(parts(&file), [("a", vec!["red", "blue"], 2)]);
    assert_eq!(file.parts[0].mesh.material_of, [0, 1]);
    assert_eq!(file.materials, []);
    assert_eq!(warnings, ["a.obj: cannot read the material file `gone.mtl`; the scene file must define `red`, `blue`"]);
}

#[test]
fn an_mtl_without_its_folder_is_found_beside_the_obj() {
    let obj = format!("mtllib scenes\\b.mtl\n{TRIANGLE}usemtl red\nf 1 2 3\n");
    let others = [("b.mtl", "newmtl unused\nnewmtl red\nKd 1 0 0\n")];
    let (file, warnings) = read_with(obj.as_bytes(), &others, Strictness::Scene).expect("a readable file");
    let red = MtlMaterial { reflectance: [1.0, 0.0, 0.0], ..MtlMaterial::undefined("red") };
    assert_eq!(file.materials, [red]);
    assert_eq!(warnings, ["a.obj: `scenes\\\\b.mtl` is not there; b.mtl is read instead"]);
}

#[test]
fn one_missing_mtl_of_several() {
    let obj = format!("mtllib x.mtl b\\ c.mtl y.mtl\n{TRIANGLE}usemtl red\nf 1 2 3\n");
    let others = [("b c.mtl", "newmtl red\nKd 1 0 0\n")];
    let (file, warnings) = read_with(obj.as_bytes(), &others, Strictness::Scene).expect("a readable file");
    assert_eq!(file.materials.len(), 1);
    let expected = "a.obj: cannot read the material file `x.mtl`, `y.mtl`; the materials in use are defined elsewhere";
    assert_eq!(warnings, [expected]);
}

#[test]
fn repeated_names_are_one_part() {
    let file = read(&format!("{TRIANGLE}o x\nf 1 2 3\no y\nf 2 3 1\no x\nusemtl m\nf 3 1 2\n"));
    assert_eq!(parts(&file), [("x", vec!["default", "m"], 2), ("y", vec!["default"], 1)]);
    assert_eq!(file.parts[0].mesh.triangles, [[0, 1, 2], [2, 0, 1]]);
    assert_eq!(file.parts[0].mesh.positions.len(), 3);
}

#[test]
fn usemtl_before_g_names_the_right_part() {
    let obj = format!("{TRIANGLE}usemtl a\ng a\nf 1 2 3\nusemtl b\ng b\nf 1 2 3\nusemtl c\nf 1 2 3\ng c\nusemtl c\n");
    let (file, warnings) = read_with(obj.as_bytes(), &[], Strictness::Scene).expect("a readable file");
    assert_eq!(parts(&file), [("a", vec!["a"], 1), ("b", vec!["b"], 1), ("c", vec!["c"], 1)]);
    let warning = "a.obj: faces of `c` come before their `g` line; they are put into the group of their material's name";
    assert_eq!(warnings, [warning]);
}

#[test]
fn relative_indices_count_back_from_their_line() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf -3/-3 -2/-2 -1/-1\nv 5 5 5\nf -1 -2 1/-1\n";
    let (file, _) = read_with(obj.as_bytes(), &[], Strictness::Scene).expect("a readable file");
    assert_eq!(file.parts[0].mesh.triangles, [[0, 1, 2], [3, 2, 0]]);
    assert_eq!(file.parts[0].mesh.uvs[0].map(|uv| uv.to_array()), [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
}

#[test]
fn indices_out_of_range_are_errors_with_a_line() {
    for (face, expected) in [
        ("f 1 2 4", "a.obj:4: a face uses index 4, but the file has 3 vertices"),
        ("f 1 2 3/1", "a.obj:4: a face uses index 1, but the file has 0 texture coordinates"),
        ("f 1 2 -4", "a.obj:4: face corner `-4`: there are only 3 of its kind above this line"),
        ("f 0 1 2", "a.obj:4: face corner `0`: index 0; the first is 1, the last is -1"),
        ("f 1 2 3/0", "a.obj:4: face corner `3/0`: index 0; the first is 1, the last is -1"),
        ("f 1 2 /1", "a.obj:4: face corner `/1`: no vertex index"),
        ("f 1 2 3/1/1/1", "a.obj:4: face corner `3/1/1/1`: at most three indices, vertex/texture/normal, make a corner"),
        ("f 1 2 x", "a.obj:4: face corner `x`: not a number"),
        (
            "f 1 2 -9223372036854775808",
            "a.obj:4: face corner `-9223372036854775808`: there are only 3 of its kind above this line",
        ),
        ("f 1 2 9223372036854775807", "a.obj:4: a face uses index 9223372036854775807, but the file has 3 vertices"),
        ("f 1 2 99999999999999999999", "a.obj:4: face corner `99999999999999999999`: not a number"),
        ("f 9", "a.obj:4: a face uses index 9, but the file has 3 vertices"),
    ] {
        assert_eq!(error(&format!("{TRIANGLE}{face}\n")), expected);
    }
}

#[test]
fn vertices_that_are_not_finite_are_errors_with_a_line() {
    for (vertex, expected) in [
        ("v nan 0 0", "a.obj:4: vertex x = `nan` is not a finite number"),
        ("v 0 -inf 0", "a.obj:4: vertex y = `-inf` is not a finite number"),
        ("v 0 0 1e999", "a.obj:4: vertex z = `1e999` is not a finite number"),
        ("v 1.#IND 0 0", "a.obj:4: vertex x = `1.#IND` is not a finite number"),
        ("v 0,5 0 0", "a.obj:4: vertex x = `0,5` is not a finite number"),
        ("v 0 0", "a.obj:4: a vertex without z: three numbers must follow `v`"),
    ] {
        assert_eq!(error(&format!("{TRIANGLE}{vertex}\nf 1 2 3\n")), expected);
    }
}

#[test]
fn colours_and_weights_of_vertices_are_passed_over() {
    let plain = read(&format!("{TRIANGLE}f 1 2 3\n"));
    for obj in [
        "v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0 # c\nf 1 2 3\n",
        "v 0 0 0 0\nv 1 0 0 0.5\nv 0 1 0 2 1\nf 1 2 3\n",
        "v 0 0 0 1 1 1 1 1 1\nv 1 0 0 x\nv 0 1 0\nf 1 2 3 # f\n",
    ] {
        assert_eq!(read(obj), plain);
    }
}

#[test]
fn line_ends_tabs_continuations_and_marks() {
    let plain = read(&format!("{TRIANGLE}o my part\nf 1 2 3\n"));
    for obj in [
        "\u{feff}v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\no my part\r\nf 1 2 3\r\n",
        "v\t0\t0 0\n  v 1 0 0\nv 0 \\\n 1 \\\r\n0\n\to\tmy part  \nf 1\\\n2 3",
        "v 0 0 0\rv 1 0 0\rv 0 1 0\ro my part\rf 1 2 3\r",
        "# \\\nv +0 .0 0.\nv 1e0 0E-2 0\nv 0 1 0\no my part\nfo 1 2 3\n",
    ] {
        assert_eq!(read(obj), plain);
    }
}

#[test]
fn names_are_the_rest_of_their_line() {
    let file = read(&format!("{TRIANGLE}usemtl  dark  red #2\no  a b/ü \nf 1 2 3\nusemtl\no\nf 1 2 3\n"));
    assert_eq!(parts(&file), [("a b/ü", vec!["dark  red #2"], 1), ("a", vec!["default"], 1)]);
}

#[test]
fn names_that_are_not_utf_8_stay_different() {
    let obj = [TRIANGLE.as_bytes(), b"o \xe4\nf 1 2 3\no \xf6\nf 1 2 3\n"].concat();
    let (file, _) = read_with(&obj, &[], Strictness::Scene).expect("a readable file");
    assert_eq!(parts(&file), [("ä", vec!["default"], 1), ("ö", vec!["default"], 1)]);
}

#[test]
fn points_and_lines_are_left_out() {
    let obj = format!("{TRIANGLE}p 1 2\nl 1 2\nf 1\nf 1 2\nf 1 2 3\nf\n");
    let (file, warnings) = read_with(obj.as_bytes(), &[], Strictness::Scene).expect("a readable file");
    assert_eq!(parts(&file), [("a", vec!["default"], 1)]);
    assert_eq!(warnings, ["a.obj:4: points and lines (5) are left out: they have no surface"]);
}

#[test]
fn a_first_face_of_all_vertices_is_not_lost() {
    // What `tobj` says of face sizes differs if all faces, also the hidden first, are triangles.
    assert_eq!(parts(&read(&format!("{TRIANGLE}f 1 2 3\nf 3 2 1\n")))[0].2, 2);
    assert_eq!(parts(&read(&format!("{TRIANGLE}v 1 1 0\nf 1 2 4 3\n")))[0].2, 2);
    assert_eq!(error("v 0 0 0\nf 1 1 1\n"), "a.obj: no triangles: all of its faces are points or lines without area");
}

#[test]
fn missing_texture_coordinates_are_not_invented() {
    let obj = format!("{TRIANGLE}vt 0.5 0.5\nvt 1\nf 1/1 2/2 3/1\nf 1/1 2 3/1\no b\nf 3//7 2//8 1//0\n");
    let (file, warnings) = read_with(obj.as_bytes(), &[], Strictness::Scene).expect("a readable file");
    let uvs = file.parts[0].mesh.uvs.iter().map(|t| t.map(|uv| uv.to_array())).collect::<Vec<_>>();
    assert_eq!(uvs, [[[0.5, 0.5], [1.0, 0.0], [0.5, 0.5]], [[0.0; 2]; 3]]);
    assert!(file.parts[1].mesh.uvs.is_empty());
    assert_eq!(warnings, ["a.obj: triangles without texture coordinates (1), in `a`, get one colour of their texture"]);
    // A rug's fringe of a material of its own misses nothing.
    let fringe = format!("{TRIANGLE}vt 0 0\nusemtl rug\nf 1/1 2/1 3/1\nusemtl fringe\nf 3 2 1\n");
    let (_, warnings) = read_with(fringe.as_bytes(), &[], Strictness::Scene).expect("a readable file");
    assert!(warnings.is_empty(), "{warnings:?}");
}

#[test]
fn triangles_without_area_are_errors_in_scenes_and_dropped_on_import() {
    let obj = format!("{TRIANGLE}v 2 0 0\no x\nf 1 2 3\nf 1 2 4\nf 1 1 2\no y\nf 1 2 4 1\no z\nf 1 2 3 3\n");
    let error = read_with(obj.as_bytes(), &[], Strictness::Scene).expect_err("an unusable scene");
    assert_eq!(error, "a.obj:7: object `x`, triangle 2 has no area; `lightmend import` cleans the file");
    let (file, warnings) = read_with(obj.as_bytes(), &[], Strictness::Import).expect("a readable file");
    assert_eq!(parts(&file), [("x", vec!["default"], 1), ("z", vec!["default"], 1)]);
    assert_eq!(warnings[0], "a.obj: zero-area triangles (3) are dropped, in `x`, `y`");
}

#[test]
fn files_without_triangles_are_errors() {
    for obj in ["", "\n\n", "# nothing", "o x\n", TRIANGLE, "\0\u{1}glTF", "f"] {
        assert!(error(obj).starts_with("a.obj: no triangles"), "{}", error(obj));
    }
    let missing = read_obj(Path::new("no such.obj"), Strictness::Scene).expect_err("a missing file");
    assert!(missing.to_string().starts_with("no such.obj: cannot be read"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn damaged_files_never_panic(
        edits in prop::collection::vec((0..200_usize, prop_oneof![any::<u8>(), prop::sample::select(&b" \n\\/-09.efvotgu#"[..])]), 0..8),
        cut in 0..250_usize,
        mtl_cut in 0..80_usize,
    ) {
        let mut obj = b"mtllib b.mtl\no first\nv 0 0 0\nv 1 0 0 0.5\nv 1 1 0 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n\
            usemtl red\nf 1/1/1 2/2/2 3/3 4\ng second\nusemtl blue\nf -4 -3 \\\n-2\nf 1 2 3 2 4\nl 1 2\n".to_vec();
        let mut mtl = b"newmtl red\nKd 1 0 0\nKe 1 1 1\nmap_Kd -s 1 1 1 a b.png\nnewmtl blue\nKd 0.5\n".to_vec();
        for (at, byte) in edits {
            for text in [&mut obj, &mut mtl] {
                let length = text.len();
                text[at % length] = byte;
            }
        }
        obj.truncate(cut);
        mtl.truncate(mtl_cut);
        let mtl = String::from_utf8_lossy(&mtl).into_owned();
        for strictness in [Strictness::Scene, Strictness::Import] {
            match read_with(&obj, &[("b.mtl", &mtl)], strictness) {
                Ok((file, _)) => prop_assert!(file.parts.iter().all(|p| !p.mesh.triangles.is_empty())),
                Err(message) => prop_assert_eq!(message.lines().count(), 1),
            }
        }
    }
}
