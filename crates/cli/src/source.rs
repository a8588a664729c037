//! The scene that a command works on: files, the standard input, or the built-in one.

use std::cell::RefCell;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use sahl::load::{AssetSource, DiskAssets, Loaded};
use sahl::render::{BuildOptions, Scene};
use sahl::scene::{Diagnostics, Severity};

use crate::console::Console;
use crate::failure::{Failure, Reason};
use crate::format::plural;

/// A scene with a name for people.
pub(crate) struct Source {
    /// What messages call it.
    pub(crate) name: String,
    /// What files made from it are called, without an extension.
    pub(crate) stem: String,
    /// The scene, and what is wrong with it that was not reported yet.
    pub(crate) loaded: Loaded,
    /// All files that were read for it.
    pub(crate) files: Vec<PathBuf>,
    /// Warnings that were reported.
    pub(crate) warnings: usize,
}

/// The file system, with a list of what was read.
#[derive(Debug, Default)]
struct Recorded(RefCell<Vec<PathBuf>>);

impl AssetSource for Recorded {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        let bytes = DiskAssets.read(path)?;
        self.0.borrow_mut().push(path.to_path_buf());
        Ok(bytes)
    }
}

impl Source {
    /// Reads the scene. What is wrong in it is in the result; an error is only a file that can't be read.
    pub(crate) fn load(scenes: &[PathBuf]) -> Result<Self, Failure> {
        match scenes {
            [] => {
                let loaded = sahl::cornell_box();
                Ok(Self::new("the built-in Cornell box", "cornell-box", loaded, Recorded::default()))
            }
            [path] if is_standard_input(path) => {
                let mut text = Vec::new();
                io::stdin()
                    .read_to_end(&mut text)
                    .map_err(|error| Failure::file("can't read", Path::new("the standard input"), &error))?;
                let assets = Recorded::default();
                let loaded = sahl::load::load_pbrt("<stdin>", text, &assets);
                Ok(Self::new("<stdin>", "stdin", loaded, assets))
            }
            [path] => {
                readable(path)?;
                let assets = Recorded::default();
                let loaded = sahl::load::load(path, &assets);
                Ok(Self::new(&path.display().to_string(), &stem(path), loaded, assets))
            }
            several => Self::load_several(several),
        }
    }

    fn new(name: &str, stem: &str, loaded: Loaded, assets: Recorded) -> Self {
        let files = assets.0.into_inner();
        Self { name: name.to_owned(), stem: stem.to_owned(), loaded, files, warnings: 0 }
    }

    /// Reads pbrt files one after the other as one scene, as pbrt does: as if another file included each of them.
    fn load_several(paths: &[PathBuf]) -> Result<Self, Failure> {
        let first = &paths[0];
        for path in paths {
            let name = path.to_string_lossy().to_ascii_lowercase();
            if !name.ends_with(".pbrt") && !name.ends_with(".pbrt.gz") {
                let message =
                    format!("`{}` is not a pbrt file: only those can be read as one scene", path.display());
                return Err(Failure::usage(message));
            }
            readable(path)?;
        }
        let mut includes = String::new();
        for path in paths {
            let absolute =
                std::path::absolute(path).map_err(|error| Failure::file("can't read", path, &error))?;
            let quoted = absolute.to_string_lossy().replace('\\', "\\\\").replace('"', "\\\"");
            let _ = writeln!(includes, "Include \"{quoted}\"");
        }
        // The text stands beside the first file, so that names in all of them are looked for there.
        let name = first.with_file_name("<command line>");
        let assets = Recorded::default();
        let loaded = sahl::load::load_pbrt(&name.to_string_lossy(), includes.into_bytes(), &assets);
        Ok(Self::new(&first.display().to_string(), &stem(first), loaded, assets))
    }

    /// Prints what is wrong so far; warnings count as errors if `strict`.
    pub(crate) fn report(&mut self, strict: bool, console: &Console) -> Result<(), Failure> {
        let mut diagnostics = std::mem::take(&mut self.loaded.diagnostics);
        if strict {
            diagnostics.promote_warnings();
        }
        console.diagnostics(&diagnostics, &self.loaded.sources);
        self.warnings += diagnostics.iter().filter(|entry| entry.severity == Severity::Warning).count();
        self.failure(&diagnostics, strict).map_or(Ok(()), Err)
    }

    /// Builds the scene and prints what is wrong with it.
    pub(crate) fn build(
        &mut self,
        options: &BuildOptions,
        strict: bool,
        console: &Console,
    ) -> Result<Scene, Failure> {
        let (scene, diagnostics) = sahl::render::build(&self.loaded.scene, options);
        self.loaded.diagnostics = diagnostics;
        self.report(strict, console)?;
        let message = format!("`{}` can't be built", self.name);
        scene.ok_or_else(|| Failure::new(Reason::Scene, message))
    }

    fn failure(&self, diagnostics: &Diagnostics, strict: bool) -> Option<Failure> {
        let errors = diagnostics.iter().filter(|entry| entry.severity == Severity::Error).count();
        if errors == 0 {
            return None;
        }
        let how = if strict { ", counting warnings (`--strict`)" } else { "" };
        let message = format!("`{}` has {}{how}", self.name, plural(errors, "error"));
        Some(Failure::new(Reason::Scene, message))
    }
}

fn is_standard_input(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// A file that can't be opened is not an error of the scene.
fn readable(path: &Path) -> Result<(), Failure> {
    let failed = |error: &io::Error| Failure::file("can't read", path, error);
    let file = File::open(path).map_err(|error| failed(&error))?;
    if file.metadata().map_err(|error| failed(&error))?.is_dir() {
        return Err(failed(&io::Error::new(io::ErrorKind::IsADirectory, "it is a directory")));
    }
    Ok(())
}

/// The file's name without its extension, and without the one before `.gz`.
fn stem(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    let stem = Path::new(name).file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_named_after_the_scene() {
        assert_eq!(stem(Path::new("a/kitchen.pbrt")), "kitchen");
        assert_eq!(stem(Path::new("kitchen.v2.pbrt.gz")), "kitchen.v2");
        assert_eq!(stem(Path::new("bunny")), "bunny");
    }
}
