//! Emitting spheres.

use std::f32::consts::PI;

use sahl_math::{Bounds3, Frame, Vec2, Vec3, gamma, safe_sqrt};

use super::{EmitterPoint, per_solid_angle};
use crate::warp;

/// A whole sphere: from outside the cone of directions that meet it is sampled uniformly, from inside and
/// from its surface its area.
#[derive(Clone, Debug)]
pub(crate) struct SphereEmitter {
    center: Vec3,
    radius: f32,
    /// Whether the inside emits.
    flip: bool,
    /// Squared sine of the cone's half angle from which on a point may lie on the sphere, as far as rounding tells. From
    /// there the cone is no use: it finds the side that is near, and the far one may be the one in sight.
    sin2_limit: f32,
}

impl SphereEmitter {
    pub(crate) fn new(center: Vec3, radius: f32, flip: bool) -> Self {
        let rounding = gamma(16) * (1.0 + center.abs().max_component() / radius);
        Self { center, radius, flip, sin2_limit: 1.0 - rounding.min(0.5) }
    }

    pub(crate) fn area(&self) -> f32 {
        4.0 * PI * self.radius * self.radius
    }

    pub(super) fn bounds(&self) -> Bounds3 {
        let half = Vec3::splat(self.radius);
        Bounds3 { min: self.center - half, max: self.center + half }
    }

    /// Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed., 2023, section 6.2.4.
    #[inline]
    pub(super) fn sample(&self, from: Vec3, u: Vec2) -> (EmitterPoint, f32) {
        let to_center = self.center - from;
        let Some(cone) = self.cone(to_center) else {
            let n = warp::uniform_sphere(u);
            let point = self.emitter_point(n);
            return (point, self.inside_pdf(from, &point));
        };
        let w = warp::uniform_cone(u, cone.one_minus_cos);
        let sin2 = w.x * w.x + w.y * w.y;
        // From the angle at the viewer to the angle at the centre, between the axis and the point that is hit.
        let sin_max = cone.sin2_max.sqrt();
        let cos_alpha = sin2 / sin_max + w.z * safe_sqrt(1.0 - sin2 / cone.sin2_max);
        let sin_alpha = safe_sqrt(1.0 - cos_alpha * cos_alpha);
        let scale = if sin2 > 0.0 { sin_alpha / sin2.sqrt() } else { 0.0 };
        let frame = Frame::from_z(-to_center / to_center.length());
        let n = frame.to_world(Vec3::new(w.x * scale, w.y * scale, cos_alpha));
        (self.emitter_point(n), warp::uniform_cone_pdf(cone.one_minus_cos))
    }

    #[inline]
    pub(super) fn pdf(&self, from: Vec3, point: &EmitterPoint) -> f32 {
        match self.cone(self.center - from) {
            Some(cone) => warp::uniform_cone_pdf(cone.one_minus_cos),
            None => self.inside_pdf(from, point),
        }
    }

    fn inside_pdf(&self, from: Vec3, point: &EmitterPoint) -> f32 {
        per_solid_angle(1.0 / self.area(), from, point.p, point.n)
    }

    /// The cone of directions that meet the sphere; `None` from inside and from the sphere itself.
    #[inline]
    fn cone(&self, to_center: Vec3) -> Option<Cone> {
        let sin2_max = self.radius * self.radius / to_center.length_squared();
        (sin2_max < self.sin2_limit)
            .then(|| Cone { sin2_max, one_minus_cos: sin2_max / (1.0 + (1.0 - sin2_max).sqrt()) })
    }

    /// The point of the sphere in the direction `n` from its centre.
    #[inline]
    fn emitter_point(&self, n: Vec3) -> EmitterPoint {
        let offset = n * self.radius;
        EmitterPoint {
            p: self.center + offset,
            p_error: (self.center.abs() + offset.abs()) * gamma(6),
            n: if self.flip { -n } else { n },
            uv: Vec2::ZERO,
        }
    }
}

struct Cone {
    sin2_max: f32,
    /// 1 − cos θ at the border, without cancellation.
    one_minus_cos: f32,
}
