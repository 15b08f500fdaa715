//! The same with intrinsics. They are unsafe to call outside of functions that are compiled for AVX2, which trait functions cannot be; an
//! [`Avx2`] proves that the processor has it.
#![allow(unsafe_code)]

use super::{Add, Arithmetic, Div, Double, LANES, Lanes, Mul, Sub, Task, operators};
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
        // SAFETY: the `Avx2` or the numbers at hand were made in `run`, which may only be called where AVX2 is; loads and stores are of
        // whole arrays.
        unsafe { $call }
    };
}

/// Eight doubles, the first four and the others. Exist where an [`Avx2`] made the first of them.
#[derive(Debug, Clone, Copy)]
pub struct Doubles(__m256d, __m256d);

operators!(
    Doubles,
    Add add (a, b) Doubles(intrinsic!(_mm256_add_pd(a.0, b.0)), intrinsic!(_mm256_add_pd(a.1, b.1))),
    Sub sub (a, b) Doubles(intrinsic!(_mm256_sub_pd(a.0, b.0)), intrinsic!(_mm256_sub_pd(a.1, b.1))),
    Mul mul (a, b) Doubles(intrinsic!(_mm256_mul_pd(a.0, b.0)), intrinsic!(_mm256_mul_pd(a.1, b.1))),
    Div div (a, b) Doubles(intrinsic!(_mm256_div_pd(a.0, b.0)), intrinsic!(_mm256_div_pd(a.1, b.1)))
);

/// [`Double::turned`] of four.
#[inline(always)]
fn turned(sin: __m256d, cos: __m256d, rounded: __m256d) -> (__m256d, __m256d) {
    intrinsic!({
        let quarters = _mm256_castpd_si256(rounded);
        let odd = _mm256_castsi256_pd(_mm256_slli_epi64::<63>(quarters));
        let next = _mm256_add_epi64(quarters, _mm256_set1_epi64x(1));
        let only_sign = _mm256_set1_pd(-0.0);
        let sin_sign = _mm256_and_pd(_mm256_castsi256_pd(_mm256_slli_epi64::<62>(quarters)), only_sign);
        let cos_sign = _mm256_and_pd(_mm256_castsi256_pd(_mm256_slli_epi64::<62>(next)), only_sign);
        (_mm256_xor_pd(_mm256_blendv_pd(sin, cos, odd), sin_sign), _mm256_xor_pd(_mm256_blendv_pd(cos, sin, odd), cos_sign))
    })
}

impl Double for Doubles {
    #[inline(always)]
    fn constant(self, value: f64) -> Doubles {
        let all = intrinsic!(_mm256_set1_pd(value));
        Doubles(all, all)
    }
    #[inline(always)]
    fn sqrt(self) -> Doubles {
        Doubles(intrinsic!(_mm256_sqrt_pd(self.0)), intrinsic!(_mm256_sqrt_pd(self.1)))
    }
    #[inline(always)]
    fn turned((sin, cos): (Doubles, Doubles), rounded: Doubles) -> (Doubles, Doubles) {
        let (low, high) = (turned(sin.0, cos.0, rounded.0), turned(sin.1, cos.1, rounded.1));
        (Doubles(low.0, high.0), Doubles(low.1, high.1))
    }
}

impl Arithmetic for Avx2 {
    type Numbers = __m256;
    type Doubles = Doubles;
    type Mask = __m256;

    #[inline(always)]
    fn splat(self, x: f32) -> __m256 {
        intrinsic!(_mm256_set1_ps(x))
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
    fn sqrt(self, a: __m256) -> __m256 {
        intrinsic!(_mm256_sqrt_ps(a))
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
    fn negative(self, a: __m256) -> __m256 {
        intrinsic!(_mm256_xor_ps(_mm256_set1_ps(-0.0), a))
    }
    #[inline(always)]
    fn copysign(self, a: __m256, b: __m256) -> __m256 {
        intrinsic!(_mm256_or_ps(_mm256_andnot_ps(_mm256_set1_ps(-0.0), a), _mm256_and_ps(_mm256_set1_ps(-0.0), b)))
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
    fn choose(self, mask: __m256, a: __m256, b: __m256) -> __m256 {
        intrinsic!(_mm256_blendv_ps(b, a, mask))
    }
    #[inline(always)]
    fn narrow(self, a: Doubles) -> __m256 {
        intrinsic!(_mm256_set_m128(_mm256_cvtpd_ps(a.1), _mm256_cvtpd_ps(a.0)))
    }
}

/// By bits, from which bytes [`Lanes::pack`] takes each.
static PACK: [[u8; 2 * LANES]; 256] = {
    let mut table = [[0; 2 * LANES]; 256];
    let mut bits = 0;
    while bits < 256 {
        let (mut k, mut count) = (0, 0);
        while k < LANES {
            if bits >> k & 1 != 0 {
                table[bits][count] = 2 * k as u8;
                table[bits][count + 1] = 2 * k as u8 + 1;
                count += 2;
            }
            k += 1;
        }
        bits += 1;
    }
    table
};

impl Lanes for Avx2 {
    #[inline(always)]
    fn load(self, from: &[f32; LANES]) -> __m256 {
        intrinsic!(_mm256_loadu_ps(from.as_ptr()))
    }
    #[inline(always)]
    fn load_doubles(self, from: &[f64; LANES]) -> Doubles {
        let [low, high] = intrinsic!([_mm256_loadu_pd(from.as_ptr()), _mm256_loadu_pd(from.as_ptr().add(LANES / 2))]);
        Doubles(low, high)
    }
    #[inline(always)]
    fn store_doubles(self, x: Doubles) -> [f64; LANES] {
        let mut to = [0.0; LANES];
        intrinsic!({
            _mm256_storeu_pd(to.as_mut_ptr(), x.0);
            _mm256_storeu_pd(to.as_mut_ptr().add(LANES / 2), x.1);
        });
        to
    }
    #[inline(always)]
    fn store(self, x: __m256) -> [f32; LANES] {
        let mut to = [0.0; LANES];
        intrinsic!(_mm256_storeu_ps(to.as_mut_ptr(), x));
        to
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
    fn meet(self, from: [&[u16; 2 * LANES]; 3], to: [&[u16; 2 * LANES]; 3], low: [u16; 3], high: [u16; 3]) -> u32 {
        intrinsic!({
            let (mut inside, mut outside) = (_mm256_set1_epi16(-1), _mm256_setzero_si256());
            for axis in 0..3 {
                let a = _mm256_loadu_si256(from[axis].as_ptr().cast());
                let b = _mm256_loadu_si256(to[axis].as_ptr().cast());
                let (least, most) = (_mm256_min_epu16(a, b), _mm256_max_epu16(a, b));
                let (low, high) = (_mm256_set1_epi16(low[axis] as i16), _mm256_set1_epi16(high[axis] as i16));
                let begins = _mm256_cmpeq_epi16(_mm256_min_epu16(least, high), least);
                let ends = _mm256_cmpeq_epi16(_mm256_max_epu16(most, low), most);
                inside = _mm256_and_si256(inside, _mm256_and_si256(begins, ends));
                if axis == 0 {
                    outside = _mm256_cmpeq_epi16(most, _mm256_set1_epi16(-1));
                }
            }
            let met = _mm256_or_si256(inside, outside);
            _mm_movemask_epi8(_mm_packs_epi16(_mm256_castsi256_si128(met), _mm256_extracti128_si256::<1>(met))) as u32
        })
    }
    #[inline(always)]
    fn fetch<T>(self, it: &T) {
        for line in 0..size_of::<T>() / 64 {
            intrinsic!(_mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(it).cast::<i8>().add(64 * line)));
        }
    }
    #[inline(always)]
    fn select(self, bits: u32) -> __m256 {
        intrinsic!({
            let own = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(bits as i32), own), own))
        })
    }
    #[inline(always)]
    fn pack(self, from: &[u16; LANES], bits: u8) -> [u16; LANES] {
        let mut to = [0; LANES];
        intrinsic!({
            let places = _mm_loadu_si128(PACK[usize::from(bits)].as_ptr().cast());
            _mm_storeu_si128(to.as_mut_ptr().cast(), _mm_shuffle_epi8(_mm_loadu_si128(from.as_ptr().cast()), places));
        });
        to
    }
    #[inline(always)]
    fn bits(self, a: __m256) -> u32 {
        intrinsic!(_mm256_movemask_ps(a)) as u32
    }
}
