//! The points that are measured: one thing grows, the rest stays.

/// What grows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Grown {
    /// Photons of the pool.
    Pool,
    /// Mesh elements, by their longest edge, metres.
    Elements(f64),
    /// Triangles: each cut into the square of this number.
    Triangles(u32),
    /// How many of the hall's thousand chairs are movable.
    Movables(usize),
}

/// One measurement, in a process of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// `room`, `house` or `hall`.
    pub scene: &'static str,
    /// What grows, and how far.
    pub grown: Grown,
    /// The pool.
    pub photons: u64,
}

/// Photons where something else than the pool grows.
const PHOTONS: u64 = 1_152_000;

/// Pools, photons.
const POOLS: [u64; 4] = [PHOTONS, 4_000_000, 20_000_000, 100_000_000];

/// Longest edges of elements that make 12 k, 378 k and 3 M of them, metres.
const ROOM_CELLS: [f64; 3] = [0.53, 0.0697, 0.02368];
const HOUSE_CELLS: [f64; 2] = [0.118, 0.0364];

impl Point {
    /// All, cheap ones first along each axis.
    pub fn all() -> Vec<Point> {
        let point = |scene, grown, photons| Point { scene, grown, photons };
        let pools = POOLS.iter().flat_map(|n| ["room", "house"].map(|scene| point(scene, Grown::Pool, *n)));
        let room = ROOM_CELLS.iter().map(|cell| point("room", Grown::Elements(*cell), PHOTONS));
        let house = HOUSE_CELLS.iter().map(|cell| point("house", Grown::Elements(*cell), PHOTONS));
        let triangles = [1, 6, 17].map(|n| point("room", Grown::Triangles(n), PHOTONS));
        let movables = [0, 10, 100, 1000].map(|n| point("hall", Grown::Movables(n), PHOTONS));
        pools.chain(room).chain(house).chain(triangles).chain(movables).collect()
    }

    /// The axis, as the table calls it.
    pub fn axis(&self) -> &'static str {
        match self.grown {
            Grown::Pool => "pool",
            Grown::Elements(_) => "elements",
            Grown::Triangles(_) => "triangles",
            Grown::Movables(_) => "movables",
        }
    }

    /// Its name, without blanks.
    pub fn name(&self) -> String {
        let value = match self.grown {
            Grown::Pool => self.photons.to_string(),
            Grown::Elements(cell) => cell.to_string(),
            Grown::Triangles(n) => n.to_string(),
            Grown::Movables(n) => n.to_string(),
        };
        format!("{}_{}_{value}", self.axis(), self.scene)
    }
}
