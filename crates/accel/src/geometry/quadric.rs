//! What sphere, cylinder and disk share: the change of space, the choice of the root, the azimuth.
//!
//! The equations are solved in `f64` in the shape's own space, the ray being mapped there in `f64`: the error is far below
//! the spacing of the `f32` in which hits and origins are stored, so that a spawned ray that starts outside the error box
//! of a surface point is outside for the intersection as well.

use std::f64::consts::TAU;

use sahl_math::{Bounds3, Ray, Transform, Vec3};

use super::cylinder::CylinderShape;
use super::disk::DiskShape;
use super::double::{DVec3, DoubleTransform};
use super::sphere::SphereShape;
use crate::world::Geometry;

/// A quadric prepared for intersection.
#[derive(Clone, Debug)]
pub(crate) struct Quadric {
    to_parent: DoubleTransform,
    shape: Shape,
    /// The primitive's place among all primitives.
    pub(crate) id: u32,
}

#[derive(Clone, Debug)]
enum Shape {
    Sphere(SphereShape),
    Cylinder(CylinderShape),
    Disk(DiskShape),
}

/// A ray in a shape's own space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DoubleRay {
    pub(crate) origin: DVec3,
    pub(crate) direction: DVec3,
}

impl DoubleRay {
    #[inline]
    pub(crate) fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }
}

/// A point of a shape in its own space, with `dp/du × dp/dv` up to a positive factor, and the parameters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalPoint {
    pub(crate) p: DVec3,
    pub(crate) n: DVec3,
    pub(crate) u: f32,
    pub(crate) v: f32,
}

/// Up to two parameters at which a ray meets a shape, ascending; NaN where there is none.
pub(crate) type Roots = [f64; 2];

/// No root.
pub(crate) const NO_ROOTS: Roots = [f64::NAN; 2];

impl Quadric {
    /// The prepared shape; `None` if `geometry` is no quadric or has no surface.
    pub(crate) fn new(geometry: &Geometry, id: u32) -> Option<Self> {
        let (shape, to_parent): (Shape, &Transform) = match geometry {
            Geometry::Sphere(sphere) => (Shape::Sphere(SphereShape::new(sphere)?), &sphere.to_parent),
            Geometry::Cylinder(cylinder) => {
                (Shape::Cylinder(CylinderShape::new(cylinder)?), &cylinder.to_parent)
            }
            Geometry::Disk(disk) => (Shape::Disk(DiskShape::new(disk)?), &disk.to_parent),
            Geometry::Triangles(_)
            | Geometry::MovingTriangles(_)
            | Geometry::Patches(_)
            | Geometry::Curves(_) => return None,
        };
        Some(Self { to_parent: DoubleTransform::new(to_parent), shape, id })
    }

    /// The box about the shape in its parent's space, rounded outwards.
    pub(crate) fn bounds(&self) -> Bounds3 {
        let (centre, half) = match &self.shape {
            Shape::Sphere(sphere) if sphere.is_whole() => {
                let extent = |i: usize| {
                    let [x, y, z, _] = self.to_parent.rows()[i];
                    DVec3::new(x, y, z).length() * sphere.radius
                };
                (DVec3::new(0.0, 0.0, 0.0), DVec3::new(extent(0), extent(1), extent(2)))
            }
            Shape::Sphere(sphere) => self.spread_box(sphere.radius, sphere.z_min, sphere.z_max),
            Shape::Cylinder(cylinder) => self.spread_box(cylinder.radius, cylinder.z_min, cylinder.z_max),
            Shape::Disk(disk) => self.spread_box(disk.radius, disk.height, disk.height),
        };
        let middle = self.to_parent.point(centre);
        Bounds3 {
            min: (middle - half).to_f32().map(f32::next_down),
            max: (middle + half).to_f32().map(f32::next_up),
        }
    }

    /// The centre, in the shape's own space, and the half extent, in the parent's, of a box `± radius` wide.
    fn spread_box(&self, radius: f64, z_min: f64, z_max: f64) -> (DVec3, DVec3) {
        let half = DVec3::new(radius, radius, (z_max - z_min) * 0.5);
        (DVec3::new(0.0, 0.0, (z_min + z_max) * 0.5), self.to_parent.spread(half))
    }

    /// The nearest parameter strictly between `ray.t_min` and infinity.
    #[inline]
    pub(crate) fn intersect(&self, ray: &Ray) -> Option<f32> {
        let local = self.local_ray(ray);
        self.first_root(ray, &local).map(|t| t as f32).filter(|t| t.is_finite())
    }

    /// The smallest parameter that lies beyond `ray.t_min` when it is rounded, as a hit's is.
    #[inline]
    fn first_root(&self, ray: &Ray, local: &DoubleRay) -> Option<f64> {
        self.roots(local).into_iter().find(|&t| t as f32 > ray.t_min)
    }

    /// The point of a hit with its error, its normal, and its parameters.
    ///
    /// The root is found again as it was by [`Self::intersect`], the first of those that round to `t`: next to a small distant shape, the
    /// `f32` parameter does not tell the two apart. It stands in for a ray that has none.
    pub(crate) fn surface(&self, ray: &Ray, t: f32) -> QuadricSurface {
        let local = self.local_ray(ray);
        let rounds_to_t = self.roots(&local).into_iter().find(|&root| root as f32 == t);
        let root = rounds_to_t.or_else(|| self.first_root(ray, &local));
        let at = local.at(root.unwrap_or(f64::from(t)));
        let point = match &self.shape {
            Shape::Sphere(sphere) => sphere.point(at),
            Shape::Cylinder(cylinder) => cylinder.point(at),
            Shape::Disk(disk) => disk.point(at),
        };
        QuadricSurface {
            p: self.to_parent.point(point.p),
            error: self.to_parent.rounding(point.p),
            n: self.to_parent.normal(point.n),
            u: point.u,
            v: point.v,
        }
    }

    #[inline]
    fn local_ray(&self, ray: &Ray) -> DoubleRay {
        DoubleRay {
            origin: self.to_parent.inverse_point(ray.origin.into()),
            direction: self.to_parent.inverse_vector(ray.direction.into()),
        }
    }

    #[inline]
    fn roots(&self, ray: &DoubleRay) -> Roots {
        match &self.shape {
            Shape::Sphere(sphere) => sphere.roots(ray),
            Shape::Cylinder(cylinder) => cylinder.roots(ray),
            Shape::Disk(disk) => disk.roots(ray),
        }
    }
}

/// A point of a quadric in its parent's space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuadricSurface {
    pub(crate) p: DVec3,
    /// The absolute error of the coordinates of `p`.
    pub(crate) error: DVec3,
    /// The normal, not of unit length.
    pub(crate) n: DVec3,
    pub(crate) u: f32,
    pub(crate) v: f32,
}

/// `phi_max` as it counts: at most a full turn; `None` if nothing is left.
pub(crate) fn checked_phi_max(phi_max: f32) -> Option<f64> {
    (phi_max > 0.0).then(|| {
        // A full turn that was rounded down, to the `f32` below it, would leave a slit.
        if f64::from(phi_max.next_up()) >= TAU { TAU } else { f64::from(phi_max) }
    })
}

/// The azimuth from +x to +y, in [0, 2π).
#[inline]
pub(crate) fn azimuth(p: DVec3) -> f64 {
    let phi = p.y.atan2(p.x);
    if phi < 0.0 { phi + TAU } else { phi }
}

/// `azimuth / phi_max`, in [0, 1].
#[inline]
pub(crate) fn azimuth_parameter(p: DVec3, phi_max: f64) -> f32 {
    ((azimuth(p) / phi_max) as f32).min(1.0)
}

/// Whether the azimuth of `p` is at most `phi_max`.
#[inline]
pub(crate) fn within_azimuth(p: DVec3, phi_max: f64) -> bool {
    phi_max >= TAU || azimuth(p) <= phi_max
}

/// The unit vector along x, which stands for a normal where a shape has none.
pub(crate) const ANY_NORMAL: Vec3 = Vec3::X;
