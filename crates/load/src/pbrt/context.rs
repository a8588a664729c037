//! What every translator of a plugin works on: the scene so far, the names defined in it, and the files around it.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use sahl_scene::{Diagnostic, Handle, MeasuredBrdf, PatchMesh, SceneDesc, Span, Texture, TriangleMesh};

use super::report::{Report, quote};
use super::statement::Name;
use super::translate::image::ImageCache;
use crate::assets::{describe, normalized};
use crate::{AssetSource, gzip};

/// The scene so far, with what is needed to go on.
pub(super) struct Context<'a> {
    pub(super) report: Rc<Report>,
    pub(super) scene: SceneDesc,
    pub(super) files: Files<'a>,
    /// Textures of numbers by name.
    pub(super) float_textures: BTreeMap<String, Handle<Texture>>,
    /// Textures of spectra by name.
    pub(super) spectrum_textures: BTreeMap<String, Handle<Texture>>,
    pub(super) images: ImageCache,
    /// Meshes of files by their paths.
    pub(super) meshes: BTreeMap<PathBuf, MeshFile>,
    /// Measured surfaces of files by their paths.
    pub(super) measurements: RefCell<BTreeMap<PathBuf, Arc<MeasuredBrdf>>>,
}

/// What a mesh file holds.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MeshFile {
    pub(super) triangles: Option<Handle<TriangleMesh>>,
    pub(super) patches: Option<Handle<PatchMesh>>,
}

/// The files that a scene can name.
pub(super) struct Files<'a> {
    assets: &'a dyn AssetSource,
    /// The directory of the first scene file.
    base: PathBuf,
}

impl<'a> Files<'a> {
    /// Files named relative to the directory of the file `first`.
    pub(super) fn beside(first: &str, assets: &'a dyn AssetSource) -> Self {
        let base = Path::new(first).parent().map(Path::to_path_buf).unwrap_or_default();
        Self { assets, base }
    }

    /// The places where the file called `name` may be, the likeliest first.
    pub(super) fn candidates(&self, name: &str) -> Vec<PathBuf> {
        let beside = normalized(&self.base.join(name));
        let plain = normalized(Path::new(name));
        if beside == plain { vec![plain] } else { vec![beside, plain] }
    }

    /// The path at which the file called `name` was found, and its bytes, decompressed.
    pub(super) fn read(&self, name: &str) -> Result<(PathBuf, Vec<u8>), String> {
        for path in self.candidates(name) {
            match self.assets.read(&path) {
                Ok(bytes) => {
                    let bytes = gzip::decompress(bytes).map_err(|error| error.to_string())?;
                    return Ok((path, bytes));
                }
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => return Err(describe(&error)),
            }
        }
        Err("no such file".to_owned())
    }
}

impl Context<'_> {
    /// Reads the file called `name`; if that fails, says so there.
    pub(super) fn read_file(&self, name: &Name) -> Option<(PathBuf, Vec<u8>)> {
        if name.text.is_empty() {
            self.report.error("unreadable-file", name.span, "the name of a file is empty");
            return None;
        }
        match self.files.read(&name.text) {
            Ok(found) => Some(found),
            Err(error) => {
                self.unreadable(name.span, &name.text, &error);
                None
            }
        }
    }

    /// Reports a file that could not be read.
    pub(super) fn unreadable(&self, span: Span, name: &str, error: &str) {
        let message = format!("can't read {}: {error}", quote(name.as_bytes()));
        let diagnostic = Diagnostic::error("unreadable-file", span, message);
        let candidates = self.files.candidates(name);
        if candidates.iter().all(|path| path == Path::new(name)) {
            // The message says it already.
            self.report.push(diagnostic);
            return;
        }
        let places: Vec<String> = candidates.iter().map(|path| format!("`{}`", path.display())).collect();
        self.report.push(diagnostic.with_note(format!("looked for {}", places.join(" and "))));
    }
}
