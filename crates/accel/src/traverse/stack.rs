//! What a traversal has still to visit.

use std::hint::select_unpredictable;

use crate::build::MAX_DEPTH;
use crate::kernel::{Interval, Isa, Node, Octant, Order, PreparedRay, Pushed, Row, WIDTH, Window};
use crate::layout::Child;

/// The level that a leaf adds which is the whole of a binary tree, with room to spare.
const LEAF_LEVELS: u32 = 4;

/// Entries that a node may leave pending for each level of the tree.
const PENDING_A_LEVEL: u32 = WIDTH as u32 - 1;

/// A stack large enough for every tree of a world, chosen once: clearing a large one costs as much as a small scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StackSize {
    Small,
    Medium,
    /// Enough for any tree.
    Large,
}

/// The places of each [`StackSize`]: a power of two for what is pending, and the window into which a node writes.
pub(crate) const SMALL: usize = 32 + WIDTH;
pub(crate) const MEDIUM: usize = 128 + WIDTH;
pub(crate) const LARGE: usize = 512 + WIDTH;

const _: () = assert!(StackSize::needed(MAX_DEPTH + LEAF_LEVELS) <= LARGE);

impl StackSize {
    /// The places that a traversal of a tree of this depth in wide nodes may use.
    const fn needed(depth: u32) -> usize {
        // The bottom, what each level leaves pending, and the window into which a node writes.
        (1 + PENDING_A_LEVEL * depth) as usize + WIDTH
    }

    /// The size for trees of at most this depth.
    pub(crate) fn for_depth(depth: u32) -> Self {
        let needed = Self::needed(depth);
        if needed <= SMALL {
            Self::Small
        } else if needed <= MEDIUM {
            Self::Medium
        } else {
            Self::Large
        }
    }
}

/// Pending children, the next to visit on top, each with the parameter at which the ray enters its box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stack<const N: usize> {
    /// The bits of the encoded references.
    children: [f32; N],
    enters: [f32; N],
    height: usize,
}

impl<const N: usize> Stack<N> {
    /// Keeps heights within the stack, where they are anyway, since trees are no deeper than it was chosen for: one instruction instead
    /// of a comparison and a choice.
    const MASK: usize = {
        assert!((N - WIDTH).is_power_of_two());
        N - WIDTH - 1
    };

    /// Nothing to visit.
    #[inline(always)]
    pub(crate) fn empty() -> Self {
        let mut stack = Self { children: [0.0; N], enters: [0.0; N], height: 1 };
        // Always there, at the bottom: whoever pops need not ask whether there is anything left.
        stack.children[0] = f32::from_bits(Child::NOTHING);
        stack.enters[0] = f32::NEG_INFINITY;
        stack
    }

    /// Forgets what is pending.
    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.height = 1;
    }

    /// Takes the topmost reference; [`Child::NOTHING`] at the end, after which the stack must be cleared.
    #[inline(always)]
    pub(crate) fn pop(&mut self) -> u32 {
        self.height = self.height.wrapping_sub(1);
        self.children[self.height & Self::MASK].to_bits()
    }

    /// Pushes the children of a node that the ray meets before `reach`, the nearest last; their parameters, for [`Self::cull`], if `ENTERS`.
    #[inline(always)]
    pub(crate) fn push_children<I: Isa, const ENTERS: bool>(
        &mut self,
        isa: I,
        node: Node<'_>,
        ray: &PreparedRay,
        reach: f32,
    ) {
        let interval = node.interval(isa, ray, reach);
        if let Some(window) = self.window(self.height) {
            self.height +=
                isa.push::<ENTERS>(node.children(), interval, &ray.orientation().order, window).count();
        }
    }

    /// Pushes the children of a node that the ray meets before `reach`, the nearest last, and pops the topmost reference as
    /// [`Self::pop`] does. Parameters are kept, for [`Self::cull`], if `ENTERS`.
    ///
    /// What was just pushed is taken from the node: the next step need not wait until it has gone through memory.
    #[inline(always)]
    pub(crate) fn exchange<I: Isa, const ENTERS: bool>(
        &mut self,
        isa: I,
        node: Node<'_>,
        ray: &PreparedRay,
        reach: f32,
    ) -> u32 {
        let interval = node.interval(isa, ray, reach);
        let height = self.height & Self::MASK;
        let before = self.children[height.wrapping_sub(1) & Self::MASK].to_bits();
        let Some(window) = self.window(height) else { return Child::NOTHING };
        let pushed = isa.push::<ENTERS>(node.children(), interval, &ray.orientation().order, window);
        let last = node.children().0[pushed.last_lane(ray.orientation().octant)].to_bits();
        self.height = (height + pushed.count()).wrapping_sub(1);
        select_unpredictable(pushed == Pushed(0), before, last)
    }

    /// Drops what begins after `reach`.
    ///
    /// Done once a hit: to compare when popping would be a branch that cannot be predicted.
    #[inline(always)]
    pub(crate) fn cull<I: Isa>(&mut self, isa: I, reach: f32) {
        let height = self.height & Self::MASK;
        self.enters[height..height + WIDTH].fill(f32::INFINITY);
        let (mut from, mut kept) = (0, 0);
        while from < height {
            let Some(window) = self.window(from) else { return };
            let (children, enters) = (Row(*window.children), Row(*window.enters));
            let interval = Interval { enter: isa.load(&enters), exit: isa.splat(reach) };
            let Some(window) = self.window(kept) else { return };
            kept += isa.push::<true>(&children, interval, Order::of(Octant::ASCENDING), window).count();
            from += WIDTH;
        }
        self.height = kept;
    }

    #[inline(always)]
    fn window(&mut self, place: usize) -> Option<Window<'_>> {
        let place = place & Self::MASK;
        let children = self.children[place..].first_chunk_mut()?;
        let enters = self.enters[place..].first_chunk_mut()?;
        Some(Window { children, enters })
    }
}
