//! The acceleration structure: built once, then queried from any number of threads.

use sahl_math::{Bounds3, Ray, Vec3};

use crate::build::{self, BuildInput};
use crate::geometry::patch;
use crate::hit::Hit;
use crate::instance::PlacedGroup;
use crate::layout::{self, WideTree, WideTrees};
use crate::options::{BuildOptions, Builder};
use crate::primitive::{Item, Kind, PrimitiveName, Primitives, TreeInput, vertices};
use crate::stats::Stats;
use crate::traverse::{
    Any, Counter, Found, List, ListTree, Nearest, NoCount, PreparedRay, Scene, Search, StackSize,
    TraversalCount, traverse,
};
use crate::world::{Geometry, Instance, World};

/// Geometry prepared for ray queries. Immutable, and free of interior mutability.
///
/// A hit counts if its parameter lies in the open interval from `t_min` to `t_max`; a negative `t_min` counts as zero, and NaN
/// anywhere in a ray makes it hit nothing. Of equally near hits the one with the lowest (instance, geometry, primitive)
/// is returned, [`Hit::NO_INSTANCE`] coming last.
#[derive(Clone, Debug)]
pub struct Accel {
    world: World,
    pub(crate) primitives: Primitives,
    placed: Vec<PlacedGroup>,
    structure: Structure,
    bounds: Bounds3,
    stats: Stats,
}

/// The two things that can be searched. The last tree of each list is that of the world, the others are the groups'.
#[derive(Clone, Debug)]
enum Structure {
    Wide { trees: WideTrees, groups: Vec<WideTree>, world: WideTree, stack_size: StackSize },
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
        let Some(prepared) = PreparedRay::new(ray) else { return false };
        self.search(&prepared, &mut Any { limit: prepared.limit() }, &mut NoCount)
    }

    /// The nearest hits of many rays: `hits[i]` as [`Self::intersect`] gives it for `rays[i]`.
    ///
    /// Where the slices differ in length, the excess of the longer is left alone.
    pub fn intersect_batch(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.intersect(ray);
        }
    }

    /// [`Self::occluded`] for many rays; slices as in [`Self::intersect_batch`].
    pub fn occluded_batch(&self, rays: &[Ray], occluded: &mut [bool]) {
        for (ray, occluded) in rays.iter().zip(occluded) {
            *occluded = self.occluded(ray);
        }
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
        let prepared = PreparedRay::new(ray)?;
        let mut nearest = Nearest::new(prepared.limit());
        self.search(&prepared, &mut nearest, counter);
        nearest.result().map(|found| self.to_hit(&prepared.ray, &found))
    }

    #[inline]
    fn search<S: Search, C: Counter>(&self, ray: &PreparedRay, search: &mut S, counter: &mut C) -> bool {
        match &self.structure {
            Structure::Wide { trees, groups, world, stack_size } => {
                let scene = Scene { trees, primitives: &self.primitives, placed: &self.placed, groups };
                traverse(scene, *stack_size, world, ray, (search, counter))
            }
            Structure::List { groups, world } => {
                let list = List { primitives: &self.primitives, placed: &self.placed, groups };
                list.search(world, ray, (search, counter))
            }
        }
    }

    /// Names the primitive and finds the parameters that the traversal leaves out.
    #[inline]
    fn to_hit(&self, ray: &Ray, found: &Found) -> Hit {
        let name = self.primitives.names[found.candidate.id as usize];
        let [u, v] = match name.kind {
            Kind::Triangle | Kind::Patch => found.candidate.weights,
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
            let local = self.placed_at(found.instance).map_or(*ray, |placed| placed.local_ray(ray));
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

/// The steps of [`Accel::build`].
struct Assembly<'a> {
    world: World,
    options: &'a BuildOptions,
    primitives: Primitives,
    stats: Stats,
}

impl<'a> Assembly<'a> {
    fn new(world: World, options: &'a BuildOptions) -> Self {
        let primitives = Primitives::for_geometries(world.geometries.len());
        Self { world, options, primitives, stats: Stats::default() }
    }

    fn finish(mut self) -> Accel {
        let (world, primitives) = (&self.world, &mut self.primitives);
        let groups: Vec<TreeInput> =
            world.groups.iter().map(|group| primitives.collect(world, group)).collect();
        let local_bounds: Vec<Bounds3> = groups.iter().map(TreeInput::total_bounds).collect();
        let placed: Vec<PlacedGroup> = (world.instances.iter().zip(0..))
            .map(|(instance, index)| {
                let local = local_bounds.get(instance.group as usize).copied().unwrap_or(Bounds3::EMPTY);
                PlacedGroup::new(index, instance, local)
            })
            .collect();
        let mut input = primitives.collect(world, &world.world);
        primitives.collect_instances(&placed, &mut input);
        let bounds = input.total_bounds();
        let structure = match self.options.builder {
            Builder::BruteForce => self.list_structure(&groups, &input),
            Builder::Median | Builder::BinnedSah => self.wide_structure(&groups, &input, &placed),
        };
        let mut stats = self.stats;
        stats.primitives = groups.iter().chain([&input]).map(|input| input.items.len() as u64).sum();
        stats.dropped = self.primitives.dropped;
        stats.bytes += self.primitives.bytes() + size_of_val(placed.as_slice()) as u64;
        Accel { world: self.world, primitives: self.primitives, placed, structure, bounds, stats }
    }

    fn list_structure(&mut self, groups: &[TreeInput], input: &TreeInput) -> Structure {
        let vertices = |id: u32| triangle_vertices(&self.world, &self.primitives.names, id);
        let list = |input: &TreeInput| ListTree::new(&input.items, &vertices);
        let (groups, world): (Vec<_>, _) = (groups.iter().map(list).collect(), list(input));
        self.stats.bytes = groups.iter().chain([&world]).map(ListTree::bytes).sum();
        Structure::List { groups, world }
    }

    fn wide_structure(
        &mut self,
        groups: &[TreeInput],
        input: &TreeInput,
        placed: &[PlacedGroup],
    ) -> Structure {
        let mut trees = WideTrees::default();
        let built: Vec<(WideTree, f64)> =
            groups.iter().map(|group| self.wide_tree(&mut trees, group, &|_| 1.0)).collect();
        // An instance costs its box test and what its group costs.
        let cost = |place: u32| match input.items[place as usize] {
            Item::Instance(place) => {
                built.get(placed[place as usize].group as usize).map_or(1.0, |tree| 1.0 + tree.1)
            }
            _ => 1.0,
        };
        let (world, sah_cost) = self.wide_tree(&mut trees, input, &cost);
        let groups: Vec<WideTree> = built.into_iter().map(|(tree, _)| tree).collect();
        let depth = groups.iter().map(|tree| tree.depth).fold(world.depth, u32::max);
        self.stats.nodes = trees.nodes.len() as u64;
        self.stats.leaves = trees.leaves;
        self.stats.depth = depth;
        self.stats.sah_cost = sah_cost as f32;
        self.stats.bytes = trees.bytes();
        Structure::Wide { trees, groups, world, stack_size: StackSize::for_depth(depth) }
    }

    /// Builds and appends one tree; returns it with its cost.
    fn wide_tree(
        &self,
        trees: &mut WideTrees,
        input: &TreeInput,
        cost: &dyn Fn(u32) -> f64,
    ) -> (WideTree, f64) {
        let vertices = |id: u32| triangle_vertices(&self.world, &self.primitives.names, id);
        let source = BuildInput { bounds: &input.bounds, centers: &input.centers };
        match build::build(source, self.options) {
            Some(tree) => (layout::append_tree(trees, &tree, input, &vertices), tree.sah_cost(cost)),
            None => (WideTree { root: None, depth: 0 }, 0.0),
        }
    }
}

/// The vertices of a triangle, or of half a patch. Ids are given to those that have them; NaN, which nothing hits, stands
/// for what cannot be.
fn triangle_vertices(world: &World, names: &[PrimitiveName], id: u32) -> [Vec3; 3] {
    let name = names[id as usize];
    let found = match (world.geometries.get(name.geometry as usize), name.kind) {
        (Some(Geometry::Triangles(mesh)), Kind::Triangle) => {
            mesh.indices.get(name.primitive as usize).and_then(|&indices| vertices(&mesh.positions, indices))
        }
        (Some(Geometry::Patches(mesh)), kind) => mesh
            .indices
            .get(name.primitive as usize)
            .and_then(|&indices| vertices(&mesh.positions, indices))
            .map(|corners| {
                patch::halves(&corners)[usize::from(matches!(kind, Kind::Half { upper: true, .. }))]
            }),
        _ => None,
    };
    found.unwrap_or([Vec3::splat(f32::NAN); 3])
}
