//! Textures.

use sahl_image::Encoding;
use sahl_math::{Transform, Vec3};
use sahl_scene::{
    Diagnostic, FaceTexture, FloatParam, Handle, ImageTexture, Origin, SolidNoise, Spectrum, SpectrumParam,
    Texture, TextureFilter, TextureMapping, UvMapping, Wrap,
};

use super::super::context::Context;
use super::super::parameter::Kind as ParameterKind;
use super::super::reader::Reader;
use super::super::report::quote;
use super::super::statement::{Name, Statement};
use super::image::{face_images, image};
use super::lookup;
use super::spectrum::{Role, float_param, spectrum_param};

/// What a texture gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Float,
    Spectrum,
}

/// What a texture gives, and the space in which it is defined.
struct Definition {
    kind: Kind,
    to_world: Transform,
}

impl Definition {
    fn world_to_texture(&self) -> Transform {
        self.to_world.inverse()
    }
}

/// Reads one kind of texture.
type Read = fn(&mut Context<'_>, &Reader<'_>, &Definition) -> Option<Texture>;

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
    ("fbm", |_, p, texture| Some(Texture::Fbm(noise(p, texture)))),
    ("wrinkled", |_, p, texture| Some(Texture::Wrinkled(noise(p, texture)))),
    ("windy", |_, _, texture| Some(Texture::Windy { world_to_texture: texture.world_to_texture() })),
    ("marble", marble),
];

/// Textures that give only numbers, and only spectra.
const FLOAT_ONLY: &[&str] = &["fbm", "wrinkled", "windy"];
const SPECTRUM_ONLY: &[&str] = &["marble"];

/// Defines the texture of a `Texture` directive that stands where `to_world` is in force.
pub(in super::super) fn texture(
    cx: &mut Context<'_>,
    statement: &Statement,
    p: &Reader<'_>,
    to_world: &Transform,
) {
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
    let Some(texture) = read(cx, p, &Definition { kind, to_world: *to_world }) else { return };
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
fn value(
    cx: &Context<'_>,
    p: &Reader<'_>,
    name: &'static str,
    texture: &Definition,
    default: f32,
) -> SpectrumParam {
    match texture.kind {
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

fn constant(cx: &mut Context<'_>, p: &Reader<'_>, texture: &Definition) -> Option<Texture> {
    Some(match value(cx, p, "value", texture, 1.0) {
        SpectrumParam::Constant(spectrum) => Texture::Constant(spectrum),
        texture => Texture::Scale { texture, scale: FloatParam::Constant(1.0) },
    })
}

fn scale(cx: &mut Context<'_>, p: &Reader<'_>, texture: &Definition) -> Option<Texture> {
    let scale = float_param(cx, p, "scale", FloatParam::Constant(1.0));
    Some(Texture::Scale { texture: value(cx, p, "tex", texture, 1.0), scale })
}

fn mix(cx: &mut Context<'_>, p: &Reader<'_>, texture: &Definition) -> Option<Texture> {
    let amount = float_param(cx, p, "amount", FloatParam::Constant(0.5));
    let [first, second] = [value(cx, p, "tex1", texture, 0.0), value(cx, p, "tex2", texture, 1.0)];
    Some(Texture::Mix { first, second, amount })
}

fn direction_mix(cx: &mut Context<'_>, p: &Reader<'_>, texture: &Definition) -> Option<Texture> {
    let [first, second] = [value(cx, p, "tex1", texture, 0.0), value(cx, p, "tex2", texture, 1.0)];
    let given = vector(p, "dir", Vec3::Y);
    let direction = texture.to_world.vector(given).try_normalize();
    if direction.is_none() {
        p.invalid("dir", "must have a direction");
    }
    Some(Texture::DirectionMix { first, second, direction: direction.unwrap_or(Vec3::Y) })
}

fn bilerp(cx: &mut Context<'_>, p: &Reader<'_>, texture: &Definition) -> Option<Texture> {
    let corners = [("v00", 0.0), ("v10", 0.0), ("v01", 1.0), ("v11", 1.0)]
        .map(|(name, default)| value(cx, p, name, texture, default));
    Some(Texture::Bilerp { mapping: mapping(p, texture), corners })
}

fn checkerboard(cx: &mut Context<'_>, p: &Reader<'_>, texture: &Definition) -> Option<Texture> {
    let [even, odd] = [value(cx, p, "tex1", texture, 1.0), value(cx, p, "tex2", texture, 0.0)];
    if p.integer("dimension", 2, 2, 3) == 3 {
        let world_to_texture = texture.world_to_texture();
        return Some(Texture::SolidCheckerboard { world_to_texture, even, odd });
    }
    Some(Texture::Checkerboard { mapping: mapping(p, texture), even, odd })
}

/// What pbrt-v4 calls `inside` lies around the dots there, and `outside` in them. Files were made to look right that way.
fn dots(cx: &mut Context<'_>, p: &Reader<'_>, texture: &Definition) -> Option<Texture> {
    let [outside, inside] = [value(cx, p, "inside", texture, 1.0), value(cx, p, "outside", texture, 0.0)];
    Some(Texture::Dots { mapping: mapping(p, texture), inside, outside })
}

fn noise(p: &Reader<'_>, texture: &Definition) -> SolidNoise {
    const MOST: i32 = SolidNoise::MOST_OCTAVES.cast_signed();
    SolidNoise {
        world_to_texture: texture.world_to_texture(),
        octaves: p.integer("octaves", 8, 0, MOST).unsigned_abs(),
        roughness: p.float("roughness", 0.5),
    }
}

fn marble(_: &mut Context<'_>, p: &Reader<'_>, texture: &Definition) -> Option<Texture> {
    let (scale, variation) = (p.float("scale", 1.0), p.float("variation", 0.2));
    Some(Texture::Marble { noise: noise(p, texture), scale, variation })
}

/// Ptex files give each face of a mesh an image of its own.
fn ptex(cx: &mut Context<'_>, p: &Reader<'_>, texture: &Definition) -> Option<Texture> {
    let (encoding, scale) = (encoding(p).unwrap_or(Encoding::Gamma(2.2)), p.float("scale", 1.0));
    let Some(name) = filename(p) else { return Some(placeholder(texture.kind)) };
    let Some(images) = face_images(cx, name) else { return Some(placeholder(texture.kind)) };
    Some(Texture::Faces(FaceTexture { images, encoding, scale }))
}

fn imagemap(cx: &mut Context<'_>, p: &Reader<'_>, texture: &Definition) -> Option<Texture> {
    let mapping = mapping(p, texture);
    let filter = filter(p);
    let wrap = wrap(p);
    let (scale, invert) = (p.float("scale", 1.0), p.bool("invert", false));
    let encoding = encoding(p);
    let Some(name) = filename(p) else { return Some(placeholder(texture.kind)) };
    // The name stays defined if the image can't be read, so that there is one error for it and not one a use.
    let Some(image) = image(cx, name, encoding) else { return Some(placeholder(texture.kind)) };
    Some(Texture::Image(ImageTexture { image, mapping, wrap, filter, scale, invert }))
}

/// The name of the file; `None`, reported, if there is none.
fn filename<'p>(p: &Reader<'p>) -> Option<&'p Name> {
    let name = p.string("filename");
    if name.is_none() && !p.has("filename") {
        let message = format!("{} needs a `string filename`", p.what());
        p.report().error("missing-parameter", p.span(), message);
    }
    name
}

/// What stands for a texture whose image could not be read, which is an error.
fn placeholder(kind: Kind) -> Texture {
    Texture::Constant(Spectrum::Constant(match kind {
        Kind::Float => 1.0,
        Kind::Spectrum => 0.5,
    }))
}

fn filter(p: &Reader<'_>) -> TextureFilter {
    const RANGE: std::ops::RangeInclusive<f32> = 1.0..=ImageTexture::MOST_ANISOTROPY;
    let requirement = format!("from 1 to {}", ImageTexture::MOST_ANISOTROPY);
    let max_anisotropy = p.float_where("maxanisotropy", 8.0, |value| RANGE.contains(&value), &requirement);
    let ewa = TextureFilter::Ewa { max_anisotropy };
    let filters = [
        ("bilinear", TextureFilter::Bilinear),
        ("point", TextureFilter::Nearest),
        ("trilinear", TextureFilter::Trilinear),
        ("EWA", ewa),
        ("ewa", ewa),
    ];
    p.choice("filter", &filters, TextureFilter::Bilinear)
}

fn wrap(p: &Reader<'_>) -> Wrap {
    let modes = [
        ("repeat", Wrap::Repeat),
        ("clamp", Wrap::Clamp),
        ("black", Wrap::Black),
        ("octahedralsphere", Wrap::OctahedralSphere),
    ];
    p.choice("wrap", &modes, Wrap::Repeat)
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

/// The map to a texture of two dimensions. Those that are not `uv` start from the space of the definition.
fn mapping(p: &Reader<'_>, texture: &Definition) -> TextureMapping {
    type Make = fn(&Reader<'_>, Transform) -> TextureMapping;
    let mappings: [(&str, Make); 4] = [
        ("uv", uv_mapping),
        ("spherical", |_, world_to_texture| TextureMapping::Spherical { world_to_texture }),
        ("cylindrical", |_, world_to_texture| TextureMapping::Cylindrical { world_to_texture }),
        ("planar", planar_mapping),
    ];
    let make = p.choice("mapping", &mappings, uv_mapping);
    let mapping = make(p, texture.world_to_texture());
    // Programs write them whatever the mapping is.
    p.without_effect(&["uscale", "vscale", "udelta", "vdelta", "v1", "v2"]);
    mapping
}

fn uv_mapping(p: &Reader<'_>, _: Transform) -> TextureMapping {
    TextureMapping::Uv(UvMapping {
        scale: [p.float("uscale", 1.0), p.float("vscale", 1.0)],
        offset: [p.float("udelta", 0.0), p.float("vdelta", 0.0)],
    })
}

fn planar_mapping(p: &Reader<'_>, world_to_texture: Transform) -> TextureMapping {
    TextureMapping::Planar {
        world_to_texture,
        s: vector(p, "v1", Vec3::X),
        t: vector(p, "v2", Vec3::Y),
        offset: [p.float("udelta", 0.0), p.float("vdelta", 0.0)],
    }
}

/// The vector called `name`.
fn vector(p: &Reader<'_>, name: &'static str, default: Vec3) -> Vec3 {
    let (Some(vectors), Some(parameter)) = (p.vectors(name, ParameterKind::Vector3), p.find(name)) else {
        return default;
    };
    p.one(parameter, &vectors).copied().unwrap_or(default)
}

/// The texture that the image called `name` is over a surface that emits: as pbrt-v4 has it, once and interpolated.
pub(super) fn emission_image(cx: &mut Context<'_>, name: &Name) -> Option<Handle<Texture>> {
    let texture = ImageTexture {
        image: image(cx, name, None)?,
        mapping: TextureMapping::default(),
        wrap: Wrap::Clamp,
        filter: TextureFilter::Bilinear,
        scale: 1.0,
        invert: false,
    };
    Some(cx.scene.textures.push(Texture::Image(texture), Origin::at(name.span)))
}
