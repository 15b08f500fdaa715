//! A solution as a file: written after it was shot, and shot on later, to the same bits as in one go.
//!
//! Little-endian: magic, version, the scene's content hash, seed of the scrambling (0: none), copies, which first hits deposit, photons shot;
//! the tally of each lamp and every bucket that is not dark, objects and lamps numbered in order of their names; a hash of all that.
//! Dimming and switching lamps leaves a file valid: they are read-out only.

use crate::{
    bucket::{Address, Bucket, Buckets, ENERGY_BITS},
    halton::Scrambling,
    path::FirstHits,
    record::Tally,
};
use lightmend_scene::Configuration;
use std::{
    collections::BTreeMap,
    io::{self, Write},
};

const MAGIC: &[u8; 8] = b"lightmnd";
const VERSION: u64 = 1;

/// Light that was shot before.
#[derive(Debug, Clone, PartialEq)]
pub struct Saved {
    /// The sequence it was shot with.
    pub scrambling: Scrambling,
    /// Its copies, and the groups that they share digits for; no matter if there is one.
    pub copies: [u32; 2],
    /// Which hits deposited.
    pub first_hits: FirstHits,
    /// Photons shot, the first ones of the sequence.
    pub photons: u64,
    /// The light.
    pub buckets: Buckets,
    /// How paths ended, by lamp.
    pub tallies: Vec<Tally>,
}

/// A file that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SavedError {
    /// Not such a file, or not whole.
    #[error("not a saved solution of this version of Lightmend, or damaged; solve again")]
    Damaged,
    /// Another scene's.
    #[error("it was solved for another scene, or the scene has changed since; solve again")]
    OtherScene,
}

/// Numbers of objects or lamps in order of their names.
fn by_name<'n>(things: impl Iterator<Item = (usize, &'n str)>) -> Vec<usize> {
    let sorted: BTreeMap<&str, usize> = things.map(|(id, name)| (name, id)).collect();
    sorted.into_values().collect()
}

fn objects(configuration: &Configuration) -> Vec<usize> {
    by_name(configuration.objects().map(|(id, object)| (id, object.name.as_str())))
}

fn lamps(configuration: &Configuration) -> Vec<usize> {
    by_name(configuration.lamps().map(|(id, lamp)| (id, lamp.name.as_str())))
}

impl Saved {
    /// Writes the file.
    pub fn write(&self, configuration: &Configuration, out: &mut impl Write) -> io::Result<()> {
        let mut bytes = Vec::new();
        bytes.extend_from_slice(MAGIC);
        let seed = if let Scrambling::Seed(seed) = self.scrambling { seed } else { 0 };
        let first_hits = match self.first_hits {
            FirstHits::AsLampsSay => 0,
            FirstHits::Never => 1,
            FirstHits::Always => 2,
        };
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend_from_slice(&configuration.content_hash());
        let copies = u64::from(self.copies[0]) << 32 | u64::from(self.copies[1]);
        for value in [seed, copies, first_hits, self.photons] {
            bytes.extend(value.to_le_bytes());
        }
        let (objects, lamps) = (objects(configuration), lamps(configuration));
        for lamp in &lamps {
            let Tally { absorbed, escaped, cut, escaped_energy, cut_energy } = self.tallies[*lamp];
            for value in [absorbed, escaped, cut].into_iter().chain(escaped_energy).chain(cut_energy) {
                bytes.extend(value.to_le_bytes());
            }
        }
        let object_place: BTreeMap<u32, u32> = objects.iter().zip(0..).map(|(id, place)| (*id as u32, place)).collect();
        let lamp_place: BTreeMap<u16, u16> = lamps.iter().zip(0..).map(|(id, place)| (*id as u16, place)).collect();
        bytes.extend((self.buckets.lit().count() as u64).to_le_bytes());
        for (at, bucket) in self.buckets.lit() {
            bytes.extend(object_place[&at.object].to_le_bytes());
            bytes.extend(at.cell.to_le_bytes());
            bytes.extend(lamp_place[&at.lamp].to_le_bytes());
            bytes.push(at.side);
            for value in bucket.energy.into_iter().chain([bucket.hits]) {
                bytes.extend(value.to_le_bytes());
            }
        }
        out.write_all(&bytes)?;
        out.write_all(blake3::hash(&bytes).as_bytes())
    }

    /// Reads a file that was written for `configuration`.
    pub fn read(bytes: &[u8], configuration: &Configuration) -> Result<Saved, SavedError> {
        let (bytes, hash) = bytes.split_last_chunk::<32>().ok_or(SavedError::Damaged)?;
        let mut input = Input(bytes);
        if input.take()? != *MAGIC || input.number()? != VERSION || *blake3::hash(bytes).as_bytes() != *hash {
            return Err(SavedError::Damaged);
        }
        if input.take::<32>()? != configuration.content_hash() {
            return Err(SavedError::OtherScene);
        }
        let scrambling = match input.number()? {
            0 => Scrambling::None,
            seed => Scrambling::Seed(seed),
        };
        let copies = input.number()?;
        let copies = [(copies >> 32) as u32, copies as u32];
        let first_hits = match input.number()? {
            0 => FirstHits::AsLampsSay,
            1 => FirstHits::Never,
            2 => FirstHits::Always,
            _ => return Err(SavedError::Damaged),
        };
        let photons = input.number()?;
        let (objects, lamps) = (objects(configuration), lamps(configuration));
        let mut tallies = vec![Tally::default(); configuration.lamp_slots()];
        for lamp in &lamps {
            let mut values = [0; 9];
            for value in &mut values {
                *value = input.number()? as i64;
            }
            let [absorbed, escaped, cut, a, b, c, d, e, f] = values;
            tallies[*lamp] = Tally { absorbed, escaped, cut, escaped_energy: [a, b, c], cut_energy: [d, e, f] };
        }
        let mut buckets = Buckets::new(configuration);
        for _ in 0..input.number()? {
            let object = *objects.get(u32::from_le_bytes(input.take()?) as usize).ok_or(SavedError::Damaged)?;
            let cell = u32::from_le_bytes(input.take()?);
            let lamp = *lamps.get(usize::from(u16::from_le_bytes(input.take()?))).ok_or(SavedError::Damaged)?;
            let [side] = input.take()?;
            let energy = [input.number()? as i64, input.number()? as i64, input.number()? as i64];
            let bucket = Bucket { energy, hits: input.number()? as i64 };
            // Each hit brings at most a whole photon: what was shot always fits.
            let counted = bucket.hits >= 0
                && buckets.admit(bucket.hits).is_ok()
                && bucket.energy.iter().all(|energy| (0..=bucket.hits << ENERGY_BITS).contains(energy));
            if side > 1 || cell >= configuration.object(object).lattice.cells() || !counted {
                return Err(SavedError::Damaged);
            }
            buckets.set(Address { object: object as u32, cell, side, lamp: lamp as u16 }, bucket);
        }
        if !input.0.is_empty() {
            return Err(SavedError::Damaged);
        }
        Ok(Saved { scrambling, copies, first_hits, photons, buckets, tallies })
    }
}

/// Bytes not yet read.
struct Input<'a>(&'a [u8]);

impl Input<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], SavedError> {
        let (taken, rest) = self.0.split_first_chunk().ok_or(SavedError::Damaged)?;
        self.0 = rest;
        Ok(*taken)
    }

    fn number(&mut self) -> Result<u64, SavedError> {
        self.take().map(u64::from_le_bytes)
    }
}
