//! Images made from images: decoded, cut, with other channels or primaries.

use crate::color::{Adaptation, ColorSpace};
use crate::{Encoding, Image, ImageError, Pixels};

impl Image {
    /// The image as linear floats. Primaries and alpha stay; values of linear float images are copied unchanged.
    ///
    /// Colours are neither multiplied nor divided by alpha.
    #[must_use]
    pub fn to_linear_f32(&self) -> Image {
        let channels = self.channels;
        let encodings: Vec<Encoding> = (0..channels).map(|channel| self.channel_encoding(channel)).collect();
        let pixels = match &self.pixels {
            Pixels::U8(values) => {
                let tables: Vec<[f32; 256]> =
                    encodings.iter().map(|encoding| encoding.decode_table()).collect();
                let pixels = values.chunks_exact(channels);
                pixels.flat_map(|pixel| pixel.iter().zip(&tables).map(|(&v, t)| t[usize::from(v)])).collect()
            }
            Pixels::F32(values) if self.encoding == Encoding::Linear => values.clone(),
            Pixels::F32(values) => {
                let pixels = values.chunks_exact(channels);
                pixels.flat_map(|pixel| pixel.iter().zip(&encodings).map(|(&v, e)| e.decode(v))).collect()
            }
        };
        Image { pixels: Pixels::F32(pixels), encoding: Encoding::Linear, ..*self }
    }

    /// Red, green and blue of every pixel, linear, in the primaries of `space`; XYZ stays
    /// ([`ColorSpace::convert`]). Y counts as red, green and blue; alpha is left out.
    pub fn to_rgb(&self, space: ColorSpace) -> Vec<[f32; 3]> {
        let linear = self.to_linear_f32();
        let Pixels::F32(values) = &linear.pixels else { return Vec::new() };
        let pixels = values.chunks_exact(self.channels);
        let mut colors: Vec<[f32; 3]> = match self.channels {
            1 | 2 => pixels.map(|pixel| [pixel[0]; 3]).collect(),
            _ => pixels.map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect(),
        };
        if self.color_space != space && self.channels >= 3 {
            let matrix = self.color_space.conversion_matrix(space, Adaptation::None);
            colors.iter_mut().for_each(|color| *color = multiply(&matrix, *color));
        }
        colors
    }

    /// The image in linear floats with the primaries of `space`; XYZ stays ([`ColorSpace::convert`]).
    ///
    /// Images without three colour channels have no primaries: only their label changes.
    #[must_use]
    pub fn to_color_space(&self, space: ColorSpace) -> Image {
        let matrix = self.color_space.conversion_matrix(space, Adaptation::None);
        let mut image = self.to_linear_f32();
        if self.color_space != space {
            image.multiply_colors(&matrix);
        }
        image.with_color_space(space)
    }

    /// Applies `matrix` to the colours of a linear float image of three or four channels; does nothing to others.
    pub(crate) fn multiply_colors(&mut self, matrix: &[[f64; 3]; 3]) {
        let channels = self.channels;
        if let (Pixels::F32(values), 3..) = (&mut self.pixels, channels) {
            for pixel in values.chunks_exact_mut(channels) {
                let color = multiply(matrix, [pixel[0], pixel[1], pixel[2]]);
                pixel[..3].copy_from_slice(&color);
            }
        }
    }

    /// The `width × height` pixels whose top left one is (`x`, `y`).
    ///
    /// # Errors
    /// [`ImageError::OutOfBounds`] unless all of them lie inside.
    pub fn crop(&self, x: usize, y: usize, width: usize, height: usize) -> Result<Image, ImageError> {
        let inside =
            |start: usize, length: usize, size| start.checked_add(length).is_some_and(|end| end <= size);
        if !inside(x, width, self.width) || !inside(y, height, self.height) {
            return Err(self.out_of_bounds(format!("the rectangle of {width}x{height} pixels at ({x}, {y})")));
        }
        let rows = (y..y + height).map(|row| {
            let start = self.index(x, row);
            start..start + width * self.channels
        });
        let pixels = match &self.pixels {
            Pixels::U8(values) => Pixels::U8(rows.flat_map(|row| values[row].iter().copied()).collect()),
            Pixels::F32(values) => Pixels::F32(rows.flat_map(|row| values[row].iter().copied()).collect()),
        };
        Ok(Image { width, height, pixels, ..*self })
    }

    /// The image whose channels are the channels `indices` of this one; an index may repeat.
    ///
    /// # Errors
    /// [`ImageError::ChannelCount`] unless there are one to four of them; [`ImageError::OutOfBounds`] if one does not
    /// exist.
    pub fn select_channels(&self, indices: &[usize]) -> Result<Image, ImageError> {
        if !(1..=4).contains(&indices.len()) {
            return Err(ImageError::ChannelCount { found: indices.len() });
        }
        if let Some(missing) = indices.iter().find(|&&channel| channel >= self.channels) {
            return Err(self.out_of_bounds(format!("channel {missing}")));
        }
        let channels = indices.len();
        let pixels = match &self.pixels {
            Pixels::U8(values) => Pixels::U8(select(values, self.channels, indices)),
            Pixels::F32(values) => Pixels::F32(select(values, self.channels, indices)),
        };
        Ok(Image { channels, pixels, ..*self })
    }

    /// Multiplies the colours of a linear float image by alpha.
    pub(crate) fn associate_alpha(&mut self) {
        self.scale_by_alpha(|alpha| alpha);
    }

    /// Divides the colours of a linear float image by alpha; they stay as they are where alpha is 0, which keeps light
    /// that covers nothing.
    pub(crate) fn unassociate_alpha(&mut self) {
        self.scale_by_alpha(|alpha| if alpha == 0.0 { 1.0 } else { 1.0 / alpha });
    }

    /// Multiplies the colours of a linear float image by `factor(alpha)`.
    fn scale_by_alpha(&mut self, factor: impl Fn(f32) -> f32) {
        let (has_alpha, channels) = (self.has_alpha(), self.channels);
        if let (Pixels::F32(values), true) = (&mut self.pixels, has_alpha) {
            for pixel in values.chunks_exact_mut(channels) {
                let factor = factor(pixel[channels - 1]);
                pixel[..channels - 1].iter_mut().for_each(|color| *color *= factor);
            }
        }
    }

    /// The error for `what` not being part of this image.
    fn out_of_bounds(&self, what: String) -> ImageError {
        let (width, height, channels) = (self.width, self.height, self.channels);
        ImageError::OutOfBounds { what, width, height, channels }
    }
}

/// The values `indices` of every group of `channels`.
fn select<T: Copy>(values: &[T], channels: usize, indices: &[usize]) -> Vec<T> {
    values.chunks_exact(channels).flat_map(|pixel| indices.iter().map(|&channel| pixel[channel])).collect()
}

/// `m v`, computed in `f64` and rounded once.
fn multiply(m: &[[f64; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    let v = v.map(f64::from);
    m.map(|row| (row[0] * v[0] + row[1] * v[1] + row[2] * v[2]) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbered() -> Image {
        Image::rgb_f32(3, 2, (0..18).map(|value| value as f32).collect()).unwrap()
    }

    #[test]
    fn cropping_keeps_the_pixels_in_place() {
        let image = numbered();
        let crop = image.crop(1, 1, 2, 1).unwrap();
        assert_eq!(crop.pixels, Pixels::F32((12..18).map(|value| value as f32).collect()));
        assert_eq!(image.crop(0, 0, 3, 2).unwrap(), image);
        let error = image.crop(2, 0, 2, 1).unwrap_err().to_string();
        assert_eq!(
            error,
            "the rectangle of 2x1 pixels at (2, 0) is outside the image of 3x2 pixels with 3 channels"
        );
        assert!(image.crop(usize::MAX, 0, 2, 1).is_err());
    }

    #[test]
    fn channels_are_selected_in_the_order_asked_for() {
        let image = numbered().select_channels(&[2, 0]).unwrap();
        assert_eq!((image.channels, image.texel(1, 0, 0), image.texel(1, 0, 1)), (2, 5.0, 3.0));
        assert!(numbered().select_channels(&[3]).is_err());
        assert!(numbered().select_channels(&[]).is_err());
    }

    #[test]
    fn decoding_agrees_with_texel() {
        let bytes = Image::new(4, 4, 4, Pixels::U8((0..64).map(|v| v * 4).collect())).unwrap();
        let floats = Image::new(4, 4, 4, Pixels::F32((0..64).map(|v| v as f32 / 50.0).collect())).unwrap();
        for encoding in [Encoding::Linear, Encoding::Srgb, Encoding::Gamma(2.0)] {
            for image in [bytes.clone().with_encoding(encoding), floats.clone().with_encoding(encoding)] {
                let linear = image.to_linear_f32();
                for (x, y, channel) in [(0, 0, 0), (3, 3, 3), (2, 1, 2)] {
                    let difference = linear.texel(x, y, channel) - image.texel(x, y, channel);
                    assert!(difference.abs() < 1e-6);
                }
            }
        }
    }

    #[test]
    fn primaries_change_and_alpha_does_not() {
        let image = Image::new(1, 1, 4, Pixels::F32(vec![0.5, 0.25, 0.125, 0.7])).unwrap();
        let wide = image.to_color_space(ColorSpace::Rec2020);
        assert_eq!(wide.texel(0, 0, 3), 0.7);
        let expected = ColorSpace::Srgb.convert(ColorSpace::Rec2020, [0.5, 0.25, 0.125]);
        assert_eq!(wide.to_rgb(ColorSpace::Rec2020), [expected]);
        let back = wide.to_rgb(ColorSpace::Srgb)[0];
        assert!((back[0] - 0.5).abs() < 1e-6);
    }

    #[test]
    fn alpha_is_multiplied_in_and_divided_out() {
        let mut image = Image::new(2, 1, 2, Pixels::F32(vec![0.5, 0.5, 0.3, 0.0])).unwrap();
        image.associate_alpha();
        assert_eq!(image.pixels, Pixels::F32(vec![0.25, 0.5, 0.0, 0.0]));
        image.unassociate_alpha();
        assert_eq!(image.pixels, Pixels::F32(vec![0.5, 0.5, 0.0, 0.0]));
    }
}
