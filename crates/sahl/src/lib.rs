//! Sahl, a physically based renderer: load a scene, build it, render it, develop the image.
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use sahl::image::{EncodeOptions, Format};
//!
//! let mut description = sahl::cornell_box().scene; // or sahl::load("scene.pbrt")?.scene
//! description.film.resolution = [32, 32];
//! description.sampler.samples = 4;
//!
//! let scene = sahl::build(&description)?;
//! let film = sahl::render(&scene);
//! let image = sahl::develop(&film);
//! let png = image.encode(Format::Png, &EncodeOptions::default())?;
//! assert!(png.starts_with(b"\x89PNG"));
//! # Ok(())
//! # }
//! ```
//!
//! The four calls take the usual way. Whoever needs more (progress, a stop, layers, files from memory, warnings) goes
//! through the namespaces, which are whole crates: [`scene`](mod@scene) is the description as plain data,
//! [`load`](mod@load) reads it from files, [`render`](mod@render) makes the image, [`image`](mod@image) holds, writes
//! and compares pictures, [`math`](mod@math) is what they share.
//!
//! Deliberately absent: a prelude (a name's path tells what it depends on), and writing to files or to the terminal,
//! which is the caller's.
#![forbid(unsafe_code)]

#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;

mod cornell_box;
mod error;

use std::path::Path;

#[doc(no_inline)]
pub use sahl_image as image;
#[doc(no_inline)]
pub use sahl_load as load;
#[doc(no_inline)]
pub use sahl_math as math;
#[doc(no_inline)]
pub use sahl_render as render;
#[doc(no_inline)]
pub use sahl_scene as scene;

pub use cornell_box::cornell_box;
pub use error::SceneError;

use image::Image;
use load::{DiskAssets, Loaded};
use render::{Film, RenderOptions, Scene};
use scene::SceneDesc;

/// Reads a scene from a file: `.pbrt`, `.obj` or `.ply`, each also compressed as `.gz`.
///
/// What the scene asks for and Sahl does otherwise is a warning among the result's `diagnostics`.
///
/// # Errors
/// The file, or one that it names, can't be read or has errors; all of them are told.
pub fn load(path: impl AsRef<Path>) -> Result<Loaded, SceneError> {
    let loaded = load::load(path.as_ref(), &DiskAssets);
    if loaded.diagnostics.has_errors() {
        return Err(SceneError::new(loaded.diagnostics, loaded.sources));
    }
    Ok(loaded)
}

/// Makes a scene ready to be rendered. Warnings are dropped; [`render::build`] returns them.
///
/// # Errors
/// The description contradicts itself, such as a shape whose material is missing.
pub fn build(description: &SceneDesc) -> Result<Scene, SceneError> {
    let (scene, diagnostics) = render::build(description, &render::BuildOptions::default());
    scene.ok_or_else(|| SceneError::new(diagnostics, scene::Sources::default()))
}

/// Renders on all cores; the film is the same on any number of them. [`render::render`] takes options, tells its
/// progress and can be stopped.
pub fn render(scene: &Scene) -> Film {
    render::render(scene, &RenderOptions::default(), &()).film
}

/// The image on the film: linear RGB in the film's colour space. Encoding it as PNG or PPM applies the tone mapping.
pub fn develop(film: &Film) -> Image {
    film.develop()
}
