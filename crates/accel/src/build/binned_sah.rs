//! Binned surface area heuristic.
//!
//! Source: Wald, *On Fast Construction of SAH-based Bounding Volume Hierarchies*, Interactive Ray Tracing 2007. Deviations: all
//! three axes are binned in one pass, a leaf's cost counts blocks of triangles, which are tested at once, and small ranges
//! are split exactly, without bins.

use rayon::prelude::*;

use super::reference::{Box8, Extent, Reference};
use super::split::{Halves, Splitter, build_tree};
use super::{BinaryTree, MAX_LEAF, median, sweep};
use crate::kernel::{Isa, Lanes, Row, Task, Tier, dispatch};

pub(super) const MAX_BINS: usize = 32;

/// Ranges of at least this many primitives are binned by all threads.
const PARALLEL_BINNING: usize = 1 << 16;

/// How many primitives one task bins.
const BINNING_CHUNK: usize = 1 << 13;

/// Builds by binned SAH with `bins` bins an axis.
pub(super) fn build(references: Vec<Reference>, bins: u32, tier: Tier) -> BinaryTree {
    build_tree(references, &BinnedSah { bins: (bins as usize).clamp(2, MAX_BINS), tier })
}

struct BinnedSah {
    bins: usize,
    tier: Tier,
}

/// What falls into the bins of one axis.
#[derive(Clone, Copy)]
struct AxisBins {
    bounds: [Box8; MAX_BINS],
    counts: [u32; MAX_BINS],
}

/// The bins of the three axes.
type Bins = [AxisBins; 3];

const EMPTY_BINS: Bins = [AxisBins { bounds: [Box8::EMPTY; MAX_BINS], counts: [0; MAX_BINS] }; 3];

/// From a doubled centre to bins: the integral part of `(center − origin) · scale`.
#[derive(Clone, Copy)]
struct Mapping {
    origin: [f32; 4],
    scale: [f32; 4],
}

/// Adding it to a number from 0 to 32 rounds that to 1 / 2^[`FRACTION_BITS`] and leaves it in the lowest bits.
const ROUNDING: f32 = (1 << (23 - FRACTION_BITS)) as f32;
const FRACTION_BITS: u32 = 6;

impl Mapping {
    fn new(centers: &Box8, bins: usize) -> Self {
        // So much below the number of bins that rounding does not reach it.
        let last = bins as f32 - 1.0 / (1 << FRACTION_BITS) as f32;
        // An axis without extent, or one that overflows, sends everything to bin 0 and is never split.
        let scale = centers.diagonal().map(|extent| {
            let scale = last / extent;
            if extent > 0.0 && scale.is_finite() { scale } else { 0.0 }
        });
        let [x, y, z, _] = centers.min();
        Self { origin: [x, y, z, 0.0], scale: [scale[0], scale[1], scale[2], 0.0] }
    }

    #[inline(always)]
    fn bin(&self, center: f32, axis: usize) -> u32 {
        let position = (center - self.origin[axis]) * self.scale[axis] + ROUNDING;
        (position.to_bits() >> FRACTION_BITS) % MAX_BINS as u32
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
struct Plane {
    cost: f32,
    axis: usize,
    bin: u32,
}

impl Splitter for BinnedSah {
    fn split(&self, references: &mut [Reference], extent: &Extent) -> Option<Halves> {
        let count = references.len();
        if count <= sweep::MAX_COUNT {
            return match sweep::split(references, extent) {
                sweep::Outcome::Leaf => None,
                sweep::Outcome::Split(halves) => Some(halves),
                sweep::Outcome::Undecided => Some(median::halve(references, extent)),
            };
        }
        let mapping = Mapping::new(&extent.centers, self.bins);
        let bins = self.fill(references, &mapping);
        // Costs that are NaN, infinite or zero, from boxes beyond the range of f32 or without area, end in the median.
        match best_plane(&bins, self.bins) {
            Some(plane) if plane.cost > 0.0 => {
                let (left_count, [left, right]) =
                    dispatch(self.tier, Partition { references, mapping: &mapping, plane });
                let row = &bins[plane.axis].bounds;
                let union = |bins: &[Box8]| bins.iter().copied().fold(Box8::EMPTY, Box8::union);
                let (left_bins, right_bins) = row[..self.bins].split_at(plane.bin as usize + 1);
                Some(Halves {
                    left_count,
                    left: Extent { bounds: union(left_bins), centers: left },
                    right: Extent { bounds: union(right_bins), centers: right },
                })
            }
            _ => Some(median::halve(references, extent)),
        }
    }
}

impl BinnedSah {
    fn fill(&self, references: &[Reference], mapping: &Mapping) -> Bins {
        let fill_chunk = |references| {
            let mut bins = EMPTY_BINS;
            dispatch(self.tier, Fill { references, mapping, bins: &mut bins });
            bins
        };
        if references.len() < PARALLEL_BINNING {
            return fill_chunk(references);
        }
        references
            .par_chunks(BINNING_CHUNK)
            .map(fill_chunk)
            .reduce(|| EMPTY_BINS, |bins, others| merge(bins, &others, self.bins))
    }
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
}

impl Task for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) {
        for reference in self.references {
            let places = self.mapping.bins(reference);
            for (row, place) in self.bins.iter_mut().zip(places) {
                let place = place as usize;
                row.bounds[place] = row.bounds[place].union_on(isa, reference.bounds());
                row.counts[place] += 1;
            }
        }
    }
}

/// Minimum and integer sums: the same in any order.
fn merge(mut bins: Bins, others: &Bins, count: usize) -> Bins {
    for (row, other) in bins.iter_mut().zip(others) {
        for bin in 0..count {
            row.bounds[bin] = row.bounds[bin].union(other.bounds[bin]);
            row.counts[bin] += other.counts[bin];
        }
    }
    bins
}

/// The plane with the least cost `A_left n_left + A_right n_right`, counted in blocks; the first of equals.
#[inline(never)]
fn best_plane(bins: &Bins, count: usize) -> Option<Plane> {
    let mut best: Option<Plane> = None;
    for (axis, row) in bins.iter().enumerate() {
        let mut right_costs = [0.0; MAX_BINS];
        let (mut bounds, mut primitives) = (Box8::EMPTY, 0);
        for i in (1..count).rev() {
            bounds = bounds.union(row.bounds[i]);
            primitives += row.counts[i];
            // Infinite times zero over no primitives: NaN, which no comparison takes.
            right_costs[i] = bounds.half_area() * blocks(primitives);
        }
        let (mut bounds, mut primitives) = (Box8::EMPTY, 0);
        for i in 0..count - 1 {
            bounds = bounds.union(row.bounds[i]);
            primitives += row.counts[i];
            let cost = bounds.half_area() * blocks(primitives) + right_costs[i + 1];
            if cost < best.map_or(f32::INFINITY, |best| best.cost) {
                best = Some(Plane { cost, axis, bin: i as u32 });
            }
        }
    }
    best
}

/// Moves what goes left to the front, without branches that cannot be predicted; returns how many these are, and the
/// boxes about the doubled centres of both sides.
struct Partition<'a> {
    references: &'a mut [Reference],
    mapping: &'a Mapping,
    plane: Plane,
}

impl Task for Partition<'_> {
    type Output = (usize, [Box8; 2]);

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Self::Output {
        let Self { references, mapping, plane } = self;
        // Added to a point, infinity removes it from every minimum. By bits, because a branch could not be predicted.
        let removed_if = |condition: bool| {
            isa.splat(f32::from_bits(u32::from(condition).wrapping_neg() & f32::INFINITY.to_bits()))
        };
        let mut left = isa.splat(f32::INFINITY);
        let mut right = isa.splat(f32::INFINITY);
        let mut left_count = 0;
        for i in 0..references.len() {
            let reference = references[i];
            let center = isa.load(&reference.doubled_center_row());
            let goes_right = mapping.bin(reference.doubled_center_at(plane.axis), plane.axis) > plane.bin;
            left = left.min(center + removed_if(goes_right));
            right = right.min(center + removed_if(!goes_right));
            references[i] = references[left_count];
            references[left_count] = reference;
            left_count += usize::from(!goes_right);
        }
        (left_count, [left, right].map(|lanes| Box8::from_row(Row(lanes.to_array()))))
    }
}
