//! Traversal by many rays that have nothing to do with each other.
//!
//! One ray's way through a tree is a chain: where it goes next is known only when the last box test has come out of the
//! pipeline, and half of the branches cannot be predicted. So some rays are kept in flight. Those that stand
//! before a node wait in one queue and those before a leaf in another: each loop does one thing, without asking which,
//! and the processor works on several rays at once. The memory of a ray's next node is asked for when the ray joins a queue. Of the rays
//! before blocks it is first found for all whether their lines pass through a triangle. What a loop works on is known a loop before, and a
//! stack is read when the next ray has been worked on, so that nothing waits for what was done last. Rays are prepared eight at a time.

use std::ops::Range;

use sahl_math::Ray;

use super::stack::{LARGE, MEDIUM, SMALL, Stack, StackSize};
use super::waiting::{SlotSet, Waiting};
use super::wide::{Scene, visit_other};
use super::{NoCount, PreparedRay, Search};
use crate::kernel::{Crossed, EXIT_WIDENING, Isa, Machine, PreparedEight, Task, WIDTH};
use crate::layout::{Child, Stage, WideTree};

/// Rays in flight: a power of two.
pub(super) const SLOTS: usize = 32;

/// What a query is asked of each ray of a slice.
pub(crate) trait Query {
    type Search: Search;
    /// Says that the rays at some places of the slice are searched next. Until they are finished they have hit nothing.
    fn begin(&mut self, places: Range<usize>);
    /// Starts the search of the ray at a place of the slice up to the largest parameter that counts.
    fn start(&self, place: usize, limit: f32) -> Self::Search;
    /// Takes the result for the ray at a place of the slice. Rays that can hit nothing have none.
    fn finish(&mut self, place: usize, search: &Self::Search, ended: bool);
}

/// Searches a tree for many rays.
#[inline]
pub(crate) fn traverse_stream<Q: Query>(
    scene: Scene<'_>,
    (machine, stack_size): (Machine, StackSize),
    tree: &WideTree,
    rays: &[Ray],
    query: &mut Q,
) {
    let Some(root) = tree.root else { return query.begin(0..rays.len()) };
    match stack_size {
        StackSize::Small => machine.run(Stream::<Q, SMALL> { scene, root, rays, query }),
        StackSize::Medium => machine.run(Stream::<Q, MEDIUM> { scene, root, rays, query }),
        StackSize::Large => machine.run(Stream::<Q, LARGE> { scene, root, rays, query }),
    }
}

/// Many rays on their ways through a tree, with stacks of `N` places.
pub(super) struct Stream<'a, Q, const N: usize> {
    pub(super) scene: Scene<'a>,
    pub(super) root: u32,
    pub(super) rays: &'a [Ray],
    pub(super) query: &'a mut Q,
}

/// A ray in flight.
struct Slot<S, const N: usize> {
    ray: PreparedRay,
    /// What its line passes through in the block against which it was held last: read when other rays' nodes have been tested.
    crossed: Crossed,
    search: S,
    stack: Stack<N>,
    /// [`EXIT_WIDENING`] times the limit of the search.
    reach: f32,
    /// The next to visit.
    child: u32,
    /// The place of the ray in the slice.
    place: usize,
    ended: bool,
}

impl<Q: Query, const N: usize> Task for Stream<'_, Q, N> {
    type Output = ();

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) {
        let Self { scene, root, rays, query } = self;
        query.begin(0..rays.len());
        let mut supply = Supply::new(isa, rays);
        // Filled for as many rays as there are. Reached through references, because to ask each in its memory whether it is there is one
        // more load a step.
        let mut memory: [Option<Slot<Q::Search, N>>; SLOTS] = [const { None }; SLOTS];
        let slots: &mut Slots<'_, Q::Search, N> = &mut [const { None }; SLOTS];
        let mut loops = Loops { scene, waiting: Waiting::default() };
        for (place, (slot, memory)) in slots.iter_mut().zip(&mut memory).enumerate() {
            if let Some(ray) = supply.next(isa) {
                *slot = Some(memory.insert(Slot::new(ray, query, root)));
                loops.waiting.join(root, place);
            }
        }
        // Each set is taken a loop before the one that works on it: the processor need not wait for the last of a loop to know the next.
        let mut blocks = loops.waiting.take_blocks();
        while loops.waiting != Waiting::default() || blocks != SlotSet::default() {
            let nodes = loops.waiting.take_nodes();
            let crossed = loops.cross_blocks(isa, slots, blocks);
            loops.test_nodes(isa, slots, nodes);
            let rare = loops.waiting.take_rare();
            for place in blocks.without(crossed) {
                loops.go_on(isa, slots, place);
            }
            loops.intersect_blocks(isa, slots, crossed);
            blocks = loops.waiting.take_blocks();
            for place in rare {
                let Some(slot) = &mut slots[place] else { continue };
                if Child::stage(slot.child) == Stage::Other {
                    slot.test_other(isa, scene);
                    loops.go_on(isa, slots, place);
                    continue;
                }
                query.finish(slot.place, &slot.search, slot.ended);
                if let Some((ray_place, ray)) = supply.next(isa) {
                    isa.prefetch(rays.as_ptr().wrapping_add(ray_place + SLOTS).cast());
                    slot.restart((ray_place, ray), query, root);
                    loops.waiting.join(root, place);
                }
            }
        }
    }
}

/// The rays in flight.
type Slots<'a, S, const N: usize> = [Option<&'a mut Slot<S, N>>; SLOTS];

/// What the loops over slots share. Apart from the slots, so that it stays in registers.
struct Loops<'a> {
    scene: Scene<'a>,
    waiting: Waiting,
}

impl Loops<'_> {
    /// Finds for rays before blocks whether their lines pass through a triangle; returns those that do.
    ///
    /// First for all: a branch on it cannot be predicted, and would make the processor wait for each.
    #[inline(always)]
    fn cross_blocks<I: Isa, S: Search, const N: usize>(
        &self,
        isa: I,
        slots: &mut Slots<'_, S, N>,
        blocks: SlotSet,
    ) -> SlotSet {
        let mut crossed = SlotSet::default();
        for place in blocks {
            let Some(slot) = &mut slots[place] else { continue };
            crossed.insert_if(slot.cross_block(isa, self.scene), place);
        }
        crossed
    }

    /// Tests the triangles of blocks through which their rays' lines pass.
    #[inline(always)]
    fn intersect_blocks<I: Isa, S: Search, const N: usize>(
        &mut self,
        isa: I,
        slots: &mut Slots<'_, S, N>,
        crossed: SlotSet,
    ) {
        for place in crossed {
            if let Some(slot) = &mut slots[place] {
                slot.intersect_block(isa, self.scene);
            }
            self.go_on(isa, slots, place);
        }
    }

    /// Tests the nodes before which rays wait.
    ///
    /// What comes next is taken from a stack when another ray's node has been tested: by then what was pushed has gone through memory.
    #[inline(always)]
    fn test_nodes<I: Isa, S: Search, const N: usize>(
        &mut self,
        isa: I,
        slots: &mut Slots<'_, S, N>,
        nodes: SlotSet,
    ) {
        let mut tested = None;
        for place in nodes {
            if let Some(slot) = &mut slots[place] {
                slot.test_node(isa, self.scene);
            }
            if let Some(before) = tested.replace(place) {
                self.go_on(isa, slots, before);
            }
        }
        if let Some(last) = tested {
            self.go_on(isa, slots, last);
        }
    }

    /// Lets a ray wait for what is on top of its stack.
    #[inline(always)]
    fn go_on<I: Isa, S: Search, const N: usize>(
        &mut self,
        isa: I,
        slots: &mut Slots<'_, S, N>,
        place: usize,
    ) {
        if let Some(slot) = &mut slots[place] {
            self.waiting.join(slot.go_on(isa, self.scene), place);
        }
    }
}

/// Rays on their way into the slots, prepared eight at a time.
struct Supply<'a> {
    prepared: PreparedEight,
    /// The place of the first of the prepared rays in the slice.
    first: usize,
    /// The prepared ones and those after them.
    rays: &'a [Ray],
}

impl<'a> Supply<'a> {
    #[inline(always)]
    fn new<I: Isa>(isa: I, rays: &'a [Ray]) -> Self {
        let mut prepared = PreparedEight::NONE;
        prepared.prepare(isa, rays);
        Self { prepared, first: 0, rays }
    }

    /// The next ray that can hit anything, with its place.
    #[inline(always)]
    fn next<I: Isa>(&mut self, isa: I) -> Option<(usize, &PreparedRay)> {
        while self.prepared.is_empty() {
            self.rays = self.rays.get(WIDTH..).filter(|rays| !rays.is_empty())?;
            self.first += WIDTH;
            self.prepared.prepare(isa, self.rays);
        }
        let (place, ray) = self.prepared.next()?;
        Some((self.first + place, ray))
    }
}

impl<S: Search, const N: usize> Slot<S, N> {
    #[inline(always)]
    fn new<Q: Query<Search = S>>((place, ray): (usize, &PreparedRay), query: &Q, root: u32) -> Self {
        let search = query.start(place, ray.limit());
        let reach = search.limit() * EXIT_WIDENING;
        Self {
            ray: *ray,
            crossed: Crossed::NONE,
            search,
            stack: Stack::empty(),
            reach,
            child: root,
            place,
            ended: false,
        }
    }

    /// As [`Self::new`], without clearing the memory of the stack.
    #[inline(always)]
    fn restart<Q: Query<Search = S>>(&mut self, (place, ray): (usize, &PreparedRay), query: &Q, root: u32) {
        self.ray = *ray;
        self.search = query.start(place, self.ray.limit());
        self.reach = self.search.limit() * EXIT_WIDENING;
        self.stack.clear();
        self.child = root;
        self.place = place;
        self.ended = false;
    }

    /// Tests the boxes of a node.
    #[inline(always)]
    fn test_node<I: Isa>(&mut self, isa: I, scene: Scene<'_>) {
        let node = scene.trees.node(self.child);
        if S::NARROWS {
            self.stack.push_children::<I, true>(isa, node, &self.ray, self.reach);
        } else {
            self.stack.push_children::<I, false>(isa, node, &self.ray, self.reach);
        }
    }

    /// Finds the triangles of a block through which the ray's line passes; returns whether there are any.
    #[inline(always)]
    fn cross_block<I: Isa>(&mut self, isa: I, scene: Scene<'_>) -> bool {
        scene.trees.block(self.child).cross(isa, &self.ray, &mut self.crossed)
    }

    /// Tests the triangles through which the ray's line passes.
    #[inline(always)]
    fn intersect_block<I: Isa>(&mut self, isa: I, scene: Scene<'_>) {
        let block = scene.trees.block(self.child);
        let crossed = (&self.crossed, self.search.limit());
        let ended = block.intersect_crossed(isa, &self.ray, crossed, |hit| self.search.offer(hit.into()));
        self.after_leaf(isa, ended);
    }

    /// Tests a primitive that is not a triangle.
    #[inline(always)]
    fn test_other<I: Isa>(&mut self, isa: I, scene: Scene<'_>) {
        let search = (&mut self.search, &mut NoCount);
        let ended = visit_other::<I, _, _, N>(isa, scene, self.child, &self.ray, search);
        self.after_leaf(isa, ended);
    }

    /// Drops what a leaf has made superfluous.
    #[inline(always)]
    fn after_leaf<I: Isa>(&mut self, isa: I, ended: bool) {
        if ended {
            self.ended = true;
            self.stack.clear();
        } else if S::NARROWS {
            let reach = self.search.limit() * EXIT_WIDENING;
            if reach < self.reach {
                self.reach = reach;
                self.stack.cull(isa, reach);
            }
        }
    }

    /// Takes what is to be visited next from the stack, asks for its memory and returns it.
    #[inline(always)]
    fn go_on<I: Isa>(&mut self, isa: I, scene: Scene<'_>) -> u32 {
        self.child = self.stack.pop();
        scene.trees.prefetch(isa, self.child);
        self.child
    }
}
