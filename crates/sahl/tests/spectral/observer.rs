//! What a spectrum looks like, and which smooth spectrum looks like a colour, in double precision and without the renderer's tables.

use std::ops::Range;

use sahl::image::ColorSpace;

/// Wavelengths in nanometres, by one.
const RANGE: Range<u32> = 360..831;

/// The CIE 1931 standard observer under the white of sRGB.
pub(crate) struct Observer {
    /// x̄, ȳ, z̄ times the white at each wavelength; the white's luminance is one.
    rows: Vec<[f64; 3]>,
    /// The components of the white in linear sRGB, which are one but for the rounding of its chromaticity.
    white: [f64; 3],
}

impl Observer {
    pub(crate) fn load() -> Self {
        const FUNCTIONS: &str = include_str!("../../../../data/color/cie-1931-2deg.csv");
        const ILLUMINANTS: &str = include_str!("../../../../data/color/cie-illuminants.csv");
        let functions = ["x", "y", "z"].map(|name| column(FUNCTIONS, name));
        let d65 = column(ILLUMINANTS, "D65");
        let power = |i: usize| {
            let (at, rest) = (i / 5, (i % 5) as f64 / 5.0);
            d65[at] + rest * (d65.get(at + 1).unwrap_or(&0.0) - d65[at])
        };
        let luminance: f64 = functions[1].iter().enumerate().map(|(i, y)| y * power(i)).sum();
        let row = |i: usize| [0, 1, 2].map(|k| functions[k][i] * power(i) / luminance);
        let mut observer = Self { rows: RANGE.enumerate().map(|(i, _)| row(i)).collect(), white: [1.0; 3] };
        observer.white = observer.color(|_| 1.0);
        observer
    }

    /// The colour of a reflectance under the white, in linear sRGB.
    pub(crate) fn color(&self, reflectance: impl Fn(f64) -> f64) -> [f64; 3] {
        let mut xyz = [0.0; 3];
        for (nm, row) in RANGE.zip(&self.rows) {
            let value = reflectance(f64::from(nm));
            for (sum, response) in xyz.iter_mut().zip(row) {
                *sum += value * response;
            }
        }
        let matrix = ColorSpace::Srgb.xyz_to_rgb_matrix();
        [0, 1, 2].map(|i| (0..3).map(|k| matrix[i][k] * xyz[k]).sum::<f64>() / self.white[i])
    }

    /// The sigmoid of a quadratic polynomial that has the colour `rgb` under the white: Jakob and Hanika 2019.
    ///
    /// Newton's method, from grey toward the colour in small steps.
    pub(crate) fn reflectance(&self, rgb: [f64; 3]) -> impl Fn(f64) -> f64 + use<> {
        const STEPS: u32 = 50;
        let mut c = [0.0; 3];
        for step in 1..=3 * STEPS {
            let way = f64::from(step.min(STEPS)) / f64::from(STEPS);
            let goal = rgb.map(|x| 0.5 + (x - 0.5) * way);
            c = self.newton(c, goal);
        }
        let found = self.color(sigmoid(c));
        for (a, b) in found.into_iter().zip(rgb) {
            assert!((a - b).abs() < 1e-9, "{found:?}, not {rgb:?}");
        }
        sigmoid(c)
    }

    /// Light of the colour `rgb` over the white, as pbrt-v4 has it: twice the largest component times a reflectance.
    pub(crate) fn light(&self, rgb: [f64; 3]) -> impl Fn(f64) -> f64 + use<> {
        let scale = 2.0 * rgb.into_iter().fold(0.0, f64::max);
        let reflectance = self.reflectance(rgb.map(|x| x / scale));
        move |nm| scale * reflectance(nm)
    }

    /// The luminance of light that is `over_white` times the white, and `count` wavelengths that stand for equal shares of it.
    pub(crate) fn quantiles(&self, over_white: impl Fn(f64) -> f64, count: usize) -> (f64, Vec<f64>) {
        let seen: Vec<f64> =
            RANGE.zip(&self.rows).map(|(nm, row)| row[1] * over_white(f64::from(nm))).collect();
        let luminance: f64 = seen.iter().sum();
        let mut wavelengths = Vec::new();
        let mut sum = 0.0;
        for (nm, share) in RANGE.zip(seen) {
            let next = |found: usize| (found as f64 + 0.5) / count as f64 * luminance;
            while wavelengths.len() < count && next(wavelengths.len()) < sum + share {
                let within = (next(wavelengths.len()) - sum) / share;
                wavelengths.push(f64::from(nm) - 0.5 + within);
            }
            sum += share;
        }
        (luminance, wavelengths)
    }

    fn newton(&self, c: [f64; 3], goal: [f64; 3]) -> [f64; 3] {
        const STEP: f64 = 1e-5;
        let at = |k: usize, step: f64| {
            let mut moved = c;
            moved[k] += step;
            self.color(sigmoid(moved))
        };
        let found = self.color(sigmoid(c));
        let columns = [0, 1, 2].map(|k| {
            let (high, low) = (at(k, STEP), at(k, -STEP));
            [0, 1, 2].map(|i| (high[i] - low[i]) / (2.0 * STEP))
        });
        let missing = [0, 1, 2].map(|i| goal[i] - found[i]);
        // Cramer's rule.
        let determinant = volume(columns);
        [0, 1, 2].map(|k| {
            let mut replaced = columns;
            replaced[k] = missing;
            c[k] + volume(replaced) / determinant
        })
    }
}

/// The determinant of a matrix by its columns.
fn volume([a, b, c]: [[f64; 3]; 3]) -> f64 {
    let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
    a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]
}

fn sigmoid([a, b, c]: [f64; 3]) -> impl Fn(f64) -> f64 {
    move |nm| {
        let t = (nm - 595.0) / 235.0;
        let x = (a * t + b) * t + c;
        0.5 + 0.5 * x / (1.0 + x * x).sqrt()
    }
}

/// A column of a table with a line of names.
fn column(table: &str, name: &str) -> Vec<f64> {
    let mut lines = table.lines();
    let mut names = lines.next().expect("a line of names").split(',');
    let index = names.position(|found| found.trim() == name).expect("a column of this name");
    let number = |line: &str| line.split(',').nth(index).and_then(|text| text.trim().parse().ok());
    lines.map(|line| number(line).expect("a number in each column")).collect()
}
