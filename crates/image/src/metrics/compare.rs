//! All figures of a comparison at once.

use serde::Serialize;

use super::error::{mean, mean_square, relative_errors, signal_to_noise, trimmed_mean};
use super::flip::mean_flip;
use super::pixels::RgbPixels;
use super::z_test::{ZTest, ZTestOptions, z_test};
use crate::{Image, ImageError};

/// Figures of one or more test images against a reference.
///
/// Serialised, the maps of the z-test are left out; an infinite figure is not a number of JSON and becomes null there.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Pixels of the tests, all together, of which a value is not finite.
    pub non_finite_pixels: usize,
    /// Pixels of the tests, all together, of which a value is negative.
    pub negative_pixels: usize,
    /// Pixels of the reference of which a value is not finite.
    pub reference_non_finite_pixels: usize,
    /// Mean over the tests of [`mse`](super::mse).
    pub mse: f64,
    /// Mean over the tests of [`rel_mse_trimmed`](super::rel_mse_trimmed).
    pub rel_mse: f64,
    /// Mean over the tests of [`rel_mse`](super::rel_mse): shows fireflies.
    pub rel_mse_all: f64,
    /// Mean over the tests of [`psnr`](super::psnr); infinite if one equals the reference.
    pub psnr: f64,
    /// [`flip`](super::flip) of the first test.
    pub flip: f64,
    /// The z-test, if there is more than one test or the variance of the tests is given.
    pub z_test: Option<ZTest>,
    /// The numbers, from zero, of two tests that are equal in every pixel. The spread of such tests is not that of noise, and there
    /// is no z-test unless their variance is given.
    pub identical_tests: Option<[usize; 2]>,
}

/// Computes all figures of `tests` against `reference`.
///
/// # Errors
/// [`ImageError::SizesDiffer`]; [`ImageError::Metric`] without tests or pixels, or where [`z_test`] gives it. Pictures
/// smaller than a tile have no z-test.
pub fn compare(
    tests: &[Image],
    reference: &Image,
    options: &ZTestOptions<'_>,
) -> Result<Comparison, ImageError> {
    let pixels = RgbPixels::new(reference);
    let converted = tests.iter().map(|test| pixels.matching(test)).collect::<Result<Vec<_>, _>>()?;
    let Some(first) = converted.first().filter(|first| !first.colors.is_empty()) else {
        return Err(ImageError::Metric("there is nothing to compare".into()));
    };
    let average = |figure: &dyn Fn(&RgbPixels) -> f64| {
        let figures: Vec<f64> = converted.iter().map(figure).collect();
        mean(&figures)
    };
    let identical_tests = identical(&converted);
    let is_noise_known = options.test_variances.is_some() || tests.len() > 1 && identical_tests.is_none();
    let is_testable = is_noise_known && options.tile <= reference.width.min(reference.height);
    Ok(Comparison {
        non_finite_pixels: converted.iter().map(|test| test.non_finite).sum(),
        negative_pixels: converted.iter().map(|test| test.negative).sum(),
        reference_non_finite_pixels: pixels.non_finite,
        mse: average(&|test| mean_square(test, &pixels)),
        rel_mse: average(&|test| trimmed_mean(relative_errors(test, &pixels))),
        rel_mse_all: average(&|test| mean(&relative_errors(test, &pixels))),
        psnr: average(&|test| signal_to_noise(test, &pixels)),
        flip: mean_flip(first, &pixels),
        z_test: if is_testable { Some(z_test(tests, reference, options)?) } else { None },
        identical_tests,
    })
}

/// The first two images that have the same pixels.
fn identical(images: &[RgbPixels]) -> Option<[usize; 2]> {
    (0..images.len())
        .flat_map(|second| (0..second).map(move |first| [first, second]))
        .find(|&[first, second]| images[first].colors == images[second].colors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::{flip, mse, psnr, rel_mse, rel_mse_trimmed};

    fn image(seed: usize) -> Image {
        let value = |index: usize| 0.25 + ((index * 7919 + seed * 104_729) % 1000) as f32 / 2000.0;
        Image::rgb_f32(20, 20, (0..1200).map(value).collect()).unwrap()
    }

    #[test]
    fn the_figures_are_those_of_the_single_functions() {
        let (test, reference) = (image(1), image(2));
        let found = compare(std::slice::from_ref(&test), &reference, &ZTestOptions::default()).unwrap();
        assert_eq!(found.mse, mse(&test, &reference).unwrap());
        assert_eq!(found.rel_mse, rel_mse_trimmed(&test, &reference).unwrap());
        assert_eq!(found.rel_mse_all, rel_mse(&test, &reference).unwrap());
        assert_eq!(found.psnr, psnr(&test, &reference).unwrap());
        assert_eq!(found.flip, flip(&test, &reference).unwrap());
        assert_eq!(found.z_test, None);
        let several = [image(1), image(3)];
        let both = compare(&several, &reference, &ZTestOptions::default()).unwrap();
        assert!(both.mse > 0.0 && both.flip == found.flip && both.z_test.is_some());
    }

    #[test]
    fn the_same_image_twice_tells_nothing_of_noise() {
        let (test, reference) = (image(1), image(2));
        let tests = [image(3), test.clone(), test];
        let found = compare(&tests, &reference, &ZTestOptions::default()).unwrap();
        assert_eq!((found.identical_tests, found.z_test), (Some([1, 2]), None));
        let variances = [image(4), image(4), image(4)];
        let options = ZTestOptions { test_variances: Some(&variances), ..ZTestOptions::default() };
        assert!(compare(&tests, &reference, &options).unwrap().z_test.is_some());
    }

    #[test]
    fn odd_pixels_are_counted() {
        let mut values = vec![0.5; 12];
        values[0] = f32::NAN;
        values[4] = -0.5;
        let test = Image::rgb_f32(2, 2, values).unwrap();
        let reference = Image::filled(2, 2, 3, 0.5).unwrap();
        let found = compare(&[test.clone(), test], &reference, &ZTestOptions::default()).unwrap();
        assert_eq!((found.non_finite_pixels, found.negative_pixels), (2, 2));
        assert_eq!(found.z_test, None, "smaller than a tile");
        assert!(compare(&[], &reference, &ZTestOptions::default()).is_err());
    }
}
