//! Shapes.

use std::sync::Arc;

use sahl_math::{Transform, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use crate::{AreaLight, Handle, Material, MediumInterface};

/// A surface with what it is made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shape {
    /// The surface, in the shape's own space.
    pub geometry: Geometry,
    /// From the shape's own space to the world, or to the object that the shape belongs to.
    pub shape_to_world: Transform,
    /// Whether the normal is turned to the other side.
    pub reverse_orientation: bool,
    /// How it scatters light.
    pub material: Handle<Material>,
    /// What it emits.
    pub area_light: Option<AreaLight>,
    /// The media that it parts; `None` where light stays in the medium through which it came.
    pub media: Option<MediumInterface>,
}

/// A surface in its own space. Angles are in radians.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Geometry {
    /// Triangles.
    Triangles(Handle<TriangleMesh>),
    /// Bilinear patches.
    Patches(Handle<PatchMesh>),
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

/// Triangles that share vertices.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TriangleMesh {
    /// Three vertices a triangle.
    pub indices: Arc<[[u32; 3]]>,
    /// Position of each vertex.
    pub positions: Arc<[Vec3]>,
    /// Shading normal of each vertex; not necessarily of unit length.
    pub normals: Option<Arc<[Vec3]>>,
    /// Texture coordinates of each vertex.
    pub uvs: Option<Arc<[Vec2]>>,
}

/// Bilinear patches that share vertices.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PatchMesh {
    /// Four vertices a patch, at (u, v) = (0,0), (1,0), (0,1), (1,1).
    pub indices: Arc<[[u32; 4]]>,
    /// Position of each vertex.
    pub positions: Arc<[Vec3]>,
    /// Shading normal of each vertex; not necessarily of unit length.
    pub normals: Option<Arc<[Vec3]>>,
    /// Texture coordinates of each vertex.
    pub uvs: Option<Arc<[Vec2]>>,
}
