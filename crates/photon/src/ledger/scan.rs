//! Which recorded paths an edit may have made wrong: a plain stream over all points.
//!
//! A path changes only if it meets a changed object where that stood (its hits tell), if something stands in its way now (its segments
//! against the boxes of what moved), or if its lamp changed. Boxes are larger than what they hold by all that storing and stepping
//! back can shift a segment, so no photon is missed; some are suspected for nothing, and replaying them clears them.
//! Most segments pass what moved at a distance: their boxes, in whole numbers and sixteen at a time, do not meet the box about all of it. Of the
//! others a segment meets a box unless one of thirteen axes parts them (Gottschalk, Lin, Manocha 1996): for a segment six are left.

use super::{
    chunk::{Chunk, Level, PHOTONS},
    grid::{Cuboid, Grid, OUTSIDE, Place, UNKNOWN},
    numbers::{ESCAPED, Numbers},
    swarm::Swarm,
};
use crate::{
    crowd::Crowd,
    lanes::{LANES, Lanes, Task, widest},
    world::{Difference, World},
};
use std::ops::Range;

/// Some of a chunk's photons, by rank.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Marks([u64; PHOTONS / 64]);

impl Marks {
    /// The first so many.
    fn first(photons: usize) -> Marks {
        Marks(std::array::from_fn(|n| match photons.saturating_sub(64 * n) {
            0 => 0,
            left => u64::MAX >> 64usize.saturating_sub(left),
        }))
    }

    /// Adds up to eight from `rank` on, a multiple of eight, or one from anywhere: a bit each.
    fn add(&mut self, rank: usize, bits: u32) {
        self.0[rank / 64] |= u64::from(bits) << (rank % 64);
    }

    /// Whether a photon is among them.
    pub fn has(&self, rank: usize) -> bool {
        self.0[rank / 64] >> (rank % 64) & 1 == 1
    }

    /// Those that are.
    pub fn ranks(&self) -> impl Iterator<Item = usize> + '_ {
        self.0.iter().enumerate().flat_map(|(n, word)| {
            let mut left = *word;
            std::iter::from_fn(move || {
                let rank = (left != 0).then(|| 64 * n + left.trailing_zeros() as usize);
                left &= left.wrapping_sub(1);
                rank
            })
        })
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
    elements: Vec<Range<u32>>,
    boxes: Swarm,
    /// Low and high corner of a box about them, in steps of the grid; `None` if no way of a photon is suspected.
    around: Option<[Place; 2]>,
    /// Something moved to where the grid does not reach.
    beyond: bool,
    /// Where the lamps stood, in steps of the grid, by number.
    origins: Vec<Place>,
}

impl Suspicion {
    /// Of paths that were recorded in `before`; `moved_in` are the objects that stand where they did not.
    pub fn new(before: &World, changed: &Difference, moved_in: &Crowd, numbers: &Numbers, grid: &Grid) -> Suspicion {
        // The most by which a path steps back from a surface, and a little for where the hit is stored.
        let slack = 16.5 * before.reach().step_back();
        let boxes = Swarm::new(moved_in.bounds(), slack, grid);
        let beyond = moved_in.bounds().any(|bounds| !grid.cuboid(bounds, slack).1);
        Suspicion {
            all: changed.choice,
            lamps: changed.lamps.iter().map(|lamp| *lamp as u16).collect(),
            elements: numbers.of_objects(&changed.objects),
            around: around(&boxes, beyond),
            beyond,
            boxes,
            origins: before.lamps().iter().map(|lamp| grid.place(lamp.position.as_vec3())).collect(),
        }
    }

    /// The photons of a chunk that may have become wrong.
    pub fn marks(&self, chunk: &Chunk) -> Marks {
        if self.all { Marks::first(chunk.order().len()) } else { widest(Looking { suspicion: self, chunk }) }
    }

    /// Whether the photons of this lamp are suspected, and where it stood.
    fn of_lamp(&self, lamp: u16) -> (bool, Place) {
        (self.lamps.contains(&lamp), self.origins.get(usize::from(lamp)).copied().unwrap_or(UNKNOWN))
    }
}

/// A box about boxes, a step larger so that no rounding leaves out what touches one of them.
fn around(boxes: &Swarm, beyond: bool) -> Option<[Place; 2]> {
    let (mut low, mut high) = ([OUTSIDE; 3], [0.0f32; 3]);
    for Cuboid { sum, size } in boxes.0.iter().map(|node| node.cuboid) {
        for axis in 0..3 {
            low[axis] = low[axis].min((sum[axis] - size[axis]) / 2.0 - 1.0);
            high[axis] = high[axis].max((sum[axis] + size[axis]) / 2.0 + 1.0);
        }
    }
    // What is too small or too large becomes the smallest or largest number.
    let around = [low.map(|low| low.floor() as u16), high.map(|high| high.ceil() as u16)];
    (beyond || !boxes.0.is_empty()).then_some(around)
}

/// A look through the records of one chunk.
struct Looking<'a> {
    suspicion: &'a Suspicion,
    chunk: &'a Chunk,
}

impl Task for Looking<'_> {
    type Output = Marks;

    /// Level by level, as the records lie in memory: first whose box meets that about all boxes, then which of those touch one.
    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Marks {
        let Looking { suspicion, chunk } = self;
        let Level { places, elements } = chunk.all();
        let mut marks = Marks::default();
        let mut near = [0; PHOTONS + LANES];
        let (mut room, mut numbers) = ([[0; 2 * LANES]; 6], [0; LANES]);
        let lamps = self.lamps(&mut marks);
        // Where photons come from on a level: rows, and where in them the first one is.
        let (mut before, mut begin) = ([&lamps[0][..], &lamps[1], &lamps[2]], 0);
        let mut start = 0;
        for reaching in chunk.reaching() {
            let reaching = usize::from(*reaching);
            for block in (0..reaching).step_by(LANES) {
                let mut suspected = l.less(l.splat(0.0), l.splat(0.0));
                let hits = some(elements, start + block, &mut numbers);
                for range in &suspicion.elements {
                    suspected = l.or(suspected, l.among(hits, range.start, range.end - range.start));
                }
                if suspicion.beyond {
                    suspected = l.or(suspected, l.among(hits, ESCAPED, 1));
                }
                // What follows the last photon of a level is of the next one.
                marks.add(block, l.bits(suspected) & first(reaching - block));
            }
            if let Some([low, high]) = suspicion.around {
                let mut count = 0;
                for block in (0..reaching).step_by(2 * LANES) {
                    let [a, b, c, d, e, f] = &mut room;
                    let at = begin + block;
                    let from = [some(before[0], at, a), some(before[1], at, b), some(before[2], at, c)];
                    let at = start + block;
                    let to = [some(places[0], at, d), some(places[1], at, e), some(places[2], at, f)];
                    let bits = l.meet(from, to, low, high) & first(reaching - block);
                    for (half, bits) in [bits as u8, (bits >> LANES) as u8].into_iter().enumerate() {
                        let ranks = RANKS[block / LANES + half];
                        near[count..count + LANES].copy_from_slice(&l.pack(&ranks, bits));
                        count += bits.count_ones() as usize;
                    }
                }
                for ranks in near[..count].chunks(LANES) {
                    let [mut from, mut to] = [[[0.0; LANES]; 3]; 2];
                    for (k, rank) in ranks.iter().enumerate() {
                        let rank = usize::from(*rank);
                        for axis in 0..3 {
                            from[axis][k] = f32::from(before[axis][begin + rank]);
                            to[axis][k] = f32::from(places[axis][start + rank]);
                        }
                    }
                    let touched = Segments::new(l, l.load_vectors(&from), l.load_vectors(&to)).touch(suspicion);
                    let mut touched = l.bits(touched) & first(ranks.len());
                    while touched != 0 {
                        marks.add(usize::from(ranks[touched.trailing_zeros() as usize]), 1);
                        touched &= touched - 1;
                    }
                }
            }
            (before, begin) = (places, start);
            start += reaching;
        }
        marks
    }
}

/// The ranks, eight by eight.
static RANKS: [[u16; LANES]; PHOTONS / LANES] = {
    let (mut ranks, mut rank) = ([[0; LANES]; PHOTONS / LANES], 0);
    while rank < PHOTONS {
        ranks[rank / LANES][rank % LANES] = rank as u16;
        rank += 1;
    }
    ranks
};

/// Bits of the first so many, or of all.
#[inline(always)]
fn first(count: usize) -> u32 {
    u32::MAX >> 32usize.saturating_sub(count)
}

impl Looking<'_> {
    /// Marks the photons of suspected lamps; where all leave theirs, by rank.
    #[inline(always)]
    fn lamps(&self, marks: &mut Marks) -> [[u16; PHOTONS]; 3] {
        if let [lamp] = self.chunk.lamps() {
            let (suspected, [x, y, z]) = self.suspicion.of_lamp(*lamp);
            if suspected {
                *marks = Marks::first(self.chunk.order().len());
            }
            return [[x; PHOTONS], [y; PHOTONS], [z; PHOTONS]];
        }
        let mut rows = [[0; PHOTONS]; 3];
        for (rank, lamp) in self.chunk.lamps().iter().enumerate() {
            let (suspected, place) = self.suspicion.of_lamp(*lamp);
            marks.add(rank, u32::from(suspected));
            for axis in 0..3 {
                rows[axis][rank] = place[axis];
            }
        }
        rows
    }
}

/// Some from `start` on, where they are if they are all there; what is not there is anything.
#[inline(always)]
fn some<'a, T: Copy, const N: usize>(row: &'a [T], start: usize, room: &'a mut [T; N]) -> &'a [T; N] {
    match row[start..].first_chunk() {
        Some(some) => some,
        None => at_the_end(&row[start..], room),
    }
}

#[cold]
fn at_the_end<'a, T: Copy, const N: usize>(from: &[T], room: &'a mut [T; N]) -> &'a [T; N] {
    room[..from.len()].copy_from_slice(from);
    room
}

/// Eight segments: the way from one end to the other, the sum of both, the way's absolute value, and where an end is outside.
struct Segments<L: Lanes> {
    lanes: L,
    way: [L::Numbers; 3],
    sum: [L::Numbers; 3],
    long: [L::Numbers; 3],
    outside: L::Mask,
}

impl<L: Lanes> Segments<L> {
    #[inline(always)]
    fn new(l: L, from: [L::Numbers; 3], to: [L::Numbers; 3]) -> Segments<L> {
        let ([ax, ay, az], [bx, by, bz]) = (from, to);
        let way = [l.sub(bx, ax), l.sub(by, ay), l.sub(bz, az)];
        Segments {
            lanes: l,
            way,
            sum: [l.add(ax, bx), l.add(ay, by), l.add(az, bz)],
            long: [l.abs(way[0]), l.abs(way[1]), l.abs(way[2])],
            outside: l.at_most(l.splat(OUTSIDE), l.max(ax, bx)),
        }
    }

    /// Which of them touch what moved.
    #[inline(always)]
    fn touch(&self, suspicion: &Suspicion) -> L::Mask {
        let l = self.lanes;
        let mut touched = self.outside;
        let (nodes, mut next) = (&suspicion.boxes.0, 0);
        while let Some(node) = nodes.get(next) {
            let crossed = self.cross(&node.cuboid);
            next = match l.bits(crossed) {
                0 => node.next as usize,
                _ => next + 1,
            };
            if node.moved {
                touched = l.or(touched, crossed);
            }
        }
        touched
    }

    /// Which of them meet a box.
    #[inline(always)]
    fn cross(&self, cuboid: &Cuboid) -> L::Mask {
        let l = self.lanes;
        let [sx, sy, sz] = [l.splat(cuboid.size[0]), l.splat(cuboid.size[1]), l.splat(cuboid.size[2])];
        let ([dx, dy, dz], [lx, ly, lz]) = (self.way, self.long);
        // Twice the way from the box's middle to the segment's.
        let mx = l.sub(self.sum[0], l.splat(cuboid.sum[0]));
        let my = l.sub(self.sum[1], l.splat(cuboid.sum[1]));
        let mz = l.sub(self.sum[2], l.splat(cuboid.sum[2]));
        let beside = l.and(l.at_most(l.abs(mx), l.add(lx, sx)), l.at_most(l.abs(my), l.add(ly, sy)));
        let beside = l.and(beside, l.at_most(l.abs(mz), l.add(lz, sz)));
        // Most boxes are passed at a distance.
        if l.bits(beside) == 0 {
            return beside;
        }
        let x = l.at_most(l.abs(l.sub(l.mul(my, dz), l.mul(mz, dy))), l.add(l.mul(sy, lz), l.mul(sz, ly)));
        let y = l.at_most(l.abs(l.sub(l.mul(mz, dx), l.mul(mx, dz))), l.add(l.mul(sz, lx), l.mul(sx, lz)));
        let z = l.at_most(l.abs(l.sub(l.mul(mx, dy), l.mul(my, dx))), l.add(l.mul(sx, ly), l.mul(sy, lx)));
        l.and(beside, l.and(x, l.and(y, z)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{hash::mix, lanes::Portable, ledger::chunk::Entry};
    use glam::Vec3;

    /// Segments in a box of 6 × 4 × 3 metres, stored and as they are.
    fn segments(grid: &Grid, seed: u64) -> ([[[f32; LANES]; 3]; 2], Vec<[Vec3; 2]>) {
        let number = |n: u64| (mix(seed << 32 | n) >> 40) as f32 / (1u64 << 24) as f32;
        let mut stored = [[[0.0; LANES]; 3]; 2];
        let ends = (0..LANES).map(|k| {
            std::array::from_fn(|end| {
                let n = (k * 6 + end * 3) as u64;
                let point = Vec3::new(number(n), number(n + 1), number(n + 2)) * Vec3::new(6.0, 4.0, 3.0);
                let place = grid.place(point);
                (0..3).for_each(|axis| stored[end][axis][k] = f32::from(place[axis]));
                point
            })
        });
        let ends = ends.collect();
        (stored, ends)
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
        for seed in 0..12_000 {
            let ([from, to], ends) = segments(&grid, seed);
            // From a grain of dust to half the room; some reach out of it.
            let size = 3.0 * (mix(seed) % 1000) as f32 / 1000.0;
            let middle = ends[0][0];
            let bounds = [middle - Vec3::new(size, size * 0.1, size * 0.5), middle + Vec3::splat(size * 0.3 + 1e-5)];
            let flags = Segments::new(Portable, from, to).cross(&grid.cuboid(bounds, 0.0).0.unwrap());
            for (rank, segment) in ends.iter().enumerate() {
                let meets = inside(*segment, bounds) >= 0.0;
                assert!(!meets || flags >> rank & 1 != 0, "seed {seed}, segment {rank}");
                through += u32::from(meets);
                found += flags >> rank & 1;
            }
        }
        assert!(through > 10_000 && found < through + through / 100, "{through} go through, {found} are found");
    }

    #[test]
    fn all_machines_suspect_the_same_and_as_much_as_one_photon_at_a_time() {
        let grid = Grid::new([Vec3::ZERO, Vec3::new(6.0, 4.0, 3.0)], 6.0);
        let mut suspected = 0;
        for seed in 0..300u64 {
            let number = |n: u64| mix(mix(seed) ^ n);
            let point = |n: u64| Vec3::from_array([n, n + 1, n + 2].map(|n| (number(n) % 4096) as f32 / 4096.0)) * 6.5;
            let photons = [0, 1, 7, 8, 9, 255, 256][(seed % 7) as usize];
            let lamp = |photon: u64| if seed % 3 == 0 { 1 } else { (number(photon) % 3) as u16 };
            let mut paths: Vec<Vec<Entry>> = Vec::new();
            for photon in 0..photons as u64 {
                let entry = |hit: u64| {
                    let n = 10_000 + photon * 100 + hit * 10;
                    let element = if number(n) % 9 == 0 { ESCAPED } else { (number(n) % 2000) as u32 };
                    Entry { place: grid.place(point(n)), element }
                };
                paths.push((0..number(photon + 500) % 9).map(entry).collect());
            }
            let lamps: Vec<u16> = (0..photons as u64).map(lamp).collect();
            let corners = (0..seed % 23).map(|n| [point(n * 9), point(n * 9) + 0.3]);
            let boxes: Vec<_> = corners.clone().filter_map(|corners| grid.cuboid(corners, 0.0).0).collect();
            let origins = (0..2).map(|lamp| grid.place(point(77 + lamp))).collect();
            let (swarm, beyond) = (Swarm::new(corners, 0.0, &grid), seed % 6 == 0);
            let suspicion = Suspicion {
                all: seed % 50 == 49,
                lamps: if seed % 4 == 0 { vec![1] } else { vec![] },
                elements: vec![20..21, 300..350],
                around: around(&swarm, beyond),
                boxes: swarm,
                beyond,
                origins,
            };
            let chunk = Chunk::new(&lamps, &paths);
            let marks = suspicion.marks(&chunk);
            if !suspicion.all {
                assert_eq!(marks, Looking { suspicion: &suspicion, chunk: &chunk }.run(Portable));
            }
            for (rank, photon) in chunk.order().iter().enumerate() {
                let (of_lamp, place) = suspicion.of_lamp(lamp(u64::from(*photon)));
                let mut from = place.map(f32::from);
                let mut wrong = suspicion.all || of_lamp;
                for entry in &paths[usize::from(*photon)] {
                    let to = entry.place.map(f32::from);
                    let one = |place: [f32; 3]| place.map(|steps| [steps; LANES]);
                    wrong |= suspicion.elements.iter().any(|range| range.contains(&entry.element))
                        || (suspicion.beyond && entry.element == ESCAPED);
                    if suspicion.beyond || !boxes.is_empty() {
                        // Boxes about boxes change nothing.
                        let segment = Segments::new(Portable, one(from), one(to));
                        wrong |= segment.outside != 0 || boxes.iter().any(|cuboid| segment.cross(cuboid) != 0);
                    }
                    from = to;
                }
                assert_eq!(marks.has(rank), wrong, "seed {seed}, photon {photon}");
                suspected += u32::from(wrong);
            }
            assert!(marks.ranks().all(|rank| rank < photons) && marks.ranks().count() as u32 == marks.count());
        }
        assert!(suspected > 3000, "{suspected}");
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
