//! From a world to the flat lists that builders and kernels work on; what cannot be hit is dropped here.

use sahl_math::{Bounds3, Vec3};

use crate::geometry::double::DVec3;
use crate::geometry::patch::{self, Corners, PatchKind};
use crate::geometry::quadric::Quadric;
use crate::instance::PlacedGroup;
use crate::traverse::{Candidate, PreparedRay};
use crate::world::{Geometry, PatchMesh, TriangleMesh, World};

/// Primitives beyond this count are dropped: node and leaf references hold their place in 27 bits.
const MAX_PRIMITIVES: usize = 1 << 27;

/// Primitives that reach beyond this coordinate are dropped as if it were infinite: the tests square coordinates in `f32`.
const MAX_COORDINATE: f32 = 1e18;

/// Stands for no place among the quadrics.
const NO_QUADRIC: u32 = u32::MAX;

/// What a primitive is to the traversal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A triangle of a mesh.
    Triangle,
    /// The half `p₀₀ p₁₁ p₀₁` (upper) or `p₀₀ p₁₀ p₁₁` of a planar patch.
    Half { upper: bool, parallelogram: bool },
    /// A patch that is not planar.
    Patch,
    /// A sphere, cylinder or disk.
    Quadric,
}

/// The name of a primitive. Its place in the list is its id; ids ascend with (geometry, primitive).
#[derive(Clone, Copy, Debug)]
pub(crate) struct PrimitiveName {
    pub(crate) geometry: u32,
    pub(crate) primitive: u32,
    pub(crate) kind: Kind,
}

/// A primitive that a tree holds.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Item {
    /// A triangle or half of a planar patch: an id.
    Triangle(u32),
    /// A place in [`Primitives::patches`].
    Patch(u32),
    /// A place in [`Primitives::quadrics`].
    Quadric(u32),
    /// A place in the list of placed groups.
    Instance(u32),
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
    pub(crate) names: Vec<PrimitiveName>,
    pub(crate) patches: Vec<CurvedPatch>,
    pub(crate) quadrics: Vec<Quadric>,
    /// For each geometry, its place in `quadrics`; [`NO_QUADRIC`] for others.
    quadric_places: Vec<u32>,
    /// For each geometry that is a mesh of patches, how they are traced.
    patch_kinds: Vec<Vec<PatchKind>>,
    /// How many were left out.
    pub(crate) dropped: u64,
}

/// What one tree is built over: parallel lists.
#[derive(Clone, Debug, Default)]
pub(crate) struct TreeInput {
    pub(crate) items: Vec<Item>,
    pub(crate) bounds: Vec<Bounds3>,
    pub(crate) centers: Vec<Vec3>,
}

impl TreeInput {
    /// The box about everything.
    pub(crate) fn total_bounds(&self) -> Bounds3 {
        self.bounds.iter().copied().fold(Bounds3::EMPTY, Bounds3::union)
    }

    fn push(&mut self, item: Item, bounds: Bounds3) {
        self.items.push(item);
        self.bounds.push(bounds);
        self.centers.push(bounds.center());
    }
}

impl Primitives {
    /// No primitives yet, of a world with this many geometries.
    pub(crate) fn for_geometries(count: usize) -> Self {
        Self {
            quadric_places: vec![NO_QUADRIC; count],
            patch_kinds: vec![Vec::new(); count],
            ..Self::default()
        }
    }

    /// The prepared quadric of a geometry that is one.
    #[inline]
    pub(crate) fn quadric(&self, geometry: u32) -> Option<&Quadric> {
        self.quadrics.get(*self.quadric_places.get(geometry as usize)? as usize)
    }

    /// The memory of the lists in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let lists = size_of_val(self.names.as_slice()) + size_of_val(self.patches.as_slice());
        let kinds: usize = self.patch_kinds.iter().map(|kinds| size_of_val(kinds.as_slice())).sum();
        (lists + kinds + size_of_val(self.quadrics.as_slice()) + size_of_val(self.quadric_places.as_slice()))
            as u64
    }

    /// Collects the primitives of one set of geometries: those of the world or of one group.
    ///
    /// Indices out of range and repeated ones are left out; the former are counted.
    pub(crate) fn collect(&mut self, world: &World, geometries: &[u32]) -> TreeInput {
        let mut input = TreeInput::default();
        let mut sorted = geometries.to_vec();
        sorted.sort_unstable();
        sorted.dedup();
        for index in sorted {
            match world.geometries.get(index as usize) {
                Some(Geometry::Triangles(mesh)) => self.collect_triangles(index, mesh, &mut input),
                Some(Geometry::Patches(mesh)) => self.collect_patches(index, mesh, &mut input),
                Some(quadric) => self.collect_quadric(index, quadric, &mut input),
                None => self.dropped += 1,
            }
        }
        input
    }

    /// Adds placed groups to the input of the world's tree; those that hold nothing are left out.
    pub(crate) fn collect_instances(&mut self, placed: &[PlacedGroup], input: &mut TreeInput) {
        for (place, group) in placed.iter().enumerate() {
            let bounds = group.bounds();
            if bounds.is_empty() || !are_usable(&bounds) || self.is_full(input) {
                self.dropped += 1;
            } else {
                input.push(Item::Instance(place as u32), bounds);
            }
        }
    }

    fn is_full(&self, input: &TreeInput) -> bool {
        self.names.len() >= MAX_PRIMITIVES || input.items.len() >= MAX_PRIMITIVES
    }

    fn name(&mut self, geometry: u32, primitive: usize, kind: Kind) -> u32 {
        let id = self.names.len() as u32;
        self.names.push(PrimitiveName { geometry, primitive: primitive as u32, kind });
        id
    }

    fn collect_triangles(&mut self, geometry: u32, mesh: &TriangleMesh, input: &mut TreeInput) {
        self.names.reserve(mesh.indices.len());
        input.items.reserve(mesh.indices.len());
        for (primitive, indices) in mesh.indices.iter().enumerate() {
            match vertices(&mesh.positions, *indices).filter(has_area) {
                Some(vertices) if !self.is_full(input) => {
                    let id = self.name(geometry, primitive, Kind::Triangle);
                    input.push(Item::Triangle(id), Bounds3::from_points(vertices));
                }
                _ => self.dropped += 1,
            }
        }
    }

    fn collect_patches(&mut self, geometry: u32, mesh: &PatchMesh, input: &mut TreeInput) {
        let mut kinds = Vec::with_capacity(mesh.indices.len());
        for (primitive, indices) in mesh.indices.iter().enumerate() {
            let corners = vertices(&mesh.positions, *indices);
            let kind = corners.map_or(PatchKind::Degenerate, |corners| patch::classify(&corners));
            kinds.push(kind);
            match (corners, kind) {
                (Some(corners), PatchKind::Planar | PatchKind::Parallelogram) if !self.is_full(input) => {
                    let parallelogram = kind == PatchKind::Parallelogram;
                    for (half, upper) in patch::halves(&corners).into_iter().zip([false, true]) {
                        if has_area(&half) {
                            let id = self.name(geometry, primitive, Kind::Half { upper, parallelogram });
                            input.push(Item::Triangle(id), Bounds3::from_points(half));
                        }
                    }
                }
                (Some(corners), PatchKind::Curved) if !self.is_full(input) => {
                    let id = self.name(geometry, primitive, Kind::Patch);
                    input.push(Item::Patch(self.patches.len() as u32), patch::curved_bounds(&corners));
                    self.patches.push(CurvedPatch { corners, id });
                }
                _ => self.dropped += 1,
            }
        }
        self.patch_kinds[geometry as usize] = kinds;
    }

    /// How a patch is traced.
    #[inline]
    pub(crate) fn patch_kind(&self, geometry: u32, primitive: u32) -> PatchKind {
        let kinds = self.patch_kinds.get(geometry as usize);
        kinds.and_then(|kinds| kinds.get(primitive as usize)).copied().unwrap_or(PatchKind::Degenerate)
    }

    fn collect_quadric(&mut self, geometry: u32, shape: &Geometry, input: &mut TreeInput) {
        let id = self.names.len() as u32;
        let prepared = Quadric::new(shape, id).map(|quadric| (quadric.bounds(), quadric));
        match prepared {
            Some((bounds, quadric)) if are_usable(&bounds) && !self.is_full(input) => {
                self.name(geometry, 0, Kind::Quadric);
                self.quadric_places[geometry as usize] = self.quadrics.len() as u32;
                input.push(Item::Quadric(self.quadrics.len() as u32), bounds);
                self.quadrics.push(quadric);
            }
            _ => self.dropped += 1,
        }
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

/// Whether a triangle has an area other than zero.
fn has_area(vertices: &[Vec3; 3]) -> bool {
    let [p0, p1, p2] = vertices.map(DVec3::from);
    let n = (p1 - p0).cross(p2 - p0);
    n.x != 0.0 || n.y != 0.0 || n.z != 0.0
}

/// Whether all coordinates are numbers that can be computed with.
#[inline]
fn is_usable(p: Vec3) -> bool {
    p.x.abs() <= MAX_COORDINATE && p.y.abs() <= MAX_COORDINATE && p.z.abs() <= MAX_COORDINATE
}

fn are_usable(bounds: &Bounds3) -> bool {
    is_usable(bounds.min) && is_usable(bounds.max)
}

impl Primitives {
    /// The hit of a curved patch.
    #[inline]
    pub(crate) fn patch_candidate(&self, place: u32, ray: &PreparedRay) -> Option<Candidate> {
        let curved = &self.patches[place as usize];
        patch::intersect(&ray.ray, &ray.shear, &curved.corners).map(|hit| Candidate {
            t: hit.t,
            id: curved.id,
            weights: [hit.u, hit.v],
        })
    }

    /// The hit of a quadric.
    #[inline]
    pub(crate) fn quadric_candidate(&self, place: u32, ray: &PreparedRay) -> Option<Candidate> {
        let quadric = &self.quadrics[place as usize];
        quadric.intersect(&ray.ray).map(|t| Candidate { t, id: quadric.id, weights: [0.0; 2] })
    }
}
