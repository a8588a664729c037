//! Where the bytes of a scene's files come from.
//!
//! Design decision: the readers never touch the file system. They ask an [`AssetSource`], so that a scene can come from
//! a disk, from memory, from an archive or from a test, and so that whoever embeds Sahl decides what a scene may read.

use std::collections::BTreeMap;
use std::io;
use std::path::{Component, Path, PathBuf};

/// A place to read files from.
pub trait AssetSource {
    /// The bytes of the file at `path`, compressed or not as they are stored.
    ///
    /// # Errors
    /// [`io::ErrorKind::NotFound`] if there is no such file, which lets a reader look for it elsewhere; any other error
    /// ends the search.
    fn read(&self, path: &Path) -> io::Result<Vec<u8>>;
}

/// The file system, relative to the working directory.
#[derive(Clone, Copy, Debug, Default)]
pub struct DiskAssets;

impl AssetSource for DiskAssets {
    /// Reads regular files only: a device or a pipe named by a scene could go on for ever.
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        let kind = std::fs::metadata(path)?;
        if kind.is_dir() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a directory"));
        }
        if !kind.is_file() {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file"));
        }
        std::fs::read(path)
    }
}

/// Files held in memory, by their paths.
#[derive(Clone, Debug, Default)]
pub struct MemoryAssets {
    files: BTreeMap<PathBuf, Vec<u8>>,
}

impl MemoryAssets {
    /// Adds a file, or replaces the one at `path`.
    pub fn insert(&mut self, path: impl AsRef<Path>, bytes: impl Into<Vec<u8>>) {
        self.files.insert(normalized(path.as_ref()), bytes.into());
    }
}

impl AssetSource for MemoryAssets {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        let missing = || io::Error::new(io::ErrorKind::NotFound, "no such file");
        self.files.get(&normalized(path)).cloned().ok_or_else(missing)
    }
}

/// What a message says about a file that can't be read: the same on every system, where that matters.
pub(crate) fn describe(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "no such file".to_owned(),
        io::ErrorKind::PermissionDenied => "permission denied".to_owned(),
        _ => error.to_string(),
    }
}

/// The path without `.` and, where a directory precedes it, without `..`: one spelling for one file.
///
/// Purely by name, so that `link/..` is taken for the directory that holds `link`.
pub(crate) fn normalized(path: &Path) -> PathBuf {
    let mut result = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if matches!(result.components().next_back(), Some(Component::Normal(_))) => {
                result.pop();
            }
            other => result.push(other),
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_files_are_found_by_any_spelling() {
        let mut assets = MemoryAssets::default();
        assets.insert("scenes/./a.pbrt", *b"x");
        assert_eq!(assets.read(Path::new("scenes/sub/../a.pbrt")).unwrap(), b"x");
        assert_eq!(assets.read(Path::new("b.pbrt")).unwrap_err().kind(), io::ErrorKind::NotFound);
    }

    #[test]
    fn leading_parents_stay() {
        assert_eq!(normalized(Path::new("../a/../../b")), Path::new("../../b"));
        assert_eq!(normalized(Path::new("/a/./b/..")), Path::new("/a"));
    }

    #[test]
    fn directories_are_no_files() {
        assert!(DiskAssets.read(Path::new(env!("CARGO_MANIFEST_DIR"))).is_err());
    }
}
