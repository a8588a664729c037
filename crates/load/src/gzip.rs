//! Transparent decompression of `.gz` files.
//!
//! The input may be hostile: a few kilobytes can stand for gigabytes. What a file may expand to is therefore limited by
//! its own size.

use std::io::Read;

use flate2::read::MultiGzDecoder;

/// What any file may expand to, in bytes, however small it is.
const FREE_EXPANSION: u64 = 16 << 20;
/// What a file may expand to in multiples of its own size, beyond [`FREE_EXPANSION`].
///
/// Meshes and scenes as text compress 3 to 20 times; deflate itself ends at 1032 times.
const EXPANSION_RATIO: u64 = 64;

/// Why a file could not be decompressed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum GzipError {
    /// The stream is damaged or cut short.
    #[error("damaged gzip data: {0}")]
    Damaged(std::io::Error),
    /// The stream expands beyond reason.
    #[error("gzip data of {compressed} bytes that expands to more than {limit} bytes is refused")]
    Expansion {
        /// Bytes of the file.
        compressed: usize,
        /// Bytes it may expand to.
        limit: u64,
    },
}

/// Whether `bytes` start like a gzip file.
pub(crate) fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b])
}

/// The decompressed contents of a gzip file; any other file as it is.
///
/// # Errors
/// [`GzipError`] if the stream is damaged, or expands to more than 16 MiB plus 64 times its size.
pub(crate) fn decompress(bytes: Vec<u8>) -> Result<Vec<u8>, GzipError> {
    if !is_gzip(&bytes) {
        return Ok(bytes);
    }
    let limit = FREE_EXPANSION + EXPANSION_RATIO * bytes.len() as u64;
    let mut contents = Vec::new();
    MultiGzDecoder::new(bytes.as_slice())
        .take(limit + 1)
        .read_to_end(&mut contents)
        .map_err(GzipError::Damaged)?;
    if contents.len() as u64 > limit {
        return Err(GzipError::Expansion { compressed: bytes.len(), limit });
    }
    Ok(contents)
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use flate2::Compression;
    use flate2::write::GzEncoder;

    use super::*;

    fn compress(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn other_files_pass() {
        assert_eq!(decompress(b"ply".to_vec()).unwrap(), b"ply");
    }

    #[test]
    fn members_are_joined() {
        let file = [compress(b"Shape "), compress(b"\"sphere\"")].concat();
        assert_eq!(decompress(file).unwrap(), b"Shape \"sphere\"");
    }

    #[test]
    fn a_cut_stream_is_an_error() {
        let mut file = compress(b"WorldBegin");
        file.truncate(file.len() - 5);
        assert!(matches!(decompress(file), Err(GzipError::Damaged(_))));
    }

    #[test]
    fn a_bomb_is_refused() {
        let file = compress(&vec![0; 40 << 20]);
        assert!(matches!(decompress(file), Err(GzipError::Expansion { .. })));
    }
}
