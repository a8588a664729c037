//! Moves subtrees to where they cost less.
//!
//! Only the top of the tree is changed, the nodes with the largest boxes: they are visited most. What hangs below is moved as it is.
//!
//! Source: Meister, Bittner, *Parallel Reinsertion for Bounding Volume Hierarchy Optimization*, Computer Graphics Forum 37(2), 2018.
//! Deviation: moves are made one after the other in the order of their gain, so that the result does not depend on threads.

use rayon::prelude::*;

use super::nodes::NodeLists;
use super::reference::Box8;
use super::{BinaryNode, MAX_DEPTH};

/// Stands for no node.
const NONE: u32 = u32::MAX;

/// Of so many nodes one is asked for its area, to find which are the largest.
const SAMPLE_STRIDE: usize = 16;

/// How many searches one task makes.
const CHUNK: usize = 64;

/// How much to change.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    /// The share of the tree's nodes that may be moved.
    share: f32,
    /// How often each may be moved.
    rounds: u32,
}

impl Effort {
    /// What costs a few hundredths of the time that the tree takes, and brings most of the gain.
    pub(super) const DEFAULT: Self = Self { share: 0.02, rounds: 3 };
    /// What is worth it where time does not count.
    pub(super) const HIGH: Self = Self { share: 0.5, rounds: 8 };
}

/// Trees that a first round improves by less, as a share of the changed nodes' areas, are left as they are: with surfaces of even
/// triangles the heuristic then no longer tells which tree is the faster one.
const MIN_GAIN: f32 = 0.02;

/// The nodes of a tree, improved.
pub(super) fn optimize(nodes: NodeLists, effort: Effort) -> Vec<BinaryNode> {
    let mut top = Top::new(&nodes, least_area(&nodes, effort.share));
    let before = top.inner_area();
    top.improve();
    if before - top.inner_area() > MIN_GAIN * before {
        for _ in 1..effort.rounds {
            top.improve();
        }
        if let Some(improved) = top.nodes(&nodes) {
            return improved;
        }
    }
    nodes.concat()
}

/// An area that about this share of the nodes exceeds.
fn least_area(nodes: &NodeLists, share: f32) -> f32 {
    let mut areas: Vec<f32> =
        nodes.iter().step_by(SAMPLE_STRIDE).map(|node| node.bounds.half_area()).collect();
    let place = ((1.0 - share) * areas.len() as f32) as usize;
    if share >= 1.0 || place >= areas.len() {
        return 0.0;
    }
    *areas.select_nth_unstable_by(place, f32::total_cmp).1
}

/// A subtree with the one next to which it had better be.
#[derive(Clone, Copy)]
struct Move {
    node: u32,
    to: u32,
    gain: f32,
}

/// The top of a tree, with links in both directions. The root is node 0.
struct Top {
    nodes: Vec<Node>,
}

#[derive(Clone, Copy)]
struct Node {
    bounds: Box8,
    area: f32,
    /// [`NONE`] for the root.
    parent: u32,
    /// [`NONE`] for one that stands for a whole subtree.
    children: [u32; 2],
    /// The subtree that it stands for: the places of its nodes.
    subtree: [u32; 2],
}

/// Nodes that one search looks at, at most: where all boxes overlap, nothing bounds it.
const MOST_VISITS: u32 = 4096;

/// Nodes that are looked at for moves, at most.
const MOST_NODES: usize = 1 << 20;

impl Top {
    /// The part of a tree in which every inner node has at least this area.
    fn new(nodes: &NodeLists, least_area: f32) -> Self {
        let mut top = Self { nodes: Vec::new() };
        let mut pending = vec![([0, nodes.len() as u32], NONE)];
        while let Some((subtree, parent)) = pending.pop() {
            let place = subtree[0];
            let node = nodes.node(place);
            let bounds = Box8::new(&node.bounds);
            let area = bounds.half_area();
            let own = top.nodes.len() as u32;
            if let Some(parent) = top.nodes.get_mut(parent as usize) {
                parent.children[usize::from(parent.children[0] != NONE)] = own;
            }
            top.nodes.push(Node { bounds, area, parent, children: [NONE; 2], subtree });
            if !node.is_leaf() && area >= least_area && top.nodes.len() < MOST_NODES {
                let [left, right] = node.children(place);
                pending.extend([([right, subtree[1]], own), ([left, right], own)]);
            }
        }
        top
    }

    /// Moves every node that had better be somewhere else, unless a move before has changed its surroundings.
    fn improve(&mut self) {
        let places: Vec<u32> = (1..self.nodes.len() as u32).collect();
        let mut moves: Vec<Move> =
            places.par_iter().with_min_len(CHUNK).filter_map(|&node| self.best_move(node)).collect();
        moves.par_sort_unstable_by(|a, b| b.gain.total_cmp(&a.gain).then(a.node.cmp(&b.node)));
        let mut is_changed = vec![false; self.nodes.len()];
        for one in &moves {
            let surroundings = self.surroundings(one);
            if !surroundings.iter().any(|&node| is_changed[node as usize]) && !self.is_below(one.to, one.node)
            {
                surroundings.iter().for_each(|&node| is_changed[node as usize] = true);
                self.make(one);
            }
        }
    }

    /// Whether a node is another or lies below it: moves before may have brought it there.
    fn is_below(&self, mut node: u32, other: u32) -> bool {
        while node != other && node != 0 {
            node = self.node(node).parent;
        }
        node == other
    }

    /// The areas of the nodes that have children.
    fn inner_area(&self) -> f32 {
        self.nodes.iter().filter(|node| node.children[0] != NONE).map(|node| node.area).sum()
    }

    fn node(&self, place: u32) -> &Node {
        &self.nodes[place as usize]
    }

    fn sibling(&self, place: u32) -> u32 {
        let [left, right] = self.node(self.node(place).parent).children;
        if left == place { right } else { left }
    }

    /// Where a node had better be: branch and bound, from its sibling outwards.
    fn best_move(&self, node: u32) -> Option<Move> {
        let Node { bounds, area, parent, .. } = *self.node(node);
        if parent == 0 {
            return None;
        }
        let mut best = Move { node, to: NONE, gain: 0.0 };
        let (mut pivot, mut subtree) = (parent, self.sibling(node));
        let mut rest = self.node(subtree).bounds;
        // What the move gains before it costs anything: the area of the parent, which goes, and what its ancestors shrink.
        let mut gained = self.node(parent).area;
        let mut pending = Vec::with_capacity(MAX_DEPTH as usize);
        let mut visits = 0;
        loop {
            pending.push((gained, subtree));
            while let Some((gained, to)) = pending.pop() {
                visits += 1;
                if visits > MOST_VISITS {
                    return (best.to != NONE).then_some(best);
                }
                if gained - area <= best.gain {
                    continue;
                }
                let target = self.node(to);
                let gain = gained - target.bounds.union(bounds).half_area();
                if gain > best.gain && to != self.sibling(node) {
                    best = Move { node, to, gain };
                }
                let [left, right] = target.children;
                if left != NONE {
                    pending.extend([(gain + target.area, left), (gain + target.area, right)]);
                }
            }
            if pivot != parent {
                rest = rest.union(self.node(subtree).bounds);
                gained += self.node(pivot).area - rest.half_area();
            }
            if pivot == 0 {
                break;
            }
            subtree = self.sibling(pivot);
            pivot = self.node(pivot).parent;
        }
        (best.to != NONE).then_some(best)
    }

    /// The nodes whose links a move changes.
    fn surroundings(&self, one: &Move) -> [u32; 6] {
        let parent = self.node(one.node).parent;
        let to_parent = self.node(one.to).parent;
        let or = |place: u32, other: u32| if place == NONE { other } else { place };
        let grandparent = self.node(parent).parent;
        [one.node, parent, self.sibling(one.node), or(grandparent, parent), one.to, or(to_parent, one.to)]
    }

    /// The sibling takes the place of the parent, which comes between the target and the target's parent.
    fn make(&mut self, one: &Move) {
        let Move { node, to, .. } = *one;
        let (sibling, parent) = (self.sibling(node), self.node(node).parent);
        let grandparent = self.node(parent).parent;
        self.replace(grandparent, parent, sibling);
        let to_parent = self.node(to).parent;
        self.replace(to_parent, to, parent);
        self.nodes[parent as usize].children = [to, node];
        self.nodes[to as usize].parent = parent;
        self.refit(grandparent);
        self.refit(parent);
    }

    fn replace(&mut self, parent: u32, old: u32, new: u32) {
        let children = &mut self.nodes[parent as usize].children;
        children[usize::from(children[1] == old)] = new;
        self.nodes[new as usize].parent = parent;
    }

    fn refit(&mut self, mut place: u32) {
        while place != NONE {
            let [left, right] = self.node(place).children;
            let bounds = self.node(left).bounds.union(self.node(right).bounds);
            let node = &mut self.nodes[place as usize];
            (node.bounds, node.area) = (bounds, bounds.half_area());
            place = node.parent;
        }
    }

    /// The nodes of the whole tree in depth-first order; `None` if it has become too deep.
    fn nodes(&self, old: &NodeLists) -> Option<Vec<BinaryNode>> {
        let mut nodes = old.room();
        // Where the subtrees begin, and how deep.
        let mut subtrees = Vec::new();
        let mut pending = vec![(0, NONE, 0)];
        while let Some((place, parent, depth)) = pending.pop() {
            let own = nodes.len();
            if parent != NONE {
                nodes[parent as usize].set_right(parent as usize, own);
            }
            let node = self.node(place);
            let [left, right] = node.children;
            if left == NONE {
                subtrees.push((own, depth));
                old.append_to(&mut nodes, node.subtree);
            } else {
                nodes.push(BinaryNode::inner(node.bounds.bounds()));
                pending.extend([(right, own as u32, depth + 1), (left, NONE, depth + 1)]);
            }
        }
        let depths = subtrees.par_iter().with_min_len(CHUNK);
        let deepest = depths.map(|&(start, above)| above + depth(&nodes[start..])).max();
        (deepest.unwrap_or(0) <= MAX_DEPTH).then_some(nodes)
    }
}

/// The depth of the deepest leaf below the first node.
fn depth(nodes: &[BinaryNode]) -> u32 {
    let mut deepest = 0;
    let mut pending = vec![(0, 0)];
    while let Some((place, depth)) = pending.pop() {
        deepest = deepest.max(depth);
        let node = &nodes[place as usize];
        if !node.is_leaf() {
            pending.extend(node.children(place).map(|child| (child, depth + 1)));
        }
    }
    deepest
}
