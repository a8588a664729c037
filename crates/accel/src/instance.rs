//! Placed groups: the second level.
//!
//! The ray is mapped to the group's space in `f64` and rounded once, so that the error is half a unit in the last place of
//! the coordinates there. [`error`] carries it back to the world, into the error bounds of surface points.

use std::borrow::Cow;

use sahl_math::{AnimatedTransform, Bounds3, Ray};

use crate::geometry::double::{DVec3, DoubleTransform};
use crate::world::{Instance, Placement};

/// A group's tree with its place in the world.
#[derive(Clone, Debug)]
pub(crate) struct PlacedGroup {
    /// The index of the instance in the world.
    pub(crate) instance: u32,
    /// Which group.
    pub(crate) group: u32,
    /// The map of a group that stands still; that when the shutter opens for one that moves.
    to_world: DoubleTransform,
    motion: Option<Box<AnimatedTransform>>,
    /// The box about the group in its own space.
    local: Bounds3,
}

impl PlacedGroup {
    pub(crate) fn new(index: u32, instance: &Instance, local: Bounds3) -> Self {
        let motion = match &instance.to_world {
            Placement::Still(_) => None,
            Placement::Moving(motion) => Some(motion.clone()),
        };
        Self {
            instance: index,
            group: instance.group,
            to_world: DoubleTransform::new(&instance.to_world.at(0.0)),
            motion,
            local,
        }
    }

    pub(crate) fn moves(&self) -> bool {
        self.motion.is_some()
    }

    /// The memory beyond that of the value itself.
    pub(crate) fn bytes(&self) -> u64 {
        self.motion.as_ref().map_or(0, |motion| size_of_val(&**motion) as u64)
    }

    /// The ray in the space of a group that stands still; parameters keep their meaning, `t_max` is the caller's.
    #[inline]
    pub(crate) fn local_ray(&self, ray: &Ray) -> Ray {
        to_local(&self.to_world, ray)
    }

    /// The ray in the group's space at the ray's time.
    pub(crate) fn local_ray_at_time(&self, ray: &Ray) -> Ray {
        to_local(&self.map_at(ray.time), ray)
    }

    /// The map from the group's space to the world at a time.
    #[inline]
    pub(crate) fn map_at(&self, time: f32) -> Cow<'_, DoubleTransform> {
        match &self.motion {
            None => Cow::Borrowed(&self.to_world),
            Some(motion) => Cow::Owned(DoubleTransform::from_rows(motion.rows_at(time))),
        }
    }

    /// The box about the group in the world at any time, widened by the rounding of rays that are mapped into the group.
    pub(crate) fn bounds(&self) -> Bounds3 {
        if self.local.is_empty() {
            return Bounds3::EMPTY;
        }
        let (min, max) = (DVec3::from(self.local.min), DVec3::from(self.local.max));
        let (center, half) = ((min + max) * 0.5, (max - min) * 0.5);
        let farthest = center.abs() + half;
        if let Some(motion) = &self.motion {
            return widened(&motion.bounds(&self.local), largest_error(motion, farthest) * 2.0);
        }
        let middle = self.to_world.point(center);
        let reach = self.to_world.spread(half) + error(&self.to_world, farthest, NO_ERROR) * 2.0;
        Bounds3 {
            min: (middle - reach).to_f32().map(f32::next_down),
            max: (middle + reach).to_f32().map(f32::next_up),
        }
    }
}

const NO_ERROR: DVec3 = DVec3::new(0.0, 0.0, 0.0);

#[inline(always)]
fn to_local(to_world: &DoubleTransform, ray: &Ray) -> Ray {
    Ray {
        origin: to_world.inverse_point(ray.origin.into()).to_f32(),
        direction: to_world.inverse_vector(ray.direction.into()).to_f32(),
        ..*ray
    }
}

/// The error in the world of a point known to within `error` in the group's space, together with the rounding of
/// a ray's origin next to it when the ray is mapped into the group's space.
#[inline]
pub(crate) fn error(to_world: &DoubleTransform, p: DVec3, error: DVec3) -> DVec3 {
    let rounding =
        p.abs() * f64::from(f32::EPSILON) + DVec3::new(1.0, 1.0, 1.0) * f64::from(f32::MIN_POSITIVE);
    to_world.spread(error + rounding) + to_world.rounding(p)
}

/// What [`error`] is at most at any time, for a point that is known, in every coordinate.
///
/// The linear part at any time is a rotation times a mixture of those of the ends without their rotations. Its coefficients are at most as
/// large as the norm of the larger of the two, which rotations do not change.
fn largest_error(motion: &AnimatedTransform, p: DVec3) -> f64 {
    let maps = motion.ends().map(|end| DoubleTransform::new(&end));
    let norm = |map: &DoubleTransform| {
        map.rows().iter().map(|&[x, y, z, _]| DVec3::new(x, y, z)).map(|row| row.dot(row)).sum::<f64>().sqrt()
    };
    let moved = |map: &DoubleTransform| {
        let translation = map.point(NO_ERROR).abs();
        translation.x.max(translation.y).max(translation.z)
    };
    let [norm, moved] = [maps.each_ref().map(norm), maps.each_ref().map(moved)].map(|[a, b]| a.max(b));
    // A row of the linear part, of which each coefficient is at most the norm.
    let reach = p.x.abs() + p.y.abs() + p.z.abs();
    norm * (reach * f64::from(f32::EPSILON) + 3.0 * f64::from(f32::MIN_POSITIVE))
        + DoubleTransform::rounding_of(norm * reach + moved)
}

fn widened(bounds: &Bounds3, by: f64) -> Bounds3 {
    let by = DVec3::new(by, by, by);
    Bounds3 {
        min: (DVec3::from(bounds.min) - by).to_f32().map(f32::next_down),
        max: (DVec3::from(bounds.max) + by).to_f32().map(f32::next_up),
    }
}
