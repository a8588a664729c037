//! Which format a file has.

use std::fmt;
use std::path::Path;

use crate::ImageError;

/// A format of image files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Portable Network Graphics, 8 or 16 bits, lossless.
    Png,
    /// OpenEXR: floats, layers, metadata.
    Exr,
    /// Radiance RGBE: a shared exponent of 8 bits.
    Hdr,
    /// Portable float map.
    Pfm,
    /// Portable pixmap, binary (P6).
    Ppm,
    /// JPEG; only read.
    Jpeg,
    /// Truevision TGA; only read.
    Tga,
}

/// Extensions in lower case and what they stand for.
const EXTENSIONS: [(&str, Format); 10] = [
    ("png", Format::Png),
    ("exr", Format::Exr),
    ("hdr", Format::Hdr),
    ("pic", Format::Hdr),
    ("rgbe", Format::Hdr),
    ("pfm", Format::Pfm),
    ("ppm", Format::Ppm),
    ("jpg", Format::Jpeg),
    ("jpeg", Format::Jpeg),
    ("tga", Format::Tga),
];

/// First bytes and what they stand for. TGA has none.
const SIGNATURES: [(&[u8], Format); 7] = [
    (b"\x89PNG\r\n\x1a\n", Format::Png),
    (b"\x76\x2f\x31\x01", Format::Exr),
    (b"#?", Format::Hdr),
    (b"PF", Format::Pfm),
    (b"Pf", Format::Pfm),
    (b"P6", Format::Ppm),
    (b"\xff\xd8\xff", Format::Jpeg),
];

impl Format {
    /// The format that the extension of `path` names, in any case.
    pub fn from_path(path: &Path) -> Option<Format> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        EXTENSIONS.iter().find(|(name, _)| *name == extension).map(|&(_, format)| format)
    }

    /// The format of `bytes` by their signature; only where there is none, by the extension of `name_hint`.
    ///
    /// # Errors
    /// [`ImageError::UnknownFormat`] if there is no signature and the extension is not that of TGA. Bytes without the
    /// signature of the format that the extension names are [`ImageError::Malformed`].
    pub fn detect(bytes: &[u8], name_hint: &str) -> Result<Format, ImageError> {
        if let Some((_, format)) = SIGNATURES.iter().find(|(signature, _)| bytes.starts_with(signature)) {
            return Ok(*format);
        }
        match Format::from_path(Path::new(name_hint)) {
            Some(Format::Tga) => Ok(Format::Tga),
            Some(format) => Err(ImageError::malformed(format, "it does not begin as one")),
            None => Err(ImageError::UnknownFormat { name: name_hint.to_string() }),
        }
    }

    /// Whether [`crate::encode`] can write it.
    pub const fn can_write(self) -> bool {
        !matches!(self, Format::Jpeg | Format::Tga)
    }
}

impl fmt::Display for Format {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Format::Png => "PNG",
            Format::Exr => "EXR",
            Format::Hdr => "HDR",
            Format::Pfm => "PFM",
            Format::Ppm => "PPM",
            Format::Jpeg => "JPEG",
            Format::Tga => "TGA",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extensions_in_any_case_name_formats() {
        assert_eq!(Format::from_path(Path::new("a/b.c.EXR")), Some(Format::Exr));
        assert_eq!(Format::from_path(Path::new("x.jpeg")), Some(Format::Jpeg));
        assert_eq!(Format::from_path(Path::new("exr")), None);
        assert_eq!(Format::from_path(Path::new("x.gif")), None);
    }

    #[test]
    fn signatures_outweigh_names() {
        assert_eq!(Format::detect(b"P6 1 1 255\n...", "a.png"), Ok(Format::Ppm));
        assert_eq!(Format::detect(b"....", "a.tga"), Ok(Format::Tga));
        let error = Format::detect(b"GIF89a", "a.png").unwrap_err();
        assert_eq!(error.to_string(), "not a valid PNG file: it does not begin as one");
        assert!(matches!(Format::detect(b"GIF89a", "a.gif"), Err(ImageError::UnknownFormat { .. })));
    }
}
