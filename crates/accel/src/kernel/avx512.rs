//! Eight lanes in a 256-bit register with the masks, permutations and compressions of AVX-512, and sixteen in one of 512 bits.
//!
//! Single rays use half the width of the registers: a ray meets eight children, and the other half would idle.
#![expect(unsafe_code, reason = "the compiler wants it for calling processor instructions")]

use std::arch::x86_64::{
    __m256, __m512, _CMP_EQ_OQ, _CMP_LE_OQ, _CMP_LT_OQ, _MM_HINT_T0, _mm_prefetch, _mm256_add_ps,
    _mm256_andnot_ps, _mm256_cmp_ps_mask, _mm256_div_ps, _mm256_load_ps, _mm256_loadu_si256,
    _mm256_mask_blend_ps, _mm256_maskz_compress_ps, _mm256_max_ps, _mm256_min_ps, _mm256_mul_ps,
    _mm256_permute2f128_ps, _mm256_permutexvar_ps, _mm256_set1_ps, _mm256_storeu_ps, _mm256_sub_ps,
    _mm512_abs_ps, _mm512_add_ps, _mm512_cmp_ps_mask, _mm512_div_ps, _mm512_loadu_ps, _mm512_mask_blend_ps,
    _mm512_max_ps, _mm512_min_ps, _mm512_mul_ps, _mm512_reduce_max_ps, _mm512_reduce_min_ps, _mm512_set1_ps,
    _mm512_storeu_ps, _mm512_sub_ps,
};

use super::avx2::transpose;
use super::isa::{BundleRow, Interval, Isa, Lanes, Order, Pushed, Row, Task, Window, operators, reduce};
use super::{BUNDLE_RAYS, WIDTH};

/// The proof that the processor has AVX-512 F, VL, BW and DQ, and BMI.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx512(());

impl Avx512 {
    #[inline(always)]
    pub(crate) fn new() -> Option<Self> {
        let found = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt");
        found.then_some(Self(()))
    }
}

/// An expression of instructions on registers.
macro_rules! avx512 {
    ($instructions:expr) => {
        // SAFETY: the instructions touch registers only, and values of the type exist only where the processor has them.
        unsafe { $instructions }
    };
}

impl Isa for Avx512 {
    type F32 = F32x8;
    type Wide = F32x16;
    const WIDE: usize = 2 * WIDTH;

    #[inline(always)]
    fn enter<T: Task>(self, task: T) -> T::Output {
        #[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq,bmi1,bmi2,lzcnt,popcnt")]
        fn run<T: Task>(isa: Avx512, task: T) -> T::Output {
            task.run(isa)
        }
        // SAFETY: `self` proves that the processor has the features.
        unsafe { run(self, task) }
    }

    #[inline(always)]
    fn splat(self, value: f32) -> F32x8 {
        F32x8(avx512!(_mm256_set1_ps(value)))
    }

    #[inline(always)]
    fn load(self, row: &Row) -> F32x8 {
        // SAFETY: a row is eight `f32`, aligned to 32 bytes.
        F32x8(unsafe { _mm256_load_ps(row.0.as_ptr()) })
    }

    #[inline(always)]
    fn transpose(self, rows: [F32x8; WIDTH]) -> [F32x8; WIDTH] {
        // SAFETY: `self` proves that the processor has the features, AVX among them.
        unsafe { transpose(rows.map(|row| row.0)) }.map(F32x8)
    }

    #[inline(always)]
    fn load_wide(self, rows: &BundleRow, group: usize) -> F32x16 {
        let numbers: &[f32; 2 * WIDTH] = &rows.0.as_chunks().0[group % (BUNDLE_RAYS / Self::WIDE)];
        // SAFETY: there are sixteen numbers.
        F32x16(unsafe { _mm512_loadu_ps(numbers.as_ptr()) })
    }

    #[inline(always)]
    fn store_wide(self, lanes: F32x16, rows: &mut BundleRow, group: usize) {
        let numbers: &mut [f32; 2 * WIDTH] =
            &mut rows.0.as_chunks_mut().0[group % (BUNDLE_RAYS / Self::WIDE)];
        // SAFETY: there are sixteen numbers.
        unsafe { _mm512_storeu_ps(numbers.as_mut_ptr(), lanes.0) }
    }

    #[inline(always)]
    fn swap_halves(self, lanes: F32x8) -> F32x8 {
        F32x8(avx512!(_mm256_permute2f128_ps::<1>(lanes.0, lanes.0)))
    }

    #[inline(always)]
    fn push<const ENTERS: bool>(
        self,
        children: &Row,
        interval: Interval<F32x8>,
        order: &Order,
        window: Window<'_>,
    ) -> Pushed {
        // SAFETY: the order, the row and both parts of the window are eight words each; `self` proves the features.
        unsafe {
            let order = _mm256_loadu_si256(order.0.as_ptr().cast());
            let enter = _mm256_permutexvar_ps(order, interval.enter.0);
            let exit = _mm256_permutexvar_ps(order, interval.exit.0);
            let children = _mm256_permutexvar_ps(order, self.load(children).0);
            let mask = _mm256_cmp_ps_mask::<_CMP_LE_OQ>(enter, exit);
            _mm256_storeu_ps(window.children.as_mut_ptr(), _mm256_maskz_compress_ps(mask, children));
            if ENTERS {
                _mm256_storeu_ps(window.enters.as_mut_ptr(), _mm256_maskz_compress_ps(mask, enter));
            }
            Pushed(mask.into())
        }
    }

    #[inline(always)]
    fn prefetch(self, place: *const Row) {
        // SAFETY: a prefetch reads nothing, and may be given any address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(place.cast()) }
    }
}

/// Eight `f32`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F32x8(__m256);

impl Lanes for F32x8 {
    type Array = [f32; WIDTH];

    #[inline(always)]
    fn splat(self, value: f32) -> Self {
        Self(avx512!(_mm256_set1_ps(value)))
    }

    #[inline(always)]
    fn to_array(self) -> [f32; WIDTH] {
        let mut lanes = [0.0; WIDTH];
        // SAFETY: the array has eight places; values of the type exist only where the processor has the instruction.
        unsafe { _mm256_storeu_ps(lanes.as_mut_ptr(), self.0) }
        lanes
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(avx512!(_mm256_min_ps(self.0, other.0)))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(avx512!(_mm256_max_ps(self.0, other.0)))
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
        Self(avx512!(_mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0)))
    }

    #[inline(always)]
    fn reciprocal(self) -> Self {
        Self(avx512!(_mm256_div_ps(_mm256_set1_ps(1.0), self.0)))
    }

    #[inline(always)]
    fn select(self, mask: u32, other: Self) -> Self {
        Self(avx512!(_mm256_mask_blend_ps(mask as u8, other.0, self.0)))
    }

    #[inline(always)]
    fn less(self, other: Self) -> u32 {
        avx512!(_mm256_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0)).into()
    }

    #[inline(always)]
    fn less_or_equal(self, other: Self) -> u32 {
        avx512!(_mm256_cmp_ps_mask::<_CMP_LE_OQ>(self.0, other.0)).into()
    }

    #[inline(always)]
    fn equal(self, other: Self) -> u32 {
        avx512!(_mm256_cmp_ps_mask::<_CMP_EQ_OQ>(self.0, other.0)).into()
    }
}

operators! { F32x8:
    Add::add(a, b) => Self(avx512!(_mm256_add_ps(a.0, b.0)));
    Sub::sub(a, b) => Self(avx512!(_mm256_sub_ps(a.0, b.0)));
    Mul::mul(a, b) => Self(avx512!(_mm256_mul_ps(a.0, b.0)));
}

/// Sixteen `f32`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F32x16(__m512);

impl Lanes for F32x16 {
    type Array = [f32; 2 * WIDTH];

    #[inline(always)]
    fn splat(self, value: f32) -> Self {
        Self(avx512!(_mm512_set1_ps(value)))
    }

    #[inline(always)]
    fn to_array(self) -> [f32; 2 * WIDTH] {
        let mut lanes = [0.0; 2 * WIDTH];
        // SAFETY: the array has sixteen places; values of the type exist only where the processor has the instruction.
        unsafe { _mm512_storeu_ps(lanes.as_mut_ptr(), self.0) }
        lanes
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(avx512!(_mm512_min_ps(self.0, other.0)))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(avx512!(_mm512_max_ps(self.0, other.0)))
    }

    #[inline(always)]
    fn least(self) -> f32 {
        avx512!(_mm512_reduce_min_ps(self.0))
    }

    #[inline(always)]
    fn greatest(self) -> f32 {
        avx512!(_mm512_reduce_max_ps(self.0))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(avx512!(_mm512_abs_ps(self.0)))
    }

    #[inline(always)]
    fn reciprocal(self) -> Self {
        Self(avx512!(_mm512_div_ps(_mm512_set1_ps(1.0), self.0)))
    }

    #[inline(always)]
    fn select(self, mask: u32, other: Self) -> Self {
        Self(avx512!(_mm512_mask_blend_ps(mask as u16, other.0, self.0)))
    }

    #[inline(always)]
    fn less(self, other: Self) -> u32 {
        avx512!(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0)).into()
    }

    #[inline(always)]
    fn less_or_equal(self, other: Self) -> u32 {
        avx512!(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, other.0)).into()
    }

    #[inline(always)]
    fn equal(self, other: Self) -> u32 {
        avx512!(_mm512_cmp_ps_mask::<_CMP_EQ_OQ>(self.0, other.0)).into()
    }
}

operators! { F32x16:
    Add::add(a, b) => Self(avx512!(_mm512_add_ps(a.0, b.0)));
    Sub::sub(a, b) => Self(avx512!(_mm512_sub_ps(a.0, b.0)));
    Mul::mul(a, b) => Self(avx512!(_mm512_mul_ps(a.0, b.0)));
}
