//! Participating media: what fills the space between surfaces.

mod grid;

use sahl_image::ColorSpace;
use serde::{Deserialize, Serialize};

use crate::{Handle, Spectrum};

pub use grid::{Grid, Region, SparseGrid};

/// Matter that absorbs, scatters and emits light along its way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Medium {
    /// The same everywhere.
    Homogeneous {
        /// How light is lost and turned aside.
        coefficients: Coefficients,
        /// What it emits.
        emission: Option<Emission>,
    },
    /// Of a density that is given on a grid.
    Grid(GridMedium),
    /// Of colours that are given on a grid.
    RgbGrid(RgbGridMedium),
    /// A cloud made of noise.
    Cloud(CloudMedium),
    /// Of a density that is given on a sparse grid.
    Sparse(Box<SparseMedium>),
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

/// Emitted radiance Lₑ with a factor: σₐ Lₑ is added to the radiance of a ray for each metre.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Emission {
    /// Normalised like that of a light.
    pub radiance: Spectrum,
    /// Factor on the radiance.
    pub scale: f32,
}

/// Matter in a box, whose coefficients are multiplied by a density.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GridMedium {
    /// At density one.
    pub coefficients: Coefficients,
    /// The box.
    pub region: Region,
    /// Its density.
    pub density: Grid<f32>,
    /// What it emits.
    pub emission: Option<GridEmission>,
}

/// Emission on a grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GridEmission {
    /// Its colour.
    pub source: GridSource,
    /// Factor on it.
    pub scale: f32,
    /// Another factor, cell by cell.
    pub scales: Option<Grid<f32>>,
}

/// The colour of emission on a grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum GridSource {
    /// The same everywhere; normalised like that of a light.
    Spectrum(Spectrum),
    /// That of black bodies.
    Temperature(Grid<f32>, TemperatureScale),
}

/// From the values of a grid to temperatures: (value − offset) × scale, in kelvin. Up to 100 K nothing is emitted. The
/// radiance of every temperature is relative to its own peak over all wavelengths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TemperatureScale {
    /// Taken off the value.
    pub offset: f32,
    /// Kelvin for each unit.
    pub scale: f32,
}

impl TemperatureScale {
    /// The temperature that `value` stands for.
    pub fn kelvin(&self, value: f32) -> f32 {
        (value - self.offset) * self.scale
    }
}

/// Matter in a box, whose coefficients are colours, interpolated after they became spectra.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RgbGridMedium {
    /// The box.
    pub region: Region,
    /// The space of all the colours.
    pub space: ColorSpace,
    /// Absorption per metre; one if it is not given.
    pub sigma_a: Option<Grid<[f32; 3]>>,
    /// Scattering per metre; one if it is not given.
    pub sigma_s: Option<Grid<[f32; 3]>>,
    /// Factor on both.
    pub scale: f32,
    /// See [`Coefficients::g`].
    pub g: f32,
    /// Emitted radiance.
    pub emission: Option<Grid<[f32; 3]>>,
    /// Factor on it.
    pub emission_scale: f32,
}

/// A cloud that thins out from y = 0 to y = 1 of its own space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CloudMedium {
    /// At density one, the greatest.
    pub coefficients: Coefficients,
    /// The box that holds it.
    pub region: Region,
    /// How much of the box is full.
    pub density: f32,
    /// How much noise displaces noise.
    pub wispiness: f32,
    /// Of the noise, per unit of its own space.
    pub frequency: f32,
}

/// Matter whose density is given on a sparse grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SparseMedium {
    /// At density one.
    pub coefficients: Coefficients,
    /// From the space in which the grids are placed to the world.
    pub medium_to_world: sahl_math::Transform,
    /// Its density.
    pub density: SparseGrid,
    /// Its temperature, if it glows.
    pub temperature: Option<(SparseGrid, TemperatureScale)>,
    /// Factor on the emission.
    pub emission_scale: f32,
}

impl Medium {
    /// Whether light comes from it.
    pub fn emits(&self) -> bool {
        match self {
            Self::Homogeneous { emission, .. } => emission.is_some(),
            Self::Grid(medium) => medium.emission.is_some(),
            Self::RgbGrid(medium) => medium.emission.is_some(),
            Self::Cloud(_) => false,
            Self::Sparse(medium) => medium.temperature.is_some(),
        }
    }
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
