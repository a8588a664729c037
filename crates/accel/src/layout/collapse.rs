//! From a binary tree to eight-wide nodes: writes what [`super::plan`] decided.

use rayon::prelude::*;
use sahl_math::Vec3;

use super::plan::{Plan, Planner};
use super::{Child, MAX_ROWS, Vertices, WideTree, WideTrees, lanes};
use crate::build::{BinaryTree, Box8, Reference};
use crate::kernel::{BLOCK_WIDTH, EMPTY_BLOCK, EMPTY_NODE, NODE_ROWS, Row, WIDTH, set_child, set_triangle};
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
    trees.rows.par_extend(rayon::iter::repeat_n(Row::splat(0.0), rows));
    let collapse = Collapse { tree, plans: &plans, vertices };
    let totals = collapse.write(0, &mut trees.rows[root..], root as u32);
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
        let (node, mut rest) = rows.split_at_mut(NODE_ROWS);
        let mut next = start + NODE_ROWS as u32;
        let mut totals = Totals { nodes: 1, ..Totals::default() };
        let mut references = [Child::NOTHING; WIDTH];
        for (reference, &child) in references.iter_mut().zip(children.as_slice()) {
            let plan = self.plans[child as usize];
            if plan.is_leaf() {
                let (block, after) = rest.split_at_mut(plan.rows as usize);
                if !block.is_empty() {
                    self.write_block(child, block);
                    totals.blocks += 1;
                }
                *reference = self.leaf(child, next).encode();
                totals.leaves += 1;
                (next, rest) = (next + plan.rows, after);
            }
        }
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

    /// The leaf that a subtree becomes; if it is a block, `row` is its first row.
    fn leaf(&self, place: u32, row: u32) -> Child {
        match self.references(place).next().map(Reference::item) {
            Some(Item::Patch(place)) => Child::Patch(place),
            Some(Item::Quadric(place)) => Child::Quadric(place),
            Some(Item::Instance(place)) => Child::Instance(place),
            _ => Child::Block(row),
        }
    }

    /// The references of a subtree that becomes one leaf.
    fn references(&self, place: u32) -> impl Iterator<Item = &Reference> {
        // Its nodes follow each other; the ranges of its leaves need not.
        let mut last = place as usize;
        while !self.tree.nodes[last].is_leaf() {
            last = self.tree.nodes[last].children(last as u32)[1] as usize;
        }
        let leaves = self.tree.nodes[place as usize..=last].iter().filter(|node| node.is_leaf());
        leaves.flat_map(|leaf| &self.tree.references[leaf.range()])
    }

    /// Writes the triangles of a subtree that becomes one block.
    fn write_block(&self, place: u32, rows: &mut [Row]) {
        let mut ids = [u32::MAX; BLOCK_WIDTH];
        for (id, reference) in ids.iter_mut().zip(self.references(place)) {
            *id = reference.place();
        }
        ids.sort_unstable();
        // Parts of one triangle may have come together.
        let mut count = 0;
        for i in 0..BLOCK_WIDTH {
            if ids[i] != u32::MAX && (count == 0 || ids[i] != ids[count - 1]) {
                ids[count] = ids[i];
                count += 1;
            }
        }
        let mut triangles = [[Vec3::ZERO; 3]; BLOCK_WIDTH];
        self.vertices.triangles(&ids[..count], &mut triangles);
        let mut block = EMPTY_BLOCK;
        for (lane, (&id, &vertices)) in ids[..count].iter().zip(&triangles).enumerate() {
            set_triangle(&mut block, lane, vertices, id);
        }
        rows.copy_from_slice(&block);
    }
}
