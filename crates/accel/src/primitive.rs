//! From a world to the flat lists that builders and kernels work on; what cannot be hit is dropped here.

use std::ops::Range;

use rayon::prelude::*;
use sahl_math::{Bounds3, Vec3};

use crate::build::{Box8, Extent, Reference};
use crate::geometry::curve::{CurvePart, Curves};
use crate::geometry::double::DVec3;
use crate::geometry::patch::{self, Corners, PatchKind};
use crate::geometry::quadric::Quadric;
use crate::instance::PlacedGroup;
use crate::kernel::prefer_large_pages;
use crate::motion::MovingMesh;
use crate::names::{Names, PrimitiveName, Shape};
use crate::traverse::{Candidate, PreparedRay};
use crate::world::{CurveSet, Geometry, MovingTriangleMesh, PatchMesh, TriangleMesh, World};

/// Primitives beyond this count are dropped: in full leaves, there are places for the rows of so many, see [`crate::layout`].
const MAX_PRIMITIVES: usize = 1 << 27;

/// Primitives that reach beyond this coordinate are dropped as if it were infinite: the tests square coordinates in `f32`.
const MAX_COORDINATE: f32 = 1e18;

/// How many primitives one task prepares.
const CHUNK: usize = 1 << 12;

/// How many primitives are prepared before their extent is found.
const PORTION: usize = 1 << 15;

/// So many times the memory that references need is asked for: for parts of them, and for the rows of the tree that may take the memory
/// over. To grow would mean to copy, and memory that is not used is not given.
const ROOM: usize = 2;

/// A primitive that a tree holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Item {
    /// A triangle or half of a planar patch: an id.
    Triangle(u32),
    /// A place in [`Primitives::patches`].
    Patch(u32),
    /// A place in [`Primitives::quadrics`].
    Quadric(u32),
    /// A place in the list of placed groups: of one that stands still.
    Instance(u32),
    /// A place in [`Primitives::curve_parts`].
    Curve(u32),
    /// A place in [`Primitives::moving`].
    MovingMesh(u32),
    /// A place in the list of placed groups: of one that moves.
    MovingInstance(u32),
}

impl Item {
    /// Its kind, zero for triangles, and its id or place.
    #[inline(always)]
    pub(crate) fn encode(self) -> (u32, u32) {
        match self {
            Self::Triangle(id) => (0, id),
            Self::Patch(place) => (1, place),
            Self::Quadric(place) => (2, place),
            Self::Instance(place) => (3, place),
            Self::Curve(place) => (4, place),
            Self::MovingMesh(place) => (5, place),
            Self::MovingInstance(place) => (6, place),
        }
    }

    /// What was encoded.
    #[inline(always)]
    pub(crate) fn decode(kind: u32, place: u32) -> Self {
        match kind {
            0 => Self::Triangle(place),
            1 => Self::Patch(place),
            2 => Self::Quadric(place),
            3 => Self::Instance(place),
            4 => Self::Curve(place),
            5 => Self::MovingMesh(place),
            _ => Self::MovingInstance(place),
        }
    }
}

/// A patch that is solved as a ruled surface.
#[derive(Clone, Debug)]
pub(crate) struct CurvedPatch {
    pub(crate) corners: Corners,
    pub(crate) id: u32,
}

/// All primitives of a world, whichever tree they stand in.
#[derive(Clone, Debug, Default)]
pub(crate) struct Primitives {
    names: Names,
    pub(crate) patches: Vec<CurvedPatch>,
    pub(crate) quadrics: Vec<Quadric>,
    curves: Vec<Curves>,
    pub(crate) curve_parts: Vec<CurvePart>,
    pub(crate) moving: Vec<MovingMesh>,
    /// How many were left out.
    pub(crate) dropped: u64,
    /// The ids of triangles and halves of patches that were left out because they have no surface or are not finite.
    pub(crate) absent: Vec<u32>,
    /// The instances that were left out.
    pub(crate) absent_instances: Vec<u32>,
    /// How many the trees hold.
    collected: usize,
}

/// What one tree is built over.
#[derive(Clone, Debug)]
pub(crate) struct TreeInput {
    pub(crate) references: Vec<Reference>,
    pub(crate) extent: Extent,
}

impl TreeInput {
    /// The box about everything.
    pub(crate) fn total_bounds(&self) -> Bounds3 {
        if self.references.is_empty() { Bounds3::EMPTY } else { self.extent.bounds.bounds() }
    }

    fn push(&mut self, item: Item, bounds: &Bounds3) {
        let reference = Reference::new(bounds, item);
        self.extent = self.extent.including(&reference);
        self.references.push(reference);
    }
}

impl Primitives {
    /// No primitives yet, of a world with these geometries.
    pub(crate) fn for_geometries(geometries: &[Geometry]) -> Self {
        Self { names: Names::new(geometries), ..Self::default() }
    }

    /// The geometry and the number of a triangle of a mesh; `None` for other primitives.
    #[inline(always)]
    pub(crate) fn triangle_name(&self, id: u32) -> Option<[u32; 2]> {
        self.names.triangle(id)
    }

    /// What the primitive with an id is called.
    #[inline]
    pub(crate) fn name(&self, id: u32) -> PrimitiveName {
        self.names.name(id)
    }

    /// The ids of a geometry.
    #[inline]
    pub(crate) fn ids(&self, geometry: u32) -> Range<u32> {
        self.names.ids(geometry)
    }

    /// Whether the patches of a geometry stand in a tree.
    pub(crate) fn collected(&self, geometry: u32) -> bool {
        matches!(self.names.shape(geometry), Some(Shape::Patches(kinds)) if !kinds.is_empty())
    }

    /// Takes the meshes that have changed as they are now, with the costs of those that move.
    pub(crate) fn refit(
        &mut self,
        world: &World,
        is_changed: impl Fn(u32) -> bool,
        moving_costs: &mut [f32],
    ) {
        for (moving, cost) in self.moving.iter_mut().zip(moving_costs) {
            if let Some(Geometry::MovingTriangles(mesh)) = world.geometries.get(moving.geometry as usize)
                && is_changed(moving.geometry)
            {
                *cost = 1.0 + moving.refit(mesh);
            }
        }
        for curved in &mut self.patches {
            let PrimitiveName { geometry, primitive, .. } = self.names.name(curved.id);
            if let Some(Geometry::Patches(mesh)) = world.geometries.get(geometry as usize)
                && is_changed(geometry)
                && let Some(&indices) = mesh.indices.get(primitive as usize)
                && let Some(corners) = vertices(&mesh.positions, indices)
            {
                curved.corners = corners;
            }
        }
    }

    /// The prepared quadric of a geometry that is one.
    #[inline]
    pub(crate) fn quadric(&self, geometry: u32) -> Option<&Quadric> {
        match self.names.shape(geometry)? {
            Shape::Quadric(Some(place)) => self.quadrics.get(*place as usize),
            _ => None,
        }
    }

    /// The prepared curves of a geometry that is some.
    #[inline]
    pub(crate) fn curves(&self, geometry: u32) -> Option<&Curves> {
        match self.names.shape(geometry)? {
            Shape::Curves { place: Some(place), .. } => self.curves.get(*place as usize),
            _ => None,
        }
    }

    /// The memory of the lists in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let lists = size_of_val(self.patches.as_slice())
            + size_of_val(self.quadrics.as_slice())
            + size_of_val(self.curves.as_slice())
            + size_of_val(self.curve_parts.as_slice());
        let moving = self.moving.iter().map(|mesh| mesh.bytes() + size_of_val(mesh) as u64).sum::<u64>();
        self.names.bytes() + lists as u64 + moving
    }

    /// Collects the primitives of one set of geometries: those of the world or of one group.
    ///
    /// Indices out of range and repeated ones are left out; the former are counted.
    pub(crate) fn collect(&mut self, world: &World, geometries: &[u32]) -> TreeInput {
        let mut sorted = geometries.to_vec();
        sorted.sort_unstable();
        sorted.dedup();
        let capacity = self.names.count(&sorted).min(self.space());
        let references = Vec::with_capacity(capacity * ROOM);
        prefer_large_pages(&references);
        let mut input = TreeInput { references, extent: Extent::EMPTY };
        for index in sorted {
            let start = input.references.len();
            match world.geometries.get(index as usize) {
                Some(Geometry::Triangles(mesh)) => self.collect_triangles(index, mesh, &mut input),
                Some(Geometry::MovingTriangles(mesh)) => self.collect_moving(index, mesh, &mut input),
                Some(Geometry::Patches(mesh)) => self.collect_patches(index, mesh, &mut input),
                Some(Geometry::Curves(set)) => self.collect_curves(index, set, &mut input),
                Some(quadric) => self.collect_quadric(index, quadric, &mut input),
                None => self.dropped += 1,
            }
            self.collected += input.references.len() - start;
        }
        // What was dropped leaves its room behind, of every group.
        input.references.shrink_to(input.references.len() * ROOM);
        input
    }

    /// Adds placed groups to the input of the world's tree; those that hold nothing are left out.
    pub(crate) fn collect_instances(&mut self, placed: &[PlacedGroup], input: &mut TreeInput) {
        for (place, group) in placed.iter().enumerate() {
            let bounds = group.bounds();
            if bounds.is_empty() || !are_usable(&bounds) || self.collected >= MAX_PRIMITIVES {
                self.dropped += 1;
                self.absent_instances.push(place as u32);
            } else {
                let place = place as u32;
                let item = if group.moves() { Item::MovingInstance(place) } else { Item::Instance(place) };
                input.push(item, &bounds);
                self.collected += 1;
            }
        }
    }

    /// How many more primitives there may be.
    fn space(&self) -> usize {
        MAX_PRIMITIVES - self.collected
    }

    fn collect_triangles(&mut self, geometry: u32, mesh: &TriangleMesh, input: &mut TreeInput) {
        let ids = self.names.ids(geometry);
        let count = ids.len().min(self.space()).min(mesh.indices.len());
        self.dropped += (mesh.indices.len() - count) as u64;
        let prepare = |(offset, indices): (usize, &[u32; 3])| {
            let found = indices.map(|index| mesh.positions.get(index as usize).copied());
            let [Some(a), Some(b), Some(c)] = found else { return Reference::NONE };
            let bounds = Box8::around([a, b, c]);
            let id = ids.start + offset as u32;
            // Coordinates that are NaN show in the area only.
            let usable = bounds.is_within(MAX_COORDINATE) && has_area(&[a, b, c]);
            if usable { Reference::triangle(bounds, id) } else { Reference::NONE }
        };
        // In portions that stay in the cache while their extent is found.
        for (portion, faces) in (0..).zip(mesh.indices[..count].chunks(PORTION)) {
            let start = input.references.len();
            let indices = faces.par_iter().with_min_len(CHUNK).enumerate();
            let with_offset = indices.map(|(offset, indices)| (portion * PORTION + offset, indices));
            input.references.par_extend(with_offset.map(prepare));
            let dropped = input.admit(start);
            if dropped > 0 {
                self.dropped += dropped;
                let first = ids.start + (portion * PORTION) as u32;
                let is_absent =
                    |indices: &[u32; 3]| !vertices(&mesh.positions, *indices).is_some_and(|v| has_area(&v));
                let absent = (first..).zip(faces).filter(|(_, indices)| is_absent(indices));
                self.absent.extend(absent.map(|(id, _)| id));
            }
        }
    }

    fn collect_moving(&mut self, geometry: u32, mesh: &MovingTriangleMesh, input: &mut TreeInput) {
        let ids = self.names.ids(geometry);
        let count = ids.len().min(self.space()).min(mesh.indices.len());
        let moving = MovingMesh::new(geometry, mesh, (ids.start, count));
        self.dropped += (mesh.indices.len() - moving.count) as u64;
        self.absent.extend(moving.dropped());
        if moving.count > 0 {
            input.push(Item::MovingMesh(self.moving.len() as u32), &moving.bounds);
            // One of them stands among the references.
            self.collected += moving.count - 1;
            self.moving.push(moving);
        }
    }

    fn collect_patches(&mut self, geometry: u32, mesh: &PatchMesh, input: &mut TreeInput) {
        let ids = self.names.ids(geometry);
        let mut kinds = Vec::with_capacity(mesh.indices.len());
        let start = input.references.len();
        for (primitive, indices) in mesh.indices.iter().enumerate() {
            let corners = vertices(&mesh.positions, *indices);
            let kind = corners.map_or(PatchKind::Degenerate, |corners| patch::classify(&corners));
            kinds.push(kind);
            let is_full = 2 * primitive + 1 >= ids.len() || input.references.len() - start + 2 > self.space();
            let id = |upper: bool| ids.start + 2 * primitive as u32 + u32::from(upper);
            match (corners, kind) {
                (Some(corners), PatchKind::Planar | PatchKind::Parallelogram) if !is_full => {
                    for (half, upper) in patch::halves(&corners).into_iter().zip([false, true]) {
                        if has_area(&half) {
                            input.push(Item::Triangle(id(upper)), &Bounds3::from_points(half));
                        } else {
                            self.absent.push(id(upper));
                        }
                    }
                }
                (Some(corners), PatchKind::Curved) if !is_full => {
                    input.push(Item::Patch(self.patches.len() as u32), &patch::curved_bounds(&corners));
                    self.patches.push(CurvedPatch { corners, id: id(false) });
                }
                _ => self.dropped += 1,
            }
        }
        self.names.set_patch_kinds(geometry, kinds);
    }

    /// How a patch is traced.
    #[inline]
    pub(crate) fn patch_kind(&self, geometry: u32, primitive: u32) -> PatchKind {
        match self.names.shape(geometry) {
            Some(Shape::Patches(kinds)) => kinds.get(primitive as usize).copied(),
            _ => None,
        }
        .unwrap_or(PatchKind::Degenerate)
    }

    fn collect_quadric(&mut self, geometry: u32, shape: &Geometry, input: &mut TreeInput) {
        let ids = self.names.ids(geometry);
        let prepared = Quadric::new(shape, ids.start).map(|quadric| (quadric.bounds(), quadric));
        match prepared {
            Some((bounds, quadric)) if are_usable(&bounds) && !ids.is_empty() && self.space() > 0 => {
                let place = self.quadrics.len() as u32;
                self.names.set_quadric(geometry, place);
                input.push(Item::Quadric(place), &bounds);
                self.quadrics.push(quadric);
            }
            _ => self.dropped += 1,
        }
    }
}

impl Primitives {
    /// Adds a reference to each part of each segment.
    fn collect_curves(&mut self, geometry: u32, set: &CurveSet, input: &mut TreeInput) {
        let ids = self.names.ids(geometry);
        let (curves, start) = (Curves::new(set), input.references.len());
        let place = self.curves.len() as u32;
        self.names.set_curves(geometry, place);
        for offset in 0..curves.len() {
            let is_full = offset >= ids.len() || input.references.len() - start >= self.space();
            match curves.bounds(offset as u32).filter(|bounds| are_usable(bounds) && !is_full) {
                Some(bounds) => {
                    input.push(Item::Curve(self.curve_parts.len() as u32), &bounds);
                    let offset = offset as u32;
                    self.curve_parts.push(CurvePart { curves: place, offset, id: ids.start + offset });
                }
                None => self.dropped += 1,
            }
        }
        self.curves.push(curves);
    }

    /// The box about a part of a curve.
    pub(crate) fn curve_bounds(&self, place: u32) -> Bounds3 {
        let part = &self.curve_parts[place as usize];
        self.curves[part.curves as usize].bounds(part.offset).unwrap_or(Bounds3::EMPTY)
    }

    /// The nearest hit of a part of a curve up to `limit`.
    #[inline]
    pub(crate) fn curve_candidate(&self, place: u32, ray: &PreparedRay, limit: f32) -> Option<Candidate> {
        let part = &self.curve_parts[place as usize];
        let curves = &self.curves[part.curves as usize];
        curves.intersect(ray.ray(), part.offset, limit).map(|hit| Candidate {
            t: hit.t,
            id: part.id,
            weights: [hit.u, hit.v],
        })
    }
}

impl TreeInput {
    /// Takes the references from `start` on into the extent and removes those that are [`Reference::NONE`]; returns how many
    /// these were.
    fn admit(&mut self, start: usize) -> u64 {
        let added = self.references[start..].par_chunks(CHUNK);
        let extent = added.map(Extent::of).reduce(|| Extent::EMPTY, Extent::union);
        self.extent = self.extent.union(extent);
        let added = &mut self.references[start..];
        let Some(first) = added.iter().position(Reference::is_none) else { return 0 };
        let mut end = first;
        for place in first..added.len() {
            let reference = added[place];
            added[end] = reference;
            end += usize::from(!reference.is_none());
        }
        let dropped = added.len() - end;
        self.references.truncate(start + end);
        dropped as u64
    }
}

/// The vertices of a primitive; `None` if an index is out of range or a coordinate is not finite or too
/// large to compute with.
#[inline]
pub(crate) fn vertices<const N: usize>(positions: &[Vec3], indices: [u32; N]) -> Option<[Vec3; N]> {
    let mut found = [Vec3::ZERO; N];
    for (vertex, index) in found.iter_mut().zip(indices) {
        *vertex = *positions.get(index as usize)?;
    }
    found.iter().all(|&vertex| is_usable(vertex)).then_some(found)
}

/// Whether a triangle has an area other than zero; no if a coordinate is NaN.
#[inline]
pub(crate) fn has_area(vertices: &[Vec3; 3]) -> bool {
    let [p0, p1, p2] = vertices.map(DVec3::from);
    let n = (p1 - p0).cross(p2 - p0);
    // Beyond the range of `f32` only where the vertices are.
    n.dot(n) > 0.0
}

/// Whether all coordinates are numbers that can be computed with.
#[inline]
pub(crate) fn is_usable(p: Vec3) -> bool {
    p.x.abs() <= MAX_COORDINATE && p.y.abs() <= MAX_COORDINATE && p.z.abs() <= MAX_COORDINATE
}

pub(crate) fn are_usable(bounds: &Bounds3) -> bool {
    is_usable(bounds.min) && is_usable(bounds.max)
}

impl Primitives {
    /// The hit of a curved patch.
    #[inline]
    pub(crate) fn patch_candidate(&self, place: u32, ray: &PreparedRay) -> Option<Candidate> {
        let curved = &self.patches[place as usize];
        patch::intersect(ray.ray(), ray.shear(), &curved.corners).map(|hit| Candidate {
            t: hit.t,
            id: curved.id,
            weights: [hit.u, hit.v],
        })
    }

    /// The hit of a quadric.
    #[inline]
    pub(crate) fn quadric_candidate(&self, place: u32, ray: &PreparedRay) -> Option<Candidate> {
        let quadric = &self.quadrics[place as usize];
        quadric.intersect(ray.ray()).map(|t| Candidate { t, id: quadric.id, weights: [0.0; 2] })
    }
}
