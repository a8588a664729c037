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
use super::{Candidate, NoCount, PreparedRay, Search};
use crate::kernel::{
    BUNDLE_GROUPS, BUNDLE_RAYS, Frustum, Isa, Node, RayBundle, Task, Tier, TriangleBlock, WIDTH, Window,
    dispatch,
};
use crate::layout::{Child, Stage, WideTree};

/// Searches a tree for rays of which each [`BUNDLE_RAYS`] in a row go nearly the same way.
#[inline]
pub(crate) fn traverse_packets<Q: Query>(
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

impl<Q: Query, const N: usize> Task for Packets<'_, Q, N> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) {
        let Self { scene, root, rays, query } = self;
        let mut packet = Packet {
            bundle: RayBundle::EMPTY,
            searches: std::array::from_fn(|_| query.start(0.0)),
            met: 0,
            ended: 0,
        };
        let mut stack = PacketStack::<N>::empty();
        for (rays, first) in rays.chunks(BUNDLE_RAYS).zip((0..).step_by(BUNDLE_RAYS)) {
            let (members, frustum) = packet.bundle.load(isa, rays).unzip();
            for (i, ray) in rays.iter().enumerate().filter(|(i, _)| members.unwrap_or(0) >> i & 1 == 0) {
                let Some(ray) = PreparedRay::new(ray) else { continue };
                let mut search = query.start(ray.limit());
                let (searched, counter) = (&mut search, &mut NoCount);
                let walk = Walk::<_, _, N> { scene, root, ray: &ray, search: searched, counter };
                let ended = walk.run(isa);
                query.finish(first + i, &search, ended);
            }
            let Some(frustum) = frustum else { continue };
            (packet.met, packet.ended) = (0, 0);
            packet.traverse(isa, scene, (root, &frustum), (&mut stack, rays, query));
            for place in places(packet.met) {
                query.finish(first + place, &packet.searches[place], packet.ended >> place & 1 == 1);
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

/// The rays of a packet.
struct Packet<S> {
    bundle: RayBundle,
    /// One a ray; of rays that have not met a leaf's box, what is left of others.
    searches: [S; BUNDLE_RAYS],
    /// The rays that have met a leaf's box, one bit each.
    met: u64,
    /// The rays whose search is over.
    ended: u64,
}

/// The cost of testing a block's triangles against one ray, and that of testing one triangle against a group of rays.
const RAY_COST: u32 = 10;
const TRIANGLE_COST: u32 = 6;

impl<S: Search> Packet<S> {
    /// Visits what any ray may hit.
    #[inline(always)]
    fn traverse<I: Isa, Q: Query<Search = S>, const N: usize>(
        &mut self,
        isa: I,
        scene: Scene<'_>,
        (root, frustum): (u32, &Frustum),
        (stack, rays, query): (&mut PacketStack<N>, &[Ray], &Q),
    ) {
        let mut reach = self.bundle.greatest_reach(isa);
        let mut entry = Entry { child: root, parent: root };
        loop {
            if Child::stage(entry.child) == Stage::Node {
                stack.push_children(isa, scene, (entry.child, frustum), reach);
            } else {
                let node = scene.trees.node(Child::row(entry.parent));
                let planes = frustum.child_planes(node, lane_of(node, entry.child));
                if self.visit_leaf::<I, Q, N>(isa, scene, (entry.child, &planes, frustum), (rays, query)) {
                    reach = self.bundle.greatest_reach(isa);
                }
            }
            match stack.pop(reach) {
                Some(next) => entry = next,
                None => return,
            }
        }
    }

    /// Tests the rays that meet a leaf's box; returns whether any of them hit something.
    #[inline(always)]
    fn visit_leaf<I: Isa, Q: Query<Search = S>, const N: usize>(
        &mut self,
        isa: I,
        scene: Scene<'_>,
        (leaf, planes, frustum): (u32, &[[f32; 3]; 2], &Frustum),
        (rays, query): (&[Ray], &Q),
    ) -> bool {
        let (mut meeting, mut groups) = (0, 0);
        for group in 0..BUNDLE_GROUPS {
            let lanes = self.bundle.meet(isa, group, planes);
            meeting |= u64::from(lanes) << (group * WIDTH);
            groups += u32::from(lanes != 0);
        }
        if meeting == 0 {
            return false;
        }
        for place in places(meeting & !self.met) {
            self.searches[place] = query.start(self.bundle.limit(place));
        }
        self.met |= meeting;
        if Child::stage(leaf) == Stage::Block && self.bundle.has_common_axis() {
            let block = scene.trees.block(Child::row(leaf));
            let triangles = block.candidates(isa, frustum, f32::INFINITY);
            if triangles.count_ones() * groups * TRIANGLE_COST < meeting.count_ones() * RAY_COST {
                return self.test_triangles(isa, block, (triangles, meeting), rays);
            }
        }
        let mut changed = false;
        for place in places(meeting) {
            let Some(ray) = PreparedRay::new(&rays[place]) else { continue };
            let search = (&mut self.searches[place], &mut NoCount);
            let ended = if Child::stage(leaf) == Stage::Block {
                visit_block(isa, scene, leaf, &ray, search)
            } else {
                visit_other::<I, _, _, N>(isa, scene, leaf, &ray, search)
            };
            changed |= self.update(place, ended);
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
        rays: &[Ray],
    ) -> bool {
        let mut changed = false;
        for triangle in places(triangles.into()) {
            let (id, vertices) = (block.id(triangle % WIDTH), block.vertices(triangle % WIDTH));
            for group in 0..BUNDLE_GROUPS {
                let lanes = (meeting >> (group * WIDTH)) as u32 & 0xff;
                if lanes == 0 {
                    continue;
                }
                let Some(solved) = self.bundle.solve(isa, group, &vertices) else { continue };
                for lane in places((solved.lanes & lanes).into()) {
                    let place = group * WIDTH + lane % WIDTH;
                    let limit = self.searches[place].limit();
                    let triangle = (id, || vertices);
                    let Some(hit) = solved.hit(lane % WIDTH, &rays[place], limit, triangle) else { continue };
                    let candidate = Candidate { t: hit.t, id: hit.id, weights: [hit.b1, hit.b2] };
                    let ended = self.ended >> place & 1 == 0 && self.searches[place].offer(candidate);
                    changed |= self.update(place, ended);
                }
            }
        }
        changed
    }

    /// Tells the bundle of a ray's new limit; returns whether there is one.
    #[inline(always)]
    fn update(&mut self, place: usize, ended: bool) -> bool {
        let limit = if ended { f32::NEG_INFINITY } else { self.searches[place].limit() };
        self.ended |= u64::from(ended) << place;
        let changed = limit < self.bundle.limit(place);
        if changed {
            self.bundle.set_limit(place, limit);
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
