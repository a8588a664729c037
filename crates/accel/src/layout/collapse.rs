//! From a binary tree to eight-wide nodes.
//!
//! Which binary nodes become wide ones, and which small subtrees blocks of triangles, is chosen so that the expected cost of a
//! ray is least. The choice is made bottom-up: the least cost of a subtree that takes up `k` lanes of the node above it
//! is the least, over all ways of dividing the lanes, of the sums over its two children.
//!
//! Source: Ylitie, Karras, Laine, *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*, High Performance
//! Graphics 2017, section 3.1. Deviation: a leaf's cost counts blocks, which are tested at once, and no primitives.

use rayon::prelude::*;

use super::{Child, Vertices, WideTree, WideTrees, lanes};
use crate::build::{BinaryNode, BinaryTree, Box8};
use crate::kernel::{
    BLOCK_ROWS, BLOCK_WIDTH, EMPTY_BLOCK, EMPTY_NODE, NODE_ROWS, Row, WIDTH, set_child, set_triangle,
};
use crate::primitive::Item;

/// The cost of testing a block of triangles against that of visiting a node, which is one.
const BLOCK_COST: f32 = 1.0;

/// Subtrees of at least this many binary nodes are worked on by several threads.
const PARALLEL_NODES: usize = 1 << 12;

/// Box8 among which a subtree that does not become a node is divided, at most.
const MAX_LANES: usize = WIDTH - 1;

/// Appends a tree to `trees`; returns it with its expected cost.
///
/// `other_cost` is that of a primitive that is not a triangle, in visits of nodes.
pub(crate) fn append_tree(
    trees: &mut WideTrees,
    tree: &BinaryTree,
    vertices: &impl Vertices,
    other_cost: &(impl Fn(Item) -> f32 + Sync),
) -> (WideTree, f32) {
    let mut plans = vec![Plan::NONE; tree.nodes.len()];
    Planner { tree, other_cost }.plan(0, &mut plans);
    let collapse = Collapse { tree, plans: &plans, vertices };
    let mut sizes = vec![0; tree.nodes.len()];
    let totals = collapse.measure(0, &mut sizes);
    let root = trees.rows.len();
    trees.rows.resize(root + totals.rows as usize, Row::splat(0.0));
    collapse.write(0, &sizes, &mut trees.rows[root..], root as u32);
    trees.nodes += totals.nodes;
    trees.blocks += totals.blocks;
    trees.leaves += totals.leaves;
    let area = half_area(&tree.nodes[0]);
    let cost = if area > 0.0 { plans[0].as_node / area } else { 0.0 };
    (WideTree { root: Some(root as u32), depth: totals.depth }, cost)
}

fn half_area(node: &BinaryNode) -> f32 {
    node.bounds.half_area()
}

/// What a subtree costs.
#[derive(Clone, Copy)]
struct Plan {
    /// Times the area of the root: when it takes up to `k + 1` lanes, at place `k`.
    costs: [f32; MAX_LANES],
    /// The same when it becomes a node of its own.
    as_node: f32,
    /// How many triangles it holds; [`Plan::MANY`] if they do not fit a block, or something else is among them.
    triangles: u32,
    /// Whether it becomes one leaf when it has one lane.
    is_leaf: bool,
}

impl Plan {
    const MANY: u32 = BLOCK_WIDTH as u32 + 1;
    const NONE: Self = Self { costs: [0.0; MAX_LANES], as_node: 0.0, triangles: 0, is_leaf: false };

    fn leaf(cost: f32, area: f32, triangles: u32) -> Self {
        Self { costs: [cost; MAX_LANES], as_node: area + cost, triangles, is_leaf: true }
    }

    /// The plan of a node of half area `area` with these children.
    #[inline]
    fn inner(area: f32, left: &Self, right: &Self) -> Self {
        let mut divided = [f32::INFINITY; WIDTH];
        for (i, left_cost) in left.costs.iter().enumerate() {
            for (j, right_cost) in right.costs[..MAX_LANES - i].iter().enumerate() {
                let cost = left_cost + right_cost;
                // Taken by `i + j + 2` lanes.
                let least = &mut divided[i + j + 1];
                *least = if cost < *least { cost } else { *least };
            }
        }
        let triangles = Self::MANY.min(left.triangles + right.triangles);
        let as_leaf = if triangles < Self::MANY { area * BLOCK_COST } else { f32::INFINITY };
        let mut least_so_far = f32::INFINITY;
        for cost in &mut divided {
            least_so_far = if *cost < least_so_far { *cost } else { least_so_far };
            *cost = least_so_far;
        }
        let as_node = area + divided[WIDTH - 1];
        let is_leaf = as_leaf <= as_node && triangles < Self::MANY;
        let single = if is_leaf { as_leaf } else { as_node };
        let costs = std::array::from_fn(|k| if divided[k] < single { divided[k] } else { single });
        Self { costs, as_node, triangles, is_leaf }
    }
}

struct Planner<'a, C> {
    tree: &'a BinaryTree,
    other_cost: &'a C,
}

impl<C: Fn(Item) -> f32 + Sync> Planner<'_, C> {
    /// Plans the subtree at `place`, whose nodes' plans are `plans`.
    fn plan(&self, place: usize, plans: &mut [Plan]) {
        let node = &self.tree.nodes[place];
        if plans.len() < PARALLEL_NODES || node.is_leaf() {
            // Children stand behind their parents.
            for i in (0..plans.len()).rev() {
                plans[i] = self.plan_node(place + i, |child| &plans[child - place]);
            }
            return;
        }
        let right = node.children(place as u32)[1] as usize - place;
        let (left_plans, right_plans) = plans.split_at_mut(right);
        rayon::join(|| self.plan(place + 1, &mut left_plans[1..]), || self.plan(place + right, right_plans));
        plans[0] = self.plan_node(place, |child| &plans[child - place]);
    }

    #[inline]
    fn plan_node<'a>(&self, place: usize, plan: impl Fn(usize) -> &'a Plan) -> Plan {
        let node = &self.tree.nodes[place];
        let area = half_area(node);
        if node.is_leaf() {
            let references = &self.tree.references[node.range()];
            if references[0].is_triangle() {
                return Plan::leaf(area * BLOCK_COST, area, references.len() as u32);
            }
            return Plan::leaf(area * (self.other_cost)(references[0].item()), area, Plan::MANY);
        }
        let [left, right] = node.children(place as u32).map(|child| plan(child as usize));
        Plan::inner(area, left, right)
    }
}

/// What a wide subtree consists of.
#[derive(Clone, Copy, Default)]
struct Totals {
    rows: u64,
    nodes: u64,
    blocks: u64,
    leaves: u64,
    depth: u32,
}

impl Totals {
    fn and(self, other: Self) -> Self {
        Self {
            rows: self.rows + other.rows,
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
    fn children(&self, place: usize) -> Children {
        let mut children = Children::default();
        if self.plans[place].is_leaf {
            // Only the root becomes a node though it is a leaf.
            children.push(place as u32);
        } else {
            self.divide(place, WIDTH, &mut children);
        }
        children
    }

    /// Divides `count` lanes between the children of a binary node.
    fn divide(&self, place: usize, count: usize, children: &mut Children) {
        let [left, right] = self.tree.nodes[place].children(place as u32).map(|child| child as usize);
        let cost =
            |lanes: usize| self.plans[left].costs[lanes - 1] + self.plans[right].costs[count - lanes - 1];
        let fewest = count.saturating_sub(MAX_LANES).max(1);
        let mut lanes = fewest;
        for more in fewest + 1..count {
            if cost(more) < cost(lanes) {
                lanes = more;
            }
        }
        self.expand(left, lanes, children);
        self.expand(right, count - lanes, children);
    }

    /// Lists what a subtree becomes that may take up to `count` lanes.
    fn expand(&self, place: usize, count: usize, children: &mut Children) {
        let costs = &self.plans[place].costs;
        let fewest = (1..count).find(|&fewer| costs[fewer - 1] == costs[count - 1]).unwrap_or(count);
        if fewest == 1 {
            children.push(place as u32);
        } else {
            self.divide(place, fewest, children);
        }
    }

    /// Stores at each place that becomes a wide node how many rows it takes with everything below; `sizes` are those of the
    /// subtree at `place`.
    fn measure(&self, place: usize, sizes: &mut [u32]) -> Totals {
        let children = self.children(place);
        let mut tasks = Vec::new();
        let is_large = sizes.len() >= PARALLEL_NODES;
        let mut totals = Totals::default();
        let (size, mut rest) = sizes.split_at_mut(1);
        let mut start = place + 1;
        for &child in children.as_slice() {
            let child = child as usize;
            if self.plans[child].is_leaf {
                let is_block = self.plans[child].triangles < Plan::MANY;
                let rows = if is_block { BLOCK_ROWS as u64 } else { 0 };
                totals =
                    totals.and(Totals { rows, blocks: u64::from(is_block), leaves: 1, ..Totals::default() });
                continue;
            }
            let (_, from_child) = rest.split_at_mut(child - start);
            let (of_child, after) = from_child.split_at_mut(self.len(child));
            (start, rest) = (child + of_child.len(), after);
            if is_large {
                tasks.push((child, of_child));
            } else {
                totals = totals.and(self.measure(child, of_child));
            }
        }
        let below = tasks.into_par_iter().map(|(child, sizes)| self.measure(child, sizes));
        totals = totals.and(below.reduce(Totals::default, Totals::and));
        totals.rows += NODE_ROWS as u64;
        totals.nodes += 1;
        totals.depth += 1;
        size[0] = totals.rows as u32;
        totals
    }

    /// How many binary nodes the subtree at `place` has.
    fn len(&self, place: usize) -> usize {
        let mut last = place;
        while !self.tree.nodes[last].is_leaf() {
            last = self.tree.nodes[last].children(last as u32)[1] as usize;
        }
        last + 1 - place
    }

    /// Writes the wide node at `place` and all below into `rows`, of which the first is row `start` of all.
    ///
    /// The node comes first, then its blocks, then its inner children, each with all below.
    fn write(&self, place: usize, sizes: &[u32], rows: &mut [Row], start: u32) {
        let children = self.children(place);
        let mut boxes = [Box8::EMPTY; WIDTH];
        for (lanes, &child) in boxes.iter_mut().zip(children.as_slice()) {
            *lanes = Box8::new(&self.tree.nodes[child as usize].bounds);
        }
        let lanes = lanes::assign(&boxes[..children.count]);
        let mut node = EMPTY_NODE;
        let is_large = rows.len() >= PARALLEL_NODES * BLOCK_ROWS;
        let (node_rows, mut rest) = rows.split_at_mut(NODE_ROWS);
        let mut next = start + NODE_ROWS as u32;
        let mut references = [0; WIDTH];
        for (reference, &child) in references.iter_mut().zip(children.as_slice()) {
            if self.plans[child as usize].is_leaf {
                let (leaf, size) = self.leaf(child as usize, next);
                let (block, after) = rest.split_at_mut(size);
                if !block.is_empty() {
                    self.write_block(child as usize, block);
                }
                *reference = leaf.encode();
                (next, rest) = (next + size as u32, after);
            }
        }
        let mut tasks = Vec::new();
        for (reference, &child) in references.iter_mut().zip(children.as_slice()) {
            if !self.plans[child as usize].is_leaf {
                let size = sizes[child as usize];
                let (below, after) = rest.split_at_mut(size as usize);
                *reference = Child::Node(next).encode();
                if is_large {
                    tasks.push((child as usize, below, next));
                } else {
                    self.write(child as usize, sizes, below, next);
                }
                (next, rest) = (next + size, after);
            }
        }
        for ((&child, &reference), &lane) in children.as_slice().iter().zip(&references).zip(&lanes) {
            set_child(&mut node, lane, &self.tree.nodes[child as usize].bounds, reference);
        }
        node_rows.copy_from_slice(&node);
        tasks.into_par_iter().for_each(|(child, rows, start)| self.write(child, sizes, rows, start));
    }

    /// The leaf that a subtree becomes, with the rows that its block takes, the first of which is `next`.
    fn leaf(&self, place: usize, next: u32) -> (Child, usize) {
        match self.tree.references[self.first(place)].item() {
            Item::Patch(place) => (Child::Patch(place), 0),
            Item::Quadric(place) => (Child::Quadric(place), 0),
            Item::Instance(place) => (Child::Instance(place), 0),
            Item::Triangle(_) => (Child::Block(next), BLOCK_ROWS),
        }
    }

    /// The place of the first reference of a subtree.
    fn first(&self, mut place: usize) -> usize {
        while !self.tree.nodes[place].is_leaf() {
            place += 1;
        }
        self.tree.nodes[place].range().start
    }

    /// Writes the triangles of a subtree that becomes one block.
    fn write_block(&self, place: usize, rows: &mut [Row]) {
        let first = self.first(place);
        let count = self.plans[place].triangles as usize;
        let mut ids = [u32::MAX; BLOCK_WIDTH];
        for (id, reference) in ids.iter_mut().zip(&self.tree.references[first..first + count]) {
            *id = reference.place();
        }
        ids.sort_unstable();
        let mut block = EMPTY_BLOCK;
        let mut lane = 0;
        for (i, &id) in ids[..count].iter().enumerate() {
            // Parts of one triangle may have come together.
            if i == 0 || id != ids[i - 1] {
                set_triangle(&mut block, lane, self.vertices.triangle(id), id);
                lane += 1;
            }
        }
        rows.copy_from_slice(&block);
    }
}
