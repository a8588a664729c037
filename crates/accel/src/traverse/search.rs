//! What a query looks for.

use super::PreparedRay;
use crate::kernel::{BlockHit, NearestHit};

/// A hit on its way to becoming the result.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    pub(crate) t: f32,
    /// The primitive.
    pub(crate) id: u32,
    /// Triangles and halves of patches: barycentric weights; curved patches: (u, v); quadrics: unused.
    pub(crate) weights: [f32; 2],
}

impl From<BlockHit> for Candidate {
    #[inline(always)]
    fn from(BlockHit { t, b1, b2, id }: BlockHit) -> Self {
        Self { t, id, weights: [b1, b2] }
    }
}

/// A candidate with the instance in which it was found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    pub(crate) candidate: Candidate,
    pub(crate) instance: u32,
}

/// Takes candidates in any order.
pub(crate) trait Search {
    /// Whether hits draw the limit nearer.
    const NARROWS: bool;
    /// Whether it may reject candidates that it wants: the same primitive may then be hit further on.
    const REJECTS: bool = false;

    /// The largest parameter that still counts.
    fn limit(&self) -> f32;
    /// Whether a candidate at or before the limit would be taken.
    fn wants(&self, candidate: &Candidate) -> bool;
    /// Takes a candidate at or before the limit; returns whether the search is over.
    fn offer(&mut self, candidate: Candidate) -> bool;
    /// Says in which instance the next candidates lie.
    fn enter_instance(&mut self, instance: u32);
}

/// Keeps the nearest hit; of equally near ones that with the lowest (instance, primitive).
pub(crate) struct Nearest {
    limit: f32,
    found: Found,
    instance: u32,
}

impl Nearest {
    #[inline]
    pub(crate) fn new(limit: f32) -> Self {
        // Sorts behind every hit, so that the first one at the limit itself is taken.
        let none = Candidate { t: limit, id: u32::MAX, weights: [0.0; 2] };
        Self { limit, found: Found { candidate: none, instance: u32::MAX }, instance: u32::MAX }
    }

    /// Goes on from what was found before.
    #[inline]
    pub(crate) fn resume(hit: &NearestHit) -> Self {
        let candidate = Candidate { t: hit.t, id: hit.id, weights: hit.weights };
        Self { limit: hit.t, found: Found { candidate, instance: hit.instance }, instance: u32::MAX }
    }

    /// What is found so far.
    #[inline]
    pub(crate) fn nearest(&self) -> NearestHit {
        let Found { candidate: Candidate { t, id, weights }, instance } = self.found;
        NearestHit { t, id, instance, weights }
    }

    #[inline]
    pub(crate) fn result(&self) -> Option<Found> {
        (self.found.candidate.id != u32::MAX).then_some(self.found)
    }
}

impl Search for Nearest {
    const NARROWS: bool = true;

    #[inline(always)]
    fn limit(&self) -> f32 {
        self.limit
    }

    #[inline(always)]
    fn wants(&self, candidate: &Candidate) -> bool {
        let before = &self.found;
        candidate.t < before.candidate.t
            || (candidate.t == before.candidate.t
                && (self.instance, candidate.id) < (before.instance, before.candidate.id))
    }

    #[inline(always)]
    fn offer(&mut self, candidate: Candidate) -> bool {
        if self.wants(&candidate) {
            self.found = Found { candidate, instance: self.instance };
            self.limit = candidate.t;
        }
        false
    }

    #[inline(always)]
    fn enter_instance(&mut self, instance: u32) {
        self.instance = instance;
    }
}

/// Ends at the first hit.
pub(crate) struct Any {
    pub(crate) limit: f32,
}

impl Search for Any {
    const NARROWS: bool = false;

    #[inline(always)]
    fn limit(&self) -> f32 {
        self.limit
    }

    #[inline(always)]
    fn wants(&self, _candidate: &Candidate) -> bool {
        true
    }

    #[inline(always)]
    fn offer(&mut self, _candidate: Candidate) -> bool {
        true
    }

    #[inline(always)]
    fn enter_instance(&mut self, _instance: u32) {}
}

/// Offers the crossings of a ray and a primitive, the nearest of which, up to a limit, `nearest` gives: only this one, unless the search may reject it.
#[inline(always)]
pub(crate) fn offer_crossings<S: Search>(
    search: &mut S,
    ray: &PreparedRay,
    nearest: impl Fn(&PreparedRay, f32) -> Option<Candidate>,
) -> bool {
    if S::REJECTS {
        return offer_all_crossings(search, *ray, nearest);
    }
    let limit = search.limit();
    nearest(ray, limit).is_some_and(|candidate| candidate.t <= limit && search.offer(candidate))
}

/// Offers the crossings one after the other: the parameter ascends, and there are few.
fn offer_all_crossings<S: Search>(
    search: &mut S,
    mut ray: PreparedRay,
    nearest: impl Fn(&PreparedRay, f32) -> Option<Candidate>,
) -> bool {
    while let Some(candidate) = nearest(&ray, search.limit()).filter(|hit| hit.t <= search.limit()) {
        if search.offer(candidate) {
            return true;
        }
        ray = ray.after(candidate.t);
    }
    false
}
