//! Exact surface area heuristic for small ranges: every split between neighbours in the order of the centres on
//! each axis that leaves both sides few enough for a leaf.

use super::MAX_LEAF;
use super::bins::first_least;
use super::reference::{Box8, Extent, Reference};
use super::split::Halves;
use crate::kernel::{Isa, Lanes, Machine, Row, Task};

/// Ranges of at most this many references are split exactly.
pub(super) const MAX_COUNT: usize = 16;

/// The parts of a range that fits a leaf must have less than this share of its area together to become leaves of their own.
const WORTH: f32 = 0.75;

/// A split of the order on an axis.
pub(super) struct Cut {
    cost: f32,
    left_count: usize,
    order: [u8; MAX_COUNT],
}

impl Cut {
    const NONE: Self = Self { cost: f32::INFINITY, left_count: 0, order: [0; MAX_COUNT] };

    /// Reorders the range that the cut was found for.
    pub(super) fn apply(&self, references: &mut [Reference]) -> Halves {
        let count = references.len();
        let mut moved = [references[0]; MAX_COUNT];
        for (place, &from) in moved.iter_mut().zip(&self.order[..count]) {
            *place = references[from as usize];
        }
        references.copy_from_slice(&moved[..count]);
        Halves::of(references, self.left_count)
    }
}

/// The best split of a range of at least two and at most [`MAX_COUNT`] references.
///
/// `None` if none is worth it for a range that fits a leaf, and where costs that are beyond the range of `f32`, or
/// zero, do not tell.
pub(super) fn best_cut(machine: Machine, references: &[Reference], extent: &Extent) -> Option<Cut> {
    machine.run(Search { references, extent })
}

/// The best split on any axis.
#[inline(always)]
fn best_of_all<I: Isa>(isa: I, references: &[Reference]) -> Option<Cut> {
    let mut best = Cut::NONE;
    for axis in 0..3 {
        improve(isa, &mut best, references, axis);
    }
    (best.left_count > 0 && best.cost > 0.0).then_some(best)
}

struct Search<'a> {
    references: &'a [Reference],
    extent: &'a Extent,
}

impl Task for Search<'_> {
    type Output = Option<Cut>;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Option<Cut> {
        if self.references.len() <= MAX_LEAF {
            return part_leaf(isa, self.references, self.extent);
        }
        best_of_all(isa, self.references)
    }
}

/// The split of a range that fits a leaf at the middle of its centres on an axis, if that is worth it.
#[inline(always)]
fn part_leaf<I: Isa>(isa: I, references: &[Reference], extent: &Extent) -> Option<Cut> {
    let middle = extent.centers.doubled_center().map(|x| 0.5 * x);
    let mut best = (WORTH * extent.bounds.half_area(), 3);
    for (axis, &middle) in middle[..3].iter().enumerate() {
        let mut sides = [isa.splat(f32::INFINITY); 2];
        for reference in references {
            // All bits set if it goes right. Infinity, added to a box, removes it from every minimum.
            let goes_right = ((middle - reference.doubled_center_at(axis)).to_bits() as i32) >> 31;
            let removed = |mask: i32| isa.splat(f32::from_bits(mask as u32 & f32::INFINITY.to_bits()));
            let own = isa.load(reference.bounds().row());
            sides = [sides[0].min(own + removed(goes_right)), sides[1].min(own + removed(!goes_right))];
        }
        let [left, right] = sides.map(|lanes| Box8::from_row(Row(lanes.to_array())).half_area());
        if left + right < best.0 {
            best = (left + right, axis);
        }
    }
    let (cost, axis) = best;
    if axis == 3 || cost == 0.0 {
        return None;
    }
    let mut order = [0; MAX_COUNT];
    let mut left_count = 0;
    let goes_right =
        |reference: &Reference| (middle[axis] - reference.doubled_center_at(axis)).is_sign_negative();
    for right in [false, true] {
        for (place, reference) in references.iter().enumerate() {
            if goes_right(reference) == right {
                order[left_count] = place as u8;
                left_count += 1;
            }
        }
    }
    let left_count = references.iter().filter(|reference| !goes_right(reference)).count();
    Some(Cut { cost, left_count, order })
}

/// The order of the references' centres on an axis, by counting for each how many precede it.
#[inline(always)]
fn sorted(references: &[Reference], axis: usize) -> [u8; MAX_COUNT] {
    let mut keys = [u32::MAX; MAX_COUNT];
    for (place, (key, reference)) in keys.iter_mut().zip(references).enumerate() {
        let bits = reference.doubled_center_at(axis).to_bits();
        let ascending = bits ^ ((bits as i32 >> 31) as u32 | 1 << 31);
        // The lowest bits tell equal ones apart.
        *key = ascending & !(MAX_COUNT as u32 - 1) | place as u32;
    }
    let mut ranks = [0_u32; MAX_COUNT];
    for &key in &keys {
        for (rank, other) in ranks.iter_mut().zip(&keys) {
            *rank += u32::from(key < *other);
        }
    }
    let mut order = [0; MAX_COUNT];
    for (place, rank) in ranks[..references.len()].iter().enumerate() {
        order[*rank as usize % MAX_COUNT] = place as u8;
    }
    order
}

/// Replaces a cut by the best one on an axis if that costs less. Both sides must fit a leaf: other cuts would change the expected cost of
/// rays by less than 0.1 %.
#[inline(always)]
fn improve<I: Isa>(isa: I, best: &mut Cut, references: &[Reference], axis: usize) {
    let order = sorted(references, axis);
    let count = references.len();
    let (first, last) = (count.saturating_sub(MAX_LEAF), count.min(MAX_LEAF));
    let mut costs = [f32::INFINITY; MAX_COUNT];
    let mut bounds = Box8::EMPTY;
    for i in (first..count).rev() {
        bounds = bounds.union_on(isa, references[order[i] as usize].bounds());
        if i <= last {
            costs[i] = bounds.half_area();
        }
    }
    let mut bounds = Box8::EMPTY;
    for i in 1..=last {
        bounds = bounds.union_on(isa, references[order[i - 1] as usize].bounds());
        if i >= first {
            costs[i] += bounds.half_area();
        }
    }
    let left_count = first_least(&costs);
    if costs[left_count] < best.cost {
        *best = Cut { cost: costs[left_count], left_count, order };
    }
}
