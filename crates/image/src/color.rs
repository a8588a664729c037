//! Colour spaces and encodings.

use serde::{Deserialize, Serialize};

/// Primaries and white of an RGB space, the values being linear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ColorSpace {
    /// ITU-R BT.709 primaries, D65.
    #[default]
    Srgb,
    /// DCI-P3 primaries, D65.
    DciP3,
    /// ITU-R BT.2020 primaries, D65.
    Rec2020,
    /// ACES AP0 primaries, D60.
    Aces2065_1,
}

/// What a stored value means.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Encoding {
    /// The quantity itself.
    Linear,
    /// IEC 61966-2-1.
    Srgb,
    /// The quantity raised to one over this.
    Gamma(f32),
}
