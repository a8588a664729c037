//! Eight lanes in two SSE registers, which every x86-64 processor has, so that nothing needs detection.
#![expect(unsafe_code, reason = "the compiler wants it for calling processor instructions")]

use std::arch::x86_64::{
    __m128, _MM_HINT_T0, _mm_add_ps, _mm_and_ps, _mm_and_si128, _mm_andnot_ps, _mm_castsi128_ps,
    _mm_cmpeq_epi32, _mm_cmpeq_ps, _mm_cmple_ps, _mm_cmplt_ps, _mm_div_ps, _mm_load_ps, _mm_max_ps,
    _mm_min_ps, _mm_movemask_ps, _mm_mul_ps, _mm_or_ps, _mm_prefetch, _mm_set1_epi32, _mm_set1_ps,
    _mm_setr_epi32, _mm_storeu_ps, _mm_sub_ps,
};

use super::isa::{BundleRow, Interval, Isa, Lanes, Order, Pushed, Row, Task, Window, operators, reduce};
use super::{BUNDLE_RAYS, WIDTH, scalar};

/// SSE2, which is part of every x86-64 processor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sse2;

/// An expression of SSE and SSE2 instructions on registers.
macro_rules! sse {
    ($instructions:expr) => {
        // SAFETY: the instructions touch registers only, and are part of every x86-64 processor.
        unsafe { $instructions }
    };
}

impl Isa for Sse2 {
    type F32 = F32x8;
    type Wide = F32x8;
    const WIDE: usize = WIDTH;

    #[inline(always)]
    fn enter<T: Task>(self, task: T) -> T::Output {
        /// A function of its own, as for the other instruction sets.
        #[inline(never)]
        fn run<T: Task>(task: T) -> T::Output {
            task.run(Sse2)
        }
        run(task)
    }

    #[inline(always)]
    fn splat(self, value: f32) -> F32x8 {
        let half = sse!(_mm_set1_ps(value));
        F32x8 { low: half, high: half }
    }

    #[inline(always)]
    fn load(self, row: &Row) -> F32x8 {
        let (low, high) = row.0.split_at(WIDTH / 2);
        // SAFETY: both halves are four `f32`, aligned to 16 bytes.
        unsafe { F32x8 { low: _mm_load_ps(low.as_ptr()), high: _mm_load_ps(high.as_ptr()) } }
    }

    #[inline(always)]
    fn load_wide(self, rows: &BundleRow, group: usize) -> F32x8 {
        self.load_unaligned(&rows.0.as_chunks().0[group % (BUNDLE_RAYS / WIDTH)])
    }

    #[inline(always)]
    fn store_wide(self, lanes: F32x8, rows: &mut BundleRow, group: usize) {
        rows.0.as_chunks_mut().0[group % (BUNDLE_RAYS / WIDTH)] = lanes.to_array();
    }

    #[inline(always)]
    fn swap_halves(self, lanes: F32x8) -> F32x8 {
        F32x8 { low: lanes.high, high: lanes.low }
    }

    #[inline(always)]
    fn push<const ENTERS: bool>(
        self,
        children: &Row,
        interval: Interval<F32x8>,
        order: &Order,
        window: Window<'_>,
    ) -> Pushed {
        let Interval { enter, exit } = interval;
        scalar::push::<ENTERS>(children, enter.less_or_equal(exit), enter.to_array(), order, window)
    }

    #[inline(always)]
    fn prefetch(self, place: *const Row) {
        // SAFETY: a prefetch reads nothing, and may be given any address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(place.cast()) }
    }
}

/// Eight `f32`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F32x8 {
    low: __m128,
    high: __m128,
}

impl F32x8 {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(__m128, __m128) -> __m128) -> Self {
        Self { low: f(self.low, other.low), high: f(self.high, other.high) }
    }

    #[inline(always)]
    fn mask(self, other: Self, f: impl Fn(__m128, __m128) -> __m128) -> u32 {
        let result = self.zip(other, f);
        let (low, high) = sse!((_mm_movemask_ps(result.low), _mm_movemask_ps(result.high)));
        (low | high << 4) as u32
    }
}

impl Lanes for F32x8 {
    type Array = [f32; WIDTH];

    #[inline(always)]
    fn splat(self, value: f32) -> Self {
        Sse2.splat(value)
    }

    #[inline(always)]
    fn to_array(self) -> [f32; WIDTH] {
        let mut lanes = [0.0; WIDTH];
        let (low, high) = lanes.split_at_mut(WIDTH / 2);
        // SAFETY: both halves have four places.
        unsafe {
            _mm_storeu_ps(low.as_mut_ptr(), self.low);
            _mm_storeu_ps(high.as_mut_ptr(), self.high);
        }
        lanes
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| sse!(_mm_min_ps(a, b)))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| sse!(_mm_max_ps(a, b)))
    }

    #[inline(always)]
    fn least(self) -> f32 {
        reduce(self.to_array(), f32::min)
    }

    #[inline(always)]
    fn greatest(self) -> f32 {
        reduce(self.to_array(), f32::max)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        let sign = sse!(_mm_set1_ps(-0.0));
        sse!(Self { low: _mm_andnot_ps(sign, self.low), high: _mm_andnot_ps(sign, self.high) })
    }

    #[inline(always)]
    fn reciprocal(self) -> Self {
        let one = sse!(_mm_set1_ps(1.0));
        sse!(Self { low: _mm_div_ps(one, self.low), high: _mm_div_ps(one, self.high) })
    }

    #[inline(always)]
    fn select(self, mask: u32, other: Self) -> Self {
        let half = |shift: u32, chosen: __m128, other: __m128| {
            sse!({
                let bits = _mm_setr_epi32(1, 2, 4, 8);
                let mask = _mm_cmpeq_epi32(_mm_and_si128(_mm_set1_epi32((mask >> shift) as i32), bits), bits);
                let mask = _mm_castsi128_ps(mask);
                _mm_or_ps(_mm_and_ps(mask, chosen), _mm_andnot_ps(mask, other))
            })
        };
        Self { low: half(0, self.low, other.low), high: half(4, self.high, other.high) }
    }

    #[inline(always)]
    fn less(self, other: Self) -> u32 {
        self.mask(other, |a, b| sse!(_mm_cmplt_ps(a, b)))
    }

    #[inline(always)]
    fn less_or_equal(self, other: Self) -> u32 {
        self.mask(other, |a, b| sse!(_mm_cmple_ps(a, b)))
    }

    #[inline(always)]
    fn equal(self, other: Self) -> u32 {
        self.mask(other, |a, b| sse!(_mm_cmpeq_ps(a, b)))
    }
}

operators! { F32x8:
    Add::add(a, b) => a.zip(b, |a, b| sse!(_mm_add_ps(a, b)));
    Sub::sub(a, b) => a.zip(b, |a, b| sse!(_mm_sub_ps(a, b)));
    Mul::mul(a, b) => a.zip(b, |a, b| sse!(_mm_mul_ps(a, b)));
}
