//! The disk.

use super::double::DVec3;
use super::quadric::{
    DoubleRay, LocalPoint, NO_ROOTS, Roots, azimuth_parameter, checked_phi_max, within_azimuth,
};
use crate::world::Disk;

/// A disk about z with its limits checked.
#[derive(Clone, Debug)]
pub(crate) struct DiskShape {
    pub(crate) height: f64,
    pub(crate) radius: f64,
    inner_radius: f64,
    phi_max: f64,
}

impl DiskShape {
    /// `None` if nothing of the surface is left, or a number is not finite.
    pub(crate) fn new(disk: &Disk) -> Option<Self> {
        let (height, radius) = (f64::from(disk.height), f64::from(disk.radius));
        let inner_radius = f64::from(disk.inner_radius).max(0.0);
        let phi_max = checked_phi_max(disk.phi_max)?;
        let finite = height.is_finite() && radius.is_finite() && !disk.inner_radius.is_nan();
        (finite && inner_radius < radius).then_some(Self { height, radius, inner_radius, phi_max })
    }

    /// The crossing of the plane, NaN if it is cut away; rays in the plane have none.
    #[inline]
    pub(crate) fn roots(&self, ray: &DoubleRay) -> Roots {
        let t = (self.height - ray.origin.z) / ray.direction.z;
        if !t.is_finite() {
            return NO_ROOTS;
        }
        let p = ray.at(t);
        let squared = p.x * p.x + p.y * p.y;
        let inside = squared <= self.radius * self.radius && squared >= self.inner_radius * self.inner_radius;
        if inside && within_azimuth(p, self.phi_max) { [t, f64::NAN] } else { NO_ROOTS }
    }

    /// The point of the surface next to `at`; its normal is +z.
    #[inline]
    pub(crate) fn point(&self, at: DVec3) -> LocalPoint {
        let p = DVec3::new(at.x, at.y, self.height);
        let v = ((self.radius - p.x.hypot(p.y)) / (self.radius - self.inner_radius)) as f32;
        LocalPoint {
            p,
            n: DVec3::new(0.0, 0.0, 1.0),
            u: azimuth_parameter(p, self.phi_max),
            v: v.clamp(0.0, 1.0),
        }
    }
}
