//! RGB colour spaces: primaries, whites, and the matrices between them.
//!
//! Decision: [`ColorSpace::convert`] keeps the XYZ tristimulus values, as pbrt does. The light that leaves a pixel is
//! then the same light in every space, and the white (1, 1, 1) of ACES (D60) comes out slightly warm in sRGB (D65).
//! That is right for radiance and for light sources. It is wrong for reflectances, where (1, 1, 1) means "all light"
//! under any white: [`ColorSpace::convert_reflectance`] maps white to white.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use super::matrix::{self, Matrix};

/// Primaries and white of an RGB space, the values being linear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ColorSpace {
    /// ITU-R BT.709 primaries, D65.
    #[default]
    Srgb,
    /// DCI-P3 primaries, D65.
    DciP3,
    /// ITU-R BT.2020 primaries, D65.
    Rec2020,
    /// ACES AP0 primaries, D60.
    Aces2065_1,
}

/// CIE 1931 (x, y) of the three primaries and of the white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chromaticities {
    /// Of red (1, 0, 0).
    pub red: [f64; 2],
    /// Of green (0, 1, 0).
    pub green: [f64; 2],
    /// Of blue (0, 0, 1).
    pub blue: [f64; 2],
    /// Of white (1, 1, 1).
    pub white: [f64; 2],
}

/// What happens to white on the way from one space to another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Adaptation {
    /// XYZ stays: for light.
    #[default]
    None,
    /// White becomes white, other colours move along by the Bradford transform: for reflectances.
    ///
    /// Source: Lam 1985; the matrix as in ICC.1:2022, annex E.
    Bradford,
}

/// D65 as the RGB standards round it.
const D65: [f64; 2] = [0.3127, 0.3290];

/// XYZ to the sharpened cone responses of the Bradford transform.
const BRADFORD: Matrix = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// (to XYZ, from XYZ) of the spaces in the order of [`ColorSpace::ALL`].
static MATRICES: LazyLock<[(Matrix, Matrix); 4]> = LazyLock::new(|| {
    ColorSpace::ALL.map(|space| {
        space.chromaticities().matrices().expect("the primaries of the standards span a triangle")
    })
});

impl ColorSpace {
    /// Every space.
    pub const ALL: [ColorSpace; 4] =
        [ColorSpace::Srgb, ColorSpace::DciP3, ColorSpace::Rec2020, ColorSpace::Aces2065_1];

    /// The name used in scene files and on the command line: `srgb`, `dci-p3`, `rec2020` or `aces2065-1`.
    pub const fn name(self) -> &'static str {
        match self {
            ColorSpace::Srgb => "srgb",
            ColorSpace::DciP3 => "dci-p3",
            ColorSpace::Rec2020 => "rec2020",
            ColorSpace::Aces2065_1 => "aces2065-1",
        }
    }

    /// The space of that [name](ColorSpace::name).
    pub fn from_name(name: &str) -> Option<ColorSpace> {
        ColorSpace::ALL.into_iter().find(|space| space.name() == name)
    }

    /// Primaries and white.
    ///
    /// Source: ITU-R BT.709-6 item 1.3; SMPTE EG 432-1 (P3) with D65; ITU-R BT.2020-2 table 3; SMPTE ST 2065-1 table 2.
    pub const fn chromaticities(self) -> Chromaticities {
        match self {
            ColorSpace::Srgb => {
                Chromaticities { red: [0.64, 0.33], green: [0.30, 0.60], blue: [0.15, 0.06], white: D65 }
            }
            ColorSpace::DciP3 => Chromaticities {
                red: [0.680, 0.320],
                green: [0.265, 0.690],
                blue: [0.150, 0.060],
                white: D65,
            },
            ColorSpace::Rec2020 => Chromaticities {
                red: [0.708, 0.292],
                green: [0.170, 0.797],
                blue: [0.131, 0.046],
                white: D65,
            },
            ColorSpace::Aces2065_1 => Chromaticities {
                red: [0.7347, 0.2653],
                green: [0.0, 1.0],
                blue: [0.0001, -0.0770],
                white: [0.32168, 0.33767],
            },
        }
    }

    /// The matrix from linear RGB to XYZ; its rows apply to (r, g, b), and white gives Y = 1.
    pub fn rgb_to_xyz_matrix(self) -> [[f64; 3]; 3] {
        MATRICES[self as usize].0
    }

    /// The inverse of [`ColorSpace::rgb_to_xyz_matrix`].
    pub fn xyz_to_rgb_matrix(self) -> [[f64; 3]; 3] {
        MATRICES[self as usize].1
    }

    /// CIE XYZ of a linear colour, Y of white being 1.
    pub fn rgb_to_xyz(self, rgb: [f32; 3]) -> [f32; 3] {
        transform(&self.rgb_to_xyz_matrix(), rgb)
    }

    /// The linear colour of CIE XYZ; components are negative outside the gamut.
    pub fn xyz_to_rgb(self, xyz: [f32; 3]) -> [f32; 3] {
        transform(&self.xyz_to_rgb_matrix(), xyz)
    }

    /// Luminance: Y of the linear colour, 1 for white.
    pub fn luminance(self, rgb: [f32; 3]) -> f32 {
        let row = MATRICES[self as usize].0[1];
        (row[0] * f64::from(rgb[0]) + row[1] * f64::from(rgb[1]) + row[2] * f64::from(rgb[2])) as f32
    }

    /// The matrix from linear RGB of this space to linear RGB of `to`; the identity for equal spaces.
    pub fn conversion_matrix(self, to: ColorSpace, adaptation: Adaptation) -> [[f64; 3]; 3] {
        if self == to {
            return matrix::IDENTITY;
        }
        let xyz = match adaptation {
            Adaptation::None => self.rgb_to_xyz_matrix(),
            Adaptation::Bradford => {
                let adapt = bradford(self.chromaticities().white, to.chromaticities().white);
                matrix::multiply(&adapt, &self.rgb_to_xyz_matrix())
            }
        };
        matrix::multiply(&to.xyz_to_rgb_matrix(), &xyz)
    }

    /// The light of the linear colour `rgb`, expressed in `to`. Nothing changes for equal spaces.
    pub fn convert(self, to: ColorSpace, rgb: [f32; 3]) -> [f32; 3] {
        if self == to { rgb } else { transform(&self.conversion_matrix(to, Adaptation::None), rgb) }
    }

    /// The reflectance `rgb`, expressed in `to`: white stays white. Nothing changes for equal spaces.
    pub fn convert_reflectance(self, to: ColorSpace, rgb: [f32; 3]) -> [f32; 3] {
        if self == to { rgb } else { transform(&self.conversion_matrix(to, Adaptation::Bradford), rgb) }
    }
}

impl Chromaticities {
    /// The space with these primaries and white, each within 0.001; files round them.
    pub fn nearest_space(&self) -> Option<ColorSpace> {
        let values = |c: &Chromaticities| [c.red, c.green, c.blue, c.white].concat();
        let own = values(self);
        ColorSpace::ALL.into_iter().find(|space| {
            values(&space.chromaticities()).iter().zip(&own).all(|(a, b)| (a - b).abs() <= 1e-3)
        })
    }

    /// The matrices from linear RGB to XYZ and back; `None` if the primaries lie on a line or the white has y = 0.
    ///
    /// Source: SMPTE RP 177-1993, section 3.3.
    fn matrices(&self) -> Option<(Matrix, Matrix)> {
        let xyz = |[x, y]: [f64; 2]| [x, y, 1.0 - x - y];
        let primaries = matrix::transpose(&[xyz(self.red), xyz(self.green), xyz(self.blue)]);
        let white = xyz(self.white).map(|value| value / self.white[1]);
        let scale = matrix::apply(&matrix::inverse(&primaries)?, white);
        let to_xyz = matrix::multiply(&primaries, &matrix::diagonal(scale));
        Some((to_xyz, matrix::inverse(&to_xyz)?))
    }
}

/// The matrix from linear RGB of any primaries to `to`, XYZ staying; `None` if the primaries are degenerate.
pub(crate) fn conversion(from: &Chromaticities, to: ColorSpace) -> Option<[[f64; 3]; 3]> {
    Some(matrix::multiply(&to.xyz_to_rgb_matrix(), &from.matrices()?.0))
}

/// The Bradford matrix that takes XYZ under the white `from` to XYZ under the white `to`.
fn bradford(from: [f64; 2], to: [f64; 2]) -> Matrix {
    let response = |[x, y]: [f64; 2]| matrix::apply(&BRADFORD, [x / y, 1.0, (1.0 - x - y) / y]);
    let (from, to) = (response(from), response(to));
    let gain = matrix::diagonal([to[0] / from[0], to[1] / from[1], to[2] / from[2]]);
    let back = matrix::inverse(&BRADFORD).expect("the Bradford matrix is invertible");
    matrix::multiply(&back, &matrix::multiply(&gain, &BRADFORD))
}

/// `m v`, computed in `f64` and rounded once.
fn transform(m: &Matrix, v: [f32; 3]) -> [f32; 3] {
    matrix::apply(m, v.map(f64::from)).map(|value| value as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_close(found: [f32; 3], expected: [f32; 3], tolerance: f32) {
        for (f, e) in found.iter().zip(&expected) {
            assert!((f - e).abs() <= tolerance, "{found:?} is not {expected:?}");
        }
    }

    #[test]
    fn matrices_agree_with_the_standards() {
        // IEC 61966-2-1 prints the sRGB matrix to four places, SMPTE ST 2065-1 that of ACES to ten.
        assert_close(ColorSpace::Srgb.rgb_to_xyz([1.0, 0.0, 0.0]), [0.4124, 0.2126, 0.0193], 1e-4);
        assert_close(ColorSpace::Srgb.rgb_to_xyz([0.0, 1.0, 0.0]), [0.3576, 0.7152, 0.1192], 1e-4);
        assert_close(ColorSpace::Srgb.rgb_to_xyz([0.0, 0.0, 1.0]), [0.1805, 0.0722, 0.9505], 1e-4);
        let ap0 = ColorSpace::Aces2065_1.rgb_to_xyz_matrix();
        assert!((ap0[0][0] - 0.952_552_395_9).abs() < 1e-9);
        assert!((ap0[1][0] - 0.343_966_449_8).abs() < 1e-9);
        assert!((ap0[1][2] + 0.072_132_546_4).abs() < 1e-9);
        assert!((ap0[2][2] - 1.008_825_184_4).abs() < 1e-9);
        // ITU-R BT.2020-2 table 4: luminance is 0.2627 R + 0.6780 G + 0.0593 B.
        assert!((ColorSpace::Rec2020.luminance([1.0, 0.0, 0.0]) - 0.2627).abs() < 5e-5);
        assert!((ColorSpace::Rec2020.luminance([0.0, 1.0, 0.0]) - 0.6780).abs() < 5e-5);
    }

    #[test]
    fn white_has_luminance_one_and_the_chromaticity_of_the_white() {
        for space in ColorSpace::ALL {
            let [x, y, z] = space.rgb_to_xyz([1.0; 3]);
            let white = space.chromaticities().white;
            assert!((y - 1.0).abs() < 1e-6 && (space.luminance([1.0; 3]) - 1.0).abs() < 1e-6);
            assert!((f64::from(x / (x + y + z)) - white[0]).abs() < 1e-6);
        }
    }

    #[test]
    fn conversions_go_there_and_back() {
        let color = [0.8, 0.3, 0.1];
        for from in ColorSpace::ALL {
            assert_close(from.xyz_to_rgb(from.rgb_to_xyz(color)), color, 1e-6);
            for to in ColorSpace::ALL {
                assert_close(to.convert(from, from.convert(to, color)), color, 1e-6);
                assert_close(to.convert_reflectance(from, from.convert_reflectance(to, color)), color, 1e-6);
                let light = from.convert(to, color);
                assert!((to.luminance(light) - from.luminance(color)).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn equal_spaces_change_no_bit() {
        let color = [0.1, 1e-20, -3.7];
        for space in ColorSpace::ALL {
            assert_eq!(space.convert(space, color), color);
            assert_eq!(space.convert_reflectance(space, color), color);
        }
    }

    #[test]
    fn white_stays_white_only_when_adapted() {
        let adapted = ColorSpace::Aces2065_1.convert_reflectance(ColorSpace::Srgb, [1.0; 3]);
        assert_close(adapted, [1.0; 3], 1e-6);
        let light = ColorSpace::Aces2065_1.convert(ColorSpace::Srgb, [1.0; 3]);
        assert!(light[0] > 1.02 && light[2] < 0.95, "D60 is warmer than D65: {light:?}");
        assert_close(ColorSpace::DciP3.convert(ColorSpace::Srgb, [1.0; 3]), [1.0; 3], 1e-6);
    }

    #[test]
    fn spaces_are_found_by_name_and_by_rounded_primaries() {
        for space in ColorSpace::ALL {
            assert_eq!(ColorSpace::from_name(space.name()), Some(space));
            let mut rounded = space.chromaticities();
            rounded.white[0] += 4e-4;
            assert_eq!(rounded.nearest_space(), Some(space));
        }
        assert_eq!(ColorSpace::from_name("adobe"), None);
        let adobe = Chromaticities { green: [0.21, 0.71], ..ColorSpace::Srgb.chromaticities() };
        assert_eq!(adobe.nearest_space(), None);
        let line = Chromaticities { blue: [0.64, 0.33], ..ColorSpace::Srgb.chromaticities() };
        assert!(conversion(&line, ColorSpace::Srgb).is_none());
    }
}
