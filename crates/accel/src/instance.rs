//! Placed groups: the second level.
//!
//! The ray is mapped to the group's space in `f64` and rounded once, so that the error is half a unit in the last place of
//! the coordinates there. [`PlacedGroup::error`] carries it back to the world, into the error bounds of surface points.

use sahl_math::{Bounds3, Ray};

use crate::geometry::double::{DVec3, DoubleTransform};
use crate::world::Instance;

/// A group's tree with its place in the world.
#[derive(Clone, Debug)]
pub(crate) struct PlacedGroup {
    /// The index of the instance in the world.
    pub(crate) instance: u32,
    /// Which group.
    pub(crate) group: u32,
    to_world: DoubleTransform,
    /// The box about the group in its own space.
    local: Bounds3,
}

impl PlacedGroup {
    pub(crate) fn new(index: u32, instance: &Instance, local: Bounds3) -> Self {
        Self {
            instance: index,
            group: instance.group,
            to_world: DoubleTransform::new(&instance.to_world),
            local,
        }
    }

    /// The ray in the group's space; parameters keep their meaning, `t_max` is the caller's.
    #[inline]
    pub(crate) fn local_ray(&self, ray: &Ray) -> Ray {
        Ray {
            origin: self.to_world.inverse_point(ray.origin.into()).to_f32(),
            direction: self.to_world.inverse_vector(ray.direction.into()).to_f32(),
            ..*ray
        }
    }

    #[inline]
    pub(crate) fn point(&self, p: DVec3) -> DVec3 {
        self.to_world.point(p)
    }

    #[inline]
    pub(crate) fn normal(&self, n: DVec3) -> DVec3 {
        self.to_world.normal(n)
    }

    /// The error in the world of a point known to within `error` in the group's space, together with the rounding of
    /// a ray's origin next to it when the ray is mapped into the group's space.
    #[inline]
    pub(crate) fn error(&self, p: DVec3, error: DVec3) -> DVec3 {
        let rounding =
            p.abs() * f64::from(f32::EPSILON) + DVec3::new(1.0, 1.0, 1.0) * f64::from(f32::MIN_POSITIVE);
        self.to_world.spread(error + rounding) + self.to_world.rounding(p)
    }

    /// The box about the group in the world, widened by the rounding of rays that are mapped into the group.
    pub(crate) fn bounds(&self) -> Bounds3 {
        if self.local.is_empty() {
            return Bounds3::EMPTY;
        }
        let (min, max) = (DVec3::from(self.local.min), DVec3::from(self.local.max));
        let (center, half) = ((min + max) * 0.5, (max - min) * 0.5);
        let middle = self.to_world.point(center);
        let farthest = center.abs() + half;
        let reach = self.to_world.spread(half) + self.error(farthest, DVec3::new(0.0, 0.0, 0.0)) * 2.0;
        Bounds3 {
            min: (middle - reach).to_f32().map(f32::next_down),
            max: (middle + reach).to_f32().map(f32::next_up),
        }
    }
}
