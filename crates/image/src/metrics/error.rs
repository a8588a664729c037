//! Errors of values: squared, relative, and of what a display shows.

use super::pixels::RgbPixels;
use crate::{Encoding, Image, ImageError};

/// What [`rel_mse`] adds to the squared reference, so that black pixels do not decide.
pub const RELATIVE_EPSILON: f64 = 0.01;

/// Share of the pixels, those with the largest errors, that [`rel_mse_trimmed`] leaves out.
const TRIMMED: f64 = 0.001;

/// Mean squared error over pixels and channels, in squared radiance.
///
/// # Errors
/// [`ImageError::SizesDiffer`]; [`ImageError::Metric`] for images without pixels.
pub fn mse(test: &Image, reference: &Image) -> Result<f64, ImageError> {
    let (test, reference) = RgbPixels::pair(test, reference)?;
    Ok(mean_square(&test, &reference))
}

/// Relative mean squared error: the mean of `(t − r)² / (r² + 0.01)` over pixels and channels. Errors as [`mse`].
///
/// Source: Rousselle, Knaus, Zwicker 2011, *Adaptive sampling and reconstruction using greedy error minimization*,
/// section 6 (there the luminance; here each channel).
pub fn rel_mse(test: &Image, reference: &Image) -> Result<f64, ImageError> {
    let (test, reference) = RgbPixels::pair(test, reference)?;
    Ok(mean(&relative_errors(&test, &reference)))
}

/// [`rel_mse`] without the 0.1 % of the pixels (at least one) that have the largest errors, so that a few fireflies do
/// not decide; 0 for an image of one pixel. Errors as [`mse`].
pub fn rel_mse_trimmed(test: &Image, reference: &Image) -> Result<f64, ImageError> {
    let (test, reference) = RgbPixels::pair(test, reference)?;
    Ok(trimmed_mean(relative_errors(&test, &reference)))
}

/// Peak signal-to-noise ratio, in decibels, of the images as a display shows them: clipped to 0 to 1 and sRGB-encoded.
/// Infinite for equal images. Errors as [`mse`].
pub fn psnr(test: &Image, reference: &Image) -> Result<f64, ImageError> {
    let (test, reference) = RgbPixels::pair(test, reference)?;
    Ok(signal_to_noise(&test, &reference))
}

pub(super) fn mean_square(test: &RgbPixels, reference: &RgbPixels) -> f64 {
    let pairs = test.colors.iter().flatten().zip(reference.colors.iter().flatten());
    let sum: f64 = pairs.map(|(&t, &r)| (f64::from(t) - f64::from(r)).powi(2)).sum();
    sum / (reference.colors.len() * 3) as f64
}

/// The relative squared error of each pixel, averaged over its channels.
pub(super) fn relative_errors(test: &RgbPixels, reference: &RgbPixels) -> Vec<f64> {
    let error = |(t, r): (&f32, &f32)| {
        let (t, r) = (f64::from(*t), f64::from(*r));
        (t - r).powi(2) / (r * r + RELATIVE_EPSILON)
    };
    let pixels = test.colors.iter().zip(&reference.colors);
    pixels.map(|(t, r)| t.iter().zip(r).map(error).sum::<f64>() / 3.0).collect()
}

pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The mean of all but the largest values.
pub(super) fn trimmed_mean(mut values: Vec<f64>) -> f64 {
    let dropped = ((TRIMMED * values.len() as f64).round_ties_even() as usize).max(1);
    let kept = values.len() - dropped.min(values.len());
    if kept == 0 {
        return 0.0;
    }
    values.select_nth_unstable_by(kept, f64::total_cmp);
    mean(&values[..kept])
}

pub(super) fn signal_to_noise(test: &RgbPixels, reference: &RgbPixels) -> f64 {
    let shown = |value: f32| f64::from(Encoding::Srgb.encode(value.clamp(0.0, 1.0)));
    let pairs = test.colors.iter().flatten().zip(reference.colors.iter().flatten());
    let sum: f64 = pairs.map(|(&t, &r)| (shown(t) - shown(r)).powi(2)).sum();
    let error = sum / (reference.colors.len() * 3) as f64;
    -10.0 * error.log10()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ColorSpace;

    fn image(values: &[f32]) -> Image {
        Image::rgb_f32(values.len() / 3, 1, values.to_vec()).unwrap()
    }

    #[test]
    fn squared_errors_are_those_worked_out_by_hand() {
        let test = image(&[1.0, 2.0, 3.0, 0.5, 0.5, 0.5]);
        let reference = image(&[1.0, 1.0, 1.0, 0.5, 0.0, 0.5]);
        // (0 + 1 + 4 + 0 + 0.25 + 0) / 6
        assert!((mse(&test, &reference).unwrap() - 0.875).abs() < 1e-12);
        // (1/1.01 + 4/1.01 + 0.25/0.01) / 6
        let expected = (5.0 / 1.01 + 25.0) / 6.0;
        assert!((rel_mse(&test, &reference).unwrap() - expected).abs() < 1e-12);
        // The worse of the two pixels is left out.
        assert!((rel_mse_trimmed(&test, &reference).unwrap() - 5.0 / 1.01 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn the_trimmed_mean_drops_one_in_a_thousand() {
        let values: Vec<f64> = (0..2000).map(f64::from).collect();
        assert_eq!(trimmed_mean(values), 1997.0 / 2.0);
        assert_eq!(trimmed_mean(vec![4.0]), 0.0);
    }

    #[test]
    fn psnr_sees_only_what_is_shown() {
        let reference = image(&[1.0, 1.0, 1.0]);
        assert_eq!(psnr(&image(&[7.0, 1.0, 2.0]), &reference).unwrap(), f64::INFINITY);
        // Encoded 0.9 against 1 in every channel: 10 log10(1 / 0.01) = 20 dB.
        let dim = Encoding::Srgb.decode(0.9);
        assert!((psnr(&image(&[dim; 3]), &reference).unwrap() - 20.0).abs() < 1e-4);
    }

    #[test]
    fn primaries_are_converted_and_sizes_checked() {
        let reference = image(&[0.8, 0.5, 0.2]);
        let wide = reference.to_color_space(ColorSpace::Rec2020);
        assert!(mse(&wide, &reference).unwrap() < 1e-12);
        let error = mse(&image(&[0.0; 6]), &reference).unwrap_err().to_string();
        assert_eq!(error, "images of different size can't be compared: expected 1x1, found 2x1");
        assert!(mse(&image(&[]), &image(&[])).is_err());
    }

    #[test]
    fn values_that_are_not_finite_count_as_zero() {
        let test = image(&[f32::NAN, f32::INFINITY, 1.0]);
        assert_eq!(mse(&test, &image(&[0.0, 0.0, 1.0])).unwrap(), 0.0);
    }
}
