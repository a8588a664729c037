//! Images wrapped over surfaces.

use std::sync::Arc;

use sahl_image::{Encoding, Image, Pixels};
use sahl_math::Vec2;
use sahl_scene::{ImageTexture, TextureFilter};

use super::TexturePoint;
use super::filter::{self, Level};
use super::mapping::Mapping;
use crate::spectrum::{ColorLookup, ColorRole, Spectrum, Wavelengths};

/// An image texture, with its pixels and what is needed to understand them.
///
/// Pixels stay as they are stored; those of 8 bits are decoded by a table when they are looked up.
#[derive(Clone, Debug)]
pub(super) struct ImageNode {
    /// The image, and ever smaller ones if the filter asks for them.
    levels: Box<[Arc<Image>]>,
    /// Linear values of the 256 stored ones, for colour and for alpha, if pixels have 8 bits.
    decode: Option<Arc<DecodeTables>>,
    /// Whether a number is read from alpha rather than from the colour.
    alpha_is_float: bool,
    colors: ColorLookup,
    mapping: Mapping,
    wrap: sahl_scene::Wrap,
    filter: TextureFilter,
    scale: f32,
    invert: bool,
}

#[derive(Debug)]
struct DecodeTables {
    color: [f32; 256],
    alpha: [f32; 256],
}

impl ImageNode {
    /// The texture over an image, given as its levels or, where the filter needs no more, as itself.
    ///
    /// `None` if the image has no pixels, or not those that it says it has.
    pub(super) fn new(texture: &ImageTexture, levels: Box<[Arc<Image>]>) -> Option<Self> {
        let image = levels.first()?;
        if !is_usable(image) {
            return None;
        }
        let is_u8 = matches!(image.pixels, Pixels::U8(_));
        let tables =
            || DecodeTables { color: image.encoding.decode_table(), alpha: Encoding::Linear.decode_table() };
        Some(Self {
            decode: is_u8.then(|| Arc::new(tables())),
            alpha_is_float: image.channels == 4 && !is_opaque(image),
            colors: ColorLookup::new(image.color_space),
            mapping: Mapping::new(&texture.mapping),
            wrap: texture.wrap,
            filter: texture.filter,
            scale: texture.scale,
            invert: texture.invert,
            levels,
        })
    }

    /// The value as a number: alpha where there is any that is not one, else the mean of the colour channels.
    ///
    /// That is how pbrt-v4 reads a texture of numbers from an image.
    pub(super) fn float(&self, at: &TexturePoint) -> f32 {
        let [value] = self.lookup(at, |image, index| {
            if self.alpha_is_float {
                [self.alpha(image, index + 3)]
            } else {
                let [r, g, b] = self.color(image, index);
                [(r + g + b) * (1.0 / 3.0)]
            }
        });
        self.adjust(value)
    }

    /// The value as a colour; alpha is ignored.
    pub(super) fn spectrum(&self, at: &TexturePoint, role: ColorRole, wavelengths: &Wavelengths) -> Spectrum {
        let rgb = self.lookup(at, |image, index| self.color(image, index));
        self.colors.at(rgb.map(|value| self.adjust(value)), role, wavelengths)
    }

    /// Scale and inversion, as in pbrt-v4: 1 − scale × value.
    fn adjust(&self, value: f32) -> f32 {
        let value = self.scale * value;
        if self.invert { (1.0 - value).max(0.0) } else { value }
    }

    /// Filters what `texel` says of pixels, given an image and the place of a pixel's first channel in its storage.
    fn lookup<const N: usize>(
        &self,
        at: &TexturePoint,
        texel: impl Fn(&Image, usize) -> [f32; N],
    ) -> [f32; N] {
        let st = self.mapping.map(at).map(|x| if x.is_finite() { x } else { 0.0 });
        // Images have their first row on top.
        let place = Vec2::new(st.x, 1.0 - st.y);
        let level = |number: usize| {
            let image = &*self.levels[number.min(self.levels.len() - 1)];
            let texel = &texel;
            Level { image, wrap: self.wrap, texel: move |index| texel(image, index) }
        };
        match self.filter {
            TextureFilter::Nearest => level(0).nearest(place),
            TextureFilter::Bilinear => level(0).bilinear(place),
            TextureFilter::Trilinear => {
                filter::trilinear(&level, self.levels.len(), place, &self.mapping.differentials(at))
            }
            TextureFilter::Ewa { max_anisotropy } => {
                let differentials = self.mapping.differentials(at);
                filter::ewa(&level, self.levels.len(), place, &differentials, max_anisotropy)
            }
        }
    }

    /// The linear colour of the pixel of `image` that begins at `index`.
    fn color(&self, image: &Image, index: usize) -> [f32; 3] {
        let value = |channel: usize| match (&image.pixels, &self.decode) {
            (Pixels::U8(values), Some(decode)) => decode.color[usize::from(values[index + channel])],
            (Pixels::U8(values), None) => image.encoding.decode_u8(values[index + channel]),
            (Pixels::F32(values), _) => image.encoding.decode(values[index + channel]),
        };
        if image.channels >= 3 { [value(0), value(1), value(2)] } else { [value(0); 3] }
    }

    /// The alpha stored at `index`.
    fn alpha(&self, image: &Image, index: usize) -> f32 {
        match (&image.pixels, &self.decode) {
            (Pixels::U8(values), Some(decode)) => decode.alpha[usize::from(values[index])],
            (Pixels::U8(values), None) => Encoding::Linear.decode_u8(values[index]),
            (Pixels::F32(values), _) => values[index],
        }
    }
}

/// Whether the image has pixels, and those that it says it has.
pub(super) fn is_usable(image: &Image) -> bool {
    let count = image.width.checked_mul(image.height).and_then(|pixels| pixels.checked_mul(image.channels));
    count.is_some_and(|count| count > 0 && count == image.pixels.len() && image.channels <= 4)
}

/// Whether every alpha of an RGBA image is one.
fn is_opaque(image: &Image) -> bool {
    match &image.pixels {
        Pixels::U8(values) => values.chunks_exact(4).all(|pixel| pixel[3] == u8::MAX),
        Pixels::F32(values) => values.chunks_exact(4).all(|pixel| pixel[3] == 1.0),
    }
}
