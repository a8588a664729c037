//! Surface materials.

use serde::{Deserialize, Serialize};

use crate::{FloatParam, Spectrum, SpectrumParam};

/// How a surface scatters light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Material {
    /// Lambertian reflection.
    Diffuse {
        /// Albedo.
        reflectance: SpectrumParam,
    },
    /// A metal.
    Conductor {
        /// Its Fresnel reflectance.
        reflectance: ConductorReflectance,
        /// Its microfacets.
        roughness: Roughness,
    },
    /// Glass, water: reflects and refracts.
    Dielectric {
        /// Index of refraction inside over outside.
        eta: Spectrum,
        /// Its microfacets.
        roughness: Roughness,
    },
    /// No surface, but the border of a medium: light passes it unchanged.
    Interface,
}

impl Default for Material {
    /// pbrt's default: grey paper.
    fn default() -> Self {
        Self::Diffuse { reflectance: SpectrumParam::Constant(Spectrum::Constant(0.5)) }
    }
}

/// How the reflectance of a metal is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ConductorReflectance {
    /// By its complex index of refraction η + i k.
    Index {
        /// Real part.
        eta: SpectrumParam,
        /// Imaginary part.
        k: SpectrumParam,
    },
    /// By its colour at normal incidence, with η = 1.
    Normal(SpectrumParam),
}

/// Microfacet roughness along the two tangents.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Roughness {
    /// Along the first tangent.
    pub u: FloatParam,
    /// Along the second tangent.
    pub v: FloatParam,
    /// Whether α = √roughness (pbrt-v4's remapping) rather than the roughness itself.
    pub remap: bool,
}

impl Roughness {
    /// A polished surface.
    pub const SMOOTH: Self = Self { u: FloatParam::Constant(0.0), v: FloatParam::Constant(0.0), remap: true };
}
