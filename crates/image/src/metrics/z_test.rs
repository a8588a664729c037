//! Whether images differ from a reference by more than their noise: z-tests over tiles.
//!
//! A difference image shows noise; a bias hides in it. Averaged over a tile of 16×16 pixels the noise shrinks sixteenfold
//! and the bias stays, and over the whole picture it shrinks further. So each tile and channel gives a deviate
//! `z = (mean of test − mean of reference) / standard error`, which is about normal where there is no bias, and three
//! figures of all deviates are judged: their root mean square (many small biases), the largest (one large bias), and the
//! deviate of the whole picture (an overall one).
//!
//! Source: Jung, Hanika, Dachsbacher 2020, *Detecting Bias in Monte Carlo Renderers using Welch's t-test* (tiles and the
//! idea); deviation: variances come from all pixels of a tile, so that they have many degrees of freedom even with two
//! tests, and the normal distribution is used.
//!
//! Heavy-tailed noise (fireflies) breaks the assumption of normal deviates and trips the test: then more samples decide.

use serde::Serialize;

use super::pixels::RgbPixels;
use super::probability::{erfc, gamma_q, sidak};
use crate::{Image, ImageError};

/// p-value below which the verdict is "biased".
const SIGNIFICANCE: f64 = 1e-4;
/// Differences below this share of the reference count as none where there is no noise to measure them by.
const NOISELESS_TOLERANCE: f64 = 1e-3;
/// The factor that [`ZTest::pixel_correlation`] may lower a variance by, at most.
const LEAST_CORRELATION: f64 = 0.25;

/// Settings of [`z_test`].
#[derive(Clone, Copy, Debug)]
pub struct ZTestOptions<'a> {
    /// Variance of each pixel of the reference; `None`: it has no noise.
    pub reference_variance: Option<&'a Image>,
    /// Variance of each pixel of each test image, in their order; `None`: estimated from the spread of the tests.
    pub test_variances: Option<&'a [Image]>,
    /// Side of a tile in pixels. Pixels right of and below the last whole tile are left out.
    pub tile: usize,
}

impl Default for ZTestOptions<'_> {
    /// No variances, tiles of 16 pixels.
    fn default() -> Self {
        ZTestOptions { reference_variance: None, test_variances: None, tile: 16 }
    }
}

/// What [`z_test`] found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ZTest {
    /// Number of test images.
    pub tests: usize,
    /// The variance of tile means over that of independent pixels: 1 unless neighbours vary together.
    pub pixel_correlation: f64,
    /// Figures of all deviates, and the verdict.
    #[serde(flatten)]
    pub figures: ZFigures,
    /// The deviates, one pixel a tile; infinite where something differs without noise.
    #[serde(skip)]
    pub tile_z: Image,
    /// Deviates of single pixels. With few tests their variances are poorly known: for looking, not for judging.
    #[serde(skip)]
    pub pixel_z: Image,
}

/// Figures of the deviates of all tiles and channels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ZFigures {
    /// Number of tiles; each has three deviates.
    pub tiles: usize,
    /// Deviate of the mean of the whole picture; standard normal without bias.
    pub z_global: f64,
    /// Root mean square of the deviates; about 1 without bias.
    pub z_rms: f64,
    /// Largest deviate; below 5 without bias.
    pub z_max: f64,
    /// Mean of the deviates.
    pub z_mean: f64,
    /// Share of the deviates beyond 3; 0.0027 without bias.
    pub fraction_above_3: f64,
    /// Tile channels without noise in which test and reference differ.
    pub different_without_noise: usize,
    /// Mean of the difference over the mean of the reference.
    pub relative_mean_difference: f64,
    /// Two-sided p-value of [`ZFigures::z_global`].
    pub p_global: f64,
    /// p-value of [`ZFigures::z_rms`], from the χ² distribution. The three channels of a tile count as one.
    pub p_rms: f64,
    /// p-value of [`ZFigures::z_max`], Šidák-corrected for the number of deviates.
    pub p_max: f64,
    /// Whether a p-value is below 1e-4, or something differs without noise.
    pub biased: bool,
}

/// Tests whether `tests`, renders of one scene with independent seeds and equal samples, have the mean `reference`.
///
/// Values are linear light. Values that are not finite count as 0.
///
/// # Errors
/// [`ImageError::SizesDiffer`] if an image has another size than the reference. [`ImageError::Metric`] without tests,
/// with one test and no variance image, with another number of variance images than tests, or with a tile that does not
/// fit into the picture.
pub fn z_test(tests: &[Image], reference: &Image, options: &ZTestOptions<'_>) -> Result<ZTest, ImageError> {
    let reference = RgbPixels::new(reference);
    let tests = matching(&reference, tests)?;
    let reference_variance = options.reference_variance.map(|image| reference.matching(image)).transpose()?;
    let test_variances = options.test_variances.map(|images| matching(&reference, images)).transpose()?;
    check(&reference, tests.len(), test_variances.as_ref().map(Vec::len), options.tile)?;

    let grid = Grid::new(reference.size, options.tile);
    let pixels = PixelStatistics::new(&tests, test_variances.as_deref());
    let correlation = match test_variances {
        Some(_) => 1.0,
        None => grid.correlation(&tests, &pixels),
    };
    let reference_values = to_f64(&reference);
    let reference_variance = reference_variance.map(|image| to_f64(&image));
    let reference_variance = reference_variance.unwrap_or_else(|| vec![[0.0; 3]; reference_values.len()]);

    let area = (options.tile * options.tile) as f64;
    let (tile_mean, tile_reference) = (grid.means(&pixels.mean), grid.means(&reference_values));
    let scale = correlation.max(LEAST_CORRELATION) / area;
    let test_part = grid.means(&pixels.variance_of_mean);
    let reference_part = grid.means(&reference_variance);
    let variance: Vec<[f64; 3]> =
        zip(&test_part, &reference_part, |test, reference| test * scale + reference / area);
    let difference = zip(&tile_mean, &tile_reference, |test, reference| test - reference);
    let deviates = deviates(&difference, &variance, &tile_reference);

    let pixel_variance =
        zip(&pixels.variance_of_mean, &reference_variance, |test, reference| test + reference);
    let pixel_difference = zip(&pixels.mean, &reference_values, |test, reference| test - reference);
    let pixel_deviates = self::deviates(&pixel_difference, &pixel_variance, &reference_values);
    let image = |[width, height]: [usize; 2], deviates: &[Deviate]| {
        Image::rgb_f32(width, height, deviates.iter().map(|deviate| deviate.value() as f32).collect())
    };
    Ok(ZTest {
        tests: tests.len(),
        pixel_correlation: correlation,
        figures: ZFigures::new(&deviates, &difference, &variance, &tile_reference),
        tile_z: image(grid.size, &deviates)?,
        pixel_z: image(reference.size, &pixel_deviates)?,
    })
}

fn matching(reference: &RgbPixels, images: &[Image]) -> Result<Vec<RgbPixels>, ImageError> {
    images.iter().map(|image| reference.matching(image)).collect()
}

fn check(
    reference: &RgbPixels,
    tests: usize,
    variances: Option<usize>,
    tile: usize,
) -> Result<(), ImageError> {
    let [width, height] = reference.size;
    let message = if tests == 0 {
        "the z-test needs a test image".to_string()
    } else if tests == 1 && variances.is_none() {
        "the z-test needs two or more test images, or a variance image".to_string()
    } else if variances.is_some_and(|count| count != tests) {
        format!(
            "the z-test needs one variance image a test image, found {} for {tests}",
            variances.unwrap_or(0)
        )
    } else if tile == 0 || tile > width || tile > height {
        format!("a tile of {tile}x{tile} pixels does not fit into {width}x{height} pixels")
    } else {
        return Ok(());
    };
    Err(ImageError::Metric(message))
}

fn to_f64(pixels: &RgbPixels) -> Vec<[f64; 3]> {
    pixels.colors.iter().map(|color| color.map(f64::from)).collect()
}

/// `function` of each pair of channels.
fn zip(a: &[[f64; 3]], b: &[[f64; 3]], function: impl Fn(f64, f64) -> f64) -> Vec<[f64; 3]> {
    let pairs = a.iter().zip(b);
    pairs.map(|(a, b)| [0, 1, 2].map(|channel| function(a[channel], b[channel]))).collect()
}

/// Per pixel: the mean of the tests, and the variance of that mean.
struct PixelStatistics {
    mean: Vec<[f64; 3]>,
    variance_of_mean: Vec<[f64; 3]>,
}

impl PixelStatistics {
    fn new(tests: &[RgbPixels], variances: Option<&[RgbPixels]>) -> PixelStatistics {
        let (count, pixels) = (tests.len() as f64, tests[0].colors.len());
        let average = |pixel: usize, channel: usize, images: &[RgbPixels]| {
            images.iter().map(|image| f64::from(image.colors[pixel][channel])).sum::<f64>() / count
        };
        let per_channel = |pixel| [0, 1, 2].map(|channel| average(pixel, channel, tests));
        let mean: Vec<[f64; 3]> = (0..pixels).map(per_channel).collect();
        let spread = |pixel: usize, channel: usize| {
            let mean = mean[pixel][channel];
            let squares = tests.iter().map(|test| (f64::from(test.colors[pixel][channel]) - mean).powi(2));
            squares.sum::<f64>() / (count - 1.0)
        };
        let variance = |pixel: usize, channel: usize| match variances {
            Some(images) => average(pixel, channel, images).max(0.0),
            None => spread(pixel, channel),
        };
        let of_mean = |pixel| [0, 1, 2].map(|channel| variance(pixel, channel) / count);
        PixelStatistics { variance_of_mean: (0..pixels).map(of_mean).collect(), mean }
    }
}

/// Whole tiles of a picture.
struct Grid {
    /// Tiles in a row, and rows of tiles.
    size: [usize; 2],
    tile: usize,
    picture_width: usize,
}

impl Grid {
    fn new([width, height]: [usize; 2], tile: usize) -> Grid {
        Grid { size: [width / tile, height / tile], tile, picture_width: width }
    }

    /// The mean of each tile.
    fn means(&self, pixels: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let [columns, rows] = self.size;
        let mut sums = vec![[0.0; 3]; columns * rows];
        let used = pixels.chunks_exact(self.picture_width).take(rows * self.tile).enumerate();
        for (y, row) in used {
            for (x, color) in row[..columns * self.tile].iter().enumerate() {
                let sum: &mut [f64; 3] = &mut sums[y / self.tile * columns + x / self.tile];
                sum.iter_mut().zip(color).for_each(|(sum, value)| *sum += value);
            }
        }
        let area = (self.tile * self.tile) as f64;
        sums.into_iter().map(|sum| sum.map(|value| value / area)).collect()
    }

    /// The factor by which the means of tiles vary more than those of independent pixels would, from the spread of the
    /// tests, over the whole picture; 1 without noise.
    fn correlation(&self, tests: &[RgbPixels], pixels: &PixelStatistics) -> f64 {
        let count = tests.len() as f64;
        let area = (self.tile * self.tile) as f64;
        let expected = self.means(&pixels.variance_of_mean);
        let mean = self.means(&pixels.mean);
        let mut squares = vec![[0.0; 3]; mean.len()];
        for test in tests {
            let deviations = zip(&self.means(&to_f64(test)), &mean, |value, mean| (value - mean).powi(2));
            squares = zip(&squares, &deviations, |sum, value| sum + value);
        }
        let ratio = |(squares, expected): (&f64, &f64)| {
            (*expected > 0.0).then(|| squares / (count - 1.0) / (expected * count / area))
        };
        let ratios: Vec<f64> =
            squares.as_flattened().iter().zip(expected.as_flattened()).filter_map(ratio).collect();
        if ratios.is_empty() { 1.0 } else { ratios.iter().sum::<f64>() / ratios.len() as f64 }
    }
}

/// A difference in units of its standard error.
#[derive(Clone, Copy)]
enum Deviate {
    /// There is noise to measure by.
    Measured(f64),
    /// There is no noise and no difference.
    Equal,
    /// There is no noise, but a difference.
    Different(f64),
}

impl Deviate {
    /// The deviate; infinite where something differs without noise.
    fn value(self) -> f64 {
        match self {
            Deviate::Measured(z) => z,
            Deviate::Equal => 0.0,
            Deviate::Different(difference) => f64::INFINITY.copysign(difference),
        }
    }
}

fn deviates(difference: &[[f64; 3]], variance: &[[f64; 3]], reference: &[[f64; 3]]) -> Vec<Deviate> {
    let values = difference.as_flattened().iter().zip(variance.as_flattened()).zip(reference.as_flattened());
    values
        .map(|((&difference, &variance), &reference)| {
            let error = variance.sqrt();
            let tolerance = NOISELESS_TOLERANCE * reference.abs().max(NOISELESS_TOLERANCE);
            if error > NOISELESS_TOLERANCE * tolerance {
                Deviate::Measured(difference / error)
            } else if difference.abs() > tolerance {
                Deviate::Different(difference)
            } else {
                Deviate::Equal
            }
        })
        .collect()
}

impl ZFigures {
    fn new(
        deviates: &[Deviate],
        difference: &[[f64; 3]],
        variance: &[[f64; 3]],
        reference: &[[f64; 3]],
    ) -> ZFigures {
        let measured = deviates.iter().filter_map(|deviate| match deviate {
            Deviate::Measured(z) => Some(*z),
            _ => None,
        });
        let mut measured: Vec<f64> = measured.collect();
        if measured.is_empty() {
            measured.push(0.0);
        }
        let different = deviates.iter().filter(|deviate| matches!(deviate, Deviate::Different(_)));
        let different_without_noise = different.count();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let z_rms = mean(&measured.iter().map(|z| z * z).collect::<Vec<f64>>()).sqrt();
        let z_max = measured.iter().fold(0.0, |largest: f64, z| largest.max(z.abs()));
        let mean_difference = mean(difference.as_flattened());
        let error = (mean(variance.as_flattened()) / reference.len() as f64).sqrt();
        let z_global = mean_difference / error.max(1e-12);
        let degrees = (measured.len() / 3).max(1) as f64;
        let two_sided = |z: f64| erfc(z.abs() / 2.0_f64.sqrt());
        let p_global = two_sided(z_global);
        let p_rms = gamma_q(degrees / 2.0, degrees / 2.0 * z_rms * z_rms);
        let p_max = sidak(two_sided(z_max), measured.len());
        let above = measured.iter().filter(|z| z.abs() > 3.0).count();
        ZFigures {
            tiles: reference.len(),
            z_global,
            z_rms,
            z_max,
            z_mean: mean(&measured),
            fraction_above_3: above as f64 / measured.len() as f64,
            different_without_noise,
            relative_mean_difference: mean_difference / mean(reference.as_flattened()).max(1e-12),
            p_global,
            p_rms,
            p_max,
            biased: p_global.min(p_rms).min(p_max) < SIGNIFICANCE || different_without_noise > 0,
        }
    }
}

#[cfg(test)]
mod tests;
