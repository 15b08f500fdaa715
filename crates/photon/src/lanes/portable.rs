//! Plain arrays, for any processor.

use super::{Add, Arithmetic, Div, Double, LANES, Lanes, Mul, One, Sub, operators};

/// Arrays.
#[derive(Debug, Clone, Copy)]
pub struct Portable;

#[inline(always)]
fn each<T>(f: impl FnMut(usize) -> T) -> [T; LANES] {
    std::array::from_fn(f)
}

#[inline(always)]
fn mask(f: impl Fn(usize) -> bool) -> u32 {
    (0..LANES).fold(0, |mask, k| mask | u32::from(f(k)) << k)
}

/// Eight doubles.
#[derive(Debug, Clone, Copy)]
pub struct Doubles([f64; LANES]);

operators!(
    Doubles,
    Add add (a, b) Doubles(each(|k| a.0[k] + b.0[k])),
    Sub sub (a, b) Doubles(each(|k| a.0[k] - b.0[k])),
    Mul mul (a, b) Doubles(each(|k| a.0[k] * b.0[k])),
    Div div (a, b) Doubles(each(|k| a.0[k] / b.0[k]))
);

impl Double for Doubles {
    #[inline(always)]
    fn constant(self, value: f64) -> Doubles {
        Doubles([value; LANES])
    }
    #[inline(always)]
    fn sqrt(self) -> Doubles {
        Doubles(self.0.map(f64::sqrt))
    }
    #[inline(always)]
    fn turned((sin, cos): (Doubles, Doubles), rounded: Doubles) -> (Doubles, Doubles) {
        let pairs: [(f64, f64); LANES] = each(|k| f64::turned((sin.0[k], cos.0[k]), rounded.0[k]));
        (Doubles(pairs.map(|pair| pair.0)), Doubles(pairs.map(|pair| pair.1)))
    }
}

impl Arithmetic for Portable {
    type Numbers = [f32; LANES];
    type Doubles = Doubles;
    type Mask = u32;

    #[inline(always)]
    fn splat(self, x: f32) -> [f32; LANES] {
        [x; LANES]
    }
    #[inline(always)]
    fn add(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        each(|k| a[k] + b[k])
    }
    #[inline(always)]
    fn sub(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        each(|k| a[k] - b[k])
    }
    #[inline(always)]
    fn mul(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        each(|k| a[k] * b[k])
    }
    #[inline(always)]
    fn div(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        each(|k| a[k] / b[k])
    }
    #[inline(always)]
    fn sqrt(self, a: [f32; LANES]) -> [f32; LANES] {
        a.map(f32::sqrt)
    }
    #[inline(always)]
    fn min(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        each(|k| One.min(a[k], b[k]))
    }
    #[inline(always)]
    fn max(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        each(|k| One.max(a[k], b[k]))
    }
    #[inline(always)]
    fn abs(self, a: [f32; LANES]) -> [f32; LANES] {
        a.map(f32::abs)
    }
    #[inline(always)]
    fn negative(self, a: [f32; LANES]) -> [f32; LANES] {
        a.map(|a| -a)
    }
    #[inline(always)]
    fn copysign(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        each(|k| a[k].copysign(b[k]))
    }
    #[inline(always)]
    fn less(self, a: [f32; LANES], b: [f32; LANES]) -> u32 {
        mask(|k| a[k] < b[k])
    }
    #[inline(always)]
    fn at_most(self, a: [f32; LANES], b: [f32; LANES]) -> u32 {
        mask(|k| a[k] <= b[k])
    }
    #[inline(always)]
    fn and(self, a: u32, b: u32) -> u32 {
        a & b
    }
    #[inline(always)]
    fn or(self, a: u32, b: u32) -> u32 {
        a | b
    }
    #[inline(always)]
    fn but_not(self, a: u32, b: u32) -> u32 {
        a & !b
    }
    #[inline(always)]
    fn choose(self, mask: u32, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        each(|k| if mask >> k & 1 != 0 { a[k] } else { b[k] })
    }
    #[inline(always)]
    fn narrow(self, a: Doubles) -> [f32; LANES] {
        a.0.map(|a| a as f32)
    }
}

impl Lanes for Portable {
    #[inline(always)]
    fn load(self, from: &[f32; LANES]) -> [f32; LANES] {
        *from
    }
    #[inline(always)]
    fn load_doubles(self, from: &[f64; LANES]) -> Doubles {
        Doubles(*from)
    }
    #[inline(always)]
    fn store_doubles(self, x: Doubles) -> [f64; LANES] {
        x.0
    }
    #[inline(always)]
    fn store(self, x: [f32; LANES]) -> [f32; LANES] {
        x
    }
    #[inline(always)]
    fn among(self, from: &[u32; LANES], first: u32, count: u32) -> u32 {
        mask(|k| from[k].wrapping_sub(first) < count)
    }
    #[inline(always)]
    fn meet(self, from: [&[u16; 2 * LANES]; 3], to: [&[u16; 2 * LANES]; 3], low: [u16; 3], high: [u16; 3]) -> u32 {
        (0..2 * LANES).fold(0, |bits, k| {
            let inside = (0..3).all(|axis| {
                let (a, b) = (from[axis][k], to[axis][k]);
                a.min(b) <= high[axis] && a.max(b) >= low[axis]
            });
            bits | u32::from(inside || from[0][k].max(to[0][k]) == u16::MAX) << k
        })
    }
    #[inline(always)]
    fn fetch<T>(self, _it: &T) {}
    #[inline(always)]
    fn pack(self, from: &[u16; LANES], bits: u8) -> [u16; LANES] {
        let (mut packed, mut count) = ([0; LANES], 0);
        for (k, number) in from.iter().enumerate() {
            packed[count] = *number;
            count += usize::from(bits >> k & 1 != 0 && count + 1 < LANES);
        }
        packed
    }
    #[inline(always)]
    fn bits(self, a: u32) -> u32 {
        a
    }
    #[inline(always)]
    fn select(self, bits: u32) -> u32 {
        bits
    }
}
