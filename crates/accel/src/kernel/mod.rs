//! Four lanes at a time: the vector type and the two tests that run on it.
//!
//! Each processor family has its own implementation of [`F32x4`]; the scalar one is the specification, and what other
//! processors run. All give the same bits.

mod block;
mod node;
mod scalar;
#[cfg(target_arch = "x86_64")]
mod sse2;

pub(crate) use block::{BLOCK_WIDTH, TriangleBlock};
pub(crate) use node::{EXIT_WIDENING, Node, NodeHits, NodeRay, WIDTH};

#[cfg(not(target_arch = "x86_64"))]
pub(crate) use scalar::F32x4;
#[cfg(target_arch = "x86_64")]
pub(crate) use sse2::F32x4;
