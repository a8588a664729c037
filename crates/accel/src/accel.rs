//! The acceleration structure: built once, then queried from any number of threads.

use std::ops::Range;

use sahl_math::{Bounds3, Ray};

use crate::assembly::Assembly;
use crate::filter::Filtered;
use crate::geometry::patch;
use crate::hit::Hit;
use crate::instance::PlacedGroup;
use crate::kernel::Machine;
use crate::layout::{WideTree, WideTrees};
use crate::names::{Kind, PrimitiveName};
use crate::options::BuildOptions;
use crate::primitive::{Primitives, vertices};
use crate::refit::Measures;
use crate::stats::Stats;
use crate::traverse::{
    Any, Candidate, Counter, Found, List, ListTree, Nearest, NoCount, PreparedRay, Query, Scene, Search,
    StackSize, TraversalCount, limit_of, traverse, traverse_packets, traverse_stream,
};
use crate::world::{Geometry, Instance, World};

/// Geometry prepared for ray queries. Changed by [`Self::refit`] alone, and free of interior mutability.
///
/// A hit counts if its parameter lies in the open interval from `t_min` to `t_max`; a negative `t_min`, or NaN, counts as zero. A
/// ray hits nothing if its direction is zero, if its origin or direction is not finite, or if `t_max` is NaN. What moves stands where it is at the ray's time, which is clamped to 0 … 1, NaN
/// counting as 0. Of equally near hits the one with the lowest (instance, geometry, primitive)
/// is returned, [`Hit::NO_INSTANCE`] coming last.
#[derive(Clone, Debug)]
pub struct Accel {
    pub(crate) world: World,
    pub(crate) primitives: Primitives,
    pub(crate) placed: Vec<PlacedGroup>,
    pub(crate) structure: Structure,
    pub(crate) bounds: Bounds3,
    pub(crate) filtered: Filtered,
    pub(crate) options: BuildOptions,
    pub(crate) measures: Measures,
    pub(crate) stats: Stats,
}

/// The two things that can be searched. The last tree of each list is that of the world, the others are the groups'.
#[derive(Clone, Debug)]
pub(crate) enum Structure {
    Wide { trees: WideTrees, groups: Vec<WideTree>, world: WideTree, machine: (Machine, StackSize) },
    List { groups: Vec<ListTree>, world: ListTree },
}

impl Accel {
    /// Builds the trees of the world and of each group.
    ///
    /// Never panics: primitives that are not finite (or reach beyond 1e18) or have no surface, and indices out of range, are dropped and counted in
    /// [`Stats::dropped`]. The result is a function of the arguments alone, whatever the number of threads.
    pub fn build(world: World, options: &BuildOptions) -> Self {
        Assembly::new(world, options).finish()
    }

    /// The nearest hit.
    #[inline]
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        self.nearest(ray, &mut NoCount)
    }

    /// The nearest hit, with the work it took added to `count`.
    pub fn intersect_counted(&self, ray: &Ray, count: &mut TraversalCount) -> Option<Hit> {
        self.nearest(ray, count)
    }

    /// Whether anything lies on the ray.
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.search(ray, &mut Any { limit: limit_of(ray) }, &mut NoCount)
    }

    /// The nearest hits of many rays: `hits[i]` as [`Self::intersect`] gives it for `rays[i]`.
    ///
    /// On the calling thread, with up to 32 rays in flight. Where the slices differ in length, the excess of the longer is left alone.
    pub fn intersect_batch(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        let count = hits.len().min(rays.len());
        self.answer(&rays[..count], traverse_stream, &mut NearestHits { accel: self, rays, hits });
    }

    /// [`Self::intersect_batch`] for rays of which each 64 in a row go nearly the same way, as the camera rays of eight by eight pixels.
    ///
    /// Rays that do not go nearly the same way are answered as well; the first of them take longer. There is no such query for
    /// occlusion: shadow rays of neighbouring points part at edges and have ends of their own, and a batch leaves each of them at the
    /// first thing in its way.
    ///
    /// The hits are those of [`Self::intersect`], to the last bit, unless a triangle is so thin or so large against its distance that
    /// its parameter errs by more than the boxes allow for (a relative 2 γ₇): then either may find the nearer one.
    pub fn intersect_coherent(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        let count = hits.len().min(rays.len());
        self.answer(&rays[..count], traverse_packets, &mut NearestHits { accel: self, rays, hits });
    }

    /// [`Self::occluded`] for many rays; slices as in [`Self::intersect_batch`].
    pub fn occluded_batch(&self, rays: &[Ray], occluded: &mut [bool]) {
        let count = occluded.len().min(rays.len());
        self.answer(&rays[..count], traverse_stream, &mut Occlusions { occluded });
    }

    /// The box about the world; empty if nothing can be hit.
    pub fn bounds(&self) -> Bounds3 {
        self.bounds
    }

    /// Counts, sizes and quality.
    pub fn stats(&self) -> Stats {
        self.stats
    }

    /// A geometry of the world that was built from.
    ///
    /// # Panics
    /// If there is no such geometry; those of hits are there.
    pub fn geometry(&self, geometry: u32) -> &Geometry {
        &self.world.geometries[geometry as usize]
    }

    /// An instance of the world that was built from.
    ///
    /// # Panics
    /// If there is no such instance; those of hits are there, except [`Hit::NO_INSTANCE`].
    pub fn instance(&self, instance: u32) -> &Instance {
        &self.world.instances[instance as usize]
    }

    #[inline]
    fn nearest(&self, ray: &Ray, counter: &mut impl Counter) -> Option<Hit> {
        let mut nearest = Nearest::new(limit_of(ray));
        self.search(ray, &mut nearest, counter);
        nearest.result().map(|found| self.to_hit(ray, &found))
    }

    #[inline]
    pub(crate) fn search<S: Search, C: Counter>(&self, ray: &Ray, search: &mut S, counter: &mut C) -> bool {
        match &self.structure {
            Structure::Wide { trees, groups, world, machine } => {
                let scene =
                    Scene { trees: trees.view(), primitives: &self.primitives, placed: &self.placed, groups };
                traverse(scene, *machine, world, ray, (search, counter))
            }
            Structure::List { groups, world } => {
                let list = List { primitives: &self.primitives, placed: &self.placed, groups };
                PreparedRay::new(ray).is_some_and(|ray| list.search(world, &ray, (search, counter)))
            }
        }
    }

    /// Answers a query for each ray, by one of the traversals for many.
    #[inline]
    pub(crate) fn answer<Q: Query>(
        &self,
        rays: &[Ray],
        traverse: fn(Scene<'_>, (Machine, StackSize), &WideTree, &[Ray], &mut Q),
        query: &mut Q,
    ) {
        if let Structure::Wide { trees, groups, world, machine } = &self.structure {
            let scene =
                Scene { trees: trees.view(), primitives: &self.primitives, placed: &self.placed, groups };
            return traverse(scene, *machine, world, rays, query);
        }
        query.begin(0..rays.len());
        for (place, ray) in rays.iter().enumerate() {
            let mut search = query.start(place, limit_of(ray));
            let ended = self.search(ray, &mut search, &mut NoCount);
            query.finish(place, &search, ended);
        }
    }

    /// Names the primitive and finds the parameters that the traversal leaves out.
    #[inline(always)]
    pub(crate) fn to_hit(&self, ray: &Ray, found: &Found) -> Hit {
        let Found { candidate: Candidate { t, id, weights: [u, v] }, instance } = *found;
        match self.primitives.triangle_name(id) {
            Some([geometry, primitive]) => Hit { t, u, v, geometry, primitive, instance },
            None => self.to_other_hit(ray, found),
        }
    }

    /// [`Self::to_hit`] for what is not a triangle of a mesh.
    #[inline(never)]
    fn to_other_hit(&self, ray: &Ray, found: &Found) -> Hit {
        let name = self.primitives.name(found.candidate.id);
        let [u, v] = match name.kind {
            Kind::Triangle | Kind::Patch | Kind::Curve => found.candidate.weights,
            Kind::Half { upper, parallelogram: true } => {
                patch::affine_parameters(upper, found.candidate.weights)
            }
            Kind::Half { upper, .. } => self.planar_parameters(name, upper, found.candidate.weights),
            Kind::Quadric => self.quadric_parameters(ray, name.geometry, found),
        };
        Hit {
            t: found.candidate.t,
            u,
            v,
            geometry: name.geometry,
            primitive: name.primitive,
            instance: found.instance,
        }
    }

    #[inline(never)]
    fn planar_parameters(&self, name: PrimitiveName, upper: bool, weights: [f32; 2]) -> [f32; 2] {
        self.corners(name.geometry, name.primitive)
            .map_or(weights, |corners| patch::planar_parameters(&corners, upper, weights))
    }

    #[inline(never)]
    fn quadric_parameters(&self, ray: &Ray, geometry: u32, found: &Found) -> [f32; 2] {
        self.primitives.quadric(geometry).map_or([0.0; 2], |quadric| {
            // As the traversal sees it: which root counts depends on where the interval begins.
            let ray = Ray { t_min: ray.t_min.max(0.0), ..*ray };
            let local = self.placed_at(found.instance).map_or(ray, |placed| placed.local_ray_at_time(&ray));
            let surface = quadric.surface(&local, found.candidate.t);
            [surface.u, surface.v]
        })
    }

    pub(crate) fn world_geometry(&self, geometry: u32) -> Option<&Geometry> {
        self.world.geometries.get(geometry as usize)
    }

    /// The corners of a patch.
    pub(crate) fn corners(&self, geometry: u32, primitive: u32) -> Option<patch::Corners> {
        match self.world.geometries.get(geometry as usize)? {
            Geometry::Patches(mesh) => vertices(&mesh.positions, *mesh.indices.get(primitive as usize)?),
            _ => None,
        }
    }

    /// The placed group of an instance; `None` for the world itself.
    #[inline]
    pub(crate) fn placed_at(&self, instance: u32) -> Option<&PlacedGroup> {
        self.placed.get(instance as usize)
    }
}

/// The nearest hits of a slice of rays.
struct NearestHits<'a> {
    accel: &'a Accel,
    rays: &'a [Ray],
    hits: &'a mut [Option<Hit>],
}

impl Query for NearestHits<'_> {
    type Search = Nearest;

    #[inline(always)]
    fn begin(&mut self, places: Range<usize>) {
        self.hits[places].fill(None);
    }

    #[inline(always)]
    fn start(&self, _place: usize, limit: f32) -> Nearest {
        Nearest::new(limit)
    }

    #[inline(always)]
    fn finish(&mut self, place: usize, search: &Nearest, _ended: bool) {
        let Some(found) = search.result() else { return };
        let Found { candidate: Candidate { t, id, weights: [u, v] }, instance } = found;
        // Written here and in a function of its own: hits that meet on the way would go through memory.
        match self.accel.primitives.triangle_name(id) {
            Some([geometry, primitive]) => {
                self.hits[place] = Some(Hit { t, u, v, geometry, primitive, instance });
            }
            None => self.finish_other(place, &found),
        }
    }
}

impl NearestHits<'_> {
    #[inline(never)]
    fn finish_other(&mut self, place: usize, found: &Found) {
        self.hits[place] = Some(self.accel.to_other_hit(&self.rays[place], found));
    }
}

/// Whether anything lies on each ray of a slice.
struct Occlusions<'a> {
    occluded: &'a mut [bool],
}

impl Query for Occlusions<'_> {
    type Search = Any;

    #[inline(always)]
    fn begin(&mut self, places: Range<usize>) {
        self.occluded[places].fill(false);
    }

    #[inline(always)]
    fn start(&self, _place: usize, limit: f32) -> Any {
        Any { limit }
    }

    #[inline(always)]
    fn finish(&mut self, place: usize, _search: &Any, ended: bool) {
        self.occluded[place] = ended;
    }
}
