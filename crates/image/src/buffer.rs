//! Pixel buffers.

use serde::{Deserialize, Serialize};

use crate::{ColorSpace, Encoding, ImageError};

/// A rectangle of pixels with one to four channels each: Y, YA, RGB or RGBA; top row first, channels interleaved.
///
/// Alpha follows the custom of the files an image comes from and goes to: colours of [`Encoding::Linear`] images are
/// multiplied by alpha (as in EXR), colours of all other images are not (as in PNG and TGA). The codecs convert.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Image {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Channels a pixel: 1 (Y), 2 (YA), 3 (RGB) or 4 (RGBA).
    pub channels: usize,
    /// `width × height × channels` values.
    pub pixels: Pixels,
    /// What the stored values mean; alpha is always linear.
    pub encoding: Encoding,
    /// Primaries and white of the colours.
    pub color_space: ColorSpace,
}

/// Storage of an [`Image`]: `[height][width][channels]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Pixels {
    /// 0 to 255 for 0 to 1.
    U8(Vec<u8>),
    /// Floats.
    F32(Vec<f32>),
}

impl Pixels {
    /// Number of values stored.
    pub fn len(&self) -> usize {
        match self {
            Pixels::U8(values) => values.len(),
            Pixels::F32(values) => values.len(),
        }
    }

    /// Whether nothing is stored.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Image {
    /// An image of the values `pixels`, `[height][width][channels]`, in linear sRGB primaries unless changed with
    /// [`Image::with_encoding`] and [`Image::with_color_space`].
    ///
    /// # Errors
    /// [`ImageError::ChannelCount`] unless there are one to four channels; [`ImageError::WrongLength`] unless there
    /// are `width × height × channels` values. Empty images (a side of 0) are allowed.
    pub fn new(width: usize, height: usize, channels: usize, pixels: Pixels) -> Result<Image, ImageError> {
        if !(1..=4).contains(&channels) {
            return Err(ImageError::ChannelCount { found: channels });
        }
        let expected = width.checked_mul(height).and_then(|count| count.checked_mul(channels));
        if expected != Some(pixels.len()) {
            let (expected, found) = (expected.unwrap_or(usize::MAX), pixels.len());
            return Err(ImageError::WrongLength { width, height, channels, expected, found });
        }
        let (encoding, color_space) = (Encoding::Linear, ColorSpace::Srgb);
        Ok(Image { width, height, channels, pixels, encoding, color_space })
    }

    /// A linear image of one channel. Errors as [`Image::new`].
    pub fn y_f32(width: usize, height: usize, values: Vec<f32>) -> Result<Image, ImageError> {
        Image::new(width, height, 1, Pixels::F32(values))
    }

    /// A linear RGB image with sRGB primaries. Errors as [`Image::new`].
    pub fn rgb_f32(width: usize, height: usize, values: Vec<f32>) -> Result<Image, ImageError> {
        Image::new(width, height, 3, Pixels::F32(values))
    }

    /// An sRGB-encoded RGB image of 8 bits a channel. Errors as [`Image::new`].
    pub fn rgb_u8(width: usize, height: usize, values: Vec<u8>) -> Result<Image, ImageError> {
        Ok(Image::new(width, height, 3, Pixels::U8(values))?.with_encoding(Encoding::Srgb))
    }

    /// A linear image whose every value is `value`.
    ///
    /// # Errors
    /// As [`Image::new`].
    pub fn filled(width: usize, height: usize, channels: usize, value: f32) -> Result<Image, ImageError> {
        if !(1..=4).contains(&channels) {
            return Err(ImageError::ChannelCount { found: channels });
        }
        let Some(count) = width.checked_mul(height).and_then(|count| count.checked_mul(channels)) else {
            return Err(ImageError::WrongLength { width, height, channels, expected: usize::MAX, found: 0 });
        };
        Image::new(width, height, channels, Pixels::F32(vec![value; count]))
    }

    /// The same values, to be understood as encoded by `encoding`.
    #[must_use]
    pub fn with_encoding(self, encoding: Encoding) -> Image {
        Image { encoding, ..self }
    }

    /// The same values, to be understood in the primaries of `color_space`.
    #[must_use]
    pub fn with_color_space(self, color_space: ColorSpace) -> Image {
        Image { color_space, ..self }
    }

    /// Whether the last channel is alpha.
    pub fn has_alpha(&self) -> bool {
        self.channels == 2 || self.channels == 4
    }

    /// Channels that are colour: 1 or 3.
    pub fn color_channels(&self) -> usize {
        if self.channels >= 3 { 3 } else { 1 }
    }

    /// Index of the first value of pixel (`x`, `y`) in the storage.
    #[inline]
    pub fn index(&self, x: usize, y: usize) -> usize {
        (y * self.width + x) * self.channels
    }

    /// The linear value of one channel of pixel (`x`, `y`), (0, 0) being the top left one.
    ///
    /// Values of 8 bits with the sRGB curve are looked up, others computed: to read a [`Encoding::Gamma`] image often,
    /// convert it first ([`Image::to_linear_f32`]).
    ///
    /// # Panics
    /// If the pixel or channel lies outside the image; like an index into a slice, the caller wraps or clamps.
    #[inline]
    pub fn texel(&self, x: usize, y: usize, channel: usize) -> f32 {
        assert!(x < self.width && channel < self.channels, "texel outside the image");
        let index = self.index(x, y) + channel;
        let encoding = self.channel_encoding(channel);
        match &self.pixels {
            Pixels::U8(values) => encoding.decode_u8(values[index]),
            Pixels::F32(values) => encoding.decode(values[index]),
        }
    }

    /// The linear red, green, blue and alpha of pixel (`x`, `y`). Y counts as red, green and blue; alpha is 1 where
    /// there is none.
    ///
    /// # Panics
    /// As [`Image::texel`].
    #[inline]
    pub fn pixel(&self, x: usize, y: usize) -> [f32; 4] {
        let texel = |channel| self.texel(x, y, channel);
        match self.channels {
            1 | 2 => {
                let luminance = texel(0);
                let alpha = if self.channels == 2 { texel(1) } else { 1.0 };
                [luminance, luminance, luminance, alpha]
            }
            _ => [texel(0), texel(1), texel(2), if self.channels == 4 { texel(3) } else { 1.0 }],
        }
    }

    /// The encoding of one channel: that of the image, or linear for alpha.
    #[inline]
    pub(crate) fn channel_encoding(&self, channel: usize) -> Encoding {
        if self.has_alpha() && channel + 1 == self.channels { Encoding::Linear } else { self.encoding }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constructors_check_the_number_of_values() {
        assert!(Image::rgb_f32(2, 2, vec![0.0; 12]).is_ok());
        let error = Image::rgb_f32(2, 2, vec![0.0; 11]).unwrap_err();
        assert_eq!(error.to_string(), "2x2 pixels with 3 channels need 12 values, found 11");
        assert_eq!(
            Image::new(1, 1, 5, Pixels::U8(vec![0; 5])).unwrap_err(),
            ImageError::ChannelCount { found: 5 }
        );
        assert!(Image::new(usize::MAX, 3, 1, Pixels::U8(vec![])).is_err());
        assert!(Image::filled(usize::MAX, 3, 1, 0.0).is_err());
        assert!(Image::filled(0, 3, 1, 0.0).is_ok());
    }

    #[test]
    fn texels_are_decoded_and_alpha_is_linear() {
        let image = Image::new(2, 1, 2, Pixels::U8(vec![255, 0, 188, 51])).unwrap();
        let image = image.with_encoding(Encoding::Srgb);
        assert_eq!(image.texel(0, 0, 0), 1.0);
        assert_eq!(image.texel(1, 0, 1), 0.2);
        assert!((image.texel(1, 0, 0) - 0.502_886_5).abs() < 1e-6);
        let [r, g, b, a] = image.pixel(1, 0);
        assert!(r == g && g == b && a == 0.2);
    }

    #[test]
    #[should_panic(expected = "texel outside the image")]
    fn a_texel_beyond_the_row_is_not_the_next_row() {
        Image::filled(2, 2, 1, 0.0).unwrap().texel(2, 0, 0);
    }
}
