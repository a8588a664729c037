//! Which binary nodes become wide ones, and which small subtrees blocks of triangles.
//!
//! The choice makes the expected cost of a ray least. It is made bottom-up: the least cost of a subtree that takes up `k` lanes of
//! the node above it is the least, over all ways of dividing the lanes, of the sums over its two children.
//!
//! Source: Ylitie, Karras, Laine, *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*, High Performance
//! Graphics 2017, section 3.1. Deviation: a leaf's cost counts blocks, which are tested at once, and no primitives.

use crate::build::{BinaryNode, BinaryTree};
use crate::kernel::{BLOCK_ROWS, BLOCK_WIDTH, NODE_ROWS, WIDTH};
use crate::primitive::Item;

/// The cost of testing a block of triangles against that of visiting a node, which is one.
pub(super) const BLOCK_COST: f32 = 1.0;

/// Subtrees of at least this many binary nodes are worked on by several threads.
const PARALLEL_NODES: usize = 1 << 12;

/// Lanes that a subtree takes up which does not become a node, at most.
const MAX_LANES: usize = WIDTH - 1;

/// What was decided about a binary node.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Plan {
    /// From the lowest bits: for each number of lanes from two to eight, how many of them the left child gets when they are
    /// divided, three bits each; from how many lanes on they are divided, three bits; whether it is a leaf otherwise.
    bits: u32,
    /// How many rows it takes with everything below when it has one lane; zero for a leaf that is not a block.
    pub(super) rows: u32,
}

const LANE_BITS: u32 = 3;
const THRESHOLD_SHIFT: u32 = LANE_BITS * (WIDTH as u32 - 1);
const LEAF: u32 = 1 << (THRESHOLD_SHIFT + LANE_BITS);

impl Plan {
    fn leaf(rows: u32) -> Self {
        Self { bits: LEAF | (MAX_LANES as u32) << THRESHOLD_SHIFT, rows }
    }

    /// Of a binary leaf that holds so many groups: they take up the lanes if there are enough, and those of a node otherwise.
    fn groups(lanes: usize, rows_of_node: u32) -> Self {
        Self { bits: ((lanes - 1) as u32) << THRESHOLD_SHIFT, rows: rows_of_node }
    }

    /// Whether it becomes one leaf where lanes are not divided, and a node otherwise.
    #[inline]
    pub(super) fn is_leaf(self) -> bool {
        self.bits & LEAF != 0
    }

    /// Whether so many lanes are divided between its children.
    #[inline]
    pub(super) fn is_divided(self, lanes: usize) -> bool {
        lanes > (self.bits >> THRESHOLD_SHIFT) as usize % WIDTH
    }

    /// How many of two to eight lanes the left child gets.
    #[inline]
    pub(super) fn left_lanes(self, lanes: usize) -> usize {
        (self.bits >> ((lanes - 2) as u32 * LANE_BITS)) as usize % WIDTH
    }
}

/// What a subtree costs, times the area of the root, and the rows it takes, for each number of lanes.
#[derive(Clone, Copy)]
pub(super) struct Cost {
    lanes: [f32; MAX_LANES],
    rows: [u32; MAX_LANES],
    /// The cost when it becomes a node of its own.
    pub(super) as_node: f32,
    /// The rows when it becomes a node of its own.
    node_rows: u32,
    /// How many triangles it holds; [`Cost::MANY`] if they do not fit a block, or something else is among them.
    triangles: u32,
    /// Whether it takes up one lane however many it gets.
    is_single: bool,
}

impl Cost {
    const MANY: u32 = BLOCK_WIDTH as u32 + 1;

    /// The rows of a tree that becomes a node whatever it is.
    pub(super) fn rows_of_root(&self) -> u32 {
        self.node_rows
    }

    fn leaf(cost: f32, area: f32, triangles: u32, rows: u32) -> Self {
        let node_rows = rows + NODE_ROWS as u32;
        Self {
            node_rows,
            lanes: [cost; MAX_LANES],
            rows: [rows; MAX_LANES],
            as_node: area + cost,
            triangles,
            is_single: true,
        }
    }

    /// Of a binary leaf that holds at least two groups, which together have this cost and take these rows.
    fn groups(lanes: usize, cost: f32, area: f32, rows: u32) -> Self {
        let (as_node, node_rows) = (area + cost, rows + NODE_ROWS as u32);
        Self {
            lanes: std::array::from_fn(|k| if k + 1 < lanes { as_node } else { cost }),
            rows: std::array::from_fn(|k| if k + 1 < lanes { node_rows } else { rows }),
            as_node,
            node_rows,
            triangles: Self::MANY,
            is_single: lanes > MAX_LANES,
        }
    }
}

/// Plans trees.
pub(super) struct Planner<'a, C> {
    pub(super) tree: &'a BinaryTree,
    /// The cost of a primitive that is not a triangle.
    pub(super) other_cost: &'a C,
}

impl<C: Fn(Item) -> f32 + Sync> Planner<'_, C> {
    /// Plans the subtree at `place`, whose nodes' plans are `plans`.
    ///
    /// The recursion is as deep as the binary tree.
    pub(super) fn plan(&self, place: usize, plans: &mut [Plan]) -> Cost {
        let node = &self.tree.nodes[place];
        let (plan, below) = plans.split_first_mut().expect("every node has a plan");
        if node.is_leaf() {
            let (cost, decided) = self.leaf(node);
            *plan = decided;
            return cost;
        }
        let [left, right] = node.children(place as u32).map(|child| child as usize);
        let (left_plans, right_plans) = below.split_at_mut(right - left);
        let [left, right] = if left_plans.len() + right_plans.len() < PARALLEL_NODES {
            [self.plan(left, left_plans), self.plan(right, right_plans)]
        } else {
            rayon::join(|| self.plan(left, left_plans), || self.plan(right, right_plans)).into()
        };
        let (cost, decided) = divide(node.bounds.half_area(), &left, &right);
        *plan = decided;
        cost
    }

    fn leaf(&self, node: &BinaryNode) -> (Cost, Plan) {
        let area = node.bounds.half_area();
        if !self.tree.is_of_groups() {
            let held = &self.tree.primitives[node.range()];
            let (cost, rows) = self.leaf_of_one(held[0].item(), area);
            let triangles = if rows > 0 { held.len() as u32 } else { Cost::MANY };
            return (Cost::leaf(cost, area, triangles, rows), Plan::leaf(rows));
        }
        let held = &self.tree.groups[node.range()];
        let (mut cost, mut rows) = (0.0, 0);
        for group in held {
            let first = self.tree.primitives[group.range().start].item();
            let of_one = self.leaf_of_one(first, group.bounds().half_area());
            (cost, rows) = (cost + of_one.0, rows + of_one.1);
        }
        if held.len() == 1 {
            return (Cost::leaf(cost, area, Cost::MANY, rows), Plan::leaf(rows));
        }
        let cost = Cost::groups(held.len(), cost, area, rows);
        (cost, Plan::groups(held.len(), cost.node_rows))
    }

    /// What a leaf of half area `area` costs that begins with `item`, and the rows it takes.
    fn leaf_of_one(&self, item: Item, area: f32) -> (f32, u32) {
        match item {
            Item::Triangle(_) => (area * BLOCK_COST, BLOCK_ROWS as u32),
            other => (area * (self.other_cost)(other), 0),
        }
    }
}

/// How many of `lanes` the left side had better get, and what both then cost.
#[inline(always)]
fn best_division(left: &[f32; MAX_LANES], right: &[f32; MAX_LANES], lanes: usize) -> (usize, f32) {
    let first = lanes.saturating_sub(MAX_LANES).max(1);
    let mut best = (first, f32::INFINITY);
    for of_left in first..lanes.min(WIDTH) {
        let cost = left[of_left - 1] + right[lanes - of_left - 1];
        best = if cost < best.1 { (of_left, cost) } else { best };
    }
    best
}

/// The cost of an inner node of half area `area` with these children, and what was decided.
#[inline(always)]
fn divide(area: f32, left: &Cost, right: &Cost) -> (Cost, Plan) {
    // At place `lanes - 1`. More lanes never cost more.
    let mut divided = [f32::INFINITY; WIDTH];
    let mut rows = [0; WIDTH];
    let mut bits = 0;
    for lanes in 2..=WIDTH {
        let (left_lanes, least) = if left.is_single {
            (1, left.lanes[0] + right.lanes[lanes - 2])
        } else if right.is_single {
            (lanes - 1, left.lanes[lanes - 2] + right.lanes[0])
        } else {
            best_division(&left.lanes, &right.lanes, lanes)
        };
        divided[lanes - 1] = least;
        rows[lanes - 1] = left.rows[left_lanes - 1].saturating_add(right.rows[lanes - left_lanes - 1]);
        bits |= (left_lanes as u32) << ((lanes - 2) as u32 * LANE_BITS);
    }
    let triangles = Cost::MANY.min(left.triangles + right.triangles);
    let (as_node, as_leaf) = (area + divided[WIDTH - 1], area * BLOCK_COST);
    let node_rows = rows[WIDTH - 1].saturating_add(NODE_ROWS as u32);
    let is_leaf = triangles < Cost::MANY && as_leaf <= as_node;
    let (single, single_rows) = if is_leaf { (as_leaf, BLOCK_ROWS as u32) } else { (as_node, node_rows) };
    let threshold = MAX_LANES - divided[..MAX_LANES].iter().filter(|&&cost| cost < single).count();
    bits |= (threshold as u32) << THRESHOLD_SHIFT | if is_leaf { LEAF } else { 0 };
    let cost = Cost {
        lanes: std::array::from_fn(|k| if k < threshold { single } else { divided[k] }),
        rows: std::array::from_fn(|k| if k < threshold { single_rows } else { rows[k] }),
        as_node,
        node_rows,
        triangles,
        is_single: threshold == MAX_LANES,
    };
    (cost, Plan { bits, rows: single_rows })
}
