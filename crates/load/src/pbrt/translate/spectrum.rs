//! Spectra, and parameters that may be a texture.

use sahl_scene::{Diagnostic, FloatParam, Span, Spectrum, SpectrumParam, suggest};

use super::super::context::Context;
use super::super::parameter::{Kind, Parameter, Values};
use super::super::reader::Reader;
use super::super::report::quote;
use super::super::statement::Name;

/// Samples that a spectrum may have; each material and emitting shape keeps its own.
const SAMPLE_LIMIT: usize = 2048;

/// What an RGB triple means, and so what it may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Role {
    /// A share of light: from zero to one.
    Albedo,
    /// A quantity that is not negative.
    Unbounded,
    /// Emitted light: not negative.
    Illuminant,
}

/// The spectrum called `name`, if it is given.
pub(super) fn spectrum(cx: &Context<'_>, p: &Reader<'_>, name: &'static str, role: Role) -> Option<Spectrum> {
    let parameter = p.find(name)?;
    let kinds = [Kind::Rgb, Kind::Spectrum, Kind::Blackbody];
    if !kinds.contains(&parameter.kind) {
        p.wrong_kind(parameter, &kinds);
        return None;
    }
    read(cx, p, parameter, role)
}

/// The number or spectrum called `name`: both are ways to give an index of refraction.
pub(super) fn float_or_spectrum(
    cx: &Context<'_>,
    p: &Reader<'_>,
    name: &'static str,
    default: f32,
) -> Spectrum {
    match p.find(name) {
        Some(parameter) if parameter.kind != Kind::Float => {
            spectrum(cx, p, name, Role::Unbounded).unwrap_or(Spectrum::Constant(default))
        }
        _ => Spectrum::Constant(p.positive(name, default)),
    }
}

/// The spectrum or texture called `name`.
pub(super) fn spectrum_param(
    cx: &Context<'_>,
    p: &Reader<'_>,
    name: &'static str,
    role: Role,
    default: SpectrumParam,
) -> SpectrumParam {
    optional_spectrum_param(cx, p, name, role).unwrap_or(default)
}

/// The spectrum or texture called `name`, if it is given.
pub(super) fn optional_spectrum_param(
    cx: &Context<'_>,
    p: &Reader<'_>,
    name: &'static str,
    role: Role,
) -> Option<SpectrumParam> {
    let parameter = p.find(name)?;
    match parameter.kind {
        Kind::Texture => {
            texture(cx, p, parameter, &cx.spectrum_textures, "spectrum").map(SpectrumParam::Texture)
        }
        Kind::Rgb | Kind::Spectrum | Kind::Blackbody => {
            read(cx, p, parameter, role).map(SpectrumParam::Constant)
        }
        _ => {
            p.wrong_kind(parameter, &[Kind::Rgb, Kind::Spectrum, Kind::Blackbody, Kind::Texture]);
            None
        }
    }
}

/// The number or texture called `name`.
pub(super) fn float_param(
    cx: &Context<'_>,
    p: &Reader<'_>,
    name: &'static str,
    default: FloatParam,
) -> FloatParam {
    optional_float_param(cx, p, name).unwrap_or(default)
}

/// The number or texture called `name`, if it is given.
pub(super) fn optional_float_param(
    cx: &Context<'_>,
    p: &Reader<'_>,
    name: &'static str,
) -> Option<FloatParam> {
    let parameter = p.find(name)?;
    match parameter.kind {
        Kind::Texture => texture(cx, p, parameter, &cx.float_textures, "float").map(FloatParam::Texture),
        Kind::Float => p.optional_float(name).map(FloatParam::Constant),
        _ => {
            p.wrong_kind(parameter, &[Kind::Float, Kind::Texture]);
            None
        }
    }
}

/// The texture that `parameter` names.
fn texture<T: Copy>(
    cx: &Context<'_>,
    p: &Reader<'_>,
    parameter: &Parameter,
    textures: &std::collections::BTreeMap<String, T>,
    kind: &str,
) -> Option<T> {
    let Values::Strings(names) = &parameter.values else { return None };
    let name = p.one(parameter, names)?;
    if let Some(texture) = textures.get(&name.text) {
        return Some(*texture);
    }
    let message = format!("there is no `{kind}` texture called {}", quote(name.text.as_bytes()));
    let diagnostic = Diagnostic::error("unknown-texture", name.span, message);
    let other_kind =
        cx.float_textures.contains_key(&name.text) || cx.spectrum_textures.contains_key(&name.text);
    if other_kind {
        let note = format!("a texture of the other kind has this name; `{kind}` is expected here");
        cx.report.push(diagnostic.with_note(note));
    } else {
        cx.report.push_with_choices(diagnostic, &name.text, textures.keys().map(String::as_str));
    }
    None
}

/// The spectrum that `parameter` holds.
fn read(cx: &Context<'_>, p: &Reader<'_>, parameter: &Parameter, role: Role) -> Option<Spectrum> {
    if let Values::Strings(names) = &parameter.values {
        return named(cx, p.one(parameter, names)?);
    }
    let values = p.finite(parameter)?;
    match parameter.kind {
        Kind::Rgb => rgb(p, parameter, values, role),
        Kind::Blackbody => {
            let temperature = *p.one(parameter, values)?;
            if temperature > 0.0 {
                return Some(Spectrum::Blackbody(temperature));
            }
            let message = format!("a temperature must be greater than zero, found {temperature}");
            cx.report.error("invalid-value", parameter.value_span, message);
            None
        }
        _ => sampled(cx, values, |index| cx.report.value_span(parameter.value_span, index)),
    }
}

/// An RGB triple, brought to where its role allows it.
fn rgb(p: &Reader<'_>, parameter: &Parameter, values: &[f32], role: Role) -> Option<Spectrum> {
    let Ok(rgb) = <[f32; 3]>::try_from(values) else {
        let message = format!("parameter `{}` expects three numbers, found {}", parameter.name, values.len());
        p.report().error("wrong-count", parameter.value_span, message);
        return None;
    };
    let highest = if role == Role::Albedo { 1.0 } else { f32::MAX };
    let clamped = rgb.map(|value| value.clamp(0.0, highest));
    if clamped != rgb {
        let range = if role == Role::Albedo { "from 0 to 1" } else { "not negative" };
        let [r, g, b] = clamped;
        let message = format!("the colour `{}` must be {range}: {r} {g} {b} is used", parameter.name);
        p.report().warning("color-range", parameter.value_span, message);
    }
    Some(Spectrum::Rgb { rgb: clamped, space: parameter.color_space })
}

/// A spectrum by name: one that is built in, or a file of wavelengths and values.
fn named(cx: &Context<'_>, name: &Name) -> Option<Spectrum> {
    if is_builtin(&name.text) {
        return Some(Spectrum::Named(name.text.clone()));
    }
    match cx.files.read(&name.text) {
        Ok((_, bytes)) => spectrum_file(cx, name, &bytes),
        Err(error) => {
            let message = format!(
                "{} is neither a named spectrum nor a readable file: {error}",
                quote(name.text.as_bytes())
            );
            let diagnostic = Diagnostic::error("unknown-spectrum", name.span, message);
            cx.report.push_with(diagnostic, |diagnostic| {
                let names: Vec<String> = builtin_names().collect();
                match suggest::nearest(&name.text, names.iter().map(String::as_str)) {
                    Some(nearest) => diagnostic.with_help(format!("did you mean `{nearest}`?")),
                    None => diagnostic,
                }
            });
            None
        }
    }
}

/// Reads pairs of numbers, `#` starting a comment.
fn spectrum_file(cx: &Context<'_>, name: &Name, bytes: &[u8]) -> Option<Spectrum> {
    let text = String::from_utf8_lossy(bytes);
    let mut values = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let content = line.split('#').next().unwrap_or_default();
        for word in content.split_ascii_whitespace() {
            match word.parse::<f32>() {
                Ok(value) if value.is_finite() => values.push(value),
                _ => {
                    let message = format!(
                        "line {} of the spectrum {} holds {} instead of a number",
                        index + 1,
                        quote(name.text.as_bytes()),
                        quote(word.as_bytes())
                    );
                    cx.report.error("bad-spectrum", name.span, message);
                    return None;
                }
            }
        }
    }
    sampled(cx, &values, |_| name.span)
}

/// A spectrum from wavelengths and values in turn; `place` tells where value number `i` stands.
fn sampled(cx: &Context<'_>, values: &[f32], place: impl Fn(usize) -> Span) -> Option<Spectrum> {
    let (pairs, rest) = values.as_chunks::<2>();
    if !rest.is_empty() || pairs.is_empty() {
        let message =
            format!("a spectrum needs pairs of wavelength and value, found {} numbers", values.len());
        cx.report.error("wrong-count", place(values.len().saturating_sub(1)), message);
        return None;
    }
    if pairs.len() > SAMPLE_LIMIT {
        let message =
            format!("a spectrum of {} samples is refused: {SAMPLE_LIMIT} is the limit", pairs.len());
        cx.report.error("wrong-count", place(2 * SAMPLE_LIMIT), message);
        return None;
    }
    if let Some(index) = pairs.windows(2).position(|pair| pair[1][0] <= pair[0][0]) {
        let message =
            format!("wavelengths must increase, found {} after {}", pairs[index + 1][0], pairs[index][0]);
        cx.report.error("wavelength-order", place(2 * index + 2), message);
        return None;
    }
    Some(Spectrum::Sampled(pairs.iter().map(|&[wavelength, value]| (wavelength, value)).collect()))
}

/// pbrt-v4's named spectra of materials and lights.
const BUILTIN: &[&str] = &[
    "glass-BAF10",
    "glass-BK7",
    "glass-F10",
    "glass-F11",
    "glass-F5",
    "glass-FK51A",
    "glass-LASF9",
    "illum-acesD60",
    "metal-Ag-eta",
    "metal-Ag-k",
    "metal-Al-eta",
    "metal-Al-k",
    "metal-Au-eta",
    "metal-Au-k",
    "metal-Cu-eta",
    "metal-Cu-k",
    "metal-CuZn-eta",
    "metal-CuZn-k",
    "metal-MgO-eta",
    "metal-MgO-k",
    "metal-TiO2-eta",
    "metal-TiO2-k",
    "stdillum-A",
    "stdillum-D50",
    "stdillum-D65",
    "stdillum-F1",
    "stdillum-F10",
    "stdillum-F11",
    "stdillum-F12",
    "stdillum-F2",
    "stdillum-F3",
    "stdillum-F4",
    "stdillum-F5",
    "stdillum-F6",
    "stdillum-F7",
    "stdillum-F8",
    "stdillum-F9",
];

/// pbrt-v4's cameras: three curves of sensitivity each.
pub(super) const SENSORS: &[&str] = &[
    "canon_eos_100d",
    "canon_eos_1dx_mkii",
    "canon_eos_200d",
    "canon_eos_200d_mkii",
    "canon_eos_5d",
    "canon_eos_5d_mkii",
    "canon_eos_5d_mkiii",
    "canon_eos_5d_mkiv",
    "canon_eos_5ds",
    "canon_eos_m",
    "hasselblad_l1d_20c",
    "nikon_d810",
    "nikon_d850",
    "sony_ilce_6400",
    "sony_ilce_7m3",
    "sony_ilce_7rm3",
    "sony_ilce_9",
];

fn is_builtin(name: &str) -> bool {
    BUILTIN.contains(&name)
        || ["_r", "_g", "_b"]
            .iter()
            .any(|curve| name.strip_suffix(curve).is_some_and(|sensor| SENSORS.contains(&sensor)))
}

fn builtin_names() -> impl Iterator<Item = String> {
    let curves = SENSORS.iter().flat_map(|sensor| ["r", "g", "b"].map(|curve| format!("{sensor}_{curve}")));
    BUILTIN.iter().map(|&name| name.to_owned()).chain(curves)
}
