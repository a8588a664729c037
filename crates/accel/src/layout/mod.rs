//! The layout that is traversed: eight-wide nodes and blocks of eight triangles, converted from binary trees.
//!
//! All trees of a world lie in one list of [`Row`]s, in which nodes and blocks stand in the order in which a depth-first walk
//! first meets them. What a node refers to fits one word:
//!
//! | bits | inner node | block of triangles | leaf of one other primitive | nothing |
//! |---|---|---|---|---|
//! | 30–31 | 0 | 1 | 2 | 3 |
//! | 27–29 | first row | first row | 0 curved patch, 1 quadric, 2 instance, 3 part of a curve, 4 moving mesh, 5 moving instance | all ones |
//! | 0–26 | first row | first row | place | all ones |

mod collapse;
mod lanes;
mod plan;
mod refit;

use sahl_math::Vec3;

use crate::kernel::{BLOCK_WIDTH, Node, Row, Rows, TriangleBlock, WIDTH};
pub(crate) use collapse::{TooLarge, append_tree};
pub(crate) use refit::{MovedLeaf, MovedPrimitives};

/// Trees in the form in which they are traversed.
#[derive(Clone, Debug, Default)]
pub(crate) struct WideTrees {
    rows: Rows,
    /// How many, for the statistics.
    pub(crate) nodes: u64,
    pub(crate) blocks: u64,
    pub(crate) leaves: u64,
}

impl WideTrees {
    /// The memory of nodes and blocks in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.rows.bytes()
    }

    /// A node by its first row.
    #[inline(always)]
    pub(crate) fn node(&self, row: u32) -> Node<'_> {
        self.rows.node(row)
    }

    /// A block by its first row.
    #[inline(always)]
    pub(crate) fn block(&self, row: u32) -> TriangleBlock<'_> {
        self.rows.block(row)
    }

    /// Where a row lies; an address to be prefetched, whatever the row.
    #[inline(always)]
    pub(crate) fn address(&self, row: u32) -> *const Row {
        self.rows.address(row)
    }
}

/// One tree of [`WideTrees`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct WideTree {
    /// The place of the root; `None` for a tree over nothing.
    pub(crate) root: Option<u32>,
    /// One more than its last row.
    pub(crate) end: u32,
    /// Nodes on the longest way down.
    pub(crate) depth: u32,
}

/// What a node refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Child {
    Node(u32),
    Block(u32),
    Patch(u32),
    Quadric(u32),
    Instance(u32),
    Curve(u32),
    MovingMesh(u32),
    MovingInstance(u32),
}

/// What is to be done with what a reference refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Test the boxes of a node.
    Node,
    /// Test the triangles of a block.
    Block,
    /// Test another primitive.
    Other,
    /// Nothing: there is no more to visit.
    Done,
}

impl Stage {
    /// Where the stage lies in an encoded reference: in its highest bits.
    pub(crate) const SHIFT: u32 = 30;
}

const KIND_SHIFT: u32 = 27;
const ROW_MASK: u32 = (1 << Stage::SHIFT) - 1;
const PLACE_MASK: u32 = (1 << KIND_SHIFT) - 1;

/// References to rows have places for so many.
const MAX_ROWS: usize = 1 << Stage::SHIFT;

impl Child {
    /// The encoded reference to nothing.
    pub(crate) const NOTHING: u32 = u32::MAX;

    #[inline]
    pub(crate) fn encode(self) -> u32 {
        let stage = |stage: Stage| (stage as u32) << Stage::SHIFT;
        let other = |kind: u32, place: u32| stage(Stage::Other) | kind << KIND_SHIFT | place & PLACE_MASK;
        match self {
            Self::Node(row) => stage(Stage::Node) | row & ROW_MASK,
            Self::Block(row) => stage(Stage::Block) | row & ROW_MASK,
            Self::Patch(place) => other(0, place),
            Self::Quadric(place) => other(1, place),
            Self::Instance(place) => other(2, place),
            Self::Curve(place) => other(3, place),
            Self::MovingMesh(place) => other(4, place),
            Self::MovingInstance(place) => other(5, place),
        }
    }

    #[inline(always)]
    pub(crate) fn stage(encoded: u32) -> Stage {
        match encoded >> Stage::SHIFT {
            0 => Stage::Node,
            1 => Stage::Block,
            2 => Stage::Other,
            _ => Stage::Done,
        }
    }

    /// The first row of an encoded node or block.
    #[inline(always)]
    pub(crate) fn row(encoded: u32) -> u32 {
        encoded & ROW_MASK
    }

    /// What an encoded reference refers to; `None` for nothing.
    #[inline]
    pub(crate) fn decode(encoded: u32) -> Option<Self> {
        let place = encoded & PLACE_MASK;
        Some(match Self::stage(encoded) {
            Stage::Node => Self::Node(Self::row(encoded)),
            Stage::Block => Self::Block(Self::row(encoded)),
            Stage::Other => match encoded >> KIND_SHIFT & 7 {
                0 => Self::Patch(place),
                1 => Self::Quadric(place),
                2 => Self::Instance(place),
                3 => Self::Curve(place),
                4 => Self::MovingMesh(place),
                _ => Self::MovingInstance(place),
            },
            Stage::Done => return None,
        })
    }
}

/// The vertices of triangle items by their ids.
pub(crate) trait Vertices: Sync {
    fn triangle(&self, id: u32) -> [Vec3; 3];

    /// Calls `found` with the place of each of up to [`MOST_AT_ONCE`] ids, in order, and with the triangle's vertices.
    #[inline]
    fn triangles(&self, ids: &[u32], mut found: impl FnMut(usize, [Vec3; 3])) {
        for (place, &id) in ids.iter().enumerate() {
            found(place, self.triangle(id));
        }
    }
}

/// How many triangles are asked for at once: those of a node's blocks.
pub(crate) const MOST_AT_ONCE: usize = WIDTH * BLOCK_WIDTH;

impl<F: Fn(u32) -> [Vec3; 3] + Sync> Vertices for F {
    fn triangle(&self, id: u32) -> [Vec3; 3] {
        self(id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_survive_encoding() {
        for child in [
            Child::Node(0),
            Child::Node(ROW_MASK),
            Child::Block(0),
            Child::Block(ROW_MASK),
            Child::Patch(PLACE_MASK),
            Child::Quadric(17),
            Child::Instance(PLACE_MASK),
            Child::Curve(3),
            Child::Curve(PLACE_MASK),
            Child::MovingMesh(3),
            Child::MovingInstance(PLACE_MASK),
        ] {
            assert_eq!(Child::decode(child.encode()), Some(child));
        }
        assert_eq!(Child::decode(Child::NOTHING), None);
    }
}
