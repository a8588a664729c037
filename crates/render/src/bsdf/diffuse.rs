//! Lambertian reflection.

use std::f32::consts::FRAC_1_PI;

use sahl_math::{Vec2, Vec3};

use super::{BsdfSample, Reach, Scatter, ScatterKind};
use crate::spectrum::Spectrum;
use crate::warp;

/// Reflects alike in all directions, on both sides: f = ρ / π.
///
/// In a scene file: `Material "diffuse" "rgb reflectance" [.5 .5 .5]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diffuse {
    reflectance: Spectrum,
}

impl Diffuse {
    /// Paper that reflects the share `reflectance` of the light; limited to [0, 1].
    #[inline]
    pub fn new(reflectance: Spectrum) -> Self {
        Self { reflectance: reflectance.clamp(0.0, 1.0) }
    }
}

impl Scatter for Diffuse {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        self.reflectance * self.pdf(wo, wi)
    }

    #[inline]
    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z * wi.z > 0.0 { wi.z.abs() * FRAC_1_PI } else { 0.0 }
    }

    #[inline]
    fn sample(&self, wo: Vec3, _u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        let mut wi = warp::cosine_hemisphere(u);
        wi.z = wi.z.copysign(wo.z);
        let pdf = self.pdf(wo, wi);
        (pdf > 0.0).then_some(BsdfSample {
            wi,
            weight: self.reflectance,
            pdf,
            kind: ScatterKind::DIFFUSE_REFLECTION,
            eta: 1.0,
        })
    }

    #[inline]
    fn is_specular(&self) -> bool {
        false
    }

    #[inline]
    fn reach(&self) -> Reach {
        Reach::OneSide
    }

    #[inline]
    fn albedo(&self, _wo: Vec3) -> Spectrum {
        self.reflectance
    }
}
