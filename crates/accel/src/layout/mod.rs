//! The layout that is traversed: eight-wide nodes and blocks of eight triangles, converted from binary trees.
//!
//! All trees of a world lie in one list of [`Row`]s, in which nodes and blocks stand in the order in which a depth-first walk
//! first meets them. What a node refers to fits one word:
//!
//! | bits | inner node | block of triangles | leaf of one other primitive | nothing |
//! |---|---|---|---|---|
//! | 29–31 | first row | first row | 0 curved patch, 1 quadric, 2 instance, 3 part of a curve, 4 moving mesh, 5 moving instance | all ones |
//! | 2–28 | first row | first row | place | all ones |
//! | 0–1 | 0 | 1 | 2 | 3 |

mod collapse;
mod lanes;
mod plan;
mod refit;

use sahl_math::Vec3;

use crate::kernel::{BLOCK_WIDTH, REFERENCE_SHIFT, Rows, RowsView, WIDTH};
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

    /// Its nodes and blocks, to be read.
    #[inline(always)]
    pub(crate) fn view(&self) -> RowsView<'_> {
        self.rows.view()
    }
}

/// One tree of [`WideTrees`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct WideTree {
    /// The encoded reference to the root; `None` for a tree over nothing.
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
    /// How many of the lowest bits of an encoded reference hold the stage.
    const BITS: u32 = REFERENCE_SHIFT;
    const MASK: u32 = (1 << Self::BITS) - 1;
}

const KIND_SHIFT: u32 = 29;
/// The largest place of a primitive that is not a triangle.
pub(crate) const MAX_PLACE: u32 = (1 << (KIND_SHIFT - Stage::BITS)) - 1;

/// References to rows have places for so many.
const MAX_ROWS: usize = 1 << (u32::BITS - Stage::BITS);

impl Child {
    /// The encoded reference to nothing.
    pub(crate) const NOTHING: u32 = u32::MAX;

    #[inline]
    pub(crate) fn encode(self) -> u32 {
        let other = |kind: u32, place: u32| {
            kind << KIND_SHIFT | (place & MAX_PLACE) << Stage::BITS | Stage::Other as u32
        };
        match self {
            Self::Node(row) => row << Stage::BITS | Stage::Node as u32,
            Self::Block(row) => row << Stage::BITS | Stage::Block as u32,
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
        match encoded & Stage::MASK {
            0 => Stage::Node,
            1 => Stage::Block,
            2 => Stage::Other,
            _ => Stage::Done,
        }
    }

    /// What an encoded reference refers to; `None` for nothing.
    #[inline]
    pub(crate) fn decode(encoded: u32) -> Option<Self> {
        let row = encoded >> Stage::BITS;
        let place = row & MAX_PLACE;
        Some(match Self::stage(encoded) {
            Stage::Node => Self::Node(row),
            Stage::Block => Self::Block(row),
            Stage::Other => match encoded >> KIND_SHIFT {
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
            Child::Node(MAX_ROWS as u32 - 1),
            Child::Block(0),
            Child::Block(MAX_ROWS as u32 - 1),
            Child::Patch(MAX_PLACE),
            Child::Quadric(17),
            Child::Instance(MAX_PLACE),
            Child::Curve(3),
            Child::Curve(MAX_PLACE),
            Child::MovingMesh(3),
            Child::MovingInstance(MAX_PLACE),
        ] {
            assert_eq!(Child::decode(child.encode()), Some(child));
        }
        assert_eq!(Child::decode(Child::NOTHING), None);
    }
}
