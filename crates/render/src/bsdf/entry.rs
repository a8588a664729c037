//! The surface of matter that light enters to come out elsewhere.

use std::f32::consts::FRAC_1_PI;

use sahl_math::{Vec2, Vec3};

use super::{BsdfSample, Reach, Scatter, ScatterKind, fresnel};
use crate::spectrum::Spectrum;
use crate::subsurface::first_moment;
use crate::warp;

/// What light of all directions contributes to what spreads below a surface: f = (1 − F(cos θi)) / (c π), with c such that the
/// integral of f cos θi is one.
///
/// Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 3rd ed., 2016, equation 15.28. Deviations: c is integrated, not fitted, and the
/// factor η² of radiance is left to who knows that the light went through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    eta: f32,
    /// 1 / c.
    scale: f32,
}

impl Entry {
    /// An interface with the relative index `eta` inside over outside.
    pub fn new(eta: f32) -> Self {
        Self { eta, scale: Self::scale(eta) }
    }

    /// 1 / c, which depends on the index alone.
    pub(crate) fn scale(eta: f32) -> f32 {
        1.0 / (1.0 - 2.0 * first_moment(eta))
    }

    /// The interface for which [`Entry::scale`] was computed before.
    pub(crate) const fn with_scale(eta: f32, scale: f32) -> Self {
        Self { eta, scale }
    }

    fn weight(&self, wi: Vec3) -> f32 {
        self.scale * (1.0 - fresnel::dielectric(wi.z.abs(), self.eta).reflectance)
    }
}

impl Scatter for Entry {
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        Spectrum::splat(self.weight(wi) * self.pdf(wo, wi))
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z * wi.z > 0.0 { wi.z.abs() * FRAC_1_PI } else { 0.0 }
    }

    fn sample(&self, wo: Vec3, _u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        let mut wi = warp::cosine_hemisphere(u);
        wi.z = wi.z.copysign(wo.z);
        let (pdf, weight) = (self.pdf(wo, wi), Spectrum::splat(self.weight(wi)));
        let kind = ScatterKind::DIFFUSE_REFLECTION;
        (pdf > 0.0).then_some(BsdfSample { wi, weight, pdf, kind, eta: 1.0 })
    }

    fn is_specular(&self) -> bool {
        false
    }

    fn reach(&self) -> Reach {
        Reach::OneSide
    }

    fn albedo(&self, _wo: Vec3) -> Spectrum {
        Spectrum::ONE
    }
}
