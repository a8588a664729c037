//! Images wrapped over surfaces.

use std::sync::Arc;

use sahl_image::{Adaptation, ColorSpace, Encoding, Image, Pixels};
use sahl_math::Vec2;
use sahl_scene::{ImageTexture, TextureFilter, UvMapping, Wrap};

use super::map_uv;
use crate::spectrum::{ColorRole, Spectrum, Wavelengths};

/// An image texture, with its pixels and what is needed to understand them.
///
/// Pixels stay as they are stored; those of 8 bits are decoded by a table when they are looked up.
#[derive(Clone, Debug)]
pub(super) struct ImageNode {
    image: Arc<Image>,
    /// Linear values of the 256 stored ones, for colour and for alpha, if pixels have 8 bits.
    decode: Option<Arc<DecodeTables>>,
    /// Whether a number is read from alpha rather than from the colour.
    alpha_is_float: bool,
    /// To linear sRGB, for reflectances and for emission; `None`: it is that already.
    to_srgb: Option<[[[f32; 3]; 3]; 2]>,
    mapping: UvMapping,
    wrap: Wrap,
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
    /// The texture over `image`; `None` if the image has no pixels, or not those that it says it has.
    pub(super) fn new(texture: &ImageTexture, image: &Arc<Image>) -> Option<Self> {
        let count = image.width.checked_mul(image.height)?.checked_mul(image.channels)?;
        let (length, is_u8) = match &image.pixels {
            Pixels::U8(values) => (values.len(), true),
            Pixels::F32(values) => (values.len(), false),
        };
        if count == 0 || count != length || image.channels > 4 {
            return None;
        }
        let table = |encoding: Encoding| std::array::from_fn(|i| encoding.decode(i as f32 / 255.0));
        let matrix = |adaptation| {
            image.color_space.conversion_matrix(ColorSpace::Srgb, adaptation).map(|row| row.map(|x| x as f32))
        };
        let is_srgb = image.color_space == ColorSpace::Srgb;
        Some(Self {
            image: Arc::clone(image),
            decode: is_u8.then(|| {
                Arc::new(DecodeTables { color: table(image.encoding), alpha: table(Encoding::Linear) })
            }),
            alpha_is_float: image.channels == 4 && !is_opaque(image),
            to_srgb: (!is_srgb).then(|| [matrix(Adaptation::Bradford), matrix(Adaptation::None)]),
            mapping: texture.mapping,
            wrap: texture.wrap,
            filter: texture.filter,
            scale: texture.scale,
            invert: texture.invert,
        })
    }

    /// The value as a number: alpha where there is any that is not one, else the mean of the colour channels.
    ///
    /// That is how pbrt-v4 reads a texture of numbers from an image.
    pub(super) fn float(&self, uv: Vec2) -> f32 {
        let [value] = self.lookup(uv, |index| {
            if self.alpha_is_float {
                [self.alpha(index + 3)]
            } else {
                let [r, g, b] = self.color(index);
                [(r + g + b) * (1.0 / 3.0)]
            }
        });
        self.adjust(value)
    }

    /// The value as a colour; alpha is ignored.
    pub(super) fn spectrum(&self, uv: Vec2, role: ColorRole, wavelengths: &Wavelengths) -> Spectrum {
        let rgb = self.lookup(uv, |index| self.color(index));
        let rgb = match &self.to_srgb {
            None => rgb,
            Some([_, emission]) if role == ColorRole::Illuminant => transform(emission, rgb),
            Some([reflectance, _]) => transform(reflectance, rgb),
        };
        let spectrum = match wavelengths {
            Wavelengths::Rgb => Spectrum::from_rgb(rgb.map(|value| self.adjust(value))),
        };
        let high = if role == ColorRole::Albedo { 1.0 } else { f32::MAX };
        spectrum.clamp(0.0, high)
    }

    /// Scale and inversion, as in pbrt-v4: 1 − scale × value.
    fn adjust(&self, value: f32) -> f32 {
        let value = self.scale * value;
        if self.invert { (1.0 - value).max(0.0) } else { value }
    }

    /// Filters what `texel` says of pixels, given the place of a pixel's first channel in the storage.
    fn lookup<const N: usize>(&self, uv: Vec2, texel: impl Fn(usize) -> [f32; N]) -> [f32; N] {
        let st = map_uv(&self.mapping, uv).map(|x| if x.is_finite() { x } else { 0.0 });
        let x = st.x * self.image.width as f32;
        let y = (1.0 - st.y) * self.image.height as f32;
        let at = |x: i64, y: i64| self.index(x, y).map_or([0.0; N], &texel);
        match self.filter {
            TextureFilter::Nearest => at(x.floor() as i64, y.floor() as i64),
            TextureFilter::Bilinear => {
                let (x, y) = (x - 0.5, y - 0.5);
                let (x0, y0) = (x.floor(), y.floor());
                let (dx, dy) = (x - x0, y - y0);
                let (x0, y0) = (x0 as i64, y0 as i64);
                let (x1, y1) = (x0.saturating_add(1), y0.saturating_add(1));
                let (v00, v10, v01, v11) = (at(x0, y0), at(x1, y0), at(x0, y1), at(x1, y1));
                std::array::from_fn(|i| {
                    (1.0 - dy) * ((1.0 - dx) * v00[i] + dx * v10[i])
                        + dy * ((1.0 - dx) * v01[i] + dx * v11[i])
                })
            }
        }
    }

    /// The place of pixel (x, y) in the storage, after wrapping; `None` where nothing is shown.
    fn index(&self, x: i64, y: i64) -> Option<usize> {
        let x = wrap(x, self.image.width, self.wrap)?;
        let y = wrap(y, self.image.height, self.wrap)?;
        Some(self.image.index(x, y))
    }

    /// The linear colour of the pixel that begins at `index`.
    fn color(&self, index: usize) -> [f32; 3] {
        let value = |channel: usize| match (&self.image.pixels, &self.decode) {
            (Pixels::U8(values), Some(decode)) => decode.color[usize::from(values[index + channel])],
            (Pixels::U8(values), None) => self.image.encoding.decode_u8(values[index + channel]),
            (Pixels::F32(values), _) => self.image.encoding.decode(values[index + channel]),
        };
        if self.image.channels >= 3 { [value(0), value(1), value(2)] } else { [value(0); 3] }
    }

    /// The alpha stored at `index`.
    fn alpha(&self, index: usize) -> f32 {
        match (&self.image.pixels, &self.decode) {
            (Pixels::U8(values), Some(decode)) => decode.alpha[usize::from(values[index])],
            (Pixels::U8(values), None) => Encoding::Linear.decode_u8(values[index]),
            (Pixels::F32(values), _) => values[index],
        }
    }
}

/// The pixel shown at place `i` along an axis of `size` pixels; `None` where nothing is.
fn wrap(i: i64, size: usize, wrap: Wrap) -> Option<usize> {
    let size = size as i64;
    if (0..size).contains(&i) {
        return Some(i as usize);
    }
    match wrap {
        Wrap::Repeat => Some(i.rem_euclid(size) as usize),
        Wrap::Clamp => Some(i.clamp(0, size - 1) as usize),
        Wrap::Black => None,
    }
}

/// Whether every alpha of an RGBA image is one.
fn is_opaque(image: &Image) -> bool {
    match &image.pixels {
        Pixels::U8(values) => values.chunks_exact(4).all(|pixel| pixel[3] == u8::MAX),
        Pixels::F32(values) => values.chunks_exact(4).all(|pixel| pixel[3] == 1.0),
    }
}

fn transform(matrix: &[[f32; 3]; 3], rgb: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2])
}
