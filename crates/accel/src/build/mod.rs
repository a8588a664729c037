//! Builders: how to split. They see boxes only, never the objects, and all yield the same binary tree, from which every
//! layout is converted.
//!
//! The tree is a function of the input alone: nodes stand in depth-first order, whoever wrote them, and bins are merged by
//! minimum, maximum and integer sums, which no order changes.

mod binned_sah;
mod median;
mod reference;
mod split;
mod sweep;

use sahl_math::Bounds3;

use crate::kernel::{BLOCK_WIDTH, Tier};
use crate::options::{BuildOptions, Builder};
pub(crate) use reference::{Box8, Extent, Reference};

/// No leaf lies deeper below the root. A split that would leave one side too many primitives for balanced splits to
/// finish within the bound is replaced by a balanced one.
pub(crate) const MAX_DEPTH: u32 = 64;

/// No leaf holds more: triangles that fill one block.
pub(crate) const MAX_LEAF: usize = BLOCK_WIDTH;

/// A binary tree over primitives in depth-first order.
///
/// A leaf holds triangles, at most [`MAX_LEAF`], or one primitive of another kind.
#[derive(Clone, Debug)]
pub(crate) struct BinaryTree {
    /// The root is node 0; the left child of node `i` is node `i + 1`.
    pub(crate) nodes: Vec<BinaryNode>,
    /// The primitives in the order of the leaves.
    pub(crate) references: Vec<Reference>,
}

/// A node of [`BinaryTree`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BinaryNode {
    /// The box about everything below.
    pub(crate) bounds: Bounds3,
    /// Inner nodes: how far behind this node the right child stands. Leaves: the first place among the references.
    index: u32,
    /// Leaves: how many primitives; zero for inner nodes.
    count: u32,
}

impl BinaryNode {
    fn leaf(bounds: Bounds3, first: usize, count: usize) -> Self {
        Self { bounds, index: first as u32, count: count as u32 }
    }

    /// An inner node whose right child is not known yet.
    fn inner(bounds: Bounds3) -> Self {
        Self { bounds, index: 0, count: 0 }
    }

    fn set_right(&mut self, place: usize, right: usize) {
        self.index = (right - place) as u32;
    }

    #[inline]
    pub(crate) fn is_leaf(&self) -> bool {
        self.count > 0
    }

    /// The places of an inner node's children, the node itself being at `place`.
    #[inline]
    pub(crate) fn children(&self, place: u32) -> [u32; 2] {
        [place + 1, place + self.index]
    }

    /// The places of a leaf's references.
    #[inline]
    pub(crate) fn range(&self) -> std::ops::Range<usize> {
        self.index as usize..(self.index + self.count) as usize
    }
}

/// Builds a tree; `None` over no primitives, and for the brute-force list, which has no tree.
pub(crate) fn build(references: Vec<Reference>, options: &BuildOptions) -> Option<BinaryTree> {
    if references.is_empty() {
        return None;
    }
    let tier = options.tier.filter(|tier| tier.is_available()).unwrap_or_else(Tier::detect);
    match options.builder {
        Builder::Median => Some(median::build(references)),
        Builder::BinnedSah => Some(binned_sah::build(references, options.bins, tier)),
        Builder::BruteForce => None,
    }
}

#[cfg(test)]
mod tests;
