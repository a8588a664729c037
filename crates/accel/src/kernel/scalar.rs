//! Eight lanes as an array: the specification of every instruction set.

use super::isa::{BundleRow, Interval, Isa, Lanes, Order, Pushed, Row, Task, Window, operators, reduce};
use super::{BUNDLE_RAYS, WIDTH};

/// No instruction set in particular.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scalar;

impl Isa for Scalar {
    type F32 = F32x8;
    type Wide = F32x8;
    const WIDE: usize = WIDTH;

    #[inline(always)]
    fn enter<T: Task>(self, task: T) -> T::Output {
        /// A function of its own, as for the other instruction sets.
        #[inline(never)]
        fn run<T: Task>(task: T) -> T::Output {
            task.run(Scalar)
        }
        run(task)
    }

    #[inline(always)]
    fn splat(self, value: f32) -> F32x8 {
        F32x8([value; WIDTH])
    }

    #[inline(always)]
    fn load(self, row: &Row) -> F32x8 {
        F32x8(row.0)
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
        F32x8(std::array::from_fn(|lane| lanes.0[(lane + WIDTH / 2) % WIDTH]))
    }

    #[inline(always)]
    fn push<const ENTERS: bool>(
        self,
        children: &Row,
        interval: Interval<F32x8>,
        order: &Order,
        window: Window<'_>,
    ) -> Pushed {
        push::<ENTERS>(children, interval.enter.less_or_equal(interval.exit), interval.enter.0, order, window)
    }

    #[inline(always)]
    fn prefetch(self, _place: *const Row) {}
}

/// [`Isa::push`] lane by lane, for instruction sets that cannot permute by a variable.
#[inline(always)]
pub(super) fn push<const ENTERS: bool>(
    children: &Row,
    mask: u32,
    enter: [f32; WIDTH],
    order: &Order,
    Window { children: into_children, enters: into_enters }: Window<'_>,
) -> Pushed {
    let (mut count, mut pushed) = (0, 0);
    for (place, lane) in order.0.into_iter().enumerate() {
        let lane = lane as usize % WIDTH;
        // Written always and kept if the bit is set: whether it is cannot be predicted.
        into_children[count % WIDTH] = children.0[lane];
        if ENTERS {
            into_enters[count % WIDTH] = enter[lane];
        }
        let bit = mask >> lane & 1;
        count += bit as usize;
        pushed |= bit << place;
    }
    Pushed(pushed)
}

/// Eight `f32`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F32x8([f32; WIDTH]);

impl F32x8 {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|lane| f(self.0[lane], other.0[lane])))
    }

    #[inline(always)]
    fn mask(self, other: Self, f: impl Fn(&f32, &f32) -> bool) -> u32 {
        (0..WIDTH).fold(0, |mask, lane| mask | u32::from(f(&self.0[lane], &other.0[lane])) << lane)
    }
}

impl Lanes for F32x8 {
    type Array = [f32; WIDTH];

    #[inline(always)]
    fn splat(self, value: f32) -> Self {
        Self([value; WIDTH])
    }

    #[inline(always)]
    fn to_array(self) -> [f32; WIDTH] {
        self.0
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
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
        Self(self.0.map(f32::abs))
    }

    #[inline(always)]
    fn reciprocal(self) -> Self {
        Self(self.0.map(|x| 1.0 / x))
    }

    #[inline(always)]
    fn select(self, mask: u32, other: Self) -> Self {
        Self(std::array::from_fn(|lane| if mask >> lane & 1 == 1 { self.0[lane] } else { other.0[lane] }))
    }

    #[inline(always)]
    fn less(self, other: Self) -> u32 {
        self.mask(other, f32::lt)
    }

    #[inline(always)]
    fn less_or_equal(self, other: Self) -> u32 {
        self.mask(other, f32::le)
    }

    #[inline(always)]
    fn equal(self, other: Self) -> u32 {
        self.mask(other, f32::eq)
    }
}

operators! { F32x8:
    Add::add(a, b) => a.zip(b, |a, b| a + b);
    Sub::sub(a, b) => a.zip(b, |a, b| a - b);
    Mul::mul(a, b) => a.zip(b, |a, b| a * b);
}
