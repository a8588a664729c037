//! Lambertian reflection and transmission: paper against the light, leaves.

use std::f32::consts::FRAC_1_PI;

use sahl_math::{Vec2, Vec3};

use super::{BsdfSample, Reach, Scatter, ScatterKind};
use crate::spectrum::Spectrum;
use crate::warp;

/// Scatters alike in all directions, to both sides: f = ρ / π on the side of wo, τ / π on the other.
///
/// In a scene file: `Material "diffusetransmission" "rgb reflectance" [.2 .4 .1] "rgb transmittance" [.3 .5 .1]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseTransmission {
    reflectance: Spectrum,
    transmittance: Spectrum,
}

impl DiffuseTransmission {
    /// A sheet that reflects and lets through these shares of the light; each is limited to [0, 1]. Their sum is not, as
    /// in pbrt-v4: what gains energy has been asked for.
    #[inline]
    pub fn new(reflectance: Spectrum, transmittance: Spectrum) -> Self {
        let limited = |share: Spectrum| share.clamp(0.0, 1.0);
        Self { reflectance: limited(reflectance), transmittance: limited(transmittance) }
    }

    /// The probability of a reflection; zero where nothing is scattered.
    #[inline]
    fn reflection_pmf(&self) -> f32 {
        let (r, t) = (self.reflectance.max_component(), self.transmittance.max_component());
        if r == 0.0 { 0.0 } else { r / (r + t) }
    }

    #[inline]
    fn is_black(&self) -> bool {
        self.reflectance.is_zero() && self.transmittance.is_zero()
    }
}

impl Scatter for DiffuseTransmission {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        let side = wo.z * wi.z;
        if side == 0.0 {
            return Spectrum::ZERO;
        }
        (if side > 0.0 { self.reflectance } else { self.transmittance }) * (wi.z.abs() * FRAC_1_PI)
    }

    #[inline]
    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let side = wo.z * wi.z;
        if side == 0.0 || self.is_black() {
            return 0.0;
        }
        let pmf = self.reflection_pmf();
        (if side > 0.0 { pmf } else { 1.0 - pmf }) * (wi.z.abs() * FRAC_1_PI)
    }

    #[inline]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 || self.is_black() {
            return None;
        }
        let pmf = self.reflection_pmf();
        let (share, pmf, kind) = if u_lobe < pmf {
            (self.reflectance, pmf, ScatterKind::DIFFUSE_REFLECTION)
        } else {
            (self.transmittance, 1.0 - pmf, ScatterKind::DIFFUSE_TRANSMISSION)
        };
        let mut wi = warp::cosine_hemisphere(u);
        let pdf = pmf * (wi.z.abs() * FRAC_1_PI);
        wi.z = wi.z.copysign(if kind.is_transmission() { -wo.z } else { wo.z });
        (pdf > 0.0).then(|| BsdfSample { wi, weight: share / pmf, pdf, kind, eta: 1.0 })
    }

    #[inline]
    fn is_specular(&self) -> bool {
        false
    }

    #[inline]
    fn reach(&self) -> Reach {
        Reach::BothSides
    }

    #[inline]
    fn albedo(&self, _wo: Vec3) -> Spectrum {
        (self.reflectance + self.transmittance).clamp(0.0, 1.0)
    }
}
