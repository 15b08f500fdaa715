//! What `lightmend frames` leaves in its folder: pictures, EXR, legend, contact sheet, film, summary.

use crate::desk::Desk;
use image::Rgb;
use lightmend_raster::FALSE_COLOURS;
use serde_json::Value;
use std::{fs, os::unix::fs::PermissionsExt, process::Output};

const AWAY: &str = "Move(object: \"short box\", to: (1.5, 0.45, 0.0))";

fn desk() -> Desk {
    let desk = Desk::new();
    desk.script(&[(0.1, AWAY)], &[]);
    desk
}

#[test]
fn exr_holds_the_parts_of_the_light() {
    let desk = Desk::new();
    for (number, aa) in [("1", ""), ("2", "--aa 2")] {
        desk.frames("cornell.ron", &format!("--exr --out out_{number} {aa}"));
        let channels = desk.channels(&format!("out_{number}/front.exr"));
        let names: Vec<&str> = channels.keys().map(String::as_str).collect();
        let expected = ["B", "G", "R", "direct.B", "direct.G", "direct.R", "indirect.B", "indirect.G", "indirect.R", "mask.lamp"];
        assert_eq!(names, expected);
        for colour in ["R", "G", "B"] {
            let [sum, direct, indirect] = ["", "direct.", "indirect."].map(|part| &channels[&format!("{part}{colour}")]);
            assert_eq!(sum.len(), 64 * 48);
            assert!(direct.iter().any(|v| *v > 1.0) && indirect.iter().any(|v| *v > 1.0));
            for ((sum, direct), indirect) in sum.iter().zip(direct).zip(indirect) {
                assert!((sum - direct - indirect).abs() <= 1e-5 * sum, "{sum} is not {direct} + {indirect}");
            }
        }
        let mask = &channels["mask.lamp"];
        assert!(mask.contains(&0.0) && mask.contains(&1.0) && mask.iter().all(|m| (0.0..=1.0).contains(m)));
        assert_eq!(mask.iter().any(|m| *m > 0.0 && *m < 1.0), number == "2", "only several samples can be partly lit");
        // Where the lamp is out of sight there is no direct light.
        let dark = mask.iter().zip(&channels["direct.G"]).filter(|(mask, _)| **mask == 0.0);
        dark.for_each(|(_, direct)| assert_eq!(*direct, 0.0));
    }
}

#[test]
fn lamps_with_odd_names_have_masks_of_their_own() {
    let desk = Desk::new();
    let lamp = "(name: \"lamp\", position: (1.0, 1.0, 1.9), intensity: (170.0, 155.0, 125.0)),";
    let names = ["a.b", "a_b", "灯/ä", "two words", &"long".repeat(99)];
    let lamps: String =
        names.iter().enumerate().map(|(n, name)| lamp.replace("lamp", name).replace("1.9", &format!("1.{n}"))).collect();
    desk.change(lamp, &lamps);
    desk.frames("cornell.ron", "--exr --out out");
    let channels = desk.channels("out/front.exr");
    let masks: Vec<&str> = channels.keys().filter_map(|name| name.strip_prefix("mask.")).collect();
    assert_eq!(masks, ["a_b", "a_b_2", &"long".repeat(50), "two words", "灯/ä"]);
}

#[test]
fn false_colours_have_a_legend() {
    let desk = desk();
    for show in ["illuminance", "indirect", "stale"] {
        desk.frames("cornell.ron", &format!("--script m.ron --out {show} --show {show} --work 5000"));
        let picture = desk.picture(&format!("{show}/frame_00000.png"));
        assert!(picture.width() == 64 && picture.height() > 48, "{show}");
        let below = picture.rows().skip(48).flatten();
        assert!(below.filter(|p| **p == Rgb(FALSE_COLOURS[8])).count() > 10, "{show}: the legend ends with the last colour");
    }
    // Each element has a colour of its own: there is no scale.
    desk.frames("cornell.ron", "--out elements --show elements");
    assert_eq!(desk.picture("elements/front.png").dimensions(), (64, 48));
    let share_of_first = |name: &str| {
        let picture = desk.picture(name);
        let seen: Vec<_> = picture.rows().take(48).flatten().filter(|p| p.0 != [0; 3]).copied().collect();
        seen.iter().filter(|p| **p == Rgb(FALSE_COLOURS[0])).count() as f64 / seen.len() as f64
    };
    assert_eq!(share_of_first("stale/frame_00000.png"), 1.0, "nothing is stale before the edit");
    assert!(share_of_first("stale/frame_00001.png") < 0.9);
    let last = desk.names("stale").into_iter().rfind(|name| name.starts_with("frame_")).expect("a frame");
    assert_eq!(share_of_first(&format!("stale/{last}")), 1.0, "nothing is stale in the end");
}

#[test]
fn ranges_and_exposure_are_kept_to() {
    let desk = Desk::new();
    for (out, range) in [("low", "0.001,0.01"), ("high", "100000,1000000"), ("linear", "0,1000")] {
        desk.frames("cornell.ron", &format!("--out {out} --show illuminance --range {range}"));
    }
    let share = |out: &str, colour: usize| {
        let picture = desk.picture(&format!("{out}/front.png"));
        let seen: Vec<_> = picture.rows().take(48).flatten().filter(|p| p.0 != [0; 3]).copied().collect();
        seen.iter().filter(|p| **p == Rgb(FALSE_COLOURS[colour])).count() as f64 / seen.len() as f64
    };
    assert!(share("low", 8) > 0.99 && share("high", 0) > 0.99);
    assert!(share("linear", 0) < 0.5 && share("linear", 8) < 0.5);
    let brightness = |ev: &str| {
        desk.frames("cornell.ron", &format!("--out ev --exposure {ev}"));
        desk.bytes("ev/front.png");
        desk.picture("ev/front.png").into_raw().into_iter().map(u64::from).sum::<u64>()
    };
    let [bright, middle, dark] = ["3", "6", "9"].map(brightness);
    assert!(bright > middle && middle > dark && dark > 0, "{bright} {middle} {dark}");
    desk.frames("cornell.ron", "--out aa --aa 2");
    assert_eq!(desk.picture("aa/front.png").dimensions(), (64, 48));
}

#[test]
fn the_summary_keeps_the_contract() {
    let desk = desk();
    let arguments = "frames cornell.ron --size 64x48 --photons 20000 --script m.ron --out out --threads 2";
    let printed: Value = serde_json::from_str(&desk.done(&format!("{arguments} --json"))).expect("one JSON document");
    assert_eq!(printed, desk.json("out/summary.json"));
    for (key, value) in [
        ("scene", Value::from("cornell")),
        ("width", 64.into()),
        ("height", 48.into()),
        ("samples", 1.into()),
        ("photons", 20_000.into()),
        ("work", 200_000.into()),
        ("fps", 10.0.into()),
        ("threads", 2.into()),
        ("interrupted", false.into()),
        ("failed", Value::Null),
        ("contact_sheet", "contact.png".into()),
    ] {
        assert_eq!(printed[key], value, "{key}");
    }
    assert!(printed["driver"].as_str().is_some_and(|driver| driver.len() > 3), "{}", printed["driver"]);
    for pass in ["preparation", "prepass", "shadows", "composition", "exposure", "tone", "frame"] {
        assert!(printed["milliseconds"][pass].as_f64().is_some_and(|ms| ms >= 0.0), "{pass}");
    }
    for (number, frame) in printed["frames"].as_array().expect("frames").iter().enumerate() {
        assert_eq!((&frame["frame"], &frame["file"]), (&number.into(), &format!("frame_{number:05}.png").into()));
        assert!((frame["time"].as_f64().expect("a number") - number as f64 / 10.0).abs() < 1e-9);
        assert_eq!(frame["exact"], frame["stale_groups"] == 0);
        assert!(frame["exposure"].as_f64().expect("a number") > 0.0);
    }
    let told = desk.done(arguments);
    assert!(told.starts_with("drawing on ") && told.contains("out/*.png") && told.lines().count() == 2, "{told}");
    assert_eq!(desk.done(&format!("{arguments} --quiet")), "");
}

#[test]
fn several_frames_have_a_contact_sheet() {
    let desk = desk();
    desk.frames("cornell.ron", "--script m.ron --out out");
    let sheet = desk.picture("out/contact.png");
    assert!(sheet.width() == 3 * 320 && sheet.height() > 240, "{:?}", sheet.dimensions());
    desk.frames("cornell.ron", "--out one");
    assert_eq!(desk.names("one"), ["front.png", "summary.json"]);
    assert_eq!(desk.json("one/summary.json")["contact_sheet"], Value::Null);
}

/// What a shorter run leaves of a longer one would be taken for its own.
#[test]
fn frames_of_an_earlier_run_are_removed() {
    let desk = Desk::new();
    desk.script(&[(0.9, AWAY)], &[]);
    desk.frames("cornell.ron", "--script m.ron --out out --exr");
    desk.write("out/frame_mine.png", "mine");
    desk.write("out/frame_00099.png", "not drawn by any run");
    desk.script(&[(0.1, AWAY)], &[]);
    let before = desk.content();
    desk.refuses("frames cornell.ron --photons 20000 --script m.ron --out out --camera back", &["'back'"]);
    assert!(desk.content() == before);
    desk.frames("cornell.ron", "--script m.ron --out out");
    let frames = ["frame_00000.png", "frame_00001.png", "frame_00002.png", "frame_00099.png", "frame_mine.png"];
    assert_eq!(desk.names("out"), [&["contact.png"], &frames[..], &["summary.json"]].concat());
    // Pictures that are called after a camera stay beside others.
    desk.frames("cornell.ron", "--out out");
    desk.change("\"front\"", "\"other\"");
    desk.frames("cornell.ron", "--out out");
    assert_eq!(desk.names("out"), ["frame_00099.png", "frame_mine.png", "front.png", "other.png", "summary.json"]);
}

#[test]
fn names_may_be_in_any_script() {
    let desk = desk();
    desk.folder("où/部屋");
    desk.change("\"front\"", "\"前/ö\"");
    desk.done("apply cornell.ron --script m.ron --quiet --out où/部屋/scène.ron");
    desk.frames("où/部屋/scène.ron", "--out où/image");
    assert_eq!(desk.names("où/image"), ["summary.json", "前_ö.png"]);
}

/// Runs with a program called ffmpeg that does this.
fn with_ffmpeg(desk: &Desk, does: &str, arguments: &str) -> Output {
    desk.folder("bin");
    desk.write("bin/ffmpeg", format!("#!/bin/sh\nfor last; do :; done\n{does}\n"));
    fs::set_permissions(desk.path("bin/ffmpeg"), fs::Permissions::from_mode(0o755)).expect("a program");
    let path = format!("{}:{}", desk.path("bin").display(), std::env::var("PATH").unwrap_or_default());
    let arguments = format!("frames cornell.ron --size 64x48 --photons 20000 --script m.ron --out out {arguments}");
    desk.command(&arguments).env("PATH", path).output().expect("the program runs")
}

#[test]
fn a_film_is_made_if_ffmpeg_is_there() {
    let desk = desk();
    let output = with_ffmpeg(&desk, "cat > \"$last\"", "--show illuminance");
    assert!(output.status.success() && output.stderr.is_empty());
    assert!(String::from_utf8_lossy(&output.stdout).contains("out/film.mp4"));
    assert_eq!(desk.json("out/summary.json")["film"], "film.mp4");
    // Frames as they are, legend included.
    let film = desk.bytes("out/film.mp4");
    let frame = desk.picture("out/frame_00000.png");
    let header = format!("P6\n64 {}\n255\n", frame.height());
    assert_eq!(film.len(), 3 * (header.len() + frame.as_raw().len()));
    assert!(film.starts_with(header.as_bytes()) && film[header.len()..].starts_with(frame.as_raw()));
    let names = ["contact.png", "film.mp4", "frame_00000.png", "frame_00001.png", "frame_00002.png", "summary.json"];
    assert_eq!(desk.names("out"), names);
    // A run without it leaves no film of the one before.
    with_ffmpeg(&desk, "exit 1", "--quiet");
    assert!(!desk.path("out/film.mp4").exists());
}

#[test]
fn frames_do_not_need_their_film() {
    for fails in ["echo half > \"$last\"; exit 1", "cat > /dev/null; exit 1", "exit 1", "exit 0", "kill -9 $$"] {
        let desk = desk();
        let output = with_ffmpeg(&desk, fails, "");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{fails}: {stderr}");
        assert!(stderr.starts_with("warning: ffmpeg failed") && stderr.lines().count() == 1, "{fails}: {stderr}");
        assert!(!String::from_utf8_lossy(&output.stdout).contains("film"), "{fails}");
        assert_eq!(desk.json("out/summary.json")["film"], Value::Null);
        assert_eq!(desk.names("out"), ["contact.png", "frame_00000.png", "frame_00001.png", "frame_00002.png", "summary.json"]);
        assert!(with_ffmpeg(&desk, fails, "--quiet").stderr.is_empty(), "{fails}: silence includes warnings");
    }
}
