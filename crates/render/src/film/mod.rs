//! The film: sums of samples by pixel, and the images that come of them.
//!
//! Design decision: the film is made of the tiles in which it is rendered, each of which belongs to one thread at a
//! time. A pixel adds its samples in the order of their numbers, so that neither the number of threads nor the size of
//! the tiles changes a bit of the result, and a film that is looked at between two tiles is valid: its pixels may have
//! different numbers of samples.
//!
//! Deliberately absent: files, tone mapping, and reconstruction over several pixels (the filter is importance-sampled).

mod pixel;
mod sensor;
mod tile;

use sahl_image::{ColorSpace, Image, Layer};

use crate::Aov;
pub(crate) use sensor::Sensor;
pub use tile::DroppedSample;
pub(crate) use tile::{SampleId, Tile};

/// An image in the making.
#[derive(Clone, Debug)]
pub struct Film {
    resolution: [u32; 2],
    /// x min, x max, y min, y max; the maxima exclusive.
    crop: [u32; 4],
    color_space: ColorSpace,
    aovs: Vec<Aov>,
    tiles: Vec<Tile>,
}

impl Film {
    /// An empty film with what `description` asks for, divided into tiles of at most `tile_size` pixels a side.
    ///
    /// A crop that reaches outside the image is cut; one that is empty, or a tile size of zero, counts as one pixel.
    pub(crate) fn new(description: &sahl_scene::Film, aovs: &[Aov], tile_size: u32) -> Self {
        let crop = effective_crop(description);
        let tile_size = tile_size.max(1);
        let (sensor, channels) = (Sensor::new(description), Aov::sums(aovs));
        let rows = (crop[2]..crop[3]).step_by(tile_size as usize);
        let tiles = rows
            .flat_map(|y| (crop[0]..crop[1]).step_by(tile_size as usize).map(move |x| [x, y]))
            .map(|[x, y]| {
                let size = [tile_size.min(crop[1] - x), tile_size.min(crop[3] - y)];
                Tile::new([x, y], size, channels, sensor)
            })
            .collect();
        Self {
            resolution: description.resolution,
            crop,
            color_space: description.color_space,
            aovs: aovs.to_vec(),
            tiles,
        }
    }

    /// Width and height of the full image.
    pub fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    /// The part of the full image that the film holds: x min, x max, y min, y max, the maxima exclusive.
    pub fn crop(&self) -> [u32; 4] {
        self.crop
    }

    /// Width and height of the part that the film holds.
    pub fn size(&self) -> [usize; 2] {
        [(self.crop[1] - self.crop[0]) as usize, (self.crop[3] - self.crop[2]) as usize]
    }

    /// The image: linear RGB of the film's colour space, exposed; black where no sample was taken.
    pub fn develop(&self) -> Image {
        self.image_of(3, |tile, place, out| {
            out.copy_from_slice(&tile.pixels[place].color().map(|x| x as f32));
        })
    }

    /// The variance of each component of [`Film::develop`], estimated from the spread of the samples, as if they were
    /// independent: an upper bound for well-spread points. Infinite in pixels with fewer than two samples.
    pub fn variance(&self) -> Image {
        self.image_of(3, |tile, place, out| {
            out.copy_from_slice(&tile.pixels[place].variance().map(|x| x as f32));
        })
    }

    /// The image and one layer for each [`Aov`] that was asked for, in that order.
    pub fn layers(&self) -> Vec<Layer> {
        let mut layers = vec![Layer::beauty(self.develop())];
        let channels = Aov::sums(&self.aovs);
        let mut first = 0;
        for aov in &self.aovs {
            let names = aov.channel_names();
            let image = self.image_of(names.len(), |tile, place, out| {
                let sums = &tile.features[place * channels..(place + 1) * channels];
                aov.develop(&sums[first..], sums[channels - 1], tile.pixels[place].samples(), out);
            });
            first += names.len();
            let channel_names = names.iter().map(|&name| name.to_owned()).collect();
            layers.push(Layer { name: aov.layer_name().map(str::to_owned), channel_names, image });
        }
        layers
    }

    /// The smallest and the largest number of samples that a pixel has.
    pub fn samples(&self) -> [u32; 2] {
        let counts = self.tiles.iter().flat_map(|tile| &tile.pixels).map(pixel::Pixel::samples);
        counts.fold([u32::MAX, 0], |[low, high], n| [low.min(n), high.max(n)])
    }

    /// How many samples were left out because their colour was NaN, infinite or negative.
    pub fn dropped(&self) -> u64 {
        self.tiles.iter().map(|tile| tile.dropped).sum()
    }

    /// The first of the dropped samples, in the order in which one thread would have met them.
    pub fn dropped_samples(&self) -> Vec<DroppedSample> {
        let mut all: Vec<_> = self.tiles.iter().flat_map(|tile| &tile.first_dropped).copied().collect();
        all.sort_by_key(|(pass, sample)| (*pass, tile::reading_order(sample)));
        all.into_iter().take(tile::REMEMBERED).map(|(_, sample)| sample).collect()
    }

    pub(crate) fn aovs(&self) -> &[Aov] {
        &self.aovs
    }

    pub(crate) fn tiles_mut(&mut self) -> &mut [Tile] {
        &mut self.tiles
    }

    /// Number of pixels.
    pub(crate) fn pixel_count(&self) -> u64 {
        let [width, height] = self.size();
        width as u64 * height as u64
    }

    /// An image of the film's size whose pixels `write` fills from a tile and a place in it.
    fn image_of(&self, channels: usize, write: impl Fn(&Tile, usize, &mut [f32])) -> Image {
        let [width, height] = self.size();
        let mut values = vec![0.0; width * height * channels];
        for tile in &self.tiles {
            for (place, [x, y]) in tile.pixels() {
                let pixel = (y - self.crop[2]) as usize * width + (x - self.crop[0]) as usize;
                write(tile, place, &mut values[pixel * channels..(pixel + 1) * channels]);
            }
        }
        Image::new(width, height, channels, sahl_image::Pixels::F32(values))
            .expect("the buffer was made for this size")
            .with_color_space(self.color_space)
    }
}

/// The part of the image that is rendered: within the image, and at least one pixel.
fn effective_crop(film: &sahl_scene::Film) -> [u32; 4] {
    let [width, height] = film.resolution.map(|pixels| pixels.max(1));
    let [x0, x1, y0, y1] = film.crop.unwrap_or([0, width, 0, height]);
    let (x0, y0) = (x0.min(width - 1), y0.min(height - 1));
    [x0, x1.clamp(x0 + 1, width), y0, y1.clamp(y0 + 1, height)]
}

#[cfg(test)]
mod tests;
