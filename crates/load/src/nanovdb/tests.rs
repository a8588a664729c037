//! Volumes that are written here, offset by offset, and read back.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::*;
use sahl_math::Vec3;

/// Bytes to write at offsets.
#[derive(Default)]
struct Memory(Vec<u8>);

impl Memory {
    fn put(&mut self, offset: usize, bytes: &[u8]) {
        let end = offset + bytes.len();
        self.0.resize(self.0.len().max(end), 0);
        self.0[offset..end].copy_from_slice(bytes);
    }

    fn set_bit(&mut self, offset: usize, bit: usize) {
        self.put(offset + bit / 8, &[self.0.get(offset + bit / 8).copied().unwrap_or(0) | 1 << (bit % 8)]);
    }
}

const ROOT: usize = 672 + 64;
const UPPER: usize = ROOT + 64 + 32;
const LOWER: usize = UPPER + 270_400;
const LEAF: usize = LOWER + 33_856;

/// What a leaf holds at the place (x, y, z) in it.
fn leaf_value(x: usize, y: usize, z: usize) -> f32 {
    (100 * x + 10 * y + z) as f32
}

/// A grid with one leaf at lattice point (−8, 0, 8), a tile of 8 voxels at (−8, 0, 16) and one of 128 at (−128, 128, 0), half
/// a unit a voxel and moved by (1, 2, 3).
fn grid() -> Vec<u8> {
    let mut memory = Memory::default();
    memory.put(0, b"NanoVDB0");
    memory.put(16, &(32_u32 << 21).to_le_bytes());
    memory.put(40, b"density");
    for (i, scale) in [0.5_f64, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.5].iter().enumerate() {
        memory.put(296 + 88 + 8 * i, &scale.to_le_bytes());
    }
    for (i, offset) in [1.0_f64, 2.0, 3.0].iter().enumerate() {
        memory.put(296 + 232 + 8 * i, &offset.to_le_bytes());
    }
    for (i, bound) in [-63.0_f64, 2.0, 3.0, 1.0, 130.0, 67.0].iter().enumerate() {
        memory.put(560 + 8 * i, &bound.to_le_bytes());
    }
    memory.put(636, &1_u32.to_le_bytes());
    memory.put(672 + 24, &64_u64.to_le_bytes());
    memory.put(ROOT + 24, &1_u32.to_le_bytes());
    memory.put(ROOT + 28, &0.0_f32.to_le_bytes());
    // The node that holds x from −4096 to −1, and y and z from 0 to 4095.
    memory.put(ROOT + 64, &(0xF_FFFF_u64 << 42).to_le_bytes());
    memory.put(ROOT + 72, &((UPPER - ROOT) as u64).to_le_bytes());
    // In it, x = −128 is entry 31 along x.
    let (child, tile) = (31 << 10, 31 << 10 | 1 << 5);
    memory.set_bit(UPPER + 4128, child);
    memory.put(UPPER + 8256 + 8 * child, &((LOWER - UPPER) as u64).to_le_bytes());
    memory.put(UPPER + 8256 + 8 * tile, &7.0_f32.to_le_bytes());
    // In that, x = −8 is entry 15 along x; z = 8 is entry 1, z = 16 entry 2.
    let (child, tile) = (15 << 8 | 1, 15 << 8 | 2);
    memory.set_bit(LOWER + 544, child);
    memory.put(LOWER + 1088 + 8 * child, &((LEAF - LOWER) as u64).to_le_bytes());
    memory.put(LOWER + 1088 + 8 * tile, &5.0_f32.to_le_bytes());
    for offset in 0..512 {
        let value = leaf_value(offset >> 6, offset >> 3 & 7, offset & 7);
        memory.put(LEAF + 96 + 4 * offset, &value.to_le_bytes());
    }
    memory.0
}

/// A file of one segment with one grid.
fn file(name: &[u8], codec: u16, size: usize, stored: &[u8]) -> Vec<u8> {
    let mut memory = Memory::default();
    memory.put(0, b"NanoVDB0");
    memory.put(8, &(32_u32 << 21).to_le_bytes());
    memory.put(12, &1_u16.to_le_bytes());
    let description = HEADER;
    memory.put(description, &(size as u64).to_le_bytes());
    memory.put(description + 8, &(stored.len() as u64).to_le_bytes());
    memory.put(description + 32, &1_u32.to_le_bytes());
    memory.put(description + 136, &(name.len() as u32).to_le_bytes());
    memory.put(description + 168, &codec.to_le_bytes());
    memory.put(description + DESCRIPTION, name);
    memory.put(description + DESCRIPTION + name.len(), stored);
    memory.0
}

fn raw() -> Vec<u8> {
    let grid = grid();
    file(b"density\0", 0, grid.len(), &grid)
}

/// The value of a grid at a lattice point.
fn value(grid: &SparseGrid, point: [i32; 3]) -> f32 {
    let steps: [i32; 3] = std::array::from_fn(|axis| point[axis] - grid.origin[axis]);
    let inside = (0..3).all(|axis| steps[axis] >= 0 && steps[axis] < 8 * grid.blocks[axis] as i32);
    if !inside {
        return grid.background;
    }
    let [x, y, z] = steps.map(|step| step as usize);
    let [nx, ny, _] = grid.blocks.map(|n| n as usize);
    match grid.table[(z / 8 * ny + y / 8) * nx + x / 8] {
        SparseGrid::NO_BLOCK => grid.background,
        block => grid.values[block as usize * 512 + (x % 8 * 8 + y % 8) * 8 + z % 8],
    }
}

fn check(grid: &SparseGrid) {
    assert!(grid.is_complete());
    assert_eq!((grid.origin, grid.blocks), ([-128, 0, 0], [16, 32, 16]));
    for (x, y, z) in [(0, 0, 0), (7, 7, 7), (3, 5, 2)] {
        let expected = leaf_value(x, y, z);
        assert_eq!(value(grid, [x as i32 - 8, y as i32, z as i32 + 8]), expected, "{x} {y} {z}");
    }
    assert_eq!(value(grid, [-8, 0, 16]), 5.0);
    assert_eq!(value(grid, [-1, 7, 23]), 5.0);
    assert_eq!(value(grid, [-1, 7, 24]), 0.0);
    for point in [[-128, 128, 0], [-1, 255, 127], [-60, 200, 50]] {
        assert_eq!(value(grid, point), 7.0, "{point:?}");
    }
    for point in [[-1, 127, 0], [0, 128, 0], [-8, 0, 7]] {
        assert_eq!(value(grid, point), 0.0, "{point:?}");
    }
    assert_eq!(grid.index_to_medium.point(Vec3::new(2.0, 0.0, 4.0)), Vec3::new(2.0, 2.0, 5.0));
    assert_eq!((grid.bounds.min.x, grid.bounds.max.z), (-63.0, 67.0));
}

#[test]
fn leaves_and_tiles_are_where_they_were() {
    check(&read(&raw(), "density").unwrap().unwrap());
    assert_eq!(read(&raw(), "temperature"), Ok(None));
    assert_eq!(names(&raw()), ["density"]);
}

#[test]
fn grids_in_later_segments_and_under_zip_are_found() {
    let grid = grid();
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(&grid).unwrap();
    let compressed = encoder.finish().unwrap();
    let mut stored = (compressed.len() as u64).to_le_bytes().to_vec();
    stored.extend(&compressed);
    let mut bytes = raw();
    bytes.extend(file(b"heat\0", 1, grid.len(), &stored));
    assert_eq!(names(&bytes), ["density", "heat"]);
    check(&read(&bytes, "heat").unwrap().unwrap());
    // A grid that expands to other than what it says.
    let wrong = file(b"heat\0", 1, grid.len() + 1, &stored);
    assert_eq!(read(&wrong, "heat"), Err(NanoVdbError::Truncated));
}

/// A Blosc chunk of floats whose bytes are shuffled and whose blocks are one stream each of LZ4: as NanoVDB writes it.
fn blosc_chunk(contents: &[u8]) -> Vec<u8> {
    let block = (1 << 18).min(contents.len());
    let blocks: Vec<_> = contents.chunks(block).collect();
    let mut chunk = vec![2, 1, 1 << 5 | 16 | 1, 4];
    chunk.extend([contents.len(), block, 0].map(|n| n as u32).map(u32::to_le_bytes).concat());
    chunk.resize(16 + 4 * blocks.len(), 0);
    for (i, block) in blocks.iter().enumerate() {
        let offset = (chunk.len() as u32).to_le_bytes();
        chunk[16 + 4 * i..][..4].copy_from_slice(&offset);
        let whole = block.len() / 4;
        let mut shuffled: Vec<u8> = (0..4 * whole).map(|k| block[k % whole * 4 + k / whole]).collect();
        shuffled.extend(&block[4 * whole..]);
        let stream = lz4_flex::block::compress(&shuffled);
        chunk.extend((stream.len() as u32).to_le_bytes());
        chunk.extend(stream);
    }
    let size = (chunk.len() as u32).to_le_bytes();
    chunk[12..16].copy_from_slice(&size);
    chunk
}

#[test]
fn grids_under_blosc_are_read_chunk_by_chunk() {
    let grid = grid();
    let store = |parts: &[&[u8]]| {
        let chunks = parts.iter().map(|part| {
            let chunk = blosc_chunk(part);
            [(chunk.len() as u64).to_le_bytes().to_vec(), chunk].concat()
        });
        chunks.collect::<Vec<_>>().concat()
    };
    let whole = store(&[&grid]);
    assert!(whole.len() < grid.len() / 10);
    check(&read(&file(b"density\0", 2, grid.len(), &whole), "density").unwrap().unwrap());
    // Files above a gigabyte have several chunks.
    let (first, second) = grid.split_at(100_001);
    let both = store(&[first, second]);
    check(&read(&file(b"density\0", 2, grid.len(), &both), "density").unwrap().unwrap());
    // More or less than the file says.
    let short = file(b"density\0", 2, grid.len() - 1, &whole);
    assert_eq!(read(&short, "density"), Err(NanoVdbError::Blosc(BloscError::Sizes)));
    let long = file(b"density\0", 2, grid.len() + 1, &whole);
    assert_eq!(read(&long, "density"), Err(NanoVdbError::Truncated));
    for length in [0, 7, 8, 20, whole.len() / 2, whole.len() - 1] {
        let cut = file(b"density\0", 2, grid.len(), &whole[..length]);
        assert_eq!(read(&cut, "density"), Err(NanoVdbError::Truncated), "{length}");
    }
}

#[test]
fn what_cannot_be_read_is_told() {
    assert_eq!(read(b"", "density"), Err(NanoVdbError::NoVolume));
    assert_eq!(read(b"OpenVDB, or not", "density"), Err(NanoVdbError::NoVolume));
    let change = |offset: usize, bytes: &[u8]| {
        let mut memory = Memory(raw());
        memory.put(offset, bytes);
        read(&memory.0, "density")
    };
    assert_eq!(change(8, &(29_u32 << 21).to_le_bytes()), Err(NanoVdbError::Version(29)));
    assert_eq!(change(HEADER + 168, &[9]), Err(NanoVdbError::Codec(9)));
    assert_eq!(change(HEADER + 32, &[6]), Err(NanoVdbError::Type(6)));
    assert_eq!(change(HEADER + 36, &[1]), Err(NanoVdbError::Class(1)));
    let first = HEADER + DESCRIPTION + 8;
    assert_eq!(change(first + 296 + 88, &0.0_f64.to_le_bytes()), Err(NanoVdbError::Transform));
    assert_eq!(change(first + ROOT + 72, &u64::MAX.to_le_bytes()), Err(NanoVdbError::Truncated));
    // A root that says it has more children than there is room for, and one whose children are all the same node.
    assert_eq!(change(first + ROOT + 24, &u32::MAX.to_le_bytes()), Err(NanoVdbError::Truncated));
    assert_eq!(change(first + UPPER + 4128, &[0xFF; 4096]), Err(NanoVdbError::Truncated));
}

#[test]
fn cut_files_are_errors() {
    let bytes = raw();
    for length in [1, 15, 16, 100, 200, 900, bytes.len() / 2, bytes.len() - 1] {
        assert!(read(&bytes[..length], "density").is_err(), "{length}");
    }
}

#[test]
fn far_apart_leaves_ask_for_no_memory() {
    let mut memory = Memory(raw());
    let first = HEADER + DESCRIPTION + 8;
    // The same node twice, at both ends of the lattice: the budget allows for one.
    memory.put(first + ROOT + 24, &2_u32.to_le_bytes());
    memory.put(first + ROOT + 96, &(0x7_FFFF_u64 << 42).to_le_bytes());
    memory.put(first + ROOT + 104, &((UPPER - ROOT) as u64).to_le_bytes());
    assert!(read(&memory.0, "density").is_err());
}
