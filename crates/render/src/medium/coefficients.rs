//! Absorption and scattering of a medium whose density may vary.

use sahl_scene::{Diagnostics, Span};

use super::HenyeyGreenstein;
use crate::spectrum::{ColorRole, SpectralCurve, Spectrum, Wavelengths};

/// Coefficients at density one.
#[derive(Clone, Debug)]
pub(super) struct Coefficients {
    sigma_a: SpectralCurve,
    sigma_s: SpectralCurve,
    scale: f32,
    pub(super) phase: HenyeyGreenstein,
}

impl Coefficients {
    pub(super) fn new(
        description: &sahl_scene::Coefficients,
        span: Option<Span>,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        let mut curve = |spectrum| SpectralCurve::new(spectrum, ColorRole::Unbounded, span, diagnostics);
        Self {
            sigma_a: curve(&description.sigma_a),
            sigma_s: curve(&description.sigma_s),
            scale: description.scale,
            phase: HenyeyGreenstein::new(description.g),
        }
    }

    /// Absorption and scattering per metre.
    #[inline]
    pub(super) fn at(&self, wavelengths: &Wavelengths) -> (Spectrum, Spectrum) {
        (self.sigma_a.at(wavelengths) * self.scale, self.sigma_s.at(wavelengths) * self.scale)
    }
}
