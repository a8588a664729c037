//! Queries: the nearest hit, and whether there is any.
//!
//! Both run over one of two structures, the eight-wide trees or the brute-force list. What is found on the way is held by a
//! [`Search`], which decides whether to go on: one for the nearest hit, one for any.

mod list;
mod packet;
mod search;
mod stack;
mod stream;
mod wide;

use sahl_math::Ray;

use crate::geometry::triangle::Shear;
use crate::kernel::{BlockRay, NodeRay};
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

/// A ray with what all tests of it need.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PreparedRay {
    pub(crate) block_ray: BlockRay,
    pub(crate) node_ray: NodeRay,
}

impl PreparedRay {
    /// `None` for a ray that hits nothing: see [`can_hit`].
    #[inline(always)]
    pub(crate) fn new(ray: &Ray) -> Option<Self> {
        can_hit(ray).then(|| Self::of_usable(ray))
    }

    /// A ray that [`can_hit`].
    #[inline(always)]
    pub(crate) fn of_usable(ray: &Ray) -> Self {
        // Negative parameters lie behind the origin and never count.
        let ray = &Ray { t_min: at_least_zero(ray.t_min), ..*ray };
        let reciprocal = ray.direction.map(|x| 1.0 / x);
        Self {
            block_ray: BlockRay::with_reciprocal(ray, reciprocal),
            node_ray: NodeRay::with_reciprocal(ray, reciprocal),
        }
    }

    /// See [`limit_of`].
    #[inline(always)]
    pub(crate) fn limit(&self) -> f32 {
        // The number before `t_max`, which is positive, without the branches of `next_down`.
        f32::from_bits(self.ray().t_max.to_bits() - 1)
    }

    #[inline(always)]
    pub(crate) fn ray(&self) -> &Ray {
        &self.block_ray.ray
    }

    #[inline(always)]
    pub(crate) fn shear(&self) -> &Shear {
        &self.block_ray.shear
    }
}

/// Whether a ray may hit anything: it has a direction, is finite, and its interval is not empty.
#[inline(always)]
pub(crate) fn can_hit(ray: &Ray) -> bool {
    // Zero times what is infinite or NaN is NaN: one comparison for all coordinates.
    let sums = ray.origin * 0.0 + ray.direction * 0.0;
    let direction = ray.direction.map(f32::abs);
    (sums.x + sums.y) + sums.z == 0.0
        && (direction.x + direction.y) + direction.z > 0.0
        && at_least_zero(ray.t_min) < ray.t_max
}

/// The number, or zero if it is negative or NaN: one instruction, unlike `max`.
#[inline(always)]
fn at_least_zero(x: f32) -> f32 {
    if x > 0.0 { x } else { 0.0 }
}

/// The largest parameter that counts for a ray: the last before `t_max`.
#[inline(always)]
pub(crate) fn limit_of(ray: &Ray) -> f32 {
    ray.t_max.next_down()
}
