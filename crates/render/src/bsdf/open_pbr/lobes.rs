//! Formulas of the layers of [`super::OpenPbr`].

use std::f32::consts::{FRAC_1_PI, PI};

use sahl_math::{Vec3, safe_sqrt};

use crate::bsdf::microfacet::TrowbridgeReitz;
use crate::spectrum::Spectrum;

/// The cosine at which the tint of a metal's edge is given, 82 degrees.
const EDGE: f32 = 1.0 / 7.0;

/// The Fresnel reflectance of a metal, by its colour at normal incidence and a tint near the edge.
///
/// F = F₀ + (1 − F₀)(1 − c)⁵ − b c (1 − c)⁶. Source: Kutz, Hašan, Edmondson, *Novel Aspects of the Adobe Standard
/// Material*, 2021 (F82-tint), as OpenPBR uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MetalFresnel {
    pub(super) normal: Spectrum,
    b: Spectrum,
}

fn schlick(normal: Spectrum, cos: f32) -> Spectrum {
    let x = 1.0 - cos;
    normal + (Spectrum::ONE - normal) * (x * x * x * x * x)
}

impl MetalFresnel {
    pub(super) fn new(normal: Spectrum, edge: Spectrum) -> Self {
        let x = 1.0 - EDGE;
        let scale = 1.0 / (EDGE * x * x * x * x * x * x);
        Self { normal, b: schlick(normal, EDGE) * (Spectrum::ONE - edge) * scale }
    }

    #[inline]
    pub(super) fn at(&self, cos: f32) -> Spectrum {
        let cos = cos.clamp(0.0, 1.0);
        let x = 1.0 - cos;
        let x3 = x * x * x;
        (schlick(self.normal, cos) - self.b * (cos * x3 * x3)).clamp(0.0, 1.0)
    }
}

/// D G₂ / (4 cos θo): reflection by microfacets that reflect everything, times |cos θi|.
#[inline]
pub(super) fn reflection(facets: &TrowbridgeReitz, wo: Vec3, wi: Vec3, m: Vec3) -> f32 {
    facets.density(m) * facets.visibility(wo, wi) * wi.z
}

/// Density per steradian of directions that reflecting microfacets are sampled by.
#[inline]
pub(super) fn reflection_pdf(facets: &TrowbridgeReitz, wo: Vec3, m: Vec3) -> f32 {
    0.5 * facets.density(m) / facets.reflecting_normalization(wo)
}

/// Rough diffuse reflection that keeps its energy, times |cos θi|; both directions above.
///
/// Source: Portsmouth, Kutz, Hill, *EON: A practical energy-preserving rough diffuse BRDF*, JCGT 14(1), 2025, with its
/// approximation of the albedo.
pub(super) fn rough_diffuse(albedo: Spectrum, roughness: f32, wo: Vec3, wi: Vec3) -> Spectrum {
    let lambert = wi.z * FRAC_1_PI;
    if roughness <= 0.0 {
        return albedo * lambert;
    }
    let (c1, c2) = (0.5 - 2.0 / (3.0 * PI), 2.0 / 3.0 - 28.0 / (15.0 * PI));
    let r = roughness.min(1.0);
    let s = wo.dot(wi) - wo.z * wi.z;
    let s_over_t = if s > 0.0 { s / wo.z.max(wi.z) } else { s };
    let a = 1.0 / (1.0 + c1 * r);
    let escaped = |cos: f32| {
        let x = 1.0 - cos;
        let g = x * (0.057_108_5 + x * (0.491_882 + x * (-0.332_181 + x * 0.071_443)));
        (1.0 + r * g) * a
    };
    let mean = a * (1.0 + c2 * r);
    let multiple = albedo * albedo * mean / (Spectrum::ONE - albedo * (1.0 - mean));
    let caught = (1.0 - escaped(wo.z)).max(0.0) * (1.0 - escaped(wi.z)).max(0.0) / (1.0 - mean);
    (albedo * (a * (1.0 + r * s_over_t)) + multiple * caught) * lambert
}

/// Density of fibres whose normal has the cosine `cos`; Estevez, Kulla, *Production Friendly Microfacet Sheen BRDF*,
/// SIGGRAPH 2017 course notes.
#[inline]
pub(super) fn fuzz_density(cos: f32, alpha: f32) -> f32 {
    let exponent = 1.0 / alpha;
    (2.0 + exponent) * safe_sqrt(1.0 - cos * cos).powf(exponent) * (0.5 * FRAC_1_PI)
}

/// Shadowing of fibres over 4 cos θo cos θi; Neubelt, Pettineo, *Crafting a Next-Gen Material Pipeline for The Order:
/// 1886*, SIGGRAPH 2013 course notes.
#[inline]
pub(super) fn fuzz_visibility(cos_o: f32, cos_i: f32) -> f32 {
    0.25 / (cos_o + cos_i - cos_o * cos_i)
}
