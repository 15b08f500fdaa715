//! Where furniture goes when it is dragged: along the surface it stands on, against walls, down from an edge, onto a table.
//!
//! What is held keeps its height and follows the pointer in a horizontal plane. With snapping, what is fixed stops it and draws it flush
//! when it is near; where nothing is under it any more it falls to what is; and small things follow the pointer onto whatever is level.
//! Without, it goes wherever the pointer goes, through everything.

use super::{
    navigation::axes,
    pick::{self, Sight, bounds, meet},
};
use glam::{DMat3, DVec3};
use lightmend_photon::world::World;
use lightmend_scene::{Configuration, Edit, Motion, Pose, Up};

/// Nearer than this to a wall, an object is drawn flush to it, metres.
const NEAR: f64 = 0.06;

/// Air left between an object and a wall, so that no surfaces lie in one another, metres.
const AIR: f64 = 0.001;

/// Differences of height that count as level: rugs, thresholds; metres.
const STEP: f64 = 0.02;

/// Things up to this size along each axis follow the pointer onto tables and shelves; metres.
const SMALL: f64 = 0.6;

/// How a held object follows the pointer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// On what it stands on, against walls.
    Snapping,
    /// In a horizontal plane, through everything.
    Free,
    /// Up and down.
    Height,
}

/// An object that the pointer holds.
pub struct Grip {
    /// Its number.
    pub object: usize,
    /// All but it and what rides on it.
    others: World,
    up: [DVec3; 3],
    /// From the point held to the object's origin.
    held: DVec3,
    /// Box about it, from its origin.
    low: DVec3,
    high: DVec3,
    /// Where its origin is.
    at: DVec3,
}

impl Grip {
    /// Holds `object`, which can be moved, at a point of it; metres.
    pub fn new(world: &World, object: usize, point: DVec3) -> Grip {
        let configuration = world.configuration();
        let at = configuration.object_motion(object).translation;
        let [low, high] = bounds(configuration, object);
        let up = axes(configuration.scene().up);
        // Rays that pass by it would miss what it stands on: that lies in the plane of its underside.
        let without = configuration.apply(&Edit::Remove { object: configuration.object(object).name.clone() });
        let others = without.map_or_else(|_| world.clone(), |without| world.moved_to(&without));
        Grip { object, others, up, held: at - point, low: low - at, high: high - at, at }
    }

    /// The object was turned while it is held.
    pub fn turned(&mut self, configuration: &Configuration) {
        let [low, high] = bounds(configuration, self.object);
        (self.at, self.low, self.high) = {
            let at = configuration.object_motion(self.object).translation;
            (at, low - at, high - at)
        };
    }

    fn height(&self, point: DVec3) -> f64 {
        point.dot(self.up[2])
    }

    /// Height of the underside when its origin is at `at`.
    fn base(&self, at: DVec3) -> f64 {
        self.height(at) + self.height(self.low.min(self.high))
    }

    fn centre(&self, at: DVec3) -> DVec3 {
        at + (self.low + self.high) / 2.0
    }

    /// `at`, raised or lowered until the underside is at `base`.
    fn resting(&self, at: DVec3, base: f64) -> DVec3 {
        at + self.up[2] * (base - self.base(at))
    }

    /// Where the origin goes, in the world, metres.
    pub fn follow(&mut self, sight: Sight, way: Way) -> DVec3 {
        let up = self.up[2];
        let wanted = match way {
            Way::Height => {
                let across = (sight.along - up * sight.along.dot(up)).try_normalize().unwrap_or(self.up[0]);
                let point = sight.on_plane(self.at - self.held, across);
                point.map(|point| self.at + up * self.height(point + self.held - self.at))
            }
            Way::Free => self.level(sight, 0.0),
            Way::Snapping => self.snapping(sight),
        };
        let reach = f64::from(self.others.reach().metres);
        if let Some(wanted) = wanted.filter(|p| p.is_finite() && p.abs().max_element() < 10.0 * reach + 10.0) {
            self.at = match way {
                // Just above something it is meant to stand on it.
                Way::Height => match self.support(wanted) {
                    Some(level) if (self.base(wanted) - level).abs() < NEAR => self.resting(wanted, level),
                    _ => wanted,
                },
                _ => wanted,
            };
        }
        self.at
    }

    /// The origin where the pointer sees the plane that the held point moves in, lower by `down` metres.
    fn level(&self, sight: Sight, down: f64) -> Option<DVec3> {
        let up = self.up[2];
        let from = self.at - self.held - up * down;
        // Near the horizon a pixel is many metres.
        let point = sight.on_plane(from, up)?;
        let step = point - from;
        Some(self.at - up * down + (step - up * step.dot(up)))
    }

    fn snapping(&self, sight: Sight) -> Option<DVec3> {
        let hidden = |id: usize| self.others.object(id).hidden_from_camera;
        if (self.high - self.low).max_element() <= SMALL {
            // The middle of its underside follows the pointer as the held point does, onto what is level there.
            let foot = self.foot();
            let seen = sight.from + sight.along * (self.at - self.held - sight.from).dot(sight.along).max(0.01);
            let aim = Sight { along: (seen + foot - (self.at - self.held) - sight.from).normalize(), ..sight };
            if let Some(met) = meet(&self.others, aim, hidden)
                && met.normal.dot(self.up[2]) > 0.9
            {
                let at = self.at + (met.point - foot);
                return Some(self.resting(self.against_walls(at), self.height(met.point)));
            }
        }
        let wanted = self.level(sight, 0.0)?;
        let stopped = self.against_walls(wanted);
        match self.support(stopped) {
            Some(level) if level < self.base(stopped) - STEP => {
                // It falls, and follows the pointer down there.
                let below = self.level(sight, self.base(stopped) - level)?;
                let below = self.against_walls(self.resting(below, level));
                let under = self.support(below);
                Some(if under.is_some_and(|under| (under - level).abs() < STEP) { below } else { self.resting(stopped, level) })
            }
            _ => Some(stopped),
        }
    }

    /// The middle of its underside.
    fn foot(&self) -> DVec3 {
        let centre = self.centre(self.at);
        centre + self.up[2] * (self.base(self.at) - self.height(centre))
    }

    /// What is under the middle of it when its origin is at `at`; from a step above its underside on.
    fn under(&self, at: DVec3) -> Option<pick::Met> {
        let up = self.up[2];
        let centre = self.centre(at);
        let from = centre + up * (self.base(at) + STEP - self.height(centre));
        meet(&self.others, Sight { from, along: -up }, |_| false)
    }

    /// Height of what is under the middle of it when its origin is at `at`.
    fn support(&self, at: DVec3) -> Option<f64> {
        self.under(at).map(|met| self.height(met.point))
    }

    /// `at`, but not through what is fixed, and flush where it is near.
    fn against_walls(&self, at: DVec3) -> DVec3 {
        let world = &self.others;
        let movable = |id: usize| world.object(id).dynamic;
        let mut at = at;
        // The middle of it never passes through a wall.
        let way = self.centre(at) - self.centre(self.at);
        let way = way - self.up[2] * way.dot(self.up[2]);
        if let Some(along) = way.try_normalize()
            && let Some(met) = meet(world, Sight { from: self.centre(self.at), along }, movable)
            && met.distance < way.length()
            && met.normal.dot(self.up[2]).abs() < 0.5
        {
            // What would go on behind the wall goes along it.
            let rest = way - along * met.distance;
            let slide = rest - met.normal * rest.dot(met.normal);
            let stop = along * (met.distance - AIR).max(0.0);
            let slid = self.centre(self.at) + stop;
            let free = slide
                .try_normalize()
                .and_then(|along| meet(world, Sight { from: slid, along }, movable))
                .map_or(f64::INFINITY, |met| met.distance - AIR);
            at = at - way + stop + slide.clamp_length_max(free.max(0.0));
        }
        for axis in [self.up[0], self.up[1]] {
            let half = (self.high - self.low).dot(axis).abs() / 2.0;
            let gap = |sign: f64| {
                let met = meet(world, Sight { from: self.centre(at), along: axis * sign }, movable)?;
                // Only what stands across the way is a wall to lean on.
                (met.normal.dot(axis).abs() > 0.95).then_some((met.distance - half, sign))
            };
            let nearest = [gap(1.0), gap(-1.0)].into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((gap, sign)) = nearest.filter(|(gap, _)| *gap < NEAR) {
                at += axis * sign * (gap - AIR);
            }
        }
        at
    }

    /// What it stands on: the object under the middle of it, within a step.
    pub fn stands_on(&self) -> Option<usize> {
        let met = self.under(self.at)?;
        ((self.height(met.point) - self.base(self.at)).abs() <= STEP).then_some(met.object)
    }
}

/// The edit that takes `object` to `at` in the world, metres, on the carrier it has.
pub fn move_to(configuration: &Configuration, object: usize, at: DVec3) -> Edit {
    let carrier = pick::carrier_motion(configuration, configuration.object(object).carrier);
    let to = carrier.rotation.transpose() * (at - carrier.translation);
    Edit::Move { object: configuration.object(object).name.clone(), to }
}

/// The edit that lets `object` ride on `carrier`, or on nothing, without moving it in the world. `None` if it does already.
pub fn ride(configuration: &Configuration, object: usize, carrier: Option<usize>) -> Option<Edit> {
    let thing = configuration.object(object);
    if thing.carrier == carrier || !thing.movable {
        return None;
    }
    let (world, on) = (configuration.object_motion(object), pick::carrier_motion(configuration, carrier));
    let inverse = on.rotation.transpose();
    let local = Motion { rotation: inverse * world.rotation, translation: inverse * (world.translation - on.translation) };
    Some(Edit::Put {
        object: thing.name.clone(),
        on: carrier.map(|id| configuration.object(id).name.clone()),
        to: local.translation,
        rotation: degrees(&local.rotation),
    })
}

/// The edits that let ride on `object` what stands on it and can be moved but rides on nothing yet.
pub fn gather_riders(world: &World, object: usize) -> Vec<Edit> {
    let configuration = world.configuration();
    let loose = configuration.objects().filter(|(id, thing)| *id != object && thing.movable && thing.carrier.is_none());
    let [low, high] = bounds(configuration, object);
    let on_it = loose.filter(|(id, _)| {
        let [bottom, top] = bounds(configuration, *id);
        // Only what is in or just above its box can stand on it.
        let near = bottom.cmple(high + STEP).all() && top.cmpge(low - STEP).all();
        near && Grip::new(world, *id, configuration.object_motion(*id).translation).stands_on() == Some(object)
    });
    on_it.filter_map(|(id, _)| ride(configuration, id, Some(object))).collect()
}

/// Degrees about the fixed x, y and z axes of a rotation; right angles come out exact.
pub fn degrees(rotation: &DMat3) -> DVec3 {
    let [x, y, z] = [rotation.x_axis, rotation.y_axis, rotation.z_axis];
    let sine = (-x.z).clamp(-1.0, 1.0);
    let angles = if sine.abs() > 1.0 - 1e-12 {
        // Looking along z: only the sum of the other two is told.
        DVec3::new(0.0, sine.asin(), (-y.x).atan2(y.y))
    } else {
        DVec3::new(y.z.atan2(z.z), sine.asin(), x.y.atan2(x.x))
    };
    // Rounding leaves specks beside whole degrees.
    let clean = |degrees: f64| {
        let rounded = (degrees * 1e6).round() / 1e6;
        if (degrees - rounded).abs() < 1e-9 { rounded + 0.0 } else { degrees }
    };
    DVec3::from_array(angles.to_array().map(|radians| clean(radians.to_degrees())))
}

/// `rotation` of something on a carrier, turned about the world's up axis by `by` degrees.
pub fn turned(rotation: DVec3, carrier: &Motion, up: Up, by: f64) -> DVec3 {
    let axis = axes(up)[2];
    let level = carrier.rotation.transpose() * axis;
    let wrapped = |degrees: f64| (degrees + 180.0).rem_euclid(360.0) - 180.0;
    if (level - axis).length() < 1e-12 {
        // The last of the three turns is the one about z: it adds up exactly. About y it does while z is not turned.
        match up {
            Up::Z => return DVec3::new(rotation.x, rotation.y, wrapped(rotation.z + by)),
            Up::Y if rotation.z == 0.0 => return DVec3::new(rotation.x, wrapped(rotation.y + by), rotation.z),
            Up::Y => {}
        }
    }
    let own = Pose { position: DVec3::ZERO, rotation }.motion().rotation;
    degrees(&(DMat3::from_axis_angle(level.normalize(), by.to_radians()) * own))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lightmend_photon::body::TreePreset;
    use lightmend_scene::Scene;
    use std::path::Path;

    fn room() -> (Configuration, World) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/room/room.ron");
        let configuration = Configuration::initial(&Scene::read(&path).unwrap().0);
        let world = World::new(&configuration, TreePreset::default());
        (configuration, world)
    }

    /// From above and a little aside, onto a point.
    fn onto(point: DVec3) -> Sight {
        let from = point + DVec3::new(0.3, -0.2, 1.4);
        Sight { from, along: (point - from).normalize() }
    }

    fn hold(world: &World, name: &str) -> (Grip, DVec3) {
        let configuration = world.configuration();
        let id = configuration.object_id(name).unwrap();
        let [low, high] = bounds(configuration, id);
        let point = DVec3::new((low.x + high.x) / 2.0, (low.y + high.y) / 2.0, high.z);
        (Grip::new(world, id, point), point)
    }

    #[test]
    fn the_table_follows_the_pointer_on_the_floor() {
        let (configuration, world) = room();
        let (mut grip, point) = hold(&world, "table");
        let before = configuration.object_motion(grip.object).translation;
        let step = DVec3::new(0.3, 0.2, 0.0);
        for way in [Way::Snapping, Way::Free] {
            let at = grip.follow(onto(point + step), way);
            assert!((at - before - step).length() < 1e-5, "{way:?}: {at}");
        }
    }

    #[test]
    fn walls_stop_it_and_draw_it_flush() {
        let (configuration, world) = room();
        let (mut grip, point) = hold(&world, "table");
        let free = |along: DVec3| {
            meet(&world, Sight { from: point + DVec3::Z * 0.2, along }, |id| world.object(id).dynamic).unwrap().distance
        };
        let (wall, half) = (free(DVec3::NEG_Y), (grip.high - grip.low).y / 2.0);
        for beyond in [wall - half - 0.04, wall - half + 0.1, wall + 0.5] {
            let at = grip.follow(onto(point + DVec3::NEG_Y * beyond), Way::Snapping);
            let gap = wall - half - (configuration.object_motion(grip.object).translation - at).y;
            assert!((gap - AIR).abs() < 2e-3 || gap > 0.0 && gap < 0.05, "{beyond}: {gap}");
        }
        let at = grip.follow(onto(point + DVec3::NEG_Y * (wall + 0.5)), Way::Free);
        assert!((configuration.object_motion(grip.object).translation - at).y > wall, "free goes through");
    }

    #[test]
    fn a_cup_falls_from_the_edge_and_climbs_back() {
        let (configuration, world) = room();
        let cup = configuration.objects().find(|(_, o)| o.name.contains("cup") && o.movable).unwrap().0;
        let name = configuration.object(cup).name.clone();
        let (mut grip, point) = hold(&world, &name);
        let table = grip.stands_on().unwrap();
        let level = grip.base(grip.at);
        // The middle of the floor that nothing stands on.
        let clear = (0..40).flat_map(|i| (0..40).map(move |j| DVec3::new(0.1 * f64::from(i), 0.1 * f64::from(j), 1.2)));
        let floor = clear
            .filter_map(|from| meet(&world, Sight { from, along: DVec3::NEG_Z }, |_| false))
            .find(|met| world.object(met.object).name == "floor" && (met.point - point).truncate().length() > 1.0)
            .unwrap();
        let height = point.z - level;
        let at = grip.follow(onto(floor.point + DVec3::Z * height), Way::Snapping);
        assert!((grip.base(at) - floor.point.z).abs() < 1e-4, "on the floor: {}", grip.base(at));
        assert_ne!(grip.stands_on(), Some(table));
        let at = grip.follow(onto(point), Way::Snapping);
        assert!((grip.base(at) - level).abs() < 1e-4, "back on the table: {}", grip.base(at));
        assert_eq!(grip.stands_on(), Some(table));
        let at = grip.follow(onto(point + DVec3::Z * 0.3), Way::Height);
        assert!(grip.base(at) > level + 0.2, "lifted: {}", grip.base(at) - level);
    }

    #[test]
    fn angles_come_back() {
        let rotation = |d: DVec3| Pose { position: DVec3::ZERO, rotation: d }.motion().rotation;
        for d in [
            DVec3::ZERO,
            DVec3::new(10.0, 20.0, 30.0),
            DVec3::new(-170.0, 60.0, 179.0),
            DVec3::new(0.0, 90.0, 40.0),
            DVec3::new(90.0, -90.0, 15.0),
        ] {
            let back = rotation(degrees(&rotation(d)));
            assert!(
                (back.x_axis - rotation(d).x_axis).length() < 1e-9 && (back.y_axis - rotation(d).y_axis).length() < 1e-9,
                "{d}"
            );
        }
        let level = Motion { rotation: DMat3::IDENTITY, translation: DVec3::ZERO };
        let mut turn = DVec3::ZERO;
        for _ in 0..24 {
            turn = turned(turn, &level, Up::Z, 15.0);
        }
        assert_eq!(turn, DVec3::ZERO, "once round is home to the bit");
        let tilted = Motion { rotation: rotation(DVec3::new(30.0, 0.0, 0.0)), translation: DVec3::ZERO };
        for (up, axis) in [(Up::Z, DVec3::Z), (Up::Y, DVec3::Y)] {
            let start = DVec3::new(5.0, 10.0, 20.0);
            let by = DMat3::from_axis_angle(axis, 25f64.to_radians());
            let (world, now) = (tilted.rotation * rotation(start), tilted.rotation * rotation(turned(start, &tilted, up, 25.0)));
            assert!(((by * world).x_axis - now.x_axis).length() < 1e-9);
        }
    }

    #[test]
    fn what_stands_on_a_table_rides_along() {
        let (configuration, _) = room();
        let table = configuration.object_id("table").unwrap();
        let rider = configuration.objects().find(|(_, o)| o.carrier == Some(table) && o.movable).unwrap().0;
        let off = ride(&configuration, rider, None).unwrap();
        let loose = configuration.apply(&off).unwrap();
        let apart =
            |a: Motion, b: Motion| (a.translation - b.translation).length() + (a.rotation.x_axis - b.rotation.x_axis).length();
        assert!(apart(configuration.object_motion(rider), loose.object_motion(rider)) < 1e-9, "it stays where it is");
        let world = World::new(&loose, TreePreset::default());
        let edits = gather_riders(&world, table);
        assert!(
            edits.iter().any(
                |e| matches!(e, Edit::Put { object, on: Some(on), .. } if *on == "table" && *object == loose.object(rider).name)
            ),
            "{edits:?}"
        );
        assert!(ride(&configuration, rider, Some(table)).is_none());
    }
}
