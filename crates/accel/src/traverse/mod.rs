//! Queries: the nearest hit, and whether there is any.
//!
//! Both run over one of two structures, the eight-wide trees or the brute-force list. What is found on the way is held by a
//! [`Search`], which decides whether to go on: one for the nearest hit, one for any.

mod list;
mod packet;
mod search;
mod stack;
mod stream;
mod waiting;
mod wide;

pub(crate) use crate::kernel::{PreparedRay, limit_of};
pub(crate) use list::{List, ListTree};
pub(crate) use packet::traverse_packets;
pub(crate) use search::{Any, Candidate, Found, Nearest, Search, offer_crossings};
pub(crate) use stack::{Stack, StackSize};
pub(crate) use stream::{Query, traverse_stream};
pub(crate) use wide::{Scene, offer_block, traverse};

/// What a query visited: the cost of a ray, for heat maps and comparisons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TraversalCount {
    /// Nodes whose children's boxes were tested.
    pub nodes: u64,
    /// Primitives that were tested; triangles are tested eight at a time and counted apart.
    pub primitives: u64,
}

/// Where a traversal reports its steps; the one that ignores them costs nothing.
pub(crate) trait Counter {
    fn node(&mut self);
    fn primitives(&mut self, count: impl FnOnce() -> u64);
}

/// Counts nothing.
pub(crate) struct NoCount;

impl Counter for NoCount {
    #[inline(always)]
    fn node(&mut self) {}
    #[inline(always)]
    fn primitives(&mut self, _count: impl FnOnce() -> u64) {}
}

impl Counter for TraversalCount {
    #[inline]
    fn node(&mut self) {
        self.nodes += 1;
    }
    #[inline]
    fn primitives(&mut self, count: impl FnOnce() -> u64) {
        self.primitives += count();
    }
}
