//! Zlib streams inside binary files.

use std::io::{self, Read as _};

use flate2::read::ZlibDecoder;

/// What Deflate expands to at most, in multiples of what it is given. Others that compress bytes stay below it: LZ4 ends at 255.
pub(crate) const MOST_EXPANSION: u64 = 1032;

/// What is set aside before anything has been expanded, at most, in bytes: `length` is only a claim.
const MOST_SET_ASIDE: u64 = 1 << 20;

/// `compressed` as the first `length` bytes that it expands to.
///
/// # Errors
/// It is damaged, or expands to less, which is [`io::ErrorKind::UnexpectedEof`].
pub(crate) fn inflate(compressed: &[u8], length: u64) -> io::Result<Vec<u8>> {
    if length > MOST_EXPANSION * compressed.len() as u64 {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    let mut bytes = Vec::with_capacity(length.min(MOST_SET_ASIDE) as usize);
    ZlibDecoder::new(compressed).take(length).read_to_end(&mut bytes)?;
    if bytes.len() as u64 == length { Ok(bytes) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use flate2::Compression;
    use flate2::write::ZlibEncoder;

    use super::*;

    fn deflated(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(bytes).expect("a list takes everything");
        encoder.finish().expect("a list takes everything")
    }

    #[test]
    fn as_many_bytes_come_out_as_are_asked_for_or_none() {
        let bytes: Vec<u8> = (0..3_000_000_u32).map(|i| (i.wrapping_mul(i) >> 7) as u8).collect();
        let compressed = deflated(&bytes);
        for length in [0, 1, bytes.len() - 1, bytes.len()] {
            let inflated = inflate(&compressed, length as u64).expect("there are as many");
            assert!(inflated == bytes[..length], "{length}");
        }
        let kind = |compressed: &[u8], length: u64| inflate(compressed, length).map_err(|error| error.kind());
        assert_eq!(kind(&compressed, bytes.len() as u64 + 1), Err(io::ErrorKind::UnexpectedEof));
        assert_eq!(kind(&compressed, u64::MAX / 2), Err(io::ErrorKind::UnexpectedEof));
        assert!(inflate(&compressed[..compressed.len() / 2], bytes.len() as u64).is_err());
        assert!(inflate(&bytes, 10).is_err());
    }
}
