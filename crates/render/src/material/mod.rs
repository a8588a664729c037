//! Materials: how a surface's parameters become a BSDF at a hit.
//!
//! Design decision: a material is a small value in the scene's list. What does not vary over the surface is computed
//! when the scene is built; at a hit, [`Material::bsdf`] looks up the rest and makes a [`Bsdf`].
//!
//! Deliberately absent: bump and normal maps, and mixtures.
//!
//! In a scene file: `Material "conductor" "rgb reflectance" [.9 .6 .3] "float roughness" .2`.

use sahl_math::safe_sqrt;
use sahl_scene::{Diagnostics, Span};

use crate::bsdf::{Bsdf, Conductor, Dielectric, Diffuse, fresnel};
use crate::spectrum::{ColorRole, SpectralCurve, Spectrum, Wavelengths};
use crate::texture::{FloatSource, SpectrumSource, TexturePoint, Textures};

/// How a surface scatters light, with its parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// Lambertian reflection.
    Diffuse {
        /// Albedo.
        reflectance: SpectrumSource,
    },
    /// A metal.
    Conductor {
        /// Its complex index of refraction, or its colour.
        reflectance: ConductorReflectance,
        /// Its microfacets.
        roughness: Roughness,
    },
    /// Glass, water: reflects and refracts.
    Dielectric {
        /// Index of refraction inside over outside.
        eta: SpectralCurve,
        /// Its microfacets.
        roughness: Roughness,
    },
}

/// How the reflectance of a metal is given.
#[derive(Clone, Debug, PartialEq)]
pub enum ConductorReflectance {
    /// By its complex index of refraction η + i k.
    Index {
        /// Real part.
        eta: SpectrumSource,
        /// Imaginary part.
        k: SpectrumSource,
    },
    /// By its colour at normal incidence, with η = 1.
    Normal(SpectrumSource),
}

/// Microfacet slopes along the two tangents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Roughness {
    /// The same everywhere.
    Constant([f32; 2]),
    /// Varying over the surface.
    Varying {
        /// Along the first tangent.
        u: FloatSource,
        /// Along the second tangent.
        v: FloatSource,
        /// Whether α is the square root of the roughness.
        remap: bool,
    },
}

impl Roughness {
    fn new(roughness: &sahl_scene::Roughness, textures: &Textures) -> Self {
        let (u, v) = (textures.float_source(&roughness.u), textures.float_source(&roughness.v));
        match (u, v) {
            (FloatSource::Constant(u), FloatSource::Constant(v)) => {
                Self::Constant([slope(u, roughness.remap), slope(v, roughness.remap)])
            }
            _ => Self::Varying { u, v, remap: roughness.remap },
        }
    }

    #[inline]
    fn alpha(&self, textures: &Textures, at: &TexturePoint) -> [f32; 2] {
        match self {
            Self::Constant(alpha) => *alpha,
            Self::Varying { u, v, remap } => {
                [slope(textures.float(u, at), *remap), slope(textures.float(v, at), *remap)]
            }
        }
    }
}

/// α of a roughness: its square root under pbrt-v4's remapping, else itself.
#[inline]
fn slope(roughness: f32, remap: bool) -> f32 {
    if remap { safe_sqrt(roughness) } else { roughness }
}

impl Material {
    /// The material of a scene; `span` is what messages point at.
    pub fn new(
        material: &sahl_scene::Material,
        textures: &Textures,
        span: Option<Span>,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        match material {
            sahl_scene::Material::Diffuse { reflectance } => Self::Diffuse {
                reflectance: textures.spectrum_source(reflectance, ColorRole::Albedo, span, diagnostics),
            },
            sahl_scene::Material::Conductor { reflectance, roughness } => Self::Conductor {
                reflectance: match reflectance {
                    sahl_scene::ConductorReflectance::Index { eta, k } => ConductorReflectance::Index {
                        eta: textures.spectrum_source(eta, ColorRole::Unbounded, span, diagnostics),
                        k: textures.spectrum_source(k, ColorRole::Unbounded, span, diagnostics),
                    },
                    sahl_scene::ConductorReflectance::Normal(color) => ConductorReflectance::Normal(
                        textures.spectrum_source(color, ColorRole::Albedo, span, diagnostics),
                    ),
                },
                roughness: Roughness::new(roughness, textures),
            },
            sahl_scene::Material::Dielectric { eta, roughness } => Self::Dielectric {
                eta: SpectralCurve::new(eta, ColorRole::Unbounded, span, diagnostics),
                roughness: Roughness::new(roughness, textures),
            },
            // Nothing asks: the borders of media are crossed, not hit.
            sahl_scene::Material::Interface => {
                Self::Diffuse { reflectance: SpectrumSource::Constant(SpectralCurve::constant(0.0)) }
            }
        }
    }

    /// How the surface scatters light at a point.
    #[inline]
    pub fn bsdf(&self, textures: &Textures, at: &TexturePoint, wavelengths: &Wavelengths) -> Bsdf {
        match self {
            Self::Diffuse { reflectance } => {
                Diffuse::new(textures.spectrum(reflectance, at, wavelengths)).into()
            }
            Self::Conductor { reflectance, roughness } => {
                let (eta, k) = match reflectance {
                    ConductorReflectance::Index { eta, k } => {
                        (textures.spectrum(eta, at, wavelengths), textures.spectrum(k, at, wavelengths))
                    }
                    ConductorReflectance::Normal(color) => {
                        let color = textures.spectrum(color, at, wavelengths);
                        (Spectrum::ONE, fresnel::absorption_of_reflectance(color))
                    }
                };
                Conductor::new(eta, k, roughness.alpha(textures, at)).into()
            }
            Self::Dielectric { eta, roughness } => {
                // One index for the whole path: there is no dispersion in RGB mode.
                let eta = match wavelengths {
                    Wavelengths::Rgb => eta.at(wavelengths).average(),
                };
                Dielectric::new(eta, roughness.alpha(textures, at)).into()
            }
        }
    }
}

#[cfg(test)]
mod tests;
