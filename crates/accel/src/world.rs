//! What an acceleration structure is built from: plain values that refer to each other by index.
//!
//! Deliberately absent: materials, textures, names, and anything else that does not decide where a ray ends.

use std::borrow::Cow;
use std::sync::Arc;

use sahl_math::{AnimatedTransform, Transform, Vec3};

use crate::motion::Weights;

/// A shape, or a mesh of many.
#[derive(Clone, Debug)]
pub enum Geometry {
    /// Flat triangles.
    Triangles(TriangleMesh),
    /// Flat triangles that move while the shutter is open.
    MovingTriangles(MovingTriangleMesh),
    /// Bilinear patches.
    Patches(PatchMesh),
    /// A sphere, whole or partial.
    Sphere(Sphere),
    /// A disk, a ring, or a sector of one.
    Disk(Disk),
    /// A cylinder without caps, whole or partial.
    Cylinder(Cylinder),
    /// Curves with a width.
    Curves(CurveSet),
}

/// Triangles over shared vertices, in the space of the world or of the group that holds them.
#[derive(Clone, Debug)]
pub struct TriangleMesh {
    /// Vertex indices, three a triangle.
    pub indices: Arc<[[u32; 3]]>,
    /// Vertices.
    pub positions: Arc<[Vec3]>,
}

/// Triangles over shared vertices that go along straight lines at constant speed while the shutter is open, in the space of the world or of
/// the group that holds them.
#[derive(Clone, Debug)]
pub struct MovingTriangleMesh {
    /// Vertex indices, three a triangle.
    pub indices: Arc<[[u32; 3]]>,
    /// Vertices when the shutter opens, and when it closes.
    pub positions: [Arc<[Vec3]>; 2],
}

impl MovingTriangleMesh {
    /// The vertices of a triangle at a time, a fraction of the time that the shutter is open: as rays meet it, to the last bit. `None` if
    /// there is no such triangle.
    pub fn triangle_at(&self, triangle: u32, time: f32) -> Option<[Vec3; 3]> {
        self.ends(triangle as usize).map(|ends| Weights::at(time).triangle(&ends))
    }

    /// The vertices of a triangle at both ends of its motion.
    pub(crate) fn ends(&self, triangle: usize) -> Option<[[Vec3; 3]; 2]> {
        let indices = self.indices.get(triangle)?;
        let mut ends = [[Vec3::ZERO; 3]; 2];
        for (vertices, positions) in ends.iter_mut().zip(&self.positions) {
            for (vertex, &index) in vertices.iter_mut().zip(indices) {
                *vertex = *positions.get(index as usize)?;
            }
        }
        Some(ends)
    }
}

/// Bilinear patches over shared vertices, in the space of the world or of the group that holds them.
///
/// The point at `(u, v)` is `(1−u)(1−v) p₀₀ + u (1−v) p₁₀ + (1−u) v p₀₁ + u v p₁₁`.
#[derive(Clone, Debug)]
pub struct PatchMesh {
    /// Vertex indices, four a patch, in the order `(u, v)` = 00, 10, 01, 11.
    pub indices: Arc<[[u32; 4]]>,
    /// Vertices.
    pub positions: Arc<[Vec3]>,
}

/// The sphere about the origin, cut at two heights and at an angle about z.
///
/// `u = φ / φ_max` with φ counted from +x to +y; `v` runs from 0 at `z_min` to 1 at `z_max`, linear in the polar angle.
#[derive(Clone, Debug)]
pub struct Sphere {
    /// The radius, positive.
    pub radius: f32,
    /// One cut; the two are put in order and clamped to ± `radius`.
    pub z_min: f32,
    /// The other cut.
    pub z_max: f32,
    /// The largest azimuth in radians; clamped to at most 2π.
    pub phi_max: f32,
    /// From the sphere's own space to the world or the group.
    pub to_parent: Transform,
}

/// The cylinder about z without caps, cut at an angle about z.
///
/// `u = φ / φ_max` with φ counted from +x to +y; `v` runs linearly from 0 at `z_min` to 1 at `z_max`.
#[derive(Clone, Debug)]
pub struct Cylinder {
    /// The radius, positive.
    pub radius: f32,
    /// One end; the two are put in order.
    pub z_min: f32,
    /// The other end.
    pub z_max: f32,
    /// The largest azimuth in radians; clamped to at most 2π.
    pub phi_max: f32,
    /// From the cylinder's own space to the world or the group.
    pub to_parent: Transform,
}

/// The disk in the plane `z = height`, with a hole if `inner_radius` is positive, cut at an angle about z.
///
/// `u = φ / φ_max` with φ counted from +x to +y; `v` runs linearly from 0 at `radius` to 1 at `inner_radius`.
#[derive(Clone, Debug)]
pub struct Disk {
    /// The plane's z.
    pub height: f32,
    /// The outer radius, positive.
    pub radius: f32,
    /// The radius of the hole, at least zero and less than `radius`.
    pub inner_radius: f32,
    /// The largest azimuth in radians; clamped to at most 2π.
    pub phi_max: f32,
    /// From the disk's own space to the world or the group.
    pub to_parent: Transform,
}

/// Cubic Bézier segments with a width, all of one kind. A segment without length or width, or without a normal that it needs,
/// is left out.
///
/// What a ray meets is a strip about the segment. `u` runs along a segment and `v` from 0 to 1 across it, such that ∂p/∂u × ∂p/∂v
/// points away from where the ray comes from; see [`CurveKind`] for ribbons.
#[derive(Clone, Debug)]
pub struct CurveSet {
    /// What the segments look like from the side.
    pub kind: CurveKind,
    /// Control points of each segment.
    pub points: Arc<[[Vec3; 4]]>,
    /// Width of each segment at its start and at its end, linear in `u` between; not negative.
    pub widths: Arc<[[f32; 2]]>,
    /// Normals of each segment at its start and at its end, for ribbons alone; of any length.
    pub normals: Arc<[[Vec3; 2]]>,
    /// Each segment is boxed in `2^split_depth` parts, of which there are at most 64. Decides about speed and memory alone.
    pub split_depth: u32,
    /// From the curves' own space to the world or the group. Widths are those of the own space.
    pub to_parent: Transform,
}

/// The cross-section of curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveKind {
    /// A strip that faces every ray.
    Flat,
    /// A strip that faces every ray, with the normals of half a tube.
    Cylinder,
    /// A strip with a normal of its own, which appears the narrower the more it is seen from the side. `∂p/∂u × ∂p/∂v` is the normal.
    Ribbon,
}

/// One placement of a group in the world.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Which group.
    pub group: u32,
    /// From the group's space to the world.
    pub to_world: Placement,
}

/// Where an instance stands, or how it moves while the shutter is open.
#[derive(Clone, Debug)]
pub enum Placement {
    /// It stands still.
    Still(Transform),
    /// It moves.
    Moving(Box<AnimatedTransform>),
}

impl Placement {
    /// The map from the group's space to the world at a time, a fraction of the time that the shutter is open.
    #[inline]
    pub fn at(&self, time: f32) -> Cow<'_, Transform> {
        match self {
            Self::Still(transform) => Cow::Borrowed(transform),
            Self::Moving(motion) => Cow::Owned(motion.at(time)),
        }
    }
}

impl From<Transform> for Placement {
    fn from(transform: Transform) -> Self {
        Self::Still(transform)
    }
}

impl From<AnimatedTransform> for Placement {
    fn from(motion: AnimatedTransform) -> Self {
        Self::Moving(Box::new(motion))
    }
}

/// Everything that rays can hit. All `u32` are indices: of `geometries`, except [`Instance::group`].
#[derive(Clone, Debug, Default)]
pub struct World {
    /// Shapes and meshes.
    pub geometries: Vec<Geometry>,
    /// The geometries that stand in the world itself.
    pub world: Vec<u32>,
    /// Sets of geometries that share a space of their own, to be placed by instances.
    pub groups: Vec<Vec<u32>>,
    /// Placements of groups.
    pub instances: Vec<Instance>,
    /// The geometries that filters are asked about, in whatever set they stand; all others are opaque.
    pub filtered: Vec<u32>,
}
