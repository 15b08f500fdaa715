//! What dragging feels like: thirty seconds of it in the ROOM and in the HOUSE. Prints, and asserts nothing about speed; only in the
//! thorough form, on a machine that is left alone.

use super::{
    program::Desk,
    room::Room,
    screen::{Screen, keys, pause},
};
use glam::DVec3;
use std::time::{Duration, Instant};

/// A point of the table's top that nothing stands on, relative to where it stands.
const HELD: DVec3 = DVec3::new(-0.15, 0.25, 0.74);

fn drag_for_half_a_minute(scene: &str, camera: usize, table: DVec3, reach: DVec3) {
    if std::env::var_os("LIGHTMEND_THOROUGH").is_none() {
        eprintln!("SKIPPED: half a minute of dragging is measured with LIGHTMEND_THOROUGH=1 only");
        return;
    }
    let Some(screen) = Screen::start() else { return };
    let desk = Desk::of(scene);
    let file = format!("{scene}.ron");
    let room = Room::learn(&desk, &screen, &file, camera);
    let program = desk.view(&screen, &format!("{file} --photons 1152000 --summary summary.json --dump view.txt"));
    screen.key(&[], u32::from(b'1') + camera as u32);
    screen.wait_for_title(&format!("{file} — exact"));
    pause(3000);

    // Round and round, at the rate of a mouse; no press or move waits for the program.
    let held = table + HELD;
    let at = |seconds: f64| held + reach * DVec3::new((1.0 - (seconds * 1.3).cos()) / 2.0, (seconds * 1.7).sin(), 0.0);
    screen.point(room.pixel(held));
    pause(500);
    screen.press(1);
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(30) {
        screen.point(room.pixel(at(start.elapsed().as_secs_f64())));
        pause(8);
    }
    screen.release(1);
    screen.wait_for_title(&format!("{file}* — exact"));

    // From the mouse to the screen: how long until a step of it changes the pixels there.
    let mut delays = Vec::new();
    for step in 0..20 {
        let (from, to) = (room.pixel(held + DVec3::X * 0.2), room.pixel(held));
        if step == 0 {
            pause(1500);
            screen.point(room.pixel(at(start.elapsed().as_secs_f64())));
            screen.key(&[keys::CONTROL], u32::from(b'z'));
            screen.wait_for_title(&format!("{file} — exact"));
            screen.point(to);
            pause(300);
            screen.press(1);
            screen.point([to[0] + 5, to[1]]);
        }
        // Something moves all the time, so that frames come at their rate.
        for wiggle in 0..20 + step * 7 % 5 {
            screen.point([to[0] + wiggle % 2, to[1]]);
            pause(13);
        }
        let edge = [from[0] - 40, from[1] - 40];
        pause(120);
        let before = screen.part(edge, 80);
        let moved = Instant::now();
        screen.point(from);
        while screen.part(edge, 80) == before && moved.elapsed() < Duration::from_secs(5) {}
        delays.push(moved.elapsed().as_secs_f64() * 1000.0);
    }
    screen.release(1);
    screen.wait_for_title("— exact");
    screen.key(&[keys::CONTROL], u32::from(b's'));
    pause(500);
    screen.key(&[keys::CONTROL], u32::from(b'q'));
    assert_eq!(program.end(), (Some(0), String::new()));
    desk.done(&format!("solve {file} --photons 1152000 --dump fresh.txt --quiet"));
    assert!(
        desk.read("view.txt") == desk.read("fresh.txt"),
        "dragged for half a minute, and the light is not that of a fresh solution"
    );

    delays.sort_by(f64::total_cmp);
    let summary = desk.json("summary.json");
    println!("{scene}: {:#}", summary["stretches"][0]);
    let between = summary["stretches"][0]["milliseconds_between_frames"]["median"].as_f64().unwrap();
    println!(
        "{scene}: from a move of the mouse until the screen shows it: median {:.0} ms, longest {:.0} ms ({:.1} and {:.1} frames)",
        delays[delays.len() / 2],
        delays[delays.len() - 1],
        delays[delays.len() / 2] / between,
        delays[delays.len() - 1] / between
    );
}

#[test]
fn dragging_in_the_room() {
    drag_for_half_a_minute("room", 0, DVec3::new(1.9, 3.0, 0.0), DVec3::new(0.9, 0.25, 0.0));
}

#[test]
fn dragging_in_the_house() {
    drag_for_half_a_minute("house", 0, DVec3::new(1.7, 3.0, 0.0), DVec3::new(0.7, 0.25, 0.0));
}
