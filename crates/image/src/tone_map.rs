//! From scene light to what a display can show.
//!
//! Deliberately absent: local operators and automatic exposure. A picture then depends on its pixels alone, and two
//! renders of one scene stay comparable.

use serde::{Deserialize, Serialize};

use crate::{ColorSpace, Encoding, Image, Pixels};

/// Exposure and curve for images of 8 or 16 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ToneMap {
    /// Light is multiplied by 2 to this power.
    pub exposure_stops: f32,
    /// Shape of the response.
    pub curve: Curve,
}

/// Shape of the response to light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Curve {
    /// Proportional, clipped to 0 to 1: what compares images honestly.
    #[default]
    Srgb,
    /// A film-like shoulder and toe, with highlights that fade to white.
    ///
    /// The fit of the ACES reference rendering transform and sRGB output transform by Stephen Hill (2015, published in
    /// Matt Pettineo's BakingLab, file `ACES.hlsl`). Deviation: light is first scaled by 1.4619, so that middle grey
    /// 0.18 stays 0.18 and the picture does not darken when the curve is chosen; the fit alone gives 0.106.
    Filmic,
}

/// Scene light of middle grey that the fit answers with 0.18, over 0.18: the positive root of Hill's quotient.
const FILMIC_SCALE: f32 = 1.461_922;

impl ToneMap {
    /// Linear display light in 0 to 1 of linear light with sRGB primaries. NaN becomes 0, infinity 1.
    pub fn apply(&self, rgb: [f32; 3]) -> [f32; 3] {
        let exposure = self.exposure_stops.exp2();
        let exposed = rgb.map(|value| {
            let light = value * exposure;
            if light.is_nan() { 0.0 } else { light.clamp(-1e9, 1e9) }
        });
        let shown = match self.curve {
            Curve::Srgb => exposed,
            Curve::Filmic => filmic(exposed),
        };
        shown.map(|value| value.clamp(0.0, 1.0))
    }

    /// The image as it is shown: sRGB primaries and sRGB-encoded floats in 0 to 1, colours divided by alpha.
    ///
    /// Only linear images hold scene light, so only they are exposed and bent; others are already made for a display
    /// and are merely re-encoded where they are not sRGB.
    #[must_use]
    pub fn develop(&self, image: &Image) -> Image {
        let pixels = Pixels::F32(self.display_values(image));
        Image { pixels, encoding: Encoding::Srgb, color_space: ColorSpace::Srgb, ..*image }
    }

    /// [`ToneMap::develop`], rounded to 8 bits.
    #[must_use]
    pub fn develop_u8(&self, image: &Image) -> Image {
        let pixels = Pixels::U8(self.display_bytes(image));
        Image { pixels, encoding: Encoding::Srgb, color_space: ColorSpace::Srgb, ..*image }
    }

    /// The values of [`ToneMap::develop_u8`].
    pub(crate) fn display_bytes(&self, image: &Image) -> Vec<u8> {
        match &image.pixels {
            Pixels::U8(values) if is_srgb(image) => values.clone(),
            _ => self.display_values(image).into_iter().map(quantize_u8).collect(),
        }
    }

    /// The values of [`ToneMap::develop`].
    pub(crate) fn display_values(&self, image: &Image) -> Vec<f32> {
        match &image.pixels {
            Pixels::U8(values) if is_srgb(image) => {
                return values.iter().map(|&v| f32::from(v) / 255.0).collect();
            }
            Pixels::F32(values) if is_srgb(image) => return values.iter().map(|&v| clamp_unit(v)).collect(),
            _ => {}
        }
        let mut light = image.to_color_space(ColorSpace::Srgb);
        let tone_map = if image.encoding == Encoding::Linear {
            light.unassociate_alpha();
            *self
        } else {
            ToneMap::default()
        };
        let Pixels::F32(mut values) = light.pixels else { return Vec::new() };
        let color_channels = image.color_channels();
        for pixel in values.chunks_exact_mut(image.channels) {
            let color = if color_channels == 3 { [pixel[0], pixel[1], pixel[2]] } else { [pixel[0]; 3] };
            let color = tone_map.apply(color).map(|value| Encoding::Srgb.encode(value));
            pixel[..color_channels].copy_from_slice(&color[..color_channels]);
            pixel[color_channels..].iter_mut().for_each(|alpha| *alpha = clamp_unit(*alpha));
        }
        values
    }
}

/// Whether the stored values are what a display takes.
fn is_srgb(image: &Image) -> bool {
    image.encoding == Encoding::Srgb && image.color_space == ColorSpace::Srgb
}

/// The nearest of 256 steps; values outside 0 to 1 are clamped, NaN becomes 0.
pub(crate) fn quantize_u8(value: f32) -> u8 {
    (value * 255.0 + 0.5) as u8
}

/// The nearest of 65536 steps; values outside 0 to 1 are clamped, NaN becomes 0.
pub(crate) fn quantize_u16(value: f32) -> u16 {
    (value * 65535.0 + 0.5) as u16
}

/// `value` clamped to 0 to 1; NaN becomes 0.
fn clamp_unit(value: f32) -> f32 {
    if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) }
}

/// Hill's fit: to a working space close to ACEScg, a rational curve a channel, and back.
fn filmic(rgb: [f32; 3]) -> [f32; 3] {
    const INPUT: [[f32; 3]; 3] =
        [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];
    const OUTPUT: [[f32; 3]; 3] =
        [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];
    let apply = |m: &[[f32; 3]; 3], v: [f32; 3]| m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
    let curve = |value: f32| {
        // Negative light lies outside the fit, whose quotient has a pole there.
        let light = value.max(0.0);
        let numerator = light * (light + 0.024_578_6) - 0.000_090_537;
        let denominator = light * (0.983_729 * light + 0.432_951) + 0.238_081;
        numerator / denominator
    };
    apply(&OUTPUT, apply(&INPUT, rgb.map(|value| value * FILMIC_SCALE)).map(curve))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILMIC: ToneMap = ToneMap { exposure_stops: 0.0, curve: Curve::Filmic };

    #[test]
    fn exposure_doubles_per_stop_and_clips() {
        let tone_map = ToneMap { exposure_stops: 1.0, curve: Curve::Srgb };
        assert_eq!(tone_map.apply([0.25, 0.7, -1.0]), [0.5, 1.0, 0.0]);
        assert_eq!(ToneMap::default().apply([f32::NAN, f32::INFINITY, f32::NEG_INFINITY]), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn filmic_keeps_middle_grey_rises_and_reaches_white() {
        for channel in FILMIC.apply([0.18; 3]) {
            assert!((channel - 0.18).abs() < 1e-4, "{channel}");
        }
        let mut previous = -1.0;
        for step in 0..200 {
            let value = FILMIC.apply([1.1_f32.powi(step - 100); 3])[1];
            assert!(value >= previous && (0.0..=1.0).contains(&value));
            previous = value;
        }
        assert_eq!(FILMIC.apply([1e6; 3]), [1.0; 3]);
        assert_eq!(FILMIC.apply([f32::INFINITY; 3]), [1.0; 3]);
        let hot = FILMIC.apply([50.0, 0.0, 0.0]);
        assert!(hot[1] > 0.1, "a very bright red fades to white: {hot:?}");
    }

    #[test]
    fn display_images_are_left_alone() {
        let bytes = Image::rgb_u8(1, 1, vec![10, 20, 30]).unwrap();
        let bright = ToneMap { exposure_stops: 3.0, curve: Curve::Filmic };
        assert_eq!(bright.develop_u8(&bytes), bytes);
        let squared = Image::rgb_f32(1, 1, vec![0.5; 3]).unwrap().with_encoding(Encoding::Gamma(2.0));
        let shown = bright.develop(&squared);
        let expected = Encoding::Srgb.encode(0.25);
        assert!((shown.pixel(0, 0)[0] - 0.25).abs() < 1e-6 && shown.encoding == Encoding::Srgb);
        assert!(matches!(&shown.pixels, Pixels::F32(v) if (v[0] - expected).abs() < 1e-6));
    }

    #[test]
    fn light_is_divided_by_alpha_before_the_curve() {
        let image = Image::new(1, 1, 4, Pixels::F32(vec![0.25, 0.25, 0.25, 0.5])).unwrap();
        let shown = ToneMap::default().develop_u8(&image);
        assert_eq!(shown.pixels, Pixels::U8(vec![188, 188, 188, 128]));
    }
}
