use std::sync::Arc;

use sahl_image::{ColorSpace, Encoding, Image, Pixels};
use sahl_scene::{
    Diagnostics, FloatParam, Handle, ImageTexture, Origin, SceneDesc, SolidNoise, Spectrum as Color,
    SpectrumParam, Texture, TextureFilter, TextureMapping, UvMapping, Wrap,
};

use super::*;

fn compile(textures: Vec<Texture>, image: Option<Image>) -> (Textures, Diagnostics) {
    let mut scene = SceneDesc::default();
    for texture in textures {
        scene.textures.push(texture, Origin::default());
    }
    if let Some(image) = image {
        scene.images.push(Arc::new(image), Origin::default());
    }
    let mut diagnostics = Diagnostics::default();
    (Textures::new(&scene, &mut diagnostics), diagnostics)
}

fn rgb(rgb: [f32; 3]) -> SpectrumParam {
    SpectrumParam::Constant(Color::srgb(rgb))
}

fn texture(index: u32) -> SpectrumParam {
    SpectrumParam::Texture(Handle::new(index))
}

fn at(u: f32, v: f32) -> TexturePoint {
    TexturePoint { uv: Vec2::new(u, v), ..Default::default() }
}

/// The colour of texture `index` as an albedo.
fn albedo(textures: &Textures, index: u32, at: &TexturePoint) -> [f32; 3] {
    let source =
        textures.spectrum_source(&texture(index), ColorRole::Albedo, None, &mut Diagnostics::default());
    textures.spectrum(&source, at, &Wavelengths::Rgb).to_rgb()
}

fn float(textures: &Textures, index: u32, at: &TexturePoint) -> f32 {
    textures.float(&textures.float_source(&FloatParam::Texture(Handle::new(index))), at)
}

#[test]
fn constants_are_resolved() {
    let constant = Texture::Constant(Color::srgb([0.1, 0.2, 1.5]));
    let (textures, diagnostics) = compile(vec![constant], None);
    assert!(diagnostics.is_empty());
    let param = texture(0);
    let mut none = Diagnostics::default();
    let source = textures.spectrum_source(&param, ColorRole::Albedo, None, &mut none);
    assert!(matches!(source, SpectrumSource::Constant(_)));
    assert_eq!(albedo(&textures, 0, &at(0.0, 0.0)), [0.1, 0.2, 1.0]);
    let emission = textures.spectrum_source(&param, ColorRole::Illuminant, None, &mut none);
    assert_eq!(textures.spectrum(&emission, &at(0.0, 0.0), &Wavelengths::Rgb).to_rgb(), [0.1, 0.2, 1.5]);
    assert_eq!(textures.float_source(&FloatParam::Texture(Handle::new(0))), FloatSource::Constant(0.1));
    assert_eq!(textures.float_source(&FloatParam::Constant(7.0)), FloatSource::Constant(7.0));
}

#[test]
fn scale_and_mix_compute() {
    let scale = Texture::Scale { texture: rgb([0.5, 0.25, 1.0]), scale: FloatParam::Constant(0.5) };
    let mix = Texture::Mix {
        first: texture(0),
        second: rgb([1.0, 1.0, 0.0]),
        amount: FloatParam::Texture(Handle::new(2)),
    };
    let (textures, diagnostics) = compile(vec![scale, mix, Texture::Constant(Color::Constant(0.25))], None);
    assert!(diagnostics.is_empty());
    assert_eq!(albedo(&textures, 0, &at(0.0, 0.0)), [0.25, 0.125, 0.5]);
    assert_eq!(albedo(&textures, 1, &at(0.0, 0.0)), [0.4375, 0.34375, 0.375]);
    assert_eq!(float(&textures, 1, &at(0.0, 0.0)), 0.4375);
}

#[test]
fn checkers_alternate_also_below_zero() {
    let mapping = TextureMapping::Uv(UvMapping { scale: [2.0, 4.0], offset: [0.0, 1.0] });
    let checker = Texture::Checkerboard { mapping, even: rgb([1.0; 3]), odd: rgb([0.0; 3]) };
    let (textures, _) = compile(vec![checker], None);
    let is_even = |u, v| albedo(&textures, 0, &at(u, v)) == [1.0; 3];
    // (0, 1), (1, 1), (0, 2), (-1, 1), (-1, 0).
    assert_eq!(
        [(0.1, 0.1), (0.6, 0.1), (0.1, 0.3), (-0.1, 0.1), (-0.1, -0.2)].map(|(u, v)| is_even(u, v)),
        [false, true, true, true, false]
    );
    // Any number has a square.
    is_even(f32::INFINITY, f32::NAN);
}

#[test]
fn bilerp_interpolates_the_corners() {
    let corners = [[0.1, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.4]].map(rgb);
    let (textures, _) = compile(vec![Texture::Bilerp { mapping: TextureMapping::default(), corners }], None);
    let close = |u, v, expected: [f32; 3]| {
        let found = albedo(&textures, 0, &at(u, v));
        found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6)
    };
    assert!(close(0.0, 0.0, [0.1, 0.0, 0.0]) && close(1.0, 0.0, [0.3, 0.0, 0.0]));
    assert!(close(0.0, 1.0, [0.0, 0.2, 0.0]) && close(1.0, 1.0, [0.0, 0.0, 0.4]));
    assert!(close(0.5, 0.5, [0.1, 0.05, 0.1]));
}

#[test]
fn directions_mix_by_the_normal() {
    let mix = Texture::DirectionMix {
        first: rgb([1.0; 3]),
        second: rgb([0.0; 3]),
        direction: Vec3::new(0.0, 0.0, 3.0),
    };
    let (textures, _) = compile(vec![mix], None);
    for (n, expected) in [(Vec3::Z, 1.0), (-Vec3::Z, 1.0), (Vec3::X, 0.0), (Vec3::new(0.8, 0.0, -0.6), 0.6)] {
        let found = float(&textures, 0, &TexturePoint { n, ..Default::default() });
        assert!((found - expected).abs() < 1e-6, "{n:?} {found}");
    }
}

#[test]
fn space_is_chequered_in_cubes() {
    let world_to_texture = Transform::scale(2.0, 2.0, 2.0).unwrap();
    let board = Texture::SolidCheckerboard { world_to_texture, even: rgb([1.0; 3]), odd: rgb([0.0; 3]) };
    let (textures, _) = compile(vec![board], None);
    let value = |x, y, z| float(&textures, 0, &TexturePoint { p: Vec3::new(x, y, z), ..Default::default() });
    assert_eq!([value(0.1, 0.1, 0.1), value(0.6, 0.1, 0.1), value(0.6, 0.6, 0.1)], [1.0, 0.0, 1.0]);
    assert_eq!([value(0.6, 0.6, 0.6), value(-0.1, 0.1, 0.1), value(-0.1, -0.1, -0.1)], [0.0, 0.0, 0.0]);
}

#[test]
fn noise_is_a_number_in_either_sense() {
    let noise = SolidNoise { world_to_texture: Transform::IDENTITY, octaves: 4, roughness: 0.5 };
    let described = vec![
        Texture::Fbm(noise),
        Texture::Wrinkled(noise),
        Texture::Windy { world_to_texture: Transform::IDENTITY },
        Texture::Marble { noise, scale: 2.0, variation: 0.4 },
        Texture::Dots { mapping: TextureMapping::default(), inside: rgb([0.9; 3]), outside: texture(0) },
    ];
    let count = described.len() as u32;
    let (textures, diagnostics) = compile(described, None);
    assert!(diagnostics.is_empty() && textures.need_footprint());
    for i in 0..200 {
        let i = i as f32 * 0.37;
        let point =
            TexturePoint { p: Vec3::new(i, -0.3 * i, 1.7 * i), uv: Vec2::splat(i), ..Default::default() };
        for index in 0..count {
            let number = float(&textures, index, &point);
            let color = albedo(&textures, index, &point);
            assert!(number.is_finite() && color.iter().all(|x| (0.0..=1.0).contains(x)), "{index} {number}");
            // A spectrum is limited to what its role allows; marble alone has a colour.
            if index != 3 {
                assert!((color[0] - number.clamp(0.0, 1.0)).abs() < 1e-6, "{index} {color:?} {number}");
            } else {
                assert!((color.iter().sum::<f32>() / 3.0 - number).abs() < 1e-6);
            }
        }
    }
}

#[test]
fn filters_average_over_the_footprint() {
    let value = |filter, size: f32| {
        let texture = ImageTexture { scale: 1.0, ..image_texture(Wrap::Repeat, filter) };
        let (textures, _) = compile(vec![Texture::Image(texture)], Some(numbered(1)));
        let footprint =
            Footprint { duv_dx: Vec2::new(size, 0.0), duv_dy: Vec2::new(0.0, size), ..Default::default() };
        (float(&textures, 0, &TexturePoint { footprint, ..at(0.1, 0.9) }), textures)
    };
    for filter in [TextureFilter::Trilinear, TextureFilter::Ewa { max_anisotropy: 8.0 }] {
        let (near, textures) = value(filter, 0.0);
        assert!(textures.need_footprint() && textures.pyramid_bytes() > 0);
        let (plain, textures) = value(TextureFilter::Bilinear, 3.0);
        assert!(!textures.need_footprint() && textures.pyramid_bytes() == 0);
        assert_eq!(near, plain);
        assert!((value(filter, 3.0).0 - 2.5 / 8.0).abs() < 1e-6);
    }
}

/// Two rows of three pixels: grey values 0 to 5, top row first.
fn numbered(channels: usize) -> Image {
    let pixels =
        (0..6).flat_map(|i| (0..channels).map(move |c| if c == 3 { 0.5 } else { i as f32 / 8.0 })).collect();
    Image {
        width: 3,
        height: 2,
        channels,
        pixels: Pixels::F32(pixels),
        encoding: Encoding::Linear,
        color_space: ColorSpace::Srgb,
    }
}

fn image_texture(wrap: Wrap, filter: TextureFilter) -> ImageTexture {
    ImageTexture {
        image: Handle::new(0),
        mapping: TextureMapping::default(),
        wrap,
        filter,
        scale: 8.0,
        invert: false,
    }
}

#[test]
fn images_start_at_the_bottom_and_wrap() {
    let value = |wrap, u, v| {
        let (textures, _) =
            compile(vec![Texture::Image(image_texture(wrap, TextureFilter::Nearest))], Some(numbered(1)));
        float(&textures, 0, &at(u, v))
    };
    assert_eq!([(0.1, 0.1), (0.9, 0.1), (0.5, 0.9)].map(|(u, v)| value(Wrap::Repeat, u, v)), [3.0, 5.0, 1.0]);
    assert_eq!([Wrap::Repeat, Wrap::Clamp, Wrap::Black].map(|wrap| value(wrap, 1.1, -0.1)), [0.0, 5.0, 0.0]);
    assert_eq!([Wrap::Repeat, Wrap::Clamp, Wrap::Black].map(|wrap| value(wrap, -3.1, 7.9)), [2.0, 0.0, 0.0]);
    for wild in [f32::NAN, f32::INFINITY, -1e30, 1e30] {
        assert!(value(Wrap::Repeat, wild, 0.5).is_finite());
        assert!(value(Wrap::Clamp, 0.5, wild).is_finite());
    }
}

#[test]
fn bilinear_interpolates_between_centers() {
    let value = |wrap, u, v| {
        let (textures, _) =
            compile(vec![Texture::Image(image_texture(wrap, TextureFilter::Bilinear))], Some(numbered(3)));
        albedo(&textures, 0, &at(u, v))[0]
    };
    // Albedos end at one: the centres of the pixels 0 and 1 of the upper row, and halfway to the lower row.
    assert!((value(Wrap::Clamp, 1.0 / 6.0, 0.75) - 0.0).abs() < 1e-6);
    assert!((value(Wrap::Clamp, 0.25, 0.75) - 0.25).abs() < 1e-5);
    assert!((value(Wrap::Clamp, 1.0 / 6.0, 0.7) - 0.3).abs() < 1e-5);
    assert_eq!(value(Wrap::Clamp, 0.5, 0.25), 1.0);
    // Across the border: repeated, the neighbour of pixel 0 on the left is pixel 2; black, it is nothing.
    assert!((value(Wrap::Repeat, 0.1, 0.75) - 0.4).abs() < 1e-5);
    assert_eq!(value(Wrap::Black, 0.1, 0.75), 0.0);
}

#[test]
fn numbers_come_from_alpha_or_the_mean() {
    let value = |image: Image| {
        let texture = ImageTexture { scale: 1.0, ..image_texture(Wrap::Clamp, TextureFilter::Nearest) };
        let (textures, _) = compile(vec![Texture::Image(texture)], Some(image));
        float(&textures, 0, &at(0.5, 0.9))
    };
    assert_eq!(value(numbered(4)), 0.5);
    assert_eq!(value(numbered(2)), 0.125);
    let pixels = [30_u8, 60, 90, 255].repeat(6);
    let opaque = Image { pixels: Pixels::U8(pixels), ..numbered(4) };
    assert!((value(opaque) - 60.0 / 255.0).abs() < 1e-6);
}

#[test]
fn bytes_are_decoded_and_inverted() {
    let image = Image { pixels: Pixels::U8(vec![128; 18]), encoding: Encoding::Srgb, ..numbered(3) };
    let texture =
        ImageTexture { scale: 2.0, invert: true, ..image_texture(Wrap::Clamp, TextureFilter::Bilinear) };
    let (textures, _) = compile(vec![Texture::Image(texture)], Some(image));
    let expected = 1.0 - 2.0 * Encoding::Srgb.decode(128.0 / 255.0);
    assert!((albedo(&textures, 0, &at(0.3, 0.3))[1] - expected).abs() < 1e-6);
    assert!((float(&textures, 0, &at(0.3, 0.3)) - expected).abs() < 1e-6);
}

#[test]
fn white_is_white_in_every_space() {
    for color_space in [ColorSpace::Srgb, ColorSpace::DciP3, ColorSpace::Rec2020, ColorSpace::Aces2065_1] {
        let image = Image { pixels: Pixels::F32(vec![0.5; 18]), color_space, ..numbered(3) };
        let texture = ImageTexture { scale: 1.0, ..image_texture(Wrap::Clamp, TextureFilter::Nearest) };
        let (textures, _) = compile(vec![Texture::Image(texture)], Some(image));
        let color = albedo(&textures, 0, &at(0.3, 0.3));
        assert!(color.iter().all(|x| (x - 0.5).abs() < 1e-4), "{color_space:?}: {color:?}");
    }
    let green = [0.0, 0.5, 0.0].repeat(6);
    let image = Image { pixels: Pixels::F32(green), color_space: ColorSpace::Rec2020, ..numbered(3) };
    let texture = ImageTexture { scale: 1.0, ..image_texture(Wrap::Clamp, TextureFilter::Nearest) };
    let (textures, _) = compile(vec![Texture::Image(texture)], Some(image));
    let [r, g, b] = albedo(&textures, 0, &at(0.3, 0.3));
    assert!(r == 0.0 && b == 0.0 && (g - 0.566).abs() < 2e-3, "{r} {g} {b}");
}

#[track_caller]
fn assert_error(textures: Vec<Texture>, code: &str) {
    let last = textures.len() as u32 - 1;
    let (textures, diagnostics) = compile(textures, None);
    assert!(diagnostics.has_errors());
    assert!(diagnostics.iter().any(|diagnostic| diagnostic.code == code), "{diagnostics:?}");
    assert!(albedo(&textures, last, &at(0.5, 0.5)).iter().all(|x| x.is_finite()));
}

#[test]
fn broken_textures_are_errors() {
    let scaled = |param| Texture::Scale { texture: param, scale: FloatParam::Constant(0.5) };
    assert_error(vec![scaled(texture(0))], "texture-cycle");
    assert_error(vec![scaled(texture(1)), scaled(texture(2)), scaled(texture(0))], "texture-cycle");
    assert_error(vec![scaled(texture(9))], "missing-texture");
    assert_error(vec![Texture::Image(image_texture(Wrap::Clamp, TextureFilter::Nearest))], "missing-image");
    // A chain of a hundred thousand, from the far end and from the near one.
    let count = 100_000;
    let mut chain: Vec<Texture> = (1..count).map(|i| scaled(texture(i))).collect();
    chain.push(Texture::Constant(Color::Constant(1.0)));
    assert_error(chain.clone(), "texture-too-deep");
    // A shallow graph whose evaluation doubles at each level.
    let double =
        |i: u32| Texture::Mix { first: texture(i), second: texture(i), amount: FloatParam::Constant(0.5) };
    let mut graph = vec![Texture::Constant(Color::Constant(1.0))];
    graph.extend((0..40).map(double));
    assert_error(graph, "texture-too-large");
}

#[test]
fn sharing_without_excess_is_fine() {
    let scaled = |param| Texture::Scale { texture: param, scale: FloatParam::Constant(0.5) };
    let shared = Texture::Mix { first: texture(1), second: texture(1), amount: FloatParam::Constant(0.5) };
    // The child comes after its parents.
    let (textures, diagnostics) =
        compile(vec![shared, scaled(texture(2)), Texture::Constant(Color::Constant(1.0))], None);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    assert_eq!(albedo(&textures, 0, &at(0.0, 0.0)), [0.5; 3]);
}
