//! Eight lanes in two NEON registers, which every aarch64 processor has, so that nothing needs detection.
#![expect(unsafe_code, reason = "the compiler wants it for calling processor instructions")]

use std::arch::aarch64::{
    float32x4_t, uint32x4_t, vabsq_f32, vaddq_f32, vaddvq_u32, vandq_u32, vbslq_f32, vceqq_f32, vcgtq_f32,
    vcleq_f32, vcltq_f32, vdivq_f32, vdupq_n_f32, vdupq_n_u32, vld1q_f32, vld1q_u32, vmulq_f32, vst1q_f32,
    vsubq_f32, vtstq_u32,
};

use super::isa::{BundleRow, Interval, Isa, Lanes, Order, Pushed, Row, Task, Window, operators, reduce};
use super::{BUNDLE_RAYS, WIDTH, scalar};

/// NEON, which is part of every aarch64 processor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Neon;

/// An expression of NEON instructions on registers.
macro_rules! neon {
    ($instructions:expr) => {
        // SAFETY: the instructions touch registers only, and are part of every aarch64 processor.
        unsafe { $instructions }
    };
}

impl Isa for Neon {
    type F32 = F32x8;
    type Wide = F32x8;
    const WIDE: usize = WIDTH;

    #[inline(always)]
    fn enter<T: Task>(self, task: T) -> T::Output {
        /// A function of its own, as for the other instruction sets.
        #[inline(never)]
        fn run<T: Task>(task: T) -> T::Output {
            task.run(Neon)
        }
        run(task)
    }

    #[inline(always)]
    fn splat(self, value: f32) -> F32x8 {
        let half = neon!(vdupq_n_f32(value));
        F32x8 { low: half, high: half }
    }

    #[inline(always)]
    fn load(self, row: &Row) -> F32x8 {
        let (low, high) = row.0.split_at(WIDTH / 2);
        // SAFETY: both halves are four `f32`, aligned to 16 bytes.
        unsafe { F32x8 { low: vld1q_f32(low.as_ptr()), high: vld1q_f32(high.as_ptr()) } }
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

    /// Nothing: stable Rust has no such instruction for these processors.
    #[inline(always)]
    fn prefetch(self, _place: *const Row) {}
}

/// Eight `f32`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F32x8 {
    low: float32x4_t,
    high: float32x4_t,
}

impl F32x8 {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(float32x4_t, float32x4_t) -> float32x4_t) -> Self {
        Self { low: f(self.low, other.low), high: f(self.high, other.high) }
    }

    #[inline(always)]
    fn mask(self, other: Self, f: impl Fn(float32x4_t, float32x4_t) -> uint32x4_t) -> u32 {
        let (low, high) = (f(self.low, other.low), f(self.high, other.high));
        // SAFETY: both arrays have four places; NEON is part of every aarch64 processor.
        unsafe {
            let (ones, sixteens) = (vld1q_u32([1, 2, 4, 8].as_ptr()), vld1q_u32([16, 32, 64, 128].as_ptr()));
            vaddvq_u32(vandq_u32(low, ones)) + vaddvq_u32(vandq_u32(high, sixteens))
        }
    }
}

impl Lanes for F32x8 {
    type Array = [f32; WIDTH];

    #[inline(always)]
    fn splat(self, value: f32) -> Self {
        Neon.splat(value)
    }

    #[inline(always)]
    fn to_array(self) -> [f32; WIDTH] {
        let mut lanes = [0.0; WIDTH];
        let (low, high) = lanes.split_at_mut(WIDTH / 2);
        // SAFETY: both halves have four places.
        unsafe {
            vst1q_f32(low.as_mut_ptr(), self.low);
            vst1q_f32(high.as_mut_ptr(), self.high);
        }
        lanes
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| neon!(vbslq_f32(vcltq_f32(a, b), a, b)))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| neon!(vbslq_f32(vcgtq_f32(a, b), a, b)))
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
        neon!(Self { low: vabsq_f32(self.low), high: vabsq_f32(self.high) })
    }

    #[inline(always)]
    fn reciprocal(self) -> Self {
        let one = neon!(vdupq_n_f32(1.0));
        neon!(Self { low: vdivq_f32(one, self.low), high: vdivq_f32(one, self.high) })
    }

    #[inline(always)]
    fn select(self, mask: u32, other: Self) -> Self {
        let half = |shift: u32, chosen: float32x4_t, other: float32x4_t| {
            // SAFETY: the array has four places; NEON is part of every aarch64 processor.
            unsafe {
                let bits = vld1q_u32([1, 2, 4, 8].as_ptr());
                vbslq_f32(vtstq_u32(vdupq_n_u32(mask >> shift), bits), chosen, other)
            }
        };
        Self { low: half(0, self.low, other.low), high: half(4, self.high, other.high) }
    }

    #[inline(always)]
    fn less(self, other: Self) -> u32 {
        self.mask(other, |a, b| neon!(vcltq_f32(a, b)))
    }

    #[inline(always)]
    fn less_or_equal(self, other: Self) -> u32 {
        self.mask(other, |a, b| neon!(vcleq_f32(a, b)))
    }

    #[inline(always)]
    fn equal(self, other: Self) -> u32 {
        self.mask(other, |a, b| neon!(vceqq_f32(a, b)))
    }
}

operators! { F32x8:
    Add::add(a, b) => a.zip(b, |a, b| neon!(vaddq_f32(a, b)));
    Sub::sub(a, b) => a.zip(b, |a, b| neon!(vsubq_f32(a, b)));
    Mul::mul(a, b) => a.zip(b, |a, b| neon!(vmulq_f32(a, b)));
}
