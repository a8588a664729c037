//! Zlib streams inside binary files.

use std::io::{self, Read as _};

use flate2::read::ZlibDecoder;

/// What Deflate expands to at most, in multiples of what it is given.
pub(crate) const MOST_EXPANSION: u64 = 1032;

/// `compressed` as the `length` bytes that it must expand to.
///
/// No more than it can expand to is set aside, whatever `length` claims.
///
/// # Errors
/// It is damaged, or expands to less, which is [`io::ErrorKind::UnexpectedEof`].
pub(crate) fn inflate(compressed: &[u8], length: u64) -> io::Result<Vec<u8>> {
    if length > MOST_EXPANSION * compressed.len() as u64 {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    let mut bytes = Vec::with_capacity(length as usize);
    ZlibDecoder::new(compressed).take(length).read_to_end(&mut bytes)?;
    if bytes.len() as u64 == length { Ok(bytes) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
}
