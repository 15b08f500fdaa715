//! Independent random numbers for estimates at points; photons take theirs from the Halton sequence.

use rand_xoshiro::{
    Xoshiro256PlusPlus,
    rand_core::{Rng, SeedableRng},
};

/// A stream of numbers that is named by what it is for and some integers: other names, other streams.
pub(crate) struct Random(Xoshiro256PlusPlus);

impl Random {
    pub(crate) fn new<const N: usize>(purpose: &str, numbers: [u64; N]) -> Random {
        let mut hasher = blake3::Hasher::new();
        for number in numbers {
            hasher.update(&number.to_le_bytes());
        }
        hasher.update(purpose.as_bytes());
        Random(Xoshiro256PlusPlus::from_seed(*hasher.finalize().as_bytes()))
    }

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_differ_by_purpose_and_by_every_number() {
        let first = |purpose, a, b, c| Random::new(purpose, [a, b, c]).unit().to_bits();
        let mut all = vec![first("", 0, 0, 0), first("", 1, 0, 0), first("", 0, 1, 0), first("", 0, 0, 1), first("", 1, 1, 0)];
        all.extend([first("", 0, 1, 1), first("paths", 0, 0, 0), first("gather", 0, 0, 0)]);
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 8);
    }
}
