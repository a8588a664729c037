//! Colour spaces and encodings.
//!
//! Deliberately absent: spectra (a renderer's business), colour appearance, ICC profiles.

mod encoding;
mod matrix;
mod space;

pub use encoding::Encoding;
pub(crate) use space::conversion;
pub use space::{Adaptation, Chromaticities, ColorSpace};
