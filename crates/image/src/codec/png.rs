//! PNG, by the `png` crate.
//!
//! The colour of a file is what its `sRGB` chunk says, else its `gAMA` chunk, else sRGB. `cHRM`, `iCCP` and `cICP` are
//! not used: the primaries are taken to be those of sRGB. Of an animation, the first frame is read.

use std::io::Cursor;

use png::{ColorType, Decoder, Encoder, Info, Limits, SrgbRenderingIntent, Transformations};

use super::{EncodeOptions, Format, ImageInfo, display, limits};
use crate::{Encoding, Image, ImageError, Pixels};

/// Bits a channel of a PNG file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BitDepth {
    /// 256 steps.
    #[default]
    Eight,
    /// 65536 steps.
    Sixteen,
}

/// Bytes that the decoder may allocate beside the pixels: text, profiles.
const DECODER_BYTES: usize = 64 << 20;

pub(super) fn probe(bytes: &[u8]) -> Result<ImageInfo, ImageError> {
    let mut decoder = decoder(bytes);
    let info = decoder.read_header_info().map_err(malformed)?;
    let (width, height, bits) = (info.width as usize, info.height as usize, info.bit_depth as u32);
    let reader = checked(decoder, bytes)?;
    let channels = reader.output_color_type().0.samples();
    let encoding = encoding(reader.info());
    Ok(ImageInfo { format: Format::Png, width, height, channels, bits, encoding })
}

pub(super) fn read(bytes: &[u8]) -> Result<Image, ImageError> {
    let mut reader = checked(decoder(bytes), bytes)?;
    let encoding = encoding(reader.info());
    let too_large = || ImageError::malformed(Format::Png, "its size overflows");
    let mut buffer = vec![0; reader.output_buffer_size().ok_or_else(too_large)?];
    let frame = reader.next_frame(&mut buffer).map_err(malformed)?;
    // Reading on to the end finds files that were cut off after the pixels.
    reader.finish().map_err(malformed)?;
    buffer.truncate(frame.buffer_size());
    let pixels = match frame.bit_depth {
        png::BitDepth::Sixteen => {
            let words = buffer.as_chunks::<2>().0.iter();
            Pixels::F32(words.map(|&word| f32::from(u16::from_be_bytes(word)) / 65535.0).collect())
        }
        _ => Pixels::U8(buffer),
    };
    let (width, height) = (frame.width as usize, frame.height as usize);
    Ok(Image::new(width, height, frame.color_type.samples(), pixels)?.with_encoding(encoding))
}

pub(super) fn write(image: &Image, options: &EncodeOptions) -> Result<Vec<u8>, ImageError> {
    let side =
        |size: usize| u32::try_from(size).map_err(|_| ImageError::encode(Format::Png, "it is too large"));
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, side(image.width)?, side(image.height)?);
    encoder.set_color(match image.channels {
        1 => ColorType::Grayscale,
        2 => ColorType::GrayscaleAlpha,
        3 => ColorType::Rgb,
        _ => ColorType::Rgba,
    });
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    let data = match options.bit_depth {
        BitDepth::Eight => {
            encoder.set_depth(png::BitDepth::Eight);
            options.tone_map.display_bytes(image)
        }
        BitDepth::Sixteen => {
            encoder.set_depth(png::BitDepth::Sixteen);
            display::words(image, &options.tone_map)
        }
    };
    let encode_error = |error| ImageError::encode(Format::Png, error);
    let mut writer = encoder.write_header().map_err(encode_error)?;
    writer.write_image_data(&data).map_err(encode_error)?;
    writer.finish().map_err(encode_error)?;
    Ok(bytes)
}

/// A decoder that expands palettes, transparent colours and less than 8 bits.
fn decoder(bytes: &[u8]) -> Decoder<Cursor<&[u8]>> {
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: DECODER_BYTES });
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder
}

/// Reads up to the pixels, after checking the size.
fn checked<'a>(
    mut decoder: Decoder<Cursor<&'a [u8]>>,
    bytes: &[u8],
) -> Result<png::Reader<Cursor<&'a [u8]>>, ImageError> {
    let info = decoder.read_header_info().map_err(malformed)?;
    // 16-bit files become floats; four channels cover palettes with transparency.
    let pixel_bytes = if info.bit_depth == png::BitDepth::Sixteen { 16 } else { 4 };
    let size = [u64::from(info.width), u64::from(info.height)];
    limits::check(Format::Png, size, pixel_bytes, bytes.len())?;
    // The limit of the `png` crate covers a row of pixels, and rows of accepted pictures can be longer.
    let row = size[0] as usize * pixel_bytes as usize;
    decoder.set_limits(Limits { bytes: DECODER_BYTES + 4 * row });
    decoder.read_info().map_err(malformed)
}

/// What the chunks say about the values.
fn encoding(info: &Info<'_>) -> Encoding {
    // Encoders write 1/2.2 where they mean sRGB.
    const SRGB_LIKE: std::ops::RangeInclusive<f32> = 0.45..=0.46;
    match (info.srgb, info.gama_chunk.map(png::ScaledFloat::into_value)) {
        (Some(_), _) | (None, None) => Encoding::Srgb,
        (None, Some(gamma)) if SRGB_LIKE.contains(&gamma) || gamma <= 0.0 => Encoding::Srgb,
        (None, Some(1.0)) => Encoding::Linear,
        (None, Some(gamma)) => Encoding::Gamma(1.0 / gamma),
    }
}

fn malformed(error: png::DecodingError) -> ImageError {
    ImageError::malformed(Format::Png, error)
}
