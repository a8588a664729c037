//! The reader of pbrt-v4 scenes, through the crate's interface.

mod cameras;
mod invalid;
mod measured;
mod media;
mod open_pbr;
mod robustness;
mod scenes;
mod subsurface;
mod support;
mod textures;
mod unsupported;
