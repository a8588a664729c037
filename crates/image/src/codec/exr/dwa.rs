//! A check of DWA-compressed blocks before they are decoded.
//!
//! Each block begins with the sizes of its parts, decoded ones included, and the `exr` crate (1.74) allocates what they
//! say. A few damaged bytes would ask for terabytes, which aborts the process: no error, no panic to catch. So the sizes
//! are compared here with what the pixels of the block can need.
//!
//! Source of the layout: OpenEXR, `ImfDwaCompressor.cpp`: version, then the bytes of UNKNOWN decoded and coded, of AC,
//! DC and RLE coded, of RLE inflated and decoded, and the numbers of AC and DC coefficients, each of 64 bits.

use std::io::Cursor;

use exr::block::chunk::{Chunk, CompressedBlock};
use exr::meta::header::Header;
use exr::prelude::{Compression, Vec2};

use super::read::{foreign, malformed};
use crate::ImageError;

/// Places of the decoded sizes that are bytes: UNKNOWN, RLE inflated, RLE decoded.
const BYTES: [usize; 3] = [1, 6, 7];
/// Places of the decoded sizes that are numbers of 16-bit coefficients: AC, DC.
const COEFFICIENTS: [usize; 2] = [8, 9];

/// Checks all DWA blocks of a file whose headers are `headers`; does nothing if there are none.
pub(super) fn check(bytes: &[u8], headers: &[Header]) -> Result<(), ImageError> {
    let is_dwa = |header: &Header| matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_));
    if !headers.iter().any(is_dwa) {
        return Ok(());
    }
    let reader = exr::block::read(Cursor::new(bytes), false).map_err(foreign)?;
    for chunk in reader.filter_chunks(false, |_, _, _| true).map_err(foreign)? {
        let chunk = chunk.map_err(foreign)?;
        let header = headers.get(chunk.layer_index).ok_or_else(|| malformed("a block belongs to no part"))?;
        if is_dwa(header) {
            check_block(&chunk, header)?;
        }
    }
    Ok(())
}

fn check_block(chunk: &Chunk, header: &Header) -> Result<(), ImageError> {
    let data = match &chunk.compressed_block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return Err(malformed("a block of flat pixels is deep")),
    };
    let place = header.get_block_data_indices(&chunk.compressed_block).map_err(foreign)?;
    let Vec2(width, height) = header.get_absolute_block_pixel_coordinates(place).map_err(foreign)?.size;
    if data.len() == width * height * header.channels.bytes_per_pixel {
        // Stored without compression.
        return Ok(());
    }
    // Coefficients come in blocks of 8×8 pixels; twice that leaves room for run lengths that gain nothing.
    let padded = width.next_multiple_of(8) * height.next_multiple_of(8) * header.channels.list.len();
    let (most_coefficients, most_bytes) = (2 * padded as u64, 2 * 4 * padded as u64);
    let size =
        |place: usize| data.as_chunks::<8>().0.get(place).map_or(0, |&bytes| u64::from_le_bytes(bytes));
    let fits = BYTES.iter().all(|&place| size(place) <= most_bytes)
        && COEFFICIENTS.iter().all(|&place| size(place) <= most_coefficients);
    if fits { Ok(()) } else { Err(malformed("a block claims more than its pixels can need")) }
}
