//! Bins of one axis for splits of space: what lies in them of triangles that are cut at their borders.

use sahl_math::Vec3;

use super::bins::{Bins, MAX_BINS, blocks};
use super::mapping::Mapping;
use super::reference::{Box8, Reference};
use crate::kernel::{Isa, Lanes, Row, Task};
use crate::layout::Vertices;

/// A plane with what lies on its sides.
#[derive(Clone, Copy)]
pub(super) struct SpatialSplit {
    pub(super) mapping: Mapping,
    pub(super) axis: usize,
    /// The first bin above.
    pub(super) bin: usize,
    pub(super) cost: f32,
    pub(super) sides: [Side; 2],
}

/// What lies on one side of a plane.
#[derive(Clone, Copy)]
pub(super) struct Side {
    pub(super) bounds: Box8,
    pub(super) count: u32,
}

impl Side {
    const EMPTY: Self = Self { bounds: Box8::EMPTY, count: 0 };

    fn cost(&self) -> f32 {
        self.bounds.half_area() * blocks(self.count)
    }
}

/// What falls into the bins of one axis.
pub(super) struct AxisBins {
    bounds: [Box8; MAX_BINS],
    /// How many references begin in each bin.
    begins: [u32; MAX_BINS],
    /// How many end there.
    ends: [u32; MAX_BINS],
}

const EMPTY_BINS: AxisBins =
    AxisBins { bounds: [Box8::EMPTY; MAX_BINS], begins: [0; MAX_BINS], ends: [0; MAX_BINS] };

impl AxisBins {
    /// The bins of an axis, into which references that are not cut have fallen.
    pub(super) fn of_whole(others: &Bins, axis: usize) -> Self {
        let mut bins = EMPTY_BINS;
        for bin in 0..MAX_BINS {
            (bins.bounds[bin], bins.begins[bin]) = others.bin(axis, bin);
        }
        bins.ends = bins.begins;
        bins
    }

    /// The plane between bins that costs least; the cost is infinite if costs do not tell.
    pub(super) fn best_split(&self, mapping: Mapping, axis: usize) -> SpatialSplit {
        let mut rights = [Side::EMPTY; MAX_BINS];
        let mut right = Side::EMPTY;
        for bin in (1..MAX_BINS).rev() {
            right =
                Side { bounds: right.bounds.union(self.bounds[bin]), count: right.count + self.ends[bin] };
            rights[bin] = right;
        }
        let mut best = SpatialSplit { mapping, axis, bin: 1, cost: f32::INFINITY, sides: [Side::EMPTY; 2] };
        let mut left = Side::EMPTY;
        for (bin, &right) in rights.iter().enumerate().skip(1) {
            left = Side {
                bounds: left.bounds.union(self.bounds[bin - 1]),
                count: left.count + self.begins[bin - 1],
            };
            let cost = left.cost() + right.cost();
            if cost < best.cost {
                best = SpatialSplit { bin, cost, sides: [left, right], ..best };
            }
        }
        best
    }
}

/// Bins references on one axis, cut at the borders of the bins.
pub(super) struct Fill<'a, V> {
    pub(super) references: &'a [Reference],
    pub(super) mapping: &'a Mapping,
    pub(super) axis: usize,
    pub(super) vertices: &'a V,
    pub(super) bins: &'a mut AxisBins,
}

impl<V: Vertices> Task for Fill<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) {
        let Self { references, mapping, axis, vertices, bins } = self;
        for reference in references {
            let [low, high] = reference.bounds().range(axis);
            let [first, last] = [low, high].map(|position| mapping.bin(position, axis));
            bins.begins[first] += 1;
            bins.ends[last] += 1;
            if first == last {
                bins.bounds[last] = bins.bounds[last].union_on(isa, reference.bounds());
                continue;
            }
            let mut parts = [Box8::EMPTY; MAX_BINS];
            let triangle = vertices.triangle(reference.place());
            cut_between_bins(isa, &triangle, (mapping, axis), [(first, low), (last, high)], &mut parts);
            for (bounds, part) in bins.bounds[first..=last].iter_mut().zip(&parts[first..=last]) {
                let part = part.intersection_on(isa, reference.bounds());
                if !part.is_empty() {
                    *bounds = bounds.union_on(isa, &part);
                }
            }
        }
    }
}

/// The boxes about a triangle's parts in bins, about as large as they are, for the part of the triangle that begins and ends
/// in the given bins at the given positions.
#[inline(always)]
fn cut_between_bins<I: Isa>(
    isa: I,
    triangle: &[Vec3; 3],
    (mapping, axis): (&Mapping, usize),
    [(first, low), (last, high)]: [(usize, f32); 2],
    parts: &mut [Box8; MAX_BINS],
) {
    let corners = triangle.map(Box8::at);
    let positions = triangle.map(|corner| corner[axis]);
    let bin_of = |position: f32| mapping.bin(position, axis);
    for i in 0..3 {
        if low <= positions[i] && positions[i] <= high {
            include(isa, parts, bin_of(positions[i]), &corners[i]);
        }
        let (from, to) =
            if positions[i] > positions[(i + 1) % 3] { ((i + 1) % 3, i) } else { (i, (i + 1) % 3) };
        let (start, end) = (positions[from], positions[to]);
        if start >= high || end <= low {
            continue;
        }
        let step = 1.0 / (end - start);
        let origin = isa.load(corners[from].row());
        let along = isa.load(corners[to].row()) - origin;
        let first_bin = if start < low { first } else { bin_of(start) };
        let last_bin = if end > high { last } else { bin_of(end) };
        if start < low {
            let point = Box8::from_row(Row((origin + along * isa.splat((low - start) * step)).to_array()));
            include(isa, parts, first, &point);
        }
        if end > high {
            let point = Box8::from_row(Row((origin + along * isa.splat((high - start) * step)).to_array()));
            include(isa, parts, last, &point);
        }
        for bin in first_bin..last_bin {
            let share = (mapping.position(bin + 1, axis) - start) * step;
            let point = Box8::from_row(Row((origin + along * isa.splat(share)).to_array()));
            include(isa, parts, bin, &point);
            include(isa, parts, bin + 1, &point);
        }
    }
}

#[inline(always)]
fn include<I: Isa>(isa: I, parts: &mut [Box8; MAX_BINS], bin: usize, point: &Box8) {
    let part = &mut parts[bin % MAX_BINS];
    *part = part.union_on(isa, point);
}
