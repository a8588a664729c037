//! Queries that ask about what they find: a candidate that is rejected is as if it were not there.
//!
//! Only geometry that the world names in [`crate::World::filtered`] is asked about. The filter is a type parameter, so that queries
//! without one are compiled as if there were none, and those with one call it directly.
//!
//! Deliberately absent: filtered twins of [`Accel::intersect_coherent`]. What packets save is the work that their rays have in common, and
//! a filter is asked for each ray alone; the batches here answer the same rays with the same hits.
//!
//! This is what surfaces with holes need, leaves cut out by an image for instance: the renderer's filter looks the hole up.

use std::ops::Range;

use sahl_math::Ray;

use crate::accel::Accel;
use crate::hit::Hit;
use crate::traverse::{Any, Candidate, Found, Nearest, NoCount, Query, Search, limit_of, traverse_stream};

/// The geometries that filters are asked about.
#[derive(Clone, Debug, Default)]
pub(crate) struct Filtered {
    /// The least range of ids that holds all of theirs.
    ids: Range<u32>,
    /// Which they are, one for each geometry.
    geometries: Vec<bool>,
}

impl Filtered {
    /// Those named in `filtered`, which have the ids that `ids` tells. Geometries that do not exist are left out.
    pub(crate) fn new(filtered: &[u32], geometries: usize, ids: impl Fn(u32) -> Range<u32>) -> Self {
        let mut marked = Self::default();
        for &geometry in filtered.iter().filter(|geometry| (**geometry as usize) < geometries) {
            marked.geometries.resize(geometries, false);
            marked.geometries[geometry as usize] = true;
            let (all, own) = (marked.ids, ids(geometry));
            marked.ids = if all.is_empty() { own } else { all.start.min(own.start)..all.end.max(own.end) };
        }
        marked
    }

    fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }
}

/// A search that asks a filter.
pub(crate) struct Asking<'a, S, F> {
    search: S,
    accel: &'a Accel,
    ray: &'a Ray,
    place: usize,
    filter: &'a F,
    instance: u32,
}

impl<S: Search, F: Fn(usize, &Hit) -> bool> Asking<'_, S, F> {
    /// Whether a candidate may count; opaque geometry is known by its id most often.
    #[inline]
    fn accepts(&self, candidate: Candidate) -> bool {
        let filtered = &self.accel.filtered;
        !filtered.ids.contains(&candidate.id) || self.asks(candidate)
    }

    fn asks(&self, candidate: Candidate) -> bool {
        let hit = self.accel.to_hit(self.ray, &Found { candidate, instance: self.instance });
        let filtered = &self.accel.filtered.geometries;
        !filtered.get(hit.geometry as usize).is_some_and(|&is| is) || (self.filter)(self.place, &hit)
    }
}

impl<S: Search, F: Fn(usize, &Hit) -> bool> Search for Asking<'_, S, F> {
    const NARROWS: bool = S::NARROWS;
    const REJECTS: bool = true;

    #[inline(always)]
    fn limit(&self) -> f32 {
        self.search.limit()
    }

    #[inline(always)]
    fn wants(&self, candidate: &Candidate) -> bool {
        self.search.wants(candidate)
    }

    #[inline(always)]
    fn offer(&mut self, candidate: Candidate) -> bool {
        self.search.wants(&candidate) && self.accepts(candidate) && self.search.offer(candidate)
    }

    #[inline(always)]
    fn enter_instance(&mut self, instance: u32) {
        self.instance = instance;
        self.search.enter_instance(instance);
    }
}

impl Accel {
    /// [`Self::intersect`] for the world without what a filter rejects.
    ///
    /// The filter is asked only about geometries in [`crate::World::filtered`], and answers whether a hit counts; it must give the same
    /// answer whenever it is asked about the same hit. It may be asked about hits in any order, about one more than once, and about such
    /// as do not turn out to be the nearest. Where a ray meets a curved shape twice, it is asked about both.
    pub fn intersect_filtered(&self, ray: &Ray, filter: impl Fn(&Hit) -> bool) -> Option<Hit> {
        if self.filtered.is_empty() {
            return self.intersect(ray);
        }
        let filter = |_: usize, hit: &Hit| filter(hit);
        let mut asking = self.asking(Nearest::new(limit_of(ray)), (0, ray), &filter);
        self.search(ray, &mut asking, &mut NoCount);
        asking.search.result().map(|found| self.to_hit(ray, &found))
    }

    /// [`Self::occluded`] for the world without what a filter rejects; the filter is that of [`Self::intersect_filtered`].
    pub fn occluded_filtered(&self, ray: &Ray, filter: impl Fn(&Hit) -> bool) -> bool {
        if self.filtered.is_empty() {
            return self.occluded(ray);
        }
        let filter = |_: usize, hit: &Hit| filter(hit);
        let mut asking = self.asking(Any { limit: limit_of(ray) }, (0, ray), &filter);
        self.search(ray, &mut asking, &mut NoCount)
    }

    /// [`Self::intersect_batch`] for the world without what a filter rejects; the filter is that of [`Self::intersect_filtered`], and is
    /// told the place of the ray as well.
    pub fn intersect_batch_filtered(
        &self,
        rays: &[Ray],
        hits: &mut [Option<Hit>],
        filter: impl Fn(usize, &Hit) -> bool,
    ) {
        if self.filtered.is_empty() {
            return self.intersect_batch(rays, hits);
        }
        let count = hits.len().min(rays.len());
        let filter = &filter;
        self.answer(&rays[..count], traverse_stream, &mut FilteredHits { accel: self, rays, filter, hits });
    }

    /// [`Self::occluded_batch`] for the world without what a filter rejects; the filter is that of [`Self::intersect_batch_filtered`].
    pub fn occluded_batch_filtered(
        &self,
        rays: &[Ray],
        occluded: &mut [bool],
        filter: impl Fn(usize, &Hit) -> bool,
    ) {
        if self.filtered.is_empty() {
            return self.occluded_batch(rays, occluded);
        }
        let count = occluded.len().min(rays.len());
        let filter = &filter;
        let mut query = FilteredOcclusions { accel: self, rays, filter, occluded };
        self.answer(&rays[..count], traverse_stream, &mut query);
    }

    fn asking<'a, S: Search, F>(
        &'a self,
        search: S,
        (place, ray): (usize, &'a Ray),
        filter: &'a F,
    ) -> Asking<'a, S, F> {
        Asking { search, accel: self, ray, place, filter, instance: Hit::NO_INSTANCE }
    }
}

/// The nearest hits of a slice of rays that a filter lets through.
struct FilteredHits<'a, F> {
    accel: &'a Accel,
    rays: &'a [Ray],
    filter: &'a F,
    hits: &'a mut [Option<Hit>],
}

impl<'a, F: Fn(usize, &Hit) -> bool> Query for FilteredHits<'a, F> {
    type Search = Asking<'a, Nearest, F>;

    #[inline(always)]
    fn begin(&mut self, places: Range<usize>) {
        self.hits[places].fill(None);
    }

    #[inline(always)]
    fn start(&self, place: usize, limit: f32) -> Self::Search {
        self.accel.asking(Nearest::new(limit), (place, &self.rays[place]), self.filter)
    }

    #[inline(always)]
    fn finish(&mut self, place: usize, asking: &Self::Search, _ended: bool) {
        let found = asking.search.result();
        self.hits[place] = found.map(|found| self.accel.to_hit(&self.rays[place], &found));
    }
}

/// Whether anything that a filter lets through lies on each ray of a slice.
struct FilteredOcclusions<'a, F> {
    accel: &'a Accel,
    rays: &'a [Ray],
    filter: &'a F,
    occluded: &'a mut [bool],
}

impl<'a, F: Fn(usize, &Hit) -> bool> Query for FilteredOcclusions<'a, F> {
    type Search = Asking<'a, Any, F>;

    #[inline(always)]
    fn begin(&mut self, places: Range<usize>) {
        self.occluded[places].fill(false);
    }

    #[inline(always)]
    fn start(&self, place: usize, limit: f32) -> Self::Search {
        self.accel.asking(Any { limit }, (place, &self.rays[place]), self.filter)
    }

    #[inline(always)]
    fn finish(&mut self, place: usize, _asking: &Self::Search, ended: bool) {
        self.occluded[place] = ended;
    }
}
