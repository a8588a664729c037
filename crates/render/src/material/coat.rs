//! Materials below a coat.

use sahl_scene::{Diagnostics, SceneDesc, Span};

use super::{ConductorReflectance, Query, Roughness};
use crate::bsdf::room::Large;
use crate::bsdf::{Bsdf, BsdfRoom, Coat, Coated, Conductor, Dielectric, Diffuse};
use crate::sampler::hash::mix;
use crate::spectrum::{ColorRole, SpectralCurve, Spectrum};
use crate::texture::{FloatSource, SpectrumSource, Textures};

/// A base below a coat.
#[derive(Clone, Debug, PartialEq)]
pub struct CoatedSource {
    base: CoatedBase,
    eta: SpectralCurve,
    roughness: Roughness,
    thickness: FloatSource,
    g: FloatSource,
    albedo: SpectrumSource,
    max_depth: u32,
    samples: u32,
    is_bright: bool,
}

/// What is below a coat.
#[derive(Clone, Debug, PartialEq)]
pub enum CoatedBase {
    /// Lambertian reflection, by its albedo.
    Diffuse(SpectrumSource),
    /// A metal, as it is without the coat.
    Conductor(ConductorReflectance, Roughness),
}

impl CoatedBase {
    /// The base of a coated material of a scene; black for others.
    pub(super) fn new(
        material: &sahl_scene::Material,
        textures: &Textures,
        span: Option<Span>,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        match material {
            sahl_scene::Material::CoatedDiffuse { reflectance, .. } => {
                Self::Diffuse(textures.spectrum_source(reflectance, ColorRole::Albedo, span, diagnostics))
            }
            sahl_scene::Material::CoatedConductor { reflectance, roughness, .. } => Self::Conductor(
                ConductorReflectance::new(reflectance, textures, span, diagnostics),
                Roughness::new(roughness, textures),
            ),
            _ => Self::Diffuse(SpectrumSource::Constant(SpectralCurve::constant(0.0))),
        }
    }
}

impl CoatedSource {
    pub(super) fn new(
        base: CoatedBase,
        coat: &sahl_scene::Coat,
        (scene, textures): (&SceneDesc, &Textures),
        span: Option<Span>,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        Self {
            base,
            eta: SpectralCurve::new(&coat.eta, ColorRole::Unbounded, span, diagnostics),
            roughness: Roughness::new(&coat.roughness, textures),
            thickness: textures.float_source(&coat.thickness),
            g: textures.float_source(&coat.g),
            albedo: textures.spectrum_source(&coat.albedo, ColorRole::Albedo, span, diagnostics),
            max_depth: coat.max_depth,
            samples: coat.samples,
            is_bright: scene.quirks.bright_coats,
        }
    }

    #[inline(never)]
    pub(super) fn bsdf<'r>(&self, query: &mut Query<'_>, room: &'r mut BsdfRoom) -> Bsdf<'r> {
        let surface = Dielectric::new(query.index(&self.eta), self.roughness.alpha(query));
        let coat = Coat {
            surface,
            thickness: query.float(&self.thickness),
            g: query.float(&self.g),
            albedo: query.spectrum(&self.albedo),
            max_depth: self.max_depth,
            samples: self.samples,
            is_bright: self.is_bright,
        };
        let place = place(query);
        room.keep(match &self.base {
            CoatedBase::Diffuse(reflectance) => {
                let base = Diffuse::new(query.spectrum(reflectance));
                Large::CoatedDiffuse(Coated::new(coat, base, place))
            }
            CoatedBase::Conductor(reflectance, roughness) => {
                // Seen from within the coat.
                let (eta, k) = reflectance.index(query);
                let inside = Spectrum::splat(surface.eta());
                let base = Conductor::new(eta / inside, k / inside, roughness.alpha(query));
                Large::CoatedConductor(Coated::new(coat, base, place))
            }
        })
    }
}

/// A hash of the point.
fn place(query: &Query<'_>) -> u64 {
    let [x, y, z] = <[f32; 3]>::from(query.at.p).map(|x| u64::from(x.to_bits()));
    mix(mix(x << 32 | y).wrapping_add(z))
}
