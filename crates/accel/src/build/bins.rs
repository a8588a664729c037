//! Bins: what a range of references holds between equidistant planes, and the best plane to split at.
//!
//! Source: Wald, *On Fast Construction of SAH-based Bounding Volume Hierarchies*, Interactive Ray Tracing 2007. Deviations: all
//! three axes are binned in one pass, costs count blocks of triangles, which are tested at once, of large ranges only a sample is
//! binned, and of small ones into fewer bins.

use rayon::prelude::*;

use super::MAX_LEAF;
use super::part::{Parted, Partition};
use super::reference::{Box8, Extent, Reference};
use super::split::{Halves, Range};
use crate::kernel::{Isa, Machine, Task};

/// The most bins an axis.
pub(super) const MAX_BINS: usize = 16;

/// Of ranges of at least this many references a sample is binned. Against 4096 the expected cost of rays differs by less than 0.3 % on four
/// models; with 256, where a sample is 32 references, it grows by 0.6 % on one.
const SAMPLED: usize = 1 << 9;

/// Smaller ranges ...
const FEW: usize = 64;

/// ... get no more bins than these. Against 16 the expected cost of rays differs by less than 0.1 % on three of four models and is 0.6 %
/// lower on one, with 1 % to 2 % more blocks.
const FEWER_BINS: usize = 8;

/// Of every so many references ...
const SAMPLE_STRIDE: usize = 64;

/// ... the first so many are in the sample: neighbours, which share lines of the cache.
const SAMPLE: usize = SAMPLE_STRIDE / 8;

/// What a split may cost against what the sample promised.
const TOLERANCE: f32 = 1.1;

/// Ranges of at least this many references are binned by all threads.
const PARALLEL: usize = 1 << 16;

/// How many references one task bins.
const CHUNK: usize = 1 << 13;

/// Ranges of at least this many references are worth a second set of bins.
const DOUBLE: usize = 512;

/// How to bin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Binning {
    bins: usize,
    pub(super) machine: Machine,
}

/// A split of a range that was found and not made.
#[derive(Clone, Copy)]
pub(super) struct ObjectSplit {
    mapping: Mapping,
    plane: Plane,
    /// The boxes about both sides, if a sample was binned about those of the sample.
    pub(super) bounds: [Box8; 2],
    /// If a sample was binned: the bins of what may not be cut.
    pub(super) sample: Option<Bins>,
}

impl ObjectSplit {
    pub(super) fn cost(&self) -> f32 {
        self.plane.cost
    }

    pub(super) fn axis(&self) -> usize {
        self.plane.axis
    }
}

impl Binning {
    /// `bins` are clamped to 2 … [`MAX_BINS`].
    pub(super) fn new(bins: u32, machine: Machine) -> Self {
        Self { bins: (bins as usize).clamp(2, MAX_BINS), machine }
    }

    /// Whether there are [`MAX_BINS`].
    pub(super) fn has_all_bins(&self) -> bool {
        self.bins == MAX_BINS
    }

    /// Splits where it costs least; `None` as of [`Self::find`].
    pub(super) fn split(&self, range: &mut Range<'_>) -> Option<Halves> {
        let found = self.find(range)?;
        self.make(range, &found)
    }

    /// Where to split for the least cost; `None` where all costs are NaN, infinite or zero, for boxes beyond the range of `f32` or
    /// without area.
    #[inline(never)]
    pub(super) fn find(&self, range: &Range<'_>) -> Option<ObjectSplit> {
        let sampled = if range.count >= SAMPLED { self.find_by_sample(range) } else { None };
        sampled.or_else(|| self.find_by_all(range))
    }

    fn find_by_sample(&self, range: &Range<'_>) -> Option<ObjectSplit> {
        // As of splits of space, for which the bins are used once more.
        let mapping = Mapping::new(&range.extent.bounds, self.bins).doubled();
        let mut others = Bins::EMPTY;
        self.fill_others(range, &mapping, &mut others);
        let mut bins = others;
        self.fill_chunk(&range.slots[..range.divisible], &mapping, &mut bins);
        let plane = self.best_plane(&bins, self.bins)?;
        Some(ObjectSplit { mapping, plane, bounds: bins.sides(plane, self.bins), sample: Some(others) })
    }

    fn find_by_all(&self, range: &Range<'_>) -> Option<ObjectSplit> {
        let count = if range.count < FEW { self.bins.min(FEWER_BINS) } else { self.bins };
        let mapping = Mapping::new(&range.extent.centers, count);
        let mut bins = Bins::EMPTY;
        self.fill(&range.slots[..range.count], &mapping, &mut bins);
        let plane = self.best_plane(&bins, count)?;
        Some(ObjectSplit { mapping, plane, bounds: bins.sides(plane, count), sample: None })
    }

    /// Makes a split that was found; `None` if a sample has promised too much, and binning all finds no split.
    pub(super) fn make(&self, range: &mut Range<'_>, found: &ObjectSplit) -> Option<Halves> {
        let ObjectSplit { mapping, plane, bounds, .. } = found;
        if found.sample.is_none() {
            return Some(self.partition(range, mapping, *plane, Some(*bounds)));
        }
        let halves = self.partition(range, mapping, *plane, None);
        if halves.cost() <= plane.cost * TOLERANCE {
            return Some(halves);
        }
        let ObjectSplit { mapping, plane, bounds, .. } = self.find_by_all(range)?;
        Some(self.partition(range, &mapping, plane, Some(bounds)))
    }

    /// Bins what may not be cut, or a sample of it if the range is large, for which it counts in full.
    pub(super) fn fill_others(&self, range: &Range<'_>, mapping: &Mapping, bins: &mut Bins) {
        let others = &range.slots[range.divisible..range.count];
        if range.count < SAMPLED {
            return self.fill_chunk(others, mapping, bins);
        }
        self.machine.run(FillSample { references: others, mapping, bins });
        for row in &mut bins.0 {
            row.counts = row.counts.map(|count| count * (SAMPLE_STRIDE / SAMPLE) as u32);
        }
    }

    fn fill(&self, references: &[Reference], mapping: &Mapping, bins: &mut Bins) {
        if references.len() < PARALLEL {
            return self.fill_chunk(references, mapping, bins);
        }
        let fill_chunk = |references: &[Reference]| {
            let mut bins = Bins::EMPTY;
            self.fill_chunk(references, mapping, &mut bins);
            bins
        };
        *bins = references.par_chunks(CHUNK).map(fill_chunk).reduce(
            || Bins::EMPTY,
            |mut bins, others| {
                merge(&mut bins, &others);
                bins
            },
        );
    }

    fn fill_chunk(&self, references: &[Reference], mapping: &Mapping, bins: &mut Bins) {
        if references.len() < DOUBLE {
            self.machine.run(Fill { references, mapping, bins, others: None });
        } else {
            let mut others = Bins::EMPTY;
            self.machine.run(Fill { references, mapping, bins, others: Some(&mut others) });
            merge(bins, &others);
        }
    }

    fn best_plane(&self, bins: &Bins, count: usize) -> Option<Plane> {
        self.machine.run(FindPlane { bins, count })
    }

    /// Parts a range; `bounds` are the boxes about both sides, if known.
    fn partition(
        &self,
        range: &mut Range<'_>,
        mapping: &Mapping,
        plane: Plane,
        bounds: Option<[Box8; 2]>,
    ) -> Halves {
        let (divisible, others) = range.slots[..range.count].split_at_mut(range.divisible);
        let counts = [divisible.len(), others.len()];
        let part = |references: &mut [Reference]| match bounds {
            Some(_) => self.machine.run(Partition::<false> { references, mapping, plane }),
            None => self.machine.run(Partition::<true> { references, mapping, plane }),
        };
        let [first, second] = [divisible, others].map(part);
        let extents = [0, 1].map(|side| {
            let found = first.boxes[side].union(second.boxes[side]);
            match bounds {
                Some(bounds) => Extent { bounds: bounds[side], centers: found },
                None => Extent::around(found),
            }
        });
        Halves {
            divisible: [first.left_count, counts[0] - first.left_count],
            others: [second.left_count, counts[1] - second.left_count],
            added: 0,
            extents,
        }
    }
}

impl Binning {
    /// Parts references by their doubled centres, and finds the boxes about both sides.
    pub(super) fn part(&self, references: &mut [Reference], mapping: &Mapping, plane: Plane) -> Parted {
        self.machine.run(Partition::<true> { references, mapping, plane })
    }
}

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
    fn sides(&self, plane: Plane, count: usize) -> [Box8; 2] {
        let (left, right) = self.0[plane.axis].bounds[..count].split_at(plane.bin as usize + 1);
        [left, right].map(|bins| bins.iter().copied().fold(Box8::EMPTY, Box8::union))
    }

    /// The box about what fell into a bin of an axis, and how many these are.
    pub(super) fn bin(&self, axis: usize, bin: usize) -> (Box8, u32) {
        (self.0[axis].bounds[bin], self.0[axis].counts[bin])
    }
}

/// From a doubled centre to bins: the integral part of `(center − origin) · scale`.
#[derive(Clone, Copy)]
pub(super) struct Mapping {
    origin: [f32; 4],
    scale: [f32; 4],
}

/// Adding it to a number from 0 to 16 rounds that to 1 / 2^[`FRACTION_BITS`] and leaves it in the lowest bits.
const ROUNDING: f32 = (1 << (23 - FRACTION_BITS)) as f32;
const FRACTION_BITS: u32 = 6;

impl Mapping {
    pub(super) fn new(bounds: &Box8, bins: usize) -> Self {
        // So much below the number of bins that rounding does not reach it.
        let last = bins as f32 - 1.0 / (1 << FRACTION_BITS) as f32;
        // An axis without extent, or one that overflows, sends everything to bin 0 and is never split.
        let scale = bounds.diagonal().map(|extent| {
            let scale = last / extent;
            if extent > 0.0 && scale.is_finite() { scale } else { 0.0 }
        });
        let [x, y, z, _] = bounds.min();
        Self { origin: [x, y, z, 0.0], scale: [scale[0], scale[1], scale[2], 0.0] }
    }

    /// The same bins, for doubled positions.
    pub(super) fn doubled(&self) -> Self {
        Self { origin: self.origin.map(|x| x * 2.0), scale: self.scale.map(|x| x * 0.5) }
    }

    #[inline(always)]
    pub(super) fn bin(&self, position: f32, axis: usize) -> u32 {
        let position = (position - self.origin[axis]) * self.scale[axis] + ROUNDING;
        (position.to_bits() >> FRACTION_BITS) % MAX_BINS as u32
    }

    /// Where bin `bin` begins.
    #[inline(always)]
    pub(super) fn position(&self, bin: usize, axis: usize) -> f32 {
        self.origin[axis] + bin as f32 / self.scale[axis]
    }

    /// The bins of a reference on the three axes.
    #[inline(always)]
    fn bins(&self, reference: &Reference) -> [u32; 3] {
        let center = reference.doubled_center();
        let bins: [u32; 4] = std::array::from_fn(|axis| self.bin(center[axis], axis));
        [bins[0], bins[1], bins[2]]
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
struct Fill<'a> {
    references: &'a [Reference],
    mapping: &'a Mapping,
    bins: &'a mut Bins,
    /// A second set for every other reference: neighbours often fall into the same bin, and would wait for each other.
    others: Option<&'a mut Bins>,
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
                add(isa, bins, first, mapping.bins(first));
                add(isa, others, second, mapping.bins(second));
            }
            rest = last;
        }
        for reference in rest {
            add(isa, bins, reference, mapping.bins(reference));
        }
    }
}

/// Bins a sample.
struct FillSample<'a> {
    references: &'a [Reference],
    mapping: &'a Mapping,
    bins: &'a mut Bins,
}

impl Task for FillSample<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) {
        for chunk in self.references.chunks(SAMPLE_STRIDE) {
            for reference in &chunk[..SAMPLE.min(chunk.len())] {
                add(isa, self.bins, reference, self.mapping.bins(reference));
            }
        }
    }
}

#[inline(always)]
fn add<I: Isa>(isa: I, bins: &mut Bins, reference: &Reference, places: [u32; 3]) {
    for (row, place) in bins.0.iter_mut().zip(places) {
        let place = place as usize;
        row.bounds[place] = row.bounds[place].union_on(isa, reference.bounds());
        row.counts[place] += 1;
    }
}

/// Minimum and integer sums: the same in any order.
fn merge(bins: &mut Bins, others: &Bins) {
    for (row, other) in bins.0.iter_mut().zip(&others.0) {
        for bin in 0..MAX_BINS {
            row.bounds[bin] = row.bounds[bin].union(other.bounds[bin]);
            row.counts[bin] += other.counts[bin];
        }
    }
}

/// The plane with the least cost `A_left n_left + A_right n_right`, counted in blocks; the first of equals.
struct FindPlane<'a> {
    bins: &'a Bins,
    count: usize,
}

impl Task for FindPlane<'_> {
    type Output = Option<Plane>;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Option<Plane> {
        let mut best = Plane { cost: f32::INFINITY, axis: 0, bin: 0 };
        for (axis, row) in self.bins.0.iter().enumerate() {
            // Infinite times zero over no primitives: NaN, which no comparison takes.
            let mut costs = [f32::INFINITY; MAX_BINS];
            let (mut bounds, mut primitives) = (Box8::EMPTY, 0);
            for i in (1..self.count).rev() {
                bounds = bounds.union_on(isa, &row.bounds[i]);
                primitives += row.counts[i];
                costs[i - 1] = bounds.half_area() * blocks(primitives);
            }
            let (mut bounds, mut primitives) = (Box8::EMPTY, 0);
            for (i, cost) in costs[..self.count - 1].iter_mut().enumerate() {
                bounds = bounds.union_on(isa, &row.bounds[i]);
                primitives += row.counts[i];
                *cost += bounds.half_area() * blocks(primitives);
            }
            let bin = first_least(&costs);
            if costs[bin] < best.cost {
                best = Plane { cost: costs[bin], axis, bin: bin as u32 };
            }
        }
        (best.cost > 0.0 && best.cost < f32::INFINITY).then_some(best)
    }
}

/// The place of the least cost that is a number, the first of equals; without branches that cannot be predicted.
#[inline(always)]
pub(super) fn first_least<const N: usize>(costs: &[f32; N]) -> usize {
    let mut least = f32::INFINITY;
    let mut place = 0;
    for (i, &cost) in costs.iter().enumerate() {
        place = if cost < least { i } else { place };
        least = if cost < least { cost } else { least };
    }
    place
}
