//! What moves while the shutter is open: meshes whose vertices go along straight lines.
//!
//! A moving mesh is one leaf of the tree in which it stands, and has a tree of its own: two copies of the same nodes and blocks, one with
//! what is there when the shutter opens, one with what is there when it closes. A ray that visits a node mixes the two by its time. The
//! static trees know nothing of it, and cost nothing more.
//!
//! Vertices and planes of boxes are mixed by the same operations, `a (1 − t) + b t`, with the same rounded weights. As rounding is
//! monotonic and neither weight is negative, a mixed box holds the mixed vertices of what it held at both ends, to the last bit: there is
//! nothing to be widened. And a vertex that triangles share is mixed to the same point for all of them, so that a closed mesh is closed
//! at any time.
//!
//! Source: Christensen, Fong, Laur, Batali, *Ray Tracing for the Movie "Cars"*, Interactive Ray Tracing 2006, for boxes that are
//! interpolated in time.
//!
//! Deliberately absent: moving patches and quadrics, whose motion is that of an instance; vertices on curved paths.

mod mesh;
mod tree;
mod walk;
mod weights;

pub(crate) use mesh::{MovingMesh, usable_triangle};
pub(crate) use tree::MovingTree;
pub(crate) use walk::MovingWalk;
pub(crate) use weights::Weights;
