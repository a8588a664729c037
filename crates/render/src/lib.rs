//! The renderer: builds a scene description into a [`Scene`], and computes its image.
//!
//! Design decision: three steps that share nothing but values. [`build()`] turns a description into an immutable [`Scene`];
//! [`render`] adds samples to a [`Film`], on all cores, as a pure function of the scene; the film develops into an
//! image. A sample depends on (scene, seed, pixel, sample number) and on nothing else.
//!
//! The modules that are public are the parts that make sense alone, and that the statistical tests reach for:
//! scattering, textures, sampling. Integrators, lights and shapes are reached through a scene.
//!
//! Deliberately absent: files, printing, clocks and entropy.
#![forbid(unsafe_code)]

pub mod bsdf;
pub mod distribution;
pub mod filter;
pub mod material;
pub mod medium;
pub mod sampler;
pub mod spectrum;
pub mod texture;
pub mod warp;

/// Acceleration structures, for those who look into a [`Scene`]'s own or measure it.
pub use sahl_accel as accel;

mod alpha;
mod aov;
mod build;
mod camera;
mod film;
mod integrator;
mod interaction;
mod light;
mod mis;
mod scene;
mod schedule;
mod shape;
mod subsurface;

pub use aov::Aov;
pub use build::{BuildOptions, build};
pub use film::{DroppedSample, Film};
pub use scene::{Sample, Scene, SceneStats};
pub use schedule::{Progress, RenderOptions, Rendered, Status, render};
pub use spectrum::Spectrum;
