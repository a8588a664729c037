//! Glass, water and other transparent matter.

use sahl_math::{Vec2, Vec3};

use super::microfacet::TrowbridgeReitz;
use super::{BsdfSample, Reach, Scatter, ScatterKind, flip_z, fresnel};
use crate::spectrum::Spectrum;

/// Reflects and refracts by Fresnel's equations, at a smooth or a rough surface.
///
/// The inside is below the surface, z < 0. With η the index on the side of wi over that on the side of wo, and m the
/// halfway vector of reflection, or of refraction (along wo + η wi):
///
/// - f_r = F D G₂ / (4 |cos θo cos θi|)
/// - f_t = (1 − F) D G₂ |wo·m wi·m| / (|cos θo cos θi| (wi·m + wo·m / η)² η²)
///
/// Source: Walter et al., *Microfacet Models for Refraction through Rough Surfaces*, EGSR 2007, equations 20 and 21;
/// G₂ = 1 / (1 + Λ(wo) + Λ(wi)) for both, as in pbrt-v4.
///
/// In a scene file: `Material "dielectric" "float eta" 1.5 "float roughness" .01`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    eta: f32,
    /// `None`: a smooth surface.
    facets: Option<TrowbridgeReitz>,
}

impl Dielectric {
    /// An interface with the index of refraction `eta` below over above, and microfacets of slopes `alpha` along the
    /// tangents (see [`TrowbridgeReitz::new`]).
    ///
    /// With `eta` = 1 light goes straight through, whatever the microfacets. So it does where `eta` is no index at all:
    /// not positive or not finite.
    #[inline]
    pub fn new(eta: f32, alpha: [f32; 2]) -> Self {
        let eta = if eta > 0.0 && eta.is_finite() { eta } else { 1.0 };
        let facets = if eta == 1.0 { None } else { TrowbridgeReitz::new(alpha[0], alpha[1]) };
        Self { eta, facets }
    }

    /// Whether `wo` is below, `wo` mirrored to above, and the index on the far side over that on the near side.
    #[inline]
    fn upright(&self, wo: Vec3) -> (bool, Vec3, f32) {
        let flip = wo.z < 0.0;
        (flip, flip_z(wo, flip), if flip { 1.0 / self.eta } else { self.eta })
    }

    #[inline]
    fn configuration(&self, wo: Vec3, wi: Vec3) -> Option<Configuration> {
        let facets = self.facets?;
        if wo.z * wi.z == 0.0 {
            return None;
        }
        let (flip, wo, eta) = self.upright(wo);
        let wi = flip_z(wi, flip);
        let reflection = wi.z > 0.0;
        let m = (if reflection { wo + wi } else { wo + wi * eta }).try_normalize()?;
        Configuration::new(facets, eta, wo, wi, upward(m))
    }

    /// The delta lobes.
    #[inline]
    fn sample_smooth(&self, wo: Vec3, u_lobe: f32) -> Option<BsdfSample> {
        let (flip, wo, eta) = self.upright(wo);
        let fresnel = fresnel::dielectric(wo.z, eta);
        let (wi, weight, pdf, kind, eta) = if u_lobe < fresnel.reflectance {
            let mirrored = Vec3::new(-wo.x, -wo.y, wo.z);
            (mirrored, 1.0, fresnel.reflectance, ScatterKind::SPECULAR_REFLECTION, 1.0)
        } else {
            let refracted = Vec3::new(-wo.x / eta, -wo.y / eta, -fresnel.cos_transmitted);
            let pdf = 1.0 - fresnel.reflectance;
            (refracted, 1.0 / (eta * eta), pdf, ScatterKind::SPECULAR_TRANSMISSION, eta)
        };
        Some(BsdfSample { wi: flip_z(wi, flip), weight: Spectrum::splat(weight), pdf, kind, eta })
    }

    /// The lobes of a rough surface.
    #[inline]
    fn sample_rough(&self, facets: TrowbridgeReitz, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        let lobe = self.rough_lobe(facets, wo, u, |reflectance, _| u_lobe >= reflectance)?;
        let (kind, eta) = match lobe.transmitted {
            true => (ScatterKind::GLOSSY_TRANSMISSION, lobe.configuration.eta),
            false => (ScatterKind::GLOSSY_REFLECTION, 1.0),
        };
        let pdf = lobe.configuration.pdf(lobe.share);
        (pdf > 0.0 && pdf.is_finite()).then(|| BsdfSample {
            wi: flip_z(lobe.configuration.wi, wo.z < 0.0),
            weight: Spectrum::splat(lobe.configuration.weight()),
            pdf,
            kind,
            eta,
        })
    }

    /// A direction by a visible microfacet; `transmits` chooses the lobe, given the reflectance of the microfacet and the cosine above it.
    #[inline]
    fn rough_lobe(
        &self,
        facets: TrowbridgeReitz,
        wo: Vec3,
        u: Vec2,
        transmits: impl FnOnce(f32, f32) -> bool,
    ) -> Option<RoughLobe> {
        let (flip, wo, eta) = self.upright(wo);
        let m = facets.sample_visible(wo, u);
        let cos = wo.dot(m);
        let fresnel = fresnel::dielectric(cos, eta);
        let cos_above = if flip { fresnel.cos_transmitted } else { cos };
        let transmitted = transmits(fresnel.reflectance, cos_above);
        let (wi, share) = if transmitted {
            let inverse_eta = 1.0 / eta;
            let along = cos * inverse_eta - fresnel.cos_transmitted;
            let share = fresnel::transmittance(cos, fresnel.cos_transmitted, eta);
            (m * along - wo * inverse_eta, share)
        } else {
            (m * (2.0 * cos) - wo, fresnel.reflectance)
        };
        if (wi.z < 0.0) != transmitted {
            return None;
        }
        let configuration = Configuration::new(facets, eta, wo, wi, m)?;
        Some(RoughLobe { configuration, share, transmitted, cos_above })
    }

    /// Draws a direction by a visible microfacet of a rough surface whose light is shared by others than Fresnel: `transmits` chooses the
    /// lobe, given the cosine above the microfacet. With the direction, whether it is refracted. `None` for smooth surfaces, too.
    pub(super) fn sample_shared(
        &self,
        wo: Vec3,
        u: Vec2,
        transmits: impl FnOnce(f32) -> bool,
    ) -> Option<(Vec3, bool)> {
        let lobe = self.rough_lobe(self.facets?, wo, u, |_, cos_above| transmits(cos_above))?;
        Some((flip_z(lobe.configuration.wi, wo.z < 0.0), lobe.transmitted))
    }

    /// What a rough surface would scatter from `wi` if all light went that way.
    pub(super) fn whole(&self, wo: Vec3, wi: Vec3) -> Option<Whole> {
        let configuration = self.configuration(wo, wi)?;
        let pdf = configuration.pdf(1.0);
        let is_below = wo.z < 0.0;
        let cos_above = match (is_below, wo.z * wi.z < 0.0) {
            (false, _) => configuration.wo_dot_m,
            (true, true) => -configuration.wi_dot_m,
            (true, false) => fresnel::dielectric(configuration.wo_dot_m, configuration.eta).cos_transmitted,
        };
        Some(Whole { value: configuration.weight() * pdf, pdf, cos_above })
    }

    /// A visible microfacet of a rough surface: the cosine above it, and what it scatters if it sends all light by reflection, and by
    /// refraction, the compression of radiance left out.
    pub(super) fn facet(&self, wo: Vec3, u: Vec2) -> Option<(f32, [f32; 2])> {
        let facets = self.facets?;
        let lobe = |transmits: bool| self.rough_lobe(facets, wo, u, |_, _| transmits);
        let (reflected, refracted) = (lobe(false), lobe(true));
        let cos_above = reflected.as_ref().or(refracted.as_ref())?.cos_above;
        let weight = |lobe: &RoughLobe| lobe.configuration.weight();
        let eta2 = refracted.as_ref().map_or(1.0, |lobe| lobe.configuration.eta * lobe.configuration.eta);
        let weights = [
            reflected.as_ref().map_or(0.0, weight),
            refracted.as_ref().map_or(0.0, |lobe| weight(lobe) * eta2),
        ];
        Some((cos_above, weights))
    }

    /// Draws a direction by reflection alone, or by refraction alone where `transmits` is set.
    ///
    /// For surfaces that are made of this interface and something below it. `None` also where the lobe has no light.
    #[inline]
    pub(super) fn sample_lobe(&self, wo: Vec3, transmits: bool, u: Vec2) -> Option<LobeSample> {
        if wo.z == 0.0 {
            return None;
        }
        let (flip, upright, eta) = self.upright(wo);
        let Some(facets) = self.facets else {
            let fresnel = fresnel::dielectric(upright.z, eta);
            let (wi, share, weight) = if transmits {
                let share = 1.0 - fresnel.reflectance;
                let wi = Vec3::new(-wo.x / eta, -wo.y / eta, -fresnel.cos_transmitted);
                (wi, share, share / (eta * eta))
            } else {
                (Vec3::new(-wo.x, -wo.y, upright.z), fresnel.reflectance, fresnel.reflectance)
            };
            let usable = share > 0.0 && wi.z != 0.0;
            return usable.then(|| LobeSample { wi: flip_z(wi, flip), weight, pdf: 1.0, share });
        };
        let lobe = self.rough_lobe(facets, wo, u, |_, _| transmits)?;
        let pdf = lobe.configuration.pdf(1.0);
        (lobe.share > 0.0 && pdf > 0.0 && pdf.is_finite()).then(|| LobeSample {
            wi: flip_z(lobe.configuration.wi, flip),
            weight: lobe.share * lobe.configuration.weight(),
            pdf,
            share: lobe.share,
        })
    }

    /// Density per steradian with which [`Dielectric::sample_lobe`] draws `wi` by the lobe of its side.
    #[inline]
    pub(super) fn lobe_pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.configuration(wo, wi).map_or(0.0, |configuration| configuration.pdf(1.0))
    }

    /// Index of refraction below over above.
    #[inline]
    pub(crate) fn eta(&self) -> f32 {
        self.eta
    }
}

/// A direction that a rough surface scatters to.
struct RoughLobe {
    configuration: Configuration,
    /// [`Configuration::share`].
    share: f32,
    transmitted: bool,
    /// The cosine between the ray on the upper side and the microfacet; zero where it is reflected totally from below.
    cos_above: f32,
}

/// What a rough surface would scatter if all light went one way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Whole {
    /// f |cos θi|.
    pub(super) value: f32,
    /// Density per steradian among the directions of the lobe.
    pub(super) pdf: f32,
    /// The cosine between the ray on the upper side and the microfacet; zero where it is reflected totally from below.
    pub(super) cos_above: f32,
}

/// A direction drawn by one of the lobes alone.
#[derive(Clone, Copy, Debug)]
pub(super) struct LobeSample {
    pub(super) wi: Vec3,
    /// f |cos θi| / `pdf`.
    pub(super) weight: f32,
    /// Density per steradian among the directions of the lobe; one for a delta lobe.
    pub(super) pdf: f32,
    /// The share of light that the lobe has at the microfacet that was drawn.
    pub(super) share: f32,
}

/// `m`, turned round if needed to point up.
#[inline]
fn upward(m: Vec3) -> Vec3 {
    if m.z < 0.0 { -m } else { m }
}

/// A pair of directions at a rough surface, mirrored such that `wo` is above, with the microfacet that connects them.
struct Configuration {
    facets: TrowbridgeReitz,
    /// Index below over above.
    eta: f32,
    wo: Vec3,
    wi: Vec3,
    m: Vec3,
    wo_dot_m: f32,
    wi_dot_m: f32,
}

impl Configuration {
    /// `None` where the microfacet shows its back to a direction.
    #[inline]
    fn new(facets: TrowbridgeReitz, eta: f32, wo: Vec3, wi: Vec3, m: Vec3) -> Option<Self> {
        let (wo_dot_m, wi_dot_m) = (wo.dot(m), wi.dot(m));
        (wo_dot_m > 0.0 && wi_dot_m * wi.z > 0.0).then_some(Self {
            facets,
            eta,
            wo,
            wi,
            m,
            wo_dot_m,
            wi_dot_m,
        })
    }

    /// Share of the light that the microfacet sends this way.
    #[inline]
    fn share(&self) -> f32 {
        if self.wi.z > 0.0 {
            fresnel::dielectric(self.wo_dot_m, self.eta).reflectance
        } else {
            fresnel::transmittance(self.wo_dot_m, -self.wi_dot_m, self.eta)
        }
    }

    /// Solid angle of normals m over that of directions wi (Walter et al. 2007, equations 14 and 17).
    #[inline]
    fn jacobian(&self) -> f32 {
        if self.wi.z > 0.0 {
            0.25 / self.wo_dot_m
        } else {
            let s = self.wi_dot_m + self.wo_dot_m / self.eta;
            -self.wi_dot_m / (s * s)
        }
    }

    /// Density of wi per steradian, `share` being [`Configuration::share`].
    #[inline]
    fn pdf(&self, share: f32) -> f32 {
        self.facets.visible_density_over_cos(self.wo, self.m) * self.wo_dot_m * self.jacobian() * share
    }

    /// f |cos θi| / pdf: D, the Jacobian and the share cancel.
    #[inline]
    fn weight(&self) -> f32 {
        let masking = self.facets.visibility(self.wo, self.wi) * self.wi.z.abs();
        let weight = 2.0 * masking * (self.wo.z + self.facets.stretched_length(self.wo));
        if self.wi.z > 0.0 { weight } else { weight / (self.eta * self.eta) }
    }
}

impl Scatter for Dielectric {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        match self.configuration(wo, wi) {
            Some(configuration) => {
                Spectrum::splat(configuration.weight() * configuration.pdf(configuration.share()))
            }
            None => Spectrum::ZERO,
        }
    }

    #[inline]
    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.configuration(wo, wi).map_or(0.0, |configuration| configuration.pdf(configuration.share()))
    }

    #[inline]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        match self.facets {
            None => self.sample_smooth(wo, u_lobe),
            Some(facets) => self.sample_rough(facets, wo, u_lobe, u),
        }
    }

    #[inline]
    fn is_specular(&self) -> bool {
        self.facets.is_none()
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
