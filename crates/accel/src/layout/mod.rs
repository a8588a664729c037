//! The layout that is traversed: four-wide nodes and blocks of four triangles, converted from binary trees.
//!
//! All trees of a world lie in one list of nodes and one of blocks. What a node refers to fits one word:
//!
//! | bits | inner node | leaf of triangles | leaf of one other primitive |
//! |---|---|---|---|
//! | 31 | 0 | 1 | 1 |
//! | 29–30 | place | 0 | 1 curved patch, 2 quadric, 3 instance |
//! | 27–28 | place | blocks − 1 | 0 |
//! | 0–26 | place | first block | place |

mod collapse;

use sahl_math::Vec3;

use crate::kernel::{Node, TriangleBlock};
pub(crate) use collapse::append_tree;

/// Trees in the form in which they are traversed.
#[derive(Clone, Debug, Default)]
pub(crate) struct WideTrees {
    pub(crate) nodes: Vec<Node>,
    pub(crate) blocks: Vec<TriangleBlock>,
    /// Leaves, for the statistics.
    pub(crate) leaves: u64,
}

impl WideTrees {
    /// The memory of nodes and blocks in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        (size_of_val(self.nodes.as_slice()) + size_of_val(self.blocks.as_slice())) as u64
    }
}

/// One tree of [`WideTrees`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct WideTree {
    /// The place of the root; `None` for a tree over nothing.
    pub(crate) root: Option<u32>,
    /// Nodes on the longest way down.
    pub(crate) depth: u32,
}

/// What a node refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Child {
    Node(u32),
    Blocks { first: u32, count: u32 },
    Patch(u32),
    Quadric(u32),
    Instance(u32),
}

const LEAF: u32 = 1 << 31;
const KIND_SHIFT: u32 = 29;
const COUNT_SHIFT: u32 = 27;
const PLACE_MASK: u32 = (1 << COUNT_SHIFT) - 1;

/// The most blocks a leaf refers to.
pub(crate) const MAX_LEAF_BLOCKS: u32 = 4;

impl Child {
    #[inline]
    pub(crate) fn encode(self) -> u32 {
        let other = |kind: u32, place: u32| LEAF | kind << KIND_SHIFT | place & PLACE_MASK;
        match self {
            Self::Node(place) => place,
            Self::Blocks { first, count } => LEAF | (count - 1) << COUNT_SHIFT | first & PLACE_MASK,
            Self::Patch(place) => other(1, place),
            Self::Quadric(place) => other(2, place),
            Self::Instance(place) => other(3, place),
        }
    }

    /// Whether an encoded reference is an inner node, whose place it then is.
    #[inline(always)]
    pub(crate) fn is_node(encoded: u32) -> bool {
        encoded & LEAF == 0
    }

    #[inline(always)]
    pub(crate) fn decode(encoded: u32) -> Self {
        if Self::is_node(encoded) {
            return Self::Node(encoded);
        }
        let place = encoded & PLACE_MASK;
        match encoded >> KIND_SHIFT & 3 {
            0 => Self::Blocks { first: place, count: (encoded >> COUNT_SHIFT & 3) + 1 },
            1 => Self::Patch(place),
            2 => Self::Quadric(place),
            _ => Self::Instance(place),
        }
    }
}

/// The vertices of a triangle item by its id.
pub(crate) trait Vertices {
    fn triangle(&self, id: u32) -> [Vec3; 3];
}

impl<F: Fn(u32) -> [Vec3; 3]> Vertices for F {
    fn triangle(&self, id: u32) -> [Vec3; 3] {
        self(id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_survive_encoding() {
        let largest = PLACE_MASK;
        for child in [
            Child::Node(0),
            Child::Node(LEAF - 1),
            Child::Blocks { first: 0, count: 1 },
            Child::Blocks { first: largest, count: MAX_LEAF_BLOCKS },
            Child::Patch(largest),
            Child::Quadric(17),
            Child::Instance(largest),
        ] {
            assert_eq!(Child::decode(child.encode()), child);
        }
    }
}
