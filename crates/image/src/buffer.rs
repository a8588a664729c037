//! Pixel buffers.

use serde::{Deserialize, Serialize};

use crate::{ColorSpace, Encoding};

/// A rectangle of pixels with one to four channels each: Y, YA, RGB or RGBA; top row first, channels interleaved.
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
