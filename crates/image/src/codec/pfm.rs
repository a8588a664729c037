//! Portable float maps: `PF` (RGB) or `Pf` (one channel), width, height and scale in ASCII, then rows of floats from the
//! bottom. The sign of the scale tells the byte order (negative: little-endian); its size multiplies the values.
//!
//! Source: Debevec, the format's description with HDR Shop, 2001.

use super::{Format, ImageInfo, display, limits};
use crate::{Encoding, Image, ImageError, Pixels};

/// What a header says.
struct Header {
    width: usize,
    height: usize,
    channels: usize,
    scale: f32,
    /// Where the pixels begin.
    start: usize,
}

pub(super) fn probe(bytes: &[u8]) -> Result<ImageInfo, ImageError> {
    let Header { width, height, channels, .. } = header(bytes)?;
    Ok(ImageInfo { format: Format::Pfm, width, height, channels, bits: 32, encoding: Encoding::Linear })
}

pub(super) fn read(bytes: &[u8]) -> Result<Image, ImageError> {
    let Header { width, height, channels, scale, start } = header(bytes)?;
    let row_bytes = width * channels * 4;
    let Some(data) = bytes.get(start..start + row_bytes * height) else {
        return Err(ImageError::malformed(Format::Pfm, "the pixels end early"));
    };
    let decode: fn([u8; 4]) -> f32 = if scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes };
    let factor = scale.abs();
    let rows = data.chunks_exact(row_bytes).rev();
    let values = rows.flat_map(|row| row.as_chunks::<4>().0).map(|&value| decode(value));
    // Multiplying by one would still quieten NaN payloads; leave the bits alone.
    let values = if factor == 1.0 { values.collect() } else { values.map(|value| value * factor).collect() };
    Image::new(width, height, channels, Pixels::F32(values))
}

pub(super) fn write(image: &Image) -> Result<Vec<u8>, ImageError> {
    let light = display::over_black(image)?;
    let kind = if light.channels == 1 { "Pf" } else { "PF" };
    let mut bytes = format!("{kind}\n{} {}\n-1.0\n", light.width, light.height).into_bytes();
    if let Pixels::F32(values) = &light.pixels {
        let row = (light.width * light.channels).max(1);
        for value in values.chunks_exact(row).rev().flatten() {
            bytes.extend(value.to_le_bytes());
        }
    }
    Ok(bytes)
}

/// Reads and checks the header.
fn header(bytes: &[u8]) -> Result<Header, ImageError> {
    let malformed = |message: &str| ImageError::malformed(Format::Pfm, message);
    let channels = if bytes.starts_with(b"PF") { 3 } else { 1 };
    let mut position = 2;
    let mut next = || word(bytes, &mut position).ok_or_else(|| malformed("the header is broken"));
    let (width, height, scale) = (next()?, next()?, next()?);
    let size = |text: &str| text.parse::<u64>().map_err(|_| malformed("a side is not a number"));
    let (width, height) = (size(width)?, size(height)?);
    let scale = scale.parse::<f32>().ok().filter(|scale| *scale != 0.0 && scale.is_finite());
    let scale = scale.ok_or_else(|| malformed("the scale is not a number other than 0"))?;
    limits::check(Format::Pfm, [width, height], channels as u64 * 4, bytes.len())?;
    Ok(Header { width: width as usize, height: height as usize, channels, scale, start: position })
}

/// The next word after white space, and the one white space that ends it.
fn word<'a>(bytes: &'a [u8], position: &mut usize) -> Option<&'a str> {
    // Longer words are not numbers; the limit keeps binary garbage from being searched to its end.
    const LONGEST: usize = 64;
    let start = *position + bytes.get(*position..)?.iter().position(|byte| !byte.is_ascii_whitespace())?;
    let length = bytes[start..].iter().take(LONGEST).position(u8::is_ascii_whitespace)?;
    *position = start + length + 1;
    std::str::from_utf8(&bytes[start..start + length]).ok()
}
