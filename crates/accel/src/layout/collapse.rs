//! From a binary tree to four-wide nodes.
//!
//! A wide node starts from the two children of a binary one and opens the child with the largest area until it has four.
//! A leaf becomes blocks of triangles, and one child for each other primitive.

use sahl_math::Bounds3;

use super::{Child, MAX_LEAF_BLOCKS, Vertices, WideTree, WideTrees};
use crate::build::BinaryTree;
use crate::kernel::{BLOCK_WIDTH, Node, TriangleBlock, WIDTH};
use crate::primitive::{Item, TreeInput};

/// What may become the child of a wide node.
#[derive(Clone, Copy)]
enum Candidate {
    /// A node of the binary tree.
    Binary(u32),
    /// A part of a leaf that is not one child: a range of the tree's order.
    Range(u32, u32),
}

/// Appends a tree over `input` to `trees`.
pub(crate) fn append_tree(
    trees: &mut WideTrees,
    tree: &BinaryTree,
    input: &TreeInput,
    vertices: &impl Vertices,
) -> WideTree {
    let order = order_leaves(tree, input);
    let mut collapse = Collapse { trees, tree, order: &order, input, vertices };
    let root = collapse.trees.nodes.len() as u32;
    let depth = collapse.append_node(Candidate::Binary(0));
    WideTree { root: Some(root), depth }
}

/// The tree's order with the triangles of each leaf before its other primitives.
fn order_leaves(tree: &BinaryTree, input: &TreeInput) -> Vec<u32> {
    let mut order = tree.order.clone();
    let is_other = |place: u32| !matches!(input.items[place as usize], Item::Triangle(_));
    let mut pending = vec![0_u32];
    while let Some(place) = pending.pop() {
        let node = &tree.nodes[place as usize];
        if node.is_leaf() {
            let range = &mut order[node.index as usize..(node.index + node.count) as usize];
            range.sort_unstable_by_key(|&place| (is_other(place), place));
        } else {
            pending.extend([node.index, place + 1]);
        }
    }
    order
}

struct Collapse<'a, V> {
    trees: &'a mut WideTrees,
    tree: &'a BinaryTree,
    order: &'a [u32],
    input: &'a TreeInput,
    vertices: &'a V,
}

impl<V: Vertices> Collapse<'_, V> {
    /// Appends the wide node for `candidate` and all below; returns the depth of this subtree in nodes.
    ///
    /// The recursion is as deep as the binary tree and a leaf's few levels, which are bounded.
    fn append_node(&mut self, candidate: Candidate) -> u32 {
        let slot = self.trees.nodes.len();
        self.trees.nodes.push(Node::empty());
        let (children, count) = self.children(candidate);
        let mut depth = 0;
        for (lane, &child) in children[..count].iter().enumerate() {
            let bounds = self.bounds(child);
            let encoded = match self.leaf(child) {
                Some(leaf) => leaf.encode(),
                None => {
                    let place = self.trees.nodes.len() as u32;
                    depth = depth.max(self.append_node(child));
                    Child::Node(place).encode()
                }
            };
            self.trees.nodes[slot].set(lane, &bounds, encoded);
        }
        depth + 1
    }

    /// Up to [`WIDTH`] children, by opening the largest inner node again and again.
    fn children(&self, candidate: Candidate) -> ([Candidate; WIDTH], usize) {
        let mut children = [candidate; WIDTH];
        let mut count = 1;
        while count < WIDTH {
            let largest = (0..count)
                .filter(|&i| self.can_open(children[i]))
                .map(|i| (self.bounds(children[i]).half_area(), i))
                .reduce(|best, next| if next.0 > best.0 { next } else { best });
            let Some((_, i)) = largest else { break };
            let [left, right] = self.open(children[i]);
            children[i] = left;
            children[count] = right;
            count += 1;
        }
        (children, count)
    }

    fn can_open(&self, candidate: Candidate) -> bool {
        match candidate {
            Candidate::Binary(place) if !self.tree.nodes[place as usize].is_leaf() => true,
            leaf => !self.is_one_child(self.range(leaf)),
        }
    }

    fn open(&self, candidate: Candidate) -> [Candidate; 2] {
        match candidate {
            Candidate::Binary(place) if !self.tree.nodes[place as usize].is_leaf() => {
                [Candidate::Binary(place + 1), Candidate::Binary(self.tree.nodes[place as usize].index)]
            }
            leaf => {
                let (first, end) = self.range(leaf);
                let triangles = (first..end).filter(|&i| self.triangle(i).is_some()).count() as u32;
                // Triangles apart from the others; within one kind, in the middle.
                let middle = if triangles > 0 && triangles < end - first {
                    first + triangles
                } else {
                    first + (end - first).div_ceil(2)
                };
                [Candidate::Range(first, middle), Candidate::Range(middle, end)]
            }
        }
    }

    /// The range of the order that a leaf candidate stands for.
    fn range(&self, candidate: Candidate) -> (u32, u32) {
        match candidate {
            Candidate::Binary(place) => {
                let node = &self.tree.nodes[place as usize];
                (node.index, node.index + node.count)
            }
            Candidate::Range(first, end) => (first, end),
        }
    }

    fn item(&self, i: u32) -> Item {
        self.input.items[self.order[i as usize] as usize]
    }

    fn triangle(&self, i: u32) -> Option<u32> {
        match self.item(i) {
            Item::Triangle(id) => Some(id),
            _ => None,
        }
    }

    /// Whether a range is one primitive, or triangles that fit a leaf.
    fn is_one_child(&self, (first, end): (u32, u32)) -> bool {
        end - first <= 1
            || end - first <= MAX_LEAF_BLOCKS * BLOCK_WIDTH as u32
                && (first..end).all(|i| self.triangle(i).is_some())
    }

    fn bounds(&self, candidate: Candidate) -> Bounds3 {
        match candidate {
            Candidate::Binary(place) => self.tree.nodes[place as usize].bounds,
            Candidate::Range(first, end) => (first..end)
                .map(|i| self.input.bounds[self.order[i as usize] as usize])
                .fold(Bounds3::EMPTY, Bounds3::union),
        }
    }

    /// The leaf that a candidate becomes, its blocks being appended; `None` if it becomes a node.
    fn leaf(&mut self, candidate: Candidate) -> Option<Child> {
        if self.can_open(candidate) {
            return None;
        }
        let (first, end) = self.range(candidate);
        self.trees.leaves += 1;
        Some(match self.item(first) {
            Item::Patch(place) => Child::Patch(place),
            Item::Quadric(place) => Child::Quadric(place),
            Item::Instance(place) => Child::Instance(place),
            Item::Triangle(_) => self.append_blocks(first, end),
        })
    }

    fn append_blocks(&mut self, first: u32, end: u32) -> Child {
        let start = self.trees.blocks.len() as u32;
        let mut ids: Vec<u32> = (first..end).filter_map(|i| self.triangle(i)).collect();
        ids.sort_unstable();
        for chunk in ids.chunks(BLOCK_WIDTH) {
            let mut block = TriangleBlock::empty();
            for (lane, &id) in chunk.iter().enumerate() {
                block.set(lane, self.vertices.triangle(id), id);
            }
            self.trees.blocks.push(block);
        }
        Child::Blocks { first: start, count: self.trees.blocks.len() as u32 - start }
    }
}
