//! Surface materials.

use std::sync::Arc;

use sahl_image::Image;
use serde::{Deserialize, Serialize};

use crate::{FloatParam, Handle, MeasuredBrdf, OpenPbr, Spectrum, SpectrumParam};

/// How a surface scatters light.
///
/// A material that refers to others must not contain itself.
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
    /// A pane of glass that is thin enough not to shift what is seen through it.
    ThinDielectric {
        /// Index of refraction inside over outside.
        eta: Spectrum,
    },
    /// Lambertian reflection and transmission.
    DiffuseTransmission {
        /// Share of light that is reflected.
        reflectance: SpectrumParam,
        /// Share of light that passes.
        transmittance: SpectrumParam,
        /// Factor on both.
        scale: f32,
    },
    /// Lambertian reflection below a coat.
    CoatedDiffuse {
        /// Albedo of the base.
        reflectance: SpectrumParam,
        /// What lies above it.
        coat: Coat,
    },
    /// A metal below a coat.
    CoatedConductor {
        /// The metal's Fresnel reflectance, as it would be without the coat.
        reflectance: ConductorReflectance,
        /// The metal's microfacets.
        roughness: Roughness,
        /// What lies above it.
        coat: Coat,
    },
    /// A fibre: the surface of a curve, whose u goes along it and v across it.
    Hair(Hair),
    /// The layers of OpenPBR, which many other models are cases of.
    OpenPbr(Box<OpenPbr>),
    /// A smooth or rough surface of matter in which light spreads.
    Subsurface(Box<Subsurface>),
    /// A surface that was measured; materials that stand for the same measurement share it.
    Measured(Arc<MeasuredBrdf>),
    /// At each point one of two materials, chosen at random.
    Mix {
        /// The materials.
        materials: [Handle<Material>; 2],
        /// The probability of the second.
        amount: FloatParam,
    },
    /// A material with shading normals of its own.
    Relief {
        /// The material.
        material: Handle<Material>,
        /// The normals.
        relief: Relief,
    },
    /// No surface, but a boundary between media: light goes through.
    Interface,
}

impl Material {
    /// The materials that this one is made of.
    pub fn parts(&self) -> &[Handle<Self>] {
        match self {
            Self::Mix { materials, .. } => materials,
            Self::Relief { material, .. } => std::slice::from_ref(material),
            Self::Diffuse { .. }
            | Self::Conductor { .. }
            | Self::Dielectric { .. }
            | Self::ThinDielectric { .. }
            | Self::DiffuseTransmission { .. }
            | Self::CoatedDiffuse { .. }
            | Self::CoatedConductor { .. }
            | Self::Hair(_)
            | Self::OpenPbr(_)
            | Self::Subsurface(_)
            | Self::Measured(_)
            | Self::Interface => &[],
        }
    }

    /// Whether it emits light by itself, so that shapes of it are lights.
    pub fn emits(&self) -> bool {
        matches!(self, Self::OpenPbr(surface) if surface.emits())
    }
}

/// Where shading normals come from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Relief {
    /// A height above the surface, in its own units, which only turns normals: the surface stays where it is.
    Bump(FloatParam),
    /// An image of normals (n + 1) / 2 in the frame of ∂p/∂u, n × ∂p/∂u and the normal n; repeated over the plane of
    /// texture coordinates, whose v = 0 is its bottom.
    Normals(Handle<Arc<Image>>),
}

/// A clear or cloudy layer over a surface, such as varnish.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coat {
    /// Microfacets of the interface.
    pub roughness: Roughness,
    /// Index of refraction inside over outside.
    pub eta: Spectrum,
    /// Depth, in mean free paths of the matter inside.
    pub thickness: FloatParam,
    /// Mean cosine of scattering inside.
    pub g: FloatParam,
    /// Share of light that scattering inside keeps; zero for matter that only absorbs.
    pub albedo: SpectrumParam,
    /// Steps of the random walk that light takes through the coat.
    pub max_depth: u32,
    /// Random walks of an evaluation.
    pub samples: u32,
}

impl Default for Coat {
    /// pbrt-v4's defaults.
    fn default() -> Self {
        Self {
            roughness: Roughness::SMOOTH,
            eta: Spectrum::Constant(1.5),
            thickness: FloatParam::Constant(0.01),
            g: FloatParam::Constant(0.0),
            albedo: SpectrumParam::Constant(Spectrum::Constant(0.0)),
            max_depth: 10,
            samples: 1,
        }
    }
}

/// Hair and fur.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hair {
    /// What absorbs light inside.
    pub color: HairColor,
    /// Index of refraction inside over outside.
    pub eta: FloatParam,
    /// Longitudinal roughness, from zero to one.
    pub beta_m: FloatParam,
    /// Azimuthal roughness, from zero to one.
    pub beta_n: FloatParam,
    /// Tilt of the scales, in radians.
    pub alpha: FloatParam,
}

/// Matter in which light spreads: it leaves near where it entered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Subsurface {
    /// How light is lost and scattered.
    pub scattering: SubsurfaceScattering,
    /// Index of refraction inside over outside.
    pub eta: f32,
    /// Mean cosine of scattering: above −1 and below 1.
    pub g: f32,
    /// Microfacets of the surface.
    pub roughness: Roughness,
}

/// How matter in which light spreads is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum SubsurfaceScattering {
    /// By its coefficients per metre.
    Coefficients {
        /// Absorption.
        sigma_a: SpectrumParam,
        /// Scattering.
        sigma_s: SpectrumParam,
        /// Factor on both.
        scale: f32,
    },
    /// By how it looks.
    Reflectance {
        /// The share of light that has entered and leaves again somewhere.
        reflectance: SpectrumParam,
        /// How far light goes until something happens, in metres.
        mean_free_path: SpectrumParam,
        /// Factor on the mean free path.
        scale: f32,
    },
}

/// How the colour of hair is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum HairColor {
    /// Absorption per radius of the fibre.
    Absorption(SpectrumParam),
    /// The colour of many such fibres together.
    Reflectance(SpectrumParam),
    /// Concentrations of the two natural pigments.
    Melanin {
        /// Of brown and black hair.
        eumelanin: FloatParam,
        /// Of red hair.
        pheomelanin: FloatParam,
    },
}

impl Default for Hair {
    /// pbrt-v4's default: brown.
    fn default() -> Self {
        Self {
            color: HairColor::Melanin {
                eumelanin: FloatParam::Constant(1.3),
                pheomelanin: FloatParam::Constant(0.0),
            },
            eta: FloatParam::Constant(1.55),
            beta_m: FloatParam::Constant(0.3),
            beta_n: FloatParam::Constant(0.3),
            alpha: FloatParam::Constant(2_f32.to_radians()),
        }
    }
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
