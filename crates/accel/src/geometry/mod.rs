//! One file a shape: where a ray meets it, and what the surface is like there.
//!
//! Triangles are tested in `f32`, with `f64` where a sign hangs on it. Curved shapes are computed in `f64` throughout:
//! they are few, and their equations cancel.

pub(crate) mod curve;
pub(crate) mod cylinder;
pub(crate) mod disk;
pub(crate) mod double;
pub(crate) mod patch;
pub(crate) mod quadric;
pub(crate) mod sphere;
pub mod triangle;
