//! Whether two noisy images estimate the same picture: a test of each value, and of tiles.
//!
//! An image from random samples differs from its reference everywhere; the question is whether by more than its noise.
//! Each value is tested by the difference of the means over its standard error. With so many tests a few fail by chance
//! and by heavy tails, which is why the significance is shared out and a small fraction may fail. A bias too faint for
//! any pixel shows when a tile is summed up: noise averages out, bias does not. That part is
//! [`sahl_image::metrics::z_test`].
//!
//! Source: the rule for single values and its limits follow the render tests of Mitsuba 3. Deviation: Student's
//! distribution stands for the normal one, since the variances are estimates too.

use std::{fmt, slice};

use sahl_image::metrics::{ZTest, ZTestOptions, z_test};
use sahl_image::{Image, Pixels};

use crate::stats::{per_test, student_two_sided};

/// Rounding of an `f32` mean, relative to its size: below that a difference means nothing, even without noise.
const ROUNDING: f64 = 1e-5;

/// Mean and variance of the mean of each pixel, images of the same size and channels.
#[derive(Clone, Copy, Debug)]
pub struct Estimate<'a> {
    /// The mean of the samples.
    pub mean: &'a Image,
    /// The variance of that mean: of one sample, divided by the count of samples.
    pub variance: &'a Image,
}

/// How two estimates are compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageTest {
    /// Probability that a family of `tests` right images fails, by values as well as by tiles.
    pub significance: f64,
    /// The fraction of values that must pass.
    pub pass_fraction: f64,
    /// Samples a pixel behind each variance: few make the variance itself uncertain, and the test milder.
    pub samples: u32,
    /// Width and height of a tile; that of the image where it is smaller.
    pub tile: usize,
    /// How many tests share the significance.
    pub tests: usize,
}

impl Default for ImageTest {
    fn default() -> Self {
        Self { significance: 0.01, pass_fraction: 0.9975, samples: 64, tile: 16, tests: 1 }
    }
}

/// What a comparison found.
#[derive(Clone, Debug, PartialEq)]
pub struct ZReport {
    /// Difference over standard error of each value, `[height][width][channels]`; NaN where a value is not finite.
    pub z: Vec<f64>,
    /// How many values fail their test, those that are NaN included.
    pub rejected: usize,
    /// How many values are not finite, or have no valid variance.
    pub invalid: usize,
    /// Column, row and channel of the value with the largest `|z|`.
    pub worst: [usize; 3],
    /// What the tiles tell.
    pub tiles: ZTest,
    /// What is wrong, `None` if the images agree.
    pub failure: Option<String>,
}

impl ImageTest {
    /// Compares `test` with `reference`.
    ///
    /// Fails only when the images can't be compared, because they differ in shape or are empty; a disagreement is told
    /// by [`ZReport::failure`].
    pub fn compare(&self, test: Estimate, reference: Estimate) -> Result<ZReport, String> {
        let shape = |image: &Image| [image.width, image.height, image.channels];
        let expected @ [width, height, channels] = shape(reference.mean);
        for (name, image) in [
            ("the image", test.mean),
            ("its variance", test.variance),
            ("the variance of the reference", reference.variance),
        ] {
            if shape(image) != expected {
                return Err(format!("{name} is {:?}, the reference {expected:?}", shape(image)));
            }
        }
        let options = ZTestOptions {
            reference_variance: Some(reference.variance),
            test_variances: Some(slice::from_ref(test.variance)),
            tile: self.tile.min(width).min(height),
        };
        let tiles =
            z_test(slice::from_ref(test.mean), reference.mean, &options).map_err(|e| e.to_string())?;
        let z = scores(test, reference);
        let invalid = z.iter().filter(|z| z.is_nan()).count();
        // Welch's degrees of freedom lie between those of one side and of both together; the lower bound is milder.
        let degrees = f64::from(self.samples.max(2) - 1);
        let threshold = per_test(self.significance, self.tests.max(1) * z.len());
        let rejected = z.iter().filter(|&&z| student_two_sided(z, degrees) < threshold).count();
        let by_size = |&a: &usize, &b: &usize| z[a].abs().total_cmp(&z[b].abs());
        let worst = (0..z.len()).filter(|&i| !z[i].is_nan()).max_by(by_size).unwrap_or(0);
        let worst = [worst / channels % width, worst / channels / width, worst % channels];
        let mut report = ZReport { z, rejected, invalid, worst, tiles, failure: None };
        report.failure = self.failure(&report);
        Ok(report)
    }

    /// The sentence that a failed report tells.
    fn failure(&self, report: &ZReport) -> Option<String> {
        let (values, figures) = (report.z.len(), report.tiles.figures);
        if report.invalid > 0 {
            return Some(format!(
                "{} of {values} values are not finite or have no valid variance",
                report.invalid
            ));
        }
        let passed = 1.0 - report.rejected as f64 / values as f64;
        if passed < self.pass_fraction {
            return Some(format!(
                "{} of {values} values differ from the reference by more than their noise",
                report.rejected
            ));
        }
        if figures.different_without_noise > 0 {
            let count = figures.different_without_noise;
            return Some(format!("{count} tiles differ from the reference though there is no noise in them"));
        }
        let p = figures.p_global.min(figures.p_rms).min(figures.p_max);
        let threshold = per_test(self.significance, self.tests.max(1) * 3);
        (p < threshold)
            .then(|| format!("the image is biased over tiles: p = {p:.3e} is below {threshold:.3e}"))
    }
}

/// The difference of the means over its standard error, for each value.
fn scores(test: Estimate, reference: Estimate) -> Vec<f64> {
    let images = [test.mean, reference.mean, test.variance, reference.variance];
    let [tests, references, test_variances, reference_variances] = images.map(linear);
    let score = |i: usize| {
        let [t, r, vt, vr] =
            [tests[i], references[i], test_variances[i], reference_variances[i]].map(f64::from);
        let rounding = ROUNDING * t.abs().max(r.abs()).max(ROUNDING);
        let valid = vt >= 0.0 && vr >= 0.0 && vt.is_finite() && vr.is_finite() && t.is_finite();
        if valid { (t - r) / (vt + vr + rounding * rounding).sqrt() } else { f64::NAN }
    };
    (0..references.len()).map(score).collect()
}

impl fmt::Display for ZReport {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [x, y, channel] = self.worst;
        writeln!(f, "{}", self.failure.as_deref().unwrap_or("the images agree"))?;
        let worst = self.z.iter().filter(|z| !z.is_nan()).fold(0.0, |a: f64, z| a.max(z.abs()));
        writeln!(f, "  values: {} of {} rejected, {} invalid", self.rejected, self.z.len(), self.invalid)?;
        write!(f, "  worst value: |z| = {worst:.2} at pixel ({x}, {y}), channel {channel}")?;
        let figures = &self.tiles.figures;
        write!(
            f,
            "\n  tiles: {}; z of the image {:.2}, of the worst tile {:.2}, root mean square {:.3}",
            figures.tiles, figures.z_global, figures.z_max, figures.z_rms
        )
    }
}

/// The linear values of an image.
fn linear(image: &Image) -> Vec<f32> {
    match image.to_linear_f32().pixels {
        Pixels::F32(values) => values,
        Pixels::U8(values) => values.into_iter().map(|v| f32::from(v) / 255.0).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Rng;
    use crate::stats::Running;

    const WIDTH: usize = 48;
    const HEIGHT: usize = 40;

    /// Means and variances of `samples` exponential numbers a value; the mean rises across the image from 0 to 2.
    fn render(seed: u64, samples: u32, factor: impl Fn(usize, usize) -> f32) -> [Image; 2] {
        let mut rng = Rng::new(seed);
        let (mut mean, mut variance) = (Vec::new(), Vec::new());
        for i in 0..WIDTH * HEIGHT * 3 {
            let (x, y) = (i / 3 % WIDTH, i / 3 / WIDTH);
            let scale = f64::from(factor(x, y)) * 2.0 * x as f64 / WIDTH as f64;
            let value: Running = (0..samples).map(|_| -scale * (1.0 - rng.next_f64()).ln()).collect();
            mean.push(value.mean() as f32);
            variance.push(value.variance_of_mean() as f32);
        }
        [mean, variance].map(|values| Image::rgb_f32(WIDTH, HEIGHT, values).unwrap())
    }

    fn compare(test: &[Image; 2], reference: &[Image; 2]) -> ZReport {
        let [test, reference] = [test, reference].map(|[mean, variance]| Estimate { mean, variance });
        ImageTest::default().compare(test, reference).unwrap()
    }

    #[test]
    fn independent_estimates_of_the_same_picture_agree() {
        let mut squares = Running::default();
        for seed in 0..4 {
            let report = compare(&render(10 + seed, 64, |_, _| 1.0), &render(20 + seed, 64, |_, _| 1.0));
            assert_eq!(report.failure, None, "{report}");
            squares.add(report.tiles.figures.z_rms.powi(2));
        }
        // Four times six tiles of three channels.
        assert!((0.7..1.3).contains(&squares.mean()), "{squares:?}");
    }

    #[test]
    fn a_bias_of_one_per_cent_shows_in_the_tiles_alone() {
        let report = compare(&render(1, 400, |_, _| 1.01), &render(2, 400, |_, _| 1.0));
        assert!(report.rejected < 10, "{report}");
        assert!(report.failure.clone().unwrap().contains("biased over tiles"), "{report}");
    }

    #[test]
    fn a_wrong_tile_and_wrong_pixels_show() {
        let tile = |x: usize, y: usize| if (16..32).contains(&x) && y < 16 { 1.1 } else { 1.0 };
        let report = compare(&render(3, 64, tile), &render(4, 64, |_, _| 1.0));
        assert!(report.failure.is_some(), "{report}");
        let speckle = |x: usize, y: usize| if (x * 7 + y * 13).is_multiple_of(100) { 4.0 } else { 1.0 };
        let report = compare(&render(5, 64, speckle), &render(6, 64, |_, _| 1.0));
        assert!(report.failure.clone().unwrap().contains("by more than their noise"), "{report}");
    }

    #[test]
    fn what_is_not_finite_fails() {
        let mut test = render(7, 16, |_, _| 1.0);
        let Pixels::F32(values) = &mut test[0].pixels else { unreachable!() };
        values[17] = f32::NAN;
        let report = compare(&test, &render(8, 16, |_, _| 1.0));
        assert_eq!(report.invalid, 1);
        assert!(report.failure.unwrap().contains("not finite"));
    }

    #[test]
    fn values_without_noise_must_be_equal() {
        let [mean, _] = render(9, 16, |_, _| 1.0);
        let zero = Image::filled(WIDTH, HEIGHT, 3, 0.0).unwrap();
        let exact = [mean.clone(), zero.clone()];
        assert_eq!(compare(&exact, &exact).failure, None);
        let Pixels::F32(values) = mean.pixels else { unreachable!() };
        let shifted = Image::rgb_f32(WIDTH, HEIGHT, values.iter().map(|v| v * 1.001).collect()).unwrap();
        assert!(compare(&[shifted, zero], &exact).failure.is_some());
    }

    #[test]
    fn different_shapes_are_an_error() {
        let small = Image::filled(4, 4, 3, 0.0).unwrap();
        let large = Image::filled(4, 5, 3, 0.0).unwrap();
        let test = Estimate { mean: &large, variance: &large };
        let error =
            ImageTest::default().compare(test, Estimate { mean: &small, variance: &small }).unwrap_err();
        assert_eq!(error, "the image is [4, 5, 3], the reference [4, 4, 3]");
    }
}
