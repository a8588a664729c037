//! Figures that say how far apart images are.
//!
//! All of them take linear light with sRGB primaries; images in other encodings or primaries are converted. Values that
//! are not finite count as 0 and are reported by [`compare`].

mod compare;
mod error;
mod flip;
mod pixels;
mod probability;
mod z_test;

pub use compare::{Comparison, compare};
pub use error::{RELATIVE_EPSILON, mse, psnr, rel_mse, rel_mse_trimmed};
pub use flip::{PIXELS_PER_DEGREE, flip, flip_map};
pub use probability::{erfc, sidak};
pub use z_test::{ZFigures, ZTest, ZTestOptions, z_test};
