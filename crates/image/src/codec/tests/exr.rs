//! EXR: layers, metadata, colour, and files of other programs.

use std::io::Cursor;

use exr::image::{
    AnyChannel, AnyChannels, Encoding as Blocks, FlatSamples, Image as ExrImage, Layer as ExrLayer, Layers,
};
use exr::meta::attribute::Chromaticities;
use exr::prelude::{Compression, LayerAttributes, LineOrder, SmallVec, Vec2, WritableImage, f16};

use super::{byte_image, floats, light_image};
use crate::{
    Attribute, ColorSpace, EncodeOptions, Format, Image, ImageError, Layer, Metadata, Picture, Pixels,
    Precision, encode, probe, read, read_layers,
};

fn write(picture: &Picture) -> Vec<u8> {
    encode(picture, Format::Exr, &EncodeOptions::default()).unwrap()
}

fn full_picture() -> Picture {
    let layers = vec![
        Layer::beauty(light_image(5, 4, 4).with_color_space(ColorSpace::Rec2020)),
        Layer::new(None, &["Z"], light_image(5, 4, 1).with_color_space(ColorSpace::Rec2020)).unwrap(),
        Layer::new(
            Some("Albedo"),
            &["R", "G", "B"],
            light_image(5, 4, 3).with_color_space(ColorSpace::Rec2020),
        )
        .unwrap(),
        Layer::new(Some("P"), &["X", "Y", "Z"], light_image(5, 4, 3).with_color_space(ColorSpace::Rec2020))
            .unwrap(),
    ];
    let metadata = Metadata {
        software: Some("a renderer 1.0".into()),
        comments: Some("für die Prüfung".into()),
        samples: Some(64),
        seed: Some(u64::MAX),
        offset: [3, 7],
        full_size: Some([20, 30]),
        attributes: vec![
            ("owner".into(), Attribute::Text("nobody".into())),
            ("renderTimeSeconds".into(), Attribute::Float(1.5)),
            ("scene".into(), Attribute::Text("box".into())),
            ("version2".into(), Attribute::Int(-4)),
            ("worldToCamera".into(), Attribute::Matrix(std::array::from_fn(|index| index as f32))),
        ],
    };
    Picture { layers, metadata }
}

#[test]
fn layers_and_metadata_come_back() {
    let picture = full_picture();
    let file = write(&picture);
    let back = read_layers(&file, "").unwrap();
    assert_eq!(back.metadata, picture.metadata);
    assert_eq!(back.layers.len(), picture.layers.len());
    for layer in &picture.layers {
        assert!(back.layers.contains(layer), "{:?}", layer.name);
    }
    assert_eq!(read(&file, "").unwrap(), picture.layers[0].image);
    let info = probe(&file, "").unwrap();
    assert_eq!((info.width, info.height, info.channels, info.bits), (5, 4, 11, 32));
}

#[test]
fn every_bit_of_a_float_is_kept() {
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, 1e-45, f32::MAX];
    let image = Image::rgb_f32(2, 1, odd.to_vec()).unwrap();
    let back = read(&write(&Picture::from_image(image)), "").unwrap();
    for (found, expected) in floats(&back).iter().zip(odd) {
        assert_eq!(found.to_bits(), expected.to_bits());
    }
}

#[test]
fn equal_pictures_give_equal_bytes() {
    let picture = full_picture();
    let file = write(&picture);
    for _ in 0..8 {
        assert_eq!(write(&picture), file);
    }
    let mut reversed = picture;
    reversed.metadata.attributes.reverse();
    assert_eq!(write(&reversed), file);
}

#[test]
fn half_is_for_colours_alone() {
    let mut picture = full_picture();
    if let Pixels::F32(values) = &mut picture.layers[0].image.pixels {
        values[0] = 1e9;
    }
    let options = EncodeOptions { precision: Precision::Half, ..EncodeOptions::default() };
    let file = encode(&picture, Format::Exr, &options).unwrap();
    let back = read_layers(&file, "").unwrap();
    let beauty = back.beauty().unwrap();
    assert_eq!(floats(&beauty.image)[0], 65504.0);
    for (found, expected) in floats(&beauty.image).iter().zip(floats(&picture.layers[0].image)).skip(1) {
        assert!((found - expected).abs() <= expected.abs() / 2048.0 + 3e-8, "{found} {expected}");
    }
    assert_eq!(back.layer("P"), picture.layer("P"));
    assert!(file.len() < write(&picture).len());
}

#[test]
fn bytes_are_decoded_to_light() {
    let back = read(&write(&Picture::from_image(byte_image(3, 2, 3))), "").unwrap();
    assert_eq!(back, byte_image(3, 2, 3).to_linear_f32());
}

#[test]
fn pictures_that_exr_cannot_hold_are_refused() {
    let message =
        |picture: &Picture| encode(picture, Format::Exr, &EncodeOptions::default()).unwrap_err().to_string();
    assert_eq!(message(&Picture::default()), "can't write EXR: the picture has no layer");
    let mut twice = Picture::from_image(light_image(2, 2, 3));
    twice.layers.push(Layer::beauty(light_image(2, 2, 3)));
    assert_eq!(message(&twice), "can't write EXR: two channels are called `R`");
    let mut sizes = Picture::from_image(light_image(2, 2, 3));
    sizes.layers.push(Layer::new(Some("Z"), &["Z"], light_image(3, 2, 1)).unwrap());
    assert!(message(&sizes).contains("layer `Z` has 3x2 pixels, expected 2x2"));
    assert!(message(&Picture::from_image(light_image(0, 2, 3))).contains("0x2"));
    let mut names = Picture::from_image(light_image(2, 2, 3));
    names.layers[0].channel_names.pop();
    assert!(message(&names).contains("2 channel names for 3 channels"));
    names.layers[0].channel_names.push(String::new());
    assert!(message(&names).contains("can't be a name"));
    let mut attributes = full_picture();
    attributes.metadata.attributes.push(("seed".into(), Attribute::Int(1)));
    assert_eq!(message(&attributes), "can't write EXR: two attributes are called `seed`");
    attributes.metadata.attributes.pop();
    attributes.metadata.attributes.push(("compression".into(), Attribute::Int(1)));
    assert!(encode(&attributes, Format::Exr, &EncodeOptions::default()).is_err());
}

/// A part of another program's file.
fn part(
    name: Option<&str>,
    channels: Vec<(&str, FlatSamples)>,
    encoding: Blocks,
) -> ExrLayer<AnyChannels<FlatSamples>> {
    let list: SmallVec<[AnyChannel<FlatSamples>; 4]> =
        channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect();
    let attributes = match name {
        Some(name) => LayerAttributes::named(name),
        None => LayerAttributes::default(),
    };
    ExrLayer::new((40, 20), attributes, encoding, AnyChannels::sort(list))
}

fn plane(offset: f32) -> FlatSamples {
    FlatSamples::F32((0..800).map(|index| offset + (index % 97) as f32).collect())
}

fn file_of(
    parts: Vec<ExrLayer<AnyChannels<FlatSamples>>>,
    chromaticities: Option<Chromaticities>,
) -> Vec<u8> {
    let mut attributes = exr::meta::header::ImageAttributes::with_size((40, 20));
    attributes.chromaticities = chromaticities;
    let image = ExrImage { attributes, layer_data: Layers::from_vec(parts) };
    let mut file = Vec::new();
    image.write().non_parallel().to_buffered(Cursor::new(&mut file)).unwrap();
    file
}

fn rgb(encoding: Blocks) -> ExrLayer<AnyChannels<FlatSamples>> {
    part(Some("main"), vec![("R", plane(0.0)), ("G", plane(1000.0)), ("B", plane(2000.0))], encoding)
}

/// Every compression that the reader knows.
pub(super) const LOSSY_AND_LOSSLESS: [Compression; 10] = [
    Compression::Uncompressed,
    Compression::RLE,
    Compression::ZIP1,
    Compression::ZIP16,
    Compression::PIZ,
    Compression::PXR24,
    Compression::B44,
    Compression::B44A,
    Compression::DWAA(None),
    Compression::DWAB(None),
];

/// A file in scan lines and one in tiles.
pub(super) fn variants(compression: Compression) -> [Vec<u8>; 2] {
    [exr::prelude::Blocks::ScanLines, exr::prelude::Blocks::Tiles(Vec2(16, 16))].map(|blocks| {
        file_of(vec![rgb(Blocks { compression, blocks, line_order: LineOrder::Increasing })], None)
    })
}

#[test]
fn lossy_compressions_are_read() {
    for compression in LOSSY_AND_LOSSLESS {
        for file in variants(compression) {
            let image = read(&file, "").unwrap();
            for (found, expected) in image.pixel(5, 1).iter().zip([45.0_f32, 1045.0, 2045.0]) {
                assert!((found / expected - 1.0).abs() < 0.1, "{compression:?} {found} {expected}");
            }
        }
    }
}

#[test]
fn tiles_and_lossless_compressions_are_read() {
    let compressions = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
    ];
    for compression in compressions {
        for blocks in [exr::prelude::Blocks::ScanLines, exr::prelude::Blocks::Tiles(Vec2(16, 16))] {
            let encoding = Blocks { compression, blocks, line_order: LineOrder::Increasing };
            let image = read(&file_of(vec![rgb(encoding)], None), "").unwrap();
            assert_eq!((image.width, image.height, image.channels), (40, 20, 3));
            assert_eq!(image.pixel(5, 1)[..3], [45.0, 1045.0, 2045.0], "{compression:?}");
            assert_eq!(image.pixel(39, 19)[..3], [23.0, 1023.0, 2023.0]);
        }
    }
}

#[test]
fn parts_become_layers() {
    let integers = FlatSamples::U32((0..800).collect());
    let halves = FlatSamples::F16((0..800).map(|index| f16::from_f32(index as f32)).collect());
    let encoding = Blocks::FAST_LOSSLESS;
    let depth = part(Some("depth"), vec![("Z", halves)], encoding);
    let many = ["a", "b", "c", "d", "e"].map(|name| (name, plane(0.0))).into_iter();
    let ids = part(Some("ids"), many.chain([("id.first", integers)]).collect(), encoding);
    let picture = read_layers(&file_of(vec![rgb(encoding), depth, ids], None), "").unwrap();
    let names: Vec<(Option<&str>, String)> =
        picture.layers.iter().map(|layer| (layer.name.as_deref(), layer.channel_names.concat())).collect();
    let expected = [
        (None, "RGB"),
        (Some("depth"), "Z"),
        (Some("ids"), "a"),
        (Some("ids"), "b"),
        (Some("ids"), "c"),
        (Some("ids"), "d"),
        (Some("ids"), "e"),
        (Some("id"), "first"),
    ];
    assert_eq!(names, expected.map(|(name, channels)| (name, channels.to_string())));
    assert_eq!(picture.layer("id").unwrap().image.texel(1, 1, 0), 41.0);
    assert_eq!(picture.layer("depth").unwrap().image.texel(2, 1, 0), 42.0);
}

#[test]
fn unusual_primaries_are_converted() {
    let adobe = Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.21, 0.71),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.3290),
    };
    let image = read(&file_of(vec![rgb(Blocks::FAST_LOSSLESS)], Some(adobe)), "").unwrap();
    assert_eq!(image.color_space, ColorSpace::Srgb);
    let expected = crate::color::conversion(
        &crate::Chromaticities {
            red: [0.64, 0.33],
            green: [0.21, 0.71],
            blue: [0.15, 0.06],
            white: [0.3127, 0.3290],
        },
        ColorSpace::Srgb,
    )
    .unwrap();
    let stored = [45.0, 1045.0, 2045.0];
    for (found, row) in image.pixel(5, 1).iter().zip(expected) {
        let value: f64 = row.iter().zip(stored).map(|(a, b)| a * b).sum();
        assert!((f64::from(*found) - value).abs() < 0.01);
    }
    let line = Chromaticities { blue: Vec2(0.64, 0.33), ..adobe };
    let error = read(&file_of(vec![rgb(Blocks::FAST_LOSSLESS)], Some(line)), "").unwrap_err();
    assert_eq!(error.to_string(), "not a valid EXR file: its chromaticities span no colours");
}

#[test]
fn subsampled_channels_are_refused() {
    let mut file = write(&Picture::from_image(light_image(4, 4, 1)));
    let key = b"chlist\0";
    let list = file.windows(key.len()).position(|bytes| bytes == key).unwrap() + key.len() + 4;
    // Name and its end, type, linearity: then the steps in x and y.
    let steps = list + 2 + 4 + 4;
    assert_eq!(file[steps..steps + 8], [1, 0, 0, 0, 1, 0, 0, 0]);
    file[steps] = 2;
    file[steps + 4] = 2;
    let error = read(&file, "").unwrap_err();
    assert!(matches!(error, ImageError::Unsupported { .. }), "{error}");
}
