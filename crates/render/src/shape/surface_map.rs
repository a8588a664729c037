//! Texture coordinates of points that were sampled on an emitter, as a hit there would have them.

use std::f32::consts::TAU;

use sahl_math::{Transform, Vec2, Vec3, safe_acos};

use super::{EmitterPoint, QuadricShape};
use crate::warp;

/// From a point of a primitive to its texture coordinates.
#[derive(Clone, Debug)]
pub(crate) enum SurfaceMap {
    /// The coordinates at the corners of a triangle.
    Triangle([Vec2; 3]),
    /// Those at the corners of a patch, at (u, v) = (0,0), (1,0), (0,1), (1,1).
    Patch([Vec2; 4]),
    /// The parameters of a quadric.
    Quadric {
        /// The quadric in its own space.
        shape: QuadricShape,
        /// To its own space.
        from_world: Transform,
    },
}

impl SurfaceMap {
    /// What a triangle without coordinates has.
    pub(crate) const PLAIN_TRIANGLE: Self = Self::Triangle([Vec2::ZERO, Vec2::new(1.0, 0.0), Vec2::ONE]);
    /// What a patch without coordinates has: its parameters.
    pub(crate) const PLAIN_PATCH: Self =
        Self::Patch([Vec2::ZERO, Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0), Vec2::ONE]);

    /// The coordinates of a point of the emitter.
    pub(crate) fn uv(&self, point: &EmitterPoint) -> Vec2 {
        match self {
            Self::Triangle(_) | Self::Patch(_) => self.blend(point.uv),
            Self::Quadric { shape, from_world } => shape.parameters(from_world.point(point.p)),
        }
    }

    /// The coordinates of a point of the primitive, over all of which it goes as `u` goes over the unit square.
    pub(crate) fn uv_of_square(&self, u: Vec2) -> Vec2 {
        match self {
            Self::Triangle(_) => {
                let [b0, b1] = warp::uniform_triangle(u);
                self.blend(Vec2::new(b1, 1.0 - b0 - b1))
            }
            Self::Patch(_) => self.blend(u),
            Self::Quadric { shape, .. } => shape.parameters(shape.sample(u).0),
        }
    }

    /// Between the corners, by the parameters of the primitive.
    fn blend(&self, Vec2 { x: u, y: v }: Vec2) -> Vec2 {
        match *self {
            Self::Triangle([a, b, c]) => a * (1.0 - u - v) + b * u + c * v,
            Self::Patch([a, b, c, d]) => {
                a * ((1.0 - u) * (1.0 - v)) + b * (u * (1.0 - v)) + c * ((1.0 - u) * v) + d * (u * v)
            }
            Self::Quadric { .. } => Vec2::new(u, v),
        }
    }
}

impl QuadricShape {
    /// The parameters of a point of the surface, in [0, 1]², as pbrt has them.
    fn parameters(&self, p: Vec3) -> Vec2 {
        let azimuth = p.y.atan2(p.x);
        let azimuth = if azimuth < 0.0 { azimuth + TAU } else { azimuth };
        let radial = p.x.hypot(p.y);
        let (v, phi_max) = match *self {
            Self::Sphere { radius, z_min, z_max, phi_max } => {
                let polar = |z: f32| safe_acos(z / radius);
                ((radial.atan2(p.z) - polar(z_min)) / (polar(z_max) - polar(z_min)), phi_max)
            }
            Self::Disk { radius, inner_radius, phi_max, .. } => {
                ((radius - radial) / (radius - inner_radius), phi_max)
            }
            Self::Cylinder { z_min, z_max, phi_max, .. } => ((p.z - z_min) / (z_max - z_min), phi_max),
        };
        Vec2::new((azimuth / phi_max).min(1.0), v.clamp(0.0, 1.0))
    }
}
