//! Eight numbers at once: AVX2 where the processor has it, plain arrays elsewhere, with the same bits.
//!
//! Both round every operation by itself; there is no fused multiply-add, which older machines would have to imitate.
//! What is written once over [`Lanes`] is compiled twice, and [`widest`] chooses when it runs.

/// How many.
pub const LANES: usize = 8;

/// A way to compute with [`LANES`] numbers at once.
pub trait Lanes: Copy {
    /// The numbers.
    type Numbers: Copy;
    /// A truth per number.
    type Mask: Copy;

    /// One number, eight times.
    fn splat(self, x: f32) -> Self::Numbers;
    /// From memory.
    fn load(self, from: &[f32; LANES]) -> Self::Numbers;
    /// From whole numbers in memory.
    fn widen(self, from: &[u16; LANES]) -> Self::Numbers;
    /// To memory.
    fn store(self, x: Self::Numbers) -> [f32; LANES];
    /// a + b
    fn add(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// a - b
    fn sub(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// a · b
    fn mul(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// a / b
    fn div(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// The smaller; b if one is not a number.
    fn min(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// The larger; b if one is not a number.
    fn max(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// |a|
    fn abs(self, a: Self::Numbers) -> Self::Numbers;
    /// Whether whole numbers in memory are among the `count` ones from `first` on; `count` is at least 1.
    fn among(self, from: &[u32; LANES], first: u32, count: u32) -> Self::Mask;
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
    /// Bit k for number k.
    fn bits(self, a: Self::Mask) -> u32;
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

impl Lanes for Portable {
    type Numbers = [f32; LANES];
    type Mask = u32;

    #[inline(always)]
    fn splat(self, x: f32) -> [f32; LANES] {
        [x; LANES]
    }
    #[inline(always)]
    fn load(self, from: &[f32; LANES]) -> [f32; LANES] {
        *from
    }
    #[inline(always)]
    fn widen(self, from: &[u16; LANES]) -> [f32; LANES] {
        from.map(f32::from)
    }
    #[inline(always)]
    fn store(self, x: [f32; LANES]) -> [f32; LANES] {
        x
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
    fn min(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        each(|k| if a[k] < b[k] { a[k] } else { b[k] })
    }
    #[inline(always)]
    fn max(self, a: [f32; LANES], b: [f32; LANES]) -> [f32; LANES] {
        each(|k| if a[k] > b[k] { a[k] } else { b[k] })
    }
    #[inline(always)]
    fn abs(self, a: [f32; LANES]) -> [f32; LANES] {
        a.map(f32::abs)
    }
    #[inline(always)]
    fn among(self, from: &[u32; LANES], first: u32, count: u32) -> u32 {
        mask(|k| from[k].wrapping_sub(first) < count)
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
    fn bits(self, a: u32) -> u32 {
        a
    }
}

/// The same with intrinsics. They are unsafe to call outside of functions that are compiled for AVX2, which trait functions cannot be;
/// an [`Avx2`](avx2::Avx2) proves that the processor has it.
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod avx2 {
    use super::{LANES, Lanes, Task};
    use std::arch::x86_64::*;

    #[target_feature(enable = "avx2")]
    pub fn run<T: Task>(task: T) -> T::Output {
        task.run(Avx2(()))
    }

    /// Exists only inside [`run`].
    #[derive(Debug, Clone, Copy)]
    pub struct Avx2(());

    macro_rules! intrinsic {
        ($call:expr) => {
            // SAFETY: `self` was made in `run`, which may only be called where AVX2 is; loads and stores are of whole arrays.
            unsafe { $call }
        };
    }

    impl Lanes for Avx2 {
        type Numbers = __m256;
        type Mask = __m256;

        #[inline(always)]
        fn splat(self, x: f32) -> __m256 {
            intrinsic!(_mm256_set1_ps(x))
        }
        #[inline(always)]
        fn load(self, from: &[f32; LANES]) -> __m256 {
            intrinsic!(_mm256_loadu_ps(from.as_ptr()))
        }
        #[inline(always)]
        fn widen(self, from: &[u16; LANES]) -> __m256 {
            intrinsic!(_mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(_mm_loadu_si128(from.as_ptr().cast()))))
        }
        #[inline(always)]
        fn store(self, x: __m256) -> [f32; LANES] {
            let mut to = [0.0; LANES];
            intrinsic!(_mm256_storeu_ps(to.as_mut_ptr(), x));
            to
        }
        #[inline(always)]
        fn add(self, a: __m256, b: __m256) -> __m256 {
            intrinsic!(_mm256_add_ps(a, b))
        }
        #[inline(always)]
        fn sub(self, a: __m256, b: __m256) -> __m256 {
            intrinsic!(_mm256_sub_ps(a, b))
        }
        #[inline(always)]
        fn mul(self, a: __m256, b: __m256) -> __m256 {
            intrinsic!(_mm256_mul_ps(a, b))
        }
        #[inline(always)]
        fn div(self, a: __m256, b: __m256) -> __m256 {
            intrinsic!(_mm256_div_ps(a, b))
        }
        #[inline(always)]
        fn min(self, a: __m256, b: __m256) -> __m256 {
            intrinsic!(_mm256_min_ps(a, b))
        }
        #[inline(always)]
        fn max(self, a: __m256, b: __m256) -> __m256 {
            intrinsic!(_mm256_max_ps(a, b))
        }
        #[inline(always)]
        fn abs(self, a: __m256) -> __m256 {
            intrinsic!(_mm256_andnot_ps(_mm256_set1_ps(-0.0), a))
        }
        #[inline(always)]
        fn among(self, from: &[u32; LANES], first: u32, count: u32) -> __m256 {
            intrinsic!({
                let off = _mm256_sub_epi32(_mm256_loadu_si256(from.as_ptr().cast()), _mm256_set1_epi32(first as i32));
                let last = _mm256_set1_epi32((count - 1) as i32);
                _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_min_epu32(off, last), off))
            })
        }
        #[inline(always)]
        fn less(self, a: __m256, b: __m256) -> __m256 {
            intrinsic!(_mm256_cmp_ps::<_CMP_LT_OQ>(a, b))
        }
        #[inline(always)]
        fn at_most(self, a: __m256, b: __m256) -> __m256 {
            intrinsic!(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b))
        }
        #[inline(always)]
        fn and(self, a: __m256, b: __m256) -> __m256 {
            intrinsic!(_mm256_and_ps(a, b))
        }
        #[inline(always)]
        fn or(self, a: __m256, b: __m256) -> __m256 {
            intrinsic!(_mm256_or_ps(a, b))
        }
        #[inline(always)]
        fn but_not(self, a: __m256, b: __m256) -> __m256 {
            intrinsic!(_mm256_andnot_ps(b, a))
        }
        #[inline(always)]
        fn bits(self, a: __m256) -> u32 {
            intrinsic!(_mm256_movemask_ps(a)) as u32
        }
    }
}
