//! FLIP for low dynamic range: the difference that is seen when flipping between two images.
//!
//! Source: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild 2020, *FLIP: A Difference Evaluator for
//! Alternating Images*, with the constants of section 4. Deviation: the contrast sensitivity filters reach three
//! standard deviations of the wider Gaussian of blue-yellow, for all channels, as in the authors' code.
//!
//! Every filter is a sum of products of a function of x and one of y, and is applied as such.

mod appearance;
mod filter;

use filter::{Kernel, Plane};

use super::error::mean;
use super::pixels::RgbPixels;
use crate::{Image, ImageError};

/// The authors' viewing condition: a display of 3840 pixels in 0.7 m, seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f32 = 67.0206;

/// Amplitudes a and widths b of the contrast sensitivity `Σ aᵢ √(π/bᵢ) exp(−π² d² / bᵢ)` over the angle d, in degrees:
/// achromatic, red-green, blue-yellow.
const SENSITIVITY: [[(f32, f32); 2]; 3] =
    [[(1.0, 0.0047), (0.0, 1e-5)], [(1.0, 0.0053), (0.0, 1e-5)], [(34.1, 0.04), (13.5, 0.025)]];

/// Exponent of the colour difference.
const COLOR_EXPONENT: f32 = 0.7;
/// Share of the largest colour difference that is mapped to [`COLOR_KNEE_VALUE`].
const COLOR_KNEE: f32 = 0.4;
/// Where the slope of the colour map changes.
const COLOR_KNEE_VALUE: f32 = 0.95;
/// Width of the feature detectors, in degrees.
const FEATURE_WIDTH: f32 = 0.082;
/// Exponent of the feature difference.
const FEATURE_EXPONENT: f32 = 0.5;

/// The mean of [`flip_map`] at [`PIXELS_PER_DEGREE`]: 0 for equal images, at most 1.
///
/// # Errors
/// [`ImageError::SizesDiffer`]; [`ImageError::Metric`] for images without pixels.
pub fn flip(test: &Image, reference: &Image) -> Result<f64, ImageError> {
    let (test, reference) = RgbPixels::pair(test, reference)?;
    Ok(mean_flip(&test, &reference))
}

/// The difference seen at each pixel, 0 to 1, in a picture of one channel. The images are linear and clipped to 0 to 1
/// first; `pixels_per_degree` is how many pixels of the display one degree of sight covers.
///
/// # Errors
/// As [`flip`], and [`ImageError::Metric`] unless `pixels_per_degree` is in 1 to 1000.
pub fn flip_map(test: &Image, reference: &Image, pixels_per_degree: f32) -> Result<Image, ImageError> {
    if !(1.0..=1000.0).contains(&pixels_per_degree) {
        return Err(ImageError::Metric(format!(
            "the pixels per degree must be in 1 to 1000, found {pixels_per_degree}"
        )));
    }
    let (test, reference) = RgbPixels::pair(test, reference)?;
    let [width, height] = reference.size;
    Image::y_f32(width, height, map(&test, &reference, pixels_per_degree))
}

/// [`flip`] of converted images.
pub(super) fn mean_flip(test: &RgbPixels, reference: &RgbPixels) -> f64 {
    let values: Vec<f64> = map(test, reference, PIXELS_PER_DEGREE).into_iter().map(f64::from).collect();
    mean(&values)
}

/// Section 4.3: the colour difference, raised by features.
fn map(test: &RgbPixels, reference: &RgbPixels, pixels_per_degree: f32) -> Vec<f32> {
    let (test, reference) = (Opponent::new(test), Opponent::new(reference));
    let mut differences = color_differences(&test, &reference, pixels_per_degree);
    let features = feature_differences(&test.planes[0], &reference.planes[0], pixels_per_degree);
    for (color, feature) in differences.iter_mut().zip(features) {
        *color = color.powf(1.0 - feature);
    }
    differences
}

/// An image in the opponent space YCxCz.
struct Opponent {
    planes: [Plane; 3],
}

impl Opponent {
    fn new(pixels: &RgbPixels) -> Opponent {
        let [width, height] = pixels.size;
        let opponent = pixels.colors.iter().map(|color| {
            let clipped = color.map(|value| value.clamp(0.0, 1.0));
            appearance::opponent_from_rgb(clipped)
        });
        let mut planes = [0, 1, 2].map(|_| Vec::with_capacity(width * height));
        for color in opponent {
            planes.iter_mut().zip(color).for_each(|(plane, value)| plane.push(value));
        }
        Opponent { planes: planes.map(|values| Plane { width, height, values }) }
    }
}

/// Section 4.1: what the eye resolves of the colours, compared in a uniform space.
fn color_differences(test: &Opponent, reference: &Opponent, pixels_per_degree: f32) -> Vec<f32> {
    let kernels = [0, 1, 2].map(|channel| sensitivity(channel, pixels_per_degree));
    let [test, reference] = [test, reference].map(|image| {
        let planes = [0, 1, 2].map(|channel| filter::sum(&image.planes[channel], &kernels[channel]));
        let values = planes[0].values.iter().zip(&planes[1].values).zip(&planes[2].values);
        let perceived = values.map(|((&y, &cx), &cz)| appearance::perceived_from_opponent([y, cx, cz]));
        perceived.collect::<Vec<[f32; 3]>>()
    });
    let largest = appearance::largest_difference().powf(COLOR_EXPONENT);
    let knee = COLOR_KNEE * largest;
    let pairs = test.iter().zip(&reference);
    pairs
        .map(|(&t, &r)| {
            let difference = appearance::difference(t, r).powf(COLOR_EXPONENT);
            if difference < knee {
                COLOR_KNEE_VALUE / knee * difference
            } else {
                let above = (difference - knee) / (largest - knee);
                COLOR_KNEE_VALUE + above * (1.0 - COLOR_KNEE_VALUE)
            }
        })
        .collect()
}

/// The contrast sensitivity of a channel as a sum of separable kernels whose weights add up to 1.
fn sensitivity(channel: usize, pixels_per_degree: f32) -> Vec<(Kernel, Kernel)> {
    let pi = std::f32::consts::PI;
    let widest = SENSITIVITY[2][0].1;
    let radius = (3.0 * (widest / (2.0 * pi * pi)).sqrt() * pixels_per_degree).ceil() as usize;
    let gaussians = SENSITIVITY[channel].iter().filter(|(amplitude, _)| *amplitude > 0.0);
    let terms: Vec<(f32, Kernel)> = gaussians
        .map(|&(amplitude, width)| {
            let gaussian = |x: f32| (-(pi * x / pixels_per_degree).powi(2) / width).exp();
            (amplitude * (pi / width).sqrt(), Kernel::new(radius, gaussian))
        })
        .collect();
    let total: f32 = terms.iter().map(|(amplitude, kernel)| amplitude * kernel.sum().powi(2)).sum();
    terms.into_iter().map(|(amplitude, kernel)| (kernel.scaled(amplitude / total), kernel)).collect()
}

/// Section 4.2: where one image has an edge or a point and the other has not, 0 to 1.
fn feature_differences(test: &Plane, reference: &Plane, pixels_per_degree: f32) -> Vec<f32> {
    let deviation = 0.5 * FEATURE_WIDTH * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as usize;
    let gaussian = |x: f32| (-x * x / (2.0 * deviation * deviation)).exp();
    let smooth = Kernel::new(radius, gaussian).balanced();
    let edge = Kernel::new(radius, |x| -x * gaussian(x)).balanced();
    let point = Kernel::new(radius, |x| (x * x / (deviation * deviation) - 1.0) * gaussian(x)).balanced();
    let strengths = |kernel: &Kernel| {
        let [test, reference] = [test, reference].map(|plane| {
            // The detectors look at Y in 0 to 1; planes hold 116 Y − 16, and a constant has no features.
            let along_x = filter::separable(plane, kernel, &smooth);
            let along_y = filter::separable(plane, &smooth, kernel);
            let pairs = along_x.values.into_iter().zip(along_y.values);
            pairs.map(|(x, y)| x.hypot(y) / 116.0).collect::<Vec<f32>>()
        });
        test.into_iter().zip(reference).map(|(t, r)| (t - r).abs()).collect::<Vec<f32>>()
    };
    let (edges, points) = (strengths(&edge), strengths(&point));
    let pairs = edges.into_iter().zip(points);
    let largest = pairs.map(|(edge, point)| edge.max(point));
    largest.map(|value| (value / 2.0_f32.sqrt()).powf(FEATURE_EXPONENT).min(1.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture with structure: stripes of two widths in changing colours.
    fn stripes(width: usize, height: usize, phase: f32) -> Image {
        let value = |x: usize, y: usize, channel: usize| {
            let wave = (x as f32 * 0.37 + y as f32 * 0.11 * channel as f32 + phase).sin();
            0.5 + 0.45 * wave
        };
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let values = pixels.flat_map(|(x, y)| [0, 1, 2].map(|channel| value(x, y, channel))).collect();
        Image::rgb_f32(width, height, values).unwrap()
    }

    #[test]
    fn equal_images_show_no_difference() {
        let image = stripes(40, 30, 0.0);
        assert_eq!(flip(&image, &image).unwrap(), 0.0);
        let bright = Image::filled(5, 5, 3, 9.0).unwrap();
        assert_eq!(
            flip(&bright, &Image::filled(5, 5, 3, 4.0).unwrap()).unwrap(),
            0.0,
            "both are clipped to white"
        );
    }

    #[test]
    fn black_against_white_is_nearly_everything() {
        let black = Image::filled(8, 8, 3, 0.0).unwrap();
        let white = Image::filled(8, 8, 3, 1.0).unwrap();
        // A difference of 100 in lightness: 100^0.7 against the 0.4 and 1 of the largest difference between colours.
        let largest = appearance::largest_difference().powf(0.7);
        let share = (100.0_f32.powf(0.7) / largest - 0.4) / 0.6;
        let expected = f64::from(0.95 + 0.05 * share);
        assert!((flip(&white, &black).unwrap() - expected).abs() < 1e-4);
    }

    #[test]
    fn greater_shifts_are_seen_more() {
        let reference = stripes(64, 48, 0.0);
        let near = flip(&stripes(64, 48, 0.05), &reference).unwrap();
        let far = flip(&stripes(64, 48, 0.8), &reference).unwrap();
        assert!(0.0 < near && near < far && far < 1.0, "{near} {far}");
    }

    #[test]
    fn the_map_is_where_the_difference_is() {
        let reference = stripes(96, 64, 0.0);
        let mut test = reference.clone();
        if let crate::Pixels::F32(values) = &mut test.pixels {
            values[(20 * 96 + 20) * 3] = 1.0;
            values[(20 * 96 + 20) * 3 + 1] = 0.0;
        }
        let map = flip_map(&test, &reference, PIXELS_PER_DEGREE).unwrap();
        assert!(map.texel(20, 20, 0) > 0.05);
        assert_eq!(map.texel(80, 50, 0), 0.0);
        assert!(flip_map(&test, &reference, 0.0).is_err());
        assert!(flip_map(&test, &reference, f32::NAN).is_err());
    }
}
