//! Readers of scene files: bytes in, a [`SceneDesc`] and what is wrong with it out.
//!
//! Design decision: a reader never stops at the first error and never fails as a whole. [`Loaded`] always holds a scene,
//! as much of it as could be understood, and [`Diagnostics`] that point into the [`Sources`]; the caller decides, by
//! [`Diagnostics::has_errors`], whether it is fit to be rendered. Whatever a file asks for that Sahl does not do is a
//! warning that says what is done instead: nothing is ignored in silence.
//!
//! Input is taken to be hostile. No declared count is trusted for an allocation, compressed files may not expand beyond
//! reason, inclusion is bounded in depth and number, and messages of one kind are counted after the first few.
//!
//! Deliberately absent: the file system (an [`AssetSource`] stands for it), and anything that knows how to render.
#![forbid(unsafe_code)]

mod assets;
mod blosc;
mod framing;
mod gzip;
mod measured;
mod mtl;
mod nanovdb;
mod normals;
mod obj;
mod pbrt;
mod ply;
mod ptex;
mod subdivision;
mod tensor;
mod words;
mod zlib;

use std::path::Path;

use sahl_scene::{Diagnostic, Diagnostics, SceneDesc, Sources};

pub use assets::{AssetSource, DiskAssets, MemoryAssets};

/// A scene, what is wrong with it, and the texts that the messages point into.
#[derive(Clone, Debug, Default)]
pub struct Loaded {
    /// What could be understood of the scene.
    pub scene: SceneDesc,
    /// What could not, or is rendered otherwise than the file says.
    pub diagnostics: Diagnostics,
    /// The files that were read.
    pub sources: Sources,
}

/// Reads the scene at `path`, in the format that the name's extension tells: `.pbrt`, `.ply` or `.obj`, each also with
/// `.gz` appended.
///
/// A file that cannot be read or has another extension gives an error among the [`Loaded::diagnostics`].
pub fn load(path: &Path, assets: &dyn AssetSource) -> Loaded {
    let bytes = match assets.read(path) {
        Ok(bytes) => bytes,
        Err(error) => {
            let message = format!("can't read `{}`: {}", path.display(), assets::describe(&error));
            return Loaded::failed("unreadable-file", message);
        }
    };
    let name = path.to_string_lossy();
    let lower = name.to_ascii_lowercase();
    match lower.strip_suffix(".gz").unwrap_or(&lower).rsplit_once('.') {
        Some((_, "pbrt")) => pbrt::read(&name, bytes, assets),
        Some((_, "ply")) => ply::load(&name, bytes),
        Some((_, "obj")) => obj::load(&name, bytes, assets),
        _ => Loaded::failed(
            "unknown-format",
            format!("no reader for `{name}`: expected `.pbrt`, `.ply` or `.obj`"),
        ),
    }
}

/// Reads a pbrt-v4 scene from `text`, which may be compressed; `name` is what messages call it.
///
/// The files that it names are looked for beside `name` and then relative to the working directory of `assets`.
pub fn load_pbrt(name: &str, text: Vec<u8>, assets: &dyn AssetSource) -> Loaded {
    pbrt::read(name, text, assets)
}

impl Loaded {
    /// An empty scene with one error about a file as a whole.
    fn failed(code: &'static str, message: String) -> Self {
        let mut loaded = Self::default();
        loaded.diagnostics.push(Diagnostic::error(code, None, message));
        loaded
    }
}
