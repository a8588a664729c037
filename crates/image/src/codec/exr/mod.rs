//! OpenEXR, by the `exr` crate.
//!
//! Written: one part, scan lines from the top, ZIP, every layer's channels as `name.channel`, so that plain readers find
//! the beauty as `R`, `G`, `B`. Read: scan lines and tiles (of mip maps the largest level), one or several parts, all
//! compressions of the crate.
//!
//! Deliberately absent: deep data, subsampled (luminance and chroma) channels.

mod dwa;
mod read;
mod write;

pub(super) use read::{probe, read};
pub(super) use write::write;

/// Width of the floats of colour channels. Other channels, such as depth and positions, always have 32 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Precision {
    /// 32 bits: every value is kept.
    #[default]
    Float,
    /// 16 bits: 11 significant bits, at most 65504; larger finite values become that.
    Half,
}

/// Attribute that holds the samples a pixel, as pbrt names it.
const SAMPLES: &str = "samplesPerPixel";
/// Attribute that holds the seed.
const SEED: &str = "seed";
