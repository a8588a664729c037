//! Rays, and the way a ray leaves a surface without hitting it again.

use crate::{Vec3, gamma};

/// A half-line with the interval of parameters in which hits count.
#[derive(Clone, Copy, Debug, PartialEq)]
// Eight numbers first, in this order: `sahl-accel` loads them at once, and asserts that they are there.
#[repr(C)]
pub struct Ray {
    /// Where the ray starts.
    pub origin: Vec3,
    /// Where it goes; need not have unit length.
    pub direction: Vec3,
    /// Hits count beyond this parameter; zero for a ray spawned by [`Ray::spawn`].
    pub t_min: f32,
    /// Hits count before this parameter.
    pub t_max: f32,
    /// When the ray is there, as the fraction of the time that the shutter is open, in [0, 1]: what moves stands where it is then. A ray
    /// that leaves a surface has to be given the time of the ray that met it, by [`Ray::with_time`].
    pub time: f32,
}

impl Ray {
    /// The ray from `origin` along `direction`, without an end, at the time when the shutter opens.
    #[inline]
    pub const fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f32::INFINITY, time: 0.0 }
    }

    /// The same ray that ends at `t_max`.
    #[inline]
    pub const fn with_t_max(mut self, t_max: f32) -> Self {
        self.t_max = t_max;
        self
    }

    /// The same ray at another time.
    #[inline]
    pub const fn with_time(mut self, time: f32) -> Self {
        self.time = time;
        self
    }

    /// The point at parameter `t`.
    #[inline]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }

    /// The ray that leaves a surface at `p ± p_error` along `direction`, starting outside the error box.
    ///
    /// `n` is the geometric normal, either side.
    #[inline]
    pub fn spawn(p: Vec3, p_error: Vec3, n: Vec3, direction: Vec3) -> Self {
        Self::new(offset_ray_origin(p, p_error, n, direction), direction)
    }

    /// The segment between two surfaces, outside the error boxes of both: `t = 1` lies just before the target.
    ///
    /// Each end is `(point, error, geometric normal)`. An end that lies on no surface has error and normal zero.
    ///
    /// The error box of the target is enlarged by what the segment's own arithmetic can lose: the direction is rounded,
    /// and an intersection test translates, shears and combines coordinates of the segment's length, which takes no more
    /// than 16 roundings one after the other.
    #[inline]
    pub fn spawn_to(from: (Vec3, Vec3, Vec3), to: (Vec3, Vec3, Vec3)) -> Self {
        let origin = offset_ray_origin(from.0, from.1, from.2, to.0 - from.0);
        let reach = gamma(16) * (to.0 - origin).abs().max_component();
        let target = offset_ray_origin(to.0, to.1 + Vec3::splat(reach), to.2, origin - to.0);
        Self::new(origin, target - origin).with_t_max(1.0)
    }
}

/// Surfaces through the origin of space, such as a floor at zero, have hardly an error. Rays that start a subnormal distance from them
/// are slow: processors take a hundred times as long to multiply such numbers. From here on products with slopes stay normal.
const LEAST_OFFSET: f32 = f32::MIN_POSITIVE / f32::EPSILON;

/// A point near `p`, outside the box `p ± p_error`, on the side of the surface to which `direction` points.
///
/// The offset goes along the geometric normal `n` (either side) beyond the plane through the far corner of the box, by
/// as much as rounding the result can take back. With error and normal zero the result is `p`.
///
/// Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed., 2023, section 6.8.6. Deviation: there each
/// coordinate of the result is rounded away from `p`; here the box is enlarged by that rounding beforehand, which needs
/// no branches.
#[inline(always)]
pub fn offset_ray_origin(p: Vec3, p_error: Vec3, n: Vec3, direction: Vec3) -> Vec3 {
    let distance = n.abs().dot(p_error + p.abs() * gamma(2)).max(LEAST_OFFSET);
    p + n * distance.copysign(direction.dot(n))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spawned_rays_start_on_the_side_they_go_to() {
        let (p, error) = (Vec3::new(1e4, -3.0, 0.125), Vec3::splat(1e-3));
        for n in [Vec3::Z, -Vec3::Z] {
            assert!(Ray::spawn(p, error, n, Vec3::new(0.1, 0.0, 1.0)).origin.z > p.z + error.z);
            assert!(Ray::spawn(p, error, n, Vec3::new(0.1, 0.0, -1.0)).origin.z < p.z - error.z);
        }
    }

    #[test]
    fn no_ray_starts_a_subnormal_distance_from_a_plane_through_zero() {
        for y_error in [0.0, 1e-44, 1e-39] {
            let ray =
                Ray::spawn(Vec3::new(3.0, 0.0, 2.0), Vec3::new(1e-6, y_error, 1e-6), Vec3::Y, Vec3::ONE);
            assert!((ray.origin.y * 1e-6).is_normal(), "{}", ray.origin.y);
        }
        let nowhere = Ray::spawn(Vec3::ZERO, Vec3::ZERO, Vec3::ZERO, Vec3::ONE);
        assert_eq!(nowhere.origin, Vec3::ZERO);
    }

    #[test]
    fn a_segment_ends_before_its_target() {
        let from = (Vec3::ZERO, Vec3::splat(1e-6), Vec3::Z);
        let to = (Vec3::new(0.0, 0.0, 2.0), Vec3::splat(1e-6), Vec3::Z);
        let ray = Ray::spawn_to(from, to);
        assert_eq!(ray.t_max, 1.0);
        assert!(ray.origin.z > 0.0 && ray.at(1.0).z < 2.0);
    }
}
