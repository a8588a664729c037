//! `cargo xtask`: tasks of the project itself.
//!
//! Design decision: what needs more than cargo can say is a program of the workspace, not a script, so that it runs wherever
//! the project builds and is checked as the rest of the code is.
//!
//! Deliberately absent: anything that a user of Sahl needs.

mod args;
#[cfg(feature = "embree")]
mod embree;
#[cfg(any(feature = "embree", test))]
#[cfg_attr(not(feature = "embree"), expect(dead_code, reason = "tests alone use it without the feature"))]
mod peers;
mod uplift;

use std::error::Error;
use std::process::ExitCode;

use clap::Parser;

use args::{Args, Command, Peers};

/// What a task returns: the message is all that a person needs of an error.
type Result<T, E = Box<dyn Error>> = std::result::Result<T, E>;

#[expect(clippy::print_stderr, reason = "a program tells its errors")]
fn main() -> ExitCode {
    let args = Args::parse();
    let result = match &args.command {
        Command::Peers { what: Peers::Accel(args) } => compare_accel(args),
        Command::Uplift { data } => uplift::run(data),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(feature = "embree")]
fn compare_accel(args: &args::AccelArgs) -> Result<()> {
    peers::run(args)
}

#[cfg(not(feature = "embree"))]
fn compare_accel(_args: &args::AccelArgs) -> Result<()> {
    Err("the comparison needs the feature `embree`; `cargo xtask` turns it on".into())
}
