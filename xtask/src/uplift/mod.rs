//! `cargo xtask uplift`: the tables by which spectral rendering turns RGB into spectra.
//!
//! For each colour space a table of 3 × 32³ cells: which component is the largest, its value z, and the other two over
//! it. A cell holds the three coefficients of a quadratic polynomial times √z, which are smooth down to black, as 16-bit
//! floats. All three axes are denser at their ends, where the coefficients bend most.
//!
//! Source: Jakob, Hanika, *A Low-Dimensional Function Space for Efficient Spectral Upsampling*, CGF 38(2), 2019. Where this
//! deviates is said in `solve` and here: the scaling by √z and the denser axes let 32³ cells do with half precision.
//!
//! Colours that are seen without noise have finer tables of their own (`plane`).
//!
//! Deliberately absent: reading the tables, which `sahl_render::spectrum` does.

mod half;
mod observer;
mod plane;
mod solve;

use std::fs;
use std::path::Path;

use glam::DVec3;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use sahl_image::ColorSpace;

use crate::Result;
use observer::Observer;
use plane::Plane;
use solve::Coefficients;

/// Cells along each axis; the renderer knows the same number.
const RESOLUTION: usize = 32;
/// What stands for the darkest cell: the limit of the coefficients is reached there to half precision.
const DARKEST: f64 = 1e-5;

/// Writes `uplift-SPACE.bin` and `uplift-light-SPACE.bin` for every colour space into `data`, from the tables of the observer and of the illuminants there.
pub(crate) fn run(data: &Path) -> Result<()> {
    let read = |name: &str| {
        fs::read_to_string(data.join(name)).map_err(|error| format!("can't read `{name}`: {error}"))
    };
    let write = |name: &str, bytes: Vec<u8>| {
        fs::write(data.join(name), bytes).map_err(|error| format!("can't write `{name}`: {error}"))
    };
    let (functions, illuminants) = (read("cie-1931-2deg.csv")?, read("cie-illuminants.csv")?);
    let d60 = read("illuminant-d60.csv")?;
    for space in ColorSpace::ALL {
        let white = if space == ColorSpace::Aces2065_1 { "acesD60" } else { "D65" };
        let observer = Observer::new(&functions, &illuminants, white)?;
        let name = format!("uplift-{}.bin", space.name());
        write(&name, table(&observer, space))?;
        let plane = Plane::new([&functions, &illuminants, &d60], space)?;
        write(&format!("uplift-light-{}.bin", space.name()), plane.table())?;
    }
    Ok(())
}

/// The value at place `index` of an axis: quadratic toward both ends.
fn node(index: usize) -> f64 {
    let u = index as f64 / (RESOLUTION - 1) as f64;
    if u < 0.5 { 2.0 * u * u } else { 1.0 - 2.0 * (1.0 - u) * (1.0 - u) }
}

/// The table of a space: by largest component, then its value, then the component before it, then the one after it.
fn table(observer: &Observer, space: ColorSpace) -> Vec<u8> {
    let cells = RESOLUTION * RESOLUTION;
    // Each column of cells is solved from dark to bright, on whichever core is free; the result does not depend on it.
    let columns: Vec<Vec<Coefficients>> =
        (0..3 * cells).into_par_iter().map(|at| column(observer, space, at / cells, at % cells)).collect();
    let mut bytes = Vec::with_capacity(3 * cells * RESOLUTION * 6);
    for largest in 0..3 {
        let columns = &columns[largest * cells..(largest + 1) * cells];
        for level in 0..RESOLUTION {
            for column in columns {
                for coefficient in column[level].to_array() {
                    bytes.extend(half::encode(coefficient as f32).to_le_bytes());
                }
            }
        }
    }
    bytes
}

/// The coefficients from dark to bright for one largest component and one pair of ratios.
fn column(observer: &Observer, space: ColorSpace, largest: usize, cell: usize) -> Vec<Coefficients> {
    let (after, before) = (node(cell % RESOLUTION), node(cell / RESOLUTION));
    let mut coefficients = DVec3::new(0.0, 0.0, -0.5);
    (0..RESOLUTION)
        .map(|level| {
            let brightness = node(level).max(DARKEST);
            let mut rgb = [0.0; 3];
            rgb[largest] = brightness;
            rgb[(largest + 1) % 3] = after * brightness;
            rgb[(largest + 2) % 3] = before * brightness;
            coefficients = solve::solve(observer, xyz(observer, space, rgb), brightness, coefficients);
            coefficients
        })
        .collect()
}

/// XYZ of linear RGB, whose white is that of the tabulated illuminant: the standards round it.
fn xyz(observer: &Observer, space: ColorSpace, rgb: [f64; 3]) -> [f64; 3] {
    let matrix = space.rgb_to_xyz_matrix();
    std::array::from_fn(|i| {
        let row = matrix[i];
        let white: f64 = row.iter().sum();
        (row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2]) * observer.white[i] / white
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const FUNCTIONS: &str = include_str!("../../../data/color/cie-1931-2deg.csv");
    const ILLUMINANTS: &str = include_str!("../../../data/color/cie-illuminants.csv");

    #[test]
    fn colours_of_srgb_are_met_exactly() {
        let observer = Observer::new(FUNCTIONS, ILLUMINANTS, "D65").unwrap();
        for rgb in
            [[0.9, 0.02, 0.1], [0.01, 0.3, 0.02], [0.0, 0.0, 1.0], [0.99, 0.98, 0.97], [1e-4, 2e-5, 0.0]]
        {
            let brightness = rgb.into_iter().fold(0.0, f64::max);
            let target = xyz(&observer, ColorSpace::Srgb, rgb);
            let found = solve::solve(&observer, target, brightness, DVec3::new(0.0, 0.0, -0.5));
            let (back, _) = solve::xyz(&observer, found, brightness);
            for (a, b) in back.into_iter().zip(target) {
                assert!((a - b).abs() < 1e-4 * brightness, "{rgb:?}: {back:?} instead of {target:?}");
            }
        }
    }

    #[test]
    fn the_tables_are_those_that_the_program_makes() {
        let observer = Observer::new(FUNCTIONS, ILLUMINANTS, "acesD60").unwrap();
        let bytes = include_bytes!("../../../data/color/uplift-aces2065-1.bin");
        for (largest, cell) in [(0, 0), (1, 517), (2, 1023)] {
            for (level, expected) in
                column(&observer, ColorSpace::Aces2065_1, largest, cell).iter().enumerate()
            {
                let at = ((largest * RESOLUTION + level) * RESOLUTION * RESOLUTION + cell) * 6;
                for (i, expected) in expected.to_array().into_iter().enumerate() {
                    let stored = half::decode(u16::from_le_bytes([bytes[at + 2 * i], bytes[at + 2 * i + 1]]));
                    // Mathematical libraries differ in last bits, which a search may enlarge.
                    let tolerance = 2e-3 * (1.0 + expected.abs());
                    assert!((f64::from(stored) - expected).abs() < tolerance, "{largest} {cell} {level}");
                }
            }
        }
    }
}
