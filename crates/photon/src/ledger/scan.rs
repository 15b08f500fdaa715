//! Which recorded paths an edit may have made wrong: a plain stream over all points.
//!
//! A path changes only if it meets a changed object where that stood (its hits tell), if something stands in its way now (its segments
//! against the boxes of what moved), or if its lamp changed. Boxes are larger than what they hold by all that storing and stepping
//! back can shift a segment, so no photon is missed; some are suspected for nothing, and replaying them clears them.
//! A segment meets a box unless one of thirteen axes parts them (Gottschalk, Lin, Manocha 1996): for a segment six are left.

use super::{
    chunk::{Chunk, PHOTONS},
    grid::{Cuboid, Grid, OUTSIDE},
    numbers::{ESCAPED, Numbers},
};
use crate::world::{Crowd, Difference, World};
use std::ops::Range;

/// Some of a chunk's photons, by rank.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Marks([u64; PHOTONS / 64]);

impl Marks {
    fn of(flags: &[u32; PHOTONS], photons: usize) -> Marks {
        let mut marks = Marks::default();
        for (rank, flag) in flags[..photons].iter().enumerate() {
            marks.0[rank / 64] |= u64::from(*flag != 0) << (rank % 64);
        }
        marks
    }

    /// Whether a photon is among them.
    pub fn has(&self, rank: usize) -> bool {
        self.0[rank / 64] >> (rank % 64) & 1 == 1
    }

    /// How many.
    pub fn count(&self) -> u32 {
        self.0.iter().map(|word| word.count_ones()).sum()
    }

    /// Those that are not among `others`.
    pub fn without(&self, others: &Marks) -> Marks {
        Marks(std::array::from_fn(|n| self.0[n] & !others.0[n]))
    }
}

/// What is looked for in recorded paths.
pub struct Suspicion {
    /// Every photon is suspected.
    all: bool,
    lamps: Vec<u16>,
    triangles: Vec<Range<u32>>,
    boxes: Vec<Cuboid>,
    /// Something moved to where the grid does not reach.
    beyond: bool,
    /// Where the lamps stood, in steps of the grid, by number.
    origins: Vec<[f32; 3]>,
}

impl Suspicion {
    /// Of paths that were recorded in `before`; `moved_in` are the objects that stand where they did not.
    pub fn new(before: &World, changed: &Difference, moved_in: &Crowd, numbers: &Numbers, grid: &Grid) -> Suspicion {
        // The most by which a path steps back from a surface, and a little for where the hit is stored.
        let slack = 16.5 * before.reach().step_back();
        let boxes: Vec<_> = moved_in.bounds().map(|bounds| grid.cuboid(bounds, slack)).collect();
        Suspicion {
            all: changed.choice,
            lamps: changed.lamps.iter().map(|lamp| *lamp as u16).collect(),
            triangles: numbers.of_objects(&changed.objects),
            beyond: boxes.iter().any(|(_, inside)| !inside),
            boxes: boxes.into_iter().filter_map(|(cuboid, _)| cuboid).collect(),
            origins: before.lamps().iter().map(|lamp| grid.place(lamp.position.as_vec3()).map(f32::from)).collect(),
        }
    }

    /// The photons of a chunk that may have become wrong.
    pub fn marks(&self, chunk: &Chunk) -> Marks {
        let photons = chunk.order().len();
        let mut flags = [u32::from(self.all); PHOTONS];
        if self.all {
            return Marks::of(&flags, photons);
        }
        let mut rows = [Row::default(), Row::default()];
        for rank in 0..photons {
            let lamp = chunk.lamp(rank);
            flags[rank] |= u32::from(self.lamps.contains(&lamp));
            let origin = self.origins.get(usize::from(lamp)).copied().unwrap_or([OUTSIDE; 3]);
            for axis in 0..3 {
                rows[0].0[axis][rank] = origin[axis];
            }
        }
        let walks = self.beyond || !self.boxes.is_empty();
        for level in chunk.levels() {
            for range in &self.triangles {
                for (flag, triangle) in flags.iter_mut().zip(level.triangles) {
                    *flag |= u32::from(triangle.wrapping_sub(range.start) < range.end - range.start);
                }
            }
            if walks {
                let reaching = level.triangles.len();
                let [from, to] = &mut rows;
                for axis in 0..3 {
                    for (steps, stored) in to.0[axis].iter_mut().zip(level.places[axis]) {
                        *steps = f32::from(*stored);
                    }
                }
                unknown(from, to, &mut flags, reaching);
                for cuboid in &self.boxes {
                    crossed(from, to, cuboid, &mut flags, reaching);
                }
                if self.beyond {
                    for (flag, triangle) in flags.iter_mut().zip(level.triangles) {
                        *flag |= u32::from(*triangle == ESCAPED);
                    }
                }
                rows.swap(0, 1);
            }
        }
        Marks::of(&flags, photons)
    }
}

/// Points of one level, in steps of the grid: x, y and z.
struct Row([[f32; PHOTONS]; 3]);

impl Default for Row {
    fn default() -> Row {
        Row([[0.0; PHOTONS]; 3])
    }
}

/// Raises the flags of segments with an end outside.
fn unknown(from: &Row, to: &Row, flags: &mut [u32; PHOTONS], reaching: usize) {
    for rank in 0..reaching {
        flags[rank] |= u32::from(from.0[0][rank].max(to.0[0][rank]) >= OUTSIDE);
    }
}

/// Raises the flags of segments that meet a box. No branches, so that the compiler makes vector instructions of it.
fn crossed(from: &Row, to: &Row, cuboid: &Cuboid, flags: &mut [u32; PHOTONS], reaching: usize) {
    let [sx, sy, sz] = cuboid.size;
    let [cx, cy, cz] = cuboid.sum;
    let reaching = reaching.min(PHOTONS);
    let ([ax, ay, az], [bx, by, bz]) = (&from.0, &to.0);
    for rank in 0..reaching {
        let (ax, ay, az, bx, by, bz) = (ax[rank], ay[rank], az[rank], bx[rank], by[rank], bz[rank]);
        let (dx, dy, dz) = (bx - ax, by - ay, bz - az);
        // Twice the way from the box's middle to the segment's.
        let (mx, my, mz) = (ax + bx - cx, ay + by - cy, az + bz - cz);
        let (lx, ly, lz) = (dx.abs(), dy.abs(), dz.abs());
        let meets = (mx.abs() <= lx + sx)
            & (my.abs() <= ly + sy)
            & (mz.abs() <= lz + sz)
            & ((my * dz - mz * dy).abs() <= sy * lz + sz * ly)
            & ((mz * dx - mx * dz).abs() <= sz * lx + sx * lz)
            & ((mx * dy - my * dx).abs() <= sx * ly + sy * lx);
        flags[rank] |= u32::from(meets);
    }
}
