//! The plan: four rooms in a box of 10 × 8 × 2.7 m, three interior walls of 12 cm, three doorways.
//!
//! The living room (south-west) has a lamp on its ceiling, the bedroom (north-west) a lamp that can be carried. The kitchen
//! (south-east) is lit through its doorway; the storage room (north-east) opens onto the kitchen only, from where no lamp is
//! seen, so light comes to it after a diffuse reflection in the kitchen at the earliest.

use glam::DVec3;

use crate::solid::v;

/// Length, width and height, metres.
pub const SIZE: [f64; 3] = [10.0, 8.0, 2.7];

/// The wall between west and east, from x to x, metres.
pub const WALL_MIDDLE: [f64; 2] = [6.2, 6.32];

/// The wall between living room and bedroom, from y to y, metres.
pub const WALL_WEST: [f64; 2] = [4.4, 4.52];

/// The wall between kitchen and storage room, from y to y, metres.
pub const WALL_EAST: [f64; 2] = [4.9, 5.02];

/// A room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Room {
    /// South-west: dining table and sofa.
    Living,
    /// South-east: kitchen with a desk.
    Kitchen,
    /// North-west.
    Bedroom,
    /// North-east, unlit.
    Storage,
}

impl Room {
    /// All rooms.
    pub const ALL: [Room; 4] = [Room::Living, Room::Kitchen, Room::Bedroom, Room::Storage];

    /// The room in which a point is; interior walls belong half to each side.
    pub fn at(p: DVec3) -> Self {
        let beyond = |wall: [f64; 2], a: f64| a > (wall[0] + wall[1]) / 2.0;
        match beyond(WALL_MIDDLE, p.x) {
            false if beyond(WALL_WEST, p.y) => Room::Bedroom,
            false => Room::Living,
            true if beyond(WALL_EAST, p.y) => Room::Storage,
            true => Room::Kitchen,
        }
    }

    /// Its name in the scene file.
    pub fn name(self) -> &'static str {
        match self {
            Room::Living => "living room",
            Room::Kitchen => "kitchen",
            Room::Bedroom => "bedroom",
            Room::Storage => "storage",
        }
    }

    /// Its corners on the floor, metres: least and greatest x, least and greatest y.
    pub fn bounds(self) -> [[f64; 2]; 2] {
        let west = [0.0, WALL_MIDDLE[0]];
        let east = [WALL_MIDDLE[1], SIZE[0]];
        match self {
            Room::Living => [west, [0.0, WALL_WEST[0]]],
            Room::Bedroom => [west, [WALL_WEST[1], SIZE[1]]],
            Room::Kitchen => [east, [0.0, WALL_EAST[0]]],
            Room::Storage => [east, [WALL_EAST[1], SIZE[1]]],
        }
    }

    /// The material of one of its sides.
    pub fn paint(self, side: &str) -> &'static str {
        match (self, side) {
            (Room::Kitchen, "floor") => "floor tiles",
            (Room::Storage, "floor") => "screed",
            (_, "floor") => "floorboards",
            (_, "ceiling") => "ceiling white",
            (Room::Living, "west wall") => "wall sage",
            (Room::Bedroom, "west wall") => "wall blue",
            _ => "wall white",
        }
    }
}

/// A doorway with its leaf. The leaf's hinge is its origin; closed, the leaf lies flush with the side that it opens towards.
#[derive(Clone, Copy, Debug)]
pub struct Doorway {
    /// Name of the leaf.
    pub name: &'static str,
    /// The hinge on the floor, metres.
    pub hinge: [f64; 2],
    /// Degrees about z of the closed leaf: 0 lies along +y and opens towards +x, 90 lies along −x and opens towards +y.
    pub closed: f64,
    /// Degrees by which it stands open at the start.
    pub ajar: f64,
}

/// All doorways.
pub const DOORWAYS: [Doorway; 3] = [
    Doorway { name: "kitchen door", hinge: [WALL_MIDDLE[1], 2.65], closed: 0.0, ajar: 84.0 },
    Doorway { name: "bedroom door", hinge: [5.75, WALL_WEST[1]], closed: 90.0, ajar: 84.0 },
    Doorway { name: "storage door", hinge: [8.85, WALL_EAST[1]], closed: 90.0, ajar: 86.0 },
];

impl Doorway {
    /// The axis, 0 or 1, that its wall runs along.
    pub fn along(&self) -> usize {
        if self.closed == 0.0 { 1 } else { 0 }
    }

    /// The hole in the wall, least and greatest corner, metres: 90 cm wide, 2.06 m high, from below the floor.
    pub fn opening(&self) -> [DVec3; 2] {
        let [x, y] = self.hinge;
        // Leaf, gap and lining: 5 cm beyond the hinge and beyond the edge of the leaf of 80 cm.
        let round = |a: f64| (a * 100.0).round() / 100.0;
        match self.along() {
            1 => [v(round(x - 0.12), round(y - 0.05), -1.0), v(x, round(y + 0.85), 2.06)],
            _ => [v(round(x - 0.85), round(y - 0.12), -1.0), v(round(x + 0.05), y, 2.06)],
        }
    }
}
