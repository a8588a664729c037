//! What the top-down builders share: the recursion over slices, leaves of one kind, and the bound on the depth.

use super::reference::{Extent, Reference};
use super::{BinaryNode, BinaryTree, MAX_DEPTH, MAX_LEAF};

/// Ranges of at least this many primitives are split by two threads.
const PARALLEL_RECURSION: usize = 1 << 13;

/// How a builder splits a range of at least two references.
pub(super) trait Splitter: Sync {
    /// Reorders the range and returns how many go to the left, with the extents of both sides; `None` for a leaf, which
    /// is allowed for at most [`MAX_LEAF`] references.
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
pub(super) fn build_tree(mut references: Vec<Reference>, splitter: &impl Splitter) -> BinaryTree {
    let extent = extent_of(&references);
    let mut nodes = Vec::with_capacity(references.len() / 2);
    Range { references: &mut references, first: 0, depth: 0, extent }.build(splitter, &mut nodes);
    BinaryTree { nodes, references }
}

/// [`Extent::of`] on all cores.
fn extent_of(references: &[Reference]) -> Extent {
    use rayon::prelude::*;
    references.par_chunks(1 << 14).map(Extent::of).reduce(|| Extent::EMPTY, Extent::union)
}

/// A range of references to build a subtree over.
struct Range<'a> {
    references: &'a mut [Reference],
    /// The place of the first reference among those of the tree.
    first: usize,
    depth: u32,
    extent: Extent,
}

impl<'a> Range<'a> {
    /// Appends the subtree to `nodes`.
    fn build(mut self, splitter: &impl Splitter, nodes: &mut Vec<BinaryNode>) {
        let count = self.references.len();
        let halves = if count > 1 { splitter.split(self.references, &self.extent) } else { None };
        let Some(halves) = halves.or_else(|| self.separate_kinds()) else {
            nodes.push(BinaryNode::leaf(self.extent.bounds.bounds(), self.first, count));
            return;
        };
        let place = nodes.len();
        nodes.push(BinaryNode::inner(self.extent.bounds.bounds()));
        let [left, right] = self.halve(halves);
        if count >= PARALLEL_RECURSION {
            let mut appended = Vec::new();
            rayon::join(|| left.build(splitter, nodes), || right.build(splitter, &mut appended));
            let right_place = nodes.len();
            nodes[place].set_right(place, right_place);
            nodes.append(&mut appended);
        } else {
            left.build(splitter, nodes);
            let right_place = nodes.len();
            nodes[place].set_right(place, right_place);
            right.build(splitter, nodes);
        }
    }

    fn halve(self, halves: Halves) -> [Range<'a>; 2] {
        let halves = self.within_depth(halves);
        let (left, right) = self.references.split_at_mut(halves.left_count);
        let depth = self.depth + 1;
        let first = self.first + halves.left_count;
        [
            Range { references: left, first: self.first, depth, extent: halves.left },
            Range { references: right, first, depth, extent: halves.right },
        ]
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

    /// Splits a range that would be a leaf, unless it holds triangles only or one other primitive: triangles apart from the
    /// others, and these in the middle.
    fn separate_kinds(&mut self) -> Option<Halves> {
        let count = self.references.len();
        debug_assert!(count <= MAX_LEAF, "a leaf of {count} references");
        if count <= 1 || self.references.iter().all(Reference::is_triangle) {
            return None;
        }
        self.references.sort_unstable_by_key(Reference::key);
        let triangles = self.references.partition_point(Reference::is_triangle);
        Some(Halves::of(self.references, if triangles > 0 { triangles } else { count.div_ceil(2) }))
    }
}

/// The depth of a balanced tree over `count` primitives, with what separating kinds in a leaf may add.
fn balanced_depth(count: usize) -> u32 {
    count.next_power_of_two().trailing_zeros() + 1
}
