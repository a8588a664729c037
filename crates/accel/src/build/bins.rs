//! Bins: what a range of references holds between equidistant planes, and the best plane to split at.

use super::MAX_LEAF;
use super::mapping::Mapping;
use super::reference::{Box8, Reference};
use crate::kernel::{Isa, Task};

/// The most bins an axis.
pub(super) const MAX_BINS: usize = 16;

/// What falls into the bins of one axis.
#[derive(Clone, Copy)]
struct AxisBins {
    bounds: [Box8; MAX_BINS],
    counts: [u32; MAX_BINS],
}

/// The bins of the three axes.
#[derive(Clone, Copy)]
pub(super) struct Bins([AxisBins; 3]);

impl Bins {
    pub(super) const EMPTY: Self =
        Self([AxisBins { bounds: [Box8::EMPTY; MAX_BINS], counts: [0; MAX_BINS] }; 3]);

    /// The boxes about what lies on both sides of a plane.
    pub(super) fn sides(&self, plane: Plane, count: usize) -> [Box8; 2] {
        let (left, right) = self.0[plane.axis].bounds[..count].split_at(plane.bin as usize + 1);
        [left, right].map(|bins| bins.iter().copied().fold(Box8::EMPTY, Box8::union))
    }

    /// Adds what has fallen into other bins: by minimum and integer sums, the same in any order.
    pub(super) fn merge(&mut self, others: &Self) {
        for (row, other) in self.0.iter_mut().zip(&others.0) {
            for bin in 0..MAX_BINS {
                row.bounds[bin] = row.bounds[bin].union(other.bounds[bin]);
                row.counts[bin] += other.counts[bin];
            }
        }
    }

    /// Lets everything that is in the bins count several times.
    pub(super) fn multiply_counts(&mut self, factor: u32) {
        for row in &mut self.0 {
            row.counts = row.counts.map(|count| count * factor);
        }
    }

    /// The box about what fell into a bin of an axis, and how many these are.
    pub(super) fn bin(&self, axis: usize, bin: usize) -> (Box8, u32) {
        (self.0[axis].bounds[bin], self.0[axis].counts[bin])
    }
}

/// A split between bins: those up to and including `bin` go left.
#[derive(Clone, Copy)]
pub(super) struct Plane {
    pub(super) cost: f32,
    pub(super) axis: usize,
    pub(super) bin: u32,
}

/// How many blocks `count` primitives fill.
#[inline(always)]
pub(super) fn blocks(count: u32) -> f32 {
    count.div_ceil(MAX_LEAF as u32) as f32
}

/// Bins references one after the other.
pub(super) struct Fill<'a> {
    pub(super) references: &'a [Reference],
    pub(super) mapping: &'a Mapping,
    pub(super) bins: &'a mut Bins,
    /// A second set for every other reference: neighbours often fall into the same bin, and would wait for each other.
    pub(super) others: Option<&'a mut Bins>,
}

impl Task for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) {
        let Self { references, mapping, bins, others } = self;
        let mut rest = references;
        if let Some(others) = others {
            let (pairs, last) = references.as_chunks();
            for [first, second] in pairs {
                add(isa, bins, first, mapping.bins(isa, first));
                add(isa, others, second, mapping.bins(isa, second));
            }
            rest = last;
        }
        for reference in rest {
            add(isa, bins, reference, mapping.bins(isa, reference));
        }
    }
}

/// Puts a reference into its bins on the three axes.
#[inline(always)]
pub(super) fn add<I: Isa>(isa: I, bins: &mut Bins, reference: &Reference, places: [usize; 3]) {
    for (row, place) in bins.0.iter_mut().zip(places) {
        row.bounds[place] = row.bounds[place].union_on(isa, reference.bounds());
        row.counts[place] += 1;
    }
}

/// The plane with the least cost `A_left n_left + A_right n_right`, counted in blocks; the first of equals.
pub(super) struct FindPlane<'a> {
    pub(super) bins: &'a Bins,
    pub(super) count: usize,
}

impl Task for FindPlane<'_> {
    type Output = Option<Plane>;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Option<Plane> {
        let count = self.count.min(MAX_BINS);
        let mut best = Plane { cost: f32::INFINITY, axis: 0, bin: 0 };
        for (axis, row) in self.bins.0.iter().enumerate() {
            // Infinite times zero over no primitives: NaN, which no comparison takes.
            let mut right_costs = [f32::INFINITY; MAX_BINS];
            let (mut bounds, mut primitives) = (Box8::EMPTY, 0);
            for i in (1..count).rev() {
                bounds = bounds.union_on(isa, &row.bounds[i]);
                primitives += row.counts[i];
                right_costs[i] = bounds.half_area() * blocks(primitives);
            }
            let (mut bounds, mut primitives) = (Box8::EMPTY, 0);
            let mut least = (f32::INFINITY, 0);
            for (bin, right_cost) in right_costs[1..count].iter().enumerate() {
                bounds = bounds.union_on(isa, &row.bounds[bin]);
                primitives += row.counts[bin];
                let cost = bounds.half_area() * blocks(primitives) + right_cost;
                least = if cost < least.0 { (cost, bin) } else { least };
            }
            if least.0 < best.cost {
                best = Plane { cost: least.0, axis, bin: least.1 as u32 };
            }
        }
        (best.cost > 0.0 && best.cost < f32::INFINITY).then_some(best)
    }
}
