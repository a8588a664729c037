//! The file that a command writes: tried before the work begins, replaced in one step after it.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// A file that was found to be writable.
#[derive(Clone, Debug)]
pub(crate) struct Output {
    /// As it was named.
    name: PathBuf,
    /// Where a link by that name leads to.
    path: PathBuf,
}

impl Output {
    /// Finds out whether `path` can be written, by making a file beside it and removing it again.
    pub(crate) fn check(path: &Path) -> Result<Self, Failure> {
        // The file that a link leads to is replaced, not the link.
        let name = path.to_path_buf();
        let path = fs::canonicalize(path).unwrap_or_else(|_| name.clone());
        if path.is_dir() {
            let error = io::Error::new(io::ErrorKind::IsADirectory, "it is a directory");
            return Err(Failure::file("can't write", &name, &error));
        }
        let output = Self { name, path };
        let trial = output.temporary();
        File::create(&trial)
            .and_then(|_| fs::remove_file(&trial))
            .map_err(|error| Failure::file("can't write", &output.name, &error))?;
        Ok(output)
    }

    /// What it is called.
    pub(crate) fn name(&self) -> &Path {
        &self.name
    }

    /// Refuses to replace one of the files that an image is made from.
    pub(crate) fn spare(&self, inputs: &[PathBuf]) -> Result<(), Failure> {
        let is_same = |input: &PathBuf| fs::canonicalize(input).is_ok_and(|input| input == self.path);
        if !inputs.iter().any(is_same) {
            return Ok(());
        }
        let message = format!("`{}` is a file that the scene is read from", self.name.display());
        Err(Failure::usage(message).with_help("name another one with `-o`"))
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
            Failure::file("can't write", &self.name, &error)
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
        let output = Output::check(&folder.join("./a.png")).unwrap();
        output.write(b"new").unwrap();
        // By whatever name, once it is there.
        let inputs = ["b.png", "../b/a.png", "a.png"].map(|name| folder.join(name));
        assert!(output.spare(&inputs[..2]).is_ok());
        let output = Output::check(&folder.join("./a.png")).unwrap();
        assert_eq!(output.name(), folder.join("./a.png"));
        assert!(output.spare(&inputs).is_err());
        fs::remove_dir_all(&folder).unwrap();
    }
}
