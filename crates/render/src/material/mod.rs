//! Materials: how a surface's parameters become a BSDF at a hit.
//!
//! Design decision: a material is a small value in the scene's list. What does not vary over the surface is computed
//! when the scene is built; at a hit, [`Material::bsdf`] looks up the rest and makes a [`Bsdf`]. Materials made of others
//! are taken apart before, when the hit becomes an interaction (`composition`): what scatters is always a plain material.
//!
//! In a scene file: `Material "conductor" "rgb reflectance" [.9 .6 .3] "float roughness" .2`.

mod coat;
mod composition;
mod hair;
mod open_pbr;
mod relief;
mod roughness;
mod shared;
mod subsurface;

use std::sync::Arc;

use sahl_scene::{Diagnostics, SceneDesc, Span};

use crate::bsdf::{
    Bsdf, BsdfRoom, Conductor, Dielectric, Diffuse, DiffuseTransmission, Measured, MeasuredTables,
    ThinDielectric, fresnel,
};
use crate::spectrum::{ColorRole, SpectralCurve, Spectrum, Wavelengths};
use crate::texture::{FloatSource, SpectrumSource, TexturePoint, Textures};

pub use coat::{CoatedBase, CoatedSource};
pub use composition::Composition;
pub(crate) use composition::traits;
pub use hair::HairSource;
pub use open_pbr::OpenPbrSource;
pub use relief::Relief;
pub use roughness::Roughness;
pub(crate) use shared::SharedTables;
pub use subsurface::SubsurfaceSource;

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
    /// A pane.
    ThinDielectric {
        /// Index of refraction inside over outside.
        eta: SpectralCurve,
    },
    /// Lambertian reflection and transmission.
    DiffuseTransmission {
        /// Share of light that is reflected.
        reflectance: SpectrumSource,
        /// Share of light that passes.
        transmittance: SpectrumSource,
        /// Factor on both.
        scale: f32,
    },
    /// A base below a coat.
    Coated(Box<CoatedSource>),
    /// A fibre.
    Hair(Box<HairSource>),
    /// The layers of OpenPBR.
    OpenPbr(Box<OpenPbrSource>),
    /// Matter in which light spreads.
    Subsurface(Box<SubsurfaceSource>),
    /// A measured surface.
    Measured(Arc<MeasuredTables>),
    /// No scattering of its own, but other materials.
    Composition(Composition),
    /// A boundary between media: light goes through.
    Interface,
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

/// What a material is asked about: a point, and the light of a path.
#[derive(Debug)]
pub struct Query<'a> {
    /// The textures of the scene.
    pub textures: &'a Textures,
    /// The point.
    pub at: &'a TexturePoint,
    /// What the lanes stand for; glass whose index varies with the wavelength leaves only the first.
    pub wavelengths: &'a mut Wavelengths,
    /// Whether nearly smooth surfaces are made rougher, so that light can be found by them that no path finds
    /// otherwise. Biased: see [`Roughness`].
    pub regularize: bool,
}

impl Query<'_> {
    #[inline]
    fn float(&self, source: &FloatSource) -> f32 {
        self.textures.float(source, self.at)
    }

    #[inline]
    fn spectrum(&self, source: &SpectrumSource) -> Spectrum {
        self.textures.spectrum(source, self.at, self.wavelengths)
    }

    /// An index of refraction: one for the whole path.
    #[inline]
    fn index(&mut self, eta: &SpectralCurve) -> f32 {
        eta.index(self.wavelengths)
    }
}

impl ConductorReflectance {
    fn new(
        reflectance: &sahl_scene::ConductorReflectance,
        textures: &Textures,
        span: Option<Span>,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        let mut source = |param, role| textures.spectrum_source(param, role, span, diagnostics);
        match reflectance {
            sahl_scene::ConductorReflectance::Index { eta, k } => {
                Self::Index { eta: source(eta, ColorRole::Unbounded), k: source(k, ColorRole::Unbounded) }
            }
            sahl_scene::ConductorReflectance::Normal(color) => Self::Normal(source(color, ColorRole::Albedo)),
        }
    }

    /// η and k relative to empty space.
    #[inline]
    fn index(&self, query: &Query<'_>) -> (Spectrum, Spectrum) {
        match self {
            Self::Index { eta, k } => (query.spectrum(eta), query.spectrum(k)),
            Self::Normal(color) => (Spectrum::ONE, fresnel::absorption_of_reflectance(query.spectrum(color))),
        }
    }
}

impl Material {
    /// The material of `scene`; `span` is what messages point at.
    pub(crate) fn new(
        material: &sahl_scene::Material,
        (scene, textures): (&SceneDesc, &Textures),
        shared: &mut SharedTables,
        span: Option<Span>,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        use sahl_scene::Material as Description;
        match material {
            Description::Diffuse { reflectance } => Self::Diffuse {
                reflectance: textures.spectrum_source(reflectance, ColorRole::Albedo, span, diagnostics),
            },
            Description::Conductor { reflectance, roughness } => Self::Conductor {
                reflectance: ConductorReflectance::new(reflectance, textures, span, diagnostics),
                roughness: Roughness::new(roughness, textures),
            },
            Description::Dielectric { eta, roughness } => Self::Dielectric {
                eta: SpectralCurve::new(eta, ColorRole::Unbounded, span, diagnostics),
                roughness: Roughness::new(roughness, textures),
            },
            Description::ThinDielectric { eta } => {
                Self::ThinDielectric { eta: SpectralCurve::new(eta, ColorRole::Unbounded, span, diagnostics) }
            }
            Description::DiffuseTransmission { reflectance, transmittance, scale } => {
                let mut albedo =
                    |param| textures.spectrum_source(param, ColorRole::Albedo, span, diagnostics);
                Self::DiffuseTransmission {
                    reflectance: albedo(reflectance),
                    transmittance: albedo(transmittance),
                    scale: *scale,
                }
            }
            Description::CoatedDiffuse { coat, .. } | Description::CoatedConductor { coat, .. } => {
                let base = CoatedBase::new(material, textures, span, diagnostics);
                Self::Coated(Box::new(CoatedSource::new(base, coat, (scene, textures), span, diagnostics)))
            }
            Description::Hair(hair) => {
                Self::Hair(Box::new(HairSource::new(hair, textures, span, diagnostics)))
            }
            Description::OpenPbr(surface) => {
                Self::OpenPbr(Box::new(OpenPbrSource::new(surface, textures, span, diagnostics)))
            }
            Description::Subsurface(subsurface) => Self::Subsurface(Box::new(SubsurfaceSource::new(
                subsurface,
                textures,
                shared,
                span,
                diagnostics,
            ))),
            Description::Measured(brdf) => Self::Measured(shared.measured(brdf, span, diagnostics)),
            Description::Mix { materials, amount } => {
                Self::Composition(Composition::mix(*materials, textures.float_source(amount)))
            }
            Description::Relief { material, relief } => Self::Composition(Composition::Relief {
                material: material.index() as u32,
                relief: Relief::new(relief, scene, textures),
            }),
            Description::Interface => Self::Interface,
        }
    }

    /// How the surface scatters light at a point; `room` is where a BSDF with many parameters is kept.
    ///
    /// An interface, and a composition that was not taken apart, let light pass.
    #[inline]
    pub fn bsdf<'r>(&'r self, query: &mut Query<'_>, room: &'r mut BsdfRoom) -> Bsdf<'r> {
        match self {
            Self::Diffuse { reflectance } => Diffuse::new(query.spectrum(reflectance)).into(),
            Self::Conductor { reflectance, roughness } => {
                let (eta, k) = reflectance.index(query);
                Conductor::new(eta, k, roughness.alpha(query)).into()
            }
            Self::Dielectric { eta, roughness } => {
                Dielectric::new(query.index(eta), roughness.alpha(query)).into()
            }
            Self::ThinDielectric { eta } => ThinDielectric::new(query.index(eta)).into(),
            Self::DiffuseTransmission { reflectance, transmittance, scale } => {
                let (r, t) = (query.spectrum(reflectance), query.spectrum(transmittance));
                DiffuseTransmission::new(r * *scale, t * *scale).into()
            }
            Self::Coated(source) => source.bsdf(query, room),
            Self::Hair(source) => source.bsdf(query, room),
            Self::OpenPbr(source) => source.bsdf(query, room),
            Self::Subsurface(source) => source.surface(query).into(),
            Self::Measured(tables) => Measured::new(tables, query.wavelengths).into(),
            Self::Composition(_) | Self::Interface => Dielectric::new(1.0, [0.0; 2]).into(),
        }
    }
}

#[cfg(test)]
mod tests;
