//! Textures, and parameters that may be one.

use std::sync::Arc;

use sahl_image::Image;
use serde::{Deserialize, Serialize};

use crate::{Handle, Spectrum};

/// A number, or a texture of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum FloatParam {
    /// The same everywhere.
    Constant(f32),
    /// A texture; of a colour, the mean of its components.
    Texture(Handle<Texture>),
}

/// A spectrum, or a texture of spectra.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum SpectrumParam {
    /// The same everywhere.
    Constant(Spectrum),
    /// A texture.
    Texture(Handle<Texture>),
}

/// A function over surfaces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Texture {
    /// The same everywhere.
    Constant(Spectrum),
    /// A product.
    Scale {
        /// First factor.
        texture: SpectrumParam,
        /// Second factor.
        scale: FloatParam,
    },
    /// `(1 − amount) first + amount second`.
    Mix {
        /// Where the amount is zero.
        first: SpectrumParam,
        /// Where the amount is one.
        second: SpectrumParam,
        /// The weight of the second.
        amount: FloatParam,
    },
    /// Alternating unit squares of texture space.
    Checkerboard {
        /// Surface to texture space.
        mapping: UvMapping,
        /// In squares whose coordinates have an even sum.
        even: SpectrumParam,
        /// In the other squares.
        odd: SpectrumParam,
    },
    /// An image file.
    Image(ImageTexture),
}

/// An image wrapped over a surface. v = 0 is its bottom row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImageTexture {
    /// The pixels, which know their encoding.
    pub image: Handle<Arc<Image>>,
    /// Surface to texture space.
    pub mapping: UvMapping,
    /// What lies outside the unit square.
    pub wrap: Wrap,
    /// What lies between pixels.
    pub filter: TextureFilter,
    /// Factor on the values.
    pub scale: f32,
    /// Whether values, after scaling, are subtracted from one.
    pub invert: bool,
}

/// An affine map of surface coordinates: `(su u + du, sv v + dv)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct UvMapping {
    /// Factors.
    pub scale: [f32; 2],
    /// Offsets.
    pub offset: [f32; 2],
}

impl Default for UvMapping {
    fn default() -> Self {
        Self { scale: [1.0, 1.0], offset: [0.0, 0.0] }
    }
}

/// What an image shows outside the unit square.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Wrap {
    /// Itself again.
    Repeat,
    /// Its border pixels.
    Clamp,
    /// Nothing.
    Black,
}

/// What an image shows between its pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TextureFilter {
    /// The nearest pixel.
    Nearest,
    /// Linear interpolation of four pixels.
    Bilinear,
}
