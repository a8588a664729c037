//! Reflection at a smooth interface.
//!
//! All formulas are for unpolarised light: the mean of both polarisations.

use crate::spectrum::Spectrum;

/// What happens to a ray at an interface between dielectrics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DielectricFresnel {
    /// Share of the light that is reflected, in [0, 1].
    pub reflectance: f32,
    /// Cosine between the refracted direction and the reversed normal; 0 where all is reflected.
    pub cos_transmitted: f32,
}

/// Reflection and refraction of a ray that arrives with `cos_incident` ≥ 0 between it and the normal.
///
/// `eta` is the index of refraction on the far side over that on the near side. Total internal reflection, which needs
/// `eta` < 1, reflects everything; `eta` = 1 reflects nothing.
///
/// Source: Fresnel's equations; Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed., 2023, section 9.3.
#[inline]
pub fn dielectric(cos_incident: f32, eta: f32) -> DielectricFresnel {
    let cos_i = cos_incident.clamp(0.0, 1.0);
    if eta == 1.0 {
        return DielectricFresnel { reflectance: 0.0, cos_transmitted: cos_i };
    }
    let sin2_transmitted = (1.0 - cos_i * cos_i) / (eta * eta);
    if sin2_transmitted >= 1.0 {
        return DielectricFresnel { reflectance: 1.0, cos_transmitted: 0.0 };
    }
    let cos_t = (1.0 - sin2_transmitted).sqrt();
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    DielectricFresnel {
        reflectance: 0.5 * (parallel * parallel + perpendicular * perpendicular),
        cos_transmitted: cos_t,
    }
}

/// Share of the light that passes an interface, given the cosines on both sides; the rest is reflected.
///
/// `eta` is as in [`dielectric`]. Symmetric: the same for the reversed path, with cosines exchanged and 1 / `eta`. A product,
/// not one minus the reflectance, it keeps its digits where next to nothing passes.
#[inline]
pub fn transmittance(cos_incident: f32, cos_transmitted: f32, eta: f32) -> f32 {
    let parallel = eta * cos_incident + cos_transmitted;
    let perpendicular = cos_incident + eta * cos_transmitted;
    let both = 1.0 / (parallel * parallel) + 1.0 / (perpendicular * perpendicular);
    2.0 * eta * cos_incident * cos_transmitted * both
}

/// Share of light reflected by a metal whose index relative to the outside is `eta` + i `k`, in each lane.
///
/// Source: Born, Wolf, *Principles of Optics*, 7th ed., 1999, section 14.2, in the real form with a² + b² of Lazányi,
/// Szirmay-Kalos, *Fresnel Term Approximations for Metals*, WSCG 2005.
#[inline]
pub fn conductor(cos_incident: f32, eta: Spectrum, k: Spectrum) -> Spectrum {
    let cos = cos_incident.clamp(0.0, 1.0);
    let (cos2, sin2) = (cos * cos, 1.0 - cos * cos);
    let (eta2, k2) = (eta * eta, k * k);
    let difference = eta2 - k2 - Spectrum::splat(sin2);
    let a2_plus_b2 = (difference * difference + 4.0 * (eta2 * k2)).sqrt();
    // a² is zero under total reflection, where rounding may leave it negative.
    let a = ((a2_plus_b2 + difference) * 0.5).clamp(0.0, f32::MAX).sqrt();
    let (sum, mixed) = (a2_plus_b2 + cos2, a * (2.0 * cos));
    let perpendicular = (sum - mixed) / (sum + mixed);
    let (sum, mixed) = (a2_plus_b2 * cos2 + sin2 * sin2, mixed * sin2);
    let parallel_over_perpendicular = (sum - mixed) / (sum + mixed);
    perpendicular * (parallel_over_perpendicular + 1.0) * 0.5
}

/// The imaginary part of the index of a metal with real part one that reflects `reflectance` at normal incidence.
///
/// k = 2 √r / √(1 − r); `reflectance` is limited to [0, 0.9999], since a perfect mirror would need an infinite one.
/// pbrt-v4's rule for the parameter `reflectance` of conductors.
#[inline]
pub fn absorption_of_reflectance(reflectance: Spectrum) -> Spectrum {
    let r = reflectance.clamp(0.0, 0.9999);
    2.0 * (r / (Spectrum::ONE - r)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_incidence_on_glass() {
        let fresnel = dielectric(1.0, 1.5);
        assert!((fresnel.reflectance - 0.04).abs() < 1e-6 && fresnel.cos_transmitted == 1.0);
        assert!((dielectric(1.0, 1.0 / 1.5).reflectance - 0.04).abs() < 1e-6);
        assert_eq!(dielectric(0.0, 1.5).reflectance, 1.0);
    }

    #[test]
    fn brewsters_angle_has_no_parallel_reflection() {
        let eta = 1.5_f32;
        let cos = 1.0 / (1.0 + eta * eta).sqrt();
        let perpendicular = (1.0 - eta * eta) / (1.0 + eta * eta);
        assert!((dielectric(cos, eta).reflectance - 0.5 * perpendicular * perpendicular).abs() < 1e-6);
    }

    #[test]
    fn both_directions_reflect_alike_and_total_reflection_is_total() {
        for i in 0..=100 {
            let cos = i as f32 / 100.0;
            let down = dielectric(cos, 1.33);
            let up = dielectric(down.cos_transmitted, 1.0 / 1.33);
            // At grazing angles the slope is steep, and the cosine below comes from rounded squares.
            assert!((down.reflectance - up.reflectance).abs() < 2e-3, "{cos}");
        }
        assert_eq!(dielectric(0.5, 1.0 / 1.5).reflectance, 1.0);
        assert_eq!(dielectric(0.0, 1.0), DielectricFresnel { reflectance: 0.0, cos_transmitted: 0.0 });
    }

    #[test]
    fn what_is_not_reflected_passes() {
        for eta in [0.7, 1.0, 1.5, 2.4] {
            for i in 1..=100 {
                let cos = i as f32 / 100.0;
                let fresnel = dielectric(cos, eta);
                if fresnel.cos_transmitted > 0.0 {
                    let passed = transmittance(cos, fresnel.cos_transmitted, eta);
                    assert!((passed - (1.0 - fresnel.reflectance)).abs() < 1e-6, "{eta} {cos}");
                }
            }
        }
    }

    #[test]
    fn a_metal_without_absorption_is_a_dielectric() {
        for eta in [0.6, 0.9, 1.5, 2.5] {
            for i in 0..=100 {
                let cos = i as f32 / 100.0;
                let metal = conductor(cos, Spectrum::splat(eta), Spectrum::ZERO).max_component();
                let glass = dielectric(cos, eta).reflectance;
                // Near the critical angle the reflectance has an infinite slope.
                let tolerance = if eta < 1.0 { 2e-3 } else { 1e-5 };
                assert!((metal - glass).abs() < tolerance, "{eta} {cos}: {metal} {glass}");
            }
        }
    }

    #[test]
    fn a_metal_reflects_what_was_asked_for() {
        let asked = Spectrum::from_rgb([0.1, 0.5, 0.95]);
        let got = conductor(1.0, Spectrum::ONE, absorption_of_reflectance(asked));
        for (asked, got) in asked.lanes().into_iter().zip(got.lanes()) {
            assert!((asked - got).abs() < 1e-5);
        }
        let extreme = conductor(0.0, Spectrum::ONE, absorption_of_reflectance(Spectrum::splat(2.0)));
        assert_eq!(extreme, Spectrum::ONE);
        // Copper at 650 nm: η = 0.214, k = 3.67.
        let copper = conductor(1.0, Spectrum::splat(0.214), Spectrum::splat(3.67)).max_component();
        assert!((copper - 0.942_5).abs() < 1e-3, "{copper}");
    }
}
