//! From a binary tree to eight-wide nodes: writes what [`super::plan`] decided.

use rayon::prelude::*;

use super::plan::{Plan, Planner};
use super::{Child, MAX_ROWS, MOST_AT_ONCE, Vertices, WideTree, WideTrees, lanes};
use crate::build::{BinaryTree, Box8};
use crate::kernel::{
    BLOCK_ROWS, BLOCK_WIDTH, EMPTY_BLOCK, EMPTY_NODE, Machine, NODE_ROWS, Row, WIDTH, set_child, set_triangle,
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
    tree: &mut BinaryTree,
    vertices: &impl Vertices,
    other_cost: &(impl Fn(Item) -> f32 + Sync),
    machine: Machine,
) -> Result<(WideTree, f32), TooLarge> {
    let mut plans = vec![Plan::default(); tree.nodes.len()];
    let cost = Planner { tree: &*tree, other_cost }.plan(0, &mut plans);
    let first = trees.rows.len();
    let rows = cost.rows_of_root() as usize;
    if first + rows > MAX_ROWS {
        return Err(TooLarge);
    }
    let memory = std::mem::take(&mut tree.spare);
    let collapse = Collapse { tree, plans: &plans, vertices, machine };
    let totals = collapse.write(0, trees.rows.append(rows, memory), first as u32);
    trees.nodes += totals.nodes;
    trees.blocks += totals.blocks;
    trees.leaves += totals.leaves;
    let area = tree.nodes[0].bounds.half_area();
    let cost = if area > 0.0 { cost.as_node / area } else { 0.0 };
    let end = (first + rows) as u32;
    let root = Some(Child::Node(first as u32).encode());
    Ok((WideTree { root, end, depth: totals.depth }, cost))
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

/// What takes up a lane of a wide node.
#[derive(Clone, Copy)]
enum Lane {
    /// A binary node with all below: its place.
    Subtree(u32),
    /// A group of primitives: its place.
    Group(u32),
}

/// The children of a wide node, in the order of the tree.
#[derive(Clone, Copy)]
struct Children {
    lanes: [Lane; WIDTH],
    count: usize,
}

impl Children {
    const NONE: Self = Self { lanes: [Lane::Subtree(0); WIDTH], count: 0 };

    fn push(&mut self, lane: Lane) {
        self.lanes[self.count % WIDTH] = lane;
        self.count += 1;
    }

    fn as_slice(&self) -> &[Lane] {
        &self.lanes[..self.count]
    }
}

struct Collapse<'a, V> {
    tree: &'a BinaryTree,
    plans: &'a [Plan],
    vertices: &'a V,
    machine: Machine,
}

impl<V: Vertices> Collapse<'_, V> {
    /// The children of the wide node that a binary one becomes.
    fn children(&self, place: u32) -> Children {
        let mut children = Children::NONE;
        if self.tree.nodes[place as usize].is_leaf() {
            self.push_leaf(place, &mut children);
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
            let plan = self.plans[child as usize];
            let is_divided = plan.is_divided(lanes);
            if self.tree.nodes[child as usize].is_leaf() && (is_divided || plan.is_leaf()) {
                self.push_leaf(child, children);
            } else if is_divided {
                self.divide(child, lanes, children);
            } else {
                children.push(Lane::Subtree(child));
            }
        }
    }

    /// Lists what a binary leaf becomes.
    fn push_leaf(&self, place: u32, children: &mut Children) {
        if self.tree.is_of_groups() {
            let groups = self.tree.nodes[place as usize].range();
            groups.for_each(|group| children.push(Lane::Group(group as u32)));
        } else {
            children.push(Lane::Subtree(place));
        }
    }

    /// The node to be written below a lane with its plan; `None` for a leaf.
    fn node_below(&self, lane: Lane) -> Option<(u32, Plan)> {
        match lane {
            Lane::Subtree(place) => {
                Some((place, self.plans[place as usize])).filter(|(_, plan)| !plan.is_leaf())
            }
            Lane::Group(_) => None,
        }
    }

    fn bounds(&self, lane: Lane) -> Box8 {
        match lane {
            Lane::Subtree(place) => Box8::new(&self.tree.nodes[place as usize].bounds),
            Lane::Group(place) => *self.tree.groups[place as usize].bounds(),
        }
    }

    /// Writes the wide node at `place` and all below into `rows`, of which the first is row `start` of all.
    ///
    /// The node comes first, then its blocks, then its inner children, each with all below.
    fn write(&self, place: u32, rows: &mut [Row], start: u32) -> Totals {
        let children = self.children(place);
        let is_large = rows.len() >= PARALLEL_ROWS;
        let Some((node, rest)) = rows.split_first_chunk_mut::<NODE_ROWS>() else { return Totals::default() };
        let mut references = [Child::NOTHING; WIDTH];
        let (mut totals, size) =
            self.write_leaves(&children, rest, start + NODE_ROWS as u32, &mut references);
        totals.nodes = 1;
        let (_, mut rest) = rest.split_at_mut(size);
        let mut next = start + (NODE_ROWS + size) as u32;
        let mut tasks = Vec::new();
        for (reference, &lane) in references.iter_mut().zip(children.as_slice()) {
            if let Some((child, plan)) = self.node_below(lane) {
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
        for (reference, &lane) in references.iter_mut().zip(children.as_slice()) {
            if self.node_below(lane).is_some() {
                continue;
            }
            totals.leaves += 1;
            *reference = match self.take_leaf(lane, &mut blocks) {
                Item::Triangle(_) => {
                    next += BLOCK_ROWS as u32;
                    Child::Block(next - BLOCK_ROWS as u32)
                }
                Item::Patch(place) => Child::Patch(place),
                Item::Quadric(place) => Child::Quadric(place),
                Item::Instance(place) => Child::Instance(place),
                Item::Curve(place) => Child::Curve(place),
                Item::MovingMesh(place) => Child::MovingMesh(place),
                Item::MovingInstance(place) => Child::MovingInstance(place),
            }
            .encode();
        }
        totals.blocks = blocks.count as u64;
        blocks.write(self.vertices, rows);
        (totals, blocks.count * BLOCK_ROWS)
    }

    fn write_node(&self, children: &Children, references: &[u32; WIDTH], node: &mut [Row; NODE_ROWS]) {
        let mut boxes = [Box8::EMPTY; WIDTH];
        for (bounds, &lane) in boxes.iter_mut().zip(children.as_slice()) {
            *bounds = self.bounds(lane);
        }
        let boxes = &boxes[..children.count];
        if children.count < WIDTH {
            *node = EMPTY_NODE;
        }
        for ((bounds, &reference), &lane) in
            boxes.iter().zip(references).zip(&lanes::assign(self.machine, boxes))
        {
            set_child(node, lane % WIDTH, &bounds.bounds(), reference);
        }
    }

    /// What the leaf in a lane begins with; triangles become a block.
    fn take_leaf(&self, lane: Lane, blocks: &mut Blocks) -> Item {
        let BinaryTree { nodes, primitives, groups, .. } = self.tree;
        match lane {
            Lane::Group(place) => {
                blocks.take(primitives[groups[place as usize].range()].iter().map(|key| key.item()))
            }
            Lane::Subtree(place) => {
                // Its nodes follow each other; the ranges of its leaves need not.
                let mut last = place as usize;
                while !nodes[last].is_leaf() {
                    last = nodes[last].children(last as u32)[1] as usize;
                }
                let leaves = nodes[place as usize..=last].iter().filter(|node| node.is_leaf());
                blocks.take(leaves.flat_map(|leaf| &primitives[leaf.range()]).map(|key| key.item()))
            }
        }
    }
}

/// The triangles of a node's blocks. They are fetched together, so that the processor waits for many of them at a time.
struct Blocks {
    /// Those of each block after those of the block before.
    ids: [u32; MOST_AT_ONCE],
    /// Where each triangle goes: eight times its block, and its lane.
    places: [u8; MOST_AT_ONCE],
    /// How many triangles there are.
    triangles: usize,
    /// How many triangles each block has.
    sizes: [u8; WIDTH],
    count: usize,
}

impl Blocks {
    const NONE: Self =
        Self { ids: [0; MOST_AT_ONCE], places: [0; MOST_AT_ONCE], triangles: 0, sizes: [0; WIDTH], count: 0 };

    /// Adds a block of triangles, or nothing for one primitive of another kind; returns the first of them.
    fn take(&mut self, items: impl Iterator<Item = Item>) -> Item {
        let mut ids = [u32::MAX; BLOCK_WIDTH];
        let mut found = 0;
        for (id, item) in ids.iter_mut().zip(items) {
            let Item::Triangle(triangle) = item else { return item };
            *id = triangle;
            found += 1;
        }
        let first = Item::Triangle(ids[0]);
        ids[..found].sort_unstable();
        // Parts of one triangle may have come together.
        let mut distinct = 0;
        for &id in &ids[..found] {
            if distinct == 0 || id != self.ids[self.triangles - 1] {
                self.ids[self.triangles] = id;
                self.places[self.triangles] = (self.count * BLOCK_WIDTH + distinct) as u8;
                self.triangles += 1;
                distinct += 1;
            }
        }
        self.sizes[self.count] = distinct as u8;
        self.count += 1;
        first
    }

    /// Writes the blocks one after the other.
    fn write(&self, vertices: &impl Vertices, rows: &mut [Row]) {
        let (blocks, _) = rows.as_chunks_mut::<BLOCK_ROWS>();
        for (block, &size) in blocks.iter_mut().zip(&self.sizes[..self.count]) {
            if usize::from(size) < BLOCK_WIDTH {
                *block = EMPTY_BLOCK;
            }
        }
        vertices.triangles(&self.ids[..self.triangles], |i, vertices| {
            let place = usize::from(self.places[i]);
            set_triangle(&mut blocks[place / BLOCK_WIDTH], place % BLOCK_WIDTH, vertices, self.ids[i]);
        });
    }
}
