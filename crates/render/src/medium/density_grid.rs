//! A density, and perhaps emission, on a grid.
//!
//! In a scene file: `MakeNamedMedium "smoke" "string type" "uniformgrid" "integer nx" 8 "integer ny" 8 "integer nz" 8` with
//! 512 values of `float density`.

use sahl_scene::{Diagnostics, GridMedium, GridSource, Span};

use super::coefficients::Coefficients;
use super::fire::Fire;
use super::grid::{Cells, Frame};
use super::majorant::MajorantGrid;
use super::walk::{self, Collision, Next};
use super::{HenyeyGreenstein, Properties, Way};
use crate::sampler::Stream;
use crate::spectrum::{ColorRole, SpectralCurve, Spectrum, Wavelengths};

/// Cells of the majorant along each axis, as in pbrt-v4.
const MAJORANT_CELLS: usize = 16;

/// Matter whose density is given on a grid.
#[derive(Clone, Debug)]
pub(crate) struct DensityGrid {
    coefficients: Coefficients,
    frame: Frame,
    density: Cells<f32>,
    majorant: MajorantGrid,
    emission: Option<Emission>,
    pub(super) phase: HenyeyGreenstein,
}

/// What the matter emits.
#[derive(Clone, Debug)]
struct Emission {
    source: Source,
    factor: f32,
    /// A factor cell by cell.
    scale: Option<Cells<f32>>,
}

/// The colour of emission.
#[derive(Clone, Debug)]
enum Source {
    Curve(SpectralCurve),
    Heat(Cells<f32>, Fire),
}

impl DensityGrid {
    /// The medium of a scene; `span` is what messages point at.
    pub(crate) fn new(description: &GridMedium, span: Option<Span>, diagnostics: &mut Diagnostics) -> Self {
        let GridMedium { coefficients, region, density, emission } = description;
        let coefficients = Coefficients::new(coefficients, span, diagnostics);
        let density = Cells::new(density, |density| density.max(0.0));
        let majorant = MajorantGrid::new(MAJORANT_CELLS, |part| density.max_within(part, |density| *density));
        let emission = emission.as_ref().map(|emission| Emission {
            source: match &emission.source {
                GridSource::Spectrum(spectrum) => {
                    Source::Curve(SpectralCurve::new(spectrum, ColorRole::Illuminant, span, diagnostics))
                }
                GridSource::Temperature(grid, scale) => {
                    let kelvin = Cells::new(grid, |value| scale.kelvin(*value));
                    let hottest = kelvin.values().iter().copied().fold(0.0, f32::max);
                    Source::Heat(kelvin, Fire::new(hottest))
                }
            },
            factor: emission.scale,
            scale: emission.scales.as_ref().map(|grid| Cells::new(grid, |scale| scale.max(0.0))),
        });
        let phase = coefficients.phase;
        Self { coefficients, frame: Frame::new(region), density, majorant, emission, phase }
    }

    pub(super) fn walk(
        &self,
        way: &Way,
        u: f32,
        stream: &mut Stream,
        visit: impl FnMut(&Collision) -> Next,
    ) -> Spectrum {
        let (sigma_a, sigma_s) = self.coefficients.at(&way.wavelengths);
        let ray = self.frame.ray_to_cube(&way.ray);
        let stretches = self.majorant.stretches(&ray, way.length, sigma_a + sigma_s);
        let properties = |p| {
            let p = self.frame.to_cube(p);
            let density = self.density.at(p, |density| *density);
            let emission = match &self.emission {
                Some(emission) => emission.at(p, &way.wavelengths),
                None => Spectrum::ZERO,
            };
            Properties { sigma_a: sigma_a * density, sigma_s: sigma_s * density, emission }
        };
        walk::walk(way, u, stream, stretches, properties, visit)
    }
}

impl Emission {
    fn at(&self, p: sahl_math::Vec3, wavelengths: &Wavelengths) -> Spectrum {
        let scale = self.factor * self.scale.as_ref().map_or(1.0, |scale| scale.at(p, |scale| *scale));
        if scale == 0.0 {
            return Spectrum::ZERO;
        }
        let radiance = match &self.source {
            Source::Curve(curve) => curve.at(wavelengths),
            Source::Heat(kelvin, fire) => fire.at(kelvin.at(p, |kelvin| *kelvin), wavelengths),
        };
        radiance * scale
    }
}
