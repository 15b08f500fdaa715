//! What happens to windows: they are made tiny, hidden, dragged out of, and their graphics device goes away.

use super::{
    program::Desk,
    screen::{Screen, keys, pause},
};

#[test]
fn a_window_survives_what_is_done_to_it() {
    let Some(screen) = Screen::start() else { return };
    let desk = Desk::new();
    let mut program = desk.view(&screen, "room.ron --dump view.txt");
    screen.wait_for_title("room.ron — exact");

    // Presses on the panel and in the menus are not the room's, wherever they end.
    for from in [[1100, 90], [1150, 700], [600, 10], [600, 790]] {
        screen.drag(1, from, [500, 420], 6);
        screen.key(&[], keys::ESCAPE);
    }
    pause(300);
    assert!(screen.title().starts_with("room.ron — "), "{}", screen.title());

    // As small as can be, with the mouse at work in it; and back.
    screen.resize([1, 1]);
    pause(300);
    screen.drag(1, [0, 0], [300, 200], 5);
    screen.key(&[], keys::F1);
    screen.key(&[], keys::ESCAPE);
    screen.resize([640, 360]);
    pause(500);
    assert!(program.runs());

    // A drag leaves the window and ends outside of it; another button is pressed meanwhile.
    screen.drag(1, [200, 200], [1200, 780], 10);
    screen.point([200, 200]);
    screen.press(1);
    screen.point([260, 220]);
    screen.press(3);
    screen.press(2);
    screen.point([900, 600]);
    screen.release(1);
    screen.release(2);
    screen.release(3);
    assert!(program.runs());

    // Hidden and shown, and the device lost, while it is.
    screen.map(false);
    pause(500);
    screen.map(true);
    screen.resize([1280, 800]);
    pause(500);
    screen.focus();
    // From wherever the buttons have taken the camera.
    screen.key(&[], u32::from(b'1'));
    let shown = |screen: &Screen| screen.part([300, 300], 64).chunks_exact(4).any(|p| p[..3].iter().any(|c| *c > 20));
    screen.wait("the room on the screen", || shown(&screen));
    for _ in 0..2 {
        screen.key(&[keys::CONTROL, keys::SHIFT], u32::from(b'g'));
        pause(1500);
        screen.wait("the room on the screen again", || shown(&screen));
    }
    assert!(program.runs());

    // Pictures, beside the scene file.
    screen.key(&[], keys::F12);
    screen.key(&[keys::SHIFT], keys::F12);
    screen.wait("a PNG and an EXR", || desk.path("room-001.png").exists() && desk.path("room-002.exr").exists());
    assert!(image::open(desk.path("room-001.png")).unwrap().width() > 500);

    // Whatever was moved: what is on the desk is saved, and its light is right.
    screen.key(&[keys::CONTROL], u32::from(b's'));
    screen.wait_for_title("room.ron — exact");
    screen.key(&[keys::CONTROL], u32::from(b'q'));
    let (status, told) = program.end();
    assert_eq!(status, Some(0), "{told}");
    assert!(told.lines().all(|line| line.contains("device was lost")), "{told}");
    desk.done("solve room.ron --photons 200000 --dump fresh.txt --quiet");
    assert!(desk.read("view.txt") == desk.read("fresh.txt"));
}

#[test]
fn without_a_screen_it_says_so() {
    let desk = Desk::new();
    let mut command = desk.command("view room.ron");
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    let run = command.output().unwrap();
    let told = String::from_utf8(run.stderr).unwrap();
    assert_eq!(run.status.code(), Some(1));
    assert!(told.lines().count() == 1 && told.contains("no window can be opened") && told.contains("lightmend frames"), "{told}");
}

#[test]
fn what_is_not_saved_is_asked_for_and_kept_on_ctrl_c() {
    let Some(screen) = Screen::start() else { return };
    let desk = Desk::new();
    let before = desk.read("room.ron");
    let mut program = desk.view(&screen, "room.ron --script moves/table.ron --record walk.ron");
    screen.wait_for_title("room.ron* — exact");
    // Quit asks, and Escape means no.
    screen.key(&[keys::CONTROL], u32::from(b'q'));
    pause(500);
    screen.key(&[], keys::ESCAPE);
    pause(500);
    assert!(program.runs());
    let pid = program.0.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let (status, told) = program.end();
    assert_eq!(status, Some(1));
    assert!(told.contains("interrupted; what was not saved is kept in room.autosave.ron"), "{told}");
    assert_eq!(desk.read("room.ron"), before);
    desk.done("apply room.ron --script walk.ron --out replayed.ron --quiet");
    desk.done("check room.autosave.ron");
    desk.done("solve room.autosave.ron --photons 20000 --dump kept.txt --quiet");
    desk.done("solve replayed.ron --photons 20000 --dump replayed.txt --quiet");
    assert!(desk.read("kept.txt") == desk.read("replayed.txt"));
}
