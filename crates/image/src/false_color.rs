//! Pictures of numbers: false colours, signed differences, errors, and images side by side.

use crate::color::ColorSpace;
use crate::metrics::RELATIVE_EPSILON;
use crate::tone_map::quantize_u8;
use crate::{Image, ImageError, Pixels, ToneMap};

/// Coefficients of powers 0 to 6 of the fit to viridis.
const VIRIDIS: [[f32; 3]; 7] = [
    [0.277_727_33, 0.005_407_344_5, 0.334_099_8],
    [0.105_093_04, 1.404_613_5, 1.384_590_2],
    [-0.330_861_83, 0.214_847_56, 0.095_095_16],
    [-4.634_230_5, -5.799_101, -19.332_441],
    [6.228_27, 14.179_933, 56.690_55],
    [4.776_385, -13.745_145, -65.353_03],
    [-5.435_456, 4.645_852_6, 26.312_435],
];

/// What values that are not numbers are shown as: no colour of the map comes near.
const NOT_A_NUMBER: [f32; 3] = [1.0, 0.0, 1.0];

/// The viridis colour of `x` in 0 to 1, sRGB-encoded; perceptually uniform, and readable without colour vision. Outside
/// the ends are repeated; NaN is magenta.
///
/// Source: Nathaniel Smith, Stéfan van der Walt 2015 (matplotlib, CC0); polynomial fit by Matt Zucker 2019 (CC0).
pub fn viridis(x: f32) -> [f32; 3] {
    if x.is_nan() {
        return NOT_A_NUMBER;
    }
    let x = x.clamp(0.0, 1.0);
    let horner = |channel: usize| VIRIDIS.iter().rev().fold(0.0, |sum, power| sum * x + power[channel]);
    [0, 1, 2].map(|channel: usize| horner(channel).clamp(0.0, 1.0))
}

/// The first channel of `values`, linear, in the colours of [`viridis`]: `low` dark violet, `high` yellow.
pub fn colorize(values: &Image, low: f32, high: f32) -> Image {
    let range = if high > low { high - low } else { f32::MIN_POSITIVE };
    let colors = pixel_indices(values).map(|(x, y)| viridis((values.texel(x, y, 0) - low) / range));
    display_image(values.width, values.height, colors)
}

/// Where `test` is darker (blue) or brighter (red) than `reference`, white being equal. Shown is the mean over the
/// channels of `(t − r) / √(r² + 0.01)`; `top` is fully coloured.
///
/// # Errors
/// [`ImageError::SizesDiffer`].
pub fn signed_difference(test: &Image, reference: &Image, top: f32) -> Result<Image, ImageError> {
    let pairs = pairs(test, reference)?;
    let colors = pairs.into_iter().map(|(test, reference)| {
        let mean = |color: [f32; 3]| color.iter().sum::<f32>() / 3.0;
        let scale = (mean(reference).powi(2) + RELATIVE_EPSILON as f32).sqrt();
        let share = (mean(test) - mean(reference)) / scale / top;
        if share.is_nan() {
            return NOT_A_NUMBER;
        }
        let faded = if share > 0.0 { [0.1, 0.9, 0.9] } else { [0.9, 0.75, 0.1] };
        faded.map(|fade| 1.0 - share.abs().min(1.0) * fade)
    });
    Ok(display_image(reference.width, reference.height, colors))
}

/// The relative squared error of each pixel, `(t − r)² / (r² + 0.01)` averaged over the channels, in the colours of
/// [`viridis`] on a logarithmic scale from 1e-5 to 1.
///
/// # Errors
/// [`ImageError::SizesDiffer`].
pub fn relative_error(test: &Image, reference: &Image) -> Result<Image, ImageError> {
    let pairs = pairs(test, reference)?;
    let colors = pairs.into_iter().map(|(test, reference)| {
        let errors =
            test.iter().zip(reference).map(|(t, r)| (t - r).powi(2) / (r * r + RELATIVE_EPSILON as f32));
        let error = errors.sum::<f32>() / 3.0;
        if error.is_nan() { NOT_A_NUMBER } else { viridis((error.max(1e-12).log10() + 5.0) / 5.0) }
    });
    Ok(display_image(reference.width, reference.height, colors))
}

/// Test, reference, signed difference (`top` 1) and relative error, side by side.
///
/// # Errors
/// [`ImageError::SizesDiffer`].
pub fn comparison(test: &Image, reference: &Image, tone_map: &ToneMap) -> Result<Image, ImageError> {
    let signed = signed_difference(test, reference, 1.0)?;
    let error = relative_error(test, reference)?;
    side_by_side(&[test.clone(), reference.clone(), signed, error], tone_map)
}

/// Images of the same height in a row, as a display shows them, three channels of 8 bits. Linear ones are tone mapped.
///
/// # Errors
/// [`ImageError::SizesDiffer`] if the heights differ; [`ImageError::Metric`] without images.
pub fn side_by_side(images: &[Image], tone_map: &ToneMap) -> Result<Image, ImageError> {
    let Some(first) = images.first() else {
        return Err(ImageError::Metric("there are no images to put side by side".into()));
    };
    if let Some(other) = images.iter().find(|image| image.height != first.height) {
        let (expected, found) = ([first.width, first.height], [other.width, other.height]);
        return Err(ImageError::SizesDiffer { expected, found });
    }
    let shown: Vec<(usize, Vec<u8>)> = images
        .iter()
        .map(|image| {
            let channels: &[usize] = if image.color_channels() == 1 { &[0, 0, 0] } else { &[0, 1, 2] };
            Ok((image.width * 3, tone_map.display_bytes(&image.select_channels(channels)?)))
        })
        .collect::<Result<_, ImageError>>()?;
    let width = images.iter().map(|image| image.width).sum();
    let rows = (0..first.height).flat_map(|y| {
        shown.iter().flat_map(move |(row, bytes)| bytes[y * row..(y + 1) * row].iter().copied())
    });
    Image::rgb_u8(width, first.height, rows.collect())
}

/// Colours of the test and of the reference at one pixel.
type Pair = ([f32; 3], [f32; 3]);

/// The colours of two images of one size, linear with sRGB primaries.
fn pairs(test: &Image, reference: &Image) -> Result<Vec<Pair>, ImageError> {
    let (expected, found) = ([reference.width, reference.height], [test.width, test.height]);
    if expected != found {
        return Err(ImageError::SizesDiffer { expected, found });
    }
    Ok(test.to_rgb(ColorSpace::Srgb).into_iter().zip(reference.to_rgb(ColorSpace::Srgb)).collect())
}

/// Coordinates of every pixel, row by row.
fn pixel_indices(image: &Image) -> impl Iterator<Item = (usize, usize)> {
    let width = image.width;
    (0..image.height).flat_map(move |y| (0..width).map(move |x| (x, y)))
}

/// An image of 8 bits of sRGB-encoded colours, one a pixel.
fn display_image(width: usize, height: usize, colors: impl Iterator<Item = [f32; 3]>) -> Image {
    let pixels = Pixels::U8(colors.flatten().map(quantize_u8).collect());
    let (encoding, color_space) = (crate::Encoding::Srgb, ColorSpace::Srgb);
    Image { width, height, channels: 3, pixels, encoding, color_space }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(image: &Image) -> &[u8] {
        match &image.pixels {
            Pixels::U8(values) => values,
            Pixels::F32(_) => panic!("expected 8 bits"),
        }
    }

    #[test]
    fn viridis_has_its_ends_and_rises_in_lightness() {
        // matplotlib: (68, 1, 84) at 0, (33, 145, 140) in the middle, (253, 231, 37) at 1.
        for (x, expected) in [(0.0, [68, 1, 84]), (0.5, [33, 145, 140]), (1.0, [253, 231, 37])] {
            for (found, expected) in viridis(x).map(quantize_u8).iter().zip(expected) {
                assert!(found.abs_diff(expected) <= 5, "{x}: {:?}", viridis(x));
            }
        }
        let lightness = |x: f32| {
            let linear = viridis(x).map(|value| crate::Encoding::Srgb.decode(value));
            ColorSpace::Srgb.luminance(linear)
        };
        for step in 0..100 {
            assert!(lightness((step + 1) as f32 / 100.0) > lightness(step as f32 / 100.0));
        }
        assert_eq!(viridis(f32::NAN), NOT_A_NUMBER);
        assert_eq!(viridis(7.0), viridis(1.0));
    }

    #[test]
    fn values_map_to_the_range() {
        let values = Image::y_f32(3, 1, vec![2.0, 4.0, f32::NAN]).unwrap();
        let shown = colorize(&values, 2.0, 4.0);
        let expected = [viridis(0.0), viridis(1.0), NOT_A_NUMBER].as_flattened().to_vec();
        assert_eq!(bytes(&shown), expected.into_iter().map(quantize_u8).collect::<Vec<u8>>());
    }

    #[test]
    fn signs_have_colours() {
        let reference = Image::filled(3, 1, 3, 0.5).unwrap();
        let test = Image::rgb_f32(3, 1, [[0.5; 3], [2.0; 3], [0.0; 3]].as_flattened().to_vec()).unwrap();
        let shown = signed_difference(&test, &reference, 1.0).unwrap();
        assert_eq!(bytes(&shown)[..3], [255, 255, 255]);
        assert_eq!(bytes(&shown)[3..6], [230, 26, 26]);
        assert!(bytes(&shown)[8] > bytes(&shown)[6], "darker is blue");
    }

    #[test]
    fn pictures_are_joined_row_by_row() {
        let test = Image::filled(2, 2, 3, 1.0).unwrap();
        let reference = Image::filled(2, 2, 3, 0.0).unwrap();
        let joined = comparison(&test, &reference, &ToneMap::default()).unwrap();
        assert_eq!((joined.width, joined.height), (8, 2));
        assert_eq!(bytes(&joined)[..9], [255, 255, 255, 255, 255, 255, 0, 0, 0]);
        assert_eq!(bytes(&joined)[24..27], [255, 255, 255], "the second row begins with the first picture");
        let other = Image::filled(2, 3, 1, 0.0).unwrap();
        assert!(side_by_side(&[test, other.clone()], &ToneMap::default()).is_err());
        assert!(side_by_side(&[], &ToneMap::default()).is_err());
        assert_eq!(side_by_side(&[other], &ToneMap::default()).unwrap().channels, 3);
    }
}
