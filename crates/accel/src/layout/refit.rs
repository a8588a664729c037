//! Trees over primitives that have moved: the same nodes, with boxes about where the primitives are now.
//!
//! Source: Wald, Boulos, Shirley, *Ray Tracing Deformable Scenes Using Dynamic Bounding Volume Hierarchies*, ACM Transactions on Graphics
//! 26(1), 2007.

use rayon::prelude::*;
use sahl_math::{Bounds3, Vec3};

use super::{Child, WideTree, WideTrees};
use crate::kernel::{
    BLOCK_ROWS, BLOCK_WIDTH, NODE_ROWS, Node, Row, TriangleBlock, WIDTH, set_child, set_triangle,
};

/// Subtrees of at least this many rows are refitted by several threads.
const PARALLEL_ROWS: usize = 1 << 14;

/// What stands for no child in a lane: the first row is a root, and no child of anything.
const PADDING: u32 = 0;

/// What a triangle that cannot be hit any more is made of.
const NO_TRIANGLE: [Vec3; 3] = [Vec3::splat(f32::NAN); 3];

/// Where primitives are now.
pub(crate) trait MovedPrimitives: Sync {
    /// The box about nothing, with which lanes are filled that hold nothing.
    const NOTHING: Bounds3;

    /// A triangle by its id; `None` if it cannot be hit any more.
    fn triangle(&self, id: u32) -> Option<[Vec3; 3]>;

    /// A leaf that is not a block.
    fn other(&self, child: Child) -> MovedLeaf;
}

/// A leaf of one primitive that is not a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MovedLeaf {
    /// What refers to it from now on.
    pub(crate) child: Child,
    /// The box about it; [`MovedPrimitives::NOTHING`] if it cannot be hit any more.
    pub(crate) bounds: Bounds3,
    /// The cost of testing it, in visits of nodes.
    pub(crate) cost: f32,
}

/// A tree about which was found out where it is now.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Refitted {
    pub(crate) bounds: Bounds3,
    /// The expected cost of a ray that meets the box.
    pub(crate) cost: f32,
}

impl WideTrees {
    /// Puts the primitives of a tree where they are now.
    pub(crate) fn refit<M: MovedPrimitives>(&mut self, tree: &WideTree, moved: &M) -> Refitted {
        let Some(Child::Node(first)) = tree.root.and_then(Child::decode) else {
            return Refitted { bounds: Bounds3::EMPTY, cost: 0.0 };
        };
        let below = refit(self.rows.between(first, tree.end), first, moved);
        let area = below.bounds.half_area();
        let cost = if area > 0.0 { 1.0 + below.cost / area } else { 0.0 };
        Refitted { bounds: below.bounds, cost }
    }
}

/// What a lane of a node holds: the cost is that times the area of the box, without the visit of the node above.
#[derive(Clone, Copy)]
struct Lane {
    child: u32,
    bounds: Bounds3,
    cost: f32,
}

/// A node in a lane of the one above, with its rows, of which the first is row `start` of all.
struct Below<'a> {
    lane: usize,
    rows: &'a mut [Row],
    start: u32,
}

/// Refits the node at the beginning of `rows`, which is row `start` of all, and everything below, which are the others; the cost is that
/// of what is below, times the area.
///
/// The recursion is as deep as the tree.
fn refit<M: MovedPrimitives>(rows: &mut [Row], start: u32, moved: &M) -> Refitted {
    let is_large = rows.len() >= PARALLEL_ROWS;
    let (node, mut rest) = rows.split_at_mut(NODE_ROWS);
    let Some(node) = node.first_chunk_mut::<NODE_ROWS>() else {
        return Refitted { bounds: Bounds3::EMPTY, cost: 0.0 };
    };
    let mut first = start + NODE_ROWS as u32;
    let mut lanes = Node(node).children().0.map(|child| Lane::of(child.to_bits(), M::NOTHING));
    refit_leaves(&mut lanes, (rest, first), moved);
    let (inner, count) = inner_children(&lanes);
    let mut tasks = Vec::new();
    for (place, &(row, lane)) in inner[..count].iter().enumerate() {
        let end = if place + 1 < count { inner[place + 1].0 } else { first + rest.len() as u32 };
        let (_, from_here) = rest.split_at_mut((row - first) as usize);
        let (rows, after) = from_here.split_at_mut((end - row) as usize);
        if is_large {
            tasks.push(Below { lane, rows, start: row });
        } else {
            lanes[lane].take(refit(rows, row, moved));
        }
        (rest, first) = (after, end);
    }
    let below = tasks.into_par_iter().map(|below| (below.lane, refit(below.rows, below.start, moved)));
    for (lane, refitted) in below.collect::<Vec<_>>() {
        lanes[lane].take(refitted);
    }
    write_node(node, &lanes, M::NOTHING)
}

/// The inner children in the order of their rows: each one's first row and its lane. How many there are comes second.
fn inner_children(lanes: &[Lane; WIDTH]) -> ([(u32, usize); WIDTH], usize) {
    let mut inner = [(u32::MAX, 0); WIDTH];
    let mut count = 0;
    for (lane, Lane { child, .. }) in lanes.iter().enumerate() {
        if let Some(Child::Node(row)) = Child::decode(*child)
            && *child != PADDING
        {
            inner[count] = (row, lane);
            count += 1;
        }
    }
    inner.sort_unstable();
    (inner, count)
}

fn write_node(node: &mut [Row; NODE_ROWS], lanes: &[Lane; WIDTH], nothing: Bounds3) -> Refitted {
    let mut total = Refitted { bounds: Bounds3::EMPTY, cost: 0.0 };
    for (lane, &Lane { child, bounds, cost }) in lanes.iter().enumerate() {
        if bounds.is_empty() {
            set_child(node, lane, &nothing, child);
        } else {
            set_child(node, lane, &bounds, child);
            total.bounds = total.bounds.union(bounds);
        }
        total.cost += cost;
    }
    total
}

impl Lane {
    fn of(child: u32, bounds: Bounds3) -> Self {
        Self { child, bounds, cost: 0.0 }
    }

    /// Takes what was found out about the node that it holds.
    fn take(&mut self, below: Refitted) {
        self.bounds = below.bounds;
        self.cost = below.bounds.half_area() + below.cost;
    }
}

/// Refits the blocks of a node, which are at the beginning of `rows`, and what else its leaves are.
fn refit_leaves<M: MovedPrimitives>(lanes: &mut [Lane; WIDTH], (rows, first): (&mut [Row], u32), moved: &M) {
    for lane in lanes.iter_mut().filter(|lane| lane.child != PADDING) {
        match Child::decode(lane.child) {
            None | Some(Child::Node(_)) => {}
            Some(Child::Block(row)) => {
                let rows = &mut rows[(row - first) as usize..];
                if let Some(block) = rows.first_chunk_mut::<BLOCK_ROWS>() {
                    lane.bounds = refit_block(block, moved);
                }
                lane.cost = lane.bounds.half_area() * super::plan::BLOCK_COST;
            }
            Some(other) => {
                let MovedLeaf { child, bounds, cost } = moved.other(other);
                *lane = Lane { child: child.encode(), bounds, cost: bounds.half_area() * cost };
            }
        }
    }
}

/// Puts the triangles of a block where they are now; returns the box about them.
fn refit_block(block: &mut [Row; BLOCK_ROWS], moved: &impl MovedPrimitives) -> Bounds3 {
    let mut bounds = Bounds3::EMPTY;
    for lane in 0..BLOCK_WIDTH {
        let id = TriangleBlock(block).id(lane);
        if id == u32::MAX {
            continue;
        }
        let triangle = moved.triangle(id);
        bounds = triangle.into_iter().flatten().fold(bounds, Bounds3::including);
        set_triangle(block, lane, triangle.unwrap_or(NO_TRIANGLE), id);
    }
    bounds
}
