//! A rectangle of the film, which one thread fills at a time.

use super::pixel::Pixel;
use super::sensor::Sensor;
use crate::spectrum::{Spectrum, Wavelengths};

/// A sample that was left out of the image because its colour was no colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DroppedSample {
    /// Column and row of the pixel in the full image.
    pub pixel: [u32; 2],
    /// The sample's number in its pixel.
    pub index: u32,
    /// What it would have added, in the film's colour space.
    pub color: [f32; 3],
}

/// How many dropped samples are remembered one by one.
pub(super) const REMEMBERED: usize = 16;

/// A rectangle of the film.
#[derive(Clone, Debug)]
pub(crate) struct Tile {
    /// Column and row of its upper left pixel in the full image.
    pub(crate) origin: [u32; 2],
    /// Width and height.
    pub(crate) size: [u32; 2],
    pub(super) pixels: Vec<Pixel>,
    /// Sums of the features of each pixel, `channels` a pixel.
    pub(super) features: Vec<f64>,
    channels: usize,
    sensor: Sensor,
    pub(super) dropped: u64,
    /// The first of the dropped samples, with the pass in which each was taken.
    pub(super) first_dropped: Vec<(u32, DroppedSample)>,
}

impl Tile {
    pub(super) fn new(origin: [u32; 2], size: [u32; 2], channels: usize, sensor: Sensor) -> Self {
        let count = size[0] as usize * size[1] as usize;
        Self {
            origin,
            size,
            pixels: vec![Pixel::default(); count],
            features: vec![0.0; count * channels],
            channels,
            sensor,
            dropped: 0,
            first_dropped: Vec::new(),
        }
    }

    /// The pixels' places in the tile and in the full image, row by row.
    pub(crate) fn pixels(&self) -> impl Iterator<Item = (usize, [u32; 2])> + use<> {
        let (origin, [width, height]) = (self.origin, self.size);
        (0..height).flat_map(move |y| (0..width).map(move |x| [origin[0] + x, origin[1] + y])).enumerate()
    }

    /// Number of pixels.
    pub(crate) fn pixel_count(&self) -> u64 {
        self.pixels.len() as u64
    }

    /// How many samples were left out so far.
    pub(crate) fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Adds a sample of the pixel at `place`; returns whether it was kept. What is not a colour (NaN, infinite, negative) is
    /// counted, remembered and left out.
    #[inline]
    pub(crate) fn add(
        &mut self,
        place: usize,
        radiance: Spectrum,
        wavelengths: &Wavelengths,
        weight: f32,
        taken: SampleId,
    ) -> bool {
        let color = self.sensor.kept_color(radiance, wavelengths);
        match color {
            Some(color) => self.pixels[place].add(color, weight),
            None => self.drop_sample(self.sensor.color(radiance, wavelengths), taken),
        }
        color.is_some()
    }

    /// Adds the features of a sample of the pixel at `place`.
    pub(crate) fn add_features(&mut self, place: usize, features: &[f32]) {
        let sums = &mut self.features[place * self.channels..(place + 1) * self.channels];
        for (sum, &feature) in sums.iter_mut().zip(features) {
            *sum += f64::from(feature);
        }
    }

    #[cold]
    fn drop_sample(&mut self, color: [f32; 3], taken: SampleId) {
        self.dropped += 1;
        if self.first_dropped.len() < REMEMBERED {
            let SampleId { pass, pixel, index } = taken;
            self.first_dropped.push((pass, DroppedSample { pixel, index, color }));
        }
    }
}

/// Which sample of the image: pass, pixel of the full image, and number in the pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SampleId {
    pub(crate) pass: u32,
    pub(crate) pixel: [u32; 2],
    pub(crate) index: u32,
}

/// Column and row of a pixel, in the order in which an image is read.
pub(super) fn reading_order(sample: &DroppedSample) -> (u32, u32, u32) {
    (sample.pixel[1], sample.pixel[0], sample.index)
}
