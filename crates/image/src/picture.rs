//! What a file holds: layers of one picture, and facts about it.

use crate::{Image, ImageError};

/// A rendered picture: the beauty, other layers, and facts about how it was made.
///
/// EXR keeps everything. The other formats keep the beauty alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// The layers; names of channels must be unique over all of them.
    pub layers: Vec<Layer>,
    /// Facts about the picture.
    pub metadata: Metadata,
}

/// Channels that belong together.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Written before the channel names, with a dot. `None`: the beauty, and single channels with customary bare
    /// names such as `Z`.
    pub name: Option<String>,
    /// One name a channel of the image, such as `R`, `G`, `B`.
    pub channel_names: Vec<String>,
    /// The values.
    pub image: Image,
}

/// Facts about a picture. Only EXR keeps them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata {
    /// Program and version, EXR's `software`.
    pub software: Option<String>,
    /// Free text, EXR's `comments`.
    pub comments: Option<String>,
    /// Samples a pixel, written as pbrt does: an integer `samplesPerPixel`.
    pub samples: Option<u32>,
    /// Seed of the renderer, written as the text `seed`, since EXR's integers have 32 bits.
    pub seed: Option<u64>,
    /// Pixel of the full picture at which a cropped one begins: EXR's data window.
    pub offset: [i32; 2],
    /// Size of the full picture of which this may be a crop, EXR's display window; `None`: it is the full one.
    pub full_size: Option<[usize; 2]>,
    /// Further attributes by name, in any order; they are written sorted. Of the names that OpenEXR itself defines, only
    /// `owner`, `worldToCamera` and `worldToNDC` are allowed.
    pub attributes: Vec<(String, Attribute)>,
}

/// Value of an attribute in [`Metadata`].
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// Text.
    Text(String),
    /// An integer.
    Int(i32),
    /// A float.
    Float(f32),
    /// Four rows of four, in the order in which the file holds them.
    Matrix([f32; 16]),
}

impl Picture {
    /// A picture of a beauty alone.
    pub fn from_image(image: Image) -> Picture {
        Picture { layers: vec![Layer::beauty(image)], metadata: Metadata::default() }
    }

    /// The layer that is shown: the first unnamed one with `R`, `G`, `B` or `Y`, else the first one with such
    /// channels, else the first one; `None` if there is no layer.
    pub fn beauty(&self) -> Option<&Layer> {
        self.layers.get(self.beauty_index())
    }

    /// [`Picture::beauty`] without a copy.
    pub fn into_beauty(mut self) -> Option<Layer> {
        let index = self.beauty_index();
        (index < self.layers.len()).then(|| self.layers.swap_remove(index))
    }

    /// Index of [`Picture::beauty`].
    pub(crate) fn beauty_index(&self) -> usize {
        let unnamed = self.layers.iter().position(|layer| layer.name.is_none() && layer.is_color());
        unnamed.or_else(|| self.layers.iter().position(Layer::is_color)).unwrap_or(0)
    }

    /// The first layer of that name.
    pub fn layer(&self, name: &str) -> Option<&Layer> {
        self.layers.iter().find(|layer| layer.name.as_deref() == Some(name))
    }
}

impl Layer {
    /// The unnamed layer of an image, its channels called Y, YA, RGB or RGBA.
    pub fn beauty(image: Image) -> Layer {
        let names = match image.channels {
            1 => "Y",
            2 => "YA",
            3 => "RGB",
            _ => "RGBA",
        };
        Layer { name: None, channel_names: names.chars().map(String::from).collect(), image }
    }

    /// A named layer of an image.
    ///
    /// # Errors
    /// [`ImageError::ChannelCount`] unless there is one name a channel.
    pub fn new(name: Option<&str>, channel_names: &[&str], image: Image) -> Result<Layer, ImageError> {
        if channel_names.len() != image.channels {
            return Err(ImageError::ChannelCount { found: channel_names.len() });
        }
        let channel_names = channel_names.iter().map(ToString::to_string).collect();
        Ok(Layer { name: name.map(String::from), channel_names, image })
    }

    /// Name of a channel in the file: that of the layer, a dot, that of the channel.
    pub(crate) fn full_channel_name(&self, channel: &str) -> String {
        match &self.name {
            Some(name) => format!("{name}.{channel}"),
            None => channel.to_string(),
        }
    }

    /// Whether the channels are RGB, RGBA, Y or YA.
    pub(crate) fn is_color(&self) -> bool {
        matches!(self.channel_names.concat().as_str(), "RGB" | "RGBA" | "Y" | "YA")
            && self.channel_names.iter().all(|name| name.len() == 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_beauty_is_the_unnamed_colour() {
        let grey = || Image::filled(1, 1, 1, 0.5).unwrap();
        let color = || Image::filled(1, 1, 3, 0.5).unwrap();
        let depth = Layer::new(None, &["Z"], grey()).unwrap();
        let albedo = Layer::new(Some("Albedo"), &["R", "G", "B"], color()).unwrap();
        let mut picture = Picture { layers: vec![depth.clone()], metadata: Metadata::default() };
        assert_eq!(picture.beauty(), Some(&depth));
        picture.layers.push(albedo.clone());
        assert_eq!(picture.beauty(), Some(&albedo));
        picture.layers.push(Layer::beauty(color()));
        assert_eq!(picture.beauty(), Some(&Layer::beauty(color())));
        assert_eq!(picture.layer("Albedo"), Some(&albedo));
        assert_eq!(Picture::default().beauty(), None);
        assert!(Layer::new(None, &["R", "G"], color()).is_err());
    }
}
