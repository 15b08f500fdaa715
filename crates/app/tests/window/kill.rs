//! The program is killed at any moment: no scene file is ever damaged, and what was kept can be opened.

use super::{
    program::Desk,
    screen::{Screen, keys, pause},
};

/// Where the table's top is on the screen.
const TABLE: [i32; 2] = [150, 545];

#[test]
fn killed_at_any_moment_it_loses_nothing() {
    let Some(screen) = Screen::start() else { return };
    let rounds = if std::env::var_os("LIGHTMEND_THOROUGH").is_some() { 60 } else { 6 };
    let desk = Desk::new();
    let original = desk.read("room.ron");
    let mut kept = 0;
    for round in 0..rounds {
        let mut program = desk.view(&screen, "room.ron");
        // Something goes on all the time: the table is moved by keys, the scene is saved now and then.
        screen.click(TABLE);
        let moments = 8 + round * 11 % 31;
        for moment in 0..moments {
            // By a degree: by 15 it would be back where it was saved after two dozen.
            screen.key_down(keys::SHIFT);
            screen.key_down(u32::from(b'r'));
            screen.key_up(u32::from(b'r'));
            screen.key_up(keys::SHIFT);
            pause(37 + (61 * (round + moment)) % 190);
            if (round + moment) % 29 == 5 {
                screen.key_down(keys::CONTROL);
                screen.key_down(u32::from(b's'));
                screen.key_up(u32::from(b's'));
                screen.key_up(keys::CONTROL);
            }
        }
        program.0.kill().unwrap();
        drop(program);
        assert!(desk.read("room.ron").ends_with(")\n"), "half-written");
        desk.done("check room.ron");
        if desk.path("room.autosave.ron").exists() {
            kept += 1;
            desk.done("check room.autosave.ron");
            desk.done("solve room.autosave.ron --photons 20000 --quiet");
            std::fs::remove_file(desk.path("room.autosave.ron")).unwrap();
        }
    }
    println!("{kept} of {rounds} rounds left an autosave");
    assert!(kept > 0 && desk.read("room.ron") != original, "nothing was going on");
}
