//! Formats of one image.

use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::tga::TgaEncoder;

use super::{byte_image, bytes, floats, light_image};
use crate::{
    BitDepth, ColorSpace, Curve, EncodeOptions, Encoding, Format, Image, ImageError, Pixels, ToneMap, probe,
    read,
};

const DEFAULT: EncodeOptions = EncodeOptions {
    tone_map: ToneMap { exposure_stops: 0.0, curve: Curve::Srgb },
    bit_depth: BitDepth::Eight,
    precision: crate::Precision::Float,
};

#[test]
fn png_keeps_bytes_of_any_channels() {
    for channels in 1..=4 {
        let image = byte_image(7, 5, channels);
        let file = image.encode(Format::Png, &DEFAULT).unwrap();
        assert_eq!(read(&file, "").unwrap(), image);
        let info = probe(&file, "").unwrap();
        assert_eq!((info.width, info.height, info.channels, info.bits), (7, 5, channels, 8));
        assert!(file.windows(4).any(|window| window == b"sRGB"));
        assert_eq!(file, image.encode(Format::Png, &DEFAULT).unwrap());
    }
}

#[test]
fn png_of_16_bits_keeps_65536_steps() {
    let options = EncodeOptions { bit_depth: BitDepth::Sixteen, ..DEFAULT };
    let values: Vec<f32> = (0..30).map(|step| (step * 2251) as f32 / 65535.0).collect();
    let image = Image::rgb_f32(5, 2, values.clone()).unwrap().with_encoding(Encoding::Srgb);
    let file = image.encode(Format::Png, &options).unwrap();
    assert_eq!(probe(&file, "").unwrap().bits, 16);
    let back = read(&file, "").unwrap();
    assert_eq!(back.encoding, Encoding::Srgb);
    assert_eq!(floats(&back), values);
}

#[test]
fn light_is_tone_mapped_for_png_and_ppm() {
    let light = Image::rgb_f32(2, 1, vec![0.25, 0.5, 2.0, f32::NAN, -1.0, 0.0]).unwrap();
    let options = EncodeOptions { tone_map: ToneMap { exposure_stops: 1.0, curve: Curve::Srgb }, ..DEFAULT };
    for format in [Format::Png, Format::Ppm] {
        let shown = read(&light.encode(format, &options).unwrap(), "").unwrap();
        // 0.5 is 188 in sRGB.
        assert_eq!(bytes(&shown), [188, 255, 255, 0, 0, 0]);
    }
    let wide = Image::rgb_f32(1, 1, vec![0.2, 0.3, 0.4]).unwrap();
    let same = wide.to_color_space(ColorSpace::Rec2020).encode(Format::Png, &DEFAULT).unwrap();
    assert_eq!(same, wide.encode(Format::Png, &DEFAULT).unwrap());
}

#[test]
fn png_palettes_transparency_and_small_depths_are_expanded() {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 4, 1);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Two);
    encoder.set_palette(vec![1, 2, 3, 40, 50, 60, 255, 0, 255, 9, 9, 9]);
    encoder.set_trns(vec![255, 128]);
    encoder.write_header().unwrap().write_image_data(&[0b0001_1011]).unwrap();
    let image = read(&file, "").unwrap();
    assert_eq!(image.channels, 4);
    assert_eq!(bytes(&image), [1, 2, 3, 255, 40, 50, 60, 128, 255, 0, 255, 255, 9, 9, 9, 255]);
    assert_eq!(probe(&file, "").unwrap().channels, 4);

    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 8, 1);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::One);
    encoder.write_header().unwrap().write_image_data(&[0b1010_0001]).unwrap();
    assert_eq!(bytes(&read(&file, "").unwrap()), [255, 0, 255, 0, 0, 0, 0, 255]);
}

#[test]
fn png_gamma_is_honoured() {
    let with_gamma = |gamma: f32| {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, 1, 1);
        encoder.set_source_gamma(png::ScaledFloat::new(gamma));
        encoder.write_header().unwrap().write_image_data(&[128]).unwrap();
        read(&file, "").unwrap().encoding
    };
    assert_eq!(with_gamma(1.0), Encoding::Linear);
    assert_eq!(with_gamma(0.5), Encoding::Gamma(2.0));
    assert_eq!(with_gamma(0.45455), Encoding::Srgb);
}

#[test]
fn alpha_is_divided_out_and_multiplied_in() {
    let light = Image::new(1, 1, 4, Pixels::F32(vec![0.25, 0.25, 0.25, 0.5])).unwrap();
    let png = light.encode(Format::Png, &DEFAULT).unwrap();
    let shown = read(&png, "").unwrap();
    assert_eq!(bytes(&shown), [188, 188, 188, 128]);
    let exr = read(&shown.encode(Format::Exr, &DEFAULT).unwrap(), "").unwrap();
    assert!((floats(&exr)[0] - 0.25).abs() < 3e-3, "{exr:?}");
    // Without alpha, the picture is over black: 0.25 is 137 in sRGB.
    for image in [&light, &shown] {
        let ppm = read(&image.encode(Format::Ppm, &DEFAULT).unwrap(), "").unwrap();
        assert!(bytes(&ppm).iter().all(|&byte| byte.abs_diff(137) <= 1), "{ppm:?}");
        let pfm = read(&image.encode(Format::Pfm, &DEFAULT).unwrap(), "").unwrap();
        assert!(pfm.channels == 3 && (floats(&pfm)[0] - 0.25).abs() < 3e-3);
    }
}

#[test]
fn ppm_keeps_bytes() {
    let image = byte_image(5, 3, 3);
    let file = image.encode(Format::Ppm, &DEFAULT).unwrap();
    assert!(file.starts_with(b"P6\n5 3\n255\n"));
    assert_eq!(read(&file, "").unwrap(), image);
    let grey = byte_image(2, 1, 1).encode(Format::Ppm, &DEFAULT).unwrap();
    assert_eq!(grey, b"P6\n2 1\n255\n\x00\x00\x00\x25\x25\x25");
}

#[test]
fn ppm_headers_may_have_comments_and_other_white() {
    let image = read(b"P6 # a comment\n1\t#another\n 1 15 \x00\x03\x0f", "").unwrap();
    assert_eq!(floats(&image), [0.0, 0.2, 1.0]);
    let image = read(b"P6 1 1 1000\n\x00\x00\x01\xf4\x03\xe8", "").unwrap();
    assert_eq!(floats(&image), [0.0, 0.5, 1.0]);
    assert_eq!(probe(b"P6 1 1 1000\n", "").unwrap().bits, 16);
    for broken in
        [&b"P6"[..], b"P6 1", b"P6 1 1 0 \0\0\0", b"P6 x 1 255 \0\0\0", b"P6 1 1 70000 \0\0\0\0\0\0"]
    {
        assert!(matches!(read(broken, ""), Err(ImageError::Malformed { .. })));
    }
}

#[test]
fn pfm_keeps_every_bit() {
    for channels in [1, 3] {
        let mut image = light_image(4, 3, channels);
        if let Pixels::F32(values) = &mut image.pixels {
            values[0] = f32::INFINITY;
            values[1] = f32::NAN;
            values[2] = f32::MIN_POSITIVE / 2.0;
        }
        let file = image.encode(Format::Pfm, &DEFAULT).unwrap();
        let back = read(&file, "").unwrap();
        let bits = |image: &Image| floats(image).iter().map(|value| value.to_bits()).collect::<Vec<u32>>();
        assert_eq!(bits(&back), bits(&image));
        assert_eq!(probe(&file, "").unwrap().channels, channels);
    }
}

#[test]
fn pfm_rows_go_up_and_the_scale_counts() {
    let mut file = b"Pf\n1 2\n2.5\n".to_vec();
    file.extend(1.0_f32.to_be_bytes());
    file.extend(4.0_f32.to_be_bytes());
    assert_eq!(floats(&read(&file, "").unwrap()), [10.0, 2.5]);
    for broken in [&b"PF\n1 1\n0\n"[..], b"PF\n1 1\nnan\n", b"PF\n-1 1\n1\n", b"PF\n", b"PF\n1 1"] {
        assert!(matches!(read(broken, ""), Err(ImageError::Malformed { .. })));
    }
}

#[test]
fn hdr_keeps_eight_bits_of_the_largest_channel() {
    for width in [3, 40] {
        let image = light_image(width, 3, 3);
        let file = image.encode(Format::Hdr, &DEFAULT).unwrap();
        let back = read(&file, "").unwrap();
        for (found, expected) in floats(&back).chunks(3).zip(floats(&image).chunks(3)) {
            let largest = expected.iter().fold(0.0_f32, |largest, value| largest.max(*value));
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected.max(0.0)).abs() <= largest / 128.0, "{found} {expected}");
            }
        }
        assert_eq!(probe(&file, "").unwrap().width, width);
    }
    let extreme = Image::rgb_f32(1, 1, vec![f32::NAN, f32::INFINITY, -5.0]).unwrap();
    let back = read(&extreme.encode(Format::Hdr, &DEFAULT).unwrap(), "").unwrap();
    assert!(floats(&back)[0] == 0.0 && floats(&back)[1] > 1e38 && floats(&back)[2] == 0.0);
}

#[test]
fn hdr_exposure_is_undone() {
    let pixels = b"\x80\x40\x20\x81";
    let file = |header: &[u8]| [b"#?RGBE\n", header, b"\n-Y 1 +X 1\n", pixels].concat();
    let plain = read(&file(b"FORMAT=32-bit_rle_rgbe\n"), "").unwrap();
    assert_eq!(floats(&plain), [1.0, 0.5, 0.25]);
    let exposed = read(&file(b"EXPOSURE=2\nCOLORCORR=1 2 4\nstray line\n"), "").unwrap();
    assert_eq!(floats(&exposed), [0.5, 0.125, 0.03125]);
    let nonsense = read(&file(b"EXPOSURE=0\n"), "").unwrap();
    assert_eq!(floats(&nonsense), [1.0, 0.5, 0.25]);
    assert!(read(&file(b"FORMAT=32-bit_rle_xyze\n"), "").is_err());
}

#[test]
fn tga_is_read_by_its_extension() {
    for (channels, color) in
        [(1, ExtendedColorType::L8), (3, ExtendedColorType::Rgb8), (4, ExtendedColorType::Rgba8)]
    {
        let image = byte_image(6, 4, channels);
        let mut file = Vec::new();
        TgaEncoder::new(&mut file).encode(bytes(&image), 6, 4, color).unwrap();
        assert_eq!(read(&file, "texture.tga").unwrap(), image);
        assert_eq!(probe(&file, "TEXTURE.TGA").unwrap().channels, channels);
        assert!(matches!(read(&file, "texture"), Err(ImageError::UnknownFormat { .. })));
    }
}

#[test]
fn jpeg_is_read_nearly_as_written() {
    let smooth =
        (0..16 * 16).flat_map(|index| [index % 16 * 16, index / 16 * 16, 128].map(|value| value as u8));
    let smooth: Vec<u8> = smooth.collect();
    let mut file = Vec::new();
    JpegEncoder::new_with_quality(&mut file, 100).encode(&smooth, 16, 16, ExtendedColorType::Rgb8).unwrap();
    let image = read(&file, "").unwrap();
    assert_eq!((image.width, image.height, image.channels, image.encoding), (16, 16, 3, Encoding::Srgb));
    for (found, expected) in bytes(&image).iter().zip(&smooth) {
        assert!(found.abs_diff(*expected) < 12);
    }
    assert_eq!(probe(&file, "").unwrap().bits, 8);
}

#[test]
fn some_formats_are_only_read() {
    let image = byte_image(1, 1, 3);
    for format in [Format::Jpeg, Format::Tga] {
        let error = image.encode(format, &DEFAULT).unwrap_err().to_string();
        assert_eq!(error, format!("can't write {format}: this format can only be read"));
        assert!(!format.can_write());
    }
}
