use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::{ColorMode, MessageArgs, Resolution};

/// Measure: how long a scene takes to load, build and render, or how well its trees work.
#[derive(Debug, Args)]
#[command(after_help = super::EXIT_CODES, args_conflicts_with_subcommands = true)]
pub(crate) struct BenchArgs {
    #[command(subcommand)]
    pub(crate) kind: Option<BenchKind>,
    #[command(flatten)]
    pub(crate) speed: SpeedArgs,
}

/// What is measured.
#[derive(Debug, Subcommand)]
pub(crate) enum BenchKind {
    Bvh(BvhArgs),
}

/// Times of loading, building and rendering, and samples and rays a second on one thread and on all.
#[derive(Debug, Args)]
pub(crate) struct SpeedArgs {
    /// Scene files as for `render`; without one, the built-in Cornell box.
    #[arg(value_name = "SCENE")]
    pub(crate) scenes: Vec<PathBuf>,
    /// Samples a pixel.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) spp: u32,
    /// Most bounces, if not as the scene says.
    #[arg(long, value_name = "N")]
    pub(crate) max_depth: Option<u32>,
    /// Mode of colour, if not as the scene says.
    #[arg(long, value_name = "MODE")]
    pub(crate) color: Option<ColorMode>,
    /// Size of the image, if not as the scene says.
    #[arg(long, value_name = "WxH")]
    pub(crate) resolution: Option<Resolution>,
    /// Print one JSON object.
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) messages: MessageArgs,
}

/// Compare the trees that the median and the SAH builder make of a scene.
///
/// Traces the camera's rays, one through the centre of each pixel, on one thread. A step is a node that is visited or a
/// primitive that is tested. Each tree's steps are drawn as an image in false colours, both to the same scale.
#[derive(Debug, Args)]
pub(crate) struct BvhArgs {
    /// Scene files as for `render`; without one, the built-in Cornell box.
    #[arg(value_name = "SCENE")]
    pub(crate) scenes: Vec<PathBuf>,
    /// Size of the image, if not as the scene says.
    #[arg(long, value_name = "WxH")]
    pub(crate) resolution: Option<Resolution>,
    /// Start of the names of the heat maps: PREFIX-median.png and PREFIX-sah.png. Without it, the scene's name and
    /// `-steps`.
    #[arg(long, short, value_name = "PREFIX")]
    pub(crate) output: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) messages: MessageArgs,
}
