//! The part of the window that shows the room: what mouse and keys do there.
//!
//! Events are taken one by one, in order. A press belongs to the room only if nothing else of the window lies there; from then on all
//! moves belong to it until the same button is released, wherever that is. Other buttons do nothing meanwhile.

use super::{
    navigation::axes,
    pick::{self, Sight, meet},
    placement::{self, Grip, Way},
    session::{Selection, Session},
};
use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, Rect};
use glam::{DVec2, DVec3};
use lightmend_raster::camera::Camera;
use lightmend_scene::Edit;

/// Moves of less than this are a click, points.
const CLICK: f32 = 3.0;

/// Turns of the head per point, radians, at a vertical view of 60 degrees.
const LOOK: f64 = 0.004;

/// How near to a lamp's mark a press means the lamp, points.
const MARK: f32 = 11.0;

/// A lamp that is hidden by something farther in front of it than this cannot be clicked, metres: shades hide lamps, walls do too.
const SHADE: f64 = 0.5;

enum Doing {
    /// Pressed, and not moved yet.
    Nothing,
    Look,
    Orbit(DVec3),
    Pan,
    Object(Box<Grip>),
    /// A lamp, and where in the world the point is that the pointer holds it by.
    Lamp {
        id: usize,
        held: DVec3,
    },
}

struct Gesture {
    button: PointerButton,
    pressed: Pos2,
    last: Pos2,
    modifiers: Modifiers,
    doing: Doing,
}

/// Where a lamp is in the window.
pub struct Mark {
    pub lamp: usize,
    pub at: Pos2,
    /// Whether it can be clicked.
    pub near: bool,
}

/// The room's part of the window.
pub struct Viewport {
    /// Points.
    pub rect: Rect,
    gesture: Option<Gesture>,
    /// Notches of the wheel that are not used up yet.
    notches: f32,
    /// What the pointer is over.
    pub hovered: Option<Selection>,
    /// Where it was last.
    pointer: Option<Pos2>,
}

impl Default for Viewport {
    fn default() -> Viewport {
        Viewport { rect: Rect::NOTHING, gesture: None, notches: 0.0, hovered: None, pointer: None }
    }
}

impl Viewport {
    /// The camera of the picture in it; `None` if it has no size.
    pub fn camera(&self, session: &Session) -> Option<Camera> {
        let size = self.rect.size();
        let aspect = f64::from(size.x) / f64::from(size.y);
        let view = session.navigation.view();
        (size.x >= 1.0 && size.y >= 1.0).then(|| Camera::new(&view, session.scene.up, aspect, session.configuration.reach()))
    }

    /// The line of sight through a point of the window.
    fn sight(&self, session: &Session, at: Pos2) -> Option<Sight> {
        let camera = self.camera(session)?;
        let share = (at - self.rect.center()) / (self.rect.size() / 2.0);
        Some(Sight::new(&camera, DVec2::new(f64::from(share.x), f64::from(-share.y))))
    }

    /// Whether the person is in the middle of something with the mouse.
    pub fn is_busy(&self) -> bool {
        self.gesture.is_some()
    }

    /// Lamps in the picture, as they can be clicked.
    pub fn marks(&self, session: &mut Session) -> Vec<Mark> {
        let Some(camera) = self.camera(session) else { return Vec::new() };
        let world = if self.is_busy() { session.recent_world() } else { session.world() };
        let lamps = session.configuration.lamps();
        let marks = lamps.filter_map(|(lamp, _)| {
            let position = session.configuration.lamp_motion(lamp).translation;
            let at = camera.project(position)?;
            let way = position - camera.eye;
            let distance = way.length();
            let sight = Sight { from: camera.eye, along: way / distance };
            let met = meet(&world, sight, |id| world.object(id).hidden_from_camera);
            let near = met.is_none_or(|met| met.distance > distance - SHADE);
            let half = self.rect.size() / 2.0;
            let at = self.rect.center() + egui::vec2(at.x as f32 * half.x, -at.y as f32 * half.y);
            self.rect.contains(at).then_some(Mark { lamp, at, near })
        });
        marks.collect()
    }

    /// What is under a point of the window, and where.
    pub fn under(&self, session: &mut Session, at: Pos2) -> Option<(Selection, DVec3)> {
        let marks = self.marks(session);
        let near = marks.iter().filter(|mark| mark.near && mark.at.distance(at) < MARK);
        if let Some(mark) = near.min_by(|a, b| a.at.distance(at).total_cmp(&b.at.distance(at))) {
            return Some((Selection::Lamp(mark.lamp), session.configuration.lamp_motion(mark.lamp).translation));
        }
        let sight = self.sight(session, at)?;
        let world = session.world();
        let met = meet(&world, sight, |id| world.object(id).hidden_from_camera)?;
        Some((Selection::Object(pick::meant(&session.configuration, met.object)), met.point))
    }

    /// Takes what the mouse did since the last frame. `free` says whether nothing else of the window lies at a point.
    pub fn take(&mut self, session: &mut Session, events: &[Event], free: &dyn Fn(Pos2) -> bool) {
        let mut moved_to: Option<(Pos2, Modifiers)> = None;
        for event in events {
            // Of moves in a row only the last counts: that is where the pointer is when this frame is shown.
            if let Event::PointerMoved(at) = event {
                moved_to = Some((*at, moved_to.map_or(self.gesture.as_ref().map_or(Modifiers::NONE, |g| g.modifiers), |m| m.1)));
                continue;
            }
            if let Some((at, modifiers)) = moved_to.take() {
                self.moved(session, at, modifiers);
            }
            match event {
                Event::PointerButton { pos, button, pressed: true, modifiers } => {
                    if self.gesture.is_none() && self.rect.contains(*pos) && free(*pos) {
                        self.pressed(session, *pos, *button, *modifiers);
                    } else if *button == PointerButton::Secondary {
                        self.put_back(session);
                    }
                }
                Event::PointerButton { pos, button, pressed: false, .. }
                    if self.gesture.as_ref().is_some_and(|g| g.button == *button) =>
                {
                    self.released(session, *pos);
                }
                Event::MouseWheel { unit, delta, modifiers, .. } => {
                    let lines = if delta.y == 0.0 { delta.x } else { delta.y };
                    let notches = match unit {
                        MouseWheelUnit::Line => lines,
                        MouseWheelUnit::Point => lines / 50.0,
                        MouseWheelUnit::Page => lines * 3.0,
                    };
                    self.wheel(session, notches, *modifiers, free);
                }
                Event::WindowFocused(false) => self.let_go(session),
                _ => {}
            }
        }
        if let Some((at, modifiers)) = moved_to {
            self.moved(session, at, modifiers);
        }
    }

    /// Modifier keys are now these: they change what a drag does.
    pub fn hold(&mut self, modifiers: Modifiers) {
        if let Some(gesture) = &mut self.gesture {
            gesture.modifiers = modifiers;
        }
    }

    fn pressed(&mut self, session: &mut Session, at: Pos2, button: PointerButton, modifiers: Modifiers) {
        self.hovered = self.under(session, at).map(|(selection, _)| selection);
        self.gesture = Some(Gesture { button, pressed: at, last: at, modifiers, doing: Doing::Nothing });
        self.notches = 0.0;
    }

    /// The first move after a press decides what it is.
    fn begin(&mut self, session: &mut Session, button: PointerButton, at: Pos2, modifiers: Modifiers) -> Doing {
        let under = self.under(session, at);
        match (button, under) {
            (PointerButton::Middle, _) if modifiers.shift => Doing::Pan,
            (PointerButton::Middle, under) => Doing::Orbit(self.orbited(session, under.map(|u| u.1))),
            (PointerButton::Primary, under) if modifiers.alt => Doing::Orbit(self.orbited(session, under.map(|u| u.1))),
            (PointerButton::Primary, Some((selection @ Selection::Lamp(id), held))) => {
                session.stop_playing();
                session.selection = Some(selection);
                Doing::Lamp { id, held }
            }
            (PointerButton::Primary, Some((selection @ Selection::Object(id), held)))
                if session.configuration.object(id).movable =>
            {
                session.stop_playing();
                session.selection = Some(selection);
                if session.snapping {
                    let title = move_title(session, id);
                    for edit in placement::gather_riders(&session.world(), id) {
                        session.go_on(&title, edit);
                    }
                }
                Doing::Object(Box::new(Grip::new(&session.world(), id, held)))
            }
            _ => Doing::Look,
        }
    }

    /// What an orbit goes round: what is selected, or what is under the pointer, or what the camera looks at.
    fn orbited(&self, session: &Session, under: Option<DVec3>) -> DVec3 {
        match session.selection {
            Some(Selection::Object(id)) => {
                let [low, high] = pick::bounds(&session.configuration, id);
                (low + high) / 2.0
            }
            Some(Selection::Lamp(id)) => session.configuration.lamp_motion(id).translation,
            None => under.unwrap_or(session.navigation.view().target),
        }
    }

    fn moved(&mut self, session: &mut Session, at: Pos2, modifiers: Modifiers) {
        let Some(mut gesture) = self.gesture.take() else { return };
        if matches!(gesture.doing, Doing::Nothing) {
            if gesture.pressed.distance(at) < CLICK {
                self.gesture = Some(gesture);
                return;
            }
            gesture.doing = self.begin(session, gesture.button, gesture.pressed, modifiers);
        }
        let step = at - gesture.last;
        let (dx, dy) = (f64::from(step.x), f64::from(step.y));
        let fov = session.navigation.view().fov;
        match &mut gesture.doing {
            Doing::Nothing => {}
            Doing::Look => session.navigation.look(-dx * LOOK * fov / 60.0, -dy * LOOK * fov / 60.0),
            Doing::Orbit(centre) => session.navigation.orbit(*centre, dx * 2.0 * LOOK, -dy * 2.0 * LOOK),
            Doing::Pan => {
                let height = f64::from(self.rect.height().max(1.0));
                session.navigation.pan(-dx / height, dy / height);
            }
            Doing::Object(grip) => {
                let way = match (modifiers.shift, modifiers.command || !session.snapping) {
                    (true, _) => Way::Height,
                    (false, true) => Way::Free,
                    (false, false) => Way::Snapping,
                };
                if let Some(sight) = self.sight(session, at) {
                    let to = grip.follow(sight, way);
                    session.drag(grip.object, to);
                }
            }
            Doing::Lamp { id, held } => {
                let up = axes(session.scene.up)[2];
                if let Some(sight) = self.sight(session, at) {
                    let across = (sight.along - up * sight.along.dot(up)).normalize_or(axes(session.scene.up)[0]);
                    let normal = if modifiers.shift { across } else { up };
                    let step = sight.on_plane(*held, normal).map(|point| point - *held);
                    let step = step.map(|step| if modifiers.shift { up * step.dot(up) } else { step - up * step.dot(up) });
                    let far = session.configuration.reach() * 10.0;
                    if let Some(step) = step.filter(|step| step.length() < far) {
                        *held += step;
                        move_lamp(session, *id, step);
                    }
                }
            }
        }
        gesture.last = at;
        self.gesture = Some(gesture);
    }

    fn released(&mut self, session: &mut Session, at: Pos2) {
        // Where it is released is where it goes, also if no move told of it.
        let modifiers = self.gesture.as_ref().map_or(Modifiers::NONE, |g| g.modifiers);
        self.moved(session, at, modifiers);
        if let Some(gesture) = &self.gesture
            && matches!(gesture.doing, Doing::Nothing)
            && gesture.button == PointerButton::Primary
        {
            session.selection = self.under(session, gesture.pressed).map(|(selection, _)| selection);
        }
        self.let_go(session);
    }

    /// The gesture is over, wherever it is.
    pub fn let_go(&mut self, session: &mut Session) {
        let Some(gesture) = self.gesture.take() else { return };
        if let Doing::Object(grip) = &gesture.doing
            && session.snapping
            && !gesture.modifiers.command
            && session.configuration.has_object(grip.object)
            && let Some(on) = grip.stands_on()
        {
            // On furniture it rides; on the floor nothing carries it.
            let carrier = session.configuration.object(on).dynamic.then_some(on);
            if let Some(edit) = placement::ride(&session.configuration, grip.object, carrier) {
                session.go_on(&move_title(session, grip.object), edit);
            }
        }
        if matches!(gesture.doing, Doing::Object(_) | Doing::Lamp { .. }) {
            session.end();
        }
    }

    /// The gesture is over, and what it moved is back where it was. Whether there was one.
    pub fn put_back(&mut self, session: &mut Session) -> bool {
        let gesture = self.gesture.take();
        if gesture.as_ref().is_some_and(|g| matches!(g.doing, Doing::Object(_) | Doing::Lamp { .. })) {
            session.cancel();
        }
        gesture.is_some()
    }

    fn wheel(&mut self, session: &mut Session, notches: f32, modifiers: Modifiers, free: &dyn Fn(Pos2) -> bool) {
        let over = self.hovered.filter(|_| self.gesture.is_none());
        let held = self.gesture.as_ref().and_then(|g| match &g.doing {
            Doing::Object(grip) => Some(grip.object),
            _ => None,
        });
        let selected = match session.selection {
            Some(Selection::Object(id)) if over == session.selection && self.over_room(free) => Some(id),
            _ => None,
        };
        if let Some(id) = held.or(selected).filter(|id| session.configuration.object(*id).movable) {
            self.notches += notches;
            let whole = self.notches.trunc();
            self.notches -= whole;
            if whole != 0.0 {
                turn(session, id, f64::from(whole) * if modifiers.shift { 1.0 } else { 15.0 }, held.is_some());
                if let Some(Gesture { doing: Doing::Object(grip), .. }) = &mut self.gesture {
                    grip.turned(&session.configuration);
                }
            }
        } else if self.gesture.is_none() && self.over_room(free) {
            session.navigation.dolly(f64::from(notches) * session.navigation.speed * 0.2);
        }
    }

    /// Whether the pointer was last seen over the room.
    fn over_room(&self, free: &dyn Fn(Pos2) -> bool) -> bool {
        self.pointer.is_some_and(|at| self.rect.contains(at) && free(at))
    }

    /// Where the pointer is, for what is under it while no button is pressed.
    pub fn hover(&mut self, session: &mut Session, pointer: Option<Pos2>, free: &dyn Fn(Pos2) -> bool) {
        if self.gesture.is_none() && pointer != self.pointer {
            self.hovered =
                pointer.filter(|at| self.rect.contains(*at) && free(*at)).and_then(|at| self.under(session, at)).map(|u| u.0);
        }
        self.pointer = pointer;
    }

    /// Keys that are held: walking, for `seconds`. Whether one walked.
    pub fn walk(&self, session: &mut Session, down: &dyn Fn(Key) -> bool, fast: bool, seconds: f64) -> bool {
        let along = |forwards: Key, back: Key| f64::from(u8::from(down(forwards))) - f64::from(u8::from(down(back)));
        let way = DVec3::new(along(Key::W, Key::S), along(Key::D, Key::A), along(Key::E, Key::Q));
        if way == DVec3::ZERO {
            return false;
        }
        let metres = session.navigation.speed * seconds * if fast { 3.0 } else { 1.0 };
        let step = way.normalize() * metres;
        session.navigation.walk(step.x, step.y, step.z);
        true
    }
}

/// What moving an object is called in the history.
fn move_title(session: &Session, id: usize) -> String {
    format!("Move {}", session.configuration.object(id).name)
}

/// Moves a lamp by a step in the world, metres.
pub fn move_lamp(session: &mut Session, id: usize, step: DVec3) {
    let lamp = session.configuration.lamp(id);
    let carrier = pick::carrier_motion(&session.configuration, lamp.carrier);
    let to = lamp.pose.position + carrier.rotation.transpose() * step;
    let name = lamp.name.clone();
    session.go_on(&format!("Move lamp {name}"), Edit::MoveLamp { lamp: name, to });
}

/// Turns an object about the world's up axis, degrees; as a part of what goes on, or as an action of its own.
pub fn turn(session: &mut Session, id: usize, by: f64, within: bool) {
    let object = session.configuration.object(id);
    let carrier = pick::carrier_motion(&session.configuration, object.carrier);
    let to = placement::turned(object.pose.rotation, &carrier, session.scene.up, by);
    let name = object.name.clone();
    let title = if within { move_title(session, id) } else { format!("Turn {name}") };
    session.go_on(&title, Edit::Turn { object: name, to });
}

/// Moves an object by a step in the world, metres, as a part of what goes on.
pub fn nudge(session: &mut Session, id: usize, step: DVec3) {
    let at = session.configuration.object_motion(id).translation + step;
    session.drag(id, at);
}
