//! The paths of up to 256 photons, as compactly as they can be streamed through: 10 bytes a hit and one a photon.
//!
//! Photons are sorted by the length of their paths, longest first, and hits are laid out level by level: first hits of all, second
//! hits of those that have one, and so on. The segments of a level then run from one contiguous row of points to the next, with no
//! mark of where a path begins.

use super::grid::Place;

/// Photons in a chunk: those of one residue class in one slab of the pool.
pub const PHOTONS: usize = 256;

/// A hit of a path, or where it leaves the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry {
    /// Where.
    pub place: Place,
    /// The number of the side of a mesh element, or that it escaped.
    pub element: u32,
}

/// Of a photon that left no lamp.
pub const NO_LAMP: u16 = u16::MAX;

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
    elements: Box<[u32]>,
}

/// The entries of one level or of all, one level after the other; by rank.
#[derive(Debug, Clone, Copy)]
pub struct Level<'a> {
    /// x, y and z.
    pub places: [&'a [u16]; 3],
    /// Numbers of elements.
    pub elements: &'a [u32],
}

/// One lamp if all are it.
fn one_or_all(lamps: &[u16]) -> Box<[u16]> {
    let alike = lamps.iter().all(|lamp| *lamp == lamps[0]);
    lamps[..if alike { lamps.len().min(1) } else { lamps.len() }].into()
}

impl Chunk {
    /// Lays paths out, each with its lamp.
    pub fn new(lamps: &[u16], paths: &[Vec<Entry>]) -> Chunk {
        let longest = paths.iter().map(Vec::len).max().unwrap_or(0);
        // How many are longer than their index says: at first, as long as it says.
        let mut levels = vec![0u16; longest + 1];
        paths.iter().for_each(|path| levels[path.len()] += 1);
        let mut longer = 0;
        for count in levels.iter_mut().rev() {
            longer += std::mem::replace(count, longer);
        }
        let mut starts = Vec::with_capacity(longest);
        let mut entries = 0;
        for reaching in &levels[..longest] {
            starts.push(entries);
            entries += usize::from(*reaching);
        }
        let (mut ranks, mut by_rank) = (levels.clone(), vec![NO_LAMP; paths.len()]);
        let mut chunk = Chunk {
            order: vec![0; paths.len()].into(),
            lamps: Box::default(),
            levels: levels[..longest].into(),
            places: vec![0; 3 * entries].into(),
            elements: vec![0; entries].into(),
        };
        for (photon, (path, lamp)) in paths.iter().zip(lamps).enumerate() {
            let rank = usize::from(ranks[path.len()]);
            ranks[path.len()] += 1;
            (chunk.order[rank], by_rank[rank]) = (photon as u8, *lamp);
            for (start, entry) in starts.iter().zip(path) {
                let at = start + rank;
                for axis in 0..3 {
                    chunk.places[axis * entries + at] = entry.place[axis];
                }
                chunk.elements[at] = entry.element;
            }
        }
        chunk.lamps = one_or_all(&by_rank);
        chunk
    }

    /// The lamp of each rank, or one for all.
    pub fn lamps(&self) -> &[u16] {
        &self.lamps
    }

    /// The photon of each rank.
    pub fn order(&self) -> &[u8] {
        &self.order
    }

    /// How many paths reach each level.
    pub fn reaching(&self) -> &[u16] {
        &self.levels
    }

    /// The entries of all levels.
    pub fn all(&self) -> Level<'_> {
        let (x, rest) = self.places.split_at(self.elements.len());
        let (y, z) = rest.split_at(self.elements.len());
        Level { places: [x, y, z], elements: &self.elements }
    }

    /// Level by level, first hits first.
    pub fn levels(&self) -> impl Iterator<Item = Level<'_>> {
        let all = self.all();
        let mut start = 0;
        self.levels.iter().map(move |reaching| {
            let range = start..start + usize::from(*reaching);
            start = range.end;
            Level { places: all.places.map(|axis| &axis[range.clone()]), elements: &all.elements[range] }
        })
    }

    /// Adds the path of a rank to `path`; its lamp.
    pub fn path(&self, rank: usize, path: &mut Vec<Entry>) -> u16 {
        let levels = self.levels().take_while(|level| rank < level.elements.len());
        path.extend(
            levels.map(|Level { places, elements }| Entry { place: places.map(|axis| axis[rank]), element: elements[rank] }),
        );
        self.lamps[rank.min(self.lamps.len() - 1)]
    }

    /// Entries of all paths.
    pub fn entries(&self) -> usize {
        self.elements.len()
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let row = std::mem::size_of_val::<[u16]>;
        size_of::<Chunk>() + self.order.len() + row(&self.lamps) + row(&self.levels) + row(&self.places) + 4 * self.elements.len()
    }
}

/// Paths that are being written: a chunk with room in every level.
///
/// A path that grows or shrinks by a hit changes places with the last or first of its length, which moves one other path; so a
/// changed photon costs a few hits, not its chunk.
#[derive(Debug, Default)]
pub struct Loose {
    /// The photon of each rank.
    order: Vec<u8>,
    rank_of: Vec<u8>,
    /// By rank.
    lamps: Vec<u16>,
    /// How many paths reach each level.
    reaching: Vec<usize>,
    /// By level; not less than there are in `reaching`.
    rows: Vec<Row>,
}

/// Room for a level: x, y and z, and elements.
#[derive(Debug, Clone)]
struct Row([[u16; PHOTONS]; 3], [u32; PHOTONS]);

impl Loose {
    /// Begins with the paths of a chunk.
    pub fn load(&mut self, chunk: &Chunk) {
        self.order.clear();
        self.order.extend_from_slice(&chunk.order);
        self.rank_of.resize(chunk.order.len(), 0);
        for (rank, photon) in chunk.order.iter().enumerate() {
            self.rank_of[usize::from(*photon)] = rank as u8;
        }
        self.lamps.clear();
        self.lamps.extend_from_slice(&chunk.lamps);
        if let [lamp] = *chunk.lamps {
            self.lamps.resize(chunk.order.len(), lamp);
        }
        self.reaching.clear();
        for level in chunk.levels() {
            let Row(places, elements) = self.add_level(level.elements.len());
            places.iter_mut().zip(level.places).for_each(|(row, places)| row[..places.len()].copy_from_slice(places));
            elements[..level.elements.len()].copy_from_slice(level.elements);
        }
    }

    /// Lays the paths to rest.
    pub fn store(&self) -> Chunk {
        let entries = self.reaching.iter().sum();
        let (mut places, mut elements) = (Vec::with_capacity(3 * entries), Vec::with_capacity(entries));
        let rows = || self.rows.iter().zip(&self.reaching);
        for axis in 0..3 {
            rows().for_each(|(row, reaching)| places.extend_from_slice(&row.0[axis][..*reaching]));
        }
        rows().for_each(|(row, reaching)| elements.extend_from_slice(&row.1[..*reaching]));
        Chunk {
            order: self.order.as_slice().into(),
            lamps: one_or_all(&self.lamps),
            levels: self.reaching.iter().map(|reaching| *reaching as u16).collect(),
            places: places.into(),
            elements: elements.into(),
        }
    }

    /// Replaces the path of a photon.
    pub fn set(&mut self, photon: u8, lamp: u16, path: &[Entry]) {
        let mut rank = usize::from(self.rank_of[usize::from(photon)]);
        let length = self.reaching.iter().take_while(|reaching| rank < **reaching).count();
        for level in length..path.len() {
            if level == self.reaching.len() {
                self.add_level(0);
            }
            let first = self.reaching[level];
            self.exchange(rank, first, level);
            rank = first;
            self.reaching[level] += 1;
        }
        for level in (path.len()..length).rev() {
            let last = self.reaching[level] - 1;
            self.exchange(rank, last, level + 1);
            rank = last;
            self.reaching[level] -= 1;
        }
        while self.reaching.last() == Some(&0) {
            self.reaching.pop();
        }
        self.lamps[rank] = lamp;
        for (Row(places, elements), entry) in self.rows.iter_mut().zip(path) {
            places.iter_mut().zip(entry.place).for_each(|(row, place)| row[rank] = place);
            elements[rank] = entry.element;
        }
    }

    fn add_level(&mut self, reaching: usize) -> &mut Row {
        let level = self.reaching.len();
        self.reaching.push(reaching);
        if level == self.rows.len() {
            self.rows.push(Row([[0; PHOTONS]; 3], [0; PHOTONS]));
        }
        &mut self.rows[level]
    }

    /// Two photons of the same length change ranks; of the first one's path nothing is kept, as it will be replaced.
    fn exchange(&mut self, replaced: usize, other: usize, length: usize) {
        if replaced == other {
            return;
        }
        self.order.swap(replaced, other);
        self.lamps.swap(replaced, other);
        for rank in [replaced, other] {
            self.rank_of[usize::from(self.order[rank])] = rank as u8;
        }
        for Row(places, elements) in &mut self.rows[..length] {
            places.iter_mut().for_each(|row| row[replaced] = row[other]);
            elements[replaced] = elements[other];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hash::mix;

    fn path(seed: u64) -> (u16, Vec<Entry>) {
        let length = mix(seed) % 7 * (mix(seed) >> 32) % 5;
        let entry = |hit| Entry { place: [seed as u16, hit as u16, 3], element: (seed * 10 + hit) as u32 };
        (if seed % 1000 < 256 { 2 } else { seed as u16 }, (0..length).map(entry).collect())
    }

    fn check(chunk: &Chunk, expected: &[(u16, Vec<Entry>)]) {
        let mut found = Vec::new();
        for (rank, photon) in chunk.order().iter().enumerate() {
            let (lamp, path) = &expected[usize::from(*photon)];
            found.clear();
            assert_eq!(chunk.path(rank, &mut found), *lamp);
            assert_eq!(found, *path);
        }
    }

    #[test]
    fn paths_come_back_as_they_were_and_changed_ones_as_if_laid_out_anew() {
        for photons in [0u64, 1, 5, 256] {
            let mut paths: Vec<_> = (0..photons).map(path).collect();
            let (lamps, all): (Vec<u16>, Vec<Vec<Entry>>) = paths.iter().cloned().unzip();
            let (mut chunk, mut loose) = (Chunk::new(&lamps, &all), Loose::default());
            for round in 0..20 {
                check(&chunk, &paths);
                loose.load(&chunk);
                let hits = paths.iter().map(|(_, path)| path.len()).sum::<usize>();
                assert_eq!(chunk.levels().map(|level| level.elements.len()).sum::<usize>(), chunk.entries());
                assert_eq!(chunk.entries(), hits, "no room is left");
                assert!(chunk.reaching().is_sorted_by(|a, b| a >= b && *b > 0));
                let longest = paths.iter().map(|(_, path)| path.len()).max().unwrap_or(0);
                assert_eq!(chunk.reaching().len(), longest);
                for change in 0..round.min(photons) {
                    let photon = (mix(round * 300 + change) % photons) as usize;
                    // Rows of one lamp become rows of several and back.
                    paths[photon] = path(1000 * (round % 3) + change);
                    loose.set(photon as u8, paths[photon].0, &paths[photon].1);
                }
                chunk = loose.store();
            }
        }
    }
}
