//! The standard observer, the illuminants of the colour spaces, and thermal emission.
//!
//! Unit of luminance: an emission L(λ) has the luminance ∫ ȳ(λ) L(λ) dλ / ∫ ȳ(λ) dλ, so that one at every wavelength has
//! the luminance one. pbrt-v4's photometric normalisation differs by the constant denominator, which cancels.

use std::sync::LazyLock;

use glam::Vec4;
use sahl_image::ColorSpace;

use super::dense::{DenseSpectrum, ENTRIES, RANGE, place};
use super::table::{Outside, column, interpolate};

/// The colour matching functions of the CIE 1931 observer (2 degrees), a row a nanometre: data/color/PROVENANCE.md.
const FUNCTIONS: &str = include_str!("../../../../data/color/cie-1931-2deg.csv");

/// Illuminants every five nanometres: data/color/PROVENANCE.md.
pub(super) const ILLUMINANTS: &str = include_str!("../../../../data/color/cie-illuminants.csv");

/// The CIE 1931 standard observer.
#[derive(Debug)]
pub(crate) struct Observer {
    /// x̄, ȳ, z̄ and zero at each nanometre from 360 on, divided by the sum of all ȳ.
    rows: [Vec4; ENTRIES],
}

static OBSERVER: LazyLock<Observer> = LazyLock::new(Observer::load);

/// The standard observer. Who needs it for each sample keeps the reference.
pub(crate) fn observer() -> &'static Observer {
    &OBSERVER
}

impl Observer {
    fn load() -> Self {
        let [x, y, z] = ["x", "y", "z"].map(|name| {
            let pairs =
                column(FUNCTIONS, name).expect("the table of the observer has three columns of numbers");
            DenseSpectrum::new(|nm| interpolate(&pairs, nm, Outside::Zero))
        });
        let total: f64 = y.values().iter().map(|&y| f64::from(y)).sum();
        let row = |i: usize| Vec4::new(x.values()[i], y.values()[i], z.values()[i], 0.0) / total as f32;
        Self { rows: std::array::from_fn(row) }
    }

    /// x̄, ȳ, z̄ at `lambda` nanometres, per nanometre, ∫ ȳ dλ being one; the fourth number is zero.
    #[inline]
    pub(crate) fn at(&self, lambda: f32) -> Vec4 {
        let (index, fraction) = place(lambda);
        let (before, after) = (self.rows[index], self.rows[index + 1]);
        before + (after - before) * fraction
    }

    /// XYZ of a spectral distribution.
    pub(crate) fn xyz(&self, power: impl Fn(f32) -> f32) -> [f32; 3] {
        let mut sum = [0.0_f64; 3];
        for (i, row) in self.rows.iter().enumerate() {
            let value = f64::from(power(RANGE[0] + i as f32));
            for (sum, response) in sum.iter_mut().zip(row.to_array()) {
                *sum += value * f64::from(response);
            }
        }
        sum.map(|x| x as f32)
    }
}

/// XYZ of a spectral distribution, one at every wavelength having Y = 1.
pub(crate) fn xyz(power: impl Fn(f32) -> f32) -> [f32; 3] {
    observer().xyz(power)
}

/// The illuminant in the column `name` of the table, of luminance one.
pub(crate) fn illuminant(name: &str) -> Option<DenseSpectrum> {
    let pairs = column(ILLUMINANTS, name)?;
    Some(with_luminance_one(DenseSpectrum::new(|nm| interpolate(&pairs, nm, Outside::Zero))))
}

/// `power` scaled to luminance one; black stays black.
pub(crate) fn with_luminance_one(power: DenseSpectrum) -> DenseSpectrum {
    let [_, y, _] = xyz(|nm| power.at(nm));
    if y > 0.0 { power.map(|value| value / y) } else { power }
}

/// The white of a colour space as light, of luminance one: D65, or the daylight of ACES.
pub(crate) fn white(space: ColorSpace) -> &'static DenseSpectrum {
    static D65: LazyLock<DenseSpectrum> =
        LazyLock::new(|| illuminant("D65").expect("the table of illuminants has D65"));
    static ACES: LazyLock<DenseSpectrum> =
        LazyLock::new(|| illuminant("acesD60").expect("the table of illuminants has the white of ACES"));
    match space {
        ColorSpace::Srgb | ColorSpace::DciP3 | ColorSpace::Rec2020 => &D65,
        ColorSpace::Aces2065_1 => &ACES,
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn chromaticity([x, y, z]: [f32; 3]) -> [f32; 2] {
        [x / (x + y + z), y / (x + y + z)]
    }

    #[test]
    fn the_observer_sees_equal_energy_as_white() {
        // The tables add up to 106.865, 106.857 and 106.892 (CIE 15:2004, table T.4).
        for (found, expected) in xyz(|_| 1.0).into_iter().zip([106.865, 106.857, 106.892]) {
            assert!((found - expected / 106.857).abs() < 1e-5, "{found}");
        }
        let raw = column(FUNCTIONS, "y").unwrap().iter().map(|&(_, y)| f64::from(y)).sum::<f64>();
        assert!((raw - 106.857).abs() < 1e-3, "{raw}");
    }

    #[test]
    fn a_black_body_has_its_chromaticity() {
        // CIE illuminant A is a black body at 2856 K: x = 0.44757, y = 0.40745 (CIE 15:2004).
        let [x, y] = chromaticity(xyz(|lambda| blackbody(2855.5, lambda)));
        assert!((x - 0.44757).abs() < 1e-4 && (y - 0.40745).abs() < 1e-4, "{x} {y}");
    }

    #[test]
    fn a_black_body_peaks_at_one_by_wiens_law() {
        assert!((blackbody(5000.0, 579.554_4) - 1.0).abs() < 1e-6);
        assert!(blackbody(5000.0, 560.0) < 1.0 && blackbody(5000.0, 600.0) < 1.0);
        assert_eq!(blackbody(0.0, 500.0), 0.0);
        assert!(blackbody(1.0, 360.0).is_finite());
    }

    #[test]
    fn whites_are_those_of_the_standards() {
        for space in ColorSpace::ALL {
            let seen = xyz(|nm| white(space).at(nm));
            assert!((seen[1] - 1.0).abs() < 1e-5);
            let [x, y] = chromaticity(seen);
            let [wx, wy] = space.chromaticities().white;
            assert!(
                (f64::from(x) - wx).abs() < 1e-4 && (f64::from(y) - wy).abs() < 1e-4,
                "{space:?} {x} {y}"
            );
        }
    }
}
