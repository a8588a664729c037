//! Participating media.

use sahl_image::ColorSpace;
use sahl_scene::{Coefficients, Diagnostic, Emission, Medium, Spectrum};

use super::super::context::Context;
use super::super::reader::Reader;
use super::super::report::quote;
use super::lookup;
use super::preset::{self, Measured};
use super::spectrum::{Role, spectrum};

/// Reads one kind of medium; `None` where it is not supported or can't be read, which is reported.
type Read = fn(&Context<'_>, &Reader<'_>) -> Option<Medium>;

const MEDIA: &[(&str, Read)] = &[
    ("homogeneous", homogeneous),
    ("uniformgrid", unsupported),
    ("rgbgrid", unsupported),
    ("cloud", unsupported),
    ("nanovdb", unsupported),
];

/// The medium of the kind `name`.
pub(in super::super) fn medium(cx: &Context<'_>, name: &str, p: &Reader<'_>) -> Option<Medium> {
    lookup(MEDIA, name, p).and_then(|read| read(cx, p))
}

fn unsupported(_: &Context<'_>, p: &Reader<'_>) -> Option<Medium> {
    p.ignore_all();
    p.unsupported_plugin("unsupported-medium", "light passes it unchanged");
    None
}

fn homogeneous(cx: &Context<'_>, p: &Reader<'_>) -> Option<Medium> {
    let measured = preset(p);
    let coefficients = coefficients(cx, p, measured);
    Some(Medium::Homogeneous { coefficients, emission: emission(cx, p) })
}

/// The measured material that `preset` names; one that nobody measured is an error.
fn preset(p: &Reader<'_>) -> Option<Measured> {
    let name = p.string("preset").filter(|name| !name.text.is_empty())?;
    let measured = preset::measured(&name.text);
    if measured.is_none() {
        let message = format!("there are no measured coefficients of {}", quote(name.text.as_bytes()));
        let diagnostic = Diagnostic::error("unknown-preset", name.span, message);
        p.report().push_with_choices(diagnostic, &name.text, preset::names());
    }
    measured
}

/// Absorption and scattering, by default one per metre, with the phase function. What was measured comes before what is
/// given, as in pbrt-v4.
fn coefficients(cx: &Context<'_>, p: &Reader<'_>, measured: Option<Measured>) -> Coefficients {
    let coefficient = |name, measured: Option<[f32; 3]>| {
        let given = spectrum(cx, p, name, Role::Unbounded);
        let measured = measured.map(|rgb| Spectrum::Rgb { rgb, space: ColorSpace::Srgb });
        measured.or(given).unwrap_or(Spectrum::Constant(1.0))
    };
    Coefficients {
        sigma_a: coefficient("sigma_a", measured.map(|measured| measured.sigma_a)),
        sigma_s: coefficient("sigma_s", measured.map(|measured| measured.sigma_s)),
        scale: p.non_negative("scale", 1.0),
        g: asymmetry(p),
    }
}

fn asymmetry(p: &Reader<'_>) -> f32 {
    p.float_where("g", 0.0, |g| g > -1.0 && g < 1.0, "greater than -1 and less than 1")
}

fn emission(cx: &Context<'_>, p: &Reader<'_>) -> Option<Emission> {
    let scale = p.non_negative("Lescale", 1.0);
    spectrum(cx, p, "Le", Role::Illuminant).map(|radiance| Emission { radiance, scale })
}
