//! Textures.

use sahl_image::Encoding;
use sahl_scene::{
    Diagnostic, FloatParam, ImageTexture, Origin, Spectrum, SpectrumParam, Texture, TextureFilter, UvMapping,
    Wrap,
};

use super::super::context::Context;
use super::super::reader::Reader;
use super::super::report::quote;
use super::super::statement::{Name, Statement};
use super::image::{image, mean_rgb};
use super::lookup;
use super::spectrum::{Role, float_param, spectrum_param};

/// What a texture gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Float,
    Spectrum,
}

/// Reads one kind of texture.
type Read = fn(&mut Context<'_>, &Reader<'_>, Kind) -> Option<Texture>;

const TEXTURES: &[(&str, Read)] = &[
    ("constant", constant),
    ("scale", scale),
    ("mix", mix),
    ("directionmix", direction_mix),
    ("bilerp", bilerp),
    ("imagemap", imagemap),
    ("ptex", ptex),
    ("checkerboard", checkerboard),
    ("dots", dots),
    ("fbm", |_, p, _| mean(p, &["octaves", "roughness"], 0.0)),
    ("wrinkled", |_, p, _| mean(p, &["octaves", "roughness"], 0.5)),
    ("windy", |_, p, _| mean(p, &[], 0.0)),
    ("marble", |_, p, _| mean(p, &["octaves", "roughness", "scale", "variation"], 0.3)),
];

/// Textures that give only numbers, and only spectra.
const FLOAT_ONLY: &[&str] = &["fbm", "wrinkled", "windy"];
const SPECTRUM_ONLY: &[&str] = &["marble"];

/// Defines the texture of a `Texture` directive.
pub(in super::super) fn texture(cx: &mut Context<'_>, statement: &Statement, p: &Reader<'_>) {
    let [name, kind, plugin] = &statement.names[..] else { return };
    let Some(kind) = kind_of(kind, p) else {
        p.ignore_all();
        return;
    };
    let read = match lookup(TEXTURES, &plugin.text, p) {
        Some(read) if is_of_kind(plugin, kind, p) => *read,
        Some(_) => {
            p.ignore_all();
            return;
        }
        None => return,
    };
    let Some(texture) = read(cx, p, kind) else { return };
    let names = match kind {
        Kind::Float => &mut cx.float_textures,
        Kind::Spectrum => &mut cx.spectrum_textures,
    };
    if let Some(former) = names.get(&name.text) {
        let message = format!("texture {} is defined twice", quote(name.text.as_bytes()));
        let diagnostic = Diagnostic::error("redefinition", name.span, message);
        let first = cx.scene.textures.origin(*former).span.unwrap_or(name.span);
        cx.report.push_with_place(diagnostic, "the first is in", first);
        return;
    }
    let origin = Origin::named(name.text.clone(), statement.span);
    names.insert(name.text.clone(), cx.scene.textures.push(texture, origin));
}

fn kind_of(name: &Name, p: &Reader<'_>) -> Option<Kind> {
    match &*name.text {
        "float" => return Some(Kind::Float),
        "spectrum" => return Some(Kind::Spectrum),
        _ => {}
    }
    let message = format!("a texture is of `float` or `spectrum`, found {}", quote(name.text.as_bytes()));
    let mut diagnostic = Diagnostic::error("unknown-value", name.span, message);
    if matches!(&*name.text, "color" | "rgb") {
        diagnostic = diagnostic.with_help("did you mean `spectrum`?");
    }
    p.report().push(diagnostic);
    None
}

fn is_of_kind(plugin: &Name, kind: Kind, p: &Reader<'_>) -> bool {
    let (wrong, right) = match kind {
        Kind::Float => (SPECTRUM_ONLY, "spectrum"),
        Kind::Spectrum => (FLOAT_ONLY, "float"),
    };
    let valid = !wrong.contains(&&*plugin.text);
    if !valid {
        let message = format!("a `{}` texture gives `{right}` values only", plugin.text);
        p.report().error("wrong-type", plugin.span, message);
    }
    valid
}

/// The number, spectrum or texture called `name`; the number `default` if it is not given.
fn value(cx: &Context<'_>, p: &Reader<'_>, name: &'static str, kind: Kind, default: f32) -> SpectrumParam {
    match kind {
        Kind::Float => match float_param(cx, p, name, FloatParam::Constant(default)) {
            FloatParam::Constant(value) => SpectrumParam::Constant(Spectrum::Constant(value)),
            FloatParam::Texture(texture) => SpectrumParam::Texture(texture),
        },
        Kind::Spectrum => {
            let default = SpectrumParam::Constant(Spectrum::Constant(default));
            spectrum_param(cx, p, name, Role::Unbounded, default)
        }
    }
}

/// The texture that is `param` everywhere.
fn same_as(param: SpectrumParam) -> Texture {
    match param {
        SpectrumParam::Constant(spectrum) => Texture::Constant(spectrum),
        texture => Texture::Scale { texture, scale: FloatParam::Constant(1.0) },
    }
}

fn constant(cx: &mut Context<'_>, p: &Reader<'_>, kind: Kind) -> Option<Texture> {
    Some(same_as(value(cx, p, "value", kind, 1.0)))
}

fn scale(cx: &mut Context<'_>, p: &Reader<'_>, kind: Kind) -> Option<Texture> {
    let scale = float_param(cx, p, "scale", FloatParam::Constant(1.0));
    Some(Texture::Scale { texture: value(cx, p, "tex", kind, 1.0), scale })
}

fn mix(cx: &mut Context<'_>, p: &Reader<'_>, kind: Kind) -> Option<Texture> {
    let amount = float_param(cx, p, "amount", FloatParam::Constant(0.5));
    let [first, second] = [value(cx, p, "tex1", kind, 0.0), value(cx, p, "tex2", kind, 1.0)];
    Some(Texture::Mix { first, second, amount })
}

fn direction_mix(cx: &mut Context<'_>, p: &Reader<'_>, kind: Kind) -> Option<Texture> {
    p.without_effect(&["dir"]);
    p.unsupported_plugin("unsupported-texture", "an even mix of its textures is used");
    let [first, second] = [value(cx, p, "tex1", kind, 0.0), value(cx, p, "tex2", kind, 1.0)];
    Some(Texture::Mix { first, second, amount: FloatParam::Constant(0.5) })
}

fn bilerp(cx: &mut Context<'_>, p: &Reader<'_>, kind: Kind) -> Option<Texture> {
    mapping(p);
    p.unsupported_plugin("unsupported-texture", "the mean of its corners is used");
    let mut edge = |low, high| {
        let [first, second] = [value(cx, p, low, kind, 0.0), value(cx, p, high, kind, 1.0)];
        let texture = Texture::Mix { first, second, amount: FloatParam::Constant(0.5) };
        SpectrumParam::Texture(cx.scene.textures.push(texture, Origin::at(p.span())))
    };
    let [first, second] = [edge("v00", "v01"), edge("v10", "v11")];
    Some(Texture::Mix { first, second, amount: FloatParam::Constant(0.5) })
}

fn checkerboard(cx: &mut Context<'_>, p: &Reader<'_>, kind: Kind) -> Option<Texture> {
    let [even, odd] = [value(cx, p, "tex1", kind, 1.0), value(cx, p, "tex2", kind, 0.0)];
    if p.integer("dimension", 2, 2, 3) == 3 {
        p.unsupported(&["dimension"], "the even mix of its colours is used");
        return Some(Texture::Mix { first: even, second: odd, amount: FloatParam::Constant(0.5) });
    }
    Some(Texture::Checkerboard { mapping: mapping(p), even, odd })
}

fn dots(cx: &mut Context<'_>, p: &Reader<'_>, kind: Kind) -> Option<Texture> {
    mapping(p);
    value(cx, p, "inside", kind, 1.0);
    p.unsupported_plugin("unsupported-texture", "its outside is used everywhere");
    Some(same_as(value(cx, p, "outside", kind, 0.0)))
}

/// A procedural texture replaced by its mean, which was estimated from its formula.
fn mean(p: &Reader<'_>, own: &[&'static str], mean: f32) -> Option<Texture> {
    p.without_effect(own);
    p.unsupported_plugin("unsupported-texture", &format!("the constant {mean} is used"));
    Some(Texture::Constant(Spectrum::Constant(mean)))
}

fn ptex(_: &mut Context<'_>, p: &Reader<'_>, _: Kind) -> Option<Texture> {
    mean(p, &["filename", "encoding", "scale"], 0.5)
}

fn imagemap(cx: &mut Context<'_>, p: &Reader<'_>, kind: Kind) -> Option<Texture> {
    let mapping = mapping(p);
    let filter = filter(p);
    let wrap = wrap(p);
    let (scale, invert) = (p.float("scale", 1.0), p.bool("invert", false));
    let encoding = encoding(p);
    let Some(name) = p.string("filename") else {
        if !p.has("filename") {
            p.report().error(
                "missing-parameter",
                p.span(),
                format!("{} needs a `string filename`", p.what()),
            );
        }
        return Some(placeholder(kind));
    };
    // The name stays defined if the image can't be read, so that there is one error for it and not one a use.
    let Some(image) = image(cx, name, encoding) else { return Some(placeholder(kind)) };
    Some(Texture::Image(ImageTexture { image, mapping, wrap, filter, scale, invert }))
}

/// What stands for a texture whose image could not be read, which is an error.
fn placeholder(kind: Kind) -> Texture {
    Texture::Constant(Spectrum::Constant(match kind {
        Kind::Float => 1.0,
        Kind::Spectrum => 0.5,
    }))
}

fn filter(p: &Reader<'_>) -> TextureFilter {
    let filters = [
        ("bilinear", Some(TextureFilter::Bilinear)),
        ("point", Some(TextureFilter::Nearest)),
        ("trilinear", None),
        ("EWA", None),
        ("ewa", None),
    ];
    let filter = p.choice("filter", &filters, Some(TextureFilter::Bilinear));
    if filter.is_none() {
        p.unsupported(&["filter"], "`bilinear` is used, which samples average");
    }
    p.without_effect(&["maxanisotropy"]);
    filter.unwrap_or(TextureFilter::Bilinear)
}

fn wrap(p: &Reader<'_>) -> Wrap {
    let modes = [
        ("repeat", Some(Wrap::Repeat)),
        ("clamp", Some(Wrap::Clamp)),
        ("black", Some(Wrap::Black)),
        ("octahedralsphere", None),
    ];
    let wrap = p.choice("wrap", &modes, Some(Wrap::Repeat));
    if wrap.is_none() {
        p.unsupported(&["wrap"], "`clamp` is used");
    }
    wrap.unwrap_or(Wrap::Clamp)
}

/// `None` if the scene leaves it to the file.
fn encoding(p: &Reader<'_>) -> Option<Encoding> {
    let given = p.string("encoding")?;
    match &*given.text {
        "sRGB" | "srgb" => return Some(Encoding::Srgb),
        "linear" => return Some(Encoding::Linear),
        _ => {}
    }
    let gamma = given.text.strip_prefix("gamma ").and_then(|value| value.trim().parse().ok());
    let gamma = gamma.filter(|value: &f32| value.is_finite() && *value > 0.0);
    if gamma.is_none() {
        let found = quote(given.text.as_bytes());
        let message = format!("an encoding is `sRGB`, `linear` or `gamma` and a number, found {found}");
        p.report().error("unknown-value", given.span, message);
    }
    gamma.map(Encoding::Gamma)
}

fn mapping(p: &Reader<'_>) -> UvMapping {
    let mappings = [("uv", true), ("spherical", false), ("cylindrical", false), ("planar", false)];
    if !p.choice("mapping", &mappings, true) {
        p.unsupported(&["mapping"], "the surface's own coordinates are used");
    }
    p.without_effect(&["v1", "v2"]);
    UvMapping {
        scale: [p.float("uscale", 1.0), p.float("vscale", 1.0)],
        offset: [p.float("udelta", 0.0), p.float("vdelta", 0.0)],
    }
}

/// The mean colour of the image called `name`, in the image's own primaries.
pub(super) fn mean_color(cx: &mut Context<'_>, name: &Name) -> Option<Spectrum> {
    let handle = image(cx, name, None)?;
    let image = cx.scene.images.get(handle)?;
    Some(Spectrum::Rgb { rgb: mean_rgb(image), space: image.color_space })
}
