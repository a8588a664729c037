//! The OpenPBR surface.

use serde::{Deserialize, Serialize};

use crate::{FloatParam, Spectrum, SpectrumParam};

/// The parameters of an OpenPBR 1.1 surface, with the names of its specification.
///
/// The renderer's documentation says where it deviates. Bumps and normal maps are those of [`crate::Relief`]. A surface that emits makes
/// its shapes lights, as an [`crate::AreaLight`] does. Deliberately absent: what the renderer does not have, such as the interior of glass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct OpenPbr {
    /// Factor on the colour of the base.
    pub base_weight: FloatParam,
    /// Colour of paper and metal.
    pub base_color: SpectrumParam,
    /// Roughness of paper.
    pub base_diffuse_roughness: FloatParam,
    /// From paper or glass to metal.
    pub base_metalness: FloatParam,
    /// Strength of reflections at the base.
    pub specular_weight: FloatParam,
    /// Tint of reflections at paper or glass, and of the edges of metal.
    pub specular_color: SpectrumParam,
    /// Roughness of the base; α is its square.
    pub specular_roughness: FloatParam,
    /// From round to stretched highlights.
    pub specular_roughness_anisotropy: FloatParam,
    /// Index of refraction of paper or glass, from 1 to 3.
    pub specular_ior: FloatParam,
    /// From paper to glass.
    pub transmission_weight: FloatParam,
    /// Tint of what glass lets through.
    pub transmission_color: SpectrumParam,
    /// From paper to what scatters light below the surface.
    pub subsurface_weight: FloatParam,
    /// Colour of the latter.
    pub subsurface_color: SpectrumParam,
    /// Presence of a coat.
    pub coat_weight: FloatParam,
    /// Tint of what lies below the coat.
    pub coat_color: SpectrumParam,
    /// Roughness of the coat.
    pub coat_roughness: FloatParam,
    /// Index of refraction of the coat, from 1 to 3.
    pub coat_ior: FloatParam,
    /// How much of the darkening that light suffers below the coat is shown.
    pub coat_darkening: FloatParam,
    /// Presence of fuzz.
    pub fuzz_weight: FloatParam,
    /// Colour of fuzz.
    pub fuzz_color: SpectrumParam,
    /// Roughness of fuzz.
    pub fuzz_roughness: FloatParam,
    /// Presence of a thin film on the base.
    pub thin_film_weight: FloatParam,
    /// Thickness of the film, in micrometres.
    pub thin_film_thickness: FloatParam,
    /// Index of refraction of the film, from 1 to 3.
    pub thin_film_ior: FloatParam,
    /// Luminance of what the base emits, from its front; from both sides of a thin wall. In the unit of the scene's radiance.
    pub emission_luminance: f32,
    /// Colour of the emission, below coat and fuzz. Of luminance one if white.
    pub emission_color: SpectrumParam,
    /// Whether the surface is a wall without an inside: glass does not refract, subsurface light comes out on both sides.
    pub geometry_thin_walled: bool,
}

impl Default for OpenPbr {
    /// The defaults of the specification.
    fn default() -> Self {
        let number = FloatParam::Constant;
        let grey = |value| SpectrumParam::Constant(Spectrum::Constant(value));
        Self {
            base_weight: number(1.0),
            base_color: grey(0.8),
            base_diffuse_roughness: number(0.0),
            base_metalness: number(0.0),
            specular_weight: number(1.0),
            specular_color: grey(1.0),
            specular_roughness: number(0.3),
            specular_roughness_anisotropy: number(0.0),
            specular_ior: number(1.5),
            transmission_weight: number(0.0),
            transmission_color: grey(1.0),
            subsurface_weight: number(0.0),
            subsurface_color: grey(0.8),
            coat_weight: number(0.0),
            coat_color: grey(1.0),
            coat_roughness: number(0.0),
            coat_ior: number(1.6),
            coat_darkening: number(1.0),
            fuzz_weight: number(0.0),
            fuzz_color: grey(1.0),
            fuzz_roughness: number(0.5),
            thin_film_weight: number(0.0),
            thin_film_thickness: number(0.5),
            thin_film_ior: number(1.4),
            emission_luminance: 0.0,
            emission_color: SpectrumParam::Constant(Spectrum::srgb([1.0; 3])),
            geometry_thin_walled: false,
        }
    }
}

impl OpenPbr {
    /// The numbers with their names.
    pub fn numbers(&self) -> [(&'static str, FloatParam); 18] {
        [
            ("base_weight", self.base_weight),
            ("base_diffuse_roughness", self.base_diffuse_roughness),
            ("base_metalness", self.base_metalness),
            ("specular_weight", self.specular_weight),
            ("specular_roughness", self.specular_roughness),
            ("specular_roughness_anisotropy", self.specular_roughness_anisotropy),
            ("specular_ior", self.specular_ior),
            ("transmission_weight", self.transmission_weight),
            ("subsurface_weight", self.subsurface_weight),
            ("coat_weight", self.coat_weight),
            ("coat_roughness", self.coat_roughness),
            ("coat_ior", self.coat_ior),
            ("coat_darkening", self.coat_darkening),
            ("fuzz_weight", self.fuzz_weight),
            ("fuzz_roughness", self.fuzz_roughness),
            ("thin_film_weight", self.thin_film_weight),
            ("thin_film_thickness", self.thin_film_thickness),
            ("thin_film_ior", self.thin_film_ior),
        ]
    }

    /// The colours with their names.
    pub fn colors(&self) -> [(&'static str, &SpectrumParam); 7] {
        [
            ("base_color", &self.base_color),
            ("specular_color", &self.specular_color),
            ("transmission_color", &self.transmission_color),
            ("subsurface_color", &self.subsurface_color),
            ("coat_color", &self.coat_color),
            ("fuzz_color", &self.fuzz_color),
            ("emission_color", &self.emission_color),
        ]
    }

    /// Whether it emits light.
    pub fn emits(&self) -> bool {
        self.emission_luminance > 0.0
    }
}
