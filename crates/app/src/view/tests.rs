//! What clumsy and careful hands do at the desk ([`Trial`]), and what comes of it.

use super::{
    commands::Command,
    desk::Request,
    dialogs::Dialog,
    session::{Selection, Session},
    trial::{Trial, start},
};
use egui::{Event, Key, Modifiers, PointerButton, pos2, vec2};
use glam::DVec3;
use lightmend_photon::solution::Solution;
use lightmend_scene::{Configuration, Edit, Moves, Scene};
use std::path::{Path, PathBuf};

#[test]
fn the_table_goes_where_the_mouse_goes_and_comes_back() {
    let mut trial = Trial::new();
    let before = trial.state();
    let from = trial.seen("table");
    let held = trial.desk.viewport.under(&mut trial.desk.session, from).unwrap().1;
    let (old, cup) = (trial.place("table"), before.objects().find(|(_, o)| o.carrier == Some(trial.id("table"))).unwrap().0);
    let to = from + vec2(-60.0, 25.0);
    trial.drag(from, to);
    assert_eq!(trial.desk.session.selection, Some(Selection::Object(trial.id("table"))), "what is dragged is selected");
    let step = trial.place("table") - old;
    assert!(step.length() > 0.1 && step.z.abs() < 1e-9, "{step}");
    // What was held is under the pointer.
    let camera = trial.desk.viewport.camera(&trial.desk.session).unwrap();
    let at = camera.project(held + step).unwrap();
    let rect = trial.desk.viewport.rect;
    let at = rect.center() + vec2(at.x as f32, -at.y as f32) * rect.size() / 2.0;
    assert!(at.distance(to) < 1.0, "{at} {to}");
    let after = trial.state();
    assert!(
        (after.object_motion(cup).translation - before.object_motion(cup).translation - step).length() < 1e-9,
        "the cup rides along"
    );
    trial.key(Key::Z, Modifiers::COMMAND);
    assert!(trial.state() == before && !trial.desk.session.is_changed(), "undone to the bit");
    trial.key(Key::Z, Modifiers::COMMAND | Modifiers::SHIFT);
    assert!(trial.state() == after, "done again to the bit");
    assert!(trial.replayed() == after);
    // The light in the background comes to what a fresh solution gives.
    let light = trial.desk.session.solver.wait_until_exact();
    let fresh =
        Solution::shoot(start().pool, light.world.clone(), lightmend_photon::path::FirstHits::AsLampsSay, &mut |_, _| true)
            .unwrap();
    assert!(light.buckets == *fresh.buckets() && *light.configuration() == after);
}

#[test]
fn no_click_falls_through_a_panel() {
    let mut trial = Trial::new();
    let before = (trial.state(), trial.desk.session.navigation.view());
    let rect = trial.desk.viewport.rect;
    let panel = pos2(rect.right() + 100.0, 500.0);
    for button in [PointerButton::Primary, PointerButton::Secondary, PointerButton::Middle] {
        // In a panel and dragged into the room; in the menus; in the line at the bottom.
        for place in [panel, pos2(600.0, rect.top() - 8.0), pos2(600.0, rect.bottom() + 8.0), pos2(1279.0, 400.0)] {
            trial.press(place, button);
            trial.point(rect.center());
            trial.point(rect.center() + vec2(100.0, 60.0));
            trial.release(rect.center(), button);
        }
    }
    let after = (trial.state(), trial.desk.session.navigation.view());
    assert!(before == after && trial.desk.session.selection.is_none());

    // A press over the panel without any move before it, all in one frame.
    trial.point(rect.center());
    trial.frame([
        Event::PointerMoved(panel),
        Trial::button(panel, PointerButton::Primary, true),
        Trial::button(panel, PointerButton::Primary, false),
    ]);
    assert!(trial.desk.session.selection.is_none(), "the panel's click is not the room's");

    // An open menu: a click beside it closes it and does nothing else.
    trial.click(pos2(20.0, rect.top() / 2.0));
    trial.frame([]);
    assert!(egui::Popup::is_any_open(&trial.context), "the File menu is open");
    let table = trial.seen("table");
    trial.click(table);
    trial.frame([]);
    assert!(!egui::Popup::is_any_open(&trial.context) && trial.desk.session.selection.is_none());
    trial.click(table);
    assert!(trial.desk.session.selection.is_some(), "the next click is the room's again");

    // A question over all: nothing behind it can be touched.
    trial.desk.run(Command::Help);
    trial.frame([]);
    trial.drag(table, table + vec2(120.0, 0.0));
    assert!(trial.state() == before.0);
}

#[test]
fn a_drag_may_leave_the_window_and_end_there() {
    let mut trial = Trial::new();
    let before = trial.state();
    let from = trial.seen("table");
    for to in [pos2(-500.0, 300.0), pos2(5000.0, 300.0), pos2(300.0, 9000.0), pos2(400.0, -3000.0), pos2(1270.0, 700.0)] {
        trial.press(from, PointerButton::Primary);
        trial.point(from + vec2(10.0, 0.0));
        trial.point(to);
        trial.frame([Event::PointerGone]);
        trial.release(to, PointerButton::Primary);
        assert!(!trial.desk.viewport.is_busy() && !trial.desk.session.history.is_open());
        let place = trial.place("table");
        assert!(place.is_finite() && place.abs().max_element() < 100.0, "{to}: {place}");
        // Nothing is held any more.
        let now = trial.state();
        trial.point(from);
        trial.point(from + vec2(50.0, 50.0));
        assert!(trial.state() == now);
        while trial.desk.session.history.last_done().is_some() {
            trial.desk.session.undo();
        }
        assert!(trial.state() == before);
    }
    // The window loses the keyboard in the middle: nobody may tell of the release.
    trial.press(from, PointerButton::Primary);
    trial.point(from + vec2(40.0, 10.0));
    trial.frame([Event::WindowFocused(false)]);
    let now = trial.state();
    trial.point(from + vec2(90.0, 30.0));
    assert!(trial.state() == now && now != before && !trial.desk.viewport.is_busy());
}

#[test]
fn two_buttons_at_once_do_no_harm() {
    let mut trial = Trial::new();
    let before = trial.state();
    let view = trial.desk.session.navigation.view();
    let from = trial.seen("table");
    // A second button does not look around, and its release does not end the drag.
    trial.press(from, PointerButton::Primary);
    trial.point(from + vec2(30.0, 0.0));
    trial.frame([Trial::button(from, PointerButton::Middle, true)]);
    trial.point(from + vec2(60.0, 0.0));
    trial.frame([Trial::button(from, PointerButton::Middle, false)]);
    assert!(trial.desk.viewport.is_busy() && trial.desk.session.navigation.view() == view);
    // The right one puts it back.
    trial.frame([Trial::button(from, PointerButton::Secondary, true)]);
    assert!(trial.state() == before && !trial.desk.viewport.is_busy());
    trial.point(from + vec2(90.0, 0.0));
    trial.frame([Trial::button(from, PointerButton::Primary, false), Trial::button(from, PointerButton::Secondary, false)]);
    assert!(
        trial.state() == before
            && trial.desk.session.history.last_done().is_none()
            && trial.desk.session.history.last_undone().is_none()
    );
    assert!(trial.replayed() == before);
    // Escape does too.
    trial.press(from, PointerButton::Primary);
    trial.point(from + vec2(30.0, 0.0));
    assert!(trial.state() != before);
    trial.key(Key::Escape, Modifiers::NONE);
    assert!(trial.state() == before);
    // Deleted while it is dragged, and all buttons at once.
    trial.press(from, PointerButton::Primary);
    trial.point(from + vec2(30.0, 0.0));
    trial.key(Key::Delete, Modifiers::NONE);
    trial.point(from + vec2(60.0, 0.0));
    assert!(trial.desk.session.configuration.object_id("table").is_err());
    for button in [PointerButton::Primary, PointerButton::Secondary, PointerButton::Middle, PointerButton::Extra1] {
        trial.frame([Trial::button(from, button, true)]);
        trial.frame([Trial::button(from, button, false)]);
    }
    trial.key(Key::Z, Modifiers::COMMAND);
    trial.key(Key::Z, Modifiers::COMMAND);
    assert!(trial.state() == before);
}

#[test]
fn a_window_of_one_pixel_does_no_harm() {
    let mut trial = Trial::new();
    let before = trial.state();
    for size in [vec2(1.0, 1.0), vec2(0.0, 0.0), vec2(1.0, 900.0), vec2(900.0, 1.0), vec2(60.0, 40.0)] {
        trial.size = size;
        for _ in 0..3 {
            trial.drag(pos2(0.5, 0.5), pos2(30.0, 20.0));
        }
        trial.key(Key::F1, Modifiers::NONE);
        trial.key(Key::Escape, Modifiers::NONE);
    }
    trial.size = vec2(1280.0, 800.0);
    trial.frame([]);
    trial.frame([]);
    trial.desk.dialog = None;
    assert!(trial.state() == before);
    let table = trial.seen("table");
    trial.click(table);
    assert!(trial.desk.session.selection.is_some());
}

#[test]
fn everything_can_be_undone_and_is_recorded() {
    let mut trial = Trial::new();
    let before = trial.state();
    let table = trial.seen("table");
    trial.click(table);
    let wheel = |y: f32| Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: vec2(0.0, y),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    };
    trial.point(table + vec2(1.0, 0.0));
    trial.frame([wheel(1.0)]);
    let turned =
        trial.desk.session.configuration.object(trial.id("table")).pose.rotation - before.object(trial.id("table")).pose.rotation;
    assert_eq!(turned, DVec3::Z * 15.0, "the wheel turns what is selected");
    trial.key(Key::T, Modifiers::SHIFT);
    trial.key(Key::ArrowRight, Modifiers::NONE);
    trial.key(Key::PageUp, Modifiers::NONE);
    trial.key(Key::D, Modifiers::COMMAND);
    assert_eq!(trial.desk.session.selection, Some(Selection::Object(trial.id("table 2"))), "the copy is selected");
    trial.key(Key::Delete, Modifiers::NONE);
    let lamp = trial.desk.session.configuration.lamps().next().unwrap().0;
    trial.desk.session.selection = Some(Selection::Lamp(lamp));
    trial.key(Key::L, Modifiers::NONE);
    assert!(!trial.desk.session.configuration.lamp(lamp).lit);
    trial.key(Key::PageDown, Modifiers::NONE);
    trial.key(Key::D, Modifiers::COMMAND);
    trial.key(Key::Delete, Modifiers::NONE);
    let file = trial.folder.path().join("ies");
    let ies =
        std::fs::read_dir(file).unwrap().flatten().map(|e| e.path()).find(|p| p.extension().is_some_and(|e| e == "ies")).unwrap();
    super::panels::relamp(&mut trial.desk.session, lamp, Some(&ies));
    super::panels::relamp(&mut trial.desk.session, lamp, None);
    let name = trial.desk.session.configuration.lamp(lamp).name.clone();
    for n in 0..50 {
        trial.desk.session.go_on("Dim", Edit::Light { lamp: name.clone(), intensity: DVec3::splat(f64::from(n)) });
    }
    trial.frame([]);
    let end = trial.state();
    let actions = std::iter::from_fn(|| {
        let any = trial.desk.session.history.last_done().is_some();
        any.then(|| trial.desk.session.undo())
    });
    let count = actions.count();
    assert!(trial.state() == before && count == 13, "{count} actions lead back");
    while trial.desk.session.history.last_undone().is_some() {
        trial.desk.session.redo();
    }
    assert!(trial.state() == end);
    assert!(trial.replayed() == end, "what was recorded leads to the same");
    let scene = trial.folder.path().join("elsewhere.ron");
    trial.desk.session.save(&scene).unwrap();
    let saved = Scene::read(&scene).unwrap().0;
    assert_eq!(Configuration::initial(&saved).content_hash(), end.content_hash(), "and so does the file");
}

#[test]
fn a_model_becomes_furniture() {
    let mut trial = Trial::new();
    let before = trial.state();
    let model = trial.folder.path().join("stool.obj");
    // A box of 40 by 60 by 50 centimetres, y upwards, with a face without an area.
    let text = "mtllib stool.mtl\nv 0 0 0\nv 40 0 0\nv 40 60 0\nv 0 60 0\nv 0 0 50\nv 40 0 50\nv 40 60 50\nv 0 60 50\nusemtl cloth\nf 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 4 8 7 3\nf 1 5 8 4\nf 2 3 7 6\nf 1 1 2\n";
    std::fs::write(&model, text).unwrap();
    std::fs::write(trial.folder.path().join("stool.mtl"), "newmtl cloth\nKd 0.2 0.3 0.4\n").unwrap();
    let dialog = Dialog::chosen_object(&trial.desk.session, model);
    let Dialog::Model(model) = dialog else { panic!("a model") };
    model.add(&mut trial.desk.session).unwrap();
    let id = trial.id("stool");
    let [low, high] = super::pick::bounds(&trial.desk.session.configuration, id);
    assert!(((high - low) - DVec3::new(0.4, 0.5, 0.6)).length() < 1e-9, "{}", high - low);
    assert!(low.z > -1e-3, "it stands on something: {low}");
    let object = trial.desk.session.configuration.object(id);
    assert!(object.movable && object.materials[0].name == "stool, cloth" && object.mesh.triangles.len() == 12);
    let with = trial.state();
    let path = trial.desk.session.path.clone();
    trial.desk.session.save(&path).unwrap();
    assert_eq!(Configuration::initial(&Scene::read(&path).unwrap().0).content_hash(), with.content_hash());
    assert!(trial.replayed() == with);
    trial.desk.session.undo();
    assert!(trial.state() == before);
    trial.desk.session.redo();
    assert!(trial.state() == with);
}

#[test]
fn changes_are_kept_until_they_are_saved() {
    let mut trial = Trial::new();
    let kept = trial.folder.path().join("room.autosave.ron");
    let file = std::fs::read(trial.folder.path().join("room.ron")).unwrap();
    let from = trial.seen("table");
    trial.drag(from, from + vec2(40.0, 5.0));
    let wait = |trial: &mut Trial, there: bool| {
        for _ in 0..400 {
            trial.frame([]);
            if kept.exists() == there {
                return;
            }
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        panic!("{} is {}there", kept.display(), if there { "not " } else { "" });
    };
    wait(&mut trial, true);
    let kept_scene = Scene::read(&kept).unwrap().0;
    assert_eq!(Configuration::initial(&kept_scene).content_hash(), trial.state().content_hash());
    assert_eq!(std::fs::read(trial.folder.path().join("room.ron")).unwrap(), file, "the scene's file is as it was");
    assert!(matches!(super::dialogs::kept_before(&trial.desk.session.path), Some(Dialog::Kept { .. })));
    // Quitting asks.
    trial.desk.run(Command::Quit);
    assert!(
        trial.desk.requests.is_empty()
            && matches!(trial.desk.dialog, Some(Dialog::Unsaved(Request::Quit { thrown_away: false })))
    );
    trial.desk.dialog = None;
    trial.desk.run(Command::Save);
    wait(&mut trial, false);
    trial.desk.run(Command::Quit);
    assert_eq!(trial.desk.requests, [Request::Quit { thrown_away: false }]);
}

#[test]
fn what_was_kept_of_an_earlier_run_is_not_written_over_unasked() {
    let earlier = |folder: &Path| folder.join("room.autosave.ron");
    let mut trial = Trial::after(|folder| {
        let text = std::fs::read_to_string(folder.join("room.ron")).unwrap();
        std::fs::write(earlier(folder), text.replace("position: (1.9, 3.0, 0.0)", "position: (2.5, 3.0, 0.0)")).unwrap();
    });
    let path = trial.folder.path().join("room.ron");
    let kept = std::fs::read(earlier(trial.folder.path())).unwrap();
    trial.desk.dialog = super::dialogs::kept_before(&path);
    assert!(matches!(trial.desk.dialog, Some(Dialog::Kept { .. })));
    // A script plays behind the question.
    let script = trial.folder.path().join("moves/table.ron");
    trial.desk.session.play(&script).unwrap();
    for _ in 0..60 {
        trial.frame([]);
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    trial.key(Key::Escape, Modifiers::NONE);
    trial.key(Key::Q, Modifiers::COMMAND);
    assert!(matches!(trial.desk.dialog, Some(Dialog::Kept { .. })), "it needs an answer");
    assert!(trial.desk.session.is_changed() && std::fs::read(earlier(trial.folder.path())).unwrap() == kept);
    // Ctrl-C: what is new is kept beside it.
    let beside = trial.desk.session.keep().unwrap();
    assert!(beside != earlier(trial.folder.path()) && Scene::read(&beside).is_ok());
    assert!(std::fs::read(earlier(trial.folder.path())).unwrap() == kept);
}

#[test]
fn scripts_that_change_a_thing_twice_are_undone_to_the_bit() {
    let mut trial = Trial::new();
    let script = trial.folder.path().join("twice.ron");
    let text = r#"(edits: [
        (at: 0.0, edit: Relamp(lamp: "pendant", photometry: "ies/washer.ies", intensity: (2.0, 2.0, 2.0))),
        (at: 0.01, edit: Relamp(lamp: "pendant", photometry: "ies/reading.ies")),
        (at: 0.02, edit: Paint(object: "table")),
        (at: 0.03, edit: Paint(object: "table", material: "pine")),
        (at: 0.04, edit: Light(lamp: "washer", intensity: (1.0, 0.0, 0.0))),
        (at: 0.05, edit: Light(lamp: "washer", intensity: (0.0, 1.0, 0.0))),
    ])"#;
    std::fs::write(&script, text).unwrap();
    let before = trial.state();
    trial.desk.session.play(&script).unwrap();
    for _ in 0..10 {
        trial.frame([]);
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let after = trial.state();
    assert!(trial.desk.session.playback.is_none() && after != before);
    assert!(trial.replayed() == after);
    trial.desk.session.undo();
    assert!(trial.state() == before);
}

#[test]
fn questions_cannot_be_got_round() {
    let mut trial = Trial::new();
    let table = trial.seen("table");
    trial.click(table);
    trial.desk.run(Command::Help);
    trial.frame([]);
    let before = trial.state();
    let wheel = Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: vec2(0.0, 1.0),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    };
    trial.frame([wheel]);
    assert!(trial.state() == before, "the help is scrolled, the table is not turned");
    trial.desk.dialog = None;
    trial.frame([]);
    // What is kept by itself is no place to save to.
    let kept = trial.folder.path().join("room.autosave.ron");
    assert!(trial.desk.session.save(&kept).is_err() && !kept.exists());
    // Another scene in the middle of a drag: what was held goes with the old one.
    trial.press(table, PointerButton::Primary);
    trial.point(table + vec2(30.0, 0.0));
    let path = trial.folder.path().join("room.ron");
    let other = Session::start(Scene::read(&path).unwrap().0, path, start(), || {}).unwrap();
    trial.desk.take(other);
    trial.point(table + vec2(60.0, 0.0));
    trial.release(table, PointerButton::Primary);
    assert!(!trial.desk.session.is_changed() && trial.desk.session.selection.is_none());
}

#[test]
fn a_cancelled_drag_leaves_what_could_be_done_again() {
    let mut trial = Trial::new();
    let from = trial.seen("table");
    trial.drag(from, from + vec2(40.0, 5.0));
    let moved = trial.state();
    trial.key(Key::Z, Modifiers::COMMAND);
    trial.press(from, PointerButton::Primary);
    trial.point(from + vec2(-30.0, 0.0));
    trial.key(Key::Escape, Modifiers::NONE);
    trial.key(Key::Z, Modifiers::COMMAND | Modifiers::SHIFT);
    assert!(trial.state() == moved);
}

#[test]
fn a_script_plays_to_the_same_scene() {
    let mut trial = Trial::new();
    let script: PathBuf = trial.folder.path().join("moves/all.ron");
    let (moves, _) = Moves::read(&script, &trial.desk.session.scene).unwrap();
    let mut wanted = trial.state();
    for timed in &moves.edits {
        wanted = wanted.apply(&timed.edit).unwrap();
    }
    let before = trial.state();
    trial.desk.session.play(&script).unwrap();
    for _ in 0..20_000 {
        trial.frame([]);
        if trial.desk.session.playback.is_none() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    assert!(trial.desk.session.playback.is_none() && trial.state() == wanted);
    assert!(trial.replayed() == wanted);
    trial.desk.session.undo();
    assert!(trial.state() == before, "a script is one action: {:?}", trial.desk.session.messages);
}

#[test]
fn typing_does_not_walk() {
    let mut trial = Trial::new();
    let view = trial.desk.session.navigation.view();
    trial.desk.run(Command::Save);
    trial.desk.run(Command::SaveAs);
    trial.frame([]);
    trial.frame([]);
    for key in [Key::W, Key::A, Key::Q, Key::R, Key::Num2] {
        trial.key(key, Modifiers::NONE);
    }
    assert_eq!(trial.desk.session.navigation.view(), view);
    trial.desk.dialog = None;
    trial.frame([]);
    trial.key(Key::W, Modifiers::NONE);
    assert_ne!(trial.desk.session.navigation.view(), view, "and without a text it does");
    trial.key(Key::Num1, Modifiers::NONE);
    assert_eq!(trial.desk.session.navigation.view(), trial.desk.session.scene.cameras[0].1);
}
