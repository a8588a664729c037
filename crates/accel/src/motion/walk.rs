//! Traversal of a moving mesh by one ray.

use super::MovingTree;
use crate::kernel::{EXIT_WIDENING, Isa, Node, Task, TriangleBlock};
use crate::layout::{Child, Stage};
use crate::traverse::{Counter, PreparedRay, Search, Stack, offer_block};

/// One ray on its way through the tree of a moving mesh, with a stack of `N` places.
///
/// The output is whether the search ended early.
pub(crate) struct MovingWalk<'a, S, C, const N: usize> {
    pub(crate) tree: &'a MovingTree,
    pub(crate) ray: &'a PreparedRay,
    pub(crate) search: &'a mut S,
    pub(crate) counter: &'a mut C,
}

impl<S: Search, C: Counter, const N: usize> Task for MovingWalk<'_, S, C, N> {
    type Output = bool;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> bool {
        let Self { tree, ray, search, counter } = self;
        let Some(mut child) = tree.tree.root else { return false };
        let rows = tree.at(ray.ray().time);
        let mut stack = Stack::<N>::empty();
        let mut reach = search.limit() * EXIT_WIDENING;
        loop {
            match Child::stage(child) {
                Stage::Node => {
                    counter.node();
                    let node = rows.node(isa, child);
                    if S::NARROWS {
                        stack.push_children::<I, true>(isa, Node(&node), ray, reach);
                    } else {
                        stack.push_children::<I, false>(isa, Node(&node), ray, reach);
                    }
                }
                Stage::Block => {
                    let block = rows.block(isa, child);
                    if offer_block(isa, TriangleBlock(&block), ray, (&mut *search, &mut *counter)) {
                        return true;
                    }
                    let reached = search.limit() * EXIT_WIDENING;
                    if S::NARROWS && reached < reach {
                        reach = reached;
                        stack.cull(isa, reach);
                    }
                }
                Stage::Other | Stage::Done => return false,
            }
            child = stack.pop();
        }
    }
}
