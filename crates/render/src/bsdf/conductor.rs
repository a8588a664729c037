//! Metals.

use sahl_math::{Vec2, Vec3};

use super::microfacet::TrowbridgeReitz;
use super::{BsdfSample, Reach, Scatter, ScatterKind, flip_z, fresnel};
use crate::spectrum::Spectrum;

/// Reflects by Fresnel's equations for a complex index of refraction, from a smooth or a rough surface, on both sides.
///
/// f = F(wo·m) D(m) G₂(wo, wi) / (4 cos θo cos θi), with the halfway vector m.
///
/// In a scene file: `Material "conductor" "spectrum eta" "metal-Cu-eta" "spectrum k" "metal-Cu-k" "float roughness" .1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    eta: Spectrum,
    k: Spectrum,
    /// `None`: a mirror.
    facets: Option<TrowbridgeReitz>,
}

impl Conductor {
    /// A metal with the index `eta` + i `k` relative to the outside, and microfacets of slopes `alpha` along the
    /// tangents (see [`TrowbridgeReitz::new`]).
    #[inline]
    pub fn new(eta: Spectrum, k: Spectrum, alpha: [f32; 2]) -> Self {
        Self { eta, k, facets: TrowbridgeReitz::new(alpha[0], alpha[1]) }
    }

    #[inline]
    fn fresnel(&self, cos: f32) -> Spectrum {
        fresnel::conductor(cos, self.eta, self.k)
    }
}

/// Both directions seen from the side of `wo`, and their halfway vector; `None` unless they are on the same side.
#[inline]
fn halfway(wo: Vec3, wi: Vec3) -> Option<(Vec3, Vec3, Vec3)> {
    if wo.z * wi.z <= 0.0 {
        return None;
    }
    let (wo, wi) = (flip_z(wo, wo.z < 0.0), flip_z(wi, wi.z < 0.0));
    Some((wo, wi, (wo + wi).try_normalize()?))
}

impl Scatter for Conductor {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        match (&self.facets, halfway(wo, wi)) {
            (Some(facets), Some((wo, wi, m))) => {
                self.fresnel(wo.dot(m)) * (facets.density(m) * facets.visibility(wo, wi) * wi.z)
            }
            _ => Spectrum::ZERO,
        }
    }

    #[inline]
    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        match (&self.facets, halfway(wo, wi)) {
            (Some(facets), Some((wo, _, m))) => 0.5 * facets.density(m) / facets.reflecting_normalization(wo),
            _ => 0.0,
        }
    }

    #[inline]
    fn sample(&self, wo: Vec3, _u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        let flip = wo.z < 0.0;
        let wo = flip_z(wo, flip);
        if wo.z <= 0.0 {
            return None;
        }
        let Some(facets) = &self.facets else {
            return Some(BsdfSample {
                wi: flip_z(Vec3::new(-wo.x, -wo.y, wo.z), flip),
                weight: self.fresnel(wo.z),
                pdf: 1.0,
                kind: ScatterKind::SPECULAR_REFLECTION,
                eta: 1.0,
            });
        };
        let m = facets.sample_reflecting(wo, u);
        let cos = wo.dot(m);
        let wi = m * (2.0 * cos) - wo;
        if wi.z <= 0.0 {
            return None;
        }
        // D(m) cancels in the weight.
        let normalization = facets.reflecting_normalization(wo);
        Some(BsdfSample {
            wi: flip_z(wi, flip),
            weight: self.fresnel(cos) * (2.0 * normalization * facets.visibility(wo, wi) * wi.z),
            pdf: 0.5 * facets.density(m) / normalization,
            kind: ScatterKind::GLOSSY_REFLECTION,
            eta: 1.0,
        })
    }

    #[inline]
    fn is_specular(&self) -> bool {
        self.facets.is_none()
    }

    #[inline]
    fn reach(&self) -> Reach {
        Reach::OneSide
    }

    #[inline]
    fn albedo(&self, wo: Vec3) -> Spectrum {
        self.fresnel(wo.z.abs())
    }
}
