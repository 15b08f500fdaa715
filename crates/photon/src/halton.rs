//! The Halton sequence with exact integer numerators, plain or with permuted digits.
//!
//! Dmitriev et al. 2002, §4.1: photon *i* takes its random numbers from the radical inverses Φ₂(i), Φ₃(i), Φ₅(i), … (Eq. 1, 2).
//! Φ_b(i) = m / b^K with an integer m; m is summed from tables of a few digits each, and only then divided, so that two values
//! are equal only if they are, and elementary intervals are exact (Eq. 3).
//! Permuting each digit (a random permutation per base and position) keeps the periodicity of Eq. 3, unlike a random shift.
//! Dimensions past [`DIMENSIONS`] are padded with a hash of (index, dimension): so deep in a path stratification buys nothing.

use crate::hash::mix;

/// Dimensions that come from the Halton sequence; the largest base is the 64th prime, 311.
pub const DIMENSIONS: usize = 64;

/// Photon indices stay below this, so that every numerator is exact in 53 bits.
pub const INDEX_LIMIT: u64 = 1 << 42;

/// The longest table, entries.
const TABLE: u64 = 1024;

/// How the digits of the sequence are permuted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scrambling {
    /// The sequence as the seed paper uses it.
    None,
    /// Every digit of every base by a permutation of its own, drawn from this seed.
    Seed(u64),
}

/// Runs of digits that an index has at most: 42 bits in base 37, digit by digit.
const RUNS: usize = 9;

/// The radical inverse in one base.
#[derive(Debug)]
pub struct RadicalInverse {
    /// b^d, where d digits are looked up at once.
    step: u64,
    /// ⌈2⁶⁴ / b^d⌉: multiplying by it divides (Granlund, Montgomery 1994), exactly as long as index · step < 2⁶⁴.
    reciprocal: u64,
    /// For each run of d digits, what its value becomes: reversed and permuted. As small as can be, since the tables of all dimensions and copies
    /// share the caches with the scene; [`step`](Self::step) entries a run.
    reversed: Box<[u16]>,
    /// What a reversed run of digits counts in the numerator.
    weights: [u64; RUNS],
    /// What all the runs from this one on add when they are zero.
    rest: [u64; RUNS + 1],
    /// b^K.
    denominator: u64,
}

impl RadicalInverse {
    /// The radical inverse in `base` (a prime).
    pub fn new(base: u64, scrambling: Scrambling) -> RadicalInverse {
        RadicalInverse::of_copy(base, scrambling, 0, 0)
    }

    /// As [`new`](Self::new), for one of several copies that share the permutations of the first `shared` digits.
    fn of_copy(base: u64, scrambling: Scrambling, copy: u64, shared: u32) -> RadicalInverse {
        let (mut digits, mut denominator) = (0u32, 1u64);
        while denominator < INDEX_LIMIT {
            denominator *= base;
            digits += 1;
        }
        let mut run = 1;
        while base.pow(run + 1) <= TABLE {
            run += 1;
        }
        let step = base.pow(run);
        let runs = digits.div_ceil(run) as usize;
        let (mut reversed, mut weights, mut rest) = (Vec::with_capacity(runs * step as usize), [0; RUNS], [0; RUNS + 1]);
        for (n, first) in (0..digits).step_by(run as usize).enumerate() {
            let positions: Vec<u32> = (first..digits.min(first + run)).collect();
            let permutations: Vec<Vec<u64>> =
                positions.iter().map(|p| permutation(base, *p, scrambling, if *p < shared { 0 } else { copy })).collect();
            let reverse = |mut value: u64| {
                permutations.iter().fold(0, |sum, permutation| {
                    let digit = permutation[(value % base) as usize];
                    value /= base;
                    sum * base + digit
                })
            };
            reversed.extend((0..step).map(|value| reverse(value) as u16));
            weights[n] = base.pow(digits - first - positions.len() as u32);
        }
        for n in (0..runs).rev() {
            rest[n] = rest[n + 1] + u64::from(reversed[n * step as usize]) * weights[n];
        }
        RadicalInverse { step, reciprocal: u64::MAX / step + 1, reversed: reversed.into(), weights, rest, denominator }
    }

    /// m in Φ_b(i) = m / [`denominator`](Self::denominator).
    #[inline(always)]
    pub fn numerator(&self, mut index: u64) -> u64 {
        let (mut sum, mut run, mut table) = (0, 0, 0);
        while index > 0 {
            let quotient = ((u128::from(index) * u128::from(self.reciprocal)) >> 64) as u64;
            sum += u64::from(self.reversed[table + (index - quotient * self.step) as usize]) * self.weights[run];
            index = quotient;
            table += self.step as usize;
            run += 1;
        }
        sum + self.rest[run]
    }

    /// b^K, below 2^53.
    pub fn denominator(&self) -> u64 {
        self.denominator
    }

    /// Φ_b(i), correctly rounded, in [0, 1).
    #[inline(always)]
    pub fn value(&self, index: u64) -> f64 {
        let [numerator, denominator] = self.fraction(index);
        numerator / denominator
    }

    /// [`value`](Self::value) before it is divided.
    #[inline(always)]
    fn fraction(&self, index: u64) -> [f64; 2] {
        // Below 2⁵³; converting signed numbers is one instruction.
        [self.numerator(index), self.denominator].map(|number| number as i64 as f64)
    }
}

fn permutation(base: u64, position: u32, scrambling: Scrambling, copy: u64) -> Vec<u64> {
    let mut digits: Vec<u64> = (0..base).collect();
    if let Scrambling::Seed(seed) = scrambling {
        let mut state = mix(seed ^ mix(copy << 48 | base << 32 | u64::from(position)));
        for i in (1..base).rev() {
            state = mix(state);
            // The bias of a remainder of 64 bits by at most 311 is below 1e-16.
            digits.swap(i as usize, (state % (i + 1)) as usize);
        }
    }
    digits
}

/// The random numbers of all photons: copies of the Halton sequence, one radical inverse per dimension, then the hash.
///
/// Photon i is point i / M of copy i mod M. Each copy has its own permutations, so that the spread over copies tells the error; but
/// those of the digits that a group of photons fixes are shared, so that a group is the same elementary interval in every copy.
#[derive(Debug)]
pub struct Sequence {
    /// [`DIMENSIONS`] of each copy.
    inverses: Vec<RadicalInverse>,
    /// log₂ of the number of copies.
    shift: u32,
    padding: u64,
}

impl Sequence {
    /// One copy of the Halton sequence in the first [`DIMENSIONS`] primes.
    pub fn new(scrambling: Scrambling) -> Sequence {
        Sequence::of_copies(scrambling, 0, 1)
    }

    /// 2^`shift` copies, whose groups are residue classes modulo `groups`.
    pub fn of_copies(scrambling: Scrambling, shift: u32, groups: u32) -> Sequence {
        let power_in_groups = |base: u64| (0..).take_while(|k| u64::from(groups) % base.pow(k + 1) == 0).count() as u32;
        let bases: Vec<u64> = primes().take(DIMENSIONS).collect();
        let inverse = |copy, base: &u64| RadicalInverse::of_copy(*base, scrambling, copy, power_in_groups(*base));
        let inverses = (0..1 << shift).flat_map(|copy| bases.iter().map(move |base| inverse(copy, base))).collect();
        let padding = match scrambling {
            Scrambling::None => 0,
            Scrambling::Seed(seed) => mix(seed),
        };
        Sequence { inverses, shift, padding }
    }

    /// How many copies of the sequence there are.
    pub fn copies(&self) -> u32 {
        1 << self.shift
    }

    /// Number `dimension` of photon `index`, in [0, 1).
    #[inline(always)]
    pub fn value(&self, index: u64, dimension: usize) -> f64 {
        let [numerator, denominator] = self.fraction(index, dimension);
        numerator / denominator
    }

    /// [`value`](Self::value) as a fraction: several can then be divided at once.
    #[inline(always)]
    pub fn fraction(&self, index: u64, dimension: usize) -> [f64; 2] {
        if dimension < DIMENSIONS {
            let copy = (index & ((1 << self.shift) - 1)) as usize;
            return self.inverses[copy * DIMENSIONS + dimension].fraction(index >> self.shift);
        }
        [(mix(mix(index ^ self.padding) ^ dimension as u64) >> 11) as f64, (1u64 << 53) as f64]
    }
}

/// The prime numbers.
pub fn primes() -> impl Iterator<Item = u64> {
    (2u64..).filter(|n| (2..).take_while(|d| d * d <= *n).all(|d| n % d != 0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_halton_crate() {
        // Its `number` is sound, its iterator is not: it ends after 1,048,575 values. See the README.
        use rayon::prelude::*;
        let bases: Vec<u64> = primes().take_while(|p| *p <= 97).collect();
        bases.into_par_iter().for_each(|base| {
            let inverse = RadicalInverse::new(base, Scrambling::None);
            for i in 0..10_000_000 {
                let oracle = halton::number(base as u8, i);
                assert!((inverse.value(i as u64) - oracle).abs() <= 5e-16, "base {base}, index {i}");
            }
        });
    }

    #[test]
    fn numerators_are_exact_beyond_32_bits() {
        for base in [2u64, 3, 5, 7, 97, 311] {
            let inverse = RadicalInverse::new(base, Scrambling::None);
            for i in [0, 1, base, (1 << 32) - 1, 1 << 32, (1 << 32) + 12_345, INDEX_LIMIT - 1] {
                let (mut rest, mut numerator, mut denominator) = (i, 0u128, 1u128);
                while rest > 0 {
                    numerator = numerator * u128::from(base) + u128::from(rest % base);
                    denominator *= u128::from(base);
                    rest /= base;
                }
                let (n, d) = (u128::from(inverse.numerator(i)), u128::from(inverse.denominator()));
                assert_eq!(n * denominator, numerator * d, "base {base}, index {i}");
                // The f64 is the correctly rounded quotient: half a unit in the last place of n / d.
                let value = inverse.value(i);
                let (below, above) = (value.next_down(), value.next_up());
                let scale = d as f64;
                assert!(below * scale <= n as f64 && n as f64 <= above * scale && value < 1.0);
            }
        }
    }

    #[test]
    fn scrambled_digits_are_permutations() {
        for base in [2u64, 3, 5, 7, 13] {
            let plain = RadicalInverse::new(base, Scrambling::None);
            let scrambled = RadicalInverse::new(base, Scrambling::Seed(7));
            let count = base.pow(3);
            let cell = |r: &RadicalInverse, i| r.numerator(i) / (r.denominator() / count);
            let mut cells: Vec<u64> = (0..count).map(|i| cell(&scrambled, i)).collect();
            assert_ne!(cells, (0..count).map(|i| cell(&plain, i)).collect::<Vec<_>>());
            cells.sort_unstable();
            assert!(cells.iter().copied().eq(0..count), "every elementary interval once");
        }
    }

    #[test]
    fn groups_are_elementary_intervals() {
        // Dmitriev et al. 2002, Eq. 3: photons i and i + m·Ng agree to within b^-k in base b, for every group.
        for scrambling in [Scrambling::None, Scrambling::Seed(11)] {
            for (groups, powers) in [(288u64, vec![(2u64, 5u32), (3, 2)]), (10_080, vec![(2, 5), (3, 2), (5, 1), (7, 1)])] {
                for (base, power) in powers {
                    let inverse = RadicalInverse::new(base, scrambling);
                    let interval = inverse.denominator() / base.pow(power);
                    for group in 0..groups {
                        let first = inverse.numerator(group);
                        for m in 1..40 {
                            let other = inverse.numerator(group + m * groups);
                            assert_eq!(first / interval, other / interval, "group {group} of {groups}, base {base}");
                            assert!(first.abs_diff(other) < interval, "Eq. 3");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn copies_differ_and_share_their_groups() {
        let sequence = Sequence::of_copies(Scrambling::Seed(3), 4, 288);
        for dimension in 0..4 {
            for group in [0, 7, 287] {
                let values: Vec<f64> = (0..16).map(|copy| sequence.value(((group + 288 * 5) << 4) | copy, dimension)).collect();
                let spans = [32.0, 9.0, 1.0, 1.0];
                let cell = |v: &f64| (v * spans[dimension]).floor();
                assert!(values.iter().all(|v| cell(v) == cell(&values[0])), "one elementary interval: {values:?}");
                assert!(values.windows(2).any(|v| v[0] != v[1]), "copies differ");
            }
        }
        let one = Sequence::of_copies(Scrambling::Seed(3), 0, 288);
        assert!((0..1000).all(|i| one.value(i, 2) == sequence.value(i << 4, 2)), "the first copy is the sequence itself");
    }

    #[test]
    fn padding_is_uniform() {
        let sequence = Sequence::new(Scrambling::None);
        let mean = (0..100_000).map(|i| sequence.value(i, DIMENSIONS + 3)).sum::<f64>() / 1e5;
        assert!((mean - 0.5).abs() < 4.0 / (12e5f64).sqrt());
    }
}
