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
    swarm::Swarm,
};
use crate::world::{Crowd, Difference, World};
use std::ops::Range;

/// Some of a chunk's photons, by rank.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Marks([u64; PHOTONS / 64]);

impl Marks {
    fn of(flags: &[u32; PHOTONS], photons: usize) -> Marks {
        let mut marks = Marks::default();
        // Most words stay zero: that is seen at once.
        for (word, flags) in marks.0.iter_mut().zip(flags[..photons].chunks(64)) {
            if flags.iter().fold(0, |any, flag| any | flag) != 0 {
                *word = flags.iter().rev().fold(0, |word, flag| word << 1 | u64::from(*flag != 0));
            }
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
    boxes: Swarm,
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
        Suspicion {
            all: changed.choice,
            lamps: changed.lamps.iter().map(|lamp| *lamp as u16).collect(),
            triangles: numbers.of_objects(&changed.objects),
            beyond: moved_in.bounds().any(|bounds| !grid.cuboid(bounds, slack).1),
            boxes: Swarm::new(moved_in.bounds(), slack, grid),
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
        let (concerns, origin) = (
            |lamp: u16| u32::from(self.lamps.contains(&lamp)),
            |lamp: u16| self.origins.get(usize::from(lamp)).copied().unwrap_or([OUTSIDE; 3]),
        );
        if let [lamp] = chunk.lamps() {
            flags[..photons].fill(concerns(*lamp));
            rows[0] = Row(origin(*lamp).map(|steps| [steps; PHOTONS]));
        } else {
            for (rank, lamp) in chunk.lamps().iter().enumerate() {
                flags[rank] = concerns(*lamp);
                origin(*lamp).iter().zip(&mut rows[0].0).for_each(|(steps, row)| row[rank] = *steps);
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
                self.boxes.met(from, to, &mut flags, reaching);
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
pub struct Row(pub [[f32; PHOTONS]; 3]);

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
pub fn crossed(from: &Row, to: &Row, cuboid: &Cuboid, flags: &mut [u32; PHOTONS], reaching: usize) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hash::mix;
    use glam::Vec3;

    /// Points of a row of segments in a box of 6 × 4 × 3 metres, stored and as they are.
    fn segments(grid: &Grid, seed: u64) -> ([Row; 2], Vec<[Vec3; 2]>) {
        let number = |n: u64| (mix(seed << 32 | n) >> 40) as f32 / (1u64 << 24) as f32;
        let mut rows = [Row::default(), Row::default()];
        let ends = (0..PHOTONS).map(|rank| {
            std::array::from_fn(|end| {
                let n = (rank * 6 + end * 3) as u64;
                let point = Vec3::new(number(n), number(n + 1), number(n + 2)) * Vec3::new(6.0, 4.0, 3.0);
                let place = grid.place(point);
                (0..3).for_each(|axis| rows[end].0[axis][rank] = f32::from(place[axis]));
                point
            })
        });
        let ends = ends.collect();
        (rows, ends)
    }

    /// How much of a segment is in a box, as a share; negative if none is.
    fn inside([a, b]: [Vec3; 2], [low, high]: [Vec3; 2]) -> f64 {
        let (mut enter, mut leave) = (0.0f64, 1.0f64);
        for axis in 0..3 {
            let (a, d) = (f64::from(a[axis]), f64::from(b[axis]) - f64::from(a[axis]));
            let (p, q) = ((f64::from(low[axis]) - a) / d, (f64::from(high[axis]) - a) / d);
            (enter, leave) = (enter.max(p.min(q)), leave.min(p.max(q)));
        }
        leave - enter
    }

    #[test]
    fn every_segment_through_a_box_is_found_and_few_others() {
        let grid = Grid::new([Vec3::ZERO, Vec3::new(6.0, 4.0, 3.0)], 6.0);
        let (mut through, mut found) = (0, 0);
        for seed in 0..400 {
            let ([from, to], ends) = segments(&grid, seed);
            // From a grain of dust to half the room; some reach out of it.
            let size = 3.0 * (mix(seed) % 1000) as f32 / 1000.0;
            let middle = ends[0][0];
            let bounds = [middle - Vec3::new(size, size * 0.1, size * 0.5), middle + Vec3::splat(size * 0.3 + 1e-5)];
            let mut flags = [0; PHOTONS];
            crossed(&from, &to, &grid.cuboid(bounds, 0.0).0.unwrap(), &mut flags, PHOTONS);
            for (rank, segment) in ends.iter().enumerate() {
                let meets = inside(*segment, bounds) >= 0.0;
                assert!(!meets || flags[rank] != 0, "seed {seed}, segment {rank}");
                through += u32::from(meets);
                found += u32::from(flags[rank] != 0);
            }
        }
        assert!(through > 10_000 && found < through + through / 100, "{through} go through, {found} are found");
    }

    #[test]
    fn what_is_outside_is_not_known() {
        let grid = Grid::new([Vec3::ZERO, Vec3::ONE], 1.0);
        let far = Vec3::new(1.2, 0.5, 0.5);
        assert!(grid.point(grid.place(far)).is_none() && grid.point(grid.place(Vec3::splat(f32::NAN))).is_none());
        let exit = grid.point(grid.exit(Vec3::splat(0.5), Vec3::new(2.0, 0.0, -0.0))).unwrap();
        assert!(exit.distance(Vec3::new(1.1, 0.5, 0.5)) < 1e-4, "{exit}");
        assert!(
            grid.point(grid.exit(far, Vec3::NEG_X)).is_none() && grid.point(grid.exit(Vec3::splat(0.5), Vec3::ZERO)).is_none()
        );
        let (cuboid, within) = grid.cuboid([Vec3::splat(3.0), Vec3::splat(4.0)], 0.0);
        assert!(cuboid.is_none() && !within);
        assert!(grid.cuboid([Vec3::splat(0.2), Vec3::splat(0.4)], 0.0).1);
    }
}
