//! Exact surface area heuristic for small ranges: every split between neighbours in the order of the centres on
//! each axis that leaves both sides few enough for a leaf.

use super::MAX_LEAF;
use super::bins::blocks;
use super::part::REMOVED;
use super::reference::{Box8, Extent, Reference};
use super::split::Halves;
use crate::kernel::{Isa, Lanes, Machine, Row, Task};

/// Ranges of at most this many references are split exactly.
pub(super) const MAX_COUNT: usize = 2 * MAX_LEAF;

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

/// The best split of a range of at least two and at most [`MAX_COUNT`] references into leaves.
///
/// `None` if none is worth it for a range that fits a leaf, and where costs that are beyond the range of `f32`, or
/// zero, do not tell.
pub(super) fn best_cut(machine: Machine, references: &[Reference], extent: &Extent) -> Option<Cut> {
    if references.len() <= MAX_LEAF {
        machine.run(PartLeaf { references, extent })
    } else {
        machine.run(Search::<true> { references })
    }
}

/// The best split of a range of at least two and at most [`MAX_COUNT`] groups, of whatever sizes.
///
/// `None` where costs that are beyond the range of `f32`, or zero, do not tell.
pub(super) fn best_cut_of_groups(machine: Machine, references: &[Reference]) -> Option<Cut> {
    machine.run(Search::<false> { references })
}

/// The best split on any axis; if `LEAVES`, only such are looked at that leave both sides few enough for a leaf: others would change
/// the expected cost of rays by less than 0.1 %.
struct Search<'a, const LEAVES: bool> {
    references: &'a [Reference],
}

impl<const LEAVES: bool> Task for Search<'_, LEAVES> {
    type Output = Option<Cut>;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Option<Cut> {
        let mut best = Cut::NONE;
        for axis in 0..3 {
            improve::<I, LEAVES>(isa, &mut best, self.references, axis);
        }
        (best.left_count > 0 && best.cost > 0.0).then_some(best)
    }
}

struct PartLeaf<'a> {
    references: &'a [Reference],
    extent: &'a Extent,
}

impl Task for PartLeaf<'_> {
    type Output = Option<Cut>;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Option<Cut> {
        part_leaf(isa, self.references, self.extent)
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
            let goes_right = usize::from((middle - reference.doubled_center_at(axis)).is_sign_negative());
            let own = isa.load(reference.bounds().row());
            let [left, right] = [isa.load(&REMOVED[goes_right]), isa.load(&REMOVED[goes_right + 1])];
            sides = [sides[0].min(own + left), sides[1].min(own + right)];
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

/// Replaces a cut by the best one on an axis if that costs less.
#[inline(always)]
fn improve<I: Isa, const LEAVES: bool>(isa: I, best: &mut Cut, references: &[Reference], axis: usize) {
    let order = sorted(references, axis);
    let count = references.len();
    let most = if LEAVES { MAX_LEAF } else { MAX_COUNT };
    let (first, last) = (count.saturating_sub(most).max(1), (count - 1).min(most));
    // Each side of leaves fills one block.
    let blocks = |count: usize| if LEAVES { 1.0 } else { blocks(count as u32) };
    let mut costs = [f32::INFINITY; MAX_COUNT];
    let mut bounds = Box8::EMPTY;
    for i in (first..count).rev() {
        bounds = bounds.union_on(isa, references[order[i] as usize].bounds());
        if i <= last {
            costs[i] = bounds.half_area() * blocks(count - i);
        }
    }
    let mut bounds = Box8::EMPTY;
    for i in 1..=last {
        bounds = bounds.union_on(isa, references[order[i - 1] as usize].bounds());
        if i >= first {
            costs[i] += bounds.half_area() * blocks(i);
        }
    }
    let left_count = first_least(&costs);
    if costs[left_count] < best.cost {
        *best = Cut { cost: costs[left_count], left_count, order };
    }
}

/// The place of the least cost that is a number, the first of equals; without branches that cannot be predicted.
#[inline(always)]
fn first_least<const N: usize>(costs: &[f32; N]) -> usize {
    let mut least = f32::INFINITY;
    let mut place = 0;
    for (i, &cost) in costs.iter().enumerate() {
        place = if cost < least { i } else { place };
        least = if cost < least { cost } else { least };
    }
    place
}

#[cfg(test)]
mod tests {
    use sahl_math::{Bounds3, Vec3};

    use super::*;
    use crate::kernel::Tier;
    use crate::primitive::Item;

    /// Boxes of many sizes at places that look random.
    fn scattered(count: usize, seed: u32) -> Vec<Reference> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let mut one = |id: usize| {
            let min = Vec3::new(next(), next() * 4.0, next());
            let max = min + Vec3::new(next(), next(), next()) * 0.3;
            Reference::new(&Bounds3 { min, max }, Item::Triangle(id as u32))
        };
        (0..count).map(&mut one).collect()
    }

    /// The least cost of a cut between neighbours in the order of the centres, with the sides' sizes.
    fn by_trying_all(references: &[Reference], most: usize) -> f32 {
        let mut least = f32::INFINITY;
        for axis in 0..3 {
            let mut sorted = references.to_vec();
            sorted.sort_by(|a, b| a.doubled_center_at(axis).total_cmp(&b.doubled_center_at(axis)));
            for left_count in 1..sorted.len() {
                let (left, right) = sorted.split_at(left_count);
                if left.len().max(right.len()) <= most {
                    let cost =
                        |side: &[Reference]| Extent::of(side).bounds.half_area() * blocks(side.len() as u32);
                    least = least.min(cost(left) + cost(right));
                }
            }
        }
        least
    }

    #[test]
    fn the_best_cut_is_that_of_trying_all() {
        for tier in Tier::ALL.into_iter().filter(|tier| tier.is_available()) {
            let machine = Machine::choose(Some(tier));
            for count in 2..=MAX_COUNT {
                let references = scattered(count, count as u32);
                let cut = best_cut_of_groups(machine, &references).expect("costs tell");
                assert_eq!(cut.cost, by_trying_all(&references, MAX_COUNT), "{count} groups, {tier:?}");
                if count > MAX_LEAF {
                    let cut = best_cut(machine, &references, &Extent::of(&references)).expect("costs tell");
                    assert_eq!(cut.cost, by_trying_all(&references, MAX_LEAF), "{count}, {tier:?}");
                    assert!(cut.left_count.max(count - cut.left_count) <= MAX_LEAF);
                }
            }
        }
    }
}
