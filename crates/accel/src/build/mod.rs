//! Builders: how to split. They see boxes and centres only, never the objects, and all yield the same binary tree, from
//! which every layout is converted.
//!
//! The tree is a function of the input alone: a subtree over `n` primitives owns `2 n − 1` consecutive node slots, so
//! that threads write to places that are known beforehand, and bins are merged by minimum, maximum and integer sums, which
//! no order changes.

mod binned_sah;
mod median;
mod split;

use sahl_math::{Bounds3, Vec3};

use crate::options::{BuildOptions, Builder};

/// No leaf lies deeper below the root. A split that would leave one side too many primitives for balanced splits to
/// finish within the bound is replaced by a balanced one.
pub(crate) const MAX_DEPTH: u32 = 64;

/// A binary tree over primitives, in depth-first order with gaps.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BinaryTree {
    /// The root is node 0; the left child of node `i` is node `i + 1`.
    pub(crate) nodes: Vec<BinaryNode>,
    /// Which primitive stands at each place of the leaves' ranges.
    pub(crate) order: Vec<u32>,
}

/// A node of [`BinaryTree`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BinaryNode {
    /// The box about everything below.
    pub(crate) bounds: Bounds3,
    /// Inner nodes: the right child. Leaves: the first place in [`BinaryTree::order`].
    pub(crate) index: u32,
    /// Leaves: how many primitives; zero for inner nodes.
    pub(crate) count: u32,
}

impl BinaryNode {
    const UNUSED: Self = Self { bounds: Bounds3::EMPTY, index: 0, count: 0 };

    #[inline]
    pub(crate) fn is_leaf(&self) -> bool {
        self.count > 0
    }
}

/// What a builder is given.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BuildInput<'a> {
    /// Boxes: finite, not empty.
    pub(crate) bounds: &'a [Bounds3],
    /// Their middles.
    pub(crate) centers: &'a [Vec3],
}

/// Builds a tree; `None` over no primitives, and for the brute-force list, which has no tree.
pub(crate) fn build(input: BuildInput<'_>, options: &BuildOptions) -> Option<BinaryTree> {
    if input.bounds.is_empty() {
        return None;
    }
    match options.builder {
        Builder::Median => Some(median::build(input)),
        Builder::BinnedSah => Some(binned_sah::build(input, options.bins)),
        Builder::BruteForce => None,
    }
}

impl BinaryTree {
    /// The expected cost of a random ray that meets the root's box, in box tests: one an inner node, and the cost of its
    /// primitives a leaf, each weighted by the chance `A / A_root` that the ray meets the node's box.
    ///
    /// Zero where the root has no area. Source: MacDonald, Booth, *Heuristics for Ray Tracing Using Space Subdivision*, The
    /// Visual Computer 6(3), 1990.
    pub(crate) fn sah_cost(&self, primitive_cost: impl Fn(u32) -> f64) -> f64 {
        let area = |bounds: &Bounds3| {
            let [x, y, z]: [f32; 3] = bounds.diagonal().into();
            let [x, y, z] = [x, y, z].map(f64::from);
            x * y + y * z + z * x
        };
        let Some(root) = self.nodes.first().map(|root| area(&root.bounds)).filter(|&root| root > 0.0) else {
            return 0.0;
        };
        let mut cost = 0.0;
        let mut pending = vec![0_u32];
        while let Some(place) = pending.pop() {
            let node = &self.nodes[place as usize];
            if node.is_leaf() {
                let places = &self.order[node.index as usize..(node.index + node.count) as usize];
                cost += area(&node.bounds) * places.iter().map(|&place| primitive_cost(place)).sum::<f64>();
            } else {
                cost += area(&node.bounds);
                pending.extend([node.index, place + 1]);
            }
        }
        cost / root
    }
}

#[cfg(test)]
mod tests;
