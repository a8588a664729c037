//! JPEG and TGA, by the `image` crate: formats that are only read.
//!
//! Values are taken to be sRGB-encoded. Neither ICC profiles nor the orientation in EXIF data are used: textures and
//! their coordinates are made against the stored pixels.

use std::io::Cursor;

use image::codecs::jpeg::JpegDecoder;
use image::codecs::tga::TgaDecoder;
use image::{DynamicImage, ImageDecoder, ImageResult, Limits};

use super::{Format, ImageInfo, limits};
use crate::{Encoding, Image, ImageError, Pixels};

pub(super) fn probe(bytes: &[u8], format: Format) -> Result<ImageInfo, ImageError> {
    let decoder = decoder(bytes, format)?;
    let ((width, height), color) = (decoder.dimensions(), decoder.color_type());
    Ok(ImageInfo {
        format,
        width: width as usize,
        height: height as usize,
        channels: usize::from(color.channel_count()),
        bits: u32::from(color.bits_per_pixel()) / u32::from(color.channel_count()),
        encoding: Encoding::Srgb,
    })
}

pub(super) fn read(bytes: &[u8], format: Format) -> Result<Image, ImageError> {
    let decoder = decoder(bytes, format)?;
    if format == Format::Jpeg && !has_end(bytes) {
        return Err(ImageError::malformed(format, "the pixels end early"));
    }
    let image = decode(decoder).map_err(|error| ImageError::malformed(format, error))?;
    let (width, height) = (image.width() as usize, image.height() as usize);
    let (channels, values) = match image {
        DynamicImage::ImageLuma8(image) => (1, image.into_raw()),
        DynamicImage::ImageLumaA8(image) => (2, image.into_raw()),
        DynamicImage::ImageRgb8(image) => (3, image.into_raw()),
        other => (4, other.into_rgba8().into_raw()),
    };
    Ok(Image::new(width, height, channels, Pixels::U8(values))?.with_encoding(Encoding::Srgb))
}

fn decode(mut decoder: Box<dyn ImageDecoder + '_>) -> ImageResult<DynamicImage> {
    // The size is checked already; this bounds what the decoder keeps beside the pixels.
    let mut bounds = Limits::no_limits();
    bounds.max_alloc = Some(decoder.total_bytes().saturating_mul(8).saturating_add(64 << 20));
    decoder.set_limits(bounds)?;
    DynamicImage::from_decoder(decoder)
}

/// Reads and checks the header.
fn decoder(bytes: &[u8], format: Format) -> Result<Box<dyn ImageDecoder + '_>, ImageError> {
    let cursor = Cursor::new(bytes);
    let decoder: ImageResult<Box<dyn ImageDecoder>> = match format {
        Format::Jpeg => JpegDecoder::new(cursor).map(|decoder| Box::new(decoder) as _),
        _ => TgaDecoder::new(cursor).map(|decoder| Box::new(decoder) as _),
    };
    let decoder = decoder.map_err(|error| ImageError::malformed(format, error))?;
    let (width, height) = decoder.dimensions();
    limits::check(format, [u64::from(width), u64::from(height)], 4, bytes.len())?;
    Ok(decoder)
}

/// Whether a JPEG's last scan is followed by the end marker. The decoder fills what is missing with grey and says
/// nothing. Neither marker can occur within the coded pixels, where 0xFF is followed by 0.
fn has_end(bytes: &[u8]) -> bool {
    let last = |marker: u8| bytes.windows(2).rposition(|pair| pair == [0xff, marker]);
    match (last(0xda), last(0xd9)) {
        (Some(scan), Some(end)) => end > scan,
        _ => false,
    }
}
