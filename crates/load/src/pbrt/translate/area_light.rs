//! Emission of shapes.

use sahl_scene::{AreaLight, Spectrum, SpectrumParam};

use super::super::context::Context;
use super::super::reader::Reader;
use super::light::photometric;
use super::lookup;
use super::spectrum::{Role, spectrum};
use super::texture::emission_image;

/// Reads one kind of area light; `white` is what it emits unless told.
type Read = fn(&mut Context<'_>, &Reader<'_>, Spectrum) -> AreaLight;

const AREA_LIGHTS: &[(&str, Read)] = &[("diffuse", diffuse)];

/// The area light called `name`.
pub(in super::super) fn area_light(
    cx: &mut Context<'_>,
    name: &str,
    p: &Reader<'_>,
    white: Spectrum,
) -> Option<AreaLight> {
    lookup(AREA_LIGHTS, name, p).map(|read| read(cx, p, white))
}

fn diffuse(cx: &mut Context<'_>, p: &Reader<'_>, white: Spectrum) -> AreaLight {
    let constant = spectrum(cx, p, "L", Role::Illuminant);
    let image = p.string("filename").and_then(|name| emission_image(cx, name));
    if constant.is_some() && p.find("filename").is_some() {
        p.report().error("contradiction", p.span(), format!("{} has both `L` and `filename`", p.what()));
    }
    AreaLight {
        radiance: match image {
            Some(texture) => SpectrumParam::Texture(texture),
            None => SpectrumParam::Constant(constant.unwrap_or(white)),
        },
        scale: p.non_negative("scale", 1.0),
        two_sided: p.bool("twosided", false),
        power: photometric(p, "power"),
    }
}
