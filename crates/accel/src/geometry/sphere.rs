//! The sphere.

use super::double::DVec3;
use super::quadric::{
    DoubleRay, LocalPoint, NO_ROOTS, Roots, azimuth_parameter, checked_phi_max, within_azimuth,
};
use crate::world::Sphere;

/// A sphere about the origin with its limits checked.
#[derive(Clone, Debug)]
pub(crate) struct SphereShape {
    pub(crate) radius: f64,
    pub(crate) z_min: f64,
    pub(crate) z_max: f64,
    phi_max: f64,
    /// Polar angles at `z_min` and `z_max`.
    theta: [f64; 2],
}

impl SphereShape {
    /// `None` if nothing of the surface is left, or a number is not finite.
    pub(crate) fn new(sphere: &Sphere) -> Option<Self> {
        let radius = f64::from(sphere.radius);
        let finite = radius.is_finite() && !sphere.z_min.is_nan() && !sphere.z_max.is_nan();
        if !(finite && radius > 0.0) {
            return None;
        }
        let [a, b] = [sphere.z_min, sphere.z_max].map(|z| f64::from(z).clamp(-radius, radius));
        let (z_min, z_max) = (a.min(b), a.max(b));
        let phi_max = checked_phi_max(sphere.phi_max)?;
        (z_min < z_max).then(|| Self {
            radius,
            z_min,
            z_max,
            phi_max,
            theta: [(z_min / radius).acos(), (z_max / radius).acos()],
        })
    }

    /// Whether nothing is cut away.
    #[inline]
    pub(crate) fn is_whole(&self) -> bool {
        self.z_min <= -self.radius && self.z_max >= self.radius && self.phi_max >= std::f64::consts::TAU
    }

    /// Both crossings, those that are cut away as NaN.
    ///
    /// The discriminant is `4 |d|² (r² − h²)`, where `h` is the distance of the ray's line from the centre: it does not
    /// cancel for distant origins. Source: Hearn, Baker, *Computer Graphics with OpenGL*, 2004; Haines et al.,
    /// *Precision Improvements for Ray/Sphere Intersection*, in Ray Tracing Gems, 2019.
    #[inline]
    pub(crate) fn roots(&self, ray: &DoubleRay) -> Roots {
        let (o, d) = (ray.origin, ray.direction);
        let a = d.dot(d);
        let half_b = -o.dot(d);
        let foot = o + d * (half_b / a);
        let inside = self.radius * self.radius - foot.dot(foot);
        if !(inside >= 0.0 && a > 0.0) {
            return NO_ROOTS;
        }
        let q = half_b + (a * inside).sqrt().copysign(half_b);
        let c = (o.length() - self.radius) * (o.length() + self.radius);
        let (t0, t1) = if q == 0.0 { (0.0, 0.0) } else { (c / q, q / a) };
        let roots = if t0 <= t1 { [t0, t1] } else { [t1, t0] };
        if self.is_whole() {
            return roots;
        }
        roots.map(|t| if self.keeps(ray.at(t)) { t } else { f64::NAN })
    }

    #[inline]
    fn keeps(&self, p: DVec3) -> bool {
        (self.z_min <= -self.radius || p.z >= self.z_min)
            && (self.z_max >= self.radius || p.z <= self.z_max)
            && within_azimuth(p, self.phi_max)
    }

    /// The point of the surface next to `at`; its normal points outwards.
    #[inline]
    pub(crate) fn point(&self, at: DVec3) -> LocalPoint {
        let distance = at.length();
        let p =
            if distance > 0.0 { at * (self.radius / distance) } else { DVec3::new(self.radius, 0.0, 0.0) };
        let theta = p.x.hypot(p.y).atan2(p.z);
        let v = (theta - self.theta[0]) / (self.theta[1] - self.theta[0]);
        LocalPoint { p, n: p, u: azimuth_parameter(p, self.phi_max), v: (v as f32).clamp(0.0, 1.0) }
    }
}
