//! The pool of photons and its groups (Dmitriev et al. 2002, §5.1 and Figure 1).
//!
//! With N photons, N_g groups and pilots' ratio R, a group has N_p = ⌊N / (N_g R)⌋ pilots: group *g* holds the pilots
//! [g·N_p, (g+1)·N_p) and the corrective photons i ≥ N_g·N_p with i mod N_g = g. What N leaves over joins its residue class.

use crate::{
    bucket::MOST_DEPOSITS,
    halton::{INDEX_LIMIT, Scrambling, Sequence},
};

/// The index of a photon; its path is a function of it and of the configuration alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PhotonIndex(pub u64);

/// The number of a group of photons.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GroupId(pub u32);

/// A pool that cannot be.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PoolError {
    /// Too few photons for every group to have a pilot and its corrective photons.
    #[error("{photons} photons are too few for {groups} groups with a pilot among {ratio} photons each: at least {} are needed", *groups as u64 * *ratio as u64)]
    TooSmall {
        /// N.
        photons: u64,
        /// N_g.
        groups: u32,
        /// R.
        ratio: u32,
    },
    /// More photons than buckets can count.
    #[error("{0} photons are too many: the limit is {MOST_DEPOSITS}")]
    TooLarge(u64),
    /// No groups or no photons in them.
    #[error("the number of groups and the pilots' ratio must be at least 1")]
    Empty,
    /// A number of copies that cannot be.
    #[error("{0} copies of the sequence: they must be 1, 2, 4, … 64, and scrambled if there are several")]
    Copies(u32),
}

/// How many photons there are, and how they are grouped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pool {
    photons: u64,
    groups: u32,
    ratio: u32,
    /// log₂ of the copies of the sequence.
    shift: u32,
    /// N_p in each copy.
    pilots: u64,
    /// How the sequence is scrambled.
    pub scrambling: Scrambling,
}

impl Pool {
    /// A pool of `photons`, in `groups` = N_g (a product of powers of the first primes, Eq. 5; higher: tighter groups, worse found
    /// by pilots; 288 = 2⁵·3² by default), with one pilot among `ratio` = R photons (lower: more is known before corrective
    /// photons are shot, but the coherent ones come later; 16 by default).
    pub fn new(photons: u64, groups: u32, ratio: u32, scrambling: Scrambling) -> Result<Pool, PoolError> {
        if groups == 0 || ratio == 0 {
            return Err(PoolError::Empty);
        }
        if photons > MOST_DEPOSITS as u64 {
            return Err(PoolError::TooLarge(photons));
        }
        let pilots = photons / (u64::from(groups) * u64::from(ratio));
        if pilots == 0 {
            return Err(PoolError::TooSmall { photons, groups, ratio });
        }
        Ok(Pool { photons, groups, ratio, shift: 0, pilots, scrambling })
    }

    /// The same photons in so many copies of the sequence (1, 2, 4, … 64), each with permutations of its own: their spread tells the
    /// error. More copies: a better estimate of the error, a little more noise.
    pub fn in_copies(self, copies: u32) -> Result<Pool, PoolError> {
        if !copies.is_power_of_two() || copies > 64 || (copies > 1 && self.scrambling == Scrambling::None) {
            return Err(PoolError::Copies(copies));
        }
        let Pool { photons, groups, ratio, .. } = self;
        let pilots = photons / (u64::from(groups) * u64::from(ratio) * u64::from(copies));
        if pilots == 0 {
            return Err(PoolError::TooSmall { photons, groups, ratio: ratio * copies });
        }
        Ok(Pool { shift: copies.ilog2(), pilots, ..self })
    }

    /// M, the copies of the sequence.
    pub fn copies(&self) -> u32 {
        1 << self.shift
    }

    /// M, and N_g where it matters to the sequence: what a saved solution must agree in.
    pub fn copies_and_groups(&self) -> [u32; 2] {
        [self.copies(), if self.shift == 0 { 1 } else { self.groups }]
    }

    /// The random numbers of its photons.
    pub fn sequence(&self) -> Sequence {
        Sequence::of_copies(self.scrambling, self.shift, self.groups)
    }

    /// The same groups with only the first `photons` photons; `None` if those are less than the pilots.
    pub fn shrunk(self, photons: u64) -> Option<Pool> {
        (photons >= self.all_pilots() << self.shift).then_some(Pool { photons: photons.min(self.photons), ..self })
    }

    /// As many groups and copies and the same share of pilots with another number of photons.
    pub fn resized(self, photons: u64) -> Result<Pool, PoolError> {
        Pool::new(photons, self.groups, self.ratio, self.scrambling)?.in_copies(self.copies())
    }

    /// The same pilots with more corrective photons, `photons` in all.
    pub fn grown(self, photons: u64) -> Pool {
        Pool { photons: photons.clamp(self.photons, INDEX_LIMIT), ..self }
    }

    /// N.
    pub fn photons(&self) -> u64 {
        self.photons
    }

    /// N_g.
    pub fn groups(&self) -> u32 {
        self.groups
    }

    /// N_p of all copies together, pilots per group.
    pub fn pilots_per_group(&self) -> u64 {
        self.pilots << self.shift
    }

    /// Pilots of one copy; its first points.
    fn all_pilots(&self) -> u64 {
        self.pilots * u64::from(self.groups)
    }

    /// Whether a photon is a pilot.
    pub fn is_pilot(&self, photon: PhotonIndex) -> bool {
        photon.0 >> self.shift < self.all_pilots()
    }

    /// The group whose corrective photons resemble this one: i mod N_g (Eq. 6), with i counted in the photon's copy.
    pub fn resembled(&self, photon: PhotonIndex) -> GroupId {
        GroupId(((photon.0 >> self.shift) % u64::from(self.groups)) as u32)
    }

    /// How many photons group `g` has.
    pub fn photons_in(&self, g: GroupId) -> u64 {
        let correctives = |copy: u64| {
            let points = (self.photons - copy).div_ceil(1 << self.shift);
            points.saturating_sub(self.all_pilots() + u64::from(g.0)).div_ceil(u64::from(self.groups))
        };
        self.pilots_per_group() + (0..1u64 << self.shift).map(correctives).sum::<u64>()
    }

    /// The photons of group `g`: copy by copy, its pilots, then its corrective photons.
    pub fn photons_of(&self, g: GroupId) -> impl Iterator<Item = PhotonIndex> + '_ {
        let (groups, g) = (u64::from(self.groups), u64::from(g.0));
        (0..1u64 << self.shift).flat_map(move |copy| {
            let points = (self.photons - copy).div_ceil(1 << self.shift);
            let pilots = g * self.pilots..(g + 1) * self.pilots;
            // N_g·N_p is a multiple of N_g, so the first corrective photon of residue g is N_g·N_p + g.
            let correctives = (self.all_pilots() + g..points).step_by(groups as usize);
            pilots.chain(correctives).map(move |point| PhotonIndex(point << self.shift | copy))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figure_1_of_the_seed() {
        // Ng = 4 groups (Figure 1): with Np = 2 and R = 3, group 1 holds pilots 2, 3 and correctives 9, 13, 17, 21.
        let pool = Pool::new(24, 4, 3, Scrambling::None).unwrap();
        let group = |g| pool.photons_of(GroupId(g)).map(|i| i.0).collect::<Vec<_>>();
        assert_eq!(group(0), [0, 1, 8, 12, 16, 20]);
        assert_eq!(group(1), [2, 3, 9, 13, 17, 21]);
        assert_eq!(group(2), [4, 5, 10, 14, 18, 22]);
        assert_eq!(group(3), [6, 7, 11, 15, 19, 23]);
        assert!(pool.is_pilot(PhotonIndex(7)) && !pool.is_pilot(PhotonIndex(8)));
        assert_eq!(pool.resembled(PhotonIndex(7)), GroupId(3));
    }

    #[test]
    fn every_photon_is_in_one_group() {
        let pools = [(1000, 6, 4, 1), (1001, 6, 4, 2), (999, 10, 7, 8), (50_003, 288, 4, 16), (10, 10, 1, 1), (13, 10, 1, 1)];
        for (photons, groups, ratio, copies) in pools {
            let pool = Pool::new(photons, groups, ratio, Scrambling::Seed(1)).unwrap().in_copies(copies).unwrap();
            let mut seen: Vec<u64> =
                (0..groups).flat_map(|g| pool.photons_of(GroupId(g)).map(|i| i.0).collect::<Vec<_>>()).collect();
            seen.sort_unstable();
            assert!(seen.into_iter().eq(0..photons), "{photons} in {groups}");
            assert!((0..groups).map(GroupId).all(|g| pool.photons_in(g) == pool.photons_of(g).count() as u64));
        }
    }

    #[test]
    fn too_small_pools_say_what_they_need() {
        let error = Pool::new(4607, 288, 16, Scrambling::None).unwrap_err();
        assert!(error.to_string().ends_with("at least 4608 are needed"));
        assert!(Pool::new(4608, 288, 16, Scrambling::None).is_ok());
    }
}
