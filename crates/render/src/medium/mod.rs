//! Participating media: matter between surfaces that absorbs, scatters and emits.
//!
//! Design decision: a medium is known by two things, its properties at a point and a majorant along a ray, a bound of its
//! extinction that is constant over stretches. Light meets tentative collisions at the rate of the majorant; at each of
//! them chance decides whether matter was there. That is exact whatever the profile, and transmittance needs no steps:
//! Miller, Georgiev, Jarosz, *A Null-Scattering Path Integral Formulation of Light Transport*, SIGGRAPH 2019.
//!
//! The four lanes of a path see different matter, but share its points. One lane, the hero, chooses the distances; how
//! likely the others would have chosen them is what the path integrator keeps.
//!
//! Deliberately absent: surfaces (the integrator crosses them), and estimates of transmittance (it makes them of walks).
//!
//! In a scene file: `MakeNamedMedium "fog" "string type" "homogeneous" "float scale" .1`, then
//! `MediumInterface "fog" ""` before a shape.

mod cloud;
mod coefficients;
mod density_grid;
mod fire;
mod grid;
mod homogeneous;
mod majorant;
mod phase;
mod rgb_grid;
mod sparse;
mod walk;

use sahl_math::Ray;

use crate::sampler::Stream;
use crate::spectrum::{Spectrum, Wavelengths};

pub use phase::{HenyeyGreenstein, PhaseSample};

pub(crate) use cloud::Cloud;
pub(crate) use density_grid::DensityGrid;
pub(crate) use homogeneous::Homogeneous;
pub(crate) use rgb_grid::RgbGrid;
pub(crate) use sparse::Sparse;
pub(crate) use walk::{Collision, Next};

/// Matter between surfaces.
#[derive(Clone, Debug)]
pub(crate) enum Medium {
    /// The same everywhere.
    Homogeneous(Homogeneous),
    /// Of a density on a grid.
    DensityGrid(Box<DensityGrid>),
    /// Of colours on a grid.
    RgbGrid(Box<RgbGrid>),
    /// Of a density that is noise.
    Cloud(Box<Cloud>),
    /// Of a density on a sparse grid.
    Sparse(Box<Sparse>),
}

/// What a medium is like at a point, per metre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Properties {
    /// Absorption.
    pub(crate) sigma_a: Spectrum,
    /// Scattering.
    pub(crate) sigma_s: Spectrum,
    /// Radiance in equilibrium: emission is σₐ Lₑ per metre.
    pub(crate) emission: Spectrum,
}

/// The way of light through a medium.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// Where it starts, and a unit direction.
    pub(crate) ray: Ray,
    /// Metres to its end; may be infinite.
    pub(crate) length: f32,
    /// The lane that chooses distances.
    pub(crate) hero: usize,
    pub(crate) wavelengths: Wavelengths,
}

impl Medium {
    /// Goes along `way` from one tentative collision to the next, for as long as `visit` says so.
    ///
    /// Distances follow the hero's majorant; `u` chooses the first, `stream` the others. Returns the majorant
    /// transmittance from the last collision to the end of the way, lane by lane: one where `visit` ended the walk.
    pub(crate) fn walk(
        &self,
        way: &Way,
        u: f32,
        stream: &mut Stream,
        visit: impl FnMut(&Collision) -> Next,
    ) -> Spectrum {
        match self {
            Self::Homogeneous(medium) => medium.walk(way, u, stream, visit),
            Self::DensityGrid(medium) => medium.walk(way, u, stream, visit),
            Self::RgbGrid(medium) => medium.walk(way, u, stream, visit),
            Self::Cloud(medium) => medium.walk(way, u, stream, visit),
            Self::Sparse(medium) => medium.walk(way, u, stream, visit),
        }
    }

    /// The transmittance of `way` where a formula gives it; it has to be estimated by walks elsewhere.
    pub(crate) fn transmittance(&self, way: &Way) -> Option<Spectrum> {
        match self {
            Self::Homogeneous(medium) => Some(medium.transmittance(way)),
            Self::DensityGrid(_) | Self::RgbGrid(_) | Self::Cloud(_) | Self::Sparse(_) => None,
        }
    }

    /// How the medium scatters.
    pub(crate) fn phase(&self) -> HenyeyGreenstein {
        match self {
            Self::Homogeneous(medium) => medium.phase,
            Self::DensityGrid(medium) => medium.phase,
            Self::RgbGrid(medium) => medium.phase,
            Self::Cloud(medium) => medium.phase,
            Self::Sparse(medium) => medium.phase,
        }
    }
}

#[cfg(test)]
mod tests;
