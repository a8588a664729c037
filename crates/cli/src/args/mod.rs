//! What was typed. What it means is decided in [`crate::settings`] and in the commands.

mod bench;
mod compare;
mod info;
mod render;
mod values;

use clap::{Args as ClapArgs, Parser, Subcommand, ValueEnum};

pub(crate) use bench::{BenchArgs, BenchKind, BvhArgs, SpeedArgs};
pub(crate) use compare::CompareArgs;
pub(crate) use info::InfoArgs;
pub(crate) use render::{AccelName, AovName, ColorMode, CurveName, IntegratorName, ProgressKind, RenderArgs};
pub(crate) use values::{Crop, Definition, Fractions, PixelPosition, Resolution, Seconds};

const EXIT_CODES: &str = "Exit codes: 0 done, 1 rendering failed (or `compare` found a bias), 2 usage, \
    3 the scene has errors, 4 a file can't be read or written, 130 interrupted (the image so far was written).";

/// Sahl, a physically based renderer.
#[derive(Debug, Parser)]
#[command(name = "sahl", version, after_help = EXIT_CODES, disable_help_subcommand = true, max_term_width = 100)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Render(Box<RenderArgs>),
    Info(InfoArgs),
    Compare(CompareArgs),
    Bench(BenchArgs),
}

/// What every command that reads a scene knows.
#[derive(Debug, ClapArgs)]
pub(crate) struct MessageArgs {
    /// Treat warnings about the scene as errors.
    #[arg(long, help_heading = "Messages")]
    pub(crate) strict: bool,
    /// Print errors only: no warnings, no progress, no summary.
    #[arg(long, short, help_heading = "Messages")]
    pub(crate) quiet: bool,
    /// How messages about the scene are printed: for people, or one JSON object a line.
    #[arg(long, value_name = "FORM", default_value = "text", help_heading = "Messages")]
    pub(crate) diagnostics: DiagnosticsForm,
}

/// How messages about the scene are printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum DiagnosticsForm {
    Text,
    Json,
}
