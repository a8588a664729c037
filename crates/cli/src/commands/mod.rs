//! The subcommands.

pub(crate) mod bench;
mod bench_bvh;
pub(crate) mod compare;
pub(crate) mod info;
pub(crate) mod render;

use std::io::{self, Write};
use std::path::Path;

use crate::failure::Failure;

/// Prints a result. Whoever closed the pipe has seen enough.
fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::file("can't write", Path::new("the standard output"), &error))
        }
        _ => Ok(()),
    }
}
