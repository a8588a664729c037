//! A film on the base of [`super::OpenPbr`]: what metal, paper and glass reflect below it, and how much more paper and glass scatter by it.
//!
//! Design decision: tables hold albedos without a film. What a film changes is the mean of its effect over some microfacets; the effect is
//! evaluated at a few cosines once a surface, and interpolated.

use sahl_math::{Vec2, Vec3};

use super::film::{Substrate, ThinFilm};
use super::{OpenPbrParameters, index, unit};
use crate::bsdf::dielectric::Dielectric;
use crate::bsdf::fresnel;
use crate::bsdf::microfacet::TrowbridgeReitz;
use crate::spectrum::Spectrum;

/// The film on a base, and what it lies on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BaseFilm {
    film: ThinFilm,
    metal: Substrate,
    dielectric: Substrate,
    /// What it adds to the reflectance of paper and glass.
    effects: Effects,
}

/// What a film adds to the reflectance of an interface, at cosines whose roots are evenly spaced: enough for albedos, which average it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Effects([Spectrum; COSINES]);

/// How many cosines.
const COSINES: usize = 25;

/// The binary logarithm of how many microfacets the albedo under a film is estimated by: on paper ...
const PAPER_LOG2: u32 = 4;
/// ... on glass, where more depends on it ...
const GLASS_LOG2: u32 = 7;
/// ... and where all are nearly alike ...
const SMOOTH_LOG2: u32 = 1;
/// ... because α is less than this.
const SMOOTH_ALPHA: f32 = 0.01;

/// By how much such an estimate for glass may err: glass under a film loses that, so that it never gains any.
const GLASS_ERROR: f32 = 0.004;

impl BaseFilm {
    /// The film of a surface whose base has these colours at normal incidence and near the edge, and the index `eta`; `None` if there is none.
    pub(super) fn new(p: &OpenPbrParameters, [base, edge]: [Spectrum; 2], eta: f32) -> Option<Self> {
        let (weight, ior) = (unit(p.thin_film_weight), index(p.thin_film_ior));
        let film = ThinFilm::new(weight, p.thin_film_thickness, ior, &p.wavelengths)?;
        let dielectric = Substrate::dielectric(eta);
        // Nobody asks for those of metal.
        let effects = if unit(p.base_metalness) < 1.0 {
            Effects::new(|cos| {
                let bare = Spectrum::splat(fresnel::dielectric(cos, eta).reflectance);
                film.over(bare, cos, &dielectric) - bare
            })
        } else {
            Effects([Spectrum::ZERO; COSINES])
        };
        Some(Self { film, metal: Substrate::metal(base, edge), dielectric, effects })
    }

    /// What metal reflects that would reflect `bare`.
    #[inline]
    pub(super) fn over_metal(&self, bare: Spectrum, cos: f32) -> Spectrum {
        self.film.over(bare, cos, &self.metal)
    }

    /// What paper and glass reflect that would reflect `bare`.
    #[inline]
    pub(super) fn over_dielectric(&self, bare: Spectrum, cos: f32) -> Spectrum {
        self.film.over(bare, cos, &self.dielectric)
    }

    /// How much more the interface of paper reflects, of single scattering, seen from `wo` above.
    pub(super) fn change_of_paper(&self, facets: &TrowbridgeReitz, alpha: f32, wo: Vec3) -> Spectrum {
        mean(samples_log2(PAPER_LOG2, alpha), |u| {
            let m = facets.sample_reflecting(wo, u);
            let cos = wo.dot(m);
            let wi = m * (2.0 * cos) - wo;
            if wi.z <= 0.0 {
                return Spectrum::ZERO;
            }
            let kept = 2.0 * facets.reflecting_normalization(wo) * facets.visibility(wo, wi) * wi.z;
            self.effects.at(cos) * kept
        })
    }

    /// How much more glass scatters: light that is reflected and light that is refracted lose different shares at microfacets.
    ///
    /// Too much by what the estimate may err.
    pub(super) fn change_of_glass(&self, glass: &Dielectric, alpha: f32, wo: Vec3) -> Spectrum {
        let change = mean(samples_log2(GLASS_LOG2, alpha), |u| {
            let Some((cos, [reflected, refracted])) = glass.facet(wo, u) else { return Spectrum::ZERO };
            self.effects.at(cos) * (reflected - refracted)
        });
        change + GLASS_ERROR
    }
}

/// The number of microfacets by which a surface that is not smooth needs `rough`.
fn samples_log2(rough: u32, alpha: f32) -> u32 {
    if alpha < SMOOTH_ALPHA { SMOOTH_LOG2 } else { rough }
}

impl Effects {
    fn new(effect: impl Fn(f32) -> Spectrum) -> Self {
        Self(std::array::from_fn(|i| {
            let root = i as f32 / (COSINES - 1) as f32;
            effect(root * root)
        }))
    }

    /// The effect under a cosine, linear between those that are known.
    fn at(&self, cos: f32) -> Spectrum {
        let place = cos.clamp(0.0, 1.0).sqrt() * (COSINES - 1) as f32;
        let first = (place as usize).min(COSINES - 2);
        self.0[first] + (self.0[first + 1] - self.0[first]) * (place - first as f32)
    }
}

/// The mean over a few points of the unit square, which are Hammersley's.
fn mean(samples_log2: u32, value: impl Fn(Vec2) -> Spectrum) -> Spectrum {
    let scale = 1.0 / (1 << samples_log2) as f32;
    let mut sum = Spectrum::ZERO;
    for i in 0..1_u32 << samples_log2 {
        let reversed = i.reverse_bits() >> (32 - samples_log2);
        sum += value(Vec2::new((reversed as f32 + 0.5) * scale, (i as f32 + 0.5) * scale));
    }
    sum * scale
}
