//! Matter in which light spreads.

use std::sync::Arc;

use sahl_scene::{Diagnostics, Span, SubsurfaceScattering};

use super::{Query, Roughness, SharedTables};
use crate::bsdf::{Dielectric, Entry};
use crate::interaction::Interaction;
use crate::spectrum::{ColorRole, Spectrum};
use crate::subsurface::{Bssrdf, DiffusionTable};
use crate::texture::{SpectrumSource, Textures};

/// The parameters of matter in which light spreads.
#[derive(Clone, Debug, PartialEq)]
pub struct SubsurfaceSource {
    scattering: Scattering,
    scale: f32,
    eta: f32,
    roughness: Roughness,
    table: Arc<DiffusionTable>,
    /// See [`Entry::scale`].
    entry_scale: f32,
}

#[derive(Clone, Debug, PartialEq)]
enum Scattering {
    /// Absorption and scattering.
    Coefficients([SpectrumSource; 2]),
    /// Effective albedo and mean free path.
    Reflectance([SpectrumSource; 2]),
}

impl SubsurfaceSource {
    pub(super) fn new(
        subsurface: &sahl_scene::Subsurface,
        textures: &Textures,
        shared: &mut SharedTables,
        span: Option<Span>,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        let mut source = |param, role| textures.spectrum_source(param, role, span, diagnostics);
        let (scattering, scale) = match &subsurface.scattering {
            SubsurfaceScattering::Coefficients { sigma_a, sigma_s, scale } => {
                let sources = [sigma_a, sigma_s].map(|param| source(param, ColorRole::Unbounded));
                (Scattering::Coefficients(sources), *scale)
            }
            SubsurfaceScattering::Reflectance { reflectance, mean_free_path, scale } => {
                let reflectance = source(reflectance, ColorRole::Albedo);
                let mean_free_path = source(mean_free_path, ColorRole::Unbounded);
                (Scattering::Reflectance([reflectance, mean_free_path]), *scale)
            }
        };
        Self {
            scattering,
            scale,
            eta: subsurface.eta,
            roughness: Roughness::new(&subsurface.roughness, textures),
            table: shared.diffusion(subsurface.g, subsurface.eta),
            entry_scale: Entry::scale(subsurface.eta),
        }
    }

    /// What the surface itself does to light.
    #[inline(never)]
    pub(super) fn surface(&self, query: &Query<'_>) -> Dielectric {
        Dielectric::new(self.eta, self.roughness.alpha(query))
    }

    /// What the surface does to light that comes out elsewhere.
    pub(crate) fn entry(&self) -> Entry {
        Entry::with_scale(self.eta, self.entry_scale)
    }

    /// How light spreads below the point `at`.
    pub(crate) fn bssrdf(&self, at: &Interaction, query: &Query<'_>) -> Bssrdf<'_> {
        let coefficients = match &self.scattering {
            Scattering::Coefficients(sources) => {
                sources.each_ref().map(|source| (query.spectrum(source) * self.scale).clamp(0.0, f32::MAX))
            }
            Scattering::Reflectance([reflectance, mean_free_path]) => {
                let albedo = query.spectrum(reflectance).map(|reflectance| self.table.albedo_of(reflectance));
                let length = query.spectrum(mean_free_path) * self.scale;
                // Light that goes nowhere leaves where it came: the shortest way that can be computed with.
                let per_length = length.map(|length| 1.0 / length.max(f32::MIN_POSITIVE.sqrt()));
                [(Spectrum::ONE - albedo) * per_length, albedo * per_length]
            }
        };
        Bssrdf::new(at, self.eta, &self.table, coefficients)
    }
}
