//! Chunks that are written here, and read back.

use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use proptest::prelude::*;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};

use super::*;

/// Makes a stream.
type Encode = fn(&[u8]) -> Vec<u8>;

/// Codecs by their number, and how to write a stream of each.
const CODECS: [(u8, Encode); 4] = [(0, blosclz), (1, lz4), (3, zlib), (4, zstd)];

fn lz4(bytes: &[u8]) -> Vec<u8> {
    lz4_flex::block::compress(bytes)
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn zstd(bytes: &[u8]) -> Vec<u8> {
    compress_to_vec(bytes, CompressionLevel::Fastest)
}

/// Literals, and runs of three bytes and more.
fn blosclz(bytes: &[u8]) -> Vec<u8> {
    let (mut stream, mut i) = (Vec::new(), 0);
    let run = |i: usize| bytes[i..].iter().take_while(|&&byte| byte == bytes[i]).count();
    while i < bytes.len() {
        let length = if i == 0 { 0 } else { run(i) };
        if length >= 3 && bytes[i] == bytes[i - 1] {
            let more = length - 3;
            stream.push((more.min(6) as u8 + 1) << 5);
            if more >= 6 {
                stream.extend(std::iter::repeat_n(255, (more - 6) / 255));
                stream.push(((more - 6) % 255) as u8);
            }
            stream.push(0);
            i += length;
        } else {
            stream.extend([0, bytes[i]]);
            i += 1;
        }
    }
    stream
}

/// How a chunk is written.
#[derive(Clone, Copy, Debug)]
struct Layout {
    flags: u8,
    element: usize,
    block: usize,
}

fn shuffle(layout: &Layout, block: &[u8]) -> Vec<u8> {
    let count = block.len() / layout.element;
    let bit = |row: usize, i: usize| block[i * layout.element + row / 8] >> (row % 8) & 1;
    let mut out = if layout.flags & BYTE_SHUFFLE != 0 {
        (0..count * layout.element).map(|k| block[k % count * layout.element + k / count]).collect()
    } else if layout.flags & BIT_SHUFFLE != 0 && count.is_multiple_of(8) && count > 0 {
        let byte = |k: usize| (0..8).map(|b| bit(k / (count / 8), k % (count / 8) * 8 + b) << b).sum();
        (0..count * layout.element).map(byte).collect()
    } else {
        Vec::new()
    };
    out.extend(&block[out.len()..]);
    out
}

fn chunk(layout: Layout, codec: u8, encode: Encode, contents: &[u8]) -> Vec<u8> {
    let Layout { flags, element, block } = layout;
    let mut chunk = vec![2, 1, codec << 5 | flags, element as u8];
    chunk.extend([contents.len(), block, 0].map(|n| n as u32).map(u32::to_le_bytes).concat());
    if flags & UNCOMPRESSED != 0 {
        chunk.extend(contents);
    } else {
        chunk.resize(HEADER + 4 * contents.len().div_ceil(block), 0);
        for (i, part) in contents.chunks(block).enumerate() {
            let offset = (chunk.len() as u32).to_le_bytes();
            chunk[HEADER + 4 * i..][..4].copy_from_slice(&offset);
            let is_split =
                flags & ONE_STREAM == 0 && part.len() == block && element <= 16 && block / element >= 128;
            let shuffled = shuffle(&layout, part);
            for stream in shuffled.chunks(if is_split { block / element } else { part.len() }) {
                let encoded = encode(stream);
                let shorter = if encoded.len() < stream.len() { &encoded } else { stream };
                chunk.extend((shorter.len() as u32).to_le_bytes());
                chunk.extend(shorter);
            }
        }
    }
    let size = (chunk.len() as u32).to_le_bytes();
    chunk[12..HEADER].copy_from_slice(&size);
    chunk
}

/// Smooth numbers, with some bytes that are like none.
fn contents(length: usize) -> Vec<u8> {
    let numbers = (0..length as u32).flat_map(|i| (1.0 + (i / 7) as f32).to_le_bytes());
    numbers.take(length).enumerate().map(|(i, byte)| if i % 97 == 3 { (i * i) as u8 } else { byte }).collect()
}

fn read(chunk: &[u8]) -> Result<Vec<u8>, BloscError> {
    let mut contents = Vec::new();
    decompress(chunk, u64::from(u32::MAX), &mut contents).map(|()| contents)
}

#[test]
fn every_codec_filter_and_split_is_undone() {
    for (codec, encode) in CODECS {
        for flags in
            [0, BYTE_SHUFFLE, BIT_SHUFFLE, ONE_STREAM, ONE_STREAM | BYTE_SHUFFLE, ONE_STREAM | BIT_SHUFFLE]
        {
            for (element, block, length) in [
                (4, 2048, 9000),
                (8, 2048, 2048),
                (4, 512, 3000),
                (1, 1000, 2500),
                (3, 999, 5000),
                (20, 4000, 9999),
                (4, 40, 47),
            ] {
                let (layout, contents) = (Layout { flags, element, block }, contents(length));
                let chunk = chunk(layout, codec, encode, &contents);
                assert!(read(&chunk).as_ref() == Ok(&contents), "{codec} {layout:?} {length}");
            }
        }
    }
}

#[test]
fn what_is_not_compressed_is_copied() {
    let contents = contents(1000);
    let chunk =
        chunk(Layout { flags: UNCOMPRESSED | BYTE_SHUFFLE, element: 4, block: 1000 }, 1, lz4, &contents);
    assert_eq!(read(&chunk), Ok(contents));
    assert_eq!(read(&chunk[..900]), Err(BloscError::Sizes));
}

#[test]
fn chunks_are_appended_up_to_a_limit() {
    let layout = Layout { flags: BYTE_SHUFFLE, element: 4, block: 2048 };
    let bytes = contents(5000);
    let chunk = chunk(layout, 1, lz4, &bytes);
    let mut all = vec![7];
    assert_eq!(decompress(&chunk, 4999, &mut all), Err(BloscError::Sizes));
    decompress(&chunk, 5000, &mut all).unwrap();
    assert_eq!((all[0], &all[1..]), (7, &bytes[..]));
}

#[test]
fn lying_headers_are_told() {
    let good = chunk(Layout { flags: BYTE_SHUFFLE, element: 4, block: 2048 }, 1, lz4, &contents(5000));
    let change = |offset: usize, bytes: &[u8]| {
        let mut chunk = good.clone();
        chunk[offset..offset + bytes.len()].copy_from_slice(bytes);
        read(&chunk).unwrap_err()
    };
    let number = |n: usize| (n as u32).to_le_bytes();
    assert_eq!(change(0, &[5]), BloscError::Version(5));
    assert_eq!(change(0, &[0]), BloscError::Version(0));
    assert_eq!(change(1, &[2]), BloscError::Codec(1, 2));
    assert_eq!(change(2, &[2 << 5]), BloscError::Snappy);
    assert_eq!(change(2, &[6 << 5]), BloscError::Codec(6, 1));
    assert_eq!(change(3, &[0]), BloscError::Sizes);
    assert_eq!(change(4, &number(0)), BloscError::Sizes);
    assert_eq!(change(8, &number(0)), BloscError::Sizes);
    assert_eq!(change(8, &number(5001)), BloscError::Sizes);
    assert_eq!(change(8, &number(1)), BloscError::Truncated);
    assert_eq!(change(12, &number(good.len() - 1)), BloscError::Sizes);
    let compressed = good.len();
    let contents = u32::MAX.into();
    assert_eq!(change(4, &[255; 4]), BloscError::Expansion { compressed, contents });
    // An offset that leads outside, and two blocks in one place.
    assert_eq!(change(HEADER, &[255; 4]), BloscError::Truncated);
    assert_eq!(change(HEADER, &number(good.len() - 3)), BloscError::Truncated);
    let second: [u8; 4] = good[HEADER + 4..HEADER + 8].try_into().unwrap();
    assert_eq!(change(HEADER + 8, &second), BloscError::Damaged("LZ4"));
}

#[test]
fn blocks_that_share_their_streams_are_refused() {
    // Streams of bytes as they are: each block alone would be good.
    let bytes: Vec<u8> = (0..4096_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let mut chunk = chunk(Layout { flags: ONE_STREAM, element: 1, block: 64 }, 1, lz4, &bytes);
    let first: [u8; 4] = chunk[HEADER..HEADER + 4].try_into().unwrap();
    let blocks = u32::from_le_bytes(first) as usize;
    for offset in chunk[HEADER..blocks].chunks_exact_mut(4) {
        offset.copy_from_slice(&first);
    }
    chunk.truncate(blocks + 68);
    let size = (chunk.len() as u32).to_le_bytes();
    chunk[12..HEADER].copy_from_slice(&size);
    assert_eq!(read(&chunk), Err(BloscError::Truncated));
}

#[test]
fn blosclz_reaches_far_and_overlaps() {
    let mut out = [0; 9000];
    // Two literals, then three copies: of what is just written, from 8 191 bytes back and from 8 193.
    let mut stream = vec![1, b'a', b'b', 7 << 5];
    stream.extend([255; 33]);
    stream.extend([0, 1, 1 << 5 | 31, 254, 1 << 5 | 31, 255, 0, 1]);
    let end = lz::expand(&stream, &mut out).unwrap();
    let length = 2 + 9 + 33 * 255;
    assert_eq!(end, length + 6);
    let expected: Vec<u8> = (0..length).map(|i| b"ab"[i % 2]).collect();
    assert_eq!(out[..length], expected);
    assert_eq!(out[length..length + 3], expected[length - 8191..][..3]);
    assert_eq!(out[length + 3..end], expected[length + 3 - 8193..][..3]);
    // Before the beginning, beyond the end, and nothing after a control byte.
    assert_eq!(lz::expand(&[0, b'a', 1 << 5, 1], &mut out), None);
    assert_eq!(lz::expand(&stream, &mut out[..8000]), None);
    assert_eq!(lz::expand(&[4, b'a'], &mut out), None);
    assert_eq!(lz::expand(&[], &mut out), None);
}

/// A chunk in which some bytes were changed.
fn damaged() -> impl Strategy<Value = Vec<u8>> {
    let layouts = (0..4_usize, 0..8_u8, prop::sample::select(vec![1, 3, 4, 8]), 1..5_usize);
    let changes = prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..5);
    let cuts = prop::option::weighted(0.25, any::<prop::sample::Index>());
    (layouts, changes, cuts).prop_map(|((codec, flags, element, size), changes, cut)| {
        let (number, encode) = CODECS[codec];
        let flags = flags & !UNCOMPRESSED | (flags & UNCOMPRESSED) << 3;
        let layout = Layout { flags, element, block: 600 * size };
        let mut chunk = chunk(layout, number, encode, &contents(2500));
        for (place, byte) in changes {
            let place = place.index(chunk.len());
            chunk[place] = byte;
        }
        if let Some(cut) = cut {
            chunk.truncate(cut.index(chunk.len()));
        }
        chunk
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2000,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(11),
        ..ProptestConfig::default()
    })]

    #[test]
    fn damaged_chunks_give_errors_or_bytes(chunk in damaged()) {
        if let Ok(contents) = read(&chunk) {
            prop_assert!(contents.len() as u64 <= MOST_EXPANSION * chunk.len() as u64);
        }
    }

    #[test]
    fn random_streams_end(codec in 0..4_usize, stream in prop::collection::vec(any::<u8>(), 0..200), room in 1..500_usize) {
        let codec = [Codec::BloscLz, Codec::Lz4, Codec::Zlib, Codec::Zstd][codec];
        let _ = codec.expand(&stream, &mut vec![0; room]);
    }
}
