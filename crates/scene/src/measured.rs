//! Surfaces that were measured.

use std::f32::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

/// A measured BRDF in the parametrisation of Dupuy and Jakob, as files of the RGL material database hold it.
///
/// f cos θi = S(u) D(m) / (4 σ(ωo)), where m is the halfway vector, D a density of microfacet normals, σ their projected area, and
/// S the values that are stored. Where S is looked up follows from m by a change of variables: the distribution of visible normals
/// takes u to m. Which density D is does not matter to the values, only to how well they are resolved.
///
/// Directions are points of the unit square: x = √(2 θ / π), y = φ / 2π + ½. Functions of the direction ωo are given for each of
/// `phi` and `theta`, and are linear between them. The files speak of the incident direction here; a BRDF is reciprocal.
///
/// Source: Dupuy, Jakob, *An Adaptive Parameterization for Efficient Material Acquisition and Rendering*, ACM TOG 37(6), 2018.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredBrdf {
    /// Polar angles of ωo in radians, increasing.
    pub theta: Arc<[f32]>,
    /// Azimuths of ωo in radians, increasing; up to two if the surface is isotropic. Azimuths of m then count from that of ωo.
    /// Otherwise they span the circle, its half, or a quarter: the surface is symmetric about the normal, or to both axes.
    pub phi: Arc<[f32]>,
    /// Wavelengths in nanometres, increasing.
    pub wavelengths: Arc<[f32]>,
    /// D, per steradian, over m.
    pub ndf: MeasuredGrid,
    /// σ over ωo.
    pub sigma: MeasuredGrid,
    /// For each azimuth and each polar angle, in this order, a density of visible normals over m.
    pub vndf: MeasuredGrid,
    /// Likewise how bright the surface is over u, which is what samples of u follow.
    pub luminance: MeasuredGrid,
    /// For each azimuth, polar angle and wavelength S over u.
    pub spectra: MeasuredGrid,
    /// Whether S is relative to the microfacets, as above; otherwise it is f cos θi itself.
    pub is_relative: bool,
}

/// Values on the unit square, at the corners of equal cells; or several such grids.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredGrid {
    /// Values along x, the direction in which neighbours are stored, and along y.
    pub resolution: [u32; 2],
    /// The values; x varies fastest, then y, then the grids, the last of their indices first.
    pub values: Arc<[f32]>,
}

/// What a grid must hold.
struct Expected {
    name: &'static str,
    grids: usize,
    least: u32,
}

impl MeasuredGrid {
    /// What is wrong with the grid, if anything is.
    fn problem(&self, expected: &Expected) -> Option<String> {
        let Expected { name, grids, least } = *expected;
        let [x, y] = self.resolution;
        if x < least || y < least {
            return Some(format!("`{name}` has {x} x {y} values: expected {least} x {least} or more"));
        }
        let count = (u128::from(x) * u128::from(y)).checked_mul(grids as u128);
        if count != Some(self.values.len() as u128) {
            let found = self.values.len();
            return Some(format!("`{name}` has {found} values: expected {grids} grids of {x} x {y}"));
        }
        let position = self.values.iter().position(|value| !value.is_finite())?;
        Some(format!("value {position} of `{name}` is {}: expected a finite number", self.values[position]))
    }
}

impl MeasuredBrdf {
    /// Whether the surface looks the same however it is turned about its normal.
    pub fn is_isotropic(&self) -> bool {
        self.phi.len() <= 2
    }

    /// Into how many equal parts the symmetry of the surface divides the circle of azimuths: one, two or four; one if it is
    /// isotropic. `None` if they span something else.
    pub fn symmetry(&self) -> Option<u32> {
        if self.is_isotropic() {
            return Some(1);
        }
        let parts = (TAU / (self.phi.last()? - self.phi.first()?)).round();
        [1, 2, 4].into_iter().find(|&known| parts == known as f32)
    }

    /// What makes the tables unusable, if anything does.
    pub fn problem(&self) -> Option<String> {
        let theta_range = [0.0, 1.01 * FRAC_PI_2];
        let axes = [
            ("theta_i", &self.theta, theta_range),
            ("phi_i", &self.phi, [-1.01 * TAU, 1.01 * TAU]),
            ("wavelengths", &self.wavelengths, [0.0, f32::MAX]),
        ];
        for (name, values, [low, high]) in axes {
            let is_inside = values.iter().all(|value| (low..=high).contains(value));
            if values.is_empty() || !is_inside || !values.is_sorted_by(|a, b| a < b) {
                return Some(format!("`{name}` must increase from {low} or more to {high} at most"));
            }
        }
        if self.symmetry().is_none() {
            return Some("`phi_i` must span the circle, a half or a quarter of it".to_owned());
        }
        let slices = self.theta.len() * self.phi.len();
        let grids = [
            (&self.ndf, Expected { name: "ndf", grids: 1, least: 1 }),
            (&self.sigma, Expected { name: "sigma", grids: 1, least: 1 }),
            (&self.vndf, Expected { name: "vndf", grids: slices, least: 2 }),
            (&self.luminance, Expected { name: "luminance", grids: slices, least: 2 }),
            (&self.spectra, Expected { name: "spectra", grids: slices * self.wavelengths.len(), least: 2 }),
        ];
        grids.iter().find_map(|(grid, expected)| grid.problem(expected))
    }
}
