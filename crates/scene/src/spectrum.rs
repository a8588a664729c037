//! Colours and spectra as files give them.

use sahl_image::ColorSpace;
use serde::{Deserialize, Serialize};

/// How rendering carries colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ColorMode {
    /// As linear sRGB: fast, exact for scenes that are given in RGB and lit by white, without dispersion.
    #[default]
    Rgb,
    /// As radiance at sampled wavelengths from 360 to 830 nm, as pbrt-v4 does.
    Spectral,
}

/// A distribution over wavelengths, as written in a scene: the renderer turns it into its own representation.
///
/// Whether an RGB triple is a reflectance, an unbounded quantity or an emission follows from the parameter it stands in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Spectrum {
    /// The same value at every wavelength.
    Constant(f32),
    /// Linear RGB.
    Rgb {
        /// The components.
        rgb: [f32; 3],
        /// Their primaries and white.
        space: ColorSpace,
    },
    /// Emission of a black body at this temperature in kelvin, scaled to a maximum of one.
    Blackbody(f32),
    /// Samples at wavelengths in nanometres, increasing; linear between them, zero outside.
    Sampled(Vec<(f32, f32)>),
    /// One of pbrt-v4's named spectra, such as `metal-Cu-eta`.
    Named(String),
}

impl Spectrum {
    /// Linear sRGB.
    pub const fn srgb(rgb: [f32; 3]) -> Self {
        Self::Rgb { rgb, space: ColorSpace::Srgb }
    }
}
