//! Four lanes in an SSE register, which every x86-64 processor has, so that nothing needs detection.
#![expect(unsafe_code, reason = "the compiler wants it for calling processor instructions")]

use std::arch::x86_64::{
    __m128, _mm_add_ps, _mm_andnot_ps, _mm_cmpeq_ps, _mm_cmple_ps, _mm_cmplt_ps, _mm_div_ps, _mm_max_ps,
    _mm_min_ps, _mm_movemask_ps, _mm_mul_ps, _mm_set1_ps, _mm_setr_ps, _mm_sub_ps,
};
use std::ops::{Add, Mul, Sub};

/// An expression of SSE and SSE2 instructions on registers.
macro_rules! sse {
    ($instructions:expr) => {
        // SAFETY: the instructions touch registers only, and need no more than SSE2, which is part of every x86-64
        // processor.
        unsafe { $instructions }
    };
}

/// Four `f32`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F32x4(__m128);

impl F32x4 {
    #[inline(always)]
    pub(crate) fn splat(value: f32) -> Self {
        Self(sse!(_mm_set1_ps(value)))
    }

    #[inline(always)]
    pub(crate) fn load(lanes: &[f32; 4]) -> Self {
        // Becomes one load.
        Self(sse!(_mm_setr_ps(lanes[0], lanes[1], lanes[2], lanes[3])))
    }

    #[inline(always)]
    pub(crate) fn to_array(self) -> [f32; 4] {
        lanes_of(self.0)
    }

    /// The smaller of each pair; the second where either is NaN.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        Self(sse!(_mm_min_ps(self.0, other.0)))
    }

    /// The larger of each pair; the second where either is NaN.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        Self(sse!(_mm_max_ps(self.0, other.0)))
    }

    /// The absolute values.
    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self(sse!(_mm_andnot_ps(_mm_set1_ps(-0.0), self.0)))
    }

    /// `1 / x`, rounded as a division.
    #[inline(always)]
    pub(crate) fn reciprocal(self) -> Self {
        Self(sse!(_mm_div_ps(_mm_set1_ps(1.0), self.0)))
    }

    /// One bit a lane: whether `self < other`; false for NaN.
    #[inline(always)]
    pub(crate) fn less(self, other: Self) -> u32 {
        sse!(_mm_movemask_ps(_mm_cmplt_ps(self.0, other.0))) as u32
    }

    /// One bit a lane: whether `self <= other`; false for NaN.
    #[inline(always)]
    pub(crate) fn less_or_equal(self, other: Self) -> u32 {
        sse!(_mm_movemask_ps(_mm_cmple_ps(self.0, other.0))) as u32
    }

    /// One bit a lane: whether `self == other`; false for NaN.
    #[inline(always)]
    pub(crate) fn equal(self, other: Self) -> u32 {
        sse!(_mm_movemask_ps(_mm_cmpeq_ps(self.0, other.0))) as u32
    }
}

/// The lanes; written with shuffles, which become one store where the lanes go to memory.
#[inline(always)]
fn lanes_of(v: __m128) -> [f32; 4] {
    use std::arch::x86_64::{_mm_cvtss_f32, _mm_shuffle_ps};
    sse!([
        _mm_cvtss_f32(v),
        _mm_cvtss_f32(_mm_shuffle_ps::<1>(v, v)),
        _mm_cvtss_f32(_mm_shuffle_ps::<2>(v, v)),
        _mm_cvtss_f32(_mm_shuffle_ps::<3>(v, v)),
    ])
}

impl Add for F32x4 {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(sse!(_mm_add_ps(self.0, other.0)))
    }
}

impl Sub for F32x4 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(sse!(_mm_sub_ps(self.0, other.0)))
    }
}

impl Mul for F32x4 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(sse!(_mm_mul_ps(self.0, other.0)))
    }
}
