//! Broken bytes: an error or, where the damage can't be seen, an image; never a panic, never absurd memory.

use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::tga::TgaEncoder;

use super::{byte_image, bytes, light_image};
use crate::{BitDepth, EncodeOptions, Format, ImageError, probe, read, read_layers};

/// A small file of every format, and the name it is read by.
fn files() -> Vec<(&'static str, Vec<u8>)> {
    let options = EncodeOptions::default();
    let deep = EncodeOptions { bit_depth: BitDepth::Sixteen, ..options };
    let small = byte_image(9, 4, 3);
    let mut jpeg = Vec::new();
    JpegEncoder::new(&mut jpeg).encode(bytes(&small), 9, 4, ExtendedColorType::Rgb8).unwrap();
    let mut tga = Vec::new();
    TgaEncoder::new(&mut tga).encode(bytes(&small), 9, 4, ExtendedColorType::Rgb8).unwrap();
    vec![
        ("a.png", small.encode(Format::Png, &options).unwrap()),
        ("b.png", light_image(9, 4, 4).encode(Format::Png, &deep).unwrap()),
        ("a.exr", light_image(9, 4, 3).encode(Format::Exr, &options).unwrap()),
        ("a.hdr", light_image(9, 4, 3).encode(Format::Hdr, &options).unwrap()),
        ("a.pfm", light_image(9, 4, 3).encode(Format::Pfm, &options).unwrap()),
        ("a.ppm", small.encode(Format::Ppm, &options).unwrap()),
        ("a.jpg", jpeg),
        ("a.tga", tga),
    ]
}

/// Reads in every way; what comes out must fit together.
fn try_all(file: &[u8], name: &str) {
    let _ = probe(file, name);
    if let Ok(picture) = read_layers(file, name) {
        for layer in &picture.layers {
            let image = &layer.image;
            assert_eq!(image.pixels.len(), image.width * image.height * image.channels);
        }
    }
}

#[test]
fn files_cut_off_anywhere_are_errors() {
    for (name, file) in files() {
        assert!(read(&file, name).is_ok(), "{name}");
        for length in 0..file.len() {
            let cut = &file[..length];
            let _ = probe(cut, name);
            // What follows the last pixel of a TGA is an optional footer.
            if !(name == "a.tga" && file.len() - length <= 26) {
                assert!(read(cut, name).is_err(), "{name} cut to {length} of {} bytes", file.len());
            }
        }
    }
}

#[test]
fn flipped_bits_do_no_harm() {
    for (name, file) in files() {
        for position in 0..file.len() {
            for bit in 0..8 {
                let mut broken = file.clone();
                broken[position] ^= 1 << bit;
                try_all(&broken, name);
            }
        }
    }
}

#[test]
fn bytes_set_to_extremes_do_no_harm() {
    for (name, file) in files() {
        for position in 0..file.len().saturating_sub(4) {
            for word in [0_u32, u32::MAX, 0x7fff_ffff, 0x8000_0000] {
                let mut broken = file.clone();
                broken[position..position + 4].copy_from_slice(&word.to_le_bytes());
                try_all(&broken, name);
            }
        }
    }
}

#[test]
fn damaged_exr_of_every_compression_does_no_harm() {
    for compression in super::exr::LOSSY_AND_LOSSLESS {
        for file in super::exr::variants(compression) {
            // Most of the file is pixels: a sample of them is enough.
            let positions = (0..400.min(file.len())).chain((400..file.len()).step_by(23));
            for position in positions {
                let mut broken = file.clone();
                broken[position] ^= 1 << (position % 8);
                try_all(&broken, "");
                broken[position] = !broken[position];
                try_all(&broken, "");
            }
            for length in (0..file.len()).step_by(37) {
                assert!(read(&file[..length], "").is_err(), "{compression:?} cut to {length}");
            }
        }
    }
}

/// The decoder would allocate what these sizes say, and failing to do so would abort the process.
#[test]
fn dwa_blocks_may_not_claim_more_than_their_pixels_need() {
    let [file, _] = super::exr::variants(exr::prelude::Compression::DWAA(None));
    // The table of offsets has one entry, which points behind itself to the block: y, length, sizes.
    let word = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().unwrap());
    let table = (0..file.len() - 8).find(|&at| word(at) == at as u64 + 8).unwrap();
    let sizes = table + 8 + 8;
    assert!(read(&file, "").is_ok());
    for place in [1, 6, 7, 8, 9] {
        let mut broken = file.clone();
        broken[sizes + 8 * place + 5] = 0x7f;
        let error = read(&broken, "").unwrap_err().to_string();
        assert_eq!(error, "not a valid EXR file: a block claims more than its pixels can need", "{place}");
    }
}

#[test]
fn garbage_is_no_image() {
    let mut state = 1_u32;
    let garbage: Vec<u8> = (0..4096)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        })
        .collect();
    for name in ["a.png", "a.exr", "a.hdr", "a.pfm", "a.ppm", "a.jpg", "a.tga", "a", ""] {
        assert!(read(&garbage, name).is_err());
        assert!(read(&[], name).is_err());
        assert!(probe(&[], name).is_err());
    }
    for (_, file) in files() {
        let mixed = [&file[..12.min(file.len())], &garbage].concat();
        try_all(&mixed, "a.tga");
    }
}

#[test]
fn absurd_sizes_are_refused_before_they_are_allocated() {
    let mut png = Vec::new();
    png::Encoder::new(&mut png, 100_000, 100_000)
        .write_header()
        .unwrap()
        .write_chunk(png::chunk::IDAT, &[])
        .unwrap();
    let mut tga = vec![0; 18];
    tga[2] = 2;
    tga[12..16].fill(0xff);
    tga[16] = 24;
    let mut exr = light_image(9, 4, 3).encode(Format::Exr, &EncodeOptions::default()).unwrap();
    let value = |file: &[u8], key: &[u8]| {
        file.windows(key.len()).position(|bytes| bytes == key).unwrap() + key.len() + 4
    };
    let window = value(&exr, b"dataWindow\0box2i\0");
    exr[window + 8..window + 12].copy_from_slice(&99_999_i32.to_le_bytes());
    exr[window + 12..window + 16].copy_from_slice(&99_999_i32.to_le_bytes());
    let chunks = value(&exr, b"chunkCount\0int\0");
    exr[chunks..chunks + 4].copy_from_slice(&6250_i32.to_le_bytes());
    let jpeg = {
        let mut jpeg = files().into_iter().find(|(name, _)| *name == "a.jpg").unwrap().1;
        let frame = jpeg.windows(2).position(|marker| marker == [0xff, 0xc0]).unwrap();
        jpeg[frame + 5..frame + 9].copy_from_slice(&[0xff, 0xdc, 0xff, 0xdc]);
        jpeg
    };
    let claims: [(&str, &[u8]); 7] = [
        ("a.png", &png),
        ("a.tga", &tga),
        ("a.exr", &exr),
        ("a.jpg", &jpeg),
        ("a.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 90000 +X 90000\n\x02\x02\x00\x01"),
        ("a.pfm", b"PF\n90000 90000\n-1.0\n1234"),
        ("a.ppm", b"P6\n90000 90000\n255\n1234"),
    ];
    for (name, file) in claims {
        let error = read(file, name).unwrap_err();
        let is_size = matches!(error, ImageError::TooLarge { .. });
        assert!(is_size, "{name}: {error}");
        assert!(read_layers(file, name).is_err());
    }
}
