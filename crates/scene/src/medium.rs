//! Participating media: what fills the space between surfaces.

use serde::{Deserialize, Serialize};

use crate::{Handle, Spectrum};

/// Matter that absorbs, scatters and emits light along its way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Medium {
    /// The same everywhere.
    Homogeneous {
        /// How light is lost and turned aside.
        coefficients: Coefficients,
        /// Emission per metre where all matter absorbs: σₐ Lₑ is added to the radiance of a ray for each metre.
        emission: Option<Emission>,
    },
}

impl Medium {
    /// Whether light comes from it.
    pub fn emits(&self) -> bool {
        match self {
            Self::Homogeneous { emission, .. } => emission.is_some(),
        }
    }
}

/// The coefficients of absorption and scattering with the phase function.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coefficients {
    /// Absorption σₐ, per metre.
    pub sigma_a: Spectrum,
    /// Scattering σₛ, per metre.
    pub sigma_s: Spectrum,
    /// Factor on both.
    pub scale: f32,
    /// Mean cosine of the angle of deflection, for the phase function of Henyey and Greenstein: above −1 and below 1,
    /// positive for scattering forward.
    pub g: f32,
}

/// Emitted radiance with a factor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Emission {
    /// Normalised like that of a light.
    pub radiance: Spectrum,
    /// Factor on the radiance.
    pub scale: f32,
}

/// The media on both sides of a surface; `None` is empty space.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MediumInterface {
    /// On the side away from the normal.
    pub inside: Option<Handle<Medium>>,
    /// On the side of the normal.
    pub outside: Option<Handle<Medium>>,
}

impl MediumInterface {
    /// Whether one medium ends at the surface.
    pub fn is_transition(&self) -> bool {
        self.inside != self.outside
    }
}
