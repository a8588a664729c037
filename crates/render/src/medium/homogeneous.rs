//! A medium that is the same everywhere.
//!
//! In a scene file: `MakeNamedMedium "milk" "string type" "homogeneous" "string preset" "Wholemilk"`.

use std::iter;

use sahl_scene::{Diagnostics, Emission, Span};

use super::coefficients::Coefficients;
use super::walk::{self, Collision, Next, Stretch};
use super::{HenyeyGreenstein, Properties, Way};
use crate::sampler::Stream;
use crate::spectrum::{ColorRole, SpectralCurve, Spectrum, Wavelengths};

/// Matter that is the same everywhere. Its majorant is its extinction, so that every collision is a real one.
#[derive(Clone, Debug)]
pub(crate) struct Homogeneous {
    coefficients: Coefficients,
    emission: Option<(SpectralCurve, f32)>,
    pub(super) phase: HenyeyGreenstein,
}

impl Homogeneous {
    /// The medium of a scene; `span` is what messages point at.
    pub(crate) fn new(
        coefficients: &sahl_scene::Coefficients,
        emission: Option<&Emission>,
        span: Option<Span>,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        let coefficients = Coefficients::new(coefficients, span, diagnostics);
        let emission = emission.map(|Emission { radiance, scale }| {
            (SpectralCurve::new(radiance, ColorRole::Illuminant, span, diagnostics), *scale)
        });
        let phase = coefficients.phase;
        Self { coefficients, emission, phase }
    }

    fn properties(&self, wavelengths: &Wavelengths) -> Properties {
        let (sigma_a, sigma_s) = self.coefficients.at(wavelengths);
        let emission = match &self.emission {
            Some((radiance, scale)) => radiance.at(wavelengths) * *scale,
            None => Spectrum::ZERO,
        };
        Properties { sigma_a, sigma_s, emission }
    }

    pub(super) fn walk(
        &self,
        way: &Way,
        u: f32,
        stream: &mut Stream,
        visit: impl FnMut(&Collision) -> Next,
    ) -> Spectrum {
        let properties = self.properties(&way.wavelengths);
        let majorant = properties.sigma_a + properties.sigma_s;
        let stretches = iter::once(Stretch { from: 0.0, to: way.length, majorant });
        walk::walk(way, u, stream, stretches, |_| properties, visit)
    }

    /// exp(−σₜ d): Beer and Lambert's law.
    pub(super) fn transmittance(&self, way: &Way) -> Spectrum {
        let (sigma_a, sigma_s) = self.coefficients.at(&way.wavelengths);
        walk::passed(sigma_a + sigma_s, way.length)
    }
}
