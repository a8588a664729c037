//! What a kernel asks of an instruction set: eight lanes of `f32`, and how to enter code that is compiled for it.

use std::ops::{Add, Mul, Sub};

use sahl_math::Vec3;

use super::{BUNDLE_RAYS, WIDTH};

/// Eight numbers in a row, aligned for the widest load that takes them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Row(pub(crate) [f32; WIDTH]);

impl Row {
    pub(crate) const fn splat(value: f32) -> Self {
        Self([value; WIDTH])
    }
}

/// A number for each ray of a bundle, aligned for the widest load that takes them.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct BundleRow(pub(crate) [f32; BUNDLE_RAYS]);

impl BundleRow {
    pub(crate) const fn splat(value: f32) -> Self {
        Self([value; BUNDLE_RAYS])
    }
}

/// A computation that is compiled once for every instruction set.
///
/// `run` and everything it inlines must be `#[inline(always)]`: only then does the code become part of the function for which
/// the instruction set is enabled.
pub(crate) trait Task {
    type Output;
    fn run<I: Isa>(self, isa: I) -> Self::Output;
}

/// An instruction set that this processor has: a value of the type is the proof.
pub(crate) trait Isa: Copy {
    /// Eight lanes.
    type F32: Lanes<Array = [f32; WIDTH]>;

    /// The most lanes that are worked on at once.
    type Wide: Lanes;

    /// How many lanes [`Self::Wide`] has: a multiple of [`WIDTH`] that divides [`BUNDLE_RAYS`].
    const WIDE: usize;

    /// Runs a task in code compiled for the instruction set.
    fn enter<T: Task>(self, task: T) -> T::Output;

    /// The same number in every lane.
    fn splat(self, value: f32) -> Self::F32;

    /// The lanes of a row.
    fn load(self, row: &Row) -> Self::F32;

    /// The lanes of numbers that lie anywhere.
    #[inline(always)]
    fn load_unaligned(self, numbers: &[f32; WIDTH]) -> Self::F32 {
        // The compiler makes one load of it where an instruction set has one.
        self.load(&Row(*numbers))
    }

    /// Exchanges rows and lanes: what was lane `i` of row `k` becomes lane `k` of row `i`.
    #[inline(always)]
    fn transpose(self, rows: [Self::F32; WIDTH]) -> [Self::F32; WIDTH] {
        let rows = rows.map(Self::F32::to_array);
        std::array::from_fn(|lane| self.load(&Row(rows.map(|row| row[lane]))))
    }

    /// The numbers of a group of [`Self::WIDE`] rays.
    fn load_wide(self, rows: &BundleRow, group: usize) -> Self::Wide;

    /// Replaces the numbers of a group of rays.
    fn store_wide(self, lanes: Self::Wide, rows: &mut BundleRow, group: usize);

    /// The lanes from the fifth on, then those before it.
    fn swap_halves(self, lanes: Self::F32) -> Self::F32;

    /// Appends to the window those children whose interval is not empty, in the given order, and, if `ENTERS`, the
    /// parameters at which they are entered. The window's places after them hold anything.
    fn push<const ENTERS: bool>(
        self,
        children: &Row,
        interval: Interval<Self::F32>,
        order: &Order,
        window: Window<'_>,
    ) -> Pushed;

    /// Asks for the memory of a place to be brought nearer. Any address is allowed.
    fn prefetch(self, place: *const Row);
}

/// Lanes of `f32`. Every instruction set gives the same bits.
pub(crate) trait Lanes: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// The lanes in memory.
    type Array: Copy + AsRef<[f32]>;
    fn to_array(self) -> Self::Array;
    /// The same number in every lane: to have lanes at all proves that there are such.
    fn splat(self, value: f32) -> Self;
    /// The smaller of each pair; the second where either is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger of each pair; the second where either is NaN.
    fn max(self, other: Self) -> Self;
    /// The smallest lane; none may be NaN.
    fn least(self) -> f32;
    /// The largest lane; none may be NaN.
    fn greatest(self) -> f32;
    /// The absolute values.
    fn abs(self) -> Self;
    /// `1 / x`, rounded as a division.
    fn reciprocal(self) -> Self;
    /// The lanes of `self` whose bit is set, those of `other` elsewhere.
    fn select(self, mask: u32, other: Self) -> Self;
    /// One bit a lane: whether `self < other`; false for NaN.
    fn less(self, other: Self) -> u32;
    /// One bit a lane: whether `self <= other`; false for NaN.
    fn less_or_equal(self, other: Self) -> u32;
    /// One bit a lane: whether `self == other`; false for NaN.
    fn equal(self, other: Self) -> u32;
}

/// Implements the operators of lanes: the trait, its method with names for the operands, and the result.
macro_rules! operators {
    ($lanes:ident: $($operator:ident::$method:ident($left:ident, $right:ident) => $result:expr;)*) => {$(
        impl std::ops::$operator for $lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let ($left, $right) = (self, other);
                $result
            }
        }
    )*};
}
pub(super) use operators;

/// What is left of a row of lanes when they are combined pair by pair.
#[inline(always)]
pub(super) fn reduce(mut lanes: [f32; WIDTH], combine: impl Fn(f32, f32) -> f32) -> f32 {
    for step in [4, 2, 1] {
        for lane in 0..step {
            lanes[lane] = combine(lanes[lane], lanes[lane + step]);
        }
    }
    lanes[0]
}

/// Where a ray enters and leaves eight boxes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval<F> {
    pub(crate) enter: F,
    pub(crate) exit: F,
}

/// The signs of a ray's direction, one bit an axis, set where it is negative: at most 7.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub(crate) struct Octant(u8);

impl Octant {
    /// In which lanes are appended in ascending order.
    pub(crate) const ASCENDING: Self = Self(7);

    #[inline(always)]
    pub(crate) fn new(negative: [bool; 3]) -> Self {
        Self(negative.iter().rev().fold(0, |bits, &bit| bits << 1 | u8::from(bit)))
    }

    /// That of an index.
    #[inline(always)]
    pub(super) const fn at(index: usize) -> Self {
        Self((index & 7) as u8)
    }

    /// That of a direction, by the sign bits: zeros count as what is next to them on their side.
    #[inline(always)]
    pub(crate) fn of(direction: Vec3) -> Self {
        let [x, y, z] = [direction.x, direction.y, direction.z].map(f32::to_bits);
        Self((x >> 31 | y >> 30 & 2 | z >> 29 & 4) as u8)
    }

    #[inline(always)]
    pub(crate) const fn index(self) -> usize {
        (self.0 & 7) as usize
    }
}

/// Which children were pushed: bit `k` stands for lane `octant ^ (7 - k)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub(crate) struct Pushed(pub(crate) u32);

impl Pushed {
    /// How many there are.
    #[inline(always)]
    pub(crate) fn count(self) -> usize {
        self.0.count_ones() as usize
    }

    /// The lane of the one that was pushed last; any lane if there is none.
    #[inline(always)]
    pub(crate) fn last_lane(self, octant: Octant) -> usize {
        const UNUSED: u32 = u32::BITS - WIDTH as u32;
        (self.0.leading_zeros().wrapping_sub(UNUSED) as usize ^ octant.index()) % WIDTH
    }
}

/// Eight free places of a stack.
pub(crate) struct Window<'a> {
    pub(crate) children: &'a mut [f32; WIDTH],
    pub(crate) enters: &'a mut [f32; WIDTH],
}

/// The lanes of a node in the order in which they are pushed: by descending `lane ^ octant`, about from far to near.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Order(pub(crate) [u32; WIDTH]);

impl Order {
    #[inline(always)]
    pub(crate) const fn of(octant: Octant) -> &'static Self {
        const ORDERS: [Order; 8] = {
            let mut orders = [Order([0; WIDTH]); 8];
            let mut octant = 0;
            while octant < 8 {
                let mut place = 0;
                while place < WIDTH {
                    orders[octant].0[place] = (octant ^ (WIDTH - 1 - place)) as u32;
                    place += 1;
                }
                octant += 1;
            }
            orders
        };
        &ORDERS[(octant.0 & 7) as usize]
    }
}
