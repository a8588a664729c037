//! Fetches the library: a wheel of PyPI that contains it, unpacked into the build folder.
//!
//! Code from the network is run, so the wheels are known by their SHA-256 ([`REQUIREMENTS`]), and pip takes no other.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::Result;

/// The wheel, which has the version of Embree that it carries, and its hash on each platform.
const REQUIREMENTS: &str = include_str!("requirements.txt");
/// The Python whose wheels [`REQUIREMENTS`] names, whichever it is that runs pip.
const PYTHON_VERSION: &str = "3.12";
/// The folder of the unpacked wheel.
const FOLDER: &str = "embree-4.4.0.post1-cp312";

/// The library's file; downloads it if it is not there yet.
///
/// # Errors
/// No Python with pip, no network, no wheel for this platform, or one with another hash.
pub(super) fn library() -> Result<PathBuf> {
    let cache = target_folder()?.join("peers");
    let folder = cache.join(FOLDER);
    if !folder.is_dir() {
        install(&cache, &folder)?;
    }
    find(&folder).ok_or_else(|| {
        format!("no Embree library in `{}`; remove that folder to fetch it again", folder.display()).into()
    })
}

/// Where cargo builds: this program lies there, in the folder of its profile.
fn target_folder() -> Result<PathBuf> {
    let program = env::current_exe()?;
    let folder = program.ancestors().nth(2).ok_or("the program lies in no build folder")?;
    Ok(folder.to_owned())
}

/// Downloads and unpacks the wheel beside `folder`, then moves it there, so that `folder` is never half full.
#[expect(clippy::print_stderr, reason = "a download takes a while")]
fn install(cache: &Path, folder: &Path) -> Result<()> {
    eprintln!("fetching Embree from PyPI into {}", folder.display());
    let partial = cache.join(format!("{FOLDER}.partial"));
    if partial.exists() {
        fs::remove_dir_all(&partial)?;
    }
    let wheels = partial.join("wheels");
    fs::create_dir_all(&wheels)?;
    let requirements = partial.join("requirements.txt");
    fs::write(&requirements, REQUIREMENTS)?;
    let mut pip = python();
    pip.args(["-m", "pip", "download", "--require-hashes", "--no-deps", "--only-binary=:all:", "--quiet"])
        .args(["--python-version", PYTHON_VERSION, "-d"])
        .arg(&wheels)
        .arg("-r")
        .arg(&requirements);
    run(pip, "pip could not fetch the wheel")?;
    let wheel = fs::read_dir(&wheels)?.next().ok_or("pip fetched nothing")??.path();
    let unpacked = partial.join("unpacked");
    let mut unzip = python();
    unzip.args(["-m", "zipfile", "-e"]).arg(&wheel).arg(&unpacked);
    run(unzip, "the wheel could not be unpacked")?;
    fs::rename(&unpacked, folder)?;
    fs::remove_dir_all(&partial)?;
    Ok(())
}

fn python() -> Command {
    Command::new(if cfg!(windows) { "python" } else { "python3" })
}

fn run(mut command: Command, failure: &str) -> Result<()> {
    let output = command.output().map_err(|error| {
        format!("can't run `{}`: {error}; Embree is fetched by Python's pip", command.get_program().display())
    })?;
    if !output.status.success() {
        let reason = String::from_utf8_lossy(&output.stderr);
        return Err(format!("{failure}:\n{}", reason.trim()).into());
    }
    Ok(())
}

/// The file in the wheel's folder of libraries whose name says that it is Embree.
fn find(folder: &Path) -> Option<PathBuf> {
    let folders = fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path()).filter(|path| path.is_dir());
    let files = folders.filter_map(|folder| fs::read_dir(folder).ok()).flatten().flatten();
    files.map(|entry| entry.path()).find(|path| {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let library = name.contains(".so") || name.ends_with(".dylib") || name.ends_with(".dll");
        library && name.trim_start_matches("lib").starts_with("embree4")
    })
}
