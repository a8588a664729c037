//! Traversal of the eight-wide trees by one ray.

use sahl_math::Ray;

use super::stack::{LARGE, MEDIUM, SMALL, Stack, StackSize};
use super::{Counter, PreparedRay, Search, offer_crossings};
use crate::instance::PlacedGroup;
use crate::kernel::{EXIT_WIDENING, Isa, Machine, RowsView, Task, TriangleBlock};
use crate::layout::{Child, Stage, WideTree};
use crate::motion::MovingWalk;
use crate::primitive::Primitives;

/// What the traversal reads.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub(crate) trees: RowsView<'a>,
    pub(crate) primitives: &'a Primitives,
    pub(crate) placed: &'a [PlacedGroup],
    /// The trees of the groups.
    pub(crate) groups: &'a [WideTree],
}

/// Searches a tree; returns whether the search ended early.
#[inline]
pub(crate) fn traverse<S: Search, C: Counter>(
    scene: Scene<'_>,
    (machine, stack_size): (Machine, StackSize),
    tree: &WideTree,
    ray: &Ray,
    (search, counter): (&mut S, &mut C),
) -> bool {
    let Some(root) = tree.root else { return false };
    match stack_size {
        StackSize::Small => machine.run(Walk::<S, C, SMALL> { scene, root, ray, search, counter }),
        StackSize::Medium => machine.run(Walk::<S, C, MEDIUM> { scene, root, ray, search, counter }),
        StackSize::Large => machine.run(Walk::<S, C, LARGE> { scene, root, ray, search, counter }),
    }
}

/// One ray on its way through a tree, with a stack of `N` places.
pub(super) struct Walk<'a, S, C, const N: usize> {
    pub(super) scene: Scene<'a>,
    pub(super) root: u32,
    pub(super) ray: &'a Ray,
    pub(super) search: &'a mut S,
    pub(super) counter: &'a mut C,
}

impl<S: Search, C: Counter, const N: usize> Task for Walk<'_, S, C, N> {
    type Output = bool;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> bool {
        let Self { scene, root, ray, search, counter } = self;
        // Prepared here, where it stays in registers and is computed with the instructions of the tier.
        let Some(ray) = &PreparedRay::new(ray) else { return false };
        let mut stack = Stack::<N>::empty();
        let mut child = root;
        let mut reach = search.limit() * EXIT_WIDENING;
        loop {
            match Child::stage(child) {
                Stage::Node => {
                    counter.node();
                    let node = scene.trees.node(child);
                    child = if S::NARROWS {
                        stack.exchange::<I, true>(isa, node, ray, reach)
                    } else {
                        stack.exchange::<I, false>(isa, node, ray, reach)
                    };
                }
                Stage::Done => return false,
                leaf => {
                    let ended = if leaf == Stage::Block {
                        visit_block(isa, scene, child, ray, (search, counter))
                    } else {
                        visit_other::<I, S, C, N>(isa, scene, child, ray, (search, counter))
                    };
                    if ended {
                        return true;
                    }
                    // The same slack as in the box test: a box is dropped only if no hit in it could be nearer.
                    let reached = search.limit() * EXIT_WIDENING;
                    if S::NARROWS && reached < reach {
                        reach = reached;
                        stack.cull(isa, reach);
                    }
                    child = stack.pop();
                }
            }
        }
    }
}

/// Tests the triangles of a block; returns whether the search is over.
#[inline(always)]
pub(super) fn visit_block<I: Isa, S: Search, C: Counter>(
    isa: I,
    scene: Scene<'_>,
    child: u32,
    ray: &PreparedRay,
    (search, counter): (&mut S, &mut C),
) -> bool {
    offer_block(isa, scene.trees.block(child), ray, (search, counter))
}

/// Offers the hits of a block; returns whether the search is over.
#[inline(always)]
pub(crate) fn offer_block<I: Isa, S: Search, C: Counter>(
    isa: I,
    block: TriangleBlock<'_>,
    ray: &PreparedRay,
    (search, counter): (&mut S, &mut C),
) -> bool {
    counter.primitives(|| block.len());
    let limit = search.limit();
    block.intersect(isa, ray, limit, |hit| search.offer(hit.into()))
}

/// The leaves that are rare where speed counts most.
#[inline(never)]
pub(super) fn visit_other<I: Isa, S: Search, C: Counter, const N: usize>(
    isa: I,
    scene: Scene<'_>,
    child: u32,
    ray: &PreparedRay,
    (search, counter): (&mut S, &mut C),
) -> bool {
    let child = Child::decode(child);
    match child {
        Some(Child::Instance(place)) => {
            let placed = &scene.placed[place as usize];
            let local = placed.local_ray(&ray.ray());
            return visit_instance::<I, S, C, N>(isa, scene, (placed, &local), (search, counter));
        }
        Some(Child::MovingInstance(place)) => {
            let placed = &scene.placed[place as usize];
            let local = placed.local_ray_at_time(&ray.ray());
            return visit_instance::<I, S, C, N>(isa, scene, (placed, &local), (search, counter));
        }
        Some(Child::MovingMesh(place)) => {
            let Some(tree) = &scene.primitives.moving[place as usize].tree else { return false };
            return isa.enter(MovingWalk::<S, C, N> { tree, ray, search, counter });
        }
        _ => {}
    }
    counter.primitives(|| 1);
    offer_crossings(search, ray, |ray, limit| match child {
        Some(Child::Patch(place)) => scene.primitives.patch_candidate(place, ray),
        Some(Child::Quadric(place)) => scene.primitives.quadric_candidate(place, ray),
        Some(Child::Curve(place)) => scene.primitives.curve_candidate(place, ray, limit),
        _ => None,
    })
}

fn visit_instance<I: Isa, S: Search, C: Counter, const N: usize>(
    isa: I,
    scene: Scene<'_>,
    (placed, local): (&PlacedGroup, &Ray),
    (search, counter): (&mut S, &mut C),
) -> bool {
    let Some(root) = scene.groups.get(placed.group as usize).and_then(|tree| tree.root) else {
        return false;
    };
    search.enter_instance(placed.instance);
    let ended =
        isa.enter(Walk::<S, C, N> { scene, root, ray: local, search: &mut *search, counter: &mut *counter });
    search.enter_instance(u32::MAX);
    ended
}
