//! Runs the binary as a user does.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod bench;
mod compare;
mod failures;
mod help;
mod info;
#[cfg(unix)]
mod interrupt;
mod renders;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A folder of its own for one test, empty.
fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("cli").join(test);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// A file of the repository's `scenes`.
fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name)
}

/// `sahl` with `arguments`, in `folder`, without a terminal and without colour.
fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sahl"));
    command.args(arguments).current_dir(folder).stdin(Stdio::null());
    for variable in ["NO_COLOR", "CLICOLOR_FORCE", "COLUMNS"] {
        command.env_remove(variable);
    }
    command
}

fn sahl(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("the process ended by itself")
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// A tiny render of the built-in scene to `name`, which has to succeed.
fn render(folder: &Path, name: &str, more: &[&str]) -> Vec<u8> {
    let mut arguments = vec!["render", "--resolution", "24x24", "--spp", "2", "-o", name];
    arguments.extend(more);
    let output = sahl(folder, &arguments);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    std::fs::read(folder.join(name)).unwrap()
}
