//! Traversal by rays that go nearly the same way, as those of neighbouring pixels do.
//!
//! A packet visits every node that one of its rays may visit, by interval arithmetic on all of them at once: the lowest parameter at
//! which any ray enters a box and the highest at which any leaves it. Only before a leaf is each ray held against the leaf's box, and
//! those that meet it against its triangles: each ray against all of them, or each triangle against groups of rays, whichever is
//! less. The arithmetic is the same either way, and so is the order of visits as that of each ray alone: what a ray hits does not depend on
//! the others.
//!
//! Rays that turn out to have little in common go their own ways, and so do those along an axis.

use std::ops::Range;

use sahl_math::Ray;

use super::stack::{LARGE, MEDIUM, SMALL, StackSize};
use super::stream::{Query, Stream};
use super::wide::{Scene, Walk, visit_block, visit_other};
use super::{Nearest, NoCount, PreparedRay, limit_of};
use crate::kernel::{
    BUNDLE_RAYS, Beam, BeamEdges, BeamVertices, BundledBlock, CrossedPairs, Frustum, Isa, LINE_ROWS, Lanes,
    Loaded, MAX_GROUPS, Machine, Node, Order, RayBundle, Row, Task, TriangleBlock, WIDTH, Window,
};
use crate::layout::{Child, Stage, WideTree};

/// Finds the nearest hits of rays of which each [`BUNDLE_RAYS`] in a row go nearly the same way.
#[inline]
pub(crate) fn traverse_packets<Q: Query<Search = Nearest>>(
    scene: Scene<'_>,
    (machine, stack_size): (Machine, StackSize),
    tree: &WideTree,
    rays: &[Ray],
    query: &mut Q,
) {
    let Some(root) = tree.root else { return query.begin(0..rays.len()) };
    match stack_size {
        StackSize::Small => machine.run(Packets::<Q, SMALL> { scene, root, rays, query }),
        StackSize::Medium => machine.run(Packets::<Q, MEDIUM> { scene, root, rays, query }),
        StackSize::Large => machine.run(Packets::<Q, LARGE> { scene, root, rays, query }),
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
        let mut crossed = CrossedPairs::none(isa);
        let (mut first, mut dissolved) = (0, 0_u32);
        while first < rays.len() {
            let packet = &rays[first..rays.len().min(first + BUNDLE_RAYS)];
            prefetch(isa, &rays[first + packet.len()..]);
            let mut query = Part { query: &mut *query, first };
            let effort = Packets { scene, root, rays: packet, query: &mut query }.search(
                isa,
                &mut bundle,
                (&mut stack, &mut crossed),
            );
            first += packet.len();
            if effort.is_worthwhile() {
                dissolved = dissolved.saturating_sub(1);
            } else {
                let others = &rays[first..rays.len().min(first + (BUNDLE_RAYS << dissolved))];
                dissolved = (dissolved + 1).min(MOST_DISSOLVED);
                query.first = first;
                Stream::<_, N> { scene, root, rays: others, query: &mut query }.run(isa);
                first += others.len();
            }
        }
    }
}

/// Asks for the memory of the next packet.
#[inline(always)]
fn prefetch<I: Isa>(isa: I, rays: &[Ray]) {
    let first: *const Row = rays.as_ptr().cast();
    for row in (0..BUNDLE_RAYS * size_of::<Ray>() / size_of::<Row>()).step_by(LINE_ROWS) {
        isa.prefetch(first.wrapping_add(row));
    }
}

/// Nodes and leaves that are soon visited, whatever the rays share.
const FEW_VISITS: u32 = 96;

/// A packet that visits more nodes and leaves is dissolved.
const MOST_VISITS: u32 = 1024;

/// So many rays go their own ways after a packet that was not worthwhile.
const MOST_DISSOLVED: u32 = 3;

/// What a packet has visited.
#[derive(Clone, Copy, Default)]
struct Effort {
    visits: u32,
    leaves: u32,
    /// How many rays met the leaves' boxes, all together.
    meetings: u32,
}

impl Effort {
    /// Whether the rays would not have been faster alone: short ways always are, long ones if some rays share them to the leaves.
    fn is_worthwhile(self) -> bool {
        self.visits <= FEW_VISITS || self.visits <= MOST_VISITS && self.meetings >= 2 * self.leaves
    }

    fn max(self, other: Self) -> Self {
        if self.visits < other.visits { other } else { self }
    }
}

/// A query for a part of the rays.
struct Part<'a, Q> {
    query: &'a mut Q,
    /// The place of the part's first ray.
    first: usize,
}

impl<Q: Query> Query for Part<'_, Q> {
    type Search = Q::Search;

    #[inline(always)]
    fn begin(&mut self, places: Range<usize>) {
        self.query.begin(self.first + places.start..self.first + places.end);
    }

    #[inline(always)]
    fn start(&self, place: usize, limit: f32) -> Q::Search {
        self.query.start(self.first + place, limit)
    }

    #[inline(always)]
    fn finish(&mut self, place: usize, search: &Q::Search, ended: bool) {
        self.query.finish(self.first + place, search, ended);
    }
}

impl<Q: Query<Search = Nearest>, const N: usize> Packets<'_, Q, N> {
    /// Finds the nearest hits of up to [`BUNDLE_RAYS`] rays; returns what the packet that saw most has visited.
    #[inline(always)]
    fn search<I: Isa>(
        self,
        isa: I,
        bundle: &mut RayBundle,
        (stack, crossed): (&mut PacketStack<N>, &mut CrossedPairs<I::Wide>),
    ) -> Effort {
        let Self { scene, root, rays, query } = self;
        query.begin(0..rays.len());
        let mut most = Effort::default();
        // One packet an octant; seldom more than one.
        let (mut wanted, mut strays) = (u64::MAX, u64::MAX);
        while wanted != 0 {
            let Some(Loaded { members, others, frustum, beam }) = bundle.load(isa, rays, wanted) else {
                break;
            };
            wanted = others;
            let (bundle, crossed) = (&mut *bundle, &mut *crossed);
            let packet = Packet { scene, rays, bundle, frustum: &frustum, beam: &beam, crossed };
            let effort = packet.traverse(isa, root, stack);
            most = most.max(effort);
            if effort.visits > MOST_VISITS {
                continue;
            }
            strays &= !members;
            for place in places(members) {
                let nearest = bundle.nearest(place);
                if nearest.id != u32::MAX {
                    query.finish(place, &Nearest::resume(&nearest), false);
                }
            }
        }
        for place in places(strays).take_while(|&place| place < rays.len()) {
            let ray = &rays[place];
            let mut search = query.start(place, limit_of(ray));
            let (searched, counter) = (&mut search, &mut NoCount);
            let ended = Walk::<_, _, N> { scene, root, ray, search: searched, counter }.run(isa);
            query.finish(place, &search, ended);
        }
        most
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
struct Packet<'a, F> {
    scene: Scene<'a>,
    rays: &'a [Ray],
    bundle: &'a mut RayBundle,
    frustum: &'a Frustum,
    beam: &'a Option<Beam>,
    crossed: &'a mut CrossedPairs<F>,
}

/// The cost of testing a block's triangles against one ray, and that of testing one triangle against a group of rays.
const RAY_COST: u32 = 5;
const TRIANGLE_COST: u32 = 1;

impl<F: Lanes> Packet<'_, F> {
    /// Visits what any ray may hit; returns what that was.
    ///
    /// Gives up after [`MOST_VISITS`].
    #[inline(always)]
    fn traverse<I: Isa<Wide = F>, const N: usize>(
        mut self,
        isa: I,
        root: u32,
        stack: &mut PacketStack<N>,
    ) -> Effort {
        stack.clear();
        let mut effort = Effort::default();
        let mut reach = self.bundle.greatest_reach(isa);
        let mut entry = Entry { child: root, parent: root };
        while effort.visits <= MOST_VISITS {
            effort.visits += 1;
            if Child::stage(entry.child) == Stage::Node {
                stack.push_children(isa, self.scene, (entry.child, self.frustum), reach);
            } else if self.visit_leaf::<I, N>(isa, &entry, &mut effort) {
                reach = self.bundle.greatest_reach(isa);
            }
            match stack.pop(reach) {
                Some(next) => entry = next,
                None => break,
            }
        }
        effort
    }

    /// Tests the rays that meet a leaf's box; returns whether any of them hit something.
    #[inline(always)]
    fn visit_leaf<I: Isa<Wide = F>, const N: usize>(
        &mut self,
        isa: I,
        entry: &Entry,
        effort: &mut Effort,
    ) -> bool {
        let node = self.scene.trees.node(entry.parent);
        let planes = self.frustum.child_planes(node, lane_of(node, entry.child));
        let mut meeting = 0;
        for group in 0..BUNDLE_RAYS / I::WIDE {
            let lanes = self.bundle.meet(isa, group, &planes);
            meeting |= u64::from(lanes) << (group * I::WIDE);
        }
        effort.leaves += 1;
        effort.meetings += meeting.count_ones();
        if meeting == 0 {
            return false;
        }
        if Child::stage(entry.child) == Stage::Block && self.bundle.has_common_axis() {
            let block = self.scene.trees.block(entry.child);
            let (candidates, vertices) = self.candidates(isa, block, meeting);
            let tests: u32 = candidates.iter().map(|triangles| triangles.count_ones()).sum();
            if tests * TRIANGLE_COST <= meeting.count_ones() * RAY_COST {
                let block = BundledBlock { block, vertices: &vertices };
                return self.test_triangles(isa, block, (&candidates, meeting));
            }
        }
        self.test_rays::<I, N>(isa, entry.child, meeting)
    }

    /// Tests a leaf against some rays, one by one.
    #[inline(always)]
    fn test_rays<I: Isa<Wide = F>, const N: usize>(&mut self, isa: I, leaf: u32, meeting: u64) -> bool {
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

    /// The triangles of a block that rays of each group may hit, one bit each, and their vertices as the rays of a beam see them.
    #[inline(always)]
    fn candidates<I: Isa<Wide = F>>(&self, isa: I, block: TriangleBlock<'_>, meeting: u64) -> Candidates<I> {
        let mut candidates = [0; MAX_GROUPS];
        let groups = candidates.iter_mut().take(BUNDLE_RAYS / I::WIDE).enumerate();
        let groups = groups.filter(|&(group, _)| lanes_of::<I>(meeting, group) != 0);
        let Some(beam) = self.beam else {
            let all = block.all(isa);
            groups.for_each(|(_, triangles)| *triangles = all);
            return (candidates, None);
        };
        let edges = BeamEdges::new(isa, block, beam);
        for (group, triangles) in groups {
            *triangles = edges.may_hit(isa, beam, group);
        }
        (candidates, Some(edges.vertices()))
    }

    /// Tests some triangles of a block against each group.
    #[inline(always)]
    fn test_triangles<I: Isa<Wide = F>>(
        &mut self,
        isa: I,
        block: BundledBlock<'_, I>,
        (candidates, meeting): (&[u32; MAX_GROUPS], u64),
    ) -> bool {
        let mut pairs = 0_u64;
        for (group, &triangles) in candidates.iter().take(BUNDLE_RAYS / I::WIDE).enumerate() {
            pairs |= u64::from(triangles) << (group * WIDTH);
        }
        self.crossed.clear();
        for pair in places(pairs) {
            let (group, triangle) = (pair / WIDTH, pair % WIDTH);
            let rays = (group, lanes_of::<I>(meeting, group));
            self.bundle.cross(isa, rays, (block, triangle), self.crossed);
        }
        self.bundle.intersect(isa, (block, self.crossed), self.rays)
    }
}

/// One set of triangles a group, and the vertices of all.
type Candidates<I> = ([u32; MAX_GROUPS], Option<BeamVertices<<<I as Isa>::F32 as Lanes>::Array>>);

/// A group's part of a set of rays.
#[inline(always)]
fn lanes_of<I: Isa>(rays: u64, group: usize) -> u32 {
    (rays >> (group * I::WIDE)) as u32 & ((1 << I::WIDE) - 1)
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
    fn clear(&mut self) {
        self.height = 0;
    }

    #[inline(always)]
    fn push_children<I: Isa>(
        &mut self,
        isa: I,
        scene: Scene<'_>,
        (child, frustum): (u32, &Frustum),
        reach: f32,
    ) {
        let node = scene.trees.node(child);
        let interval = frustum.interval(isa, node, reach);
        // Trees are no deeper than the stack was chosen for.
        let place = self.height.min(N - WIDTH);
        let children = self.children[place..].first_chunk_mut();
        let (Some(children), Some(enters)) = (children, self.enters[place..].first_chunk_mut()) else {
            return;
        };
        let window = Window { children, enters };
        let pushed = isa.push::<true>(node.children(), interval, Order::of(frustum.octant), window).count();
        self.parents[place..place + WIDTH].fill(child);
        self.height += pushed;
        for entry in &self.children[place..(place + pushed).min(N)] {
            scene.trees.prefetch(isa, entry.to_bits());
        }
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
