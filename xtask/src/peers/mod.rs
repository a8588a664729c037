//! Sahl against its peers.
//!
//! Design decision: everything is measured in one process on the same rays and meshes, in alternating order, and medians of
//! several rounds are compared; so what disturbs one disturbs all. The last line of the output is meant for machines.

#[cfg(feature = "embree")]
mod builds;
#[cfg(feature = "embree")]
mod check;
#[cfg(feature = "embree")]
mod comparison;
mod lost;
mod models;
mod rays;
mod summary;
mod table;
mod timing;
#[cfg(feature = "embree")]
mod traversal;

use sahl_accel::{Geometry, TriangleMesh, World};

#[cfg(feature = "embree")]
pub(crate) use comparison::run;

/// A world that is one mesh.
fn world(mesh: &TriangleMesh) -> World {
    World { geometries: vec![Geometry::Triangles(mesh.clone())], world: vec![0], ..World::default() }
}
