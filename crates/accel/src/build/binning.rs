//! Object splits by bins: where to split a range, and the splitting.
//!
//! Source: Wald, *On Fast Construction of SAH-based Bounding Volume Hierarchies*, Interactive Ray Tracing 2007. Deviations: all
//! three axes are binned in one pass, costs count blocks of triangles, which are tested at once, of large ranges only a sample is
//! binned, and of small ones into fewer bins.

use rayon::prelude::*;

use super::bins::{Bins, Fill, FindPlane, MAX_BINS, Plane, add};
use super::mapping::Mapping;
use super::part::{Parted, Partition};
use super::reference::{Box8, Extent, Reference};
use super::split::{Halves, Range};
use crate::kernel::{Isa, Machine, Task};

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
        bins.multiply_counts((SAMPLE_STRIDE / SAMPLE) as u32);
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
                bins.merge(&others);
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
            bins.merge(&others);
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
                add(isa, self.bins, reference, self.mapping.bins(isa, reference));
            }
        }
    }
}
