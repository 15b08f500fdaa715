//! `lightmend frames`: what the frames show, and when.

use crate::desk::Desk;
use serde_json::Value;

const AWAY: &str = "Move(object: \"short box\", to: (1.5, 0.45, 0.0))";

/// Every file is the same in both folders, but for the summary's times and threads.
fn same(desk: &Desk, a: &str, b: &str) {
    let names = desk.names(a);
    assert_eq!(names, desk.names(b));
    for name in names.iter().filter(|name| *name != "summary.json") {
        assert!(desk.bytes(&format!("{a}/{name}")) == desk.bytes(&format!("{b}/{name}")), "{name} differs in {a} and {b}");
    }
    let [first, second] = [a, b].map(|folder| {
        let mut summary = desk.json(&format!("{folder}/summary.json"));
        let known = summary.as_object_mut().expect("an object");
        assert!(known.remove("milliseconds").is_some() && known.remove("threads").is_some());
        summary
    });
    assert_eq!(first, second);
}

/// What a summary says about each frame.
fn told(desk: &Desk, folder: &str, key: &str) -> Vec<Value> {
    let summary = desk.json(&format!("{folder}/summary.json"));
    summary["frames"].as_array().expect("frames").iter().map(|frame| frame[key].clone()).collect()
}

fn rays(desk: &Desk, folder: &str) -> Vec<u64> {
    told(desk, folder, "rays").iter().map(|rays| rays.as_u64().expect("a number")).collect()
}

#[test]
fn same_input_same_bits() {
    let desk = Desk::new();
    desk.script(
        &[(0.1, AWAY), (0.2, "AddLamp((name: \"second\", position: (0.5, 0.5, 1.2), intensity: (9.0, 8.0, 7.0)))")],
        &[
            "(at: 0.0, eye: (1.0, -2.7, 1.0), target: (1.0, 1.0, 1.0), fov: 40.0)",
            "(at: 0.3, eye: (0.8, -2.0, 1.2), target: (1.0, 1.0, 1.0), fov: 50.0)",
        ],
    );
    for (out, threads, drivers) in
        [("first", "", ""), ("again", "", ""), ("one", "--threads 1", "1"), ("two", "--threads 2", "2")]
    {
        let arguments = "frames cornell.ron --size 64x48 --photons 20000 --quiet --work 5000 --script m.ron --exr";
        let mut command = desk.command(&format!("{arguments} --out {out} {threads}"));
        if !drivers.is_empty() {
            command.env("LP_NUM_THREADS", drivers);
        }
        assert!(command.status().expect("the program runs").success());
    }
    for other in ["again", "one", "two"] {
        same(&desk, "first", other);
    }
}

/// The invariant that Lightmend is built around, as seen by a camera.
#[test]
fn the_last_frame_is_the_picture_of_the_scene_after_all_edits() {
    let desk = Desk::new();
    let slide = "Drag(object: \"short box\", to: (1.5, 0.45, 0.3), step: 0.05, seconds: 0.3)";
    let scripts: [&[(f64, &str)]; 5] = [
        &[
            (0.0, slide),
            (0.1, "Turn(object: \"tall box\", to: (0.0, 0.0, 48.0))"),
            (0.35, "Paint(object: \"tall box\", material: \"red\")"),
        ],
        &[
            (0.1, "AddLamp((name: \"b\", position: (0.5, 0.5, 1.5), intensity: (50.0, 50.0, 50.0)))"),
            (0.2, "Remove(object: \"tall box\")"),
            (0.2, "Light(lamp: \"lamp\", intensity: (20.0, 20.0, 20.0))"),
        ],
        &[
            (0.1, "Add((name: \"x\", mesh: \"short_box.obj\", movable: true, position: (1.0, 0.5, 0.9)))"),
            (0.2, "Reflect(material: \"white\", to: (0.3, 0.4, 0.5))"),
        ],
        // A drag ends where the next edit takes its object.
        &[(0.0, slide), (0.15, "Move(object: \"short box\", to: (1.2, 0.5, 0.0))")],
        &[(0.0, slide), (0.15, "Remove(object: \"short box\")"), (0.15, "Remove(object: \"tall box\")")],
    ];
    for (number, edits) in scripts.into_iter().enumerate() {
        desk.script(edits, &[]);
        let moved = format!("moved_{number}");
        desk.frames("cornell.ron", &format!("--script m.ron --out {moved} --work 20000"));
        desk.done("apply cornell.ron --script m.ron --quiet --out after.ron");
        desk.frames("after.ron", &format!("--out after_{number}"));
        let last = told(&desk, &moved, "file").pop().expect("a frame");
        assert_eq!(told(&desk, &moved, "exact").pop(), Some(true.into()));
        let last = desk.bytes(&format!("{moved}/{}", last.as_str().expect("a name")));
        assert!(last == desk.bytes(&format!("after_{number}/front.png")), "script {number}");
    }
}

#[test]
fn direct_light_moves_at_once_and_indirect_light_with_the_work() {
    let desk = Desk::new();
    desk.script(&[(0.15, AWAY)], &[]);
    desk.frames("cornell.ron", "--script m.ron --out out --work 5000 --exr");
    assert_eq!(told(&desk, "out", "exact")[..4], [true, true, false, false], "the edit is seen in the first frame not before it");
    let channels = |frame: usize| desk.channels(&format!("out/frame_{frame:05}.exr"));
    let frames = [0, 1, 2, 3].map(channels);
    assert!(frames[0] == frames[1], "the light before the first frame is drained");
    assert!(frames[1]["direct.R"] != frames[2]["direct.R"]);
    // High up, where neither the box nor its shadow is, indirect light is as it was before the first work.
    let high = |frame: usize| &frames[frame]["indirect.R"][..64 * 12];
    assert!(high(1) == high(2) && high(2) != high(3));
    // The work of a frame ends with the group of photons that reaches it.
    let rays = rays(&desk, "out");
    let last = rays.len() - 1;
    assert_eq!(rays[..3], [0, 0, 0]);
    for (frame, rays) in rays.iter().enumerate().take(last).skip(3) {
        let due = 5000 * (frame as u64 - 2);
        assert!((due..due + 3000).contains(rays), "frame {frame}: {rays}");
    }
    assert!(last > 8 && rays[last] <= 5000 * (last as u64 - 2) + 3000);
}

#[test]
fn idle_frames_save_nothing_up() {
    let desk = Desk::new();
    for (out, at) in [("soon", 0.1), ("late", 3.1)] {
        desk.script(&[(at, AWAY)], &[]);
        desk.frames("cornell.ron", &format!("--script m.ron --out {out} --work 5000"));
    }
    let (soon, late) = (rays(&desk, "soon"), rays(&desk, "late"));
    assert!(late[..30].iter().all(|rays| *rays == 0));
    assert_eq!(soon[..], late[30..]);
}

#[test]
fn much_work_is_exact_in_the_next_frame() {
    let desk = Desk::new();
    desk.script(&[(0.1, AWAY)], &[]);
    desk.frames("cornell.ron", "--script m.ron --out out --work 1000000000000");
    assert_eq!(told(&desk, "out", "exact"), [true, false, true]);
}

#[test]
fn light_that_stays_behind_is_told() {
    let desk = Desk::new();
    desk.script(&[(0.1, AWAY)], &[]);
    let run = desk.run("frames cornell.ron --size 64x48 --photons 20000 --script m.ron --out out --work 1 --every 500");
    assert_eq!((run.status, run.stderr.lines().count()), (Some(0), 1), "{}", run.stderr);
    assert!(run.stderr.starts_with("warning: ") && run.stderr.contains("--work"), "{}", run.stderr);
    assert_eq!(told(&desk, "out", "frame"), [0, 500, 1000]);
    assert_eq!(told(&desk, "out", "exact"), [true, false, false]);
}

#[test]
fn every_leaves_frames_out_and_changes_none() {
    let desk = Desk::new();
    desk.script(&[(0.1, AWAY)], &[]);
    desk.frames("cornell.ron", "--script m.ron --out all --work 7000");
    desk.frames("cornell.ron", "--script m.ron --out third --work 7000 --every 3");
    let frames = told(&desk, "third", "frame");
    let multiples: Vec<Value> = (0..frames.len()).map(|k| (3 * k).into()).collect();
    assert_eq!(frames, multiples);
    let all = desk.names("all").iter().filter(|name| name.starts_with("frame_")).count();
    assert!(all > 4 && frames.len() >= all.div_ceil(3));
    for frame in (0..all).step_by(3) {
        let [a, b] = ["all", "third"].map(|folder| desk.bytes(&format!("{folder}/frame_{frame:05}.png")));
        assert!(a == b, "frame {frame}");
    }
    assert_eq!(told(&desk, "third", "exact").pop(), Some(true.into()), "the last frame that is drawn is exact");
}

#[test]
fn cameras_move_from_key_to_key() {
    let desk = Desk::new();
    let key = |at: f64, x: f64| format!("(at: {at:?}, eye: ({x:?}, -2.7, 1.0), target: (1.0, 1.0, 1.0), fov: 40.0)");
    desk.script(&[], &[&key(0.1, 1.0), &key(0.3, 0.5)]);
    desk.frames("cornell.ron", "--script m.ron --out keys");
    let frame = |k: usize| desk.bytes(&format!("keys/frame_{k:05}.png"));
    assert_eq!(told(&desk, "keys", "frame").len(), 4, "the last key ends the frames");
    assert!(frame(0) == frame(1) && frame(1) != frame(2) && frame(2) != frame(3));
    // The camera of the scene file where the first key is, and halfway.
    desk.frames("cornell.ron", "--out front");
    assert!(frame(1) == desk.bytes("front/front.png"));
    desk.change("eye: (1.0, -2.7, 1.0)", "eye: (0.75, -2.7, 1.0)");
    desk.frames("cornell.ron", "--out halfway");
    assert!(frame(2) == desk.bytes("halfway/front.png"));
}

#[test]
fn cameras_of_the_scene() {
    let desk = Desk::new();
    let more = "fov: 40.0),\n(name: \"contact\", eye: (0.5, -2.5, 1.5), target: (1.0, 1.0, 1.0), fov: 50.0),";
    desk.change("fov: 40.0),", more);
    desk.frames("cornell.ron", "--out all");
    // The contact sheet keeps its name.
    assert_eq!(desk.names("all"), ["contact.png", "contact_2.png", "front.png", "summary.json"]);
    desk.frames("cornell.ron", "--out one --camera contact");
    assert_eq!(desk.names("one"), ["contact_2.png", "summary.json"]);
    assert!(desk.bytes("one/contact_2.png") == desk.bytes("all/contact_2.png"));
    desk.script(&[(0.0, AWAY)], &[]);
    desk.frames("cornell.ron", "--out script --camera contact --script m.ron");
    desk.done("apply cornell.ron --script m.ron --quiet --out after.ron");
    desk.frames("after.ron", "--out after --camera contact");
    let last = told(&desk, "script", "file").pop().expect("a frame");
    assert!(desk.bytes(&format!("script/{}", last.as_str().expect("a name"))) == desk.bytes("after/contact_2.png"));
}

#[test]
fn a_camera_inside_of_an_object_is_told_once() {
    let desk = Desk::new();
    let key = |at: f64, z: f64| format!("(at: {at:?}, eye: (1.32, 0.68, {z:?}), target: (1.0, 1.5, 1.0), fov: 40.0)");
    desk.script(&[], &[&key(0.0, 1.0), &key(0.1, 0.3), &key(0.2, 0.9), &key(0.4, 0.3)]);
    let run = desk.run("frames cornell.ron --size 64x48 --photons 20000 --script m.ron --out out");
    assert_eq!(run.status, Some(0), "{}", run.stderr);
    assert_eq!(run.stderr.lines().count(), 1, "{}", run.stderr);
    assert!(run.stderr.starts_with("warning: at 0.10 s ") && run.stderr.contains("'short box'"), "{}", run.stderr);
    assert_eq!(told(&desk, "out", "frame").len(), 5);
    desk.frames("cornell.ron", "--script m.ron --out quiet");
    desk.change("eye: (1.0, -2.7, 1.0)", "eye: (1.32, 0.68, 0.3)");
    let run = desk.run("frames cornell.ron --size 64x48 --photons 20000 --out still");
    assert!(run.stderr.starts_with("warning: in front.png ") && run.stderr.lines().count() == 1, "{}", run.stderr);
    assert!(run.status == Some(0) && desk.path("still/front.png").is_file());
}

#[test]
fn scenes_with_little_in_them() {
    let little = [
        ("(name: \"lamp\", position: (1.0, 1.0, 1.9), intensity: (170.0, 155.0, 125.0)),", "", 1),
        (
            "objects: [",
            "objects: [], lamps: [], cameras: [(name: \"front\", eye: (1.0, -2.7, 1.0), target: (1.0, 1.0, 1.0), fov: 40.0)])\n//",
            2,
        ),
    ];
    for (from, to, warnings) in little {
        let desk = Desk::new();
        match warnings {
            1 => desk.change(from, to),
            _ => {
                let text = desk.read("cornell.ron");
                let start = text.find(from).expect("objects");
                desk.write("cornell.ron", format!("{}{to}", &text[..start]));
            }
        }
        for show in ["radiance", "illuminance", "indirect", "elements", "stale"] {
            let run = desk.run(&format!("frames cornell.ron --size 33x7 --photons 20000 --out out --exr --show {show}"));
            assert_eq!(run.status, Some(0), "{}", run.stderr);
            assert!(run.stderr.contains("there is no lamp") && run.stderr.lines().count() <= 2, "{}", run.stderr);
            assert_eq!(desk.picture("out/front.png").width(), 33);
        }
    }
}
