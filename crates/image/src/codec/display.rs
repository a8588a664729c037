//! Pixels as formats without EXR's freedom hold them.

use crate::tone_map::quantize_u16;
use crate::{ColorSpace, Encoding, Image, ImageError, ToneMap};

/// The values of `image` as a display shows them, 16 bits each, the larger byte first.
pub(super) fn words(image: &Image, tone_map: &ToneMap) -> Vec<u8> {
    let values = tone_map.display_values(image);
    values.into_iter().flat_map(|value| quantize_u16(value).to_be_bytes()).collect()
}

/// The image in linear floats, colours multiplied by alpha.
pub(super) fn associated(image: &Image) -> Image {
    let mut linear = image.to_linear_f32();
    if image.encoding != Encoding::Linear {
        linear.associate_alpha();
    }
    linear
}

/// The image over black, without alpha, in linear floats with sRGB primaries.
pub(super) fn over_black(image: &Image) -> Result<Image, ImageError> {
    let light = associated(image).to_color_space(ColorSpace::Srgb);
    match image.channels {
        2 => light.select_channels(&[0]),
        4 => light.select_channels(&[0, 1, 2]),
        _ => Ok(light),
    }
}
