//! Embree 4.4, as far as the comparison needs it: triangle meshes, single rays and packets of sixteen.
//!
//! Design decision: the library is loaded at run time from a wheel of PyPI, so that nothing of it is needed to build the
//! project, and called through declarations written by hand ([`ffi`]). That they are right is checked whenever the
//! comparison starts, against a search of all triangles in `f64`.
//!
//! Deliberately absent: instances, other shapes, filters, and whatever else is not compared.
#![expect(unsafe_code, reason = "a foreign library is called")]

mod device;
mod ffi;
mod install;
mod query;
mod scene;

pub(crate) use device::{Device, Embree, Isa, Settings};
pub(crate) use ffi::{INVALID, Ray, RayHit, RayHit16};
pub(crate) use query::{intersect, intersect_packets, occluded, pack, single};
pub(crate) use scene::{Draft, Quality, Scene};
