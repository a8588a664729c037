//! Emitting disks and cylinders, and spheres that are partial or deformed.
//!
//! They are sampled uniformly in their own space; an affine map changes the density per area by
//! |det M| |M⁻ᵀ n|, which depends on the normal alone.

use std::f32::consts::{PI, TAU};

use sahl_math::{Bounds3, Transform, Vec2, Vec3, gamma, lerp, safe_sqrt};

use super::patch::mean_over_square;
use super::{EmitterPoint, per_solid_angle};
use crate::light::Cone;
use crate::warp;

/// A quadric in its own space; lengths in metres there, angles in radians.
#[derive(Clone, Copy, Debug)]
pub(crate) enum QuadricShape {
    /// The part of a sphere between two planes.
    Sphere { radius: f32, z_min: f32, z_max: f32, phi_max: f32 },
    /// A ring or its sector.
    Disk { height: f32, radius: f32, inner_radius: f32, phi_max: f32 },
    /// A tube or its sector.
    Cylinder { radius: f32, z_min: f32, z_max: f32, phi_max: f32 },
}

/// A quadric in the world, sampled by area.
#[derive(Clone, Debug)]
pub(crate) struct QuadricEmitter {
    shape: QuadricShape,
    to_world: Transform,
    from_world: Transform,
    /// |det M|.
    determinant: f32,
    flip: bool,
    area: f32,
}

impl QuadricShape {
    /// The surface area in its own space.
    fn area(&self) -> f32 {
        match *self {
            Self::Sphere { radius, z_min, z_max, phi_max }
            | Self::Cylinder { radius, z_min, z_max, phi_max } => phi_max * radius * (z_max - z_min),
            Self::Disk { radius, inner_radius, phi_max, .. } => {
                0.5 * phi_max * (radius * radius - inner_radius * inner_radius)
            }
        }
    }

    /// A point uniform by area, and its unit normal.
    #[inline]
    pub(super) fn sample(&self, u: Vec2) -> (Vec3, Vec3) {
        match *self {
            Self::Sphere { radius, z_min, z_max, phi_max } => {
                let z = lerp(u.x, z_min, z_max);
                let (sin, cos) = (phi_max * u.y).sin_cos();
                let r = safe_sqrt(radius * radius - z * z);
                let p = Vec3::new(r * cos, r * sin, z);
                (p, p / radius)
            }
            Self::Cylinder { radius, z_min, z_max, phi_max } => {
                let (sin, cos) = (phi_max * u.y).sin_cos();
                (Vec3::new(radius * cos, radius * sin, lerp(u.x, z_min, z_max)), Vec3::new(cos, sin, 0.0))
            }
            Self::Disk { height, radius, inner_radius, phi_max } => {
                let p = if inner_radius == 0.0 && phi_max == TAU {
                    warp::concentric_disk(u) * radius
                } else {
                    let r = lerp(u.x, inner_radius * inner_radius, radius * radius).sqrt();
                    let (sin, cos) = (phi_max * u.y).sin_cos();
                    Vec2::new(r * cos, r * sin)
                };
                (Vec3::new(p.x, p.y, height), Vec3::Z)
            }
        }
    }
}

impl QuadricEmitter {
    /// The shape placed by `to_world`. Normals point outwards, for a disk along +z, and inwards if `flip`.
    pub(crate) fn new(shape: QuadricShape, to_world: &Transform, flip: bool) -> Self {
        let mut emitter = Self {
            shape,
            to_world: *to_world,
            from_world: to_world.inverse(),
            determinant: determinant(to_world) as f32,
            flip,
            area: 0.0,
        };
        emitter.area =
            shape.area() * mean_over_square(|x, y| emitter.stretch(shape.sample(Vec2::new(x, y)).1));
        emitter
    }

    pub(crate) fn area(&self) -> f32 {
        self.area
    }

    pub(super) fn bounds(&self) -> Bounds3 {
        let (radius, low, high) = match self.shape {
            QuadricShape::Sphere { radius, z_min, z_max, .. }
            | QuadricShape::Cylinder { radius, z_min, z_max, .. } => (radius, z_min, z_max),
            QuadricShape::Disk { height, radius, .. } => (radius, height, height),
        };
        let local = Bounds3 { min: Vec3::new(-radius, -radius, low), max: Vec3::new(radius, radius, high) };
        Bounds3::from_points(local.corners().map(|corner| self.to_world.point(corner)))
    }

    /// The one normal of a disk; those of the others go round.
    pub(super) fn facing(&self) -> Cone {
        match self.shape {
            QuadricShape::Disk { .. } => {
                let n = self.to_world.normal(Vec3::Z).normalize();
                Cone::of(if self.flip { -n } else { n })
            }
            QuadricShape::Sphere { .. } | QuadricShape::Cylinder { .. } => Cone::ALL,
        }
    }

    #[inline]
    pub(super) fn sample(&self, from: Vec3, u: Vec2) -> (EmitterPoint, f32) {
        let (p, n) = self.shape.sample(u);
        let (p, p_error) = self.to_world.point_with_error(p, p.abs() * gamma(6));
        let n_world = self.to_world.normal(n).normalize();
        let point =
            EmitterPoint { p, p_error, n: if self.flip { -n_world } else { n_world }, uv: Vec2::ZERO };
        (point, per_solid_angle(1.0 / (self.shape.area() * self.stretch(n)), from, p, n_world))
    }

    #[inline]
    pub(super) fn pdf(&self, from: Vec3, point: &EmitterPoint) -> f32 {
        let n = self.from_world.normal(point.n).normalize();
        per_solid_angle(1.0 / (self.shape.area() * self.stretch(n)), from, point.p, point.n)
    }

    /// By how much the map stretches areas with unit normal `n`.
    #[inline]
    fn stretch(&self, n: Vec3) -> f32 {
        self.determinant * self.to_world.normal(n).length()
    }
}

/// |det M| of the linear part.
fn determinant(transform: &Transform) -> f64 {
    let [a, b, c] = transform.to_rows();
    let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
    (a[0] * minor(1, 2) - a[1] * minor(0, 2) + a[2] * minor(0, 1)).abs()
}

/// The radius of the sphere that a unit sphere becomes; `None` if it becomes an ellipsoid.
pub(crate) fn uniform_scale(transform: &Transform) -> Option<f32> {
    let rows = transform.to_rows();
    let column = |j: usize| [rows[0][j], rows[1][j], rows[2][j]];
    let dot = |i: usize, j: usize| (0..3).map(|k| column(i)[k] * column(j)[k]).sum::<f64>();
    let squared = dot(0, 0);
    let is_uniform = [(1, 1), (2, 2)].iter().all(|&(i, j)| (dot(i, j) / squared - 1.0).abs() < 1e-6)
        && [(0, 1), (0, 2), (1, 2)].iter().all(|&(i, j)| (dot(i, j) / squared).abs() < 1e-6);
    is_uniform.then(|| squared.sqrt() as f32)
}

/// Limits as pbrt has them: heights in order and within the sphere, the sweep within a turn.
pub(crate) fn clamp_heights(z_min: f32, z_max: f32, radius: f32) -> (f32, f32) {
    (z_min.min(z_max).clamp(-radius, radius), z_min.max(z_max).clamp(-radius, radius))
}

/// The sweep, at most a full turn.
pub(crate) fn clamp_sweep(phi_max: f32) -> f32 {
    phi_max.clamp(0.0, 2.0 * PI)
}
