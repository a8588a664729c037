//! What a header may claim.
//!
//! A file of a few bytes can claim a picture of many gigabytes. No compression that these formats know gains more than
//! a factor of about a thousand (deflate: 1032), so a claim far beyond the size of the file is refused before anything
//! is allocated.

use crate::{Format, ImageError};

/// Most pixels along a side.
const MAX_SIDE: u64 = 1 << 17;
/// Most decoded bytes.
const MAX_BYTES: u64 = 1 << 32;
/// Decoded bytes a byte of the file may stand for.
const MAX_RATIO: u64 = 2048;
/// Decoded bytes that are always allowed: some formats describe a flat picture in next to nothing.
const ALWAYS_ALLOWED: u64 = 1 << 24;

/// Accepts or refuses a picture of `width × height` pixels that take `pixel_bytes` bytes each when decoded, in a file of
/// `file_bytes` bytes.
///
/// # Errors
/// [`ImageError::TooLarge`], or [`ImageError::Malformed`] if a side is 0.
pub(super) fn check(
    format: Format,
    [width, height]: [u64; 2],
    pixel_bytes: u64,
    file_bytes: usize,
) -> Result<(), ImageError> {
    if width == 0 || height == 0 {
        return Err(ImageError::malformed(format, format!("the picture is empty ({width}x{height} pixels)")));
    }
    let bytes =
        width.checked_mul(height).and_then(|count| count.checked_mul(pixel_bytes)).unwrap_or(u64::MAX);
    let plausible = plausible_bytes(file_bytes);
    let reason = if width > MAX_SIDE || height > MAX_SIDE {
        format!("but at most {MAX_SIDE} a side are accepted")
    } else if bytes > MAX_BYTES {
        format!("but at most {MAX_BYTES} bytes are accepted")
    } else if bytes > plausible {
        format!("which a file of {file_bytes} bytes can't hold")
    } else {
        return Ok(());
    };
    Err(ImageError::TooLarge { format, width, height, pixel_bytes, reason })
}

/// Decoded bytes that a file of `file_bytes` bytes is trusted to hold, at most.
pub(super) fn plausible_bytes(file_bytes: usize) -> u64 {
    ALWAYS_ALLOWED.max((file_bytes as u64).saturating_mul(MAX_RATIO)).min(MAX_BYTES)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absurd_claims_are_refused() {
        let check = |width, height, file_bytes| check(Format::Png, [width, height], 4, file_bytes);
        assert!(check(100, 100, 60).is_ok());
        assert!(check(8192, 8192, 1 << 20).is_ok());
        assert!(check(0, 5, 100).is_err());
        assert!(check(1 << 18, 1, 1 << 20).is_err());
        assert!(check(1 << 17, 1 << 17, 1 << 30).is_err());
        assert!(check(u64::MAX, u64::MAX, usize::MAX).is_err());
        let error = check(20_000, 20_000, 100).unwrap_err().to_string();
        assert_eq!(
            error,
            "PNG: the header claims 20000x20000 pixels of 4 bytes, which a file of 100 bytes can't hold"
        );
    }
}
