//! Chunks as Blosc 1 writes them: blocks of equal elements, shuffled so that like bytes stand together, then compressed.
//!
//! A chunk is a header of 16 bytes, the offset of each block, and the blocks. A block is one stream, or one for each byte
//! of an element; a stream is its length and what the inner codec made of it, or the bytes themselves if that is no shorter.
//!
//! | byte | holds |
//! |---|---|
//! | 0, 1 | versions of the format and of the codec |
//! | 2 | 1 bytes are shuffled, 2 not compressed at all, 4 bits are shuffled, 16 blocks are one stream; codec in the top three bits |
//! | 3 | bytes of an element |
//! | 4, 8, 12 | bytes of the contents, of a block, and of the chunk |
//!
//! The input may be hostile. Nothing is set aside before the chunk has shown as many bytes as can stand for it, and no two
//! blocks may share what they are made of, so that work and memory are bounded by the size of the chunk.
//!
//! Source: `README_HEADER.rst` and the behaviour of c-blosc 1.21.
//!
//! Deliberately absent: writing, Blosc 2, and the codec Snappy, which Blosc is commonly built without.

mod lz;
mod shuffle;

use std::io::Read as _;

use flate2::read::ZlibDecoder;
use ruzstd::decoding::FrameDecoder;
use thiserror::Error;

use crate::zlib::MOST_EXPANSION;

/// Bytes of the header.
const HEADER: usize = 16;

/// The newest version of the format.
const VERSION: u8 = 2;

/// Flags.
const BYTE_SHUFFLE: u8 = 1;
const UNCOMPRESSED: u8 = 2;
const BIT_SHUFFLE: u8 = 4;
const ONE_STREAM: u8 = 16;

/// Blocks are split into a stream for each byte of an element if there are at most so many and each gets so many bytes.
const MOST_STREAMS: usize = 16;
const LEAST_STREAM: usize = 128;

/// The window that every decoder of Zstandard is asked to support.
const ZSTD_WINDOW: u64 = 8 << 20;

/// Why a chunk can't be decompressed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub(crate) enum BloscError {
    #[error("it ends too early, or leads outside itself")]
    Truncated,
    #[error("its version is {0}: only 1 and 2 can be read")]
    Version(u8),
    #[error("its inner codec is Snappy, which is not supported")]
    Snappy,
    #[error("its inner codec has an unknown number or version ({0}, {1})")]
    Codec(u8, u8),
    #[error("its sizes contradict each other")]
    Sizes,
    #[error("it claims to expand from {compressed} bytes to {contents}")]
    Expansion { compressed: usize, contents: u64 },
    #[error("a stream of {0} is damaged")]
    Damaged(&'static str),
}

/// What made the streams.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Codec {
    BloscLz,
    Lz4,
    Zlib,
    Zstd,
}

/// What the header says.
struct Header {
    codec: Codec,
    flags: u8,
    element: usize,
    contents: usize,
    block: usize,
}

/// Appends what `chunk` holds to `contents`: at most `limit` bytes, and at least one.
///
/// # Errors
/// [`BloscError`] if the chunk is damaged or not of a supported kind; `contents` may then have grown.
pub(crate) fn decompress(chunk: &[u8], limit: u64, contents: &mut Vec<u8>) -> Result<(), BloscError> {
    let header = Header::read(chunk, limit)?;
    if header.flags & UNCOMPRESSED != 0 {
        let bytes = chunk.get(HEADER..HEADER + header.contents).ok_or(BloscError::Truncated)?;
        contents.extend_from_slice(bytes);
        return Ok(());
    }
    // All offsets are there before anything is set aside.
    let count = header.contents.div_ceil(header.block);
    let offsets = chunk.get(HEADER..).and_then(|rest| rest.get(..count.checked_mul(4)?));
    let offsets = offsets.ok_or(BloscError::Truncated)?;
    let mut shuffled = vec![0; header.block];
    let mut budget = chunk.len();
    for (index, offset) in offsets.chunks_exact(4).enumerate() {
        let streams = chunk.get(usize_at(offset, 0)?..).ok_or(BloscError::Truncated)?;
        let length = header.block.min(header.contents - index * header.block);
        header.expand(streams, &mut shuffled[..length], &mut budget)?;
        let end = contents.len();
        contents.resize(end + length, 0);
        header.unfilter(&shuffled[..length], &mut contents[end..]);
    }
    Ok(())
}

/// The number of 32 bits at an offset.
fn usize_at(bytes: &[u8], offset: usize) -> Result<usize, BloscError> {
    let number = bytes.get(offset..).and_then(|rest| rest.first_chunk()).ok_or(BloscError::Truncated)?;
    usize::try_from(u32::from_le_bytes(*number)).map_err(|_| BloscError::Sizes)
}

impl Header {
    fn read(chunk: &[u8], limit: u64) -> Result<Self, BloscError> {
        let &[version, codec_version, flags, element, ..] = chunk else { return Err(BloscError::Truncated) };
        if !(1..=VERSION).contains(&version) {
            return Err(BloscError::Version(version));
        }
        let header = Self {
            codec: Codec::of(flags >> 5, codec_version)?,
            flags,
            element: usize::from(element),
            contents: usize_at(chunk, 4)?,
            block: usize_at(chunk, 8)?,
        };
        let size = usize_at(chunk, 12)?;
        let contents = header.contents as u64;
        let blocks_fit = header.block > 0 && header.block <= header.contents;
        if size != chunk.len() || header.element == 0 || !blocks_fit || contents > limit {
            return Err(BloscError::Sizes);
        }
        if contents > MOST_EXPANSION * size as u64 {
            return Err(BloscError::Expansion { compressed: size, contents });
        }
        Ok(header)
    }

    /// How many streams a block of `length` bytes is.
    fn streams(&self, length: usize) -> usize {
        // Before there was the flag, this rule alone decided; what is left over at the end is never split.
        let is_split = self.flags & ONE_STREAM == 0
            && length == self.block
            && self.element <= MOST_STREAMS
            && length / self.element >= LEAST_STREAM
            && length.is_multiple_of(self.element);
        if is_split { self.element } else { 1 }
    }

    /// Expands the streams of a block, at the start of `streams`, until it is full. `budget` is how many bytes of the chunk
    /// other blocks have left.
    fn expand(&self, mut streams: &[u8], block: &mut [u8], budget: &mut usize) -> Result<(), BloscError> {
        for part in block.chunks_exact_mut(block.len() / self.streams(block.len())) {
            let length = usize_at(streams, 0)?;
            let stream = streams.get(4..).and_then(|rest| rest.get(..length)).ok_or(BloscError::Truncated)?;
            *budget = budget.checked_sub(4 + length).ok_or(BloscError::Truncated)?;
            streams = &streams[4 + length..];
            if length == part.len() {
                part.copy_from_slice(stream);
            } else {
                self.codec.expand(stream, part)?;
            }
        }
        Ok(())
    }

    /// Puts the bytes of a block back in their places.
    fn unfilter(&self, shuffled: &[u8], block: &mut [u8]) {
        if self.flags & BYTE_SHUFFLE != 0 && self.element > 1 {
            shuffle::unshuffle_bytes(self.element, shuffled, block);
        } else if self.flags & BIT_SHUFFLE != 0 && block.len() >= self.element {
            shuffle::unshuffle_bits(self.element, shuffled, block);
        } else {
            block.copy_from_slice(shuffled);
        }
    }
}

impl Codec {
    fn of(number: u8, version: u8) -> Result<Self, BloscError> {
        match (number, version) {
            (0, 1) => Ok(Self::BloscLz),
            (1, 1) => Ok(Self::Lz4),
            (2, _) => Err(BloscError::Snappy),
            (3, 1) => Ok(Self::Zlib),
            (4, 1) => Ok(Self::Zstd),
            _ => Err(BloscError::Codec(number, version)),
        }
    }

    /// Expands a stream that must fill `out`.
    fn expand(self, stream: &[u8], out: &mut [u8]) -> Result<(), BloscError> {
        let (name, is_full) = match self {
            Self::BloscLz => ("BloscLZ", lz::expand(stream, out) == Some(out.len())),
            Self::Lz4 => ("LZ4", lz4_flex::block::decompress_into(stream, out).is_ok_and(|n| n == out.len())),
            Self::Zlib => ("Zlib", ZlibDecoder::new(stream).read_exact(out).is_ok()),
            Self::Zstd => ("Zstandard", expand_zstd(stream, out)),
        };
        if is_full { Ok(()) } else { Err(BloscError::Damaged(name)) }
    }
}

fn expand_zstd(stream: &[u8], out: &mut [u8]) -> bool {
    let mut decoder = FrameDecoder::new();
    decoder.set_max_window_size(ZSTD_WINDOW.max(out.len() as u64));
    decoder.decode_all(stream, out).is_ok_and(|n| n == out.len())
}

#[cfg(test)]
mod tests;
