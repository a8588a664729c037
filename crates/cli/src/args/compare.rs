use std::path::PathBuf;

use clap::Args;

/// Compare images with a reference: MSE, relMSE, PSNR, FLIP and a test for bias.
///
/// `sahl compare A B` compares A with the reference B; `sahl compare A1 A2 A3 --ref B` compares renders of several
/// seeds with it. The test for bias needs to know the noise of A: from the spread of at least two seeds, or from --var.
/// When it finds a bias, the exit code is 1.
#[derive(Debug, Args)]
#[command(after_help = super::EXIT_CODES)]
pub(crate) struct CompareArgs {
    /// Images under test; without --ref, exactly one, and the reference after it.
    #[arg(value_name = "IMAGE", required = true)]
    pub(crate) images: Vec<PathBuf>,
    /// The reference.
    #[arg(long = "ref", value_name = "IMAGE")]
    pub(crate) reference: Option<PathBuf>,
    /// Variance of the reference's pixels: an image, or an .exr with a layer `Variance`. Without it, the reference has
    /// no noise.
    #[arg(long, value_name = "IMAGE")]
    pub(crate) ref_var: Option<PathBuf>,
    /// Variance of the pixels of the images under test, in their order; likewise. `render --aov variance` writes it.
    #[arg(long, value_name = "IMAGE", num_args = 1..)]
    pub(crate) var: Vec<PathBuf>,
    /// Write the first image, the reference, their signed difference (blue: darker, red: brighter) and the relative
    /// squared error side by side.
    #[arg(long, value_name = "FILE")]
    pub(crate) png: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    pub(crate) json: bool,
}
