//! Exact surface area heuristic for small ranges: every split between neighbours in the order of the centres on
//! each axis.

use super::MAX_LEAF;
use super::binned_sah::blocks;
use super::reference::{Box8, Extent, Reference};
use super::split::Halves;

/// Ranges of at most this many references are split exactly.
pub(super) const MAX_COUNT: usize = 32;

/// The parts of a range that fits a leaf must have less than this share of its area together to become leaves of their own.
const WORTH: f32 = 0.8;

/// What to do with a range.
pub(super) enum Outcome {
    /// It becomes a leaf.
    Leaf,
    /// It was split.
    Split(Halves),
    /// Costs that are beyond the range of `f32`, or zero, do not tell.
    Undecided,
}

/// A split of the order on an axis.
#[derive(Clone, Copy)]
struct Cut {
    cost: f32,
    axis: usize,
    left_count: usize,
}

/// Splits a range of at least two and at most [`MAX_COUNT`] references.
pub(super) fn split(references: &mut [Reference], extent: &Extent) -> Outcome {
    let count = references.len();
    let worth = WORTH;
    let limit = if count <= MAX_LEAF { worth * extent.bounds.half_area() } else { f32::INFINITY };
    if count <= 2 {
        return Outcome::Leaf;
    }
    let mut orders = [[0; MAX_COUNT]; 3];
    let mut best = Cut { cost: limit, axis: 0, left_count: 0 };
    for (axis, order) in orders.iter_mut().enumerate() {
        *order = sorted(references, axis);
        best = best_cut(references, &order[..count], axis, best);
    }
    if best.left_count == 0 || best.cost == 0.0 {
        return if count <= MAX_LEAF { Outcome::Leaf } else { Outcome::Undecided };
    }
    let mut moved = [references[0]; MAX_COUNT];
    for (place, &from) in moved.iter_mut().zip(&orders[best.axis][..count]) {
        *place = references[from];
    }
    references.copy_from_slice(&moved[..count]);
    Outcome::Split(Halves::of(references, best.left_count))
}

/// The order of the references' centres on an axis, by counting for each how many precede it.
#[inline(never)]
fn sorted(references: &[Reference], axis: usize) -> [usize; MAX_COUNT] {
    let mut keys = [u32::MAX; MAX_COUNT];
    for (place, (key, reference)) in keys.iter_mut().zip(references).enumerate() {
        let bits = reference.doubled_center()[axis].to_bits();
        let ascending = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
        // The lowest bits tell equal ones apart.
        *key = ascending & !(MAX_COUNT as u32 - 1) | place as u32;
    }
    let mut order = [0; MAX_COUNT];
    for (place, key) in keys[..references.len()].iter().enumerate() {
        let rank: u32 = keys.iter().map(|other| u32::from(other < key)).sum();
        order[rank as usize % MAX_COUNT] = place;
    }
    order
}

#[inline(never)]
fn best_cut(references: &[Reference], order: &[usize], axis: usize, mut best: Cut) -> Cut {
    let count = order.len();
    let mut right_costs = [0.0; MAX_COUNT];
    let mut bounds = Box8::EMPTY;
    for i in (1..count).rev() {
        bounds = bounds.union(*references[order[i]].bounds());
        right_costs[i] = bounds.half_area() * blocks((count - i) as u32);
    }
    let mut bounds = Box8::EMPTY;
    for left_count in 1..count {
        bounds = bounds.union(*references[order[left_count - 1]].bounds());
        let cost = bounds.half_area() * blocks(left_count as u32) + right_costs[left_count];
        if cost < best.cost {
            best = Cut { cost, axis, left_count };
        }
    }
    best
}
