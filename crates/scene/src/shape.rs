//! Shapes.

use std::sync::Arc;

use sahl_math::{AnimatedTransform, Transform, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use crate::{AreaLight, FloatParam, Handle, Material, MediumInterface};

/// A surface with what it is made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shape {
    /// The surface, in the shape's own space.
    pub geometry: Geometry,
    /// From the shape's own space to the world, or to the object that the shape belongs to.
    pub shape_to_world: Transform,
    /// How it moves while the shutter is open. It takes the place of `shape_to_world`, which is where it stands when the shutter opens.
    pub motion: Option<Box<AnimatedTransform>>,
    /// Whether the normal is turned to the other side.
    pub reverse_orientation: bool,
    /// How it scatters light.
    pub material: Handle<Material>,
    /// What it emits.
    pub area_light: Option<AreaLight>,
    /// The media that it parts; `None` where light stays in the medium through which it came.
    pub media: Option<MediumInterface>,
    /// The share of the surface that is there: rays pass the rest as if it were not. One or more is all, zero or less nothing.
    pub alpha: FloatParam,
}

impl Shape {
    /// An opaque surface that neither emits nor moves, its front where its geometry has it.
    pub fn new(geometry: Geometry, shape_to_world: Transform, material: Handle<Material>) -> Self {
        Self {
            geometry,
            shape_to_world,
            motion: None,
            reverse_orientation: false,
            material,
            area_light: None,
            media: None,
            alpha: FloatParam::Constant(1.0),
        }
    }
}

/// A surface in its own space. Angles are in radians.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Geometry {
    /// Triangles.
    Triangles(Handle<TriangleMesh>),
    /// Bilinear patches.
    Patches(Handle<PatchMesh>),
    /// Curves with a width.
    Curves(Handle<Curves>),
    /// Triangles that are cut until none of their edges is longer than a limit, and whose vertices are then moved along their normals.
    ///
    /// The mesh needs texture coordinates. Its normals, or those of its faces where it has none, say where to, and are not normalised;
    /// the shading normals are those of the faces that result.
    Displaced {
        /// The triangles.
        mesh: Handle<TriangleMesh>,
        /// How far vertices move, in the shape's own space.
        displacement: FloatParam,
        /// Longer edges are cut; in the space into which the shape is placed.
        edge_length: f32,
    },
    /// A sphere about the origin, cut by two planes and a sweep about z.
    Sphere {
        /// Its radius.
        radius: f32,
        /// Lower plane.
        z_min: f32,
        /// Upper plane.
        z_max: f32,
        /// Sweep.
        phi_max: f32,
    },
    /// A disk perpendicular to z.
    Disk {
        /// Its plane, z = height.
        height: f32,
        /// Outer radius.
        radius: f32,
        /// Radius of the hole.
        inner_radius: f32,
        /// Sweep.
        phi_max: f32,
    },
    /// An open cylinder about z.
    Cylinder {
        /// Its radius.
        radius: f32,
        /// Lower end.
        z_min: f32,
        /// Upper end.
        z_max: f32,
        /// Sweep.
        phi_max: f32,
    },
}

/// Faces of `N` vertices that share vertices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "[u32; N]: Serialize", deserialize = "[u32; N]: Deserialize<'de>"))]
pub struct Mesh<const N: usize> {
    /// The vertices of each face.
    pub indices: Arc<[[u32; N]]>,
    /// Position of each vertex.
    pub positions: Arc<[Vec3]>,
    /// Shading normal of each vertex; not necessarily of unit length.
    pub normals: Option<Arc<[Vec3]>>,
    /// Shading tangent of each vertex, of any length; it takes the place of ∂p/∂u of the texture coordinates. Zero leaves that in
    /// force.
    pub tangents: Option<Arc<[Vec3]>>,
    /// Texture coordinates of each vertex.
    pub uvs: Option<Arc<[Vec2]>>,
    /// The number of each face among those that a [`FaceTexture`](crate::FaceTexture) has images for; zero for all if there is none.
    pub face_indices: Option<Arc<[u32]>>,
}

/// Triangles that share vertices.
pub type TriangleMesh = Mesh<3>;

/// Bilinear patches that share vertices: four a patch, at (u, v) = (0,0), (1,0), (0,1), (1,1).
pub type PatchMesh = Mesh<4>;

impl<const N: usize> Default for Mesh<N> {
    fn default() -> Self {
        let (indices, positions): (Vec<[u32; N]>, Vec<Vec3>) = Default::default();
        Self {
            indices: indices.into(),
            positions: positions.into(),
            normals: None,
            tangents: None,
            uvs: None,
            face_indices: None,
        }
    }
}

/// Cubic Bézier segments with a width, all of one kind: hair, grass, wires.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curves {
    /// What they look like from the side.
    pub kind: CurveKind,
    /// Control points of each segment.
    pub points: Arc<[[Vec3; 4]]>,
    /// Width of each segment at its start and at its end.
    pub widths: Arc<[[f32; 2]]>,
    /// Normals of each segment at its start and at its end, of any length; none unless they are ribbons.
    pub normals: Arc<[[Vec3; 2]]>,
    /// Each segment is boxed in `2^split_depth` parts: a hint that changes speed and memory, and no image.
    pub split_depth: u32,
}

/// The cross-section of curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CurveKind {
    /// A strip that faces whoever looks.
    Flat,
    /// A strip that faces whoever looks, shaded as half a tube.
    Cylinder,
    /// A strip that has a normal of its own.
    Ribbon,
}
