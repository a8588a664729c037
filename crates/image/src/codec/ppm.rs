//! Portable pixmaps: `P6`, width, height and largest value in ASCII, then rows of red, green, blue from the top.
//!
//! Values are taken to be sRGB-encoded, as every program does; the specification asks for BT.709's curve.
//! Source: the manual page `ppm(5)` of Netpbm.

use super::{EncodeOptions, Format, ImageInfo, display, limits};
use crate::{Encoding, Image, ImageError, Pixels, ToneMap};

/// What a header says.
struct Header {
    width: usize,
    height: usize,
    /// The value of white, 1 to 65535.
    largest: u16,
    /// Where the pixels begin.
    start: usize,
}

pub(super) fn probe(bytes: &[u8]) -> Result<ImageInfo, ImageError> {
    let Header { width, height, largest, .. } = header(bytes)?;
    let bits = if largest > 255 { 16 } else { 8 };
    Ok(ImageInfo { format: Format::Ppm, width, height, channels: 3, bits, encoding: Encoding::Srgb })
}

pub(super) fn read(bytes: &[u8]) -> Result<Image, ImageError> {
    let Header { width, height, largest, start } = header(bytes)?;
    let count = width * height * 3;
    let value_bytes = if largest > 255 { 2 } else { 1 };
    let Some(data) = bytes.get(start..start + count * value_bytes) else {
        return Err(ImageError::malformed(Format::Ppm, "the pixels end early"));
    };
    let pixels = match largest {
        255 => Pixels::U8(data.to_vec()),
        0..=254 => Pixels::F32(data.iter().map(|&byte| f32::from(byte) / f32::from(largest)).collect()),
        _ => {
            let words = data.as_chunks::<2>().0.iter();
            Pixels::F32(words.map(|&word| f32::from(u16::from_be_bytes(word)) / f32::from(largest)).collect())
        }
    };
    Ok(Image::new(width, height, 3, pixels)?.with_encoding(Encoding::Srgb))
}

pub(super) fn write(image: &Image, options: &EncodeOptions) -> Result<Vec<u8>, ImageError> {
    let shown = if image.has_alpha() {
        // What was made for a display is multiplied by alpha as light, but not tone mapped.
        let is_light = image.encoding == Encoding::Linear;
        let tone_map = if is_light { options.tone_map } else { ToneMap::default() };
        tone_map.display_bytes(&display::over_black(image)?)
    } else {
        options.tone_map.display_bytes(image)
    };
    let mut bytes = format!("P6\n{} {}\n255\n", image.width, image.height).into_bytes();
    if image.color_channels() == 1 {
        bytes.extend(shown.iter().flat_map(|&value| [value; 3]));
    } else {
        bytes.extend(shown);
    }
    Ok(bytes)
}

/// Reads and checks the header.
fn header(bytes: &[u8]) -> Result<Header, ImageError> {
    let malformed = |message: &str| ImageError::malformed(Format::Ppm, message);
    let mut position = 2;
    let mut next = || number(bytes, &mut position).ok_or_else(|| malformed("the header is broken"));
    let (width, height, largest) = (next()?, next()?, next()?);
    let largest = u16::try_from(largest).ok().filter(|&value| value > 0);
    let largest = largest.ok_or_else(|| malformed("the largest value is not in 1 to 65535"))?;
    limits::check(Format::Ppm, [width, height], 12, bytes.len())?;
    // One white space follows the last number.
    Ok(Header { width: width as usize, height: height as usize, largest, start: position + 1 })
}

/// The next number, after white space and comments.
fn number(bytes: &[u8], position: &mut usize) -> Option<u64> {
    loop {
        match bytes.get(*position)? {
            b'#' => *position += bytes[*position..].iter().position(|&byte| byte == b'\n')? + 1,
            byte if byte.is_ascii_whitespace() => *position += 1,
            _ => break,
        }
    }
    let digits = bytes[*position..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let text = std::str::from_utf8(&bytes[*position..*position + digits]).ok()?;
    *position += digits;
    bytes.get(*position).filter(|byte| byte.is_ascii_whitespace())?;
    text.parse().ok()
}
