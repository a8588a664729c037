//! Image files: bytes to pixels and back.
//!
//! Every reader checks the claimed size ([`limits`]) before it allocates, and gives an error for bytes that are broken
//! or end early. One file a format; what they share is here.

mod display;
mod exr;
mod format;
mod hdr;
mod limits;
mod pfm;
mod png;
mod ppm;
mod raster;
#[cfg(test)]
mod tests;

pub use self::exr::Precision;
pub use self::format::Format;
pub use self::png::BitDepth;

use crate::{Encoding, Image, ImageError, Layer, Picture, ToneMap};

/// What a file claims to hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageInfo {
    /// Format of the file.
    pub format: Format,
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Channels a pixel as [`read`] would give them; for EXR all channels of all parts.
    pub channels: usize,
    /// Bits a channel in the file.
    pub bits: u32,
    /// What the stored values mean.
    pub encoding: Encoding,
}

/// Settings of [`encode`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EncodeOptions {
    /// How light becomes 8 or 16 bits: PNG and PPM.
    pub tone_map: ToneMap,
    /// Bits a channel in PNG.
    pub bit_depth: BitDepth,
    /// Width of the floats of EXR's colours.
    pub precision: Precision,
}

/// Decodes the beauty of an image file.
///
/// `name_hint` is the file's name; it matters only for TGA, which has no signature. 8-bit values stay as they are, with
/// [`Image::encoding`] telling what they mean; so do the values of 16-bit files, as floats in 0 to 1. EXR, HDR and PFM
/// give linear floats. Of EXR, see [`Picture::beauty`] for what is chosen; alpha is kept.
///
/// # Errors
/// [`ImageError::UnknownFormat`], [`ImageError::Unsupported`], [`ImageError::Malformed`] or [`ImageError::TooLarge`].
pub fn read(bytes: &[u8], name_hint: &str) -> Result<Image, ImageError> {
    let picture = read_layers(bytes, name_hint)?;
    match picture.into_beauty() {
        Some(layer) => Ok(layer.image),
        None => Err(ImageError::malformed(Format::Exr, "it has no channels")),
    }
}

/// Decodes all layers of an image file; only EXR has more than the beauty. Arguments and errors as [`read`].
pub fn read_layers(bytes: &[u8], name_hint: &str) -> Result<Picture, ImageError> {
    let image = match Format::detect(bytes, name_hint)? {
        Format::Exr => return exr::read(bytes),
        Format::Png => png::read(bytes)?,
        Format::Hdr => hdr::read(bytes)?,
        Format::Pfm => pfm::read(bytes)?,
        Format::Ppm => ppm::read(bytes)?,
        format @ (Format::Jpeg | Format::Tga) => raster::read(bytes, format)?,
    };
    Ok(Picture::from_image(image))
}

/// What a file claims to hold, from its header alone. Arguments and errors as [`read`].
pub fn probe(bytes: &[u8], name_hint: &str) -> Result<ImageInfo, ImageError> {
    match Format::detect(bytes, name_hint)? {
        Format::Png => png::probe(bytes),
        Format::Exr => exr::probe(bytes),
        Format::Hdr => hdr::probe(bytes),
        Format::Pfm => pfm::probe(bytes),
        Format::Ppm => ppm::probe(bytes),
        format @ (Format::Jpeg | Format::Tga) => raster::probe(bytes, format),
    }
}

/// The bytes of a file that holds `picture`.
///
/// EXR gets every layer and the metadata; the other formats get the beauty ([`Picture::beauty`]). PNG and PPM are tone
/// mapped if the picture is linear, else their values are kept. Formats that can't name their primaries are written
/// with those of sRGB. PPM, HDR and PFM have no alpha: what remains of associated colours is the picture over black.
///
/// # Errors
/// [`ImageError::Encode`]: there is no layer, layers differ in size, two channels have the same name, or the format is
/// one of those that are only read (JPEG, TGA).
pub fn encode(picture: &Picture, format: Format, options: &EncodeOptions) -> Result<Vec<u8>, ImageError> {
    let beauty = picture.beauty().ok_or_else(|| ImageError::encode(format, "the picture has no layer"))?;
    match format {
        Format::Png => png::write(&beauty.image, options),
        Format::Exr => exr::write(picture, options.precision),
        Format::Hdr => hdr::write(&beauty.image),
        Format::Pfm => pfm::write(&beauty.image),
        Format::Ppm => ppm::write(&beauty.image, options),
        Format::Jpeg | Format::Tga => Err(ImageError::encode(format, "this format can only be read")),
    }
}

impl Image {
    /// The bytes of a file that holds this image alone: [`encode`] of [`Picture::from_image`]. Errors as there.
    pub fn encode(&self, format: Format, options: &EncodeOptions) -> Result<Vec<u8>, ImageError> {
        let picture = Picture { layers: vec![Layer::beauty(self.clone())], ..Picture::default() };
        encode(&picture, format, options)
    }
}
