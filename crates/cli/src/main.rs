//! `sahl`: the command line.
//!
//! Design decision: what was typed ([`args`]) is kept apart from what it means ([`settings`], [`commands`]), so that
//! aliases, defaults and conflicts are settled in one place before any work begins. Results go to the standard output,
//! everything else to the standard error; the exit code tells what went wrong ([`failure::Reason`]).
//!
//! Deliberately absent: rendering, file formats and the meaning of scenes, which are the library's.
#![forbid(unsafe_code)]

mod args;
mod commands;
mod console;
mod failure;
mod format;
mod interrupt;
mod memory;
mod output;
mod progress;
mod settings;
mod source;

use std::process::ExitCode;

use clap::Parser;

use args::{Args, BenchKind, Command, ProgressKind};
use console::Console;

fn main() -> ExitCode {
    let args = Args::parse();
    let console = console_of(&args.command);
    let result = match &args.command {
        Command::Render(args) => commands::render::run(args, console),
        Command::Info(args) => commands::info::run(args, console),
        Command::Compare(args) => commands::compare::run(args),
        Command::Bench(args) => commands::bench::run(args, console),
    };
    result.unwrap_or_else(|failure| {
        console.failure(&failure);
        failure.reason.into()
    })
}

fn console_of(command: &Command) -> Console {
    match command {
        Command::Render(args) => Console::new(&args.messages, args.work.progress == ProgressKind::Json),
        Command::Info(args) => Console::new(&args.messages, false),
        Command::Compare(_) => Console::plain(),
        Command::Bench(args) => match &args.kind {
            Some(BenchKind::Bvh(args)) => Console::new(&args.messages, false),
            None => Console::new(&args.speed.messages, false),
        },
    }
}
