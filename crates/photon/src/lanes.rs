//! Eight numbers at once: AVX2 where the processor has it, plain arrays elsewhere, with the same bits; or one number.
//!
//! All round every operation by itself; there is no fused multiply-add, which older machines would have to imitate.
//! What is written once over [`Lanes`] is compiled twice, and [`widest`] chooses when it runs. What is written over [`Arithmetic`] serves one
//! number ([`One`]) as well.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod portable;

use lightmend_scene::trig::Double;
pub use portable::Portable;
use std::ops::{Add, Div, Mul, Sub};

/// Operators of doubles: not closures, which are not sure to be inlined, and then every operation is a call.
macro_rules! operators {
    ($doubles:ty, $($operator:ident $name:ident ($a:ident, $b:ident) $body:expr),+) => {
        $(impl $operator for $doubles {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let ($a, $b) = (self, other);
                $body
            }
        })+
    };
}
use operators;

/// How many.
pub const LANES: usize = 8;

/// Arithmetic on one number or several side by side.
pub trait Arithmetic: Copy {
    /// The numbers.
    type Numbers: Copy;
    /// As many of twice the length.
    type Doubles: Double;
    /// A truth per number.
    type Mask: Copy;

    /// The same number for all.
    fn splat(self, x: f32) -> Self::Numbers;
    /// a + b
    fn add(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// a - b
    fn sub(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// a · b
    fn mul(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// a / b
    fn div(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// √a
    fn sqrt(self, a: Self::Numbers) -> Self::Numbers;
    /// The smaller; b if one is not a number.
    fn min(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// The larger; b if one is not a number.
    fn max(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// |a|
    fn abs(self, a: Self::Numbers) -> Self::Numbers;
    /// -a
    fn negative(self, a: Self::Numbers) -> Self::Numbers;
    /// |a| with the sign of b
    fn copysign(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// a < b
    fn less(self, a: Self::Numbers, b: Self::Numbers) -> Self::Mask;
    /// a ≤ b
    fn at_most(self, a: Self::Numbers, b: Self::Numbers) -> Self::Mask;
    /// a and b
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// a or b
    fn or(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// a and not b
    fn but_not(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// a where the mask is, b elsewhere.
    fn choose(self, mask: Self::Mask, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// Rounded.
    fn narrow(self, a: Self::Doubles) -> Self::Numbers;
}

/// [`Arithmetic`] on [`LANES`] numbers, from memory and back.
pub trait Lanes: Arithmetic {
    /// Vectors from memory.
    #[inline(always)]
    fn load_vectors(self, from: &[[f32; LANES]; 3]) -> [Self::Numbers; 3] {
        [self.load(&from[0]), self.load(&from[1]), self.load(&from[2])]
    }
    /// Vectors to memory.
    #[inline(always)]
    fn store_vectors(self, [x, y, z]: [Self::Numbers; 3]) -> [[f32; LANES]; 3] {
        [self.store(x), self.store(y), self.store(z)]
    }
    /// From memory.
    fn load(self, from: &[f32; LANES]) -> Self::Numbers;
    /// Doubles from memory.
    fn load_doubles(self, from: &[f64; LANES]) -> Self::Doubles;
    /// Doubles to memory.
    fn store_doubles(self, x: Self::Doubles) -> [f64; LANES];
    /// To memory.
    fn store(self, x: Self::Numbers) -> [f32; LANES];
    /// Whether whole numbers in memory are among the `count` ones from `first` on; `count` is at least 1.
    fn among(self, from: &[u32; LANES], first: u32, count: u32) -> Self::Mask;
    /// Which of sixteen boxes between two points each meet the box between two corners, or reach out of all whole numbers along their first axis: a bit each.
    fn meet(self, from: [&[u16; 2 * LANES]; 3], to: [&[u16; 2 * LANES]; 3], low: [u16; 3], high: [u16; 3]) -> u32;
    /// Bit k for number k.
    fn bits(self, a: Self::Mask) -> u32;
    /// The other way round.
    fn select(self, bits: u32) -> Self::Mask;
    /// Those of eight whole numbers whose bits are set, in order; what follows them is anything.
    fn pack(self, from: &[u16; LANES], bits: u8) -> [u16; LANES];
    /// Asks for something that may be read soon. A hint: it changes nothing.
    fn fetch<T>(self, it: &T);
}

/// The scalar products of vectors, coordinate by coordinate.
#[inline(always)]
pub fn dots<A: Arithmetic>(a: A, [px, py, pz]: [A::Numbers; 3], [qx, qy, qz]: [A::Numbers; 3]) -> A::Numbers {
    a.add(a.add(a.mul(px, qx), a.mul(py, qy)), a.mul(pz, qz))
}

/// Vectors times numbers.
#[inline(always)]
pub fn scaled<A: Arithmetic>(a: A, [x, y, z]: [A::Numbers; 3], by: A::Numbers) -> [A::Numbers; 3] {
    [a.mul(x, by), a.mul(y, by), a.mul(z, by)]
}

/// One number.
#[derive(Debug, Clone, Copy)]
pub struct One;

impl Arithmetic for One {
    type Numbers = f32;
    type Doubles = f64;
    type Mask = bool;

    #[inline(always)]
    fn splat(self, x: f32) -> f32 {
        x
    }
    #[inline(always)]
    fn add(self, a: f32, b: f32) -> f32 {
        a + b
    }
    #[inline(always)]
    fn sub(self, a: f32, b: f32) -> f32 {
        a - b
    }
    #[inline(always)]
    fn mul(self, a: f32, b: f32) -> f32 {
        a * b
    }
    #[inline(always)]
    fn div(self, a: f32, b: f32) -> f32 {
        a / b
    }
    #[inline(always)]
    fn sqrt(self, a: f32) -> f32 {
        a.sqrt()
    }
    #[inline(always)]
    fn min(self, a: f32, b: f32) -> f32 {
        if a < b { a } else { b }
    }
    #[inline(always)]
    fn max(self, a: f32, b: f32) -> f32 {
        if a > b { a } else { b }
    }
    #[inline(always)]
    fn abs(self, a: f32) -> f32 {
        a.abs()
    }
    #[inline(always)]
    fn negative(self, a: f32) -> f32 {
        -a
    }
    #[inline(always)]
    fn copysign(self, a: f32, b: f32) -> f32 {
        a.copysign(b)
    }
    #[inline(always)]
    fn less(self, a: f32, b: f32) -> bool {
        a < b
    }
    #[inline(always)]
    fn at_most(self, a: f32, b: f32) -> bool {
        a <= b
    }
    #[inline(always)]
    fn and(self, a: bool, b: bool) -> bool {
        a & b
    }
    #[inline(always)]
    fn or(self, a: bool, b: bool) -> bool {
        a | b
    }
    #[inline(always)]
    fn but_not(self, a: bool, b: bool) -> bool {
        a & !b
    }
    #[inline(always)]
    fn choose(self, mask: bool, a: f32, b: f32) -> f32 {
        if mask { a } else { b }
    }
    #[inline(always)]
    fn narrow(self, a: f64) -> f32 {
        a as f32
    }
}

/// Something that is done the faster the wider the lanes are.
pub trait Task {
    /// Its result.
    type Output;
    /// Does it. To be inlined always, with everything below it, into code that may use these lanes: a closure that computes with them
    /// is not sure to be, and then every operation is a call.
    fn run<L: Lanes>(self, lanes: L) -> Self::Output;
}

/// Does a task with the widest lanes of this machine.
#[inline]
#[allow(unsafe_code)]
pub fn widest<T: Task>(task: T) -> T::Output {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has what the function was compiled for.
        return unsafe { avx2::run(task) };
    }
    task.run(Portable)
}
