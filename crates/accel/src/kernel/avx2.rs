//! Eight lanes in an AVX register; children are gathered by a table of permutations.
#![expect(unsafe_code, reason = "the compiler wants it for calling processor instructions")]

use std::arch::x86_64::{
    __m256, _CMP_EQ_OQ, _CMP_LE_OQ, _CMP_LT_OQ, _MM_HINT_T0, _mm_loadl_epi64, _mm_prefetch, _mm256_add_ps,
    _mm256_and_si256, _mm256_andnot_ps, _mm256_blendv_ps, _mm256_castsi256_ps, _mm256_cmp_ps,
    _mm256_cmpeq_epi32, _mm256_cvtepu8_epi32, _mm256_div_ps, _mm256_load_ps, _mm256_loadu_si256,
    _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps, _mm256_permute2f128_ps,
    _mm256_permutevar8x32_ps, _mm256_set1_epi32, _mm256_set1_ps, _mm256_setr_epi32, _mm256_shuffle_ps,
    _mm256_storeu_ps, _mm256_sub_ps, _mm256_unpackhi_ps, _mm256_unpacklo_ps,
};

use super::isa::{BundleRow, Interval, Isa, Lanes, Order, Pushed, Row, Task, Window, operators, reduce};
use super::{BUNDLE_RAYS, WIDTH};

/// The proof that the processor has AVX2 and the bit instructions that came with it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2(());

impl Avx2 {
    #[inline(always)]
    pub(crate) fn new() -> Option<Self> {
        let found = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt");
        found.then_some(Self(()))
    }
}

/// For each mask, the places of its bits in ascending order; what follows them is zero.
static PLACES_OF_BITS: [[u8; WIDTH]; 256] = {
    let mut table = [[0; WIDTH]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut count, mut bit) = (0, 0);
        while bit < WIDTH {
            if mask >> bit & 1 == 1 {
                table[mask][count] = bit as u8;
                count += 1;
            }
            bit += 1;
        }
        mask += 1;
    }
    table
};

/// An expression of instructions on registers.
macro_rules! avx2 {
    ($instructions:expr) => {
        // SAFETY: the instructions touch registers only, and values of the type exist only where the processor has them.
        unsafe { $instructions }
    };
}

impl Isa for Avx2 {
    type F32 = F32x8;
    type Wide = F32x8;
    const WIDE: usize = WIDTH;

    #[inline(always)]
    fn enter<T: Task>(self, task: T) -> T::Output {
        #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
        fn run<T: Task>(isa: Avx2, task: T) -> T::Output {
            task.run(isa)
        }
        // SAFETY: `self` proves that the processor has the features.
        unsafe { run(self, task) }
    }

    #[inline(always)]
    fn splat(self, value: f32) -> F32x8 {
        F32x8(avx2!(_mm256_set1_ps(value)))
    }

    #[inline(always)]
    fn load(self, row: &Row) -> F32x8 {
        // SAFETY: a row is eight `f32`, aligned to 32 bytes.
        F32x8(unsafe { _mm256_load_ps(row.0.as_ptr()) })
    }

    #[inline(always)]
    fn transpose(self, rows: [F32x8; WIDTH]) -> [F32x8; WIDTH] {
        // SAFETY: `self` proves that the processor has the features.
        unsafe { transpose(rows.map(|row| row.0)) }.map(F32x8)
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
        F32x8(avx2!(_mm256_permute2f128_ps::<1>(lanes.0, lanes.0)))
    }

    #[inline(always)]
    fn push<const ENTERS: bool>(
        self,
        children: &Row,
        interval: Interval<F32x8>,
        order: &Order,
        window: Window<'_>,
    ) -> Pushed {
        // SAFETY: the order, the row, both parts of the window and a line of the table have eight places each; `self` proves the features.
        unsafe {
            let order = _mm256_loadu_si256(order.0.as_ptr().cast());
            let enter = _mm256_permutevar8x32_ps(interval.enter.0, order);
            let exit = _mm256_permutevar8x32_ps(interval.exit.0, order);
            let children = _mm256_permutevar8x32_ps(self.load(children).0, order);
            let mask = F32x8(enter).less_or_equal(F32x8(exit));
            let places = PLACES_OF_BITS[mask as usize % 256].as_ptr();
            let places = _mm256_cvtepu8_epi32(_mm_loadl_epi64(places.cast()));
            _mm256_storeu_ps(window.children.as_mut_ptr(), _mm256_permutevar8x32_ps(children, places));
            if ENTERS {
                _mm256_storeu_ps(window.enters.as_mut_ptr(), _mm256_permutevar8x32_ps(enter, places));
            }
            Pushed(mask)
        }
    }

    #[inline(always)]
    fn prefetch(self, place: *const Row) {
        // SAFETY: a prefetch reads nothing, and may be given any address.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(place.cast()) }
    }
}

/// [`Isa::transpose`]: pairs of lanes, then fours, both within the halves of a row, then the halves.
///
/// # Safety
///
/// The processor must have AVX.
#[inline(always)]
pub(super) unsafe fn transpose([a, b, c, d, e, f, g, h]: [__m256; WIDTH]) -> [__m256; WIDTH] {
    const LOW: i32 = 0b01_00_01_00;
    const HIGH: i32 = 0b11_10_11_10;
    // SAFETY: the instructions touch registers only, and the caller says that the processor has them.
    unsafe {
        let (ab0, ab2) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
        let (cd0, cd2) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
        let (ef0, ef2) = (_mm256_unpacklo_ps(e, f), _mm256_unpackhi_ps(e, f));
        let (gh0, gh2) = (_mm256_unpacklo_ps(g, h), _mm256_unpackhi_ps(g, h));
        let (ad0, ad1) = (_mm256_shuffle_ps::<LOW>(ab0, cd0), _mm256_shuffle_ps::<HIGH>(ab0, cd0));
        let (ad2, ad3) = (_mm256_shuffle_ps::<LOW>(ab2, cd2), _mm256_shuffle_ps::<HIGH>(ab2, cd2));
        let (eh0, eh1) = (_mm256_shuffle_ps::<LOW>(ef0, gh0), _mm256_shuffle_ps::<HIGH>(ef0, gh0));
        let (eh2, eh3) = (_mm256_shuffle_ps::<LOW>(ef2, gh2), _mm256_shuffle_ps::<HIGH>(ef2, gh2));
        [
            _mm256_permute2f128_ps::<0x20>(ad0, eh0),
            _mm256_permute2f128_ps::<0x20>(ad1, eh1),
            _mm256_permute2f128_ps::<0x20>(ad2, eh2),
            _mm256_permute2f128_ps::<0x20>(ad3, eh3),
            _mm256_permute2f128_ps::<0x31>(ad0, eh0),
            _mm256_permute2f128_ps::<0x31>(ad1, eh1),
            _mm256_permute2f128_ps::<0x31>(ad2, eh2),
            _mm256_permute2f128_ps::<0x31>(ad3, eh3),
        ]
    }
}

/// Eight `f32`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F32x8(__m256);

impl Lanes for F32x8 {
    type Array = [f32; WIDTH];

    #[inline(always)]
    fn splat(self, value: f32) -> Self {
        Self(avx2!(_mm256_set1_ps(value)))
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
        Self(avx2!(_mm256_min_ps(self.0, other.0)))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(avx2!(_mm256_max_ps(self.0, other.0)))
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
        Self(avx2!(_mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0)))
    }

    #[inline(always)]
    fn reciprocal(self) -> Self {
        Self(avx2!(_mm256_div_ps(_mm256_set1_ps(1.0), self.0)))
    }

    #[inline(always)]
    fn select(self, mask: u32, other: Self) -> Self {
        avx2!({
            let bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let chosen = _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(mask as i32), bits), bits);
            Self(_mm256_blendv_ps(other.0, self.0, _mm256_castsi256_ps(chosen)))
        })
    }

    #[inline(always)]
    fn less(self, other: Self) -> u32 {
        avx2!(_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0))) as u32
    }

    #[inline(always)]
    fn less_or_equal(self, other: Self) -> u32 {
        avx2!(_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0))) as u32
    }

    #[inline(always)]
    fn equal(self, other: Self) -> u32 {
        avx2!(_mm256_movemask_ps(_mm256_cmp_ps::<_CMP_EQ_OQ>(self.0, other.0))) as u32
    }
}

operators! { F32x8:
    Add::add(a, b) => Self(avx2!(_mm256_add_ps(a.0, b.0)));
    Sub::sub(a, b) => Self(avx2!(_mm256_sub_ps(a.0, b.0)));
    Mul::mul(a, b) => Self(avx2!(_mm256_mul_ps(a.0, b.0)));
}
