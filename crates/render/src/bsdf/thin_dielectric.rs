//! Panes.

use sahl_math::{Vec2, Vec3};

use super::{BsdfSample, Reach, Scatter, ScatterKind, fresnel};
use crate::spectrum::Spectrum;

/// A pane of glass so thin that what it lets through goes straight on: both of its faces at once.
///
/// With the reflectance R of one face and T = 1 − R, light that bounces between the faces adds up to
///
/// - R' = R + T² R / (1 − R²), reflected like a mirror,
/// - T' = 1 − R', unchanged in direction.
///
/// Source: Stokes, *On the Intensity of the Light Reflected from or Transmitted through a Pile of Plates*, 1860; Pharr,
/// Jakob, Humphreys, *Physically Based Rendering*, 4th ed., 2023, section 9.5.
///
/// In a scene file: `Material "thindielectric" "float eta" 1.5`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinDielectric {
    eta: f32,
}

impl ThinDielectric {
    /// A pane whose inside has `eta` times the index of refraction of its surroundings. Where `eta` is no index at all,
    /// not positive or not finite, light passes.
    #[inline]
    pub fn new(eta: f32) -> Self {
        Self { eta: if eta > 0.0 && eta.is_finite() { eta } else { 1.0 } }
    }

    /// R'.
    #[inline]
    fn reflectance(&self, wo: Vec3) -> f32 {
        // T² R / (1 − R²) = T R / (1 + R), which has a value for R = 1 too.
        let r = fresnel::dielectric(wo.z.abs(), self.eta).reflectance;
        r + (1.0 - r) * r / (1.0 + r)
    }
}

impl Scatter for ThinDielectric {
    #[inline]
    fn eval(&self, _wo: Vec3, _wi: Vec3) -> Spectrum {
        Spectrum::ZERO
    }

    #[inline]
    fn pdf(&self, _wo: Vec3, _wi: Vec3) -> f32 {
        0.0
    }

    #[inline]
    fn sample(&self, wo: Vec3, u_lobe: f32, _u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let reflectance = self.reflectance(wo);
        let (wi, pdf, kind) = if u_lobe < reflectance {
            (Vec3::new(-wo.x, -wo.y, wo.z), reflectance, ScatterKind::SPECULAR_REFLECTION)
        } else {
            (-wo, 1.0 - reflectance, ScatterKind::SPECULAR_TRANSMISSION)
        };
        Some(BsdfSample { wi, weight: Spectrum::ONE, pdf, kind, eta: 1.0 })
    }

    #[inline]
    fn is_specular(&self) -> bool {
        true
    }

    #[inline]
    fn reach(&self) -> Reach {
        Reach::BothSides
    }

    #[inline]
    fn albedo(&self, _wo: Vec3) -> Spectrum {
        Spectrum::ONE
    }
}
