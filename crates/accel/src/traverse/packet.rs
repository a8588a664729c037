//! Traversal by rays that go nearly the same way, as those of neighbouring pixels do.
//!
//! A packet visits every node that one of its rays may visit, by interval arithmetic on all of them at once: the lowest parameter at
//! which any ray enters a box and the highest at which any leaves it. Only before a leaf is each ray held against the leaf's box, and
//! those that meet it are tested one by one. So a packet finds what its rays find alone, to the last bit.
//!
//! Deliberately absent: packets of rays in different octants, or along an axis. Such rays go their own ways.

use sahl_math::Ray;

use super::stack::{LARGE, MEDIUM, SMALL, StackSize};
use super::stream::Query;
use super::wide::{Scene, Walk, visit_block, visit_other};
use super::{Nearest, NoCount, PreparedRay};
use crate::kernel::{
    BUNDLE_RAYS, Frustum, Isa, Loaded, Node, RayBundle, Task, Tier, TriangleBlock, WIDTH, Window, dispatch,
};
use crate::layout::{Child, Stage, WideTree};

/// Finds the nearest hits of rays of which each [`BUNDLE_RAYS`] in a row go nearly the same way.
#[inline]
pub(crate) fn traverse_packets<Q: Query<Search = Nearest>>(
    scene: Scene<'_>,
    (tier, stack_size): (Tier, StackSize),
    tree: &WideTree,
    rays: &[Ray],
    query: &mut Q,
) {
    let Some(root) = tree.root else { return };
    match stack_size {
        StackSize::Small => dispatch(tier, Packets::<Q, SMALL> { scene, root, rays, query }),
        StackSize::Medium => dispatch(tier, Packets::<Q, MEDIUM> { scene, root, rays, query }),
        StackSize::Large => dispatch(tier, Packets::<Q, LARGE> { scene, root, rays, query }),
    }
}

struct Packets<'a, Q, const N: usize> {
    scene: Scene<'a>,
    root: u32,
    rays: &'a [Ray],
    query: &'a mut Q,
}

impl<Q: Query<Search = Nearest>, const N: usize> Task for Packets<'_, Q, N> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) {
        let Self { scene, root, rays, query } = self;
        let mut bundle = RayBundle::EMPTY;
        let mut stack = PacketStack::<N>::empty();
        for (rays, first) in rays.chunks(BUNDLE_RAYS).zip((0..).step_by(BUNDLE_RAYS)) {
            // One packet an octant; seldom more than one.
            let (mut wanted, mut strays) = (u64::MAX, u64::MAX);
            while wanted != 0 {
                let Some(Loaded { members, others, frustum }) = bundle.load(isa, rays, wanted) else { break };
                (wanted, strays) = (others, strays & !members);
                let mut packet = Packet { scene, rays, bundle: &mut bundle, frustum: &frustum };
                packet.traverse(isa, root, &mut stack);
                for place in places(members) {
                    let nearest = bundle.nearest(place);
                    if nearest.id != u32::MAX {
                        query.finish(first + place, &Nearest::resume(&nearest), false);
                    }
                }
            }
            for place in places(strays).take_while(|&place| place < rays.len()) {
                let Some(ray) = PreparedRay::new(&rays[place]) else { continue };
                let mut search = query.start(ray.limit());
                let (searched, counter) = (&mut search, &mut NoCount);
                let walk = Walk::<_, _, N> { scene, root, ray: &ray, search: searched, counter };
                let ended = walk.run(isa);
                query.finish(first + place, &search, ended);
            }
        }
    }
}

/// The places of a set's bits.
#[inline(always)]
fn places(mut set: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let place = (set != 0).then(|| set.trailing_zeros() as usize % BUNDLE_RAYS)?;
        set &= set - 1;
        Some(place)
    })
}

/// Rays on their common way through a tree.
struct Packet<'a> {
    scene: Scene<'a>,
    rays: &'a [Ray],
    bundle: &'a mut RayBundle,
    frustum: &'a Frustum,
}

/// The cost of testing a block's triangles against one ray, and that of testing one triangle against a group of rays.
const RAY_COST: u32 = 10;
const TRIANGLE_COST: u32 = 4;

impl Packet<'_> {
    /// Visits what any ray may hit.
    #[inline(always)]
    fn traverse<I: Isa, const N: usize>(&mut self, isa: I, root: u32, stack: &mut PacketStack<N>) {
        let mut reach = self.bundle.greatest_reach(isa);
        let mut entry = Entry { child: root, parent: root };
        loop {
            if Child::stage(entry.child) == Stage::Node {
                stack.push_children(isa, self.scene, (entry.child, self.frustum), reach);
            } else if self.visit_leaf::<I, N>(isa, &entry, reach) {
                reach = self.bundle.greatest_reach(isa);
            }
            match stack.pop(reach) {
                Some(next) => entry = next,
                None => return,
            }
        }
    }

    /// Tests the rays that meet a leaf's box; returns whether any of them hit something.
    #[inline(always)]
    fn visit_leaf<I: Isa, const N: usize>(&mut self, isa: I, entry: &Entry, reach: f32) -> bool {
        let node = self.scene.trees.node(Child::row(entry.parent));
        let planes = self.frustum.child_planes(node, lane_of(node, entry.child));
        let (mut meeting, mut groups) = (0, 0);
        for group in 0..BUNDLE_RAYS / I::WIDE {
            let lanes = self.bundle.meet(isa, group, &planes);
            meeting |= u64::from(lanes) << (group * I::WIDE);
            groups += u32::from(lanes != 0);
        }
        if meeting == 0 {
            return false;
        }
        if Child::stage(entry.child) == Stage::Block && self.bundle.has_common_axis() {
            let block = self.scene.trees.block(Child::row(entry.child));
            let triangles = block.candidates(isa, self.frustum, reach);
            if triangles.count_ones() * groups * TRIANGLE_COST <= meeting.count_ones() * RAY_COST {
                return self.test_triangles(isa, block, (triangles, meeting));
            }
        }
        self.test_rays::<I, N>(isa, entry.child, meeting)
    }

    /// Tests a leaf against some rays, one by one.
    #[inline(always)]
    fn test_rays<I: Isa, const N: usize>(&mut self, isa: I, leaf: u32, meeting: u64) -> bool {
        let mut changed = false;
        for place in places(meeting) {
            let Some(ray) = PreparedRay::new(&self.rays[place]) else { continue };
            let mut search = Nearest::resume(&self.bundle.nearest(place));
            let searched = (&mut search, &mut NoCount);
            if Child::stage(leaf) == Stage::Block {
                visit_block(isa, self.scene, leaf, &ray, searched);
            } else {
                visit_other::<I, _, _, N>(isa, self.scene, leaf, &ray, searched);
            }
            self.bundle.set_nearest(place, search.nearest());
            changed = true;
        }
        changed
    }

    /// Tests some triangles of a block against the groups in which rays meet its box.
    #[inline(always)]
    fn test_triangles<I: Isa>(
        &mut self,
        isa: I,
        block: TriangleBlock<'_>,
        (triangles, meeting): (u32, u64),
    ) -> bool {
        let mut changed = false;
        for triangle in places(triangles.into()) {
            let vertices = block.vertices(triangle % WIDTH);
            for group in 0..BUNDLE_RAYS / I::WIDE {
                let lanes = (meeting >> (group * I::WIDE)) as u32 & ((1 << I::WIDE) - 1);
                if lanes != 0 {
                    let named = (block.id(triangle % WIDTH), &vertices);
                    changed |= self.bundle.intersect(isa, (group, lanes), named, self.rays);
                }
            }
        }
        changed
    }
}

/// The lane of a node in which a child stands.
#[inline(always)]
fn lane_of(node: Node<'_>, child: u32) -> usize {
    node.children().0.iter().position(|bits| bits.to_bits() == child).unwrap_or(0)
}

/// What a packet has still to visit.
struct PacketStack<const N: usize> {
    children: [f32; N],
    enters: [f32; N],
    /// The node of which each is a child.
    parents: [u32; N],
    height: usize,
}

struct Entry {
    child: u32,
    parent: u32,
}

impl<const N: usize> PacketStack<N> {
    #[inline(always)]
    fn empty() -> Self {
        Self { children: [0.0; N], enters: [0.0; N], parents: [0; N], height: 0 }
    }

    #[inline(always)]
    fn push_children<I: Isa>(
        &mut self,
        isa: I,
        scene: Scene<'_>,
        (child, frustum): (u32, &Frustum),
        reach: f32,
    ) {
        let node = scene.trees.node(Child::row(child));
        let interval = frustum.interval(isa, node, reach);
        // Trees are no deeper than the stack was chosen for.
        let place = self.height.min(N - WIDTH);
        let children = self.children[place..].first_chunk_mut();
        let (Some(children), Some(enters)) = (children, self.enters[place..].first_chunk_mut()) else {
            return;
        };
        self.height += isa.push(node.children(), interval, frustum.octant, Window { children, enters });
        self.parents[place..place + WIDTH].fill(child);
    }

    /// The topmost entry that begins before `reach`.
    #[inline(always)]
    fn pop(&mut self, reach: f32) -> Option<Entry> {
        loop {
            self.height = self.height.checked_sub(1)?;
            let place = self.height.min(N - 1);
            if self.enters[place] <= reach {
                return Some(Entry { child: self.children[place].to_bits(), parent: self.parents[place] });
            }
        }
    }
}
