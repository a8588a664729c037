//! What the top-down builders share: the recursion over slices, leaves of one kind, and the bound on the depth.

use sahl_math::Bounds3;

use super::bins::blocks;
use super::nodes::NodeLists;
use super::reference::{Extent, Reference};
use super::{BinaryNode, BinaryTree, MAX_DEPTH, MAX_LEAF};

/// Ranges of at least this many primitives are split by two threads.
const PARALLEL_RECURSION: usize = 1 << 12;

/// How a builder splits a range of at least two references.
pub(super) trait Splitter: Sync {
    /// Whether a leaf may hold triangles only, or one other primitive.
    const LEAVES_OF_ONE_KIND: bool = true;

    /// Reorders the range and tells how; `None` for a leaf, which is allowed for at most [`MAX_LEAF`] references.
    fn split(&self, range: &mut Range<'_>) -> Option<Halves>;
}

/// References to build a subtree over, and room for parts of them.
pub(super) struct Range<'a> {
    /// The references, those first that may be cut in two, and free slots behind them.
    pub(super) slots: &'a mut [Reference],
    /// How many references there are.
    pub(super) count: usize,
    /// How many of them may be cut in two.
    pub(super) divisible: usize,
    pub(super) extent: Extent,
}

/// A range that was split. The slots hold, one after the other: the divisible references of the left side, such of the
/// right side, the other references of the left side, such of the right side, and then references that were added to the
/// divisible ones of the right side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Halves {
    /// How many divisible references each side has, without those added.
    pub(super) divisible: [usize; 2],
    /// How many other references each side has.
    pub(super) others: [usize; 2],
    /// How many were added.
    pub(super) added: usize,
    pub(super) extents: [Extent; 2],
}

impl Range<'_> {
    pub(super) fn references(&mut self) -> &mut [Reference] {
        &mut self.slots[..self.count]
    }
}

impl Halves {
    /// The halves of a range that is in order, none of whose references will be cut.
    pub(super) fn of(references: &[Reference], left_count: usize) -> Self {
        let (left, right) = references.split_at(left_count);
        Self {
            divisible: [0; 2],
            others: [left.len(), right.len()],
            added: 0,
            extents: [Extent::of(left), Extent::of(right)],
        }
    }

    /// What the split costs, counted in blocks.
    pub(super) fn cost(&self) -> f32 {
        let counts = self.counts();
        let cost = |side: usize| self.extents[side].bounds.half_area() * blocks(counts[side] as u32);
        cost(0) + cost(1)
    }

    /// How many references each side has.
    pub(super) fn counts(&self) -> [usize; 2] {
        let [left, right] = [0, 1].map(|side| self.divisible[side] + self.others[side]);
        [left, right + self.added]
    }

    /// Moves the references so that the slots hold the left side, `free` free slots, and the right side, each with its
    /// divisible references first.
    fn arrange(&self, slots: &mut [Reference], free: usize) {
        let [left, right] = self.divisible;
        if left + right + self.added + free == 0 {
            return;
        }
        let [left_others, right_others] = self.others;
        exchange(slots, left, right, left_others);
        let start = left + left_others;
        exchange(slots, start + right, right_others, self.added);
        // The right side moves back by `free` slots. The first of its others make room and go to the end.
        let right = right + self.added;
        let moved = free.min(right_others);
        let first_other = start + right;
        slots.copy_within(first_other..first_other + moved, first_other + right_others.max(free));
        slots.copy_within(start..first_other, start + free);
    }
}

/// Exchanges two neighbouring groups, the first of which starts at `start`. The order within a group is not kept.
fn exchange(slots: &mut [Reference], start: usize, first: usize, second: usize) {
    let few = first.min(second);
    let (front, back) = slots[start..start + first + second].split_at_mut(first + second - few);
    front[..few].swap_with_slice(back);
}

/// Builds a tree over at least one primitive, none of which is cut.
pub(super) fn build_tree(
    mut references: Vec<Reference>,
    extent: Extent,
    splitter: &impl Splitter,
) -> BinaryTree {
    let count = references.len();
    let nodes = build_nodes(Range { slots: &mut references, count, divisible: 0, extent }, splitter);
    BinaryTree::over(references, nodes.concat())
}

/// The nodes of a tree.
pub(super) fn build_nodes(range: Range<'_>, splitter: &impl Splitter) -> NodeLists {
    NodeLists::new(Task { range, first: 0, depth: 0 }.build(splitter))
}

/// A subtree to build.
struct Task<'a> {
    range: Range<'a>,
    /// The place of the first slot among those of the tree.
    first: usize,
    depth: u32,
}

impl<'a> Task<'a> {
    /// The subtree's nodes, in as many lists as are made at the same time: one after the other they are its depth-first order.
    fn build<S: Splitter>(mut self, splitter: &S) -> Vec<Vec<BinaryNode>> {
        if self.range.count < PARALLEL_RECURSION {
            let mut nodes = Vec::with_capacity(self.range.count / 2);
            self.append(splitter, &mut nodes);
            return vec![nodes];
        }
        let bounds = self.range.extent.bounds.bounds();
        let Some(halves) = self.split(splitter) else {
            return vec![vec![self.leaf(bounds)]];
        };
        let [left, right] = self.halve(halves);
        let (left, right) = rayon::join(|| left.build(splitter), || right.build(splitter));
        let mut node = BinaryNode::inner(bounds);
        node.set_right(0, 1 + left.iter().map(Vec::len).sum::<usize>());
        std::iter::once(vec![node]).chain(left).chain(right).collect()
    }

    /// Appends the subtree to `nodes`.
    fn append<S: Splitter>(mut self, splitter: &S, nodes: &mut Vec<BinaryNode>) {
        let bounds = self.range.extent.bounds.bounds();
        let Some(halves) = self.split(splitter) else {
            nodes.push(self.leaf(bounds));
            return;
        };
        let place = nodes.len();
        nodes.push(BinaryNode::inner(bounds));
        let [left, right] = self.halve(halves);
        left.append(splitter, nodes);
        let right_place = nodes.len();
        nodes[place].set_right(place, right_place);
        right.append(splitter, nodes);
    }

    /// Splits the range; `None` if it is to be a leaf.
    fn split<S: Splitter>(&mut self, splitter: &S) -> Option<Halves> {
        self.keep_depth_for_cuts();
        // Halves are large: combinators would copy them at each step.
        let mut halves = None;
        if self.range.count > 1 {
            halves = splitter.split(&mut self.range);
        }
        if halves.is_none() && S::LEAVES_OF_ONE_KIND {
            halves = self.separate_kinds();
        }
        halves
    }

    fn leaf(&self, bounds: Bounds3) -> BinaryNode {
        BinaryNode::leaf(bounds, self.first, self.range.count)
    }

    /// Where the depth is nearly used up nothing is cut, so that balanced splits can end within the bound.
    fn keep_depth_for_cuts(&mut self) {
        let range = &mut self.range;
        if range.divisible > 0 && self.depth + 2 + balanced_depth(range.slots.len()) > MAX_DEPTH {
            range.divisible = 0;
        }
    }

    fn halve(self, mut halves: Halves) -> [Self; 2] {
        if self.is_too_deep_for(&halves) {
            let [left, right] = halves.counts();
            halves = Halves::of(&self.range.slots[..left + right], (left + right).div_ceil(2));
        }
        let [left, right] = halves.counts();
        let [left_divisible, right_divisible] = [halves.divisible[0], halves.divisible[1] + halves.added];
        // Free slots are shared out in proportion to what may need them.
        let free = (self.range.slots.len() - left - right) as u64;
        let divisible = (left_divisible + right_divisible).max(1) as u64;
        let left_free = (free * left_divisible as u64 / divisible) as usize;
        halves.arrange(self.range.slots, left_free);
        let (left_slots, right_slots) = self.range.slots.split_at_mut(left + left_free);
        let side = |slots, count, divisible, extent, first| Task {
            range: Range { slots, count, divisible, extent },
            first,
            depth: self.depth + 1,
        };
        let right_first = self.first + left_slots.len();
        let [left_extent, right_extent] = halves.extents;
        [
            side(left_slots, left, left_divisible, left_extent, self.first),
            side(right_slots, right, right_divisible, right_extent, right_first),
        ]
    }

    /// Whether one of the halves is too large for balanced splits to end above [`MAX_DEPTH`].
    fn is_too_deep_for(&self, halves: &Halves) -> bool {
        let [left, right] = halves.counts();
        self.depth + 1 + balanced_depth(left.max(right)) > MAX_DEPTH
    }

    /// Splits a range that would be a leaf, unless it holds triangles only or one other primitive: triangles apart from the
    /// others, and these in the middle.
    fn separate_kinds(&mut self) -> Option<Halves> {
        let references = self.range.references();
        debug_assert!(references.len() <= MAX_LEAF, "a leaf of {} references", references.len());
        if references.len() <= 1 || references.iter().all(Reference::is_triangle) {
            return None;
        }
        references.sort_unstable_by_key(Reference::key);
        let triangles = references.partition_point(Reference::is_triangle);
        let left_count = if triangles > 0 { triangles } else { references.len().div_ceil(2) };
        Some(Halves::of(references, left_count))
    }
}

/// The depth of a balanced tree over `count` primitives, with what separating kinds in a leaf may add.
fn balanced_depth(count: usize) -> u32 {
    count.next_power_of_two().trailing_zeros() + 1
}
