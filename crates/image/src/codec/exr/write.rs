//! Writing EXR.

use std::collections::BTreeSet;
use std::io::Cursor;

use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer as ExrLayer};
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, Chromaticities, IntegerBounds, LineOrder, Text};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use exr::prelude::{Blocks, Compression, SmallVec, WritableImage, f16};

use super::{Precision, SAMPLES, SEED};
use crate::codec::display;
use crate::{Attribute, ColorSpace, Format, Image, ImageError, Layer, Metadata, Picture, Pixels};

/// The bytes of an EXR file.
pub(in crate::codec) fn write(picture: &Picture, precision: Precision) -> Result<Vec<u8>, ImageError> {
    let beauty = picture.beauty().ok_or_else(|| encode_error("the picture has no layer"))?;
    let size = [beauty.image.width, beauty.image.height];
    let mut channels = SmallVec::new();
    let mut names = BTreeSet::new();
    for layer in &picture.layers {
        check_size(layer, size)?;
        for channel in layer_channels(layer, beauty.image.color_space, precision)? {
            if !names.insert(channel.name.to_string()) {
                return Err(encode_error(format!("two channels are called `{}`", channel.name)));
            }
            channels.push(channel);
        }
    }
    let layer = ExrLayer {
        channel_data: AnyChannels::sort(channels),
        attributes: layer_attributes(&picture.metadata)?,
        size: Vec2(size[0], size[1]),
        encoding: Encoding {
            compression: Compression::ZIP16,
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        },
    };
    let attributes = image_attributes(&picture.metadata, size, beauty.image.color_space)?;
    let file = exr::image::Image { attributes, layer_data: layer };
    let mut bytes = Vec::new();
    // One thread: the caller said how many it wants, and this crate starts none.
    file.write().non_parallel().to_buffered(Cursor::new(&mut bytes)).map_err(encode_error)?;
    sort_attributes(&mut bytes);
    Ok(bytes)
}

/// The channels of a layer as EXR holds them.
fn layer_channels(
    layer: &Layer,
    space: ColorSpace,
    precision: Precision,
) -> Result<Vec<AnyChannel<FlatSamples>>, ImageError> {
    let mut linear = display::associated(&layer.image);
    if layer.is_color() {
        // A file has one set of primaries.
        linear = linear.to_color_space(space);
    }
    if layer.channel_names.len() != linear.channels {
        return Err(encode_error(format!(
            "a layer has {} channel names for {} channels",
            layer.channel_names.len(),
            linear.channels
        )));
    }
    let names = layer.channel_names.iter().enumerate();
    names
        .map(|(index, channel)| {
            let half =
                precision == Precision::Half && matches!(channel.as_str(), "R" | "G" | "B" | "A" | "Y");
            let samples = if half && layer.is_color() {
                FlatSamples::F16(plane(&linear, index).map(to_half).collect())
            } else {
                FlatSamples::F32(plane(&linear, index).collect())
            };
            Ok(AnyChannel::new(channel_name(&layer.full_channel_name(channel))?, samples))
        })
        .collect()
}

/// The values of one channel of a float image.
fn plane(image: &Image, channel: usize) -> impl Iterator<Item = f32> {
    let values: &[f32] = match &image.pixels {
        Pixels::F32(values) => values,
        Pixels::U8(_) => &[],
    };
    values.iter().skip(channel).step_by(image.channels).copied()
}

/// The nearest half; finite values stay finite.
fn to_half(value: f32) -> f16 {
    let largest = f16::MAX.to_f32();
    f16::from_f32(if value.is_finite() { value.clamp(-largest, largest) } else { value })
}

fn check_size(layer: &Layer, expected: [usize; 2]) -> Result<(), ImageError> {
    let found = [layer.image.width, layer.image.height];
    if found == expected && found[0] > 0 && found[1] > 0 {
        return Ok(());
    }
    let name = layer.name.as_deref().unwrap_or("");
    Err(encode_error(format!(
        "layer `{name}` has {}x{} pixels, expected {}x{} and at least one",
        found[0], found[1], expected[0], expected[1]
    )))
}

fn layer_attributes(metadata: &Metadata) -> Result<LayerAttributes, ImageError> {
    let mut attributes = LayerAttributes {
        layer_position: Vec2(metadata.offset[0], metadata.offset[1]),
        software_name: metadata.software.as_deref().map(text),
        comments: metadata.comments.as_deref().map(text),
        ..LayerAttributes::default()
    };
    let samples = metadata.samples.map(|samples| {
        let samples = i32::try_from(samples).unwrap_or(i32::MAX);
        (SAMPLES.to_string(), Attribute::Int(samples))
    });
    let seed = metadata.seed.map(|seed| (SEED.to_string(), Attribute::Text(seed.to_string())));
    for (name, value) in samples.into_iter().chain(seed).chain(metadata.attributes.iter().cloned()) {
        if set_attribute(&mut attributes, &name, value)? {
            return Err(encode_error(format!("two attributes are called `{name}`")));
        }
    }
    Ok(attributes)
}

/// Adds an attribute; tells whether there was one of that name. The `exr` crate wants those it knows in their fields.
fn set_attribute(attributes: &mut LayerAttributes, name: &str, value: Attribute) -> Result<bool, ImageError> {
    Ok(match (name, value) {
        ("owner", Attribute::Text(value)) => attributes.owner.replace(text(&value)).is_some(),
        ("worldToCamera", Attribute::Matrix(value)) => attributes.world_to_camera.replace(value).is_some(),
        ("worldToNDC", Attribute::Matrix(value)) => {
            attributes.world_to_normalized_device.replace(value).is_some()
        }
        (name, value) => {
            let value = match value {
                Attribute::Text(value) => AttributeValue::Text(text(&value)),
                Attribute::Int(value) => AttributeValue::I32(value),
                Attribute::Float(value) => AttributeValue::F32(value),
                Attribute::Matrix(value) => AttributeValue::Matrix4x4(value),
            };
            attributes.other.insert(channel_name(name)?, value).is_some()
        }
    })
}

fn image_attributes(
    metadata: &Metadata,
    size: [usize; 2],
    space: ColorSpace,
) -> Result<ImageAttributes, ImageError> {
    let [width, height] = metadata.full_size.unwrap_or(size);
    let window = match metadata.full_size {
        Some(_) => IntegerBounds::from_dimensions(Vec2(width, height)),
        None => IntegerBounds::new(Vec2(metadata.offset[0], metadata.offset[1]), Vec2(width, height)),
    };
    if [width, height, size[0], size[1]].iter().any(|&side| side > (i32::MAX / 2) as usize) {
        return Err(encode_error(format!("{width}x{height} pixels are too many")));
    }
    let space = space.chromaticities();
    let pair = |[x, y]: [f64; 2]| Vec2(x as f32, y as f32);
    let (red, green) = (pair(space.red), pair(space.green));
    let (blue, white) = (pair(space.blue), pair(space.white));
    let mut attributes = ImageAttributes::new(window);
    attributes.chromaticities = Some(Chromaticities { red, green, blue, white });
    Ok(attributes)
}

/// The name of a channel or attribute: 1 to 255 bytes, none of them 0.
fn channel_name(name: &str) -> Result<Text, ImageError> {
    if name.is_empty() || name.len() > 255 || name.contains('\0') {
        return Err(encode_error(format!("`{}` can't be a name", name.escape_debug())));
    }
    Ok(text(name))
}

/// The bytes of `value` as UTF-8, as OpenEXR means them.
fn text(value: &str) -> Text {
    Text::from_slice_unchecked(value.as_bytes())
}

/// Sorts the attributes of a file with one part by name, in place.
///
/// The `exr` crate keeps those it does not know in a hash map and writes them in its order, which differs from run to
/// run. The header keeps its length, so that the table of offsets behind it stays right.
fn sort_attributes(bytes: &mut [u8]) {
    const START: usize = 8;
    let text_end =
        |from: usize| bytes[from..].iter().position(|&byte| byte == 0).map(|length| from + length + 1);
    let mut attributes = Vec::new();
    let mut position = START;
    while bytes.get(position).is_some_and(|&byte| byte != 0) {
        let end = text_end(position).and_then(text_end).and_then(|size_at| {
            let size = bytes.get(size_at..size_at + 4)?;
            Some(size_at + 4 + u32::from_le_bytes(size.try_into().ok()?) as usize)
        });
        let Some(attribute) = end.and_then(|end| bytes.get(position..end)) else { return };
        position += attribute.len();
        attributes.push(attribute.to_vec());
    }
    attributes.sort();
    bytes[START..position].copy_from_slice(&attributes.concat());
}

fn encode_error(message: impl ToString) -> ImageError {
    ImageError::encode(Format::Exr, message)
}
