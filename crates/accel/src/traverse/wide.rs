//! Traversal of the four-wide trees.
//!
//! Children are visited near first. The stack holds a fixed number of entries: a tree of depth `d` never has more than
//! `3 d` pending, and the depth is bounded by the builders.

use sahl_math::Ray;

use super::{Candidate, Counter, PreparedRay, Search};
use crate::build::MAX_DEPTH;
use crate::instance::PlacedGroup;
use crate::kernel::{EXIT_WIDENING, NodeHits, WIDTH};
use crate::layout::{Child, WideTree, WideTrees};
use crate::primitive::Primitives;

/// Levels that the conversion of a leaf may add below a binary tree: a leaf of eight is opened by halves.
const LEAF_LEVELS: u32 = 4;

/// What the traversal reads.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub(crate) trees: &'a WideTrees,
    pub(crate) primitives: &'a Primitives,
    pub(crate) placed: &'a [PlacedGroup],
    /// The trees of the groups.
    pub(crate) groups: &'a [WideTree],
}

/// A stack large enough for every tree of a world, chosen once: clearing a large one costs as much as a small scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StackSize {
    /// 16 entries.
    Small,
    /// 64 entries.
    Medium,
    /// 256 entries, enough for any tree.
    Large,
}

const _: () = assert!(3 * (MAX_DEPTH + LEAF_LEVELS) < 256);

impl StackSize {
    /// The size for trees of at most this depth in wide nodes.
    pub(crate) fn for_depth(depth: u32) -> Self {
        match 3 * depth {
            0..16 => Self::Small,
            16..64 => Self::Medium,
            _ => Self::Large,
        }
    }
}

/// A child still to visit.
#[derive(Clone, Copy, Default)]
struct Entry {
    child: u32,
    enter: f32,
}

/// Searches a tree; returns whether the search ended early.
#[inline]
pub(crate) fn traverse<S: Search, C: Counter>(
    scene: Scene<'_>,
    stack_size: StackSize,
    tree: &WideTree,
    ray: &PreparedRay,
    (search, counter): (&mut S, &mut C),
) -> bool {
    let Some(root) = tree.root else { return false };
    match stack_size {
        StackSize::Small => walk::<16, S, C>(scene, root, ray, search, counter),
        StackSize::Medium => walk::<64, S, C>(scene, root, ray, search, counter),
        StackSize::Large => walk::<256, S, C>(scene, root, ray, search, counter),
    }
}

/// The loop over nodes and leaves, with a stack of `N` entries, a power of two.
fn walk<const N: usize, S: Search, C: Counter>(
    scene: Scene<'_>,
    root: u32,
    ray: &PreparedRay,
    search: &mut S,
    counter: &mut C,
) -> bool {
    let mut stack = [Entry::default(); N];
    let mut height = 0;
    let mut child = root;
    loop {
        if Child::is_node(child) {
            counter.node();
            let node = &scene.trees.nodes[child as usize];
            let hits = node.hits(&ray.node_ray, search.limit());
            if hits.mask != 0 {
                child = push_children::<N, S>(&node.children, hits, &mut stack, &mut height);
                continue;
            }
        } else if visit_leaf::<N, S, C>(scene, child, ray, search, counter) {
            return true;
        }
        // The same slack as in the box test, so that the order of visits cannot decide between nearly equal hits.
        child = loop {
            if height == 0 {
                return false;
            }
            height -= 1;
            let entry = stack[height % N];
            if entry.enter <= search.limit() * EXIT_WIDENING {
                break entry.child;
            }
        };
    }
}

/// Pushes the children that were hit, but for the nearest, which is returned. `hits.mask` is not zero.
#[inline(always)]
fn push_children<const N: usize, S: Search>(
    children: &[u32; WIDTH],
    hits: NodeHits,
    stack: &mut [Entry; N],
    height: &mut usize,
) -> u32 {
    let enters = hits.enter.to_array();
    let mut mask = hits.mask;
    let mut next = || {
        let lane = mask.trailing_zeros() as usize % WIDTH;
        mask &= mask - 1;
        (Entry { child: children[lane], enter: enters[lane] }, mask == 0)
    };
    let (mut nearest, mut last) = next();
    let base = *height;
    while !last {
        let (mut entry, is_last) = next();
        last = is_last;
        if !S::ANY && entry.enter < nearest.enter {
            std::mem::swap(&mut entry, &mut nearest);
        }
        // Insertion keeps the pending ones in order, the nearest on top.
        let mut place = *height;
        while !S::ANY && place > base && stack[(place - 1) % N].enter < entry.enter {
            stack[place % N] = stack[(place - 1) % N];
            place -= 1;
        }
        stack[place % N] = entry;
        *height += 1;
    }
    nearest.child
}

/// Tests what a leaf holds; returns whether the search is over.
#[inline(always)]
fn visit_leaf<const N: usize, S: Search, C: Counter>(
    scene: Scene<'_>,
    leaf: u32,
    ray: &PreparedRay,
    search: &mut S,
    counter: &mut C,
) -> bool {
    match Child::decode(leaf) {
        Child::Blocks { first, count } => {
            for block in &scene.trees.blocks[first as usize..(first + count) as usize] {
                counter.primitives(block.len());
                let limit = search.limit();
                let ended = block.intersect(&ray.ray, &ray.shear, limit, |hit| {
                    search.offer(Candidate { t: hit.t, id: hit.id, weights: [hit.b1, hit.b2] })
                });
                if ended {
                    return true;
                }
            }
            false
        }
        other => visit_other::<N, S, C>(scene, other, ray, search, counter),
    }
}

/// The leaves that are rare where speed counts most.
#[inline(never)]
fn visit_other<const N: usize, S: Search, C: Counter>(
    scene: Scene<'_>,
    leaf: Child,
    ray: &PreparedRay,
    search: &mut S,
    counter: &mut C,
) -> bool {
    let candidate = match leaf {
        Child::Instance(place) => return visit_instance::<N, S, C>(scene, place, &ray.ray, search, counter),
        Child::Patch(place) => scene.primitives.patch_candidate(place, ray),
        Child::Quadric(place) => scene.primitives.quadric_candidate(place, ray),
        Child::Node(_) | Child::Blocks { .. } => None,
    };
    counter.primitives(1);
    candidate.is_some_and(|candidate| candidate.t <= search.limit() && search.offer(candidate))
}

fn visit_instance<const N: usize, S: Search, C: Counter>(
    scene: Scene<'_>,
    place: u32,
    ray: &Ray,
    search: &mut S,
    counter: &mut C,
) -> bool {
    let placed = &scene.placed[place as usize];
    let Some(root) = scene.groups.get(placed.group as usize).and_then(|tree| tree.root) else {
        return false;
    };
    let Some(local) = PreparedRay::new(&placed.local_ray(ray)) else { return false };
    search.enter_instance(placed.instance);
    let ended = walk::<N, S, C>(scene, root, &local, search, counter);
    search.enter_instance(u32::MAX);
    ended
}
