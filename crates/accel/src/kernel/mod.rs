//! Eight lanes at a time: the instruction sets, and what runs on them: the preparation of rays, and the tests of nodes and triangles.
//!
//! [`isa::Isa`] is what a test asks of an instruction set. The scalar one is the specification; all give the same bits, so
//! that every tier visits the same nodes and returns the same hits.

mod beam;
mod block;
mod bundle;
mod eight_rays;
mod isa;
mod node;
mod pages;
mod prepared;
mod rows;
mod scalar;
mod tier;
mod watertight;

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "aarch64")]
mod neon;
#[cfg(target_arch = "x86_64")]
mod sse2;

pub(crate) use beam::{Beam, BeamEdges, BeamVertices, MAX_GROUPS};
pub(crate) use block::{BLOCK_ROWS, BLOCK_WIDTH, Crossed, EMPTY_BLOCK, TriangleBlock, set_triangle};
pub(crate) use bundle::{BUNDLE_RAYS, BundledBlock, CrossedPairs, Frustum, Loaded, NearestHit, RayBundle};
pub(crate) use eight_rays::PreparedEight;
pub(crate) use isa::{Interval, Isa, Lanes, Octant, Order, Pushed, Row, Task, Window};
pub(crate) use node::{EMPTY_NODE, EXIT_WIDENING, NODE_ROWS, Node, set_child};
pub(crate) use pages::prefer_large_pages;
pub(crate) use prepared::{PreparedRay, limit_of};
pub(crate) use rows::{LINE_ROWS, REFERENCE_SHIFT, Rows, RowsView};
pub(crate) use tier::Machine;
pub use tier::Tier;
#[cfg(test)]
pub(crate) use tier::dispatch;
pub(crate) use watertight::BlockHit;

/// Children of a node, and lanes of every operation.
pub(crate) const WIDTH: usize = 8;

#[cfg(test)]
mod tests;
