//! The reader of pbrt-v4 scenes, through the crate's interface.

mod invalid;
mod media;
mod robustness;
mod scenes;
mod support;
mod textures;
mod unsupported;
