//! pbrt-v4's named spectra, as far as RGB can tell them.

/// What a name stands for in RGB mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NamedSpectrum {
    /// A quantity averaged over the responses of linear sRGB.
    Rgb([f32; 3]),
    /// A refractive index at the Fraunhofer d line, 587.6 nm.
    Index(f32),
    /// An illuminant by its chromaticity (x, y).
    Illuminant([f32; 2]),
}

/// The spectrum called `name`.
pub(crate) fn find(name: &str) -> Option<NamedSpectrum> {
    let metal = |&(symbol, eta, k): &(&str, [f32; 3], [f32; 3])| match name
        .strip_prefix("metal-")?
        .strip_prefix(symbol)?
    {
        "-eta" => Some(NamedSpectrum::Rgb(eta)),
        "-k" => Some(NamedSpectrum::Rgb(k)),
        _ => None,
    };
    let glass = |&(glass, index): &(&str, f32)| {
        (name.strip_prefix("glass-")? == glass).then_some(NamedSpectrum::Index(index))
    };
    let illuminant =
        |&(illuminant, xy): &(&str, [f32; 2])| (name == illuminant).then_some(NamedSpectrum::Illuminant(xy));
    METALS
        .iter()
        .find_map(metal)
        .or_else(|| GLASSES.iter().find_map(glass))
        .or_else(|| ILLUMINANTS.iter().find_map(illuminant))
}

/// Every name that [`find`] knows.
pub(crate) fn names() -> impl Iterator<Item = String> {
    let metals =
        METALS.iter().flat_map(|(symbol, ..)| [format!("metal-{symbol}-eta"), format!("metal-{symbol}-k")]);
    let glasses = GLASSES.iter().map(|(glass, _)| format!("glass-{glass}"));
    metals.chain(glasses).chain(ILLUMINANTS.iter().map(|&(name, _)| name.to_owned()))
}

/// η and k averaged over the responses of linear sRGB, each response scaled to average one.
///
/// Averages as they are in circulation for the measurements of Johnson and Christy 1972 (Ag, Au, Cu), Rakić 1998 (Al),
/// Querry 1985 (CuZn) and Stephens and Malitson 1952 (MgO); they were not recomputed from the measurements, and a scene
/// that uses them gets a warning. TiO2 is from Devore's formula of 1951 (ordinary ray). Responses of sRGB have negative
/// lobes: an average need not lie among the values of the curve.
#[rustfmt::skip]
const METALS: [(&str, [f32; 3], [f32; 3]); 7] = [
    ("Ag",   [0.1289, 0.1231, 0.1522], [4.0076, 3.2921, 2.3627]),
    ("Al",   [1.3757, 0.9283, 0.5736], [7.6560, 6.6107, 5.3230]),
    ("Au",   [0.1188, 0.3954, 1.5874], [3.3061, 2.5155, 1.7643]),
    ("CuZn", [0.3685, 0.5557, 1.2039], [3.0669, 2.9154, 2.0128]),
    ("Cu",   [0.1664, 0.9743, 1.2130], [3.2478, 2.5863, 2.3574]),
    ("MgO",  [1.7343, 1.7407, 1.7550], [0.0, 0.0, 0.0]),
    ("TiO2", [2.5980, 2.6480, 2.7765], [0.0, 0.0, 0.0]),
];

/// Index at the d line, from the makers' data sheets. pbrt's F5, F10 and F11 hold Schott's SF5, SF10 and SF11.
const GLASSES: [(&str, f32); 7] = [
    ("BK7", 1.5168),
    ("BAF10", 1.6700),
    ("FK51A", 1.4866),
    ("LASF9", 1.8503),
    ("F5", 1.6727),
    ("F10", 1.7283),
    ("F11", 1.7847),
];

/// Chromaticities of the CIE 1931 observer: CIE 15:2004, tables T.3 and T.8; ACES white from SMPTE ST 2065-1.
const ILLUMINANTS: [(&str, [f32; 2]); 16] = [
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
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_found() {
        assert_eq!(names().count(), 2 * METALS.len() + GLASSES.len() + ILLUMINANTS.len());
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
    fn metals_reflect_their_colour_at_normal_incidence() {
        let reflectance = |symbol: &str| {
            let rgb = |quantity: &str| match find(&format!("metal-{symbol}-{quantity}")) {
                Some(NamedSpectrum::Rgb(rgb)) => rgb,
                other => panic!("{other:?}"),
            };
            let (eta, k) = (rgb("eta"), rgb("k"));
            let r = |lane: usize| {
                let (n, k2) = (eta[lane], k[lane] * k[lane]);
                ((n - 1.0).powi(2) + k2) / ((n + 1.0).powi(2) + k2)
            };
            [r(0), r(1), r(2)]
        };
        // Normal-incidence colours as tabulated for real-time rendering (Akenine-Möller et al. 2018, table 9.2).
        for (symbol, expected) in [
            ("Ag", [0.972, 0.960, 0.915]),
            ("Al", [0.912, 0.914, 0.920]),
            ("Au", [1.000, 0.782, 0.344]),
            ("Cu", [0.955, 0.638, 0.538]),
        ] {
            let found = reflectance(symbol);
            for lane in 0..3 {
                assert!(
                    (found[lane] - expected[lane]).abs() < 0.05,
                    "{symbol}: {found:?} against {expected:?}"
                );
            }
        }
    }
}
