//! Edited geometry: the trees stay, and their boxes go where the primitives have gone.
//!
//! That is quick, a few percent of a build, and the hits are those of a new build. But the trees are those of where everything was: the
//! further it has gone, the more the boxes overlap and the longer rays take. [`Refit::cost_ratio`] tells how much, and the caller decides
//! when to build anew.

mod edit;

use rayon::prelude::*;
use sahl_math::{Bounds3, Vec3};

use crate::accel::{Accel, Structure};
use crate::assembly::OTHER_COST;
use crate::geometry::patch::{self, PatchKind};
use crate::instance::PlacedGroup;
use crate::layout::{Child, MovedLeaf, MovedPrimitives, Vertices};
use crate::motion::usable_triangle;
use crate::primitive::{Primitives, are_usable, has_area, is_usable, vertices};
use crate::vertices::TriangleVertices;
use crate::world::{Geometry, World};
use edit::Changes;
pub use edit::{Edit, UnfitEdit};

/// What came of edits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refit {
    /// The expected cost of a ray, see [`crate::Stats::sah_cost`], relative to that when the trees were built: from about 1.5 on, building
    /// anew is worth it for more than a few rays.
    pub cost_ratio: f32,
    /// Whether the trees were built anew after all: something can be hit that could not when they were built, and so stands in no tree, or
    /// a patch is flat that was not, or there are no trees but the brute-force list.
    pub rebuilt: bool,
}

/// What a structure remembers of when it was built or last refitted.
#[derive(Clone, Debug, Default)]
pub(crate) struct Measures {
    /// The cost when the trees were built.
    pub(crate) built_cost: f32,
    pub(crate) group_bounds: Vec<Bounds3>,
    pub(crate) group_costs: Vec<f32>,
    /// With the visit of the leaf that they are.
    pub(crate) moving_costs: Vec<f32>,
}

impl Accel {
    /// Changes the world, and puts the boxes of the trees where the primitives are now. The hits are then those of a structure that is
    /// built from the changed world; only what takes how long differs.
    ///
    /// Edits are made in their order. What cannot be hit any more, because it is not finite or has no surface, is counted in
    /// [`crate::Stats::dropped`] as by [`Self::build`], and may come back by a later edit. None is made if one does not fit.
    ///
    /// ```
    /// # use sahl_accel::{Accel, BuildOptions, Edit, Geometry, TriangleMesh, World};
    /// # use sahl_math::{Ray, Vec3};
    /// # let mesh = TriangleMesh { indices: [[0, 1, 2]].into(), positions: [Vec3::ZERO, Vec3::X, Vec3::Y].into() };
    /// # let world = World { geometries: vec![Geometry::Triangles(mesh)], world: vec![0], ..World::default() };
    /// let mut accel = Accel::build(world, &BuildOptions::default());
    /// let positions = [Vec3::ZERO, Vec3::X, Vec3::Y].map(|p| p + Vec3::Z * 3.0);
    /// accel.refit(vec![Edit::Positions { geometry: 0, positions: positions.into() }]).unwrap();
    /// assert_eq!(accel.intersect(&Ray::new(Vec3::new(0.2, 0.2, 5.0), -Vec3::Z)).unwrap().t, 2.0);
    /// ```
    pub fn refit(&mut self, edits: Vec<Edit>) -> Result<Refit, UnfitEdit> {
        if let Some(place) = edits.iter().position(|edit| !edit.fits(&self.world)) {
            return Err(UnfitEdit { place });
        }
        let changes = Changes::of(&edits, &self.world);
        let before = self.counts(&changes);
        for edit in edits {
            edit.apply(&mut self.world);
        }
        if self.stands_in_no_tree(&changes) || !self.refit_trees(&changes) {
            *self = Self::build(std::mem::take(&mut self.world), &self.options);
            return Ok(Refit { cost_ratio: 1.0, rebuilt: true });
        }
        let after = self.counts(&changes);
        let gained = |after: u64, before: u64| after.wrapping_sub(before);
        let stats = &mut self.stats;
        stats.primitives = stats.primitives.wrapping_add(gained(after.primitives, before.primitives));
        stats.dropped = stats.dropped.wrapping_add(gained(after.dropped, before.dropped));
        stats.bytes = stats.bytes.wrapping_add(gained(after.motions, before.motions));
        let built = self.measures.built_cost;
        let cost_ratio = if built > 0.0 { self.stats.sah_cost / built } else { 1.0 };
        Ok(Refit { cost_ratio, rebuilt: false })
    }

    /// Whether something has to be hit that is in no tree.
    fn stands_in_no_tree(&self, changes: &Changes) -> bool {
        let world = &self.world;
        let vertices = TriangleVertices { world, primitives: &self.primitives };
        let is_back = |id: &u32| {
            let name = self.primitives.name(*id);
            changes.geometry(name.geometry)
                && match &world.geometries[name.geometry as usize] {
                    Geometry::MovingTriangles(mesh) => {
                        usable_triangle(mesh, name.primitive as usize).is_some()
                    }
                    _ => is_triangle(&vertices.triangle(*id)),
                }
        };
        self.primitives.absent.iter().any(is_back)
            || changes.changed_geometries().any(|geometry| self.has_other_kinds(geometry))
    }

    /// Whether a patch of a geometry is traced in another way than it is now prepared for.
    fn has_other_kinds(&self, geometry: u32) -> bool {
        let Geometry::Patches(mesh) = &self.world.geometries[geometry as usize] else { return false };
        let kind = |indices: &[u32; 4]| {
            vertices(&mesh.positions, *indices)
                .map_or(PatchKind::Degenerate, |corners| patch::classify(&corners))
        };
        let mut kinds = (0..).zip(mesh.indices.iter());
        self.primitives.collected(geometry)
            && kinds.any(|(place, indices)| kind(indices) != self.primitives.patch_kind(geometry, place))
    }

    /// Puts the boxes where the primitives are now; false if an instance has to be hit that is in no tree, or there are no trees.
    fn refit_trees(&mut self, changes: &Changes) -> bool {
        let Self { world, primitives, placed, structure, measures, .. } = self;
        let Structure::Wide { trees, groups, world: tree, .. } = structure else { return false };
        primitives.refit(world, |geometry| changes.geometry(geometry), &mut measures.moving_costs);
        let group_changed: Vec<bool> = world.groups.iter().map(|group| changes.any_of(group)).collect();
        for (group, _) in group_changed.iter().enumerate().filter(|(_, is_changed)| **is_changed) {
            let refitted = trees.refit(&groups[group], &Now { world, primitives, placed, measures });
            measures.group_bounds[group] = refitted.bounds;
            measures.group_costs[group] = refitted.cost;
        }
        let mut any_instance = false;
        for (index, instance) in (0..).zip(&world.instances) {
            let group = instance.group as usize;
            let place = index as usize;
            if changes.instances[place] || group_changed.get(group).is_some_and(|&is_changed| is_changed) {
                let local = measures.group_bounds.get(group).copied().unwrap_or(Bounds3::EMPTY);
                placed[place] = PlacedGroup::new(index, instance, local);
                // They were listed in ascending order.
                let was_absent = primitives.absent_instances.binary_search(&index).is_ok();
                if was_absent && can_be_hit(&placed[place].bounds()) {
                    return false;
                }
                any_instance = true;
            }
        }
        if any_instance || changes.any_of(&world.world) {
            let refitted = trees.refit(tree, &Now { world, primitives, placed, measures });
            (self.bounds, self.stats.sah_cost) = (refitted.bounds, refitted.cost);
        }
        true
    }

    /// Counts what edits may change: of changed geometries in each tree that holds them, and of all instances.
    fn counts(&self, changes: &Changes) -> Counts {
        let mut counts = Counts::default();
        let trees = self.trees_of_geometries();
        for geometry in changes.changed_geometries() {
            let trees = trees[geometry as usize];
            let (usable, dropped) = self.usable(geometry);
            counts.primitives += trees * usable;
            counts.dropped += trees * dropped;
        }
        for placed in &self.placed {
            let is_hit = u64::from(can_be_hit(&placed.bounds()));
            counts.primitives += is_hit;
            counts.dropped += 1 - is_hit;
            counts.motions += placed.bytes();
        }
        counts
    }

    /// In how many trees each geometry stands.
    fn trees_of_geometries(&self) -> Vec<u64> {
        let world = &self.world;
        // The number of trees, and the last set that was counted: sets may name a geometry more than once.
        let mut trees = vec![(0, usize::MAX); world.geometries.len()];
        for (set, geometries) in world.groups.iter().chain([&world.world]).enumerate() {
            for &geometry in geometries {
                if let Some((count, last)) = trees.get_mut(geometry as usize)
                    && *last != set
                {
                    (*count, *last) = (*count + 1, set);
                }
            }
        }
        trees.into_iter().map(|(count, _)| count).collect()
    }

    /// How many primitives of a mesh can be hit, and how many cannot.
    fn usable(&self, geometry: u32) -> (u64, u64) {
        match &self.world.geometries[geometry as usize] {
            Geometry::Triangles(mesh) => {
                let is_usable = |indices: &&[u32; 3]| {
                    vertices(&mesh.positions, **indices).is_some_and(|vertices| has_area(&vertices))
                };
                let usable = mesh.indices.par_iter().filter(is_usable).count();
                (usable as u64, (mesh.indices.len() - usable) as u64)
            }
            Geometry::MovingTriangles(mesh) => {
                let places = (0..mesh.indices.len()).into_par_iter();
                let usable = places.filter(|&place| usable_triangle(mesh, place).is_some()).count();
                (usable as u64, (mesh.indices.len() - usable) as u64)
            }
            Geometry::Patches(mesh) => {
                let halves = |indices: &[u32; 4]| {
                    let corners = vertices(&mesh.positions, *indices)?;
                    Some(match patch::classify(&corners) {
                        PatchKind::Degenerate => 0,
                        PatchKind::Curved => 1,
                        _ => patch::halves(&corners).iter().filter(|half| has_area(half)).count(),
                    })
                };
                let counts = mesh.indices.iter().map(|indices| halves(indices).unwrap_or(0));
                // Kinds do not change without a new build: what is dropped stays so.
                (counts.sum::<usize>() as u64, 0)
            }
            _ => (0, 0),
        }
    }
}

/// What edits may change of the statistics.
#[derive(Default)]
struct Counts {
    primitives: u64,
    dropped: u64,
    /// Memory of motions in bytes.
    motions: u64,
}

/// Whether these are vertices of a triangle that can be hit.
fn is_triangle(vertices: &[Vec3; 3]) -> bool {
    vertices.iter().all(|&vertex| is_usable(vertex)) && has_area(vertices)
}

/// Whether a box is that of a placed group that can be hit.
fn can_be_hit(bounds: &Bounds3) -> bool {
    !bounds.is_empty() && are_usable(bounds)
}

/// The primitives of static trees where they are now.
struct Now<'a> {
    world: &'a World,
    primitives: &'a Primitives,
    placed: &'a [PlacedGroup],
    measures: &'a Measures,
}

impl MovedPrimitives for Now<'_> {
    const NOTHING: Bounds3 = Bounds3::EMPTY;

    fn triangle(&self, id: u32) -> Option<[Vec3; 3]> {
        let vertices = TriangleVertices { world: self.world, primitives: self.primitives }.triangle(id);
        is_triangle(&vertices).then_some(vertices)
    }

    fn other(&self, child: Child) -> MovedLeaf {
        let leaf = |bounds, cost| MovedLeaf { child, bounds, cost };
        match child {
            Child::Node(_) | Child::Block(_) => leaf(Self::NOTHING, 0.0),
            Child::Patch(place) => {
                leaf(patch::curved_bounds(&self.primitives.patches[place as usize].corners), OTHER_COST)
            }
            Child::Curve(place) => leaf(self.primitives.curve_bounds(place), OTHER_COST),
            Child::Quadric(place) => leaf(self.primitives.quadrics[place as usize].bounds(), OTHER_COST),
            Child::MovingMesh(place) => {
                let cost = self.measures.moving_costs[place as usize];
                leaf(self.primitives.moving[place as usize].bounds, cost)
            }
            Child::Instance(place) | Child::MovingInstance(place) => {
                let placed = &self.placed[place as usize];
                let group_cost = self.measures.group_costs.get(placed.group as usize).copied().unwrap_or(0.0);
                let bounds = placed.bounds();
                let bounds = if can_be_hit(&bounds) { bounds } else { Self::NOTHING };
                let child =
                    if placed.moves() { Child::MovingInstance(place) } else { Child::Instance(place) };
                MovedLeaf { child, bounds, cost: 1.0 + group_cost }
            }
        }
    }
}
