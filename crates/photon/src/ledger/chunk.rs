//! The paths of up to 256 photons, as compactly as they can be streamed through: 10 bytes a hit and one a photon.
//!
//! Photons are sorted by the length of their paths, longest first, and hits are laid out level by level: first hits of all, second
//! hits of those that have one, and so on. The segments of a level then run from one contiguous row of points to the next, with no
//! mark of where a path begins.

use super::grid::Place;
use crate::solution::{CLASSES, Shooting};

/// Photons in a chunk: those of one residue class in one slab of the pool.
pub const PHOTONS: usize = (Shooting::SLAB / CLASSES) as usize;

/// A hit of a path, or where it leaves the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry {
    /// Where.
    pub place: Place,
    /// The triangle's number, or that it escaped.
    pub triangle: u32,
}

/// Of a photon that left no lamp.
pub const NO_LAMP: u16 = u16::MAX;

/// Paths one after the other, while they are worked on.
#[derive(Debug, Default)]
pub struct Paths {
    entries: Vec<Entry>,
    /// Per photon: its lamp, and one past its last entry.
    photons: Vec<(u16, usize)>,
}

impl Paths {
    /// Adds an entry to the path that is being written.
    pub fn push(&mut self, entry: Entry) {
        self.entries.push(entry);
    }

    /// Ends the path that is being written; the next one begins.
    pub fn finish(&mut self, lamp: u16) {
        self.photons.push((lamp, self.entries.len()));
    }

    /// How many paths are finished.
    pub fn len(&self) -> usize {
        self.photons.len()
    }

    /// Lamp and entries of a path.
    pub fn get(&self, photon: usize) -> (u16, &[Entry]) {
        let start = if photon == 0 { 0 } else { self.photons[photon - 1].1 };
        let (lamp, end) = self.photons[photon];
        (lamp, &self.entries[start..end])
    }
}

/// Paths at rest.
#[derive(Debug, Clone, Default)]
pub struct Chunk {
    /// The photon of each rank; ranks go from the longest path to the shortest.
    order: Box<[u8]>,
    /// The lamp of each rank, or one for all.
    lamps: Box<[u16]>,
    /// How many paths reach each level.
    levels: Box<[u16]>,
    /// x of all entries, then y, then z.
    places: Box<[u16]>,
    triangles: Box<[u32]>,
}

/// The entries of one level, by rank.
#[derive(Debug, Clone, Copy)]
pub struct Level<'a> {
    /// x, y and z.
    pub places: [&'a [u16]; 3],
    /// Numbers of triangles.
    pub triangles: &'a [u32],
}

impl Chunk {
    /// Lays paths out.
    pub fn pack(paths: &Paths) -> Chunk {
        let length = |photon: u8| paths.get(usize::from(photon)).1.len();
        let mut order: Vec<u8> = (0..paths.len()).map(|photon| photon as u8).collect();
        order.sort_by_key(|photon| std::cmp::Reverse(length(*photon)));
        let mut lamps: Vec<u16> = order.iter().map(|photon| paths.get(usize::from(*photon)).0).collect();
        if lamps.iter().all(|lamp| *lamp == lamps[0]) {
            lamps.truncate(1);
        }
        let entries = paths.entries.len();
        let (mut places, mut triangles) = (vec![0; 3 * entries], Vec::with_capacity(entries));
        let mut levels = Vec::new();
        let mut reaching = order.len();
        for level in 0.. {
            while reaching > 0 && length(order[reaching - 1]) <= level {
                reaching -= 1;
            }
            if reaching == 0 {
                break;
            }
            for photon in &order[..reaching] {
                let entry = paths.get(usize::from(*photon)).1[level];
                for axis in 0..3 {
                    places[axis * entries + triangles.len()] = entry.place[axis];
                }
                triangles.push(entry.triangle);
            }
            levels.push(reaching as u16);
        }
        Chunk {
            order: order.into(),
            lamps: lamps.into(),
            levels: levels.into(),
            places: places.into(),
            triangles: triangles.into(),
        }
    }

    /// The paths again, in the photons' order.
    pub fn unpack(&self) -> Paths {
        let mut rank_of = [0u8; PHOTONS];
        for (rank, photon) in self.order.iter().enumerate() {
            rank_of[usize::from(*photon)] = rank as u8;
        }
        let mut paths = Paths::default();
        paths.entries.reserve(self.triangles.len());
        for rank in &rank_of[..self.order.len()] {
            let rank = usize::from(*rank);
            let mut start = 0;
            for reaching in self.levels.iter().map(|n| usize::from(*n)).take_while(|n| rank < *n) {
                paths.push(self.entry(start + rank));
                start += reaching;
            }
            paths.finish(self.lamp(rank));
        }
        paths
    }

    fn entry(&self, number: usize) -> Entry {
        let entries = self.triangles.len();
        let place = std::array::from_fn(|axis| self.places[axis * entries + number]);
        Entry { place, triangle: self.triangles[number] }
    }

    /// The lamp of each rank, or one for all.
    pub fn lamps(&self) -> &[u16] {
        &self.lamps
    }

    fn lamp(&self, rank: usize) -> u16 {
        if self.lamps.len() == 1 { self.lamps[0] } else { self.lamps[rank] }
    }

    /// The photon of each rank.
    pub fn order(&self) -> &[u8] {
        &self.order
    }

    /// Level by level, first hits first.
    pub fn levels(&self) -> impl Iterator<Item = Level<'_>> {
        let entries = self.triangles.len();
        let mut start = 0;
        self.levels.iter().map(move |reaching| {
            let range = start..start + usize::from(*reaching);
            start = range.end;
            let places = std::array::from_fn(|axis| &self.places[axis * entries + range.start..axis * entries + range.end]);
            Level { places, triangles: &self.triangles[range] }
        })
    }

    /// Entries of all paths.
    pub fn entries(&self) -> usize {
        self.triangles.len()
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let row = std::mem::size_of_val::<[u16]>;
        size_of::<Chunk>()
            + self.order.len()
            + row(&self.lamps)
            + row(&self.levels)
            + row(&self.places)
            + 4 * self.triangles.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_come_back_as_they_were() {
        for photons in [0, 1, 5, 256] {
            let mut paths = Paths::default();
            for photon in 0..photons {
                for hit in 0..photon * 7 % 5 {
                    paths.push(Entry { place: [photon as u16, hit as u16, 3], triangle: (photon * 10 + hit) as u32 });
                }
                paths.finish(if photons == 5 { photon as u16 } else { 2 });
            }
            let chunk = Chunk::pack(&paths);
            let back = chunk.unpack();
            assert_eq!((back.entries, back.photons), (paths.entries, paths.photons));
            assert_eq!(chunk.levels().map(|level| level.triangles.len()).sum::<usize>(), chunk.entries());
        }
    }
}
