//! A walk through the ROOM by mouse and keyboard.

use super::{
    program::{Desk, pictures},
    room::Room,
    screen::{Screen, keys, pause},
};
use glam::DVec3;
use lightmend_scene::{Configuration, Scene};

/// Where the table stands in a scene file.
fn table(desk: &Desk, scene: &str) -> DVec3 {
    let scene = Scene::read(&desk.path(scene)).unwrap().0;
    let configuration = Configuration::initial(&scene);
    configuration.object_motion(configuration.object_id("table").unwrap()).translation
}

/// A point of its top that nothing stands on, and where it is dragged.
const HELD: DVec3 = DVec3::new(1.75, 3.25, 0.74);
const STEP: DVec3 = DVec3::new(0.5, 0.1, 0.0);

#[test]
fn the_table_is_dragged_and_its_light_mends() {
    let Some(screen) = Screen::start() else { return };
    let desk = Desk::new();
    let kept = pictures();
    std::fs::copy(desk.path("room.ron"), desk.path("original.ron")).unwrap();
    let room = Room::learn(&desk, &screen, "room.ron", 0);

    let program = desk.view(&screen, "room.ron --record walk.ron --dump view.txt --summary summary.json");
    let middle = [700, 300];
    screen.point(middle);
    screen.wait_for_title("room.ron — exact");
    let before = screen.still();
    // One looks around, and comes back to the camera of the file.
    screen.drag(3, middle, [850, 280], 12);
    let around = screen.still();
    around.save(kept.join("around.png")).unwrap();
    assert!(room.difference(&before, &around) > 5.0, "one sees something else");
    screen.key(&[], u32::from(b'1'));
    screen.point(middle);
    let again = screen.still();
    assert!(room.difference(&before, &again) < 0.5, "and then the same again: {}", room.difference(&before, &again));
    before.save(kept.join("before.png")).unwrap();

    // The table is dragged, step by step; in the middle of it, it is on its way.
    let (from, to) = (room.pixel(HELD), room.pixel(HELD + STEP));
    screen.point(from);
    pause(300);
    screen.press(1);
    for step in 1..=20 {
        screen.point([0, 1].map(|i| from[i] + (to[i] - from[i]) * step / 20));
        pause(50);
        if step == 10 {
            screen.keep(&kept.join("during.png"));
        }
    }
    pause(200);
    screen.release(1);
    screen.wait_for_title("room.ron* — exact");
    let after = screen.still();
    after.save(kept.join("after.png")).unwrap();
    assert!(room.difference(&before, &after) > 1.0);
    screen.key(&[keys::CONTROL], u32::from(b's'));
    screen.wait_for_title("room.ron — exact");
    screen.key(&[keys::CONTROL], u32::from(b'q'));
    assert_eq!(program.end(), (Some(0), String::new()));

    // It went where the mouse went: a pixel is less than a centimetre there.
    let step = table(&desk, "room.ron") - table(&desk, "original.ron");
    assert!((step - STEP).length() < 0.015, "{step}");
    // Its light is that of a fresh solution of the saved scene, and of the recording that is replayed without a window.
    desk.done("solve room.ron --photons 200000 --dump fresh.txt --quiet");
    assert!(desk.read("view.txt") == desk.read("fresh.txt"), "the window's buckets differ from a fresh solution's");
    desk.done("apply original.ron --script walk.ron --out replayed.ron --quiet");
    desk.done("solve replayed.ron --photons 200000 --dump replayed.txt --quiet");
    assert!(desk.read("view.txt") == desk.read("replayed.txt"), "the recording ends with other light");
    desk.done("replay original.ron --script walk.ron --photons 200000 --orders stateless --out replay --quiet");
    desk.done("frames original.ron --script walk.ron --photons 200000 --size 64x48 --every 10 --out frames --quiet");
    let frames = desk.json("frames/summary.json");
    assert_eq!(frames["frames"].as_array().unwrap().last().unwrap()["exact"], true);
    println!("{:#}", desk.json("summary.json")["stretches"]);
}

#[test]
fn what_is_undone_leaves_no_trace() {
    let Some(screen) = Screen::start() else { return };
    let desk = Desk::new();
    std::fs::copy(desk.path("room.ron"), desk.path("original.ron")).unwrap();
    let room = Room::learn(&desk, &screen, "room.ron", 0);
    let program = desk.view(&screen, "room.ron --dump view.txt --record walk.ron");
    let exact = "room.ron — exact";
    screen.wait_for_title(exact);
    screen.point([400, 60]);
    let before = screen.still();
    screen.drag(1, room.pixel(HELD), room.pixel(HELD + STEP), 10);
    screen.wait_for_title("room.ron* — ");
    screen.key(&[keys::CONTROL], u32::from(b'z'));
    screen.wait_for_title(exact);
    screen.key(&[], keys::ESCAPE);
    screen.point([400, 60]);
    let after = screen.still();
    after.save(pictures().join("undone.png")).unwrap();
    assert!(room.difference(&before, &after) < 1.0, "{}", room.difference(&before, &after));
    screen.key(&[keys::CONTROL], u32::from(b's'));
    pause(500);
    screen.key(&[keys::CONTROL], u32::from(b'q'));
    assert_eq!(program.end(), (Some(0), String::new()));
    assert_eq!(table(&desk, "room.ron"), table(&desk, "original.ron"));
    desk.done("solve original.ron --photons 200000 --dump fresh.txt --quiet");
    assert!(desk.read("view.txt") == desk.read("fresh.txt"), "undone, but the light differs");
    desk.done("apply original.ron --script walk.ron --out replayed.ron --quiet");
    assert_eq!(table(&desk, "replayed.ron"), table(&desk, "original.ron"));
}
