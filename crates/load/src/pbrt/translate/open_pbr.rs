//! OpenPBR surfaces, which pbrt-v4 does not have: parameters by the names of the specification.
//!
//! Deliberately absent: what the renderer does not have. Such parameters are reported like all that are unknown.

use sahl_scene::{FloatParam, OpenPbr, SpectrumParam};

use super::super::context::Context;
use super::super::reader::Reader;
use super::spectrum::{Role, float_param, spectrum_param};

/// The surface that the parameters of a material `openpbr` describe.
pub(super) fn open_pbr(cx: &Context<'_>, p: &Reader<'_>) -> OpenPbr {
    let number = |name: &'static str, default: FloatParam| float_param(cx, p, name, default);
    let color =
        |name: &'static str, default: SpectrumParam| spectrum_param(cx, p, name, Role::Albedo, default);
    let emitted =
        |name: &'static str, default: SpectrumParam| spectrum_param(cx, p, name, Role::Illuminant, default);
    let default = OpenPbr::default();
    OpenPbr {
        base_weight: number("base_weight", default.base_weight),
        base_color: color("base_color", default.base_color),
        base_diffuse_roughness: number("base_diffuse_roughness", default.base_diffuse_roughness),
        base_metalness: number("base_metalness", default.base_metalness),
        specular_weight: number("specular_weight", default.specular_weight),
        specular_color: color("specular_color", default.specular_color),
        specular_roughness: number("specular_roughness", default.specular_roughness),
        specular_roughness_anisotropy: number(
            "specular_roughness_anisotropy",
            default.specular_roughness_anisotropy,
        ),
        specular_ior: number("specular_ior", default.specular_ior),
        transmission_weight: number("transmission_weight", default.transmission_weight),
        transmission_color: color("transmission_color", default.transmission_color),
        subsurface_weight: number("subsurface_weight", default.subsurface_weight),
        subsurface_color: color("subsurface_color", default.subsurface_color),
        coat_weight: number("coat_weight", default.coat_weight),
        coat_color: color("coat_color", default.coat_color),
        coat_roughness: number("coat_roughness", default.coat_roughness),
        coat_ior: number("coat_ior", default.coat_ior),
        coat_darkening: number("coat_darkening", default.coat_darkening),
        fuzz_weight: number("fuzz_weight", default.fuzz_weight),
        fuzz_color: color("fuzz_color", default.fuzz_color),
        fuzz_roughness: number("fuzz_roughness", default.fuzz_roughness),
        thin_film_weight: number("thin_film_weight", default.thin_film_weight),
        thin_film_thickness: number("thin_film_thickness", default.thin_film_thickness),
        thin_film_ior: number("thin_film_ior", default.thin_film_ior),
        emission_luminance: p.non_negative("emission_luminance", default.emission_luminance),
        emission_color: emitted("emission_color", default.emission_color),
        geometry_thin_walled: p.bool("geometry_thin_walled", default.geometry_thin_walled),
    }
}
