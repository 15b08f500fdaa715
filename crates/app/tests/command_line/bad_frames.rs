//! `lightmend frames` that cannot be drawn, or not all of them.

use crate::desk::Desk;

const AWAY: &str = "Move(object: \"short box\", to: (1.5, 0.45, 0.0))";

/// Far more photons than could be shot: what is refused is refused before.
const FRAMES: &str = "frames cornell.ron --photons 2000000000 --out out";

#[test]
fn sizes() {
    let desk = Desk::new();
    for size in ["0x0", "64", "axb", "64x", "64x0", "-64x48", "64x48x2"] {
        desk.refuses(&format!("{FRAMES} --size={size}"), &[&format!("'{size}'"), "--size", "like 1280x720"]);
    }
    desk.refuses(&format!("{FRAMES} --size 100000x100000"), &["--size: ", "100000x100000", "each side must be 1 to "]);
    desk.refuses(&format!("{FRAMES} --size 9000x9 --aa 4"), &["--size: ", "9000x9", "4x4 samples"]);
    for size in ["1x1", "1x70", "900x2"] {
        desk.done(&format!("frames cornell.ron --photons 20000 --out out --quiet --exr --show illuminance --size {size}"));
    }
}

#[test]
fn numbers() {
    let desk = Desk::new();
    desk.script(&[(0.1, AWAY)], &[]);
    for (argument, values) in [
        ("--work", &["0", "-5", "x", "18446744073709551615"][..]),
        ("--every", &["0", "-1", "1.5"]),
        ("--aa", &["0", "5", "-1"]),
        ("--range", &["5,1", "-1,1", "1", "1,inf", "nan,2"]),
        ("--exposure", &["nan", "inf", "x", "1e30"]),
    ] {
        for value in values {
            desk.refuses(
                &format!("{FRAMES} --script m.ron --show illuminance {argument} {value}"),
                &[&format!("'{value}'"), argument],
            );
        }
    }
}

#[test]
fn options_without_effect() {
    let desk = Desk::new();
    for show in ["radiance", "elements"] {
        desk.refuses(&format!("{FRAMES} --show {show} --range 1,5"), &["--range: ", "--show"]);
    }
    desk.refuses(&format!("{FRAMES} --show stale --exposure 5"), &["--exposure: ", "--range"]);
}

#[test]
fn cameras() {
    let desk = Desk::new();
    desk.refuses(&format!("{FRAMES} --camera frnt"), &["--camera: ", "'frnt'", "did you mean 'front'?"]);
    desk.change("(name: \"front\", eye: (1.0, -2.7, 1.0), target: (1.0, 1.0, 1.0), fov: 40.0),", "");
    desk.refuses(FRAMES, &["cornell.ron", "there is no camera"]);
    desk.script(&[(0.1, AWAY)], &[]);
    desk.refuses(&format!("{FRAMES} --script m.ron"), &["cornell.ron", "there is no camera", "camera keys"]);
    desk.script(&[], &["(at: 0.0, eye: (1.0, -2.7, 1.0), target: (1.0, 1.0, 1.0), fov: 40.0)"]);
    desk.frames("cornell.ron", "--script m.ron --out out");
}

#[test]
fn output() {
    let desk = Desk::new();
    desk.write("file", "mine");
    for place in ["file", "file/below"] {
        desk.refuses(
            &format!("frames cornell.ron --photons 2000000000 --out {place}"),
            &[&format!("{place}: "), "cannot be written"],
        );
    }
    desk.script(&[(0.1, AWAY)], &[]);
    for (name, script) in [("summary.json", ""), ("contact.png", ""), ("front.png", ""), ("frame_00000.png", "--script m.ron")] {
        let desk = Desk::new();
        desk.script(&[(0.1, AWAY)], &[]);
        desk.folder(&format!("out/{name}"));
        desk.refuses(&format!("{FRAMES} {script}"), &[&format!("out/{name}: "), "it is a folder"]);
    }
}

#[test]
fn moves() {
    let desk = Desk::new();
    desk.refuses(&format!("{FRAMES} --script m.ron"), &["m.ron", "No such file"]);
    desk.script(&[], &["(at: -1.0, eye: (1.0, -2.7, 1.0), target: (1.0, 1.0, 1.0), fov: 40.0)"]);
    desk.refuses(&format!("{FRAMES} --script m.ron"), &["m.ron", "camera key 0"]);
}

/// Status 1 and one line, before any photon is shot and without a trace on the disk.
#[test]
fn no_driver() {
    let desk = Desk::new();
    let before = desk.content();
    let none: &[(&str, &str)] =
        &[("VK_DRIVER_FILES", "/nonexistent"), ("VK_ICD_FILENAMES", "/nonexistent"), ("WGPU_BACKEND", "vulkan")];
    for (variables, told) in [(none, "apt-get install mesa-vulkan-drivers"), (&[("WGPU_ADAPTER_NAME", "abacus")], "'abacus'")] {
        let mut command = desk.command(FRAMES);
        command.envs(variables.iter().copied());
        let output = command.output().expect("the program runs");
        let stderr = String::from_utf8(output.stderr).expect("UTF-8");
        assert_eq!(output.status.code(), Some(1), "{stderr}");
        assert_eq!(stderr.lines().count(), 1, "{stderr}");
        assert!(stderr.starts_with("lightmend: no graphics driver was found") && stderr.contains(told), "{stderr}");
        assert!(output.stdout.is_empty());
        assert!(desk.content() == before);
    }
}

/// A folder in place of a frame stands for a disk that fills up.
#[test]
fn frames_before_a_failure_are_kept() {
    let desk = Desk::new();
    desk.script(&[(0.6, AWAY)], &[]);
    desk.folder("out/frame_00003.png/below");
    let run = desk.run("frames cornell.ron --size 64x48 --photons 20000 --script m.ron --out out");
    assert_eq!(run.status, Some(2), "{}", run.stderr);
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    assert!(
        run.stderr.contains("out/frame_00003.png") && run.stderr.contains("3 finished frames are kept in out"),
        "{}",
        run.stderr
    );
    let whole = ["frame_00000.png", "frame_00001.png", "frame_00002.png"];
    assert_eq!(desk.names("out"), ["contact.png", whole[0], whole[1], whole[2], "frame_00003.png", "summary.json"]);
    whole.iter().for_each(|name| assert_eq!(desk.picture(&format!("out/{name}")).dimensions(), (64, 48)));
    let summary = desk.json("out/summary.json");
    assert_eq!(summary["frames"].as_array().expect("frames").len(), 3);
    assert!(run.stderr.contains(summary["failed"].as_str().expect("a line")), "{summary}");
}
