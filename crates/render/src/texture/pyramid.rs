//! An image in ever smaller sizes, for means over large parts of it.
//!
//! Each level is half as large as the one before, rounded down, and its pixels are means of two by two, or of three along
//! a side that is odd: weighted such that every pixel below counts the same. So the last level, one pixel, is the mean of
//! the image. Source: Williams, *Pyramidal Parametrics*, SIGGRAPH 1983; Guthe, Heckbert, *Non-Power-of-Two Mipmap
//! Creation*, NVIDIA 2005, for odd sizes.
//!
//! Deviation from pbrt-v4: that enlarges images to powers of two first, with a filter that rings. Levels are stored as the
//! image is, but computed from unrounded values.

use std::sync::Arc;

use sahl_image::{Encoding, Image, Pixels};

/// The levels of `image`, itself first.
pub(super) fn levels(image: &Arc<Image>) -> Box<[Arc<Image>]> {
    let mut levels = vec![Arc::clone(image)];
    let mut size = [image.width, image.height];
    let mut values = linear(image);
    while size[0] > 1 || size[1] > 1 {
        // One axis after the other: the weights are products.
        values = halve(&values, Axis { lines: size[1], length: size[0], stride: 1 }, image.channels);
        size[0] = (size[0] / 2).max(1);
        values = halve(&values, Axis { lines: size[0], length: size[1], stride: size[0] }, image.channels);
        size[1] = (size[1] / 2).max(1);
        levels.push(Arc::new(encoded(&values, size, image)));
    }
    levels.into()
}

/// The encoding of a channel: alpha is linear.
fn encoding(image: &Image, channel: usize) -> Encoding {
    let is_alpha = image.has_alpha() && channel + 1 == image.channels;
    if is_alpha { Encoding::Linear } else { image.encoding }
}

/// The values that are stored, decoded.
fn linear(image: &Image) -> Vec<f32> {
    let encodings: Vec<Encoding> = (0..image.channels).map(|channel| encoding(image, channel)).collect();
    match &image.pixels {
        Pixels::U8(stored) => {
            let tables: Vec<[f32; 256]> = encodings.iter().map(|encoding| encoding.decode_table()).collect();
            let decode = |(i, &value): (usize, &u8)| tables[i % image.channels][usize::from(value)];
            stored.iter().enumerate().map(decode).collect()
        }
        Pixels::F32(stored) => {
            let decode = |(i, &value): (usize, &f32)| encodings[i % image.channels].decode(value);
            stored.iter().enumerate().map(decode).collect()
        }
    }
}

/// A level of `size` with the values `linear`, stored as those of `image` are.
fn encoded(linear: &[f32], size: [usize; 2], image: &Image) -> Image {
    let stored =
        linear.iter().enumerate().map(|(i, &value)| encoding(image, i % image.channels).encode(value));
    let pixels = match image.pixels {
        Pixels::U8(_) => Pixels::U8(stored.map(|value| (value * 255.0).round() as u8).collect()),
        Pixels::F32(_) => Pixels::F32(stored.collect()),
    };
    let [width, height] = size;
    Image {
        width,
        height,
        channels: image.channels,
        pixels,
        encoding: image.encoding,
        color_space: image.color_space,
    }
}

/// Pixels in lines: how many lines, how many pixels in each, and how far one is from the next.
#[derive(Clone, Copy)]
struct Axis {
    lines: usize,
    length: usize,
    stride: usize,
}

/// The image at half its length along an axis.
fn halve(values: &[f32], axis: Axis, channels: usize) -> Vec<f32> {
    let Axis { lines, length, stride } = axis;
    if length == 1 {
        return values.to_vec();
    }
    let half = length / 2;
    let mut result = vec![0.0; lines * half * channels];
    // A row's pixels are neighbours and rows are `length` apart; a column's are a row apart and columns are neighbours.
    let (line_step, half_line_step) = if stride == 1 { (length, half) } else { (1, 1) };
    for line in 0..lines {
        for i in 0..half {
            for (k, weight) in weights(i, length).into_iter().enumerate().filter(|(_, weight)| *weight > 0.0)
            {
                let from = (line * line_step + (2 * i + k) * stride) * channels;
                let to = (line * half_line_step + i * stride) * channels;
                for channel in 0..channels {
                    result[to + channel] += weight * values[from + channel];
                }
            }
        }
    }
    result
}

/// The weights of pixels 2i, 2i + 1 and 2i + 2 of `length` in pixel i of half as many.
fn weights(i: usize, length: usize) -> [f32; 3] {
    if length.is_multiple_of(2) {
        return [0.5, 0.5, 0.0];
    }
    let (half, i, length) = ((length / 2) as f32, i as f32, length as f32);
    [(half - i) / length, half / length, (i + 1.0) / length]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: usize, height: usize, values: Vec<f32>) -> Arc<Image> {
        Arc::new(Image::y_f32(width, height, values).unwrap())
    }

    fn values(image: &Image) -> Vec<f32> {
        (0..image.height).flat_map(|y| (0..image.width).map(move |x| image.texel(x, y, 0))).collect()
    }

    #[test]
    fn every_pixel_counts_the_same_in_every_size() {
        for (width, height) in [(1, 1), (8, 8), (5, 3), (7, 1), (1, 6), (13, 32), (3, 2)] {
            let source: Vec<f32> = (0..width * height).map(|i| ((i * 7919) % 101) as f32).collect();
            let mean = source.iter().sum::<f32>() / source.len() as f32;
            let levels = levels(&image(width, height, source));
            let last = levels.last().unwrap();
            assert_eq!((last.width, last.height), (1, 1));
            for level in &levels {
                let found = values(level).iter().sum::<f32>() / (level.width * level.height) as f32;
                assert!((found - mean).abs() < 1e-3, "{width} × {height}: {found} {mean}");
            }
        }
    }

    #[test]
    fn even_sizes_are_means_of_four() {
        let levels = levels(&image(4, 2, vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]));
        assert_eq!(levels.len(), 3);
        assert_eq!(values(&levels[1]), [2.5, 4.5]);
        assert_eq!(values(&levels[2]), [3.5]);
    }

    #[test]
    fn bytes_are_averaged_as_light_and_alpha_as_it_is() {
        let pixels = Pixels::U8(vec![0, 0, 0, 0, 255, 255, 255, 255]);
        let image = Image::new(2, 1, 4, pixels).unwrap().with_encoding(Encoding::Srgb);
        let levels = levels(&Arc::new(image));
        // Half the light is the value 188; half the alpha is 128.
        assert_eq!(levels[1].pixels, Pixels::U8(vec![188, 188, 188, 128]));
    }
}
