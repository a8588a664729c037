//! What a tree is built over; what cannot be hit is dropped here.

use rayon::prelude::*;
use sahl_math::Bounds3;

use super::{CurvedPatch, Item, MAX_COORDINATE, Primitives, are_usable, has_area, vertices};
use crate::build::{Box8, Extent, Reference};
use crate::geometry::curve::{CurvePart, Curves};
use crate::geometry::patch::{self, PatchKind};
use crate::geometry::quadric::Quadric;
use crate::instance::PlacedGroup;
use crate::kernel::prefer_large_pages;
use crate::layout::MAX_PLACE;
use crate::motion::MovingMesh;
use crate::world::{CurveSet, Geometry, MovingTriangleMesh, PatchMesh, TriangleMesh, World};

/// Primitives beyond this count are dropped: in full leaves, there are places for the rows of so many, see [`crate::layout`].
const MAX_PRIMITIVES: usize = 1 << 27;

const _: () = assert!(MAX_PRIMITIVES - 1 <= MAX_PLACE as usize);

/// How many primitives one task prepares.
const CHUNK: usize = 1 << 12;

/// How many primitives are prepared before their extent is found.
const PORTION: usize = 1 << 15;

/// So many times the memory that references need is asked for: for parts of them, and for the rows of the tree that may take the memory
/// over. To grow would mean to copy, and memory that is not used is not given.
const ROOM: usize = 2;

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

    /// Takes the references from `start` on into the extent and removes those that are [`Reference::NONE`]; returns how far behind
    /// `start` these stood.
    fn admit(&mut self, start: usize) -> Vec<u32> {
        let added = self.references[start..].par_chunks(CHUNK);
        let extent = added.map(Extent::of).reduce(|| Extent::EMPTY, Extent::union);
        self.extent = self.extent.union(extent);
        let added = &mut self.references[start..];
        let Some(first) = added.iter().position(Reference::is_none) else { return Vec::new() };
        let (mut end, mut dropped) = (first, Vec::new());
        for place in first..added.len() {
            let reference = added[place];
            added[end] = reference;
            if reference.is_none() {
                dropped.push(place as u32);
            } else {
                end += 1;
            }
        }
        self.references.truncate(start + end);
        dropped
    }
}

impl Primitives {
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
            self.dropped += dropped.len() as u64;
            let is_absent = |offset: &u32| {
                let corners = vertices(&mesh.positions, faces[*offset as usize]);
                !corners.is_some_and(|corners| has_area(&corners))
            };
            let first = ids.start + (portion * PORTION) as u32;
            self.absent.extend(dropped.into_iter().filter(is_absent).map(|offset| first + offset));
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
}
