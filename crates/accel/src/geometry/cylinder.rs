//! The cylinder without caps.

use super::double::DVec3;
use super::quadric::{
    DoubleRay, LocalPoint, NO_ROOTS, Roots, azimuth_parameter, checked_phi_max, within_azimuth,
};
use crate::world::Cylinder;

/// A cylinder about z with its limits checked.
#[derive(Clone, Debug)]
pub(crate) struct CylinderShape {
    pub(crate) radius: f64,
    pub(crate) z_min: f64,
    pub(crate) z_max: f64,
    phi_max: f64,
}

impl CylinderShape {
    /// `None` if nothing of the surface is left, or a number is not finite.
    pub(crate) fn new(cylinder: &Cylinder) -> Option<Self> {
        let [a, b] = [cylinder.z_min, cylinder.z_max].map(f64::from);
        let (radius, z_min, z_max) = (f64::from(cylinder.radius), a.min(b), a.max(b));
        let phi_max = checked_phi_max(cylinder.phi_max)?;
        let finite = radius.is_finite() && a.is_finite() && b.is_finite();
        (finite && radius > 0.0 && z_min < z_max).then_some(Self { radius, z_min, z_max, phi_max })
    }

    /// Both crossings, those that are cut away as NaN; the discriminant as in the sphere, in two dimensions.
    #[inline]
    pub(crate) fn roots(&self, ray: &DoubleRay) -> Roots {
        let flat = |v: DVec3| DVec3::new(v.x, v.y, 0.0);
        let (o, d) = (flat(ray.origin), flat(ray.direction));
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
        roots.map(|t| if self.keeps(ray.at(t)) { t } else { f64::NAN })
    }

    #[inline]
    fn keeps(&self, p: DVec3) -> bool {
        p.z >= self.z_min && p.z <= self.z_max && within_azimuth(p, self.phi_max)
    }

    /// The point of the surface next to `at`; its normal points outwards.
    #[inline]
    pub(crate) fn point(&self, at: DVec3) -> LocalPoint {
        let distance = at.x.hypot(at.y);
        let (x, y) = if distance > 0.0 {
            (at.x * (self.radius / distance), at.y * (self.radius / distance))
        } else {
            (self.radius, 0.0)
        };
        let p = DVec3::new(x, y, at.z.clamp(self.z_min, self.z_max));
        let v = ((p.z - self.z_min) / (self.z_max - self.z_min)) as f32;
        LocalPoint {
            p,
            n: DVec3::new(x, y, 0.0),
            u: azimuth_parameter(p, self.phi_max),
            v: v.clamp(0.0, 1.0),
        }
    }
}
