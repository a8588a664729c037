use std::path::PathBuf;

use clap::Args;

use super::MessageArgs;

/// Tell what is in a scene: counts, memory, lights, warnings.
#[derive(Debug, Args)]
#[command(after_help = super::EXIT_CODES)]
pub(crate) struct InfoArgs {
    /// Scene files as for `render`; without one, the built-in Cornell box.
    #[arg(value_name = "SCENE")]
    pub(crate) scenes: Vec<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) messages: MessageArgs,
}
