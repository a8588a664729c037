//! The scenes of the repository, in memory, so that paths in messages are the same everywhere.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use sahl_load::MemoryAssets;

/// The directory of the test scenes.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/tests")
}

/// Every file below `directory`, relative to [`root`], in order.
pub(crate) fn files_below(directory: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![root().join(directory)];
    while let Some(directory) = open.pop() {
        for entry in std::fs::read_dir(&directory).expect("the directory is part of the repository") {
            let path = entry.expect("directories can be listed").path();
            if path.is_dir() {
                open.push(path);
            } else {
                found.push(path.strip_prefix(root()).expect("found below the root").to_path_buf());
            }
        }
    }
    found.sort();
    found
}

/// The test scenes with everything they name.
pub(crate) fn assets() -> &'static MemoryAssets {
    static ASSETS: LazyLock<MemoryAssets> = LazyLock::new(|| {
        let mut assets = MemoryAssets::default();
        for directory in VALID.iter().chain(&["assets", "invalid"]) {
            for path in files_below(directory) {
                let bytes = std::fs::read(root().join(&path)).expect("listed files can be read");
                assets.insert(&path, bytes);
            }
        }
        assets
    });
    &ASSETS
}

/// The pbrt scenes directly in the directories `directories`.
pub(crate) fn scenes(directories: &[&str]) -> Vec<PathBuf> {
    let is_scene = |path: &PathBuf| {
        let name = path.to_string_lossy();
        name.ends_with(".pbrt") || name.ends_with(".pbrt.gz")
    };
    let mut found = Vec::new();
    for directory in directories {
        let files = files_below(directory).into_iter();
        found.extend(files.filter(is_scene).filter(|path| path.parent() == Some(Path::new(directory))));
    }
    found
}

/// The directories of valid scenes that this crate's tests own.
pub(crate) const VALID: &[&str] =
    &["cameras", "film", "lights", "materials", "shapes", "structure", "textures"];
