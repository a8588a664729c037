//! OpenPBR surfaces.

use sahl_scene::{Diagnostics, Span};

use super::Query;
use super::roughness::regularized;
use crate::bsdf::room::Large;
use crate::bsdf::{Bsdf, BsdfRoom, OpenPbr, OpenPbrParameters};
use crate::spectrum::{ColorRole, Spectrum, Wavelengths};
use crate::texture::{FloatSource, SpectrumSource, TexturePoint, Textures};

/// The parameters of an OpenPBR surface.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenPbrSource {
    base_weight: FloatSource,
    base_color: SpectrumSource,
    base_diffuse_roughness: FloatSource,
    base_metalness: FloatSource,
    specular_weight: FloatSource,
    specular_color: SpectrumSource,
    specular_roughness: FloatSource,
    specular_roughness_anisotropy: FloatSource,
    specular_ior: FloatSource,
    transmission_weight: FloatSource,
    transmission_color: SpectrumSource,
    subsurface_weight: FloatSource,
    subsurface_color: SpectrumSource,
    coat_weight: FloatSource,
    coat_color: SpectrumSource,
    coat_roughness: FloatSource,
    coat_ior: FloatSource,
    coat_darkening: FloatSource,
    fuzz_weight: FloatSource,
    fuzz_color: SpectrumSource,
    fuzz_roughness: FloatSource,
    thin_film_weight: FloatSource,
    thin_film_thickness: FloatSource,
    thin_film_ior: FloatSource,
    thin_walled: bool,
}

impl OpenPbrSource {
    pub(crate) fn new(
        surface: &sahl_scene::OpenPbr,
        textures: &Textures,
        span: Option<Span>,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        let number = |param| textures.float_source(param);
        let mut color = |param| textures.spectrum_source(param, ColorRole::Albedo, span, diagnostics);
        Self {
            base_weight: number(&surface.base_weight),
            base_color: color(&surface.base_color),
            base_diffuse_roughness: number(&surface.base_diffuse_roughness),
            base_metalness: number(&surface.base_metalness),
            specular_weight: number(&surface.specular_weight),
            specular_color: color(&surface.specular_color),
            specular_roughness: number(&surface.specular_roughness),
            specular_roughness_anisotropy: number(&surface.specular_roughness_anisotropy),
            specular_ior: number(&surface.specular_ior),
            transmission_weight: number(&surface.transmission_weight),
            transmission_color: color(&surface.transmission_color),
            subsurface_weight: number(&surface.subsurface_weight),
            subsurface_color: color(&surface.subsurface_color),
            coat_weight: number(&surface.coat_weight),
            coat_color: color(&surface.coat_color),
            coat_roughness: number(&surface.coat_roughness),
            coat_ior: number(&surface.coat_ior),
            coat_darkening: number(&surface.coat_darkening),
            fuzz_weight: number(&surface.fuzz_weight),
            fuzz_color: color(&surface.fuzz_color),
            fuzz_roughness: number(&surface.fuzz_roughness),
            thin_film_weight: number(&surface.thin_film_weight),
            thin_film_thickness: number(&surface.thin_film_thickness),
            thin_film_ior: number(&surface.thin_film_ior),
            thin_walled: surface.geometry_thin_walled,
        }
    }

    /// Whether anything lies over what the base emits.
    pub(crate) fn is_veiled(&self) -> bool {
        [&self.coat_weight, &self.fuzz_weight]
            .iter()
            .any(|weight| !matches!(weight, FloatSource::Constant(..=0.0)))
    }

    /// The share of what the base emits at the point `at` that coat and fuzz let out under the cosine `cos`.
    #[inline(never)]
    pub(crate) fn veil(
        &self,
        cos: f32,
        at: &TexturePoint,
        textures: &Textures,
        wavelengths: &Wavelengths,
    ) -> Spectrum {
        let mut wavelengths = *wavelengths;
        let query = Query { textures, at, wavelengths: &mut wavelengths, regularize: false };
        // No film on the base: it does not dim what comes from below it, and takes time.
        OpenPbr::new(&OpenPbrParameters { thin_film_weight: 0.0, ..self.parameters(&query) }).veil(cos)
    }

    #[inline(never)]
    pub(super) fn bsdf<'r>(&self, query: &Query<'_>, room: &'r mut BsdfRoom) -> Bsdf<'r> {
        room.keep(Large::OpenPbr(OpenPbr::new(&self.parameters(query))))
    }

    fn parameters(&self, query: &Query<'_>) -> OpenPbrParameters {
        let number = |source| query.float(source);
        let color = |source| query.spectrum(source);
        let roughness = |source| {
            let alpha = query.float(source) * query.float(source);
            if query.regularize { regularized(alpha).sqrt() } else { query.float(source) }
        };
        OpenPbrParameters {
            base_weight: number(&self.base_weight),
            base_color: color(&self.base_color),
            base_diffuse_roughness: number(&self.base_diffuse_roughness),
            base_metalness: number(&self.base_metalness),
            specular_weight: number(&self.specular_weight),
            specular_color: color(&self.specular_color),
            specular_roughness: roughness(&self.specular_roughness),
            specular_anisotropy: number(&self.specular_roughness_anisotropy),
            specular_ior: number(&self.specular_ior),
            transmission_weight: number(&self.transmission_weight),
            transmission_color: color(&self.transmission_color),
            subsurface_weight: number(&self.subsurface_weight),
            subsurface_color: color(&self.subsurface_color),
            coat_weight: number(&self.coat_weight),
            coat_color: color(&self.coat_color),
            coat_roughness: roughness(&self.coat_roughness),
            coat_ior: number(&self.coat_ior),
            coat_darkening: number(&self.coat_darkening),
            fuzz_weight: number(&self.fuzz_weight),
            fuzz_color: color(&self.fuzz_color),
            fuzz_roughness: number(&self.fuzz_roughness),
            thin_film_weight: number(&self.thin_film_weight),
            thin_film_thickness: number(&self.thin_film_thickness),
            thin_film_ior: number(&self.thin_film_ior),
            thin_walled: self.thin_walled,
            wavelengths: *query.wavelengths,
        }
    }
}
