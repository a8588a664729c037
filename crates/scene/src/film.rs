//! Film, reconstruction filter and sampler.

use sahl_image::ColorSpace;
use serde::{Deserialize, Serialize};

/// What the camera records on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Film {
    /// Width and height of the full image in pixels.
    pub resolution: [u32; 2],
    /// The pixels to render: x min, x max, y min, y max, the maxima exclusive. `None`: all.
    pub crop: Option<[u32; 4]>,
    /// Length of the film from corner to corner in metres; it matters to lenses of glass alone.
    pub diagonal: f32,
    /// Factor from radiance to pixel value.
    pub exposure: f32,
    /// Samples with a larger component are scaled down to it; infinite by default.
    pub max_component: f32,
    /// Primaries and white of the pixel values.
    pub color_space: ColorSpace,
    /// Where the scene asks for the image to be written.
    pub filename: Option<String>,
}

impl Film {
    /// The most pixels that an image may have, 16 384 squared: a film of them takes 16 GiB.
    pub const MOST_PIXELS: u64 = 1 << 28;
}

impl Default for Film {
    /// pbrt's default: 1280 × 720 pixels on a film of 35 mm.
    fn default() -> Self {
        Self {
            resolution: [1280, 720],
            crop: None,
            diagonal: 0.035,
            exposure: 1.0,
            max_component: f32::INFINITY,
            color_space: ColorSpace::Srgb,
            filename: None,
        }
    }
}

/// Weight of a sample by its offset from the pixel centre, in pixels. Radii are half widths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Filter {
    /// Constant.
    Box {
        /// Half widths in x and y.
        radius: [f32; 2],
    },
    /// Linear falloff.
    Triangle {
        /// Half widths in x and y.
        radius: [f32; 2],
    },
    /// Gaussian, moved down to reach zero at the radius.
    Gaussian {
        /// Half widths in x and y.
        radius: [f32; 2],
        /// Standard deviation.
        sigma: f32,
    },
    /// Mitchell and Netravali's cubic.
    Mitchell {
        /// Half widths in x and y.
        radius: [f32; 2],
        /// Blur.
        b: f32,
        /// Ringing.
        c: f32,
    },
    /// A sine cardinal under the middle lobe of another: Lanczos's window.
    Sinc {
        /// Half widths in x and y.
        radius: [f32; 2],
        /// Half the width of the window's middle lobe.
        tau: f32,
    },
}

impl Default for Filter {
    /// pbrt's default.
    fn default() -> Self {
        Self::Gaussian { radius: [1.5, 1.5], sigma: 0.5 }
    }
}

/// Source of sample points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sampler {
    /// How points are placed.
    pub kind: SamplerKind,
    /// Samples a pixel.
    pub samples: u32,
    /// Different seeds give independent images.
    pub seed: u64,
}

impl Default for Sampler {
    /// pbrt's default: 16 well-spread samples.
    fn default() -> Self {
        Self { kind: SamplerKind::Sobol, samples: 16, seed: 0 }
    }
}

/// How sample points are placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SamplerKind {
    /// Owen-scrambled Sobol' points whose error is blue noise on the screen.
    Sobol,
    /// Independent uniform points.
    Independent,
}
