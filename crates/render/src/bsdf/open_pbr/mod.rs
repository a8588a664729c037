//! The OpenPBR surface: fuzz over a coat over a base that is metal, glass or paper, or anything between.
//!
//! Design decision: layers are put on each other by albedo scaling: what lies below gets the light that the layer above does
//! not scatter back to `wo`, by a table of directional albedos. Energy that scatters more than once between microfacets
//! is given back to each lobe apart (Turquin 2019), before metal and dielectric are mixed. A surface that absorbs nothing
//! thus scatters all light, at any roughness and metalness. The price is reciprocity, which albedo scaling gives up.
//!
//! Source: *OpenPBR Surface*, version 1.1, Academy Software Foundation, 2024; Turquin, *Practical Multiple Scattering
//! Compensation for Microfacet Models*, 2019. Deviations: subsurface scattering is diffuse, by its colour; fuzz is that of
//! Estevez and Kulla; the coat tints by its colour whatever the angle; every lobe is at least slightly rough.
//!
//! Deliberately absent: the interior of glass (depth, scattering, dispersion), thin films, darkening below the coat and its
//! anisotropy, opacity, and emission, which is an area light's.

mod albedo;
mod lobes;

use std::f32::consts::FRAC_1_PI;

use sahl_math::{Vec2, Vec3};

use super::microfacet::{SMOOTH_ALPHA, TrowbridgeReitz};
use super::{BsdfSample, Dielectric, Reach, Scatter, ScatterKind, flip_z, fresnel};
use crate::spectrum::Spectrum;
use crate::warp;
use albedo::{Albedos, INDEX_RANGE, albedos};
use lobes::{MetalFresnel, fuzz_density, fuzz_visibility, reflection, reflection_pdf, rough_diffuse};

/// The parameters of an OpenPBR surface at a point, by the names of its specification. Colours and weights lie in
/// [0, 1] and are limited to it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "the specification of OpenPBR is their documentation")]
pub struct OpenPbrParameters {
    pub base_weight: f32,
    pub base_color: Spectrum,
    pub base_diffuse_roughness: f32,
    pub base_metalness: f32,
    pub specular_weight: f32,
    pub specular_color: Spectrum,
    pub specular_roughness: f32,
    pub specular_anisotropy: f32,
    pub specular_ior: f32,
    pub transmission_weight: f32,
    pub transmission_color: Spectrum,
    pub subsurface_weight: f32,
    pub subsurface_color: Spectrum,
    pub coat_weight: f32,
    pub coat_color: Spectrum,
    pub coat_roughness: f32,
    pub coat_ior: f32,
    pub fuzz_weight: f32,
    pub fuzz_color: Spectrum,
    pub fuzz_roughness: f32,
    pub thin_walled: bool,
}

/// Scattering of an OpenPBR surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenPbr {
    albedos: &'static Albedos,
    fuzz: Fuzz,
    coat: Coating,
    /// Microfacets of the base, and an isotropic α that stands for them in tables.
    facets: TrowbridgeReitz,
    alpha: f32,
    metalness: f32,
    metal: MetalFresnel,
    /// Of the metal's reflection.
    metal_weight: f32,
    eta: f32,
    specular_color: Spectrum,
    diffuse: Spectrum,
    diffuse_roughness: f32,
    /// Share of the diffuse light that goes through a thin wall.
    diffuse_transmission: f32,
    transmission: f32,
    transmission_color: Spectrum,
    glass: Dielectric,
    thin_walled: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Fuzz {
    weight: f32,
    color: Spectrum,
    alpha: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Coating {
    weight: f32,
    color: Spectrum,
    facets: TrowbridgeReitz,
    alpha: f32,
    eta: f32,
}

/// What each lobe is scaled by, seen from `wo`, and how likely it is drawn.
struct Scales {
    fuzz: f32,
    coat: f32,
    metal: Spectrum,
    specular: Spectrum,
    diffuse: Spectrum,
    glass: f32,
    below_coat: Spectrum,
    pmf: [f32; LOBES],
}

/// Fuzz, coat, base reflection, diffuse, glass.
const LOBES: usize = 5;

/// Below this index a rough interface deflects too little for its microfacets to be told from the directions.
const LEAST_GLASS_INDEX: f32 = 1.01;

/// Sheens with less roughness have no albedo to speak of: glTF's limit.
const LEAST_FUZZ_ALPHA: f32 = 0.07;

fn unit(x: f32) -> f32 {
    if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) }
}

/// α of a roughness.
fn slope(roughness: f32) -> f32 {
    (unit(roughness) * unit(roughness)).max(SMOOTH_ALPHA)
}

impl OpenPbr {
    /// The surface with the given parameters.
    pub fn new(p: &OpenPbrParameters) -> Self {
        let color = |color: Spectrum| color.clamp(0.0, 1.0);
        let coat_weight = unit(p.coat_weight);
        let roughness = roughened(unit(p.specular_roughness), unit(p.coat_roughness), coat_weight);
        let (alpha, anisotropy) = (slope(roughness), 1.0 - unit(p.specular_anisotropy));
        let alpha_x = (alpha * (2.0 / (1.0 + anisotropy * anisotropy)).sqrt()).min(1.0);
        let alphas = [alpha_x, (alpha_x * anisotropy).max(SMOOTH_ALPHA)];
        let eta = weighted_index(p.specular_ior, p.specular_weight);
        let base = color(p.base_color * unit(p.base_weight));
        let subsurface = unit(p.subsurface_weight);
        let coat_alpha = slope(p.coat_roughness);
        Self {
            albedos: albedos(),
            fuzz: Fuzz {
                weight: unit(p.fuzz_weight),
                color: color(p.fuzz_color),
                alpha: (unit(p.fuzz_roughness) * unit(p.fuzz_roughness)).max(LEAST_FUZZ_ALPHA),
            },
            coat: Coating {
                weight: coat_weight,
                color: color(p.coat_color),
                facets: TrowbridgeReitz::never_smooth([coat_alpha; 2]),
                alpha: coat_alpha,
                eta: index(p.coat_ior),
            },
            facets: TrowbridgeReitz::never_smooth(alphas),
            alpha,
            metalness: unit(p.base_metalness),
            metal: MetalFresnel::new(base, color(p.specular_color)),
            metal_weight: unit(p.base_metalness) * unit(p.specular_weight),
            eta,
            specular_color: color(p.specular_color),
            diffuse: base * (1.0 - subsurface) + color(p.subsurface_color) * subsurface,
            diffuse_roughness: unit(p.base_diffuse_roughness),
            diffuse_transmission: if p.thin_walled { 0.5 * subsurface } else { 0.0 },
            transmission: unit(p.transmission_weight),
            transmission_color: color(p.transmission_color),
            glass: Dielectric::new(eta.max(LEAST_GLASS_INDEX), alphas),
            thin_walled: p.thin_walled,
        }
    }

    fn scales(&self, wo: Vec3) -> Scales {
        let (cos, albedos) = (wo.z.abs(), self.albedos);
        // Fuzz.
        let fuzz_albedo = albedos.fuzz(cos, self.fuzz.alpha);
        let fuzz = self.fuzz.weight / fuzz_albedo.max(1.0);
        let below_fuzz = 1.0 - fuzz * fuzz_albedo;
        // The coat, and what it lets through.
        let coat_mirror = albedos.mirror(cos, self.coat.alpha);
        let coat_gain = gain(fresnel_normal(self.coat.eta), coat_mirror);
        let coat_albedo = (albedos.reflected(cos, self.coat.alpha, self.coat.eta) * coat_gain).min(1.0);
        let coat = below_fuzz * self.coat.weight * coat_gain;
        let coated = self.coat.color * (self.coat.weight * (1.0 - coat_albedo));
        let below_coat = (coated + (1.0 - self.coat.weight)) * below_fuzz;
        // The base.
        let mirror = albedos.mirror(cos, self.alpha);
        let opaque = (1.0 - self.metalness) * (1.0 - self.transmission);
        let metal_gain = self.metal.normal.map(|normal| gain(normal, mirror));
        let specular_gain = gain(fresnel_normal(self.eta), mirror);
        let specular_albedo = (albedos.reflected(cos, self.alpha, self.eta) * specular_gain).min(1.0);
        let metal = below_coat * metal_gain * self.metal_weight;
        let specular = below_coat * self.specular_color * (opaque * specular_gain);
        let diffuse = below_coat * (Spectrum::ONE - self.specular_color * specular_albedo) * opaque;
        let glass = (1.0 - self.metalness) * self.transmission / self.glass_albedo(wo, mirror);
        let shares = [
            fuzz * fuzz_albedo * self.fuzz.color.max_component(),
            below_fuzz * self.coat.weight * coat_albedo,
            (metal * self.metal.normal * mirror + specular * (specular_albedo / specular_gain))
                .max_component(),
            (diffuse * self.diffuse).max_component(),
            below_coat.max_component() * (1.0 - self.metalness) * self.transmission,
        ];
        let sum: f32 = shares.iter().sum();
        let pmf = if sum > 0.0 { shares.map(|share| share / sum) } else { [0.0; LOBES] };
        Scales { fuzz, coat, metal, specular, diffuse, glass, below_coat, pmf }
    }

    fn glass_albedo(&self, wo: Vec3, mirror: f32) -> f32 {
        let albedo = if self.thin_walled {
            mirror
        } else {
            self.albedos.glass(wo.z.abs(), self.alpha, self.eta, wo.z < 0.0)
        };
        // Next to nothing is lost where next to nothing is there to be scaled.
        if albedo > 0.0 { albedo } else { 1.0 }
    }

    /// The lobes on the side of `wo`; both directions and `m`, halfway between them, above.
    fn reflected(&self, scales: &Scales, wo: Vec3, wi: Vec3, m: Vec3) -> Spectrum {
        let cos = wo.dot(m);
        let fuzz = scales.fuzz * fuzz_density(m.z, self.fuzz.alpha) * fuzz_visibility(wo.z, wi.z) * wi.z;
        let coat = scales.coat
            * fresnel::dielectric(cos, self.coat.eta).reflectance
            * reflection(&self.coat.facets, wo, wi, m);
        let base = scales.metal * self.metal.at(cos)
            + scales.specular * fresnel::dielectric(cos, self.eta).reflectance;
        let diffuse = rough_diffuse(self.diffuse, self.diffuse_roughness, wo, wi);
        self.fuzz.color * fuzz
            + coat
            + base * reflection(&self.facets, wo, wi, m)
            + scales.diffuse * diffuse * (1.0 - self.diffuse_transmission)
    }

    /// Refraction, and reflection at glass.
    fn through(&self, scales: &Scales, wo: Vec3, wi: Vec3) -> Spectrum {
        if self.transmission == 0.0 {
            return Spectrum::ZERO;
        }
        let transmits = wo.z * wi.z < 0.0;
        let tint = if transmits { self.transmission_color } else { self.specular_color };
        let value = if self.thin_walled {
            self.pane(wo, wi).map_or(0.0, |(share, m, wo, wi)| share * reflection(&self.facets, wo, wi, m))
        } else {
            self.glass.eval(wo, wi).max_component()
        };
        scales.below_coat * tint * (scales.glass * value)
    }

    /// The share that a thin wall reflects or lets through between two directions, which are then both above, with the
    /// microfacet between them.
    fn pane(&self, wo: Vec3, wi: Vec3) -> Option<(f32, Vec3, Vec3, Vec3)> {
        let (wo, wi, transmits) = (above(wo), above(wi), wo.z * wi.z < 0.0);
        let m = (wo + wi).try_normalize()?;
        let r = pane_reflectance(wo.dot(m), self.eta);
        Some((if transmits { 1.0 - r } else { r }, m, wo, wi))
    }

    fn through_pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if self.thin_walled {
            self.pane(wo, wi).map_or(0.0, |(share, m, wo, _)| share * reflection_pdf(&self.facets, wo, m))
        } else {
            self.glass.pdf(wo, wi)
        }
    }

    fn value(&self, scales: &Scales, wo: Vec3, wi: Vec3) -> Spectrum {
        let through = self.through(scales, wo, wi);
        let (up_o, up_i) = (above(wo), above(wi));
        if wo.z * wi.z < 0.0 {
            let share = self.diffuse_transmission;
            return through + scales.diffuse * self.diffuse * (share * up_i.z * FRAC_1_PI);
        }
        match (up_o + up_i).try_normalize() {
            Some(m) => through + self.reflected(scales, up_o, up_i, m),
            None => through,
        }
    }

    fn density(&self, scales: &Scales, wo: Vec3, wi: Vec3) -> f32 {
        let [fuzz, coat, base, diffuse, glass] = scales.pmf;
        let cosine = wi.z.abs() * FRAC_1_PI;
        let through = if glass > 0.0 { glass * self.through_pdf(wo, wi) } else { 0.0 };
        if wo.z * wi.z < 0.0 {
            return through + diffuse * self.diffuse_transmission * cosine;
        }
        let (wo, wi) = (above(wo), above(wi));
        let Some(m) = (wo + wi).try_normalize() else { return through };
        through
            + (fuzz + diffuse * (1.0 - self.diffuse_transmission)) * cosine
            + coat * reflection_pdf(&self.coat.facets, wo, m)
            + base * reflection_pdf(&self.facets, wo, m)
    }

    /// Draws a direction by lobe number `lobe`; `u_lobe` is what is left of the number that chose it.
    fn draw(&self, lobe: usize, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<(Vec3, ScatterKind, f32)> {
        let side =
            |w: Vec3, through: bool| Vec3::new(w.x, w.y, if (wo.z < 0.0) != through { -w.z } else { w.z });
        let mirrored = |facets: &TrowbridgeReitz| {
            let wo = above(wo);
            let m = facets.sample_reflecting(wo, u);
            let cos = wo.dot(m);
            let wi = m * (2.0 * cos) - wo;
            (wi.z > 0.0).then_some((wi, cos))
        };
        Some(match lobe {
            1 => (side(mirrored(&self.coat.facets)?.0, false), ScatterKind::GLOSSY_REFLECTION, 1.0),
            2 => (side(mirrored(&self.facets)?.0, false), ScatterKind::GLOSSY_REFLECTION, 1.0),
            4 if self.thin_walled => {
                let (wi, cos) = mirrored(&self.facets)?;
                let through = u_lobe >= pane_reflectance(cos, self.eta);
                let kind =
                    if through { ScatterKind::GLOSSY_TRANSMISSION } else { ScatterKind::GLOSSY_REFLECTION };
                (side(wi, through), kind, 1.0)
            }
            4 => {
                let sample = self.glass.sample(wo, u_lobe, u)?;
                (sample.wi, sample.kind, sample.eta)
            }
            _ => {
                let through = lobe == 3 && u_lobe < self.diffuse_transmission;
                let kind =
                    if through { ScatterKind::DIFFUSE_TRANSMISSION } else { ScatterKind::DIFFUSE_REFLECTION };
                (side(warp::cosine_hemisphere(u), through), kind, 1.0)
            }
        })
    }
}

/// `w` mirrored to above.
#[inline]
fn above(w: Vec3) -> Vec3 {
    flip_z(w, w.z < 0.0)
}

/// An index of refraction that the tables have.
fn index(eta: f32) -> f32 {
    if eta.is_nan() { 1.5 } else { eta.clamp(INDEX_RANGE[0], INDEX_RANGE[1]) }
}

/// The index whose reflectance at normal incidence is `weight` times that of `eta`.
fn weighted_index(eta: f32, weight: f32) -> f32 {
    if weight >= 1.0 {
        return index(eta);
    }
    let root = (fresnel_normal(index(eta)) * unit(weight)).sqrt();
    index((1.0 + root) / (1.0 - root))
}

/// The reflectance of an interface at normal incidence.
fn fresnel_normal(eta: f32) -> f32 {
    let root = (eta - 1.0) / (eta + 1.0);
    root * root
}

/// The reflectance of both faces of a thin wall together: see [`super::ThinDielectric`].
fn pane_reflectance(cos: f32, eta: f32) -> f32 {
    let r = fresnel::dielectric(cos, eta).reflectance;
    2.0 * r / (1.0 + r)
}

/// What a lobe gains by light that bounces more than once, of which `normal` is kept each time (Turquin 2019).
fn gain(normal: f32, mirror: f32) -> f32 {
    1.0 + normal * (1.0 - mirror) / mirror
}

/// The roughness of the base as it is seen through a rough coat: OpenPBR 1.1, "roughening".
fn roughened(base: f32, coat: f32, weight: f32) -> f32 {
    let both = (base.powi(4) + 2.0 * coat.powi(4)).min(1.0).sqrt().sqrt();
    base + (both - base) * weight
}

impl Scatter for OpenPbr {
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        if wo.z == 0.0 || wi.z == 0.0 {
            return Spectrum::ZERO;
        }
        self.value(&self.scales(wo), wo, wi)
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z == 0.0 || wi.z == 0.0 {
            return 0.0;
        }
        self.density(&self.scales(wo), wo, wi)
    }

    fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let scales = self.scales(wo);
        let (mut lobe, mut left) = (0, u_lobe);
        while lobe + 1 < LOBES && left >= scales.pmf[lobe] {
            left -= scales.pmf[lobe];
            lobe += 1;
        }
        let probability = scales.pmf[lobe];
        if probability <= 0.0 {
            return None;
        }
        let u_lobe = (left / probability).clamp(0.0, 1.0 - f32::EPSILON / 2.0);
        let (wi, kind, eta) = self.draw(lobe, wo, u_lobe, u)?;
        if wi.z == 0.0 || kind.is_transmission() != (wo.z * wi.z < 0.0) {
            return None;
        }
        let pdf = self.density(&scales, wo, wi);
        let weight = self.value(&scales, wo, wi) / pdf;
        let usable = pdf > 0.0 && pdf.is_finite() && weight.is_finite();
        usable.then_some(BsdfSample { wi, weight, pdf, kind, eta })
    }

    #[inline]
    fn is_specular(&self) -> bool {
        false
    }

    #[inline]
    fn reach(&self) -> Reach {
        let is_thick = self.transmission == 0.0 && self.diffuse_transmission == 0.0;
        if is_thick { Reach::OneSide } else { Reach::BothSides }
    }

    fn albedo(&self, wo: Vec3) -> Spectrum {
        let scales = self.scales(wo);
        let metal = self.metal.normal * self.metal_weight;
        let glass = (1.0 - self.metalness) * self.transmission;
        (scales.below_coat * (metal + glass)
            + scales.specular * fresnel_normal(self.eta)
            + scales.diffuse * self.diffuse
            + self.coat.weight * fresnel_normal(self.coat.eta))
        .clamp(0.0, 1.0)
    }
}
