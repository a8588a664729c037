use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{Crop, Definition, Fractions, MessageArgs, PixelPosition, Resolution, Seconds};

/// Render a scene; without one, the built-in Cornell box.
///
/// What is not given here is as the scene says.
#[derive(Debug, Args)]
#[command(after_help = super::EXIT_CODES)]
pub(crate) struct RenderArgs {
    /// Scene files: .pbrt, .obj or .ply, each also with .gz, or `-` for pbrt text from the standard input. Several pbrt
    /// files are read as one.
    #[arg(value_name = "SCENE")]
    pub(crate) scenes: Vec<PathBuf>,
    /// The image to write: .exr, .hdr and .pfm hold light, .png and .ppm hold 8-bit pictures. Without it, the name
    /// that the scene asks for, else the scene's own name with .exr.
    #[arg(long, short, value_name = "FILE", visible_alias = "outfile")]
    pub(crate) output: Option<PathBuf>,
    /// Set a value as Mitsuba does; keys: spp, seed, threads, width, height, integrator, max_depth, time.
    #[arg(short = 'D', value_name = "KEY=VALUE")]
    pub(crate) definitions: Vec<Definition>,

    #[command(flatten)]
    pub(crate) sampling: SamplingArgs,
    #[command(flatten)]
    pub(crate) frame: FrameArgs,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
    #[command(flatten)]
    pub(crate) work: WorkArgs,
    #[command(flatten)]
    pub(crate) messages: MessageArgs,
    #[command(flatten)]
    pub(crate) absent: AbsentArgs,
}

/// How light is computed.
#[derive(Debug, Args)]
#[command(next_help_heading = "Light")]
pub(crate) struct SamplingArgs {
    /// Samples a pixel.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) spp: Option<u32>,
    /// Different seeds give independent images.
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
    /// Light transport algorithm.
    #[arg(long, value_name = "NAME")]
    pub(crate) integrator: Option<IntegratorName>,
    /// Most bounces: 0 shows lamps only, 1 adds direct light.
    #[arg(long, value_name = "N")]
    pub(crate) max_depth: Option<u32>,
    /// Limit each contribution of indirect light: fewer fireflies, darker images.
    #[arg(long, value_name = "LIMIT")]
    pub(crate) clamp_indirect: Option<f32>,
    /// See mirrors as rougher by light that was spread before: less noise, softer caustics.
    #[arg(long)]
    pub(crate) regularize: bool,
    /// Light meshes as the smooth surfaces that their normals stand for: no facets where light grazes.
    #[arg(long)]
    pub(crate) smooth_terminator: bool,
    /// Carry colour as sampled wavelengths or as RGB, if not as the scene says: pbrt files spectral, others RGB.
    #[arg(long, value_name = "MODE")]
    pub(crate) color: Option<ColorMode>,
    /// Stop after this time with the image so far: seconds, or a number with `s`, `m` or `h`.
    #[arg(long, value_name = "TIME")]
    pub(crate) time: Option<Seconds>,
    /// Render this pixel only and print its value and its samples; writes no image.
    #[arg(long, value_name = "X,Y", conflicts_with_all = ["output", "time", "aov"])]
    pub(crate) pixel: Option<PixelPosition>,
}

/// What part of the scene the image shows.
#[derive(Debug, Args)]
#[command(next_help_heading = "Frame")]
pub(crate) struct FrameArgs {
    /// Size of the full image in pixels. A crop of the scene keeps its place in the picture.
    #[arg(long, value_name = "WxH")]
    pub(crate) resolution: Option<Resolution>,
    /// Render these pixels only; the maxima are exclusive.
    #[arg(long, value_name = "X0,X1,Y0,Y1", visible_alias = "pixelbounds")]
    pub(crate) crop: Option<Crop>,
    /// Render this part only, in shares of the width and the height.
    #[arg(long, value_name = "X0,X1,Y0,Y1", conflicts_with = "crop")]
    pub(crate) cropwindow: Option<Fractions>,
    /// Which of the scene's cameras, counted from 0.
    #[arg(long, value_name = "N")]
    pub(crate) camera: Option<u32>,
}

/// How the image is written.
#[derive(Debug, Args)]
#[command(next_help_heading = "Picture")]
pub(crate) struct PictureArgs {
    /// More layers for .exr, separated by commas.
    #[arg(long, value_name = "LAYERS", value_delimiter = ',')]
    pub(crate) aov: Vec<AovName>,
    /// Brighten by this many stops (.png and .ppm).
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true)]
    pub(crate) exposure: Option<f32>,
    /// How light becomes an 8-bit value (.png and .ppm) [default: srgb]
    #[arg(long, value_name = "CURVE")]
    pub(crate) tonemap: Option<CurveName>,
}

/// How the work is done. None of this changes the image.
#[derive(Debug, Args)]
#[command(next_help_heading = "Work")]
pub(crate) struct WorkArgs {
    /// Threads; 0 takes all cores [default: 0]
    #[arg(long, short, value_name = "N", visible_alias = "nthreads")]
    pub(crate) threads: Option<usize>,
    /// Width of the squares of pixels that a thread takes at a time.
    #[arg(long, value_name = "PIXELS", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(crate) tile_size: u32,
    /// How the tree over the shapes is built.
    #[arg(long, value_name = "BUILDER", default_value = "sah")]
    pub(crate) accel: AccelName,
    /// How progress is told on the standard error: `auto` is a bar on a terminal, `json` one object a line.
    #[arg(long, value_name = "FORM", default_value = "auto")]
    pub(crate) progress: ProgressKind,
}

/// What is understood, but answered by an error for as long as it does not exist.
#[derive(Debug, Args)]
pub(crate) struct AbsentArgs {
    /// Stop at this noise.
    #[arg(long, value_name = "ERROR", hide = true)]
    pub(crate) noise: Option<String>,
    /// Save the state of the render.
    #[arg(long, value_name = "FILE", hide = true, num_args = 0..=1)]
    pub(crate) checkpoint: Option<Option<PathBuf>>,
    /// Go on from a saved state.
    #[arg(long, value_name = "FILE", hide = true, num_args = 0..=1)]
    pub(crate) resume: Option<Option<PathBuf>>,
    /// Show the image in a viewer while it is rendered.
    #[arg(long, value_name = "HOST:PORT", alias = "display-server", hide = true, num_args = 0..=1)]
    pub(crate) tev: Option<Option<String>>,
}

/// Light transport algorithms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum IntegratorName {
    Path,
    Whitted,
    Ao,
    Normals,
}

/// How colour is carried.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ColorMode {
    Rgb,
    Spectral,
}

impl ColorMode {
    /// The scene's word for it.
    pub(crate) fn mode(self) -> sahl::scene::ColorMode {
        match self {
            Self::Rgb => sahl::scene::ColorMode::Rgb,
            Self::Spectral => sahl::scene::ColorMode::Spectral,
        }
    }
}

/// Layers beside the image itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum AovName {
    /// Reflected share of light at the first surface: Albedo.R, Albedo.G, Albedo.B.
    Albedo,
    /// Shading normal of the first surface: Ns.X, Ns.Y, Ns.Z.
    Normal,
    /// Geometric normal of the first surface: N.X, N.Y, N.Z.
    GeometricNormal,
    /// Distance along the camera's axis: Z.
    Depth,
    /// Place of the first surface: P.X, P.Y, P.Z.
    Position,
    /// Surface coordinates: u, v.
    Uv,
    /// Variance of the image's pixels: Variance.R, Variance.G, Variance.B.
    Variance,
}

/// How light becomes an 8-bit value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum CurveName {
    Srgb,
    Filmic,
}

/// How the tree over the shapes is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum AccelName {
    /// Halves at the median: to learn from and to compare with
    Median,
    /// Built most quickly, traced more slowly: for previews
    Fast,
    /// By the surface area heuristic: for most renders
    Sah,
    /// The best trees, for several times the time: for renders that take hours
    High,
}

/// How progress is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProgressKind {
    Auto,
    Bar,
    Json,
    None,
}
