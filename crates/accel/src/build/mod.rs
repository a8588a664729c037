//! Builders: how to split. They see boxes only, never the objects, and all yield the same binary tree, from which every
//! layout is converted.
//!
//! The tree is a function of the input alone: nodes stand in depth-first order, whoever wrote them, and bins are merged by
//! minimum, maximum and integer sums, which no order changes.

mod binning;
mod bins;
mod clip;
mod curve;
mod cut_bins;
mod fast;
mod mapping;
mod median;
mod nodes;
mod part;
mod reference;
mod reinsertion;
mod sah;
mod spatial;
mod split;
mod sweep;

use rayon::prelude::*;
use sahl_math::{Bounds3, Vec3};

use crate::kernel::{BLOCK_WIDTH, Machine, Row};
use crate::layout::Vertices;
use crate::options::{BuildOptions, Builder};
use crate::primitive::Item;

use binning::Binning;
pub(crate) use curve::Key;
pub(crate) use reference::{Box8, Extent, Reference};
use reinsertion::Effort;
use spatial::Cutting;

/// No leaf lies deeper below the root. A split that would leave one side too many primitives for balanced splits to
/// finish within the bound is replaced by a balanced one.
pub(crate) const MAX_DEPTH: u32 = 64;

/// No leaf holds more: triangles that fill one block.
pub(crate) const MAX_LEAF: usize = BLOCK_WIDTH;

/// A binary tree over primitives in depth-first order.
///
/// A leaf holds triangles, at most [`MAX_LEAF`], or one primitive of another kind; of some trees it holds several groups of these.
#[derive(Clone, Debug)]
pub(crate) struct BinaryTree {
    /// The root is node 0; the left child of node `i` is node `i + 1`.
    pub(crate) nodes: Vec<BinaryNode>,
    /// The primitives, those of a leaf side by side; with gaps, which no leaf refers to.
    pub(crate) primitives: Vec<Key>,
    /// Of a tree of groups: what the leaves' ranges are of, at most eight a leaf. A group is triangles that share a block, or one primitive
    /// of another kind, and has a range of the primitives. Empty if the leaves' ranges are of these themselves.
    pub(crate) groups: Vec<Reference>,
    /// Memory that is needed no more: that of the references, as the builder moved them about.
    pub(crate) spare: Vec<Row>,
}

impl BinaryTree {
    /// A tree whose leaves' ranges are of these references.
    fn over(references: Vec<Reference>, nodes: Vec<BinaryNode>) -> Self {
        let primitives = references.par_iter().map(Key::of_reference).collect();
        Self { nodes, primitives, groups: Vec::new(), spare: spare(references) }
    }

    /// Whether the leaves hold groups of primitives.
    pub(crate) fn is_of_groups(&self) -> bool {
        !self.groups.is_empty()
    }
}

/// The memory of references under another name.
fn spare(references: Vec<Reference>) -> Vec<Row> {
    references.into_iter().map(Reference::into_row).collect()
}

/// A node of [`BinaryTree`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BinaryNode {
    /// The box about everything below.
    pub(crate) bounds: Bounds3,
    /// Inner nodes: how far behind this node the right child stands. Leaves: the first place among the primitives or groups.
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

    /// The places of a leaf's primitives or groups.
    #[inline]
    pub(crate) fn range(&self) -> std::ops::Range<usize> {
        self.index as usize..(self.index + self.count) as usize
    }
}

/// Builds a tree over references with this extent; `None` over none, and for the brute-force list, which has no tree.
pub(crate) fn build(
    references: Vec<Reference>,
    extent: Extent,
    options: &BuildOptions,
    vertices: &impl Vertices,
) -> Option<BinaryTree> {
    if references.is_empty() {
        return None;
    }
    let binning = Binning::new(options.bins, Machine::choose(options.tier));
    let (cutting, effort) = match options.builder {
        Builder::BruteForce => return None,
        Builder::Median => return Some(median::build(references, extent)),
        Builder::BinnedSah => (Cutting::DEFAULT, Effort::DEFAULT),
        Builder::HighQuality => (Cutting::HIGH, Effort::HIGH),
        Builder::Fast => return Some(fast::build(references, &extent, binning)),
    };
    let (nodes, references) = spatial::build(references, extent, binning, cutting, vertices);
    Some(BinaryTree::over(references, reinsertion::optimize(nodes, effort)))
}

/// [`build`] over triangles none of which is cut, because they move and the parts would not hold them.
pub(crate) fn build_uncut(
    references: Vec<Reference>,
    extent: Extent,
    options: &BuildOptions,
) -> Option<BinaryTree> {
    // Nobody asks for them.
    let no_vertices = |_| [Vec3::splat(f32::NAN); 3];
    let binning = Binning::new(options.bins, Machine::choose(options.tier));
    let effort = match options.builder {
        Builder::BinnedSah => Effort::DEFAULT,
        Builder::HighQuality => Effort::HIGH,
        // The others cut nothing.
        _ => return build(references, extent, options, &no_vertices),
    };
    if references.is_empty() {
        return None;
    }
    let (nodes, references) = spatial::build(references, extent, binning, Cutting::NONE, &no_vertices);
    Some(BinaryTree::over(references, reinsertion::optimize(nodes, effort)))
}

/// A tree with leaves as full as can be over what another holds, for when that has too many of them.
pub(crate) fn build_compact(tree: &BinaryTree, vertices: &impl Vertices) -> BinaryTree {
    let whole = |bounds: &Bounds3, item: Item| match item {
        Item::Triangle(id) => Reference::around(vertices.triangle(id), item),
        other => Reference::new(bounds, other),
    };
    let leaves = tree.nodes.iter().filter(|node| node.is_leaf());
    let all_of = |range: std::ops::Range<usize>, bounds: Bounds3| {
        tree.primitives[range].iter().map(move |key| whole(&bounds, key.item()))
    };
    let mut references: Vec<Reference> = if tree.is_of_groups() {
        let groups = leaves.flat_map(|leaf| &tree.groups[leaf.range()]);
        groups.flat_map(|group| all_of(group.range(), group.bounds().bounds())).collect()
    } else {
        leaves.flat_map(|leaf| all_of(leaf.range(), leaf.bounds)).collect()
    };
    // Parts of one triangle become one again.
    references.sort_unstable_by_key(Reference::key);
    references.dedup_by_key(|reference| reference.key());
    let extent = Extent::of(&references);
    median::build(references, extent)
}

#[cfg(test)]
mod tests;
