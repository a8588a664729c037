//! Reading EXR.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

use exr::block::reader::Reader;
use exr::image::read::image::ReadLayers;
use exr::image::read::layers::ReadChannels;
use exr::image::{AnyChannels, FlatSamples, Layer as ExrLayer};
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, SampleType, Text};
use exr::meta::header::Header;
use exr::prelude::f16;

use super::{SAMPLES, SEED, dwa};
use crate::codec::{ImageInfo, limits};
use crate::color::conversion;
use crate::{
    Attribute, Chromaticities, ColorSpace, Encoding, Format, Image, ImageError, Layer, Metadata, Picture,
    Pixels,
};

/// What the header claims.
pub(in crate::codec) fn probe(bytes: &[u8]) -> Result<ImageInfo, ImageError> {
    guarded(|| {
        let reader = open(bytes)?;
        let headers = reader.headers();
        let first = headers.first().ok_or_else(|| malformed("it has no parts"))?;
        let channels = headers.iter().map(|header| header.channels.list.len()).sum();
        let sample_type = first.channels.list.first().map(|channel| channel.sample_type);
        let Vec2(width, height) = first.layer_size;
        let bits = if sample_type == Some(SampleType::F16) { 16 } else { 32 };
        Ok(ImageInfo { format: Format::Exr, width, height, channels, bits, encoding: Encoding::Linear })
    })
}

/// All layers.
///
/// A layer is made of the channels of one part that have the same name up to the last dot. Unnamed channels of the first
/// part have no layer name; those of later parts have the name of their part. R, G, B and A, or Y and A, stay together;
/// other unnamed channels, and those of layers that would have more than four, become layers of one channel.
/// Integers become the nearest floats.
pub(in crate::codec) fn read(bytes: &[u8]) -> Result<Picture, ImageError> {
    guarded(|| {
        let reader = open(bytes)?;
        dwa::check(bytes, reader.headers())?;
        let first = reader.headers().first().ok_or_else(|| malformed("it has no parts"))?;
        let metadata = metadata(first);
        let primaries = first.shared_attributes.chromaticities.map(|c| {
            let pair = |Vec2(x, y): Vec2<f32>| [f64::from(x), f64::from(y)];
            let (red, green) = (pair(c.red), pair(c.green));
            Chromaticities { red, green, blue: pair(c.blue), white: pair(c.white) }
        });
        let channels = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
        let image = channels.all_layers().all_attributes().non_parallel().from_chunks(reader);
        let mut layers = Vec::new();
        for (index, part) in image.map_err(foreign)?.layer_data.into_iter().enumerate() {
            layers.extend(part_layers(index, part)?);
        }
        for layer in &mut layers {
            set_color_space(layer, primaries.as_ref())?;
        }
        Ok(Picture { layers, metadata })
    })
}

/// Runs `decode`; a panic becomes an error.
///
/// The `exr` crate is not proven free of panics on hostile bytes (overflowing sizes, inner assertions), and its state
/// is dropped with the error, so nothing broken is ever seen. The panic hook still runs and may print. Allocations that
/// fail abort and can't be caught: [`limits`] and [`dwa`] see to it that none is that large.
fn guarded<T>(decode: impl FnOnce() -> Result<T, ImageError>) -> Result<T, ImageError> {
    catch_unwind(AssertUnwindSafe(decode)).unwrap_or_else(|_| Err(malformed("decoding failed")))
}

/// Reads and checks the headers.
fn open(bytes: &[u8]) -> Result<Reader<Cursor<&[u8]>>, ImageError> {
    let reader = exr::block::read(Cursor::new(bytes), false).map_err(foreign)?;
    let mut total = 0_u64;
    for header in reader.headers() {
        if header.deep {
            return Err(ImageError::unsupported(Format::Exr, "deep data is"));
        }
        let Vec2(width, height) = header.layer_size;
        let pixel_bytes = 4 * header.channels.list.len() as u64;
        limits::check(Format::Exr, [width as u64, height as u64], pixel_bytes, bytes.len())?;
        total += width as u64 * height as u64 * pixel_bytes;
    }
    if total > limits::plausible_bytes(bytes.len()) {
        return Err(malformed(format!("its parts claim {total} bytes, which the file can't hold")));
    }
    Ok(reader)
}

/// The facts that a header states. Standard attributes beyond those of [`Metadata`] are left out, apart from the owner
/// and the two matrices of the camera.
fn metadata(header: &Header) -> Metadata {
    let Vec2(x, y) = header.own_attributes.layer_position;
    let window = header.shared_attributes.display_window;
    let own = &header.own_attributes;
    let mut metadata = Metadata {
        offset: [x - window.position.0, y - window.position.1],
        full_size: (window != header.data_window()).then_some([window.size.0, window.size.1]),
        software: own.software_name.as_ref().map(string),
        comments: own.comments.as_ref().map(string),
        ..Metadata::default()
    };
    let matrices = [("worldToCamera", own.world_to_camera), ("worldToNDC", own.world_to_normalized_device)];
    for (name, matrix) in matrices {
        let matrix = matrix.map(|matrix| (name.to_string(), Attribute::Matrix(matrix)));
        metadata.attributes.extend(matrix);
    }
    let owner = own.owner.as_ref().map(|owner| ("owner".to_string(), Attribute::Text(string(owner))));
    metadata.attributes.extend(owner);
    for (name, value) in &own.other {
        let value = match value {
            AttributeValue::Text(text) => Attribute::Text(string(text)),
            AttributeValue::I32(value) => Attribute::Int(*value),
            AttributeValue::F32(value) => Attribute::Float(*value),
            AttributeValue::Matrix4x4(value) => Attribute::Matrix(*value),
            _ => continue,
        };
        match (string(name), value) {
            (name, Attribute::Int(samples @ 0..)) if name == SAMPLES => {
                metadata.samples = Some(samples.unsigned_abs());
            }
            (name, Attribute::Text(text)) if name == SEED && text.parse::<u64>().is_ok() => {
                metadata.seed = text.parse().ok();
            }
            (name, value) => metadata.attributes.push((name, value)),
        }
    }
    // The map that they come from has no order of its own.
    metadata.attributes.sort_by(|a, b| a.0.cmp(&b.0));
    metadata
}

/// The text, its bytes being UTF-8.
fn string(text: &Text) -> String {
    String::from_utf8_lossy(text.as_slice()).into_owned()
}

/// A channel on its way into a layer.
struct Plane {
    name: String,
    values: Vec<f32>,
}

/// The layers of one part.
fn part_layers(index: usize, part: ExrLayer<AnyChannels<FlatSamples>>) -> Result<Vec<Layer>, ImageError> {
    let part_name = part.attributes.layer_name.as_ref().map(string);
    let unnamed = if index == 0 { None } else { part_name };
    let mut groups: Vec<(Option<String>, Vec<Plane>)> = Vec::new();
    for channel in part.channel_data.list {
        let full_name = string(&channel.name);
        let (group, name) = match full_name.rsplit_once('.') {
            Some((group, name)) => (Some(group.to_string()), name.to_string()),
            None => (unnamed.clone(), full_name),
        };
        let values = match channel.sample_data {
            FlatSamples::F32(values) => values,
            FlatSamples::F16(values) => values.into_iter().map(f16::to_f32).collect(),
            FlatSamples::U32(values) => values.into_iter().map(|value| value as f32).collect(),
        };
        let plane = Plane { name, values };
        match groups.iter_mut().find(|(existing, _)| *existing == group) {
            Some((_, planes)) => planes.push(plane),
            None => groups.push((group, vec![plane])),
        }
    }
    let size = [part.size.0, part.size.1];
    let mut layers = Vec::new();
    for (name, planes) in groups {
        for planes in split(name.is_some(), planes) {
            layers.push(interleave(name.clone(), planes, size)?);
        }
    }
    Ok(layers)
}

/// Splits the channels of a layer into groups of at most four: colour first.
fn split(is_named: bool, mut planes: Vec<Plane>) -> Vec<Vec<Plane>> {
    let mut groups = Vec::new();
    let has = |planes: &[Plane], name: &str| planes.iter().any(|plane| plane.name == name);
    let color: &[&str] = if ["R", "G", "B"].iter().all(|name| has(&planes, name)) {
        &["R", "G", "B", "A"]
    } else if has(&planes, "Y") && !has(&planes, "X") {
        &["Y", "A"]
    } else {
        &[]
    };
    let mut group = Vec::new();
    for name in color {
        if let Some(index) = planes.iter().position(|plane| plane.name == *name) {
            group.push(planes.remove(index));
        }
    }
    if !group.is_empty() {
        groups.push(group);
    }
    if is_named && (1..=4).contains(&planes.len()) {
        groups.push(planes);
    } else {
        groups.extend(planes.into_iter().map(|plane| vec![plane]));
    }
    groups
}

/// One layer of one to four channels.
fn interleave(
    name: Option<String>,
    planes: Vec<Plane>,
    [width, height]: [usize; 2],
) -> Result<Layer, ImageError> {
    let channels = planes.len();
    let mut values = vec![0.0; width * height * channels];
    for (channel, plane) in planes.iter().enumerate() {
        if plane.values.len() != width * height {
            return Err(malformed(format!("channel `{}` has the wrong size", plane.name)));
        }
        let targets = values.iter_mut().skip(channel).step_by(channels);
        targets.zip(&plane.values).for_each(|(target, value)| *target = *value);
    }
    let image = Image::new(width, height, channels, Pixels::F32(values))?;
    Ok(Layer { name, channel_names: planes.into_iter().map(|plane| plane.name).collect(), image })
}

/// Labels a layer with the primaries of the file. Colours in primaries that have no label are converted to sRGB.
fn set_color_space(layer: &mut Layer, primaries: Option<&Chromaticities>) -> Result<(), ImageError> {
    let Some(primaries) = primaries else { return Ok(()) };
    if let Some(space) = primaries.nearest_space() {
        layer.image.color_space = space;
    } else if layer.is_color() {
        let matrix = conversion(primaries, ColorSpace::Srgb);
        let matrix = matrix.ok_or_else(|| malformed("its chromaticities span no colours"))?;
        layer.image.multiply_colors(&matrix);
    }
    Ok(())
}

/// The error for one of the `exr` crate.
pub(super) fn foreign(error: exr::error::Error) -> ImageError {
    match error {
        exr::error::Error::NotSupported(feature) => {
            ImageError::unsupported(Format::Exr, format!("a feature ({feature}) is"))
        }
        other => malformed(other),
    }
}

pub(super) fn malformed(message: impl ToString) -> ImageError {
    ImageError::malformed(Format::Exr, message)
}
