//! The OpenPBR surface: fuzz over a coat over a base that is metal, glass or paper, or anything between.
//!
//! Design decision: layers are put on each other by albedo scaling: what lies below gets the light that the layer above does
//! not scatter back to `wo`, by a table of directional albedos. Energy that scatters more than once between microfacets
//! is given back to each lobe apart (Turquin 2019), before metal and dielectric are mixed. A surface that absorbs nothing
//! thus scatters all light, at any roughness and metalness. The price is reciprocity, which albedo scaling gives up. A film on the base
//! changes what its microfacets reflect ([`film`]), and hence the albedos: by a few samples of them, beside those in the tables.
//!
//! Source: *OpenPBR Surface*, version 1.1, Academy Software Foundation, 2024; Turquin, *Practical Multiple Scattering
//! Compensation for Microfacet Models*, 2019. Deviations: subsurface scattering is diffuse, by its colour; fuzz is that of
//! Estevez and Kulla; the coat tints by its colour whatever the angle; every lobe is at least slightly rough; light that glass lets pass
//! counts as kept where the coat darkens; rough glass under a film loses 0.4 %, by which its albedo may be in error.
//!
//! Deliberately absent: the interior of glass (depth, scattering, dispersion), the anisotropy of the coat, what the index of the coat does
//! to the reflection of the base, and opacity. Emission is an area light's, which asks [`OpenPbr::veil`] for what the layers let out.
//!
//! In a scene file: `Material "openpbr" "rgb base_color" [ .9 .7 .3 ] "float base_metalness" 1 "float coat_weight" 1`.

mod albedo;
mod base_film;
mod darkening;
mod film;
mod lobes;

use std::f32::consts::FRAC_1_PI;

use sahl_math::{Vec2, Vec3};

use super::dielectric::{Dielectric, Whole};
use super::microfacet::{SMOOTH_ALPHA, TrowbridgeReitz};
use super::{BsdfSample, Reach, Scatter, ScatterKind, flip_z, fresnel};
use crate::spectrum::{Spectrum, Wavelengths};
use crate::warp;
use albedo::{Albedos, INDEX_RANGE, albedos};
use base_film::BaseFilm;
use darkening::{Darkening, mean_reflectance};
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
    pub coat_darkening: f32,
    pub fuzz_weight: f32,
    pub fuzz_color: Spectrum,
    pub fuzz_roughness: f32,
    pub thin_film_weight: f32,
    pub thin_film_thickness: f32,
    pub thin_film_ior: f32,
    pub thin_walled: bool,
    /// What the lanes of the colours stand for.
    pub wavelengths: Wavelengths,
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
    film: Option<BaseFilm>,
    /// Reflectances at normal incidence, of the metal and of the rest, with the film.
    normal: [Spectrum; 2],
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
    darkening: Darkening,
}

/// What each lobe is scaled by, seen from `wo`, and how likely it is drawn.
struct Scales {
    fuzz: f32,
    coat: f32,
    metal: Spectrum,
    specular: Spectrum,
    diffuse: Spectrum,
    below_coat: Spectrum,
    pmf: [f32; LOBES],
}

/// What the layers over the base scatter and let pass, seen from one direction.
struct Layers {
    fuzz: f32,
    fuzz_albedo: f32,
    below_fuzz: f32,
    coat_gain: f32,
    coat_albedo: f32,
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
        let metal = MetalFresnel::new(base, color(p.specular_color));
        let film = BaseFilm::new(p, [base, color(p.specular_color)], eta);
        let mut surface = Self {
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
                darkening: Darkening::NONE,
            },
            facets: TrowbridgeReitz::never_smooth(alphas),
            alpha,
            metalness: unit(p.base_metalness),
            metal,
            film,
            normal: [Spectrum::ZERO; 2],
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
        };
        surface.normal = [surface.metal_reflectance(1.0), surface.dielectric_reflectance(1.0)];
        if coat_weight > 0.0 {
            surface.coat.darkening =
                surface.darkening(coat_weight * unit(p.coat_darkening), unit(p.specular_roughness));
        }
        surface
    }

    /// How the coat darkens the base, by `weight` of the full effect; `roughness` is that of the base alone.
    ///
    /// OpenPBR 1.1, "Darkening". What glass lets pass is no loss: it does not go to and fro.
    fn darkening(&self, weight: f32, roughness: f32) -> Darkening {
        let [metal, specular] = self.normal;
        let specular_color = self.specular_color * specular;
        let paper = specular_color + (Spectrum::ONE - specular_color) * self.diffuse;
        let glass = specular_color + (Spectrum::ONE - specular) * self.transmission_color;
        let dielectric = paper * (1.0 - self.transmission) + glass * self.transmission;
        // Paper below an interface is rough, as far as light gets there.
        let paper_roughness = 1.0 + (roughness - 1.0) * fresnel_normal(self.eta);
        let dielectric_roughness = paper_roughness + (roughness - paper_roughness) * self.transmission;
        let eta = self.coat.eta;
        Darkening {
            weight,
            rough_return: 1.0 - (1.0 - mean_reflectance(eta)) / (eta * eta),
            roughness: dielectric_roughness + (roughness - dielectric_roughness) * self.metalness,
            base_albedo: metal * self.metal_weight + dielectric * (1.0 - self.metalness),
        }
    }

    /// What the metal reflects under the cosine `cos`, before its weight.
    #[inline]
    fn metal_reflectance(&self, cos: f32) -> Spectrum {
        let bare = self.metal.at(cos);
        self.film.as_ref().map_or(bare, |film| film.over_metal(bare, cos))
    }

    /// What paper and glass reflect under the cosine `cos`, that of the ray outside, before their tint.
    #[inline]
    fn dielectric_reflectance(&self, cos: f32) -> Spectrum {
        let bare = Spectrum::splat(fresnel::dielectric(cos, self.eta).reflectance);
        self.film.as_ref().map_or(bare, |film| film.over_dielectric(bare, cos))
    }

    /// What the layers over the base do under the cosine `cos`.
    fn layers(&self, cos: f32) -> Layers {
        let albedos = self.albedos;
        let fuzz_albedo = albedos.fuzz(cos, self.fuzz.alpha);
        let fuzz = self.fuzz.weight / fuzz_albedo.max(1.0);
        let coat_mirror = albedos.mirror(cos, self.coat.alpha);
        let coat_gain = gain(fresnel_normal(self.coat.eta), coat_mirror);
        let coat_albedo = (albedos.reflected(cos, self.coat.alpha, self.coat.eta) * coat_gain).min(1.0);
        Layers { fuzz, fuzz_albedo, below_fuzz: 1.0 - fuzz * fuzz_albedo, coat_gain, coat_albedo }
    }

    /// The share of light from the base that the layers over it let out under the cosine `cos`. The colour of a coat is that of light which
    /// passes it twice (OpenPBR 1.1, "Coat"); light from the base passes it once.
    pub(crate) fn veil(&self, cos: f32) -> Spectrum {
        let layers = self.layers(cos);
        let coated = self.coat.color.sqrt() * (self.coat.weight * (1.0 - layers.coat_albedo));
        (coated + (1.0 - self.coat.weight)) * layers.below_fuzz
    }

    fn scales(&self, wo: Vec3) -> Scales {
        let (cos, albedos) = (wo.z.abs(), self.albedos);
        let Layers { fuzz, fuzz_albedo, below_fuzz, coat_gain, coat_albedo } = self.layers(cos);
        // The coat, and what it lets through.
        let coat = below_fuzz * self.coat.weight * coat_gain;
        let coated = self.coat.color * (self.coat.weight * (1.0 - coat_albedo));
        let below_coat =
            (coated + (1.0 - self.coat.weight)) * below_fuzz * self.coat.darkening.at(cos, self.coat.eta);
        // The base.
        let mirror = albedos.mirror(cos, self.alpha);
        let opaque = (1.0 - self.metalness) * (1.0 - self.transmission);
        let metal_gain = self.normal[0].map(|normal| gain(normal, mirror));
        let specular_gain = self.normal[1].map(|normal| gain(normal, mirror));
        let bare = Spectrum::splat(albedos.reflected(cos, self.alpha, self.eta));
        let single = match &self.film {
            Some(film) if opaque > 0.0 => bare + film.change_of_paper(&self.facets, self.alpha, above(wo)),
            _ => bare,
        };
        let specular_albedo = (single * specular_gain).clamp(0.0, 1.0);
        let metal = below_coat * metal_gain * self.metal_weight;
        let specular = below_coat * self.specular_color * specular_gain * opaque;
        let diffuse = below_coat * (Spectrum::ONE - self.specular_color * specular_albedo) * opaque;
        let shares = [
            fuzz * fuzz_albedo * self.fuzz.color.max_component(),
            below_fuzz * self.coat.weight * coat_albedo,
            (metal * self.normal[0] * mirror + specular * specular_albedo / specular_gain).max_component(),
            (diffuse * self.diffuse).max_component(),
            below_coat.max_component() * (1.0 - self.metalness) * self.transmission,
        ];
        let sum: f32 = shares.iter().sum();
        let pmf = if sum > 0.0 { shares.map(|share| share / sum) } else { [0.0; LOBES] };
        Scales { fuzz, coat, metal, specular, diffuse, below_coat, pmf }
    }

    /// What refraction and reflection at glass are scaled by; apart from the others, since no density needs it.
    fn glass_scale(&self, wo: Vec3) -> Spectrum {
        Spectrum::splat((1.0 - self.metalness) * self.transmission) / self.glass_albedo(wo)
    }

    fn glass_albedo(&self, wo: Vec3) -> Spectrum {
        let albedo = if self.thin_walled {
            Spectrum::splat(self.albedos.mirror(wo.z.abs(), self.alpha))
        } else {
            let bare = Spectrum::splat(self.albedos.glass(wo.z.abs(), self.alpha, self.eta, wo.z < 0.0));
            let change = |film: &BaseFilm| film.change_of_glass(&self.glass, self.alpha, wo);
            bare + self.film.as_ref().map_or(Spectrum::ZERO, change)
        };
        // Next to nothing is lost where next to nothing is there to be scaled.
        albedo.map(|albedo| if albedo > 0.0 { albedo } else { 1.0 })
    }

    /// The lobes on the side of `wo`; both directions and `m`, halfway between them, above.
    fn reflected(&self, scales: &Scales, wo: Vec3, wi: Vec3, m: Vec3) -> Spectrum {
        let cos = wo.dot(m);
        let fuzz = scales.fuzz * fuzz_density(m.z, self.fuzz.alpha) * fuzz_visibility(wo.z, wi.z) * wi.z;
        let coat = scales.coat
            * fresnel::dielectric(cos, self.coat.eta).reflectance
            * reflection(&self.coat.facets, wo, wi, m);
        let mut base = Spectrum::ZERO;
        if self.metalness > 0.0 {
            base += scales.metal * self.metal_reflectance(cos);
        }
        if self.metalness < 1.0 {
            base += scales.specular * self.dielectric_reflectance(cos);
        }
        let diffuse = rough_diffuse(self.diffuse, self.diffuse_roughness, wo, wi);
        self.fuzz.color * fuzz
            + coat
            + base * reflection(&self.facets, wo, wi, m)
            + scales.diffuse * diffuse * (1.0 - self.diffuse_transmission)
    }

    /// Whether light passes through the base: metal lets none.
    #[inline]
    fn has_glass(&self) -> bool {
        self.transmission > 0.0 && self.metalness < 1.0
    }

    /// Refraction, and reflection at glass.
    fn through(&self, scales: &Scales, wo: Vec3, wi: Vec3) -> Spectrum {
        if !self.has_glass() {
            return Spectrum::ZERO;
        }
        let transmits = wo.z * wi.z < 0.0;
        let tint = if transmits { self.transmission_color } else { self.specular_color };
        let value = if self.thin_walled {
            let light = |(share, m, wo, wi): (Spectrum, Vec3, Vec3, Vec3)| {
                share * reflection(&self.facets, wo, wi, m)
            };
            self.pane(wo, wi).map_or(Spectrum::ZERO, light)
        } else if self.film.is_some() {
            let light = |whole: Whole| self.glass_share(whole.cos_above, transmits) * whole.value;
            self.glass.whole(wo, wi).map_or(Spectrum::ZERO, light)
        } else {
            self.glass.eval(wo, wi)
        };
        scales.below_coat * tint * self.glass_scale(wo) * value
    }

    /// The share that glass under a film lets through or reflects, given the cosine above.
    fn glass_share(&self, cos: f32, transmits: bool) -> Spectrum {
        let r = self.dielectric_reflectance(cos);
        if transmits { Spectrum::ONE - r } else { r }
    }

    /// The share that a thin wall reflects or lets through between two directions, which are then both above, with the
    /// microfacet between them.
    fn pane(&self, wo: Vec3, wi: Vec3) -> Option<(Spectrum, Vec3, Vec3, Vec3)> {
        let (wo, wi, transmits) = (above(wo), above(wi), wo.z * wi.z < 0.0);
        let m = (wo + wi).try_normalize()?;
        let r = self.pane_reflectance(wo.dot(m));
        Some((if transmits { Spectrum::ONE - r } else { r }, m, wo, wi))
    }

    /// The reflectance of both faces of a thin wall together: see [`super::ThinDielectric`].
    fn pane_reflectance(&self, cos: f32) -> Spectrum {
        let r = self.dielectric_reflectance(cos);
        2.0 * r / (r + 1.0)
    }

    fn through_pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if self.thin_walled {
            let pdf = |(share, m, wo, _): (Spectrum, Vec3, Vec3, Vec3)| {
                share.average() * reflection_pdf(&self.facets, wo, m)
            };
            self.pane(wo, wi).map_or(0.0, pdf)
        } else if self.film.is_some() {
            let transmits = wo.z * wi.z < 0.0;
            let pdf = |whole: Whole| self.glass_share(whole.cos_above, transmits).average() * whole.pdf;
            self.glass.whole(wo, wi).map_or(0.0, pdf)
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
                let through = u_lobe >= self.pane_reflectance(cos).average();
                let kind =
                    if through { ScatterKind::GLOSSY_TRANSMISSION } else { ScatterKind::GLOSSY_REFLECTION };
                (side(wi, through), kind, 1.0)
            }
            4 if self.film.is_some() => {
                let transmits = |cos: f32| u_lobe >= self.dielectric_reflectance(cos).average();
                let (wi, through) = self.glass.sample_shared(wo, u, transmits)?;
                match (through, wo.z < 0.0) {
                    (false, _) => (wi, ScatterKind::GLOSSY_REFLECTION, 1.0),
                    (true, false) => (wi, ScatterKind::GLOSSY_TRANSMISSION, self.glass.eta()),
                    (true, true) => (wi, ScatterKind::GLOSSY_TRANSMISSION, 1.0 / self.glass.eta()),
                }
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
        let is_thick = !self.has_glass() && self.diffuse_transmission == 0.0;
        if is_thick { Reach::OneSide } else { Reach::BothSides }
    }

    fn albedo(&self, wo: Vec3) -> Spectrum {
        let scales = self.scales(wo);
        let metal = self.normal[0] * self.metal_weight;
        let glass = (1.0 - self.metalness) * self.transmission;
        (scales.below_coat * (metal + glass)
            + scales.specular * self.normal[1]
            + scales.diffuse * self.diffuse
            + self.coat.weight * fresnel_normal(self.coat.eta))
        .clamp(0.0, 1.0)
    }
}
