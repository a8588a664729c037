//! What a query returns.

use sahl_math::Vec3;

/// Where a ray meets the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The ray's parameter.
    pub t: f32,
    /// Triangles: the barycentric weight of vertex 1. Others: the first surface parameter, in [0, 1].
    pub u: f32,
    /// Triangles: the barycentric weight of vertex 2. Others: the second surface parameter, in [0, 1].
    pub v: f32,
    /// The index of the geometry.
    pub geometry: u32,
    /// The index of the triangle or patch in its mesh; zero for other shapes.
    pub primitive: u32,
    /// The index of the instance, or [`Hit::NO_INSTANCE`].
    pub instance: u32,
}

impl Hit {
    /// Stands for the world itself.
    pub const NO_INSTANCE: u32 = u32::MAX;
}

/// A point on a surface, as precise as it can be known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The point in world space.
    pub p: Vec3,
    /// The absolute error of each coordinate: the surface passes through the box `p ± p_error`, and a ray that
    /// `sahl_math::Ray::spawn` starts outside it on one side of the surface is taken for being there by the intersection tests.
    pub p_error: Vec3,
    /// The unit geometric normal in world space.
    pub n: Vec3,
}
