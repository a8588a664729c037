//! pbrt-v4's named spectra.
//!
//! Deliberately absent: the sensitivities of cameras, which are no spectra of materials or lights.

use super::cie;
use super::dense::DenseSpectrum;
use super::table::{Outside, interpolate};

/// Indices of refraction of metals and oxides: data/color/PROVENANCE.md.
const METALS: &str = include_str!("../../../../data/color/metals.csv");

/// What a name stands for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum NamedSpectrum {
    /// A quantity that was measured.
    Measured(DenseSpectrum),
    /// The refractive index of a glass, and its value at the Fraunhofer d line, 587.6 nm.
    Index {
        /// At the d line.
        index: f32,
        /// At every wavelength.
        dense: DenseSpectrum,
    },
    /// An illuminant, of luminance one.
    Illuminant(DenseSpectrum),
}

/// The spectrum called `name`.
pub(crate) fn find(name: &str) -> Option<NamedSpectrum> {
    if let Some(metal) = name.strip_prefix("metal-") {
        return measured(metal).map(NamedSpectrum::Measured);
    }
    if let Some(glass) = name.strip_prefix("glass-") {
        let &(_, coefficients) = GLASSES.iter().find(|(name, _)| *name == glass)?;
        let dense = DenseSpectrum::new(|nm| sellmeier(&coefficients, nm));
        return Some(NamedSpectrum::Index { index: sellmeier(&coefficients, D_LINE), dense });
    }
    let &(_, column) = ILLUMINANTS.iter().find(|(illuminant, _)| *illuminant == name)?;
    match column {
        Some(column) => cie::illuminant(column),
        None => Some(cie::with_luminance_one(DenseSpectrum::new(|nm| cie::blackbody(ILLUMINANT_A, nm)))),
    }
    .map(NamedSpectrum::Illuminant)
}

/// Every name that [`find`] knows.
pub(crate) fn names() -> impl Iterator<Item = String> {
    let metals =
        METAL_NAMES.iter().flat_map(|symbol| [format!("metal-{symbol}-eta"), format!("metal-{symbol}-k")]);
    let glasses = GLASSES.iter().map(|(glass, _)| format!("glass-{glass}"));
    metals.chain(glasses).chain(ILLUMINANTS.iter().map(|&(name, _)| name.to_owned()))
}

/// The quantity of a metal, such as `Cu-eta`.
fn measured(name: &str) -> Option<DenseSpectrum> {
    let (symbol, quantity) = name.rsplit_once('-')?;
    let column = match quantity {
        "eta" => 2,
        "k" => 3,
        _ => return None,
    };
    METAL_NAMES.contains(&symbol).then_some(())?;
    let samples: Option<Vec<(f32, f32)>> = METALS
        .lines()
        .filter(|line| line.split(',').next() == Some(symbol))
        .map(|line| {
            let words: Vec<&str> = line.split(',').collect();
            Some((words.get(1)?.parse().ok()?, words.get(column)?.parse().ok()?))
        })
        .collect();
    let samples = samples?;
    Some(DenseSpectrum::new(|nm| interpolate(&samples, nm, Outside::Ends)))
}

/// Metals and oxides in the table.
const METAL_NAMES: [&str; 7] = ["Ag", "Al", "Au", "CuZn", "Cu", "MgO", "TiO2"];

/// The Fraunhofer d line of helium, in nanometres.
const D_LINE: f32 = 587.561_8;

/// n² = 1 + Σ Bᵢ λ² / (λ² − Cᵢ), with λ in micrometres: Sellmeier 1871, in the form of the makers' data sheets.
fn sellmeier([b, c]: &[[f64; 3]; 2], nm: f32) -> f32 {
    let square = (f64::from(nm) * 1e-3).powi(2);
    let sum: f64 = b.iter().zip(c).map(|(b, c)| b * square / (square - c)).sum();
    (1.0 + sum).sqrt() as f32
}

/// Coefficients B and C of glasses, C in µm²: data/color/PROVENANCE.md. pbrt's F5, F10 and F11 hold Schott's SF5, SF10 and SF11.
#[rustfmt::skip]
const GLASSES: [(&str, [[f64; 3]; 2]); 7] = [
    ("BK7", [[1.03961212, 0.231792344, 1.01046945], [0.00600069867, 0.0200179144, 103.560653]]),
    ("BAF10", [[1.5851495, 0.143559385, 1.08521269], [0.00926681282, 0.0424489805, 105.613573]]),
    ("FK51A", [[0.971247817, 0.216901417, 0.904651666], [0.00472301995, 0.0153575612, 168.68133]]),
    ("LASF9", [[2.00029547, 0.298926886, 1.80691843], [0.0121426017, 0.0538736236, 156.530829]]),
    ("F5", [[1.52481889, 0.187085527, 1.42729015], [0.011254756, 0.0588995392, 129.141675]]),
    ("F10", [[1.62153902, 0.256287842, 1.64447552], [0.0122241457, 0.0595736775, 147.468793]]),
    ("F11", [[1.73759695, 0.313747346, 1.89878101], [0.013188707, 0.0623068142, 155.23629]]),
];

/// Kelvin of illuminant A: 2848 K by the second radiation constant of 1931, 1.435e7 nm K (CIE 15:2004, equation 3.1), and so
/// 2848 × 14.38777 / 14.35 by today's.
const ILLUMINANT_A: f32 = 2855.495;

/// Illuminants and their columns in the table; the one without is a formula.
const ILLUMINANTS: [(&str, Option<&str>); 16] = [
    ("stdillum-A", None),
    ("stdillum-D50", Some("D50")),
    ("stdillum-D65", Some("D65")),
    ("stdillum-F1", Some("F1")),
    ("stdillum-F2", Some("F2")),
    ("stdillum-F3", Some("F3")),
    ("stdillum-F4", Some("F4")),
    ("stdillum-F5", Some("F5")),
    ("stdillum-F6", Some("F6")),
    ("stdillum-F7", Some("F7")),
    ("stdillum-F8", Some("F8")),
    ("stdillum-F9", Some("F9")),
    ("stdillum-F10", Some("F10")),
    ("stdillum-F11", Some("F11")),
    ("stdillum-F12", Some("F12")),
    ("illum-acesD60", Some("acesD60")),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_found() {
        assert_eq!(names().count(), 2 * METAL_NAMES.len() + GLASSES.len() + ILLUMINANTS.len());
        assert!(names().all(|name| find(&name).is_some()));
        assert_eq!(find("metal-Xx-eta"), None);
        assert_eq!(find("metal-Cu"), None);
        assert_eq!(find("stdillum-F13"), None);
    }

    #[test]
    fn brass_is_not_copper() {
        assert_ne!(find("metal-CuZn-k"), find("metal-Cu-k"));
    }

    #[test]
    fn illuminants_have_their_chromaticities() {
        // CIE 15:2004, tables T.3 and T.8; the white of ACES from SMPTE ST 2065-1.
        for (name, [x, y]) in [
            ("stdillum-A", [0.44757, 0.40745]),
            ("stdillum-D50", [0.34567, 0.35850]),
            ("stdillum-D65", [0.31272, 0.32903]),
            ("stdillum-F1", [0.31310, 0.33727]),
            ("stdillum-F2", [0.37208, 0.37529]),
            ("stdillum-F3", [0.40910, 0.39430]),
            ("stdillum-F4", [0.44018, 0.40329]),
            ("stdillum-F5", [0.31379, 0.34531]),
            ("stdillum-F6", [0.37790, 0.38835]),
            ("stdillum-F7", [0.31292, 0.32933]),
            ("stdillum-F8", [0.34588, 0.35875]),
            ("stdillum-F9", [0.37417, 0.37281]),
            ("stdillum-F10", [0.34609, 0.35986]),
            ("stdillum-F11", [0.38052, 0.37713]),
            ("stdillum-F12", [0.43695, 0.40441]),
            ("illum-acesD60", [0.32168, 0.33767]),
        ] {
            let Some(NamedSpectrum::Illuminant(dense)) = find(name) else { panic!("{name}") };
            let seen = cie::xyz(|nm| dense.at(nm));
            let sum: f32 = seen.iter().sum();
            // The tables have five nanometres between their lines, which smooths the peaks of three-band lamps.
            let tolerance =
                if matches!(name, "stdillum-F10" | "stdillum-F11" | "stdillum-F12") { 1e-3 } else { 1e-4 };
            let error = (seen[0] / sum - x).abs().max((seen[1] / sum - y).abs());
            assert!(error < tolerance, "{name}: {} {}", seen[0] / sum, seen[1] / sum);
            assert!((seen[1] - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn glasses_have_the_indices_of_their_data_sheets() {
        // Schott, optical glass data sheets: n_d and the Abbe number (n_d − 1) / (n_F − n_C).
        for (glass, n_d, abbe) in [
            ("BK7", 1.51680, 64.17),
            ("BAF10", 1.67003, 47.11),
            ("FK51A", 1.48656, 84.47),
            ("LASF9", 1.85025, 32.17),
            ("F5", 1.67271, 32.25),
            ("F10", 1.72828, 28.53),
            ("F11", 1.78472, 25.68),
        ] {
            let Some(NamedSpectrum::Index { index, dense }) = find(&format!("glass-{glass}")) else {
                panic!("{glass}")
            };
            assert!((index - n_d).abs() < 1e-5, "{glass}: {index}");
            assert!((dense.at(587.561_8) - index).abs() < 1e-5);
            let found = (index - 1.0) / (dense.at(486.132_7) - dense.at(656.272_5));
            assert!((found - abbe).abs() < 0.02, "{glass}: {found}");
        }
    }

    #[test]
    fn metals_reflect_their_colour_at_normal_incidence() {
        use sahl_image::ColorSpace;
        let quantity = |name: String| match find(&name) {
            Some(NamedSpectrum::Measured(dense)) => dense,
            other => panic!("{other:?}"),
        };
        // Normal-incidence colours as tabulated for real-time rendering (Akenine-Möller et al. 2018, table 9.2).
        for (symbol, expected) in [
            ("Ag", [0.972, 0.960, 0.915]),
            ("Al", [0.912, 0.914, 0.920]),
            ("Au", [1.000, 0.782, 0.344]),
            ("Cu", [0.955, 0.638, 0.538]),
        ] {
            let (eta, k) = (quantity(format!("metal-{symbol}-eta")), quantity(format!("metal-{symbol}-k")));
            let reflectance = |nm: f32| {
                let (n, k2) = (eta.at(nm), k.at(nm) * k.at(nm));
                ((n - 1.0).powi(2) + k2) / ((n + 1.0).powi(2) + k2)
            };
            let white = cie::white(ColorSpace::Srgb);
            let found = ColorSpace::Srgb.xyz_to_rgb(cie::xyz(|nm| white.at(nm) * reflectance(nm)));
            for lane in 0..3 {
                assert!(
                    (found[lane] - expected[lane]).abs() < 0.05,
                    "{symbol}: {found:?} against {expected:?}"
                );
            }
        }
    }
}
