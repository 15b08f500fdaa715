//! Where photons land: integer sums per object, side, lamp and mesh element.
//!
//! Integers add and subtract exactly in any order: the order of threads, edits or photons never changes a bit. A page of buckets
//! exists only where light has arrived, so the inside of furniture costs nothing.
//!
//! No sum can overflow: a deposit is at most 2²⁴ per channel, so [`CAPACITY`] = 2³⁹ − 1 of them fit 63 bits wherever they land: 55 times 10¹⁰. Whatever
//! would make them more is refused whole before anything of it is added ([`Full`]). No slab of photons is shot once there are
//! [`MOST_DEPOSITS`], half of that; a slab adds at most 2³⁵ ([`crate::shooting::Shooting::shoot`]). The other half is for edits that brighten the scene.

mod table;
mod trend;

use glam::Vec3;
use lightmend_scene::Configuration;
use std::{
    io::{self, Write},
    iter::{empty, once, repeat_n},
    sync::Arc,
};
use table::Table;

/// log₂ of the energy of a photon that has lost nothing: a deposit is `round(throughput · 2²⁴)`.
pub const ENERGY_BITS: u32 = 24;

/// Deposits from which on no more photons are shot, so that no bucket can overflow.
pub const MOST_DEPOSITS: i64 = 1 << 38;

/// Deposits that fit wherever they land: ⌊(2⁶³ − 1) / 2²⁴⌋.
pub const CAPACITY: i64 = i64::MAX >> ENERGY_BITS;

/// More light than can be counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "there is no room for more light: mesh elements count {MOST_DEPOSITS} photon hits, and twice as many after edits; shoot fewer photons"
)]
pub struct Full;

/// Where a deposit goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Address {
    /// Index of the object.
    pub object: u32,
    /// Cell of the object's lattice.
    pub cell: u32,
    /// 0: front, 1: back.
    pub side: u8,
    /// Index of the lamp.
    pub lamp: u16,
}

/// A photon's energy at one hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Deposit {
    /// Where.
    pub to: Address,
    /// Per linear Rec. 709 channel, in units of 2⁻²⁴ of a photon.
    pub energy: [u32; 3],
}

/// Throughput per channel as fixed-point energy.
#[inline(always)]
pub fn energy(throughput: Vec3) -> [u32; 3] {
    // One rounding, ties to even, that of the addition: the integer is then the lowest bits of the sum. `round_ties_even` is a call on
    // processors before SSE 4.1.
    const ROUND: f64 = (1u64 << 52) as f64;
    throughput.to_array().map(|t| (f64::from(t) * f64::from(1 << ENERGY_BITS) + ROUND).to_bits() as u32)
}

/// The light that has arrived at one element side from one lamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Bucket {
    /// Energy per channel.
    pub energy: [i64; 3],
    /// Photon hits.
    pub hits: i64,
}

impl Bucket {
    #[inline(always)]
    fn count(&mut self, deposit: &Deposit, sign: i64) {
        self.energy.iter_mut().zip(deposit.energy).for_each(|(sum, energy)| *sum += sign * i64::from(energy));
        self.hits += sign;
    }
}

/// All buckets of a scene. A clone shares its pages until light arrives in them: of two snapshots, only what differs is held twice.
#[derive(Debug, Clone, Default)]
pub struct Buckets {
    /// Cells of each object, by number.
    cells: Vec<u32>,
    /// Per object, a page for each side of each lamp: 2 · lamp + side. As many for every object.
    pages: Vec<Vec<Option<Arc<[Bucket]>>>>,
    /// Hits in all buckets.
    deposits: i64,
}

impl Buckets {
    /// Dark buckets for the objects and lamps of `configuration`.
    pub fn new(configuration: &Configuration) -> Buckets {
        let mut buckets = Buckets::default();
        buckets.grow(configuration);
        buckets
    }

    /// Makes room for the objects and lamps that were added.
    pub fn grow(&mut self, configuration: &Configuration) {
        let new = self.cells.len()..configuration.object_slots();
        self.cells.extend(new.map(|id| configuration.object(id).lattice.cells()));
        self.pages.resize_with(self.cells.len(), Vec::new);
        let width = self.width().max(2 * configuration.lamp_slots());
        self.pages.iter_mut().for_each(|pages| pages.resize(width, None));
    }

    /// Whether so many deposits more fit, whatever they bring and wherever they land.
    pub fn admit(&self, more: i64) -> Result<(), Full> {
        if self.deposits.saturating_add(more) > CAPACITY { Err(Full) } else { Ok(()) }
    }

    /// Adds deposits; none of them if they do not fit.
    pub fn add(&mut self, deposits: &[Deposit]) -> Result<(), Full> {
        self.exchange(empty(), once(deposits))
    }

    /// Takes away deposits that were added before and adds others; neither if they do not fit.
    pub fn exchange<'d, T, A>(&mut self, taken: T, added: A) -> Result<(), Full>
    where
        T: Iterator<Item = &'d [Deposit]> + Clone,
        A: Iterator<Item = &'d [Deposit]> + Clone,
    {
        let less: i64 = taken.clone().map(|deposits| deposits.len() as i64).sum();
        let more: i64 = added.clone().map(|deposits| deposits.len() as i64).sum();
        self.admit(more - less)?;
        let batches = taken.map(|deposits| (deposits, -1)).chain(added.map(|deposits| (deposits, 1)));
        if less + more < self.few() {
            for (deposits, sign) in batches {
                deposits.iter().for_each(|deposit| self.page(deposit.to)[deposit.to.cell as usize].count(deposit, sign));
            }
        } else {
            let mut table = Table::new(self);
            batches.for_each(|(deposits, sign)| table.count(deposits, sign));
        }
        self.deposits += more - less;
        Ok(())
    }

    /// Deposits from which on a [`Table`] of all pages is faster than to look for the page of each: two for every page. (Measured: at one the table
    /// takes 1.1 to 1.3 times as long, at two 0.98 and 1.1, at four 0.9.)
    fn few(&self) -> i64 {
        2 * (self.pages.len() * self.width()) as i64
    }

    /// Pages of an object, dark ones too.
    fn width(&self) -> usize {
        self.pages.first().map_or(0, Vec::len)
    }

    /// Deposits that all buckets hold together.
    pub fn deposits(&self) -> i64 {
        self.deposits
    }

    /// Adds the light of another pool in the same scene; nothing if it does not fit.
    pub fn merge(&mut self, other: &Buckets) -> Result<(), Full> {
        self.admit(other.deposits)?;
        for (at, more) in other.lit() {
            let bucket = &mut self.page(at)[at.cell as usize];
            bucket.energy.iter_mut().zip(more.energy).for_each(|(sum, energy)| *sum += energy);
            bucket.hits += more.hits;
        }
        self.deposits += other.deposits;
        Ok(())
    }

    /// So many hits more (or less) on one side of a cell, from all lamps in proportion, each like those that are there; like `usual`, of this lamp, where
    /// there are none.
    pub(crate) fn add_hits_alike(&mut self, object: usize, cell: u32, side: usize, hits: f64, (lamp, usual): (usize, Bucket)) {
        let hits_of = |page: &Option<Arc<[Bucket]>>| page.as_ref().and_then(|page| page.get(cell as usize)).map_or(0, |b| b.hits);
        let all: i64 = self.pages[object].iter().skip(side).step_by(2).map(hits_of).sum();
        if all == 0 && hits >= 1.0 && usual.hits > 0 && cell < self.cells[object] {
            let scaled = |value: i64| (value as f64 * hits / usual.hits as f64).round() as i64;
            let bucket = Bucket { energy: usual.energy.map(scaled), hits: hits.round() as i64 };
            self.set(Address { object: object as u32, cell, side: side as u8, lamp: lamp as u16 }, bucket);
        }
        if all == 0 {
            return;
        }
        let factor = (1.0 + hits / all as f64).max(0.0);
        for page in self.pages[object].iter_mut().skip(side).step_by(2).filter(|page| hits_of(page) > 0) {
            let Some(page) = page else { continue };
            let bucket = &mut Arc::make_mut(page)[cell as usize];
            let scaled = |value: i64| (value as f64 * factor).round() as i64;
            self.deposits += scaled(bucket.hits) - bucket.hits;
            *bucket = Bucket { energy: bucket.energy.map(scaled), hits: scaled(bucket.hits) };
        }
    }

    /// The lamp that most hits stem from, and all its light.
    pub(crate) fn usual(&self) -> (usize, Bucket) {
        let lamps = self.pages.iter().map(|pages| pages.len() / 2).max().unwrap_or(0);
        let of_lamp = |lamp: usize| {
            let pages = self.pages.iter().flat_map(|pages| pages.iter().skip(2 * lamp).take(2)).flatten();
            let mut sum = Bucket::default();
            for bucket in pages.flat_map(|page| page.iter()) {
                sum.hits += bucket.hits;
                sum.energy.iter_mut().zip(bucket.energy).for_each(|(sum, energy)| *sum += energy);
            }
            (lamp, sum)
        };
        (0..lamps).map(of_lamp).max_by_key(|(_, sum)| sum.hits).unwrap_or_default()
    }

    /// Sets one bucket.
    pub fn set(&mut self, at: Address, bucket: Bucket) {
        let before = std::mem::replace(&mut self.page(at)[at.cell as usize], bucket);
        self.deposits += bucket.hits - before.hits;
    }

    #[inline]
    fn page(&mut self, at: Address) -> &mut [Bucket] {
        let cells = self.cells[at.object as usize];
        let page = &mut self.pages[at.object as usize][2 * usize::from(at.lamp) + usize::from(at.side)];
        Arc::make_mut(page.get_or_insert_with(|| dark(cells)))
    }

    /// The buckets of all cells of one object, side and lamp; `None` if no light ever arrived.
    pub fn get(&self, object: usize, side: usize, lamp: usize) -> Option<&[Bucket]> {
        self.pages.get(object)?.get(2 * lamp + side)?.as_deref()
    }

    /// Every bucket that is not dark, in order of object, cell, lamp and side.
    pub fn lit(&self) -> impl Iterator<Item = (Address, Bucket)> + '_ {
        (0..self.cells.len()).flat_map(move |object| {
            let pages = &self.pages[object];
            let cells = if pages.iter().any(Option::is_some) { self.cells[object] } else { 0 };
            (0..cells).flat_map(move |cell| {
                pages.iter().enumerate().filter_map(move |(n, page)| {
                    let bucket = page.as_ref()?[cell as usize];
                    let (side, lamp) = ((n % 2) as u8, (n / 2) as u16);
                    (bucket != Bucket::default()).then_some((Address { object: object as u32, cell, side, lamp }, bucket))
                })
            })
        })
    }

    /// Writes every bucket that is not dark as a line of text, in order of object, cell, side and lamp: hits, energy (red, green, blue).
    /// Two solutions are equal if and only if their dumps are.
    pub fn dump(&self, configuration: &Configuration, out: &mut impl Write) -> io::Result<()> {
        writeln!(out, "object\tcell\tside\tlamp\thits\tred\tgreen\tblue")?;
        let object = |at: &Address| configuration.object(at.object as usize).name.as_str();
        let lamp = |at: &Address| configuration.lamp(usize::from(at.lamp)).name.as_str();
        let mut lit: Vec<(Address, Bucket)> = self.lit().collect();
        lit.sort_by(|(a, _), (b, _)| (object(a), a.cell, a.side, lamp(a)).cmp(&(object(b), b.cell, b.side, lamp(b))));
        for (at, bucket) in &lit {
            let side = if at.side == 0 { "front" } else { "back" };
            let [red, green, blue] = bucket.energy;
            writeln!(out, "{}\t{}\t{side}\t{}\t{}\t{red}\t{green}\t{blue}", object(at), at.cell, lamp(at), bucket.hits)?;
        }
        Ok(())
    }

    /// Memory of the pages in use, bytes.
    pub fn bytes(&self) -> usize {
        self.pages.iter().flatten().flatten().map(|p| std::mem::size_of_val::<[Bucket]>(p)).sum()
    }
}

impl PartialEq for Buckets {
    /// Equal light, whatever pages were touched on the way.
    fn eq(&self, other: &Self) -> bool {
        self.lit().eq(other.lit())
    }
}

/// A page without light.
fn dark(cells: u32) -> Arc<[Bucket]> {
    repeat_n(Bucket::default(), cells as usize).collect()
}
