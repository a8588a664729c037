//! Binned surface area heuristic.
//!
//! Source: Wald, *On Fast Construction of SAH-based Bounding Volume Hierarchies*, Interactive Ray Tracing 2007. Deviations: all
//! three axes are binned in one pass, and a leaf's cost counts blocks of four primitives, which are tested at once.

use rayon::prelude::*;
use sahl_math::{Bounds3, Vec3};

use super::median;
use super::split::{Extent, Halves, Reference, Splitter, build_tree};
use super::{BinaryTree, BuildInput};

const MAX_BINS: usize = 32;

/// Ranges of at least this many primitives are binned by all threads.
const PARALLEL_BINNING: usize = 1 << 16;

/// How many primitives one task bins.
const BINNING_CHUNK: usize = 1 << 13;

/// Primitives that are tested at once.
const BLOCK: u32 = 4;

/// No leaf holds more.
const MAX_LEAF: usize = 8;

/// The cost of testing a block against that of visiting a node.
const BLOCK_COST: f32 = 1.0;

/// Builds by binned SAH with `bins` bins an axis.
pub(super) fn build(input: BuildInput<'_>, bins: u32) -> BinaryTree {
    build_tree(input, &BinnedSah { bins: (bins as usize).clamp(2, MAX_BINS) })
}

struct BinnedSah {
    bins: usize,
}

/// What falls into one bin.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds3,
    count: u32,
}

/// The bins of the three axes.
type Bins = [[Bin; MAX_BINS]; 3];

const EMPTY_BINS: Bins = [[Bin { bounds: Bounds3::EMPTY, count: 0 }; MAX_BINS]; 3];

/// From a centre to bins: `(center − origin) · scale`.
#[derive(Clone, Copy)]
struct Mapping {
    origin: Vec3,
    scale: Vec3,
    last: usize,
}

impl Mapping {
    fn new(centers: &Bounds3, bins: usize) -> Self {
        // An axis without extent, or one that overflows, sends everything to bin 0 and is never split.
        let scale = centers.diagonal().map(|extent| {
            let scale = bins as f32 / extent;
            if extent > 0.0 && scale.is_finite() { scale } else { 0.0 }
        });
        Self { origin: centers.min, scale, last: bins - 1 }
    }

    #[inline(always)]
    fn bin(&self, center: Vec3, axis: usize) -> usize {
        // The conversion saturates: negative and NaN give zero.
        (((center[axis] - self.origin[axis]) * self.scale[axis]) as usize).min(self.last)
    }
}

/// A split between bins: those up to and including `bin` go left.
#[derive(Clone, Copy)]
struct Plane {
    cost: f32,
    axis: usize,
    bin: usize,
}

impl Splitter for BinnedSah {
    fn split(&self, references: &mut [Reference], extent: &Extent) -> Option<Halves> {
        let count = references.len();
        let bins = self.bins.min(count.next_power_of_two().max(4));
        let mapping = Mapping::new(&extent.centers, bins);
        let plane = best_plane(&fill(references, &mapping), bins);
        let area = extent.bounds.half_area();
        let leaf_cost = blocks(count as u32) * BLOCK_COST * area;
        // NaN and infinite costs, from boxes beyond the range of f32, compare false and end in the median.
        let split_cost = plane.map_or(f32::INFINITY, |plane| area + plane.cost * BLOCK_COST);
        let small = count <= MAX_LEAF;
        match plane {
            Some(plane) if split_cost < leaf_cost || !small && split_cost.is_finite() => {
                Some(partition(references, &mapping, plane))
            }
            _ if small && (plane.is_some() || count <= BLOCK as usize) => None,
            _ => Some(median::halve(references, extent)),
        }
    }
}

/// How many blocks `count` primitives fill.
#[inline]
fn blocks(count: u32) -> f32 {
    count.div_ceil(BLOCK) as f32
}

fn fill(references: &[Reference], mapping: &Mapping) -> Bins {
    if references.len() < PARALLEL_BINNING {
        return fill_chunk(references, mapping);
    }
    references.par_chunks(BINNING_CHUNK).map(|chunk| fill_chunk(chunk, mapping)).reduce(|| EMPTY_BINS, merge)
}

fn fill_chunk(references: &[Reference], mapping: &Mapping) -> Bins {
    let mut bins = EMPTY_BINS;
    for reference in references {
        for (axis, row) in bins.iter_mut().enumerate() {
            let bin = &mut row[mapping.bin(reference.center, axis)];
            bin.bounds = bin.bounds.union(reference.bounds);
            bin.count += 1;
        }
    }
    bins
}

/// Minimum, maximum and integer sums: the same in any order.
fn merge(mut bins: Bins, others: Bins) -> Bins {
    for (bin, other) in bins.as_flattened_mut().iter_mut().zip(others.as_flattened()) {
        bin.bounds = bin.bounds.union(other.bounds);
        bin.count += other.count;
    }
    bins
}

/// The plane with the least cost `A_left n_left + A_right n_right`, counted in blocks; the first of equals.
fn best_plane(bins: &Bins, count: usize) -> Option<Plane> {
    let mut best: Option<Plane> = None;
    for (axis, row) in bins.iter().enumerate() {
        let row = &row[..count];
        let mut right_costs = [0.0; MAX_BINS];
        let (mut bounds, mut primitives) = (Bounds3::EMPTY, 0);
        for i in (1..count).rev() {
            bounds = bounds.union(row[i].bounds);
            primitives += row[i].count;
            right_costs[i] =
                if primitives > 0 { bounds.half_area() * blocks(primitives) } else { f32::INFINITY };
        }
        let (mut bounds, mut primitives) = (Bounds3::EMPTY, 0);
        for i in 0..count - 1 {
            bounds = bounds.union(row[i].bounds);
            primitives += row[i].count;
            let cost = bounds.half_area() * blocks(primitives) + right_costs[i + 1];
            if primitives > 0 && cost.is_finite() && best.is_none_or(|best| cost < best.cost) {
                best = Some(Plane { cost, axis, bin: i });
            }
        }
    }
    best
}

/// Moves what goes left to the front.
fn partition(references: &mut [Reference], mapping: &Mapping, plane: Plane) -> Halves {
    let (mut left, mut right) = (Extent::EMPTY, Extent::EMPTY);
    let grow = |extent: Extent, reference: &Reference| Extent {
        bounds: extent.bounds.union(reference.bounds),
        centers: extent.centers.including(reference.center),
    };
    let (mut front, mut back) = (0, references.len());
    while front < back {
        if mapping.bin(references[front].center, plane.axis) <= plane.bin {
            left = grow(left, &references[front]);
            front += 1;
        } else {
            back -= 1;
            right = grow(right, &references[front]);
            references.swap(front, back);
        }
    }
    Halves { left_count: front, left, right }
}
