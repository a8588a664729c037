//! Tests of all codecs: what was written is read again, known bytes give known values, and broken bytes give errors.

mod exr;
mod hostile;
mod round_trip;

use crate::{Encoding, Image, Pixels};

/// Bytes that differ from pixel to pixel and channel to channel.
fn byte_image(width: usize, height: usize, channels: usize) -> Image {
    let values = (0..width * height * channels).map(|index| (index * 37 % 256) as u8);
    Image::new(width, height, channels, Pixels::U8(values.collect())).unwrap().with_encoding(Encoding::Srgb)
}

/// Light from dim to bright, with negative values.
fn light_image(width: usize, height: usize, channels: usize) -> Image {
    let value = |index: usize| (index as f32 * 0.7).sin() * 1.5_f32.powi(index as i32 % 20 - 10);
    let values = (0..width * height * channels).map(value).collect();
    Image::new(width, height, channels, Pixels::F32(values)).unwrap()
}

/// The floats of an image.
fn floats(image: &Image) -> &[f32] {
    match &image.pixels {
        Pixels::F32(values) => values,
        Pixels::U8(_) => panic!("expected floats"),
    }
}

/// The bytes of an image.
fn bytes(image: &Image) -> &[u8] {
    match &image.pixels {
        Pixels::U8(values) => values,
        Pixels::F32(_) => panic!("expected bytes"),
    }
}
