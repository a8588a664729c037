//! Tables for colours whose largest component is a half: light, and whatever else is a multiple of a sigmoid.
//!
//! For each colour space 3 × 64² cells: which component is the largest, and the other two over it, in equal steps. A cell
//! holds the three coefficients of the polynomial as 32-bit floats. Skies are seen without noise, so that these tables are
//! finer than those of reflectances.
//!
//! The cells are those of Jakob and Hanika's own table between two of whose planes the half lies, which programs interpolate
//! over, made with the program's own tables and matrices: pbrt-v4 and others that read the authors' tables show the same colours to
//! 5e-5. The exact half under the exact illuminants would differ from them by up to 1e-3. White is none of the table's colours, and
//! stays white.
//!
//! Source: Jakob, Hanika, *A Low-Dimensional Function Space for Efficient Spectral Upsampling*, CGF 38(2), 2019, and the
//! program that comes with it (rgb2spec), for the places of cells, the illuminants and the matrices.

use glam::DVec3;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use sahl_image::ColorSpace;

use super::observer::{Illuminant, Observer};
use super::solve::{self, Coefficients};
use crate::Result;

/// Cells along each axis; the renderer knows the same number.
pub(super) const RESOLUTION: usize = 64;
/// CIE D65 and CIE D60 as the program has them.
const D65: Illuminant = Illuminant { name: "D65", last: 780.0, total: 10_566.864_005_283_874 };
const D60: Illuminant = Illuminant { name: "D60", last: 825.0, total: 10_536.3 };
/// The matrix of sRGB as it used to be rounded.
const SRGB_TO_XYZ: [[f64; 3]; 3] =
    [[0.412_453, 0.357_580, 0.180_423], [0.212_671, 0.715_160, 0.072_169], [0.019_334, 0.119_193, 0.950_227]];

/// What turns colours of one space into coefficients.
pub(super) struct Plane {
    observer: Observer,
    /// From RGB to XYZ under the observer's illuminant.
    to_xyz: [[f64; 3]; 3],
}

impl Plane {
    /// From the tables of the observer, of the illuminants and of CIE D60, in the format of the files in data/color/.
    pub(super) fn new(tables: [&str; 3], space: ColorSpace) -> Result<Self> {
        let [functions, illuminants, d60] = tables;
        let observer = match space {
            ColorSpace::Aces2065_1 => Observer::coarse(functions, d60, &D60),
            ColorSpace::Srgb | ColorSpace::DciP3 | ColorSpace::Rec2020 => {
                Observer::coarse(functions, illuminants, &D65)
            }
        }?;
        let to_xyz = if space == ColorSpace::Srgb { SRGB_TO_XYZ } else { space.rgb_to_xyz_matrix() };
        Ok(Self { observer, to_xyz })
    }

    /// The table: by largest component, then the component before it over it, then the one after it.
    pub(super) fn table(&self) -> Vec<u8> {
        let rows: Vec<Vec<u8>> = (0..3 * RESOLUTION)
            .into_par_iter()
            .map(|at| {
                let (largest, before) = (at / RESOLUTION, at % RESOLUTION);
                (0..RESOLUTION)
                    .flat_map(|after| self.cell(largest, before, after))
                    .flat_map(f32::to_le_bytes)
                    .collect()
            })
            .collect();
        rows.concat()
    }

    /// The coefficients of t², t and 1 in one cell.
    pub(super) fn cell(&self, largest: usize, before: usize, after: usize) -> [f32; 3] {
        let ratio = |index: usize| index as f64 / (RESOLUTION - 1) as f64;
        let sum: Coefficients = [level(31), level(32)]
            .into_iter()
            .map(|brightness| {
                let mut rgb = [0.0; 3];
                rgb[largest] = brightness;
                rgb[(largest + 1) % 3] = ratio(after) * brightness;
                rgb[(largest + 2) % 3] = ratio(before) * brightness;
                let target = self.to_xyz.map(|row| row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2]);
                solve::solve(&self.observer, target, brightness, DVec3::new(0.0, 0.0, -0.5))
                    / brightness.sqrt()
            })
            .sum();
        (0.5 * sum).to_array().map(|x| x as f32)
    }
}

/// The value of plane `index` of the authors' table, of 64.
fn level(index: u32) -> f64 {
    let smooth = |x: f64| x * x * (3.0 - 2.0 * x);
    smooth(smooth(f64::from(index) / 63.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_half_lies_between_the_planes() {
        assert!((level(31) + level(32) - 1.0).abs() < 1e-12 && level(31) > 0.48);
    }

    #[test]
    fn the_tables_are_those_that_the_program_makes() {
        let tables = [
            include_str!("../../../data/color/cie-1931-2deg.csv"),
            include_str!("../../../data/color/cie-illuminants.csv"),
            include_str!("../../../data/color/illuminant-d60.csv"),
        ];
        let stored: [(ColorSpace, &[u8]); 2] = [
            (ColorSpace::Srgb, include_bytes!("../../../data/color/uplift-light-srgb.bin")),
            (ColorSpace::Aces2065_1, include_bytes!("../../../data/color/uplift-light-aces2065-1.bin")),
        ];
        for (space, bytes) in stored {
            let plane = Plane::new(tables, space).unwrap();
            for (largest, before, after) in [(0, 60, 62), (1, 40, 50), (2, 36, 33), (2, 52, 54)] {
                let at = ((largest * RESOLUTION + before) * RESOLUTION + after) * 12;
                for (i, expected) in plane.cell(largest, before, after).into_iter().enumerate() {
                    let stored = f32::from_le_bytes(bytes[at + 4 * i..][..4].try_into().unwrap());
                    assert!(
                        (stored - expected).abs() < 1e-4 * (1.0 + expected.abs()),
                        "{space:?} {largest} {before} {after}"
                    );
                }
            }
        }
    }
}
