//! Emitting shapes by kind.

use sahl_math::{Bounds3, Vec2, Vec3};

use crate::light::Cone;

use super::{PatchEmitter, QuadricEmitter, SphereEmitter, TriangleEmitter};

/// A shape in world space that can be sampled from a point.
#[derive(Clone, Debug)]
pub(crate) enum Emitter {
    /// A triangle of a mesh.
    Triangle(TriangleEmitter),
    /// A bilinear patch of a mesh.
    Patch(Box<PatchEmitter>),
    /// A whole sphere that is a sphere in the world too.
    Sphere(SphereEmitter),
    /// Any other quadric: partial, or deformed by its transform.
    Quadric(Box<QuadricEmitter>),
}

/// A point of an emitter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EmitterPoint {
    /// Where it is.
    pub(crate) p: Vec3,
    /// Absolute error bound of each coordinate.
    pub(crate) p_error: Vec3,
    /// Unit normal on the side that emits.
    pub(crate) n: Vec3,
    /// Parameters on a triangle or a patch, as the accelerator has them; other shapes leave them zero when sampled.
    pub(crate) uv: Vec2,
}

impl Emitter {
    /// A point of the shape as seen from `from`, and its density per solid angle; `None` where none can be found.
    #[inline]
    pub(crate) fn sample(&self, from: Vec3, u: Vec2) -> Option<(EmitterPoint, f32)> {
        let (point, pdf) = match self {
            Self::Triangle(triangle) => triangle.sample(from, u),
            Self::Patch(patch) => patch.sample(from, u),
            Self::Sphere(sphere) => sphere.sample(from, u),
            Self::Quadric(quadric) => quadric.sample(from, u),
        };
        (pdf > 0.0 && pdf.is_finite()).then_some((point, pdf))
    }

    /// The density with which [`Emitter::sample`] finds `point` from `from`, per solid angle.
    #[inline]
    pub(crate) fn pdf(&self, from: Vec3, point: &EmitterPoint) -> f32 {
        let pdf = match self {
            Self::Triangle(triangle) => triangle.pdf(from, point),
            Self::Patch(patch) => patch.pdf(from, point),
            Self::Sphere(sphere) => sphere.pdf(from, point),
            Self::Quadric(quadric) => quadric.pdf(from, point),
        };
        if pdf.is_finite() { pdf } else { 0.0 }
    }

    /// Whether the shape is flat, and so large or so slender that a segment of length `distance` to one of its points may be found
    /// to end behind it.
    ///
    /// A triangle is met at the mean of its vertices' depths, weighted by edge functions. Each of these is a product of
    /// coordinates up to R = `distance` + s, where s is the extent of the shape, with differences up to s; it has an
    /// error of some units of ε R s, the depths differ by at most s, and the weights add up to twice the area of the triangle. The error of the
    /// distance to the plane is then some units of ε R s² / 2A, for which [`Ray::spawn_to`](sahl_math::Ray::spawn_to) leaves 16 of
    /// ε `distance`.
    pub(crate) fn may_block_itself(&self, distance: f32) -> bool {
        const UNITS: f32 = 4.0;
        let twice_area = match self {
            Self::Triangle(triangle) => 2.0 * triangle.area(),
            // It is two triangles to the rays.
            Self::Patch(patch) if patch.is_flat() => patch.area(),
            Self::Patch(_) | Self::Sphere(_) | Self::Quadric(_) => return false,
        };
        let extent = self.bounds().diagonal();
        UNITS * (distance + extent.length()) * extent.length_squared() > 16.0 * twice_area * distance
    }

    /// Surface area, in m².
    pub(crate) fn area(&self) -> f32 {
        match self {
            Self::Triangle(triangle) => triangle.area(),
            Self::Patch(patch) => patch.area(),
            Self::Sphere(sphere) => sphere.area(),
            Self::Quadric(quadric) => quadric.area(),
        }
    }

    /// A box about the shape.
    pub(crate) fn bounds(&self) -> Bounds3 {
        match self {
            Self::Triangle(triangle) => triangle.bounds(),
            Self::Patch(patch) => patch.bounds(),
            Self::Sphere(sphere) => sphere.bounds(),
            Self::Quadric(quadric) => quadric.bounds(),
        }
    }

    /// A cone about the normals on the side that emits.
    pub(crate) fn facing(&self) -> Cone {
        match self {
            Self::Triangle(triangle) => triangle.facing(),
            Self::Patch(patch) => patch.facing(),
            Self::Sphere(_) => Cone::ALL,
            Self::Quadric(quadric) => quadric.facing(),
        }
    }
}
