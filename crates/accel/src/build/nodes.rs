//! The nodes of a tree as they were made: in several lists.

use super::BinaryNode;
use crate::kernel::prefer_large_pages;

/// Lists of nodes, which one after the other are the depth-first order of a tree.
pub(super) struct NodeLists {
    lists: Vec<Vec<BinaryNode>>,
    /// How many nodes stand before each list.
    starts: Vec<usize>,
}

impl NodeLists {
    pub(super) fn new(lists: Vec<Vec<BinaryNode>>) -> Self {
        let mut end = 0;
        let starts = lists.iter().map(|list| {
            let start = end;
            end += list.len();
            start
        });
        Self { starts: starts.collect(), lists }
    }

    /// How many nodes there are.
    pub(super) fn len(&self) -> usize {
        self.lists.iter().map(Vec::len).sum()
    }

    /// The list in which the node at a place stands, and its place there.
    fn locate(&self, place: usize) -> (usize, usize) {
        let list = self.starts.partition_point(|&start| start <= place) - 1;
        (list, place - self.starts[list])
    }

    /// A node by its place.
    pub(super) fn node(&self, place: u32) -> &BinaryNode {
        let (list, offset) = self.locate(place as usize);
        &self.lists[list][offset]
    }

    /// All nodes.
    pub(super) fn iter(&self) -> impl Iterator<Item = &BinaryNode> {
        self.lists.iter().flatten()
    }

    /// Appends the nodes between two places, of which there is at least one.
    pub(super) fn append_to(&self, nodes: &mut Vec<BinaryNode>, [start, end]: [u32; 2]) {
        let (list, offset) = self.locate(start as usize);
        let mut rest = (end - start) as usize;
        let lists = std::iter::once(&self.lists[list][offset..])
            .chain(self.lists[list + 1..].iter().map(Vec::as_slice));
        for nodes_of_list in lists {
            let taken = rest.min(nodes_of_list.len());
            nodes.extend_from_slice(&nodes_of_list[..taken]);
            rest -= taken;
            if rest == 0 {
                break;
            }
        }
    }

    /// A list for as many nodes as there are.
    pub(super) fn room(&self) -> Vec<BinaryNode> {
        let nodes = Vec::with_capacity(self.len());
        prefer_large_pages(&nodes);
        nodes
    }

    /// One list of all.
    pub(super) fn concat(mut self) -> Vec<BinaryNode> {
        if self.lists.len() == 1 {
            return self.lists.swap_remove(0);
        }
        let mut nodes = self.room();
        self.lists.iter().for_each(|list| nodes.extend_from_slice(list));
        nodes
    }
}

#[cfg(test)]
mod tests {
    use sahl_math::Bounds3;

    use super::*;

    #[test]
    fn lists_are_one_after_the_other() {
        let node = |first: usize| BinaryNode::leaf(Bounds3::EMPTY, first, 1);
        let lists =
            || NodeLists::new(vec![vec![node(0)], vec![node(1), node(2), node(3)], vec![node(4), node(5)]]);
        let all: Vec<BinaryNode> = (0..6).map(node).collect();
        assert_eq!(lists().len(), all.len());
        assert!(lists().iter().eq(&all));
        assert_eq!(lists().concat(), all);
        for start in 0..6 {
            assert_eq!(*lists().node(start), all[start as usize]);
            for end in start + 1..=6 {
                let mut nodes = lists().room();
                lists().append_to(&mut nodes, [start, end]);
                assert_eq!(nodes, all[start as usize..end as usize]);
            }
        }
    }
}
