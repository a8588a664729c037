//! Values in space.

use std::sync::Arc;

use sahl_math::{Bounds3, Transform};
use serde::{Deserialize, Serialize};

/// A box in a space of its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// The box.
    pub bounds: Bounds3,
    /// From the space of the box to the world.
    pub medium_to_world: Transform,
}

/// Values at the centres of the cells into which a box is divided; zero outside the box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grid<T> {
    /// Cells along x, y and z.
    pub resolution: [u32; 3],
    /// Their values; x varies fastest, z slowest.
    pub values: Arc<[T]>,
}

impl<T> Grid<T> {
    /// Whether there is one value for each cell, and a cell.
    pub fn is_complete(&self) -> bool {
        let [x, y, z] = self.resolution.map(u64::from);
        x.checked_mul(y).and_then(|xy| xy.checked_mul(z)) == Some(self.values.len() as u64)
            && !self.values.is_empty()
    }
}

/// Values at the points of an integer lattice, kept in blocks of 8³: where no block is, the background.
///
/// This is the content of an OpenVDB or NanoVDB grid, whose tree is flattened into one table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SparseGrid {
    /// From the lattice to the space of the medium.
    pub index_to_medium: Transform,
    /// The box that is to be rendered, in the space of the medium.
    pub bounds: Bounds3,
    /// The lattice point at the lowest corner of the table; multiples of 8.
    pub origin: [i32; 3],
    /// Blocks along x, y and z.
    pub blocks: [u32; 3],
    /// For each block its number among `values`, or [`SparseGrid::NO_BLOCK`]; x varies fastest.
    pub table: Arc<[u32]>,
    /// 512 values a block; z varies fastest.
    pub values: Arc<[f32]>,
    /// The value where no block is.
    pub background: f32,
}

impl SparseGrid {
    /// Stands for a block of nothing but background.
    pub const NO_BLOCK: u32 = u32::MAX;

    /// Values in a block.
    pub const BLOCK: usize = 512;

    /// Whether the table has one entry for each block, each leads to values, and lattice points fit 32 bits.
    pub fn is_complete(&self) -> bool {
        let [x, y, z] = self.blocks.map(u64::from);
        let count = (self.values.len() / Self::BLOCK) as u64;
        x.checked_mul(y).and_then(|xy| xy.checked_mul(z)) == Some(self.table.len() as u64)
            && self.values.len().is_multiple_of(Self::BLOCK)
            && (0..3).all(|axis| {
                i64::from(self.origin[axis]) + 8 * i64::from(self.blocks[axis]) <= i64::from(i32::MAX) + 1
            })
            && self.table.iter().all(|&block| block == Self::NO_BLOCK || u64::from(block) < count)
    }
}
