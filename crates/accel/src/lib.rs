//! Acceleration structures: geometry in, hits out.
//!
//! Design decision: an [`Accel`] is two levels of trees built from plain values, a [`World`], and it answers rays
//! with indices into them. It knows shapes, and nothing of what they look like. Its layout and traversal are private, so
//! that they may change with every processor generation while the queries stay: one ray or a slice of them, nearest
//! hit or any.
//!
//! Triangles, and patches that are flat, are copied into blocks of eight and tested eight at a time by the watertight test of
//! [`triangle`]. Boxes are tested conservatively. So no ray slips between two triangles that share an edge, and there is no
//! epsilon anywhere: surface points carry error bounds, and rays that start outside them do not meet their own
//! surface.
//!
//! What moves while the shutter is open, meshes and instances, stands in the same world: rays carry a time, and meet it where it is then.
//!
//! Deliberately absent: materials, textures, and any dependency on the rest of a renderer.
//!
//! ```
//! use sahl_accel::{Accel, BuildOptions, Geometry, TriangleMesh, World};
//! use sahl_math::{Ray, Vec3};
//!
//! let mesh = TriangleMesh { indices: [[0, 1, 2]].into(), positions: [Vec3::ZERO, Vec3::X, Vec3::Y].into() };
//! let world = World { geometries: vec![Geometry::Triangles(mesh)], world: vec![0], ..World::default() };
//! let accel = Accel::build(world, &BuildOptions::default());
//! let hit = accel.intersect(&Ray::new(Vec3::new(0.25, 0.25, 1.0), -Vec3::Z)).unwrap();
//! assert_eq!((hit.t, hit.geometry, hit.primitive), (1.0, 0, 0));
//! ```

mod accel;
mod assembly;
mod build;
mod filter;
mod geometry;
mod hit;
mod instance;
mod kernel;
mod layout;
mod motion;
mod names;
mod options;
mod primitive;
mod refit;
mod stats;
mod surface;
mod traverse;
mod vertices;
mod world;

pub use accel::Accel;
pub use geometry::triangle;
pub use hit::{Hit, SurfacePoint};
pub use kernel::Tier;
pub use options::{BuildOptions, Builder};
pub use refit::{Edit, Refit, UnfitEdit};
pub use stats::Stats;
pub use traverse::TraversalCount;
pub use world::{
    CurveKind, CurveSet, Cylinder, Disk, Geometry, Instance, MovingTriangleMesh, PatchMesh, Placement,
    Sphere, TriangleMesh, World,
};
