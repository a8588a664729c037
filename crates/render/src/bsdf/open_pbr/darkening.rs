//! How the coat of [`super::OpenPbr`] darkens what lies below it: light goes to and fro between both, and loses some each time.
//!
//! Source: *OpenPBR Surface*, version 1.1, section "Darkening".

use crate::bsdf::fresnel;
use crate::spectrum::Spectrum;

/// What light loses by going to and fro between base and coat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Darkening {
    /// How much of the effect there is.
    pub(super) weight: f32,
    /// The share of light from a rough base that the coat sends back to it.
    pub(super) rough_return: f32,
    /// How rough the base is, from zero to one.
    pub(super) roughness: f32,
    /// What the base keeps of light at normal incidence.
    pub(super) base_albedo: Spectrum,
}

impl Darkening {
    /// A coat that sends nothing back.
    pub(super) const NONE: Self =
        Self { weight: 0.0, rough_return: 0.0, roughness: 0.0, base_albedo: Spectrum::ZERO };

    /// What the base is multiplied by, seen under the cosine `cos` through a coat of the index `eta`.
    pub(super) fn at(&self, cos: f32, eta: f32) -> Spectrum {
        if self.weight == 0.0 {
            return Spectrum::ONE;
        }
        let smooth_return = fresnel::dielectric(cos, eta).reflectance;
        let k = smooth_return + (self.rough_return - smooth_return) * self.roughness;
        // One where nothing is absorbed, whatever comes back.
        let darkened = self.base_albedo.map(|albedo| {
            let lost = k * (1.0 - albedo);
            if lost > 0.0 { 1.0 - lost / (1.0 - albedo * k) } else { 1.0 }
        });
        Spectrum::ONE + (darkened - Spectrum::ONE) * self.weight
    }
}

/// The reflectance of an interface to matter of the index `eta`, from 1 to 3, for light from all sides.
///
/// Source: d'Eon, *A Hitchhiker's Guide to Multiple Scattering*, 2021, whose fit OpenPBR 1.1 recommends for coats.
pub(super) fn mean_reflectance(eta: f32) -> f32 {
    ((10893.0 * eta - 1438.2) / (-774.4 * eta * eta + 10212.0 * eta + 1.0)).ln().clamp(0.0, 1.0)
}
