//! One grid: from a tree in memory to blocks in a table.
//!
//! The tree has four levels: a root with a list of nodes of 4096 voxels a side, these with 32³ nodes of 128, these with 16³
//! leaves of 8. Where nothing is below, a tile holds one value. Offsets are in bytes from the node that holds them.

use std::collections::BTreeMap;

use sahl_math::{Bounds3, Transform, Vec3};
use sahl_scene::SparseGrid;

use super::{Bytes, FLOAT, NanoVdbError};

/// Where things are in a grid: the map from lattice to world in double precision, the box of what is there, the type of
/// values, and the tree, whose fourth offset leads to the root.
const MAP: usize = 296 + 88;
const TRANSLATION: usize = 296 + 232;
const WORLD_BOX: usize = 560;
const TYPE: usize = 636;
const TREE: usize = 672;
const ROOT: usize = TREE + 24;

/// Sizes of the nodes of floats.
const UPPER_SIZE: usize = 270_400;
const LOWER_SIZE: usize = 33_856;
const LEAF_SIZE: usize = 2144;

/// The most blocks that the table of a grid may have.
const MOST_BLOCKS: u64 = 1 << 26;

/// An inner node: how many entries it has along an edge (as a power of two), blocks along an entry's edge, and where its mask
/// of children and its table of entries are.
struct Level {
    log: u32,
    span: i32,
    children: usize,
    table: usize,
    size: usize,
}

const UPPER: Level = Level { log: 5, span: 16, children: 4128, table: 8256, size: UPPER_SIZE };
const LOWER: Level = Level { log: 4, span: 1, children: 544, table: 1088, size: LOWER_SIZE };

/// What is found on the way down.
struct Found<'a> {
    bytes: Bytes<'a>,
    background: f32,
    /// Leaves by the place of their block: the offset of their values.
    leaves: BTreeMap<[i32; 3], usize>,
    /// Tiles: place and edge in blocks, and value.
    tiles: Vec<([i32; 3], i32, f32)>,
    /// Nodes of each kind that may still be visited: as many as the bytes have room for, so that a tree which leads to the
    /// same node again and again ends.
    budget: [usize; 3],
}

/// The grid in `bytes`, with its tree flattened.
pub(super) fn flatten(bytes: Bytes<'_>) -> Result<SparseGrid, NanoVdbError> {
    let kind = bytes.u32(TYPE)?;
    if kind != FLOAT {
        return Err(NanoVdbError::Type(kind));
    }
    let root = at(TREE, bytes.u64(ROOT)?)?;
    let background = bytes.f32(at(root, 28)?)?;
    let room = |size: usize| bytes.0.len() / size;
    let budget = [room(UPPER_SIZE), room(LOWER_SIZE), room(LEAF_SIZE)];
    let mut found = Found { bytes, background, leaves: BTreeMap::new(), tiles: Vec::new(), budget };
    for index in 0..bytes.u32(at(root, 24)?)? as usize {
        let tile = at(root, 64 + 32 * index as u64)?;
        let (key, child) = (bytes.u64(tile)?, bytes.u64(tile + 8)?);
        if child != 0 {
            found.inner(at(root, child)?, place_of(key), &UPPER)?;
        } else if bytes.f32(tile + 20)? != background {
            return Err(NanoVdbError::GiantTile);
        }
    }
    found.into_grid(index_to_world(bytes)?, world_box(bytes)?)
}

fn at(base: usize, offset: u64) -> Result<usize, NanoVdbError> {
    usize::try_from(offset).ok().and_then(|offset| base.checked_add(offset)).ok_or(NanoVdbError::Truncated)
}

/// The block at which a child of the root begins: three signed numbers of 20 bits in its key, in units of 512 blocks.
fn place_of(key: u64) -> [i32; 3] {
    let number = |shift: u32| (((key >> shift) & 0xF_FFFF) as i32) << 12 >> 12;
    [number(42), number(21), number(0)].map(|number| number * 512)
}

fn index_to_world(bytes: Bytes<'_>) -> Result<Transform, NanoVdbError> {
    let mut rows = [[0.0; 4]; 3];
    for (i, row) in rows.iter_mut().enumerate() {
        for (j, value) in row.iter_mut().enumerate() {
            *value = bytes.f64(if j < 3 { MAP + 8 * (3 * i + j) } else { TRANSLATION + 8 * i })?;
        }
    }
    Transform::from_rows(rows).ok_or(NanoVdbError::Transform)
}

fn world_box(bytes: Bytes<'_>) -> Result<Bounds3, NanoVdbError> {
    let corner = |offset: usize| -> Result<Vec3, NanoVdbError> {
        let value = |axis: usize| bytes.f64(WORLD_BOX + offset + 8 * axis).map(|x| x as f32);
        Ok(Vec3::new(value(0)?, value(1)?, value(2)?))
    };
    let bounds = Bounds3 { min: corner(0)?, max: corner(24)? };
    // Without a voxel the box is inside out.
    let empty = Bounds3 { min: Vec3::ZERO, max: Vec3::ZERO };
    Ok(if bounds.is_empty() || !(bounds.min.is_finite() && bounds.max.is_finite()) { empty } else { bounds })
}

impl Found<'_> {
    /// Goes through an inner node at `node`, whose first block is at `place`.
    fn inner(&mut self, node: usize, place: [i32; 3], level: &Level) -> Result<(), NanoVdbError> {
        let is_upper = level.size == UPPER_SIZE;
        self.spend(if is_upper { 0 } else { 1 })?;
        let edge = 1 << level.log;
        for index in 0..edge * edge * edge {
            let entry = at(node, level.table as u64 + 8 * index)?;
            let within = [index >> (2 * level.log), index >> level.log & (edge - 1), index & (edge - 1)];
            let block: [i32; 3] = std::array::from_fn(|axis| place[axis] + level.span * within[axis] as i32);
            let mask = self.bytes.take::<1>(at(node, level.children as u64 + index / 8)?)?[0];
            if mask >> (index % 8) & 1 == 0 {
                let value = self.bytes.f32(entry)?;
                if value != self.background {
                    self.tiles.push((block, level.span, value));
                }
            } else {
                let child = at(node, self.bytes.u64(entry)?)?;
                if is_upper {
                    self.inner(child, block, &LOWER)?;
                } else {
                    self.spend(2)?;
                    // The values must be there when they are copied.
                    self.bytes.part(child, LEAF_SIZE as u64)?;
                    self.leaves.insert(block, child + 96);
                }
            }
        }
        Ok(())
    }

    fn spend(&mut self, kind: usize) -> Result<(), NanoVdbError> {
        self.budget[kind] = self.budget[kind].checked_sub(1).ok_or(NanoVdbError::Truncated)?;
        Ok(())
    }

    /// The first block and the number of blocks along each axis.
    fn extent(&self) -> ([i32; 3], [u32; 3]) {
        let (mut first, mut last) = ([i32::MAX; 3], [i32::MIN; 3]);
        let leaves = self.leaves.keys().map(|&place| (place, 1));
        let tiles = self.tiles.iter().map(|&(place, edge, _)| (place, edge));
        for (place, edge) in leaves.chain(tiles) {
            for axis in 0..3 {
                first[axis] = first[axis].min(place[axis]);
                last[axis] = last[axis].max(place[axis] + edge);
            }
        }
        if first[0] > last[0] {
            return ([0; 3], [0; 3]);
        }
        (first, std::array::from_fn(|axis| last[axis].abs_diff(first[axis])))
    }

    fn into_grid(self, index_to_medium: Transform, bounds: Bounds3) -> Result<SparseGrid, NanoVdbError> {
        let (first, blocks) = self.extent();
        let count = blocks.iter().try_fold(1_u64, |count, &n| count.checked_mul(u64::from(n)));
        let count = count.filter(|&count| count <= MOST_BLOCKS).ok_or(NanoVdbError::TooSparse(
            blocks.iter().fold(1, |count: u64, &n| count.saturating_mul(u64::from(n))),
        ))?;
        let mut table = vec![SparseGrid::NO_BLOCK; count as usize];
        let mut values: Vec<f32> = Vec::new();
        let index = |place: [i32; 3]| {
            let [x, y, z] = std::array::from_fn(|axis| place[axis].abs_diff(first[axis]) as usize);
            (z * blocks[1] as usize + y) * blocks[0] as usize + x
        };
        let mut constants: BTreeMap<u32, u32> = BTreeMap::new();
        for &(place, edge, value) in &self.tiles {
            let block = *constants.entry(value.to_bits()).or_insert_with(|| {
                values.resize(values.len() + SparseGrid::BLOCK, value);
                (values.len() / SparseGrid::BLOCK - 1) as u32
            });
            for z in 0..edge {
                for y in 0..edge {
                    let row = index([place[0], place[1] + y, place[2] + z]);
                    table[row..row + edge as usize].fill(block);
                }
            }
        }
        for (&place, &leaf) in &self.leaves {
            table[index(place)] = (values.len() / SparseGrid::BLOCK) as u32;
            for offset in 0..SparseGrid::BLOCK {
                values.push(self.bytes.f32(leaf + 4 * offset)?);
            }
        }
        Ok(SparseGrid {
            index_to_medium,
            bounds,
            origin: first.map(|block| block * 8),
            blocks,
            table: table.into(),
            values: values.into(),
            background: self.background,
        })
    }
}
