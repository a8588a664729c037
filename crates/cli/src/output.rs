//! The file that a command writes: tried before the work begins, replaced in one step after it.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// A file that was found to be writable.
#[derive(Clone, Debug)]
pub(crate) struct Output {
    path: PathBuf,
}

impl Output {
    /// Finds out whether `path` can be written, by making a file beside it and removing it again.
    pub(crate) fn check(path: &Path) -> Result<Self, Failure> {
        // The file that a link leads to is replaced, not the link.
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        if path.is_dir() {
            let error = io::Error::new(io::ErrorKind::IsADirectory, "it is a directory");
            return Err(Failure::file("can't write", &path, &error));
        }
        let output = Self { path };
        let trial = output.temporary();
        File::create(&trial)
            .and_then(|_| fs::remove_file(&trial))
            .map_err(|error| Failure::file("can't write", &output.path, &error))?;
        Ok(output)
    }

    /// Where it goes.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Replaces the file by `bytes`: whoever reads it sees the old file or the new one, never half of one.
    pub(crate) fn write(&self, bytes: &[u8]) -> Result<(), Failure> {
        let temporary = self.temporary();
        let write = || {
            let mut file = File::create(&temporary)?;
            file.write_all(bytes)?;
            file.sync_all()?;
            fs::rename(&temporary, &self.path)
        };
        write().map_err(|error| {
            // What is left of it is of no use to anyone; the first error is the one to tell.
            let _ = fs::remove_file(&temporary);
            Failure::file("can't write", &self.path, &error)
        })
    }

    /// A name in the same folder, so that renaming it does not copy, and with the process in it, so that two renders
    /// to one file do not mix.
    fn temporary(&self) -> PathBuf {
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        self.path.with_file_name(format!(".{name}.{}.part", std::process::id()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("sahl-output-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[test]
    fn a_file_is_replaced_and_nothing_is_left_beside_it() {
        let folder = folder("replace");
        let path = folder.join("a.png");
        fs::write(&path, b"old").unwrap();
        let output = Output::check(&path).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        output.write(b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn what_can_t_be_written_is_found_at_once() {
        let folder = folder("check");
        assert!(Output::check(&folder.join("missing/a.png")).is_err());
        assert!(Output::check(&folder).is_err());
        fs::remove_dir_all(&folder).unwrap();
    }
}
