//! The standard observer and thermal emission, as functions.
//!
//! Deliberately absent: tables. The analytic fit is good to about one per cent, which is enough to find the RGB of a
//! spectrum; spectral rendering integrates against the tabulated observer.

/// Wavelengths at which curves are integrated: 360 to 830 nm, as the standard observer is defined.
pub(crate) fn wavelengths() -> impl Iterator<Item = f32> {
    (360_u16..=830).map(f32::from)
}

/// XYZ colour matching functions of the CIE 1931 observer at `lambda` nanometres.
///
/// Source: Wyman, Sloan, Shirley, *Simple Analytic Approximations to the CIE XYZ Color Matching Functions*, JCGT 2(2),
/// 2013, listing 1 (multi-lobe fit).
pub(crate) fn color_matching(lambda: f32) -> [f32; 3] {
    let lobe = |height: f32, center: f32, left: f32, right: f32| {
        let t = (lambda - center) / if lambda < center { left } else { right };
        height * (-0.5 * t * t).exp()
    };
    [
        lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) + lobe(-0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    ]
}

/// Emission of a black body at `kelvin` and `lambda` nanometres, relative to its peak over all wavelengths.
///
/// Planck's law; the peak is where Wien's displacement law puts it.
pub(crate) fn blackbody(kelvin: f32, lambda: f32) -> f32 {
    if kelvin.is_nan() || kelvin <= 0.0 {
        return 0.0;
    }
    // h c / k in nanometre kelvin, and Wien's b in the same unit.
    const SECOND_RADIATION_CONSTANT: f64 = 1.438_776_877e7;
    const WIEN: f64 = 2.897_771_955e6;
    let planck =
        |nm: f64| 1.0 / (nm.powi(5) * (SECOND_RADIATION_CONSTANT / (nm * f64::from(kelvin))).exp_m1());
    (planck(f64::from(lambda)) / planck(WIEN / f64::from(kelvin))) as f32
}

/// XYZ of a spectral power distribution, not normalised.
pub(crate) fn xyz(power: impl Fn(f32) -> f32) -> [f32; 3] {
    let mut sum = [0.0_f64; 3];
    for lambda in wavelengths() {
        let value = f64::from(power(lambda));
        for (sum, response) in sum.iter_mut().zip(color_matching(lambda)) {
            *sum += value * f64::from(response);
        }
    }
    sum.map(|x| x as f32)
}

/// XYZ with Y = 1 of the chromaticity (x, y).
pub(crate) fn xyz_of_chromaticity([x, y]: [f32; 2]) -> [f32; 3] {
    [x / y, 1.0, (1.0 - x - y) / y]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_observer_sees_equal_energy_as_white() {
        let [x, y, z] = xyz(|_| 1.0);
        // The tables integrate to 106.857 in all three.
        for value in [x, y, z] {
            assert!((value - 106.857).abs() < 0.4, "{x} {y} {z}");
        }
    }

    #[test]
    fn a_black_body_has_its_chromaticity() {
        // CIE illuminant A is a black body at 2856 K: x = 0.44757, y = 0.40745 (CIE 15:2004).
        let [x, y, z] = xyz(|lambda| blackbody(2855.5, lambda));
        let sum = x + y + z;
        assert!(
            (x / sum - 0.44757).abs() < 3e-3 && (y / sum - 0.40745).abs() < 3e-3,
            "{} {}",
            x / sum,
            y / sum
        );
    }

    #[test]
    fn a_black_body_peaks_at_one_by_wiens_law() {
        assert!((blackbody(5000.0, 579.554_4) - 1.0).abs() < 1e-6);
        assert!(blackbody(5000.0, 560.0) < 1.0 && blackbody(5000.0, 600.0) < 1.0);
        assert_eq!(blackbody(0.0, 500.0), 0.0);
        assert!(blackbody(1.0, 360.0).is_finite());
    }
}
