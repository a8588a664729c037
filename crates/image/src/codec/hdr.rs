//! Radiance RGBE, by the `image` crate.
//!
//! The `EXPOSURE` and `COLORCORR` lines are undone, so that values are the radiance of the scene. XYZE files and
//! pictures that are not stored row by row from the top left are refused.

use std::io::Cursor;

use image::codecs::hdr::{HdrDecoder, HdrEncoder, HdrMetadata};
use image::{ImageDecoder, Rgb};

use super::{Format, ImageInfo, display, limits};
use crate::{ColorSpace, Encoding, Image, ImageError};

pub(super) fn probe(bytes: &[u8]) -> Result<ImageInfo, ImageError> {
    let (_, metadata) = decoder(bytes)?;
    let (width, height) = (metadata.width as usize, metadata.height as usize);
    Ok(ImageInfo { format: Format::Hdr, width, height, channels: 3, bits: 8, encoding: Encoding::Linear })
}

pub(super) fn read(bytes: &[u8]) -> Result<Image, ImageError> {
    let (decoder, metadata) = decoder(bytes)?;
    let (width, height) = (metadata.width as usize, metadata.height as usize);
    let mut buffer = vec![0; width * height * 12];
    decoder.read_image(&mut buffer).map_err(|error| ImageError::malformed(Format::Hdr, error))?;
    let mut values: Vec<f32> = buffer.as_chunks::<4>().0.iter().map(|&v| f32::from_ne_bytes(v)).collect();
    undo_exposure(&mut values, &metadata);
    Image::rgb_f32(width, height, values)
}

pub(super) fn write(image: &Image) -> Result<Vec<u8>, ImageError> {
    // A shared exponent has neither sign nor NaN; the largest finite value is close below 2^127.
    let representable = |value: f32| if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.7e38) };
    let colors = display::over_black(image)?.to_rgb(ColorSpace::Srgb);
    let pixels: Vec<Rgb<f32>> = colors.into_iter().map(|color| Rgb(color.map(representable))).collect();
    let mut bytes = Vec::new();
    let encoder = HdrEncoder::new(&mut bytes);
    let result = encoder.encode(&pixels, image.width, image.height);
    result.map_err(|error| ImageError::encode(Format::Hdr, error))?;
    Ok(bytes)
}

type Decoder<'a> = HdrDecoder<Cursor<&'a [u8]>>;

/// Reads and checks the header.
fn decoder(bytes: &[u8]) -> Result<(Decoder<'_>, HdrMetadata), ImageError> {
    // The strict decoder refuses the signature `#?RGBE` and stray lines, both of which are common.
    let decoder = HdrDecoder::new_nonstrict(Cursor::new(bytes));
    let decoder = decoder.map_err(|error| ImageError::malformed(Format::Hdr, error))?;
    let metadata = decoder.metadata();
    let size = [u64::from(metadata.width), u64::from(metadata.height)];
    limits::check(Format::Hdr, size, 12, bytes.len())?;
    Ok((decoder, metadata))
}

/// Divides by what the writing program multiplied with.
fn undo_exposure(values: &mut [f32], metadata: &HdrMetadata) {
    let exposure = metadata.exposure.unwrap_or(1.0);
    let (red, green, blue) = metadata.color_correction.unwrap_or((1.0, 1.0, 1.0));
    let usable = |factor: f32| if factor.is_normal() && factor > 0.0 { factor } else { 1.0 };
    let divisors = [red, green, blue].map(|correction| usable(exposure * correction));
    if divisors != [1.0; 3] {
        for pixel in values.as_chunks_mut::<3>().0 {
            pixel.iter_mut().zip(divisors).for_each(|(value, divisor)| *value /= divisor);
        }
    }
}
