//! What the builders share: the working copy of a primitive, the recursion over slices, and the bound on the depth.

use sahl_math::{Bounds3, Vec3};

use super::{BinaryNode, BinaryTree, BuildInput, MAX_DEPTH};

/// Ranges of at least this many primitives are split by two threads.
const PARALLEL_RECURSION: usize = 4096;

/// A primitive as the builders move it about: next to each other in memory, which counts more than its size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reference {
    pub(super) bounds: Bounds3,
    pub(super) center: Vec3,
    pub(super) place: u32,
}

/// The boxes about a range of primitives and about their centres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub(super) bounds: Bounds3,
    pub(super) centers: Bounds3,
}

impl Extent {
    pub(super) const EMPTY: Self = Self { bounds: Bounds3::EMPTY, centers: Bounds3::EMPTY };

    pub(super) fn of(references: &[Reference]) -> Self {
        references.iter().fold(Self::EMPTY, |extent, reference| Self {
            bounds: extent.bounds.union(reference.bounds),
            centers: extent.centers.including(reference.center),
        })
    }
}

/// How a builder splits a range of at least two references.
pub(super) trait Splitter: Sync {
    /// Reorders the range and returns how many go to the left, with the extents of both sides; `None` for a leaf.
    fn split(&self, references: &mut [Reference], extent: &Extent) -> Option<Halves>;
}

/// A range that was split.
#[derive(Clone, Copy, Debug)]
pub(super) struct Halves {
    pub(super) left_count: usize,
    pub(super) left: Extent,
    pub(super) right: Extent,
}

impl Halves {
    /// The halves of a range that is already in order.
    pub(super) fn of(references: &[Reference], left_count: usize) -> Self {
        let (left, right) = references.split_at(left_count);
        Self { left_count, left: Extent::of(left), right: Extent::of(right) }
    }
}

/// Builds a tree over at least one primitive.
pub(super) fn build_tree(input: BuildInput<'_>, splitter: &impl Splitter) -> BinaryTree {
    let mut references: Vec<Reference> = (input.bounds.iter().zip(input.centers).zip(0..))
        .map(|((&bounds, &center), place)| Reference { bounds, center, place })
        .collect();
    let extent = Extent::of(&references);
    let mut nodes = vec![BinaryNode::UNUSED; 2 * references.len() - 1];
    Range { references: &mut references, nodes: &mut nodes, first: 0, slot: 0, depth: 0, extent }
        .build(splitter);
    BinaryTree { nodes, order: references.iter().map(|reference| reference.place).collect() }
}

/// A range of primitives with the node slots that belong to it.
struct Range<'a> {
    references: &'a mut [Reference],
    nodes: &'a mut [BinaryNode],
    /// The place of the first reference in the tree's order.
    first: usize,
    /// The place of the first node in the tree.
    slot: usize,
    depth: u32,
    extent: Extent,
}

impl Range<'_> {
    fn build(self, splitter: &impl Splitter) {
        let count = self.references.len();
        let halves = if count > 1 { splitter.split(self.references, &self.extent) } else { None };
        let Some(halves) = halves else {
            self.nodes[0] =
                BinaryNode { bounds: self.extent.bounds, index: self.first as u32, count: count as u32 };
            return;
        };
        let halves = self.within_depth(halves);
        let left_count = halves.left_count;
        let (node, below) = self.nodes.split_first_mut().expect("a range owns at least one slot");
        let (left_nodes, right_nodes) = below.split_at_mut(2 * left_count - 1);
        let (left_references, right_references) = self.references.split_at_mut(left_count);
        let depth = self.depth + 1;
        *node =
            BinaryNode { bounds: self.extent.bounds, index: (self.slot + 2 * left_count) as u32, count: 0 };
        let left = Range {
            references: left_references,
            nodes: left_nodes,
            first: self.first,
            slot: self.slot + 1,
            depth,
            extent: halves.left,
        };
        let right = Range {
            references: right_references,
            nodes: right_nodes,
            first: self.first + left_count,
            slot: self.slot + 2 * left_count,
            depth,
            extent: halves.right,
        };
        if count >= PARALLEL_RECURSION {
            rayon::join(|| left.build(splitter), || right.build(splitter));
        } else {
            left.build(splitter);
            right.build(splitter);
        }
    }

    /// The halves, or two of equal size where one is too large for balanced splits to end above [`MAX_DEPTH`].
    fn within_depth(&self, halves: Halves) -> Halves {
        let count = self.references.len();
        let larger = halves.left_count.max(count - halves.left_count);
        if self.depth + 1 + balanced_depth(larger) <= MAX_DEPTH {
            return halves;
        }
        Halves::of(self.references, count.div_ceil(2))
    }
}

/// The depth of a balanced tree over `count` primitives.
fn balanced_depth(count: usize) -> u32 {
    count.next_power_of_two().trailing_zeros()
}
