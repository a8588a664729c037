//! From a world to the flat lists that builders and kernels work on.

mod collect;

use std::ops::Range;

use sahl_math::{Bounds3, Vec3};

use crate::geometry::curve::{CurvePart, Curves};
use crate::geometry::double::DVec3;
use crate::geometry::patch::{self, Corners, PatchKind};
use crate::geometry::quadric::Quadric;
use crate::motion::MovingMesh;
use crate::names::{Names, PrimitiveName, Shape};
use crate::traverse::{Candidate, PreparedRay};
use crate::world::{Geometry, World};
pub(crate) use collect::TreeInput;

/// Primitives that reach beyond this coordinate are dropped as if it were infinite: the tests square coordinates in `f32`.
const MAX_COORDINATE: f32 = 1e18;

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
            + size_of_val(self.curve_parts.as_slice())
            + size_of_val(self.absent.as_slice())
            + size_of_val(self.absent_instances.as_slice());
        let moving = self.moving.iter().map(|mesh| mesh.bytes() + size_of_val(mesh) as u64).sum::<u64>();
        self.names.bytes() + lists as u64 + moving
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
        curves.intersect(&ray.ray(), part.offset, limit).map(|hit| Candidate {
            t: hit.t,
            id: part.id,
            weights: [hit.u, hit.v],
        })
    }

    /// The hit of a curved patch.
    #[inline]
    pub(crate) fn patch_candidate(&self, place: u32, ray: &PreparedRay) -> Option<Candidate> {
        let curved = &self.patches[place as usize];
        patch::intersect(&ray.ray(), &ray.shear(), &curved.corners).map(|hit| Candidate {
            t: hit.t,
            id: curved.id,
            weights: [hit.u, hit.v],
        })
    }

    /// The hit of a quadric.
    #[inline]
    pub(crate) fn quadric_candidate(&self, place: u32, ray: &PreparedRay) -> Option<Candidate> {
        let quadric = &self.quadrics[place as usize];
        quadric.intersect(&ray.ray()).map(|t| Candidate { t, id: quadric.id, weights: [0.0; 2] })
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
