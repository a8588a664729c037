//! Rendering from a description to an image, through the public interface alone.
#![expect(clippy::unwrap_used, reason = "a test that panics has failed, which is what it is for")]

mod analytic;
mod building;
mod cameras;
mod common;
mod determinism;
mod features;
mod limits;
mod many_lights;
mod media;
mod open_pbr;
mod shapes;
mod spectral;
mod subsurface;
mod terminator;
