//! From a binary tree to eight-wide nodes: writes what [`super::plan`] decided.

use rayon::prelude::*;
use sahl_math::Vec3;

use super::plan::{Plan, Planner};
use super::{Child, MAX_ROWS, Vertices, WideTree, WideTrees, lanes};
use crate::build::{BinaryNode, BinaryTree, Box8};
use crate::kernel::{
    BLOCK_ROWS, BLOCK_WIDTH, EMPTY_BLOCK, EMPTY_NODE, NODE_ROWS, Row, WIDTH, set_child, set_triangle,
};
use crate::primitive::Item;

/// Subtrees of at least this many rows are written by several threads.
const PARALLEL_ROWS: usize = 1 << 14;

/// There are not as many places for rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TooLarge;

/// Appends a tree to `trees`; returns it with its expected cost.
///
/// `other_cost` is that of a primitive that is not a triangle, in visits of nodes.
pub(crate) fn append_tree(
    trees: &mut WideTrees,
    tree: &BinaryTree,
    vertices: &impl Vertices,
    other_cost: &(impl Fn(Item) -> f32 + Sync),
) -> Result<(WideTree, f32), TooLarge> {
    let mut plans = vec![Plan::default(); tree.nodes.len()];
    let cost = Planner { tree, other_cost }.plan(0, &mut plans);
    let root = trees.rows.len();
    let rows = cost.rows_of_root() as usize;
    if root + rows > MAX_ROWS {
        return Err(TooLarge);
    }
    let collapse = Collapse { tree, plans: &plans, vertices };
    let totals = collapse.write(0, trees.rows.append(rows), root as u32);
    trees.nodes += totals.nodes;
    trees.blocks += totals.blocks;
    trees.leaves += totals.leaves;
    let area = tree.nodes[0].bounds.half_area();
    let cost = if area > 0.0 { cost.as_node / area } else { 0.0 };
    Ok((WideTree { root: Some(root as u32), depth: totals.depth }, cost))
}

/// What a wide subtree consists of.
#[derive(Clone, Copy, Default)]
struct Totals {
    nodes: u64,
    blocks: u64,
    leaves: u64,
    depth: u32,
}

impl Totals {
    fn and(self, other: Self) -> Self {
        Self {
            nodes: self.nodes + other.nodes,
            blocks: self.blocks + other.blocks,
            leaves: self.leaves + other.leaves,
            depth: self.depth.max(other.depth),
        }
    }
}

/// The children of a wide node: places of binary nodes, ascending.
#[derive(Clone, Copy, Default)]
struct Children {
    places: [u32; WIDTH],
    count: usize,
}

impl Children {
    fn push(&mut self, place: u32) {
        self.places[self.count % WIDTH] = place;
        self.count += 1;
    }

    fn as_slice(&self) -> &[u32] {
        &self.places[..self.count]
    }
}

struct Collapse<'a, V> {
    tree: &'a BinaryTree,
    plans: &'a [Plan],
    vertices: &'a V,
}

impl<V: Vertices> Collapse<'_, V> {
    /// The children of the wide node that a binary one becomes.
    fn children(&self, place: u32) -> Children {
        let mut children = Children::default();
        if self.tree.nodes[place as usize].is_leaf() {
            // Only the root becomes a node though it is a leaf.
            children.push(place);
        } else {
            self.divide(place, WIDTH, &mut children);
        }
        children
    }

    /// Divides lanes between the children of a binary node, and lists what takes them up.
    fn divide(&self, place: u32, lanes: usize, children: &mut Children) {
        let [left, right] = self.tree.nodes[place as usize].children(place);
        let left_lanes = self.plans[place as usize].left_lanes(lanes);
        for (child, lanes) in [(left, left_lanes), (right, lanes - left_lanes)] {
            if self.plans[child as usize].is_divided(lanes) {
                self.divide(child, lanes, children);
            } else {
                children.push(child);
            }
        }
    }

    /// Writes the wide node at `place` and all below into `rows`, of which the first is row `start` of all.
    ///
    /// The node comes first, then its blocks, then its inner children, each with all below.
    fn write(&self, place: u32, rows: &mut [Row], start: u32) -> Totals {
        let children = self.children(place);
        let is_large = rows.len() >= PARALLEL_ROWS;
        let (node, rest) = rows.split_at_mut(NODE_ROWS);
        let mut references = [Child::NOTHING; WIDTH];
        let (mut totals, size) =
            self.write_leaves(&children, rest, start + NODE_ROWS as u32, &mut references);
        totals.nodes = 1;
        let (_, mut rest) = rest.split_at_mut(size);
        let mut next = start + (NODE_ROWS + size) as u32;
        let mut tasks = Vec::new();
        for (reference, &child) in references.iter_mut().zip(children.as_slice()) {
            let plan = self.plans[child as usize];
            if !plan.is_leaf() {
                let (below, after) = rest.split_at_mut(plan.rows as usize);
                *reference = Child::Node(next).encode();
                if is_large {
                    tasks.push((child, below, next));
                } else {
                    totals = totals.and(self.write(child, below, next));
                }
                (next, rest) = (next + plan.rows, after);
            }
        }
        self.write_node(&children, &references, node);
        let below = tasks.into_par_iter().map(|(child, rows, start)| self.write(child, rows, start));
        totals = totals.and(below.reduce(Totals::default, Totals::and));
        totals.depth += 1;
        totals
    }

    /// Writes the blocks of a node from the start of `rows` on, the first of which is row `next`, and the references to all its leaves;
    /// returns what they are and how many rows they take.
    fn write_leaves(
        &self,
        children: &Children,
        rows: &mut [Row],
        mut next: u32,
        references: &mut [u32; WIDTH],
    ) -> (Totals, usize) {
        let mut blocks = Blocks::NONE;
        let mut totals = Totals::default();
        for (reference, &child) in references.iter_mut().zip(children.as_slice()) {
            if self.plans[child as usize].is_leaf() {
                totals.leaves += 1;
                *reference = match self.items(child).next() {
                    Some(Item::Patch(place)) => Child::Patch(place),
                    Some(Item::Quadric(place)) => Child::Quadric(place),
                    Some(Item::Instance(place)) => Child::Instance(place),
                    Some(Item::Curve(place)) => Child::Curve(place),
                    Some(Item::Triangle(_)) | None => {
                        blocks.push(self.items(child));
                        next += BLOCK_ROWS as u32;
                        Child::Block(next - BLOCK_ROWS as u32)
                    }
                }
                .encode();
            }
        }
        totals.blocks = blocks.count as u64;
        blocks.write(self.vertices, rows);
        (totals, blocks.count * BLOCK_ROWS)
    }

    fn write_node(&self, children: &Children, references: &[u32; WIDTH], rows: &mut [Row]) {
        let mut boxes = [Box8::EMPTY; WIDTH];
        for (lanes, &child) in boxes.iter_mut().zip(children.as_slice()) {
            *lanes = Box8::new(&self.tree.nodes[child as usize].bounds);
        }
        let lanes = lanes::assign(&boxes[..children.count]);
        let mut node = EMPTY_NODE;
        for ((&child, &reference), &lane) in children.as_slice().iter().zip(references).zip(&lanes) {
            set_child(&mut node, lane, &self.tree.nodes[child as usize].bounds, reference);
        }
        rows.copy_from_slice(&node);
    }

    /// What a subtree holds that becomes one leaf.
    fn items(&self, place: u32) -> impl Iterator<Item = Item> {
        // Its nodes follow each other; the ranges of its leaves need not.
        let mut last = place as usize;
        while !self.tree.nodes[last].is_leaf() {
            last = self.tree.nodes[last].children(last as u32)[1] as usize;
        }
        let leaves = self.tree.nodes[place as usize..=last].iter().filter(|node| node.is_leaf());
        leaves.flat_map(BinaryNode::range).map(|place| self.tree.order.item(place))
    }
}

/// The triangles of a node's blocks. They are fetched together, so that the processor waits for many of them at a time.
struct Blocks {
    ids: [u32; WIDTH * BLOCK_WIDTH],
    /// Where each block ends among the ids.
    ends: [usize; WIDTH],
    count: usize,
}

impl Blocks {
    const NONE: Self = Self { ids: [u32::MAX; WIDTH * BLOCK_WIDTH], ends: [0; WIDTH], count: 0 };

    /// Where the next block begins among the ids.
    fn end(&self) -> usize {
        if self.count == 0 { 0 } else { self.ends[self.count - 1] }
    }

    /// Adds a block of triangles; the ids ascend and are distinct.
    fn push(&mut self, items: impl Iterator<Item = Item>) {
        let start = self.end();
        let ids = &mut self.ids[start..start + BLOCK_WIDTH];
        let mut found = 0;
        for (id, item) in ids.iter_mut().zip(items) {
            if let Item::Triangle(triangle) = item {
                *id = triangle;
                found += 1;
            }
        }
        ids[..found].sort_unstable();
        // Parts of one triangle may have come together.
        let mut distinct = 0;
        for i in 0..found {
            if distinct == 0 || ids[i] != ids[distinct - 1] {
                ids[distinct] = ids[i];
                distinct += 1;
            }
        }
        self.ends[self.count] = start + distinct;
        self.count += 1;
    }

    /// Writes the blocks one after the other.
    fn write(&self, vertices: &impl Vertices, rows: &mut [Row]) {
        let mut triangles = [[Vec3::ZERO; 3]; WIDTH * BLOCK_WIDTH];
        vertices.triangles(&self.ids[..self.end()], &mut triangles);
        let mut start = 0;
        for (&end, rows) in self.ends[..self.count].iter().zip(rows.chunks_exact_mut(BLOCK_ROWS)) {
            let mut block = EMPTY_BLOCK;
            let ids = &self.ids[start..end];
            for (lane, (&id, &vertices)) in ids.iter().zip(&triangles[start..end]).enumerate() {
                set_triangle(&mut block, lane, vertices, id);
            }
            rows.copy_from_slice(&block);
            start = end;
        }
    }
}
