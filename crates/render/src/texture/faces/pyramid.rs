//! Images of faces in ever smaller sizes.
//!
//! A size has half as many pixels along each axis as the one before, as long as there is more than one; the last is one pixel, the mean of
//! all. Means are those of the values that are stored, and stored as these are.

use std::sync::Arc;

use sahl_scene::{Face, FaceImages, FaceTexels};

use super::walk::Place;

/// Images with their smaller sizes.
#[derive(Debug)]
pub(in super::super) struct Pyramid {
    images: Arc<FaceImages>,
    /// Where the smaller sizes of each face begin among `smaller`: one after the other, none of constant faces.
    first: Box<[usize]>,
    smaller: FaceTexels,
}

impl Pyramid {
    /// `None` if the images refer to what is not there.
    pub(in super::super) fn new(images: &Arc<FaceImages>) -> Option<Self> {
        if !images.is_usable() {
            return None;
        }
        let mut first = Vec::with_capacity(images.faces.len());
        let smaller = match &images.texels {
            FaceTexels::U8(values) => {
                FaceTexels::U8(smaller(images, values, &mut first, |mean| (mean + 0.5) as u8))
            }
            FaceTexels::U16(values) => {
                FaceTexels::U16(smaller(images, values, &mut first, |mean| (mean + 0.5) as u16))
            }
            FaceTexels::F32(values) => FaceTexels::F32(smaller(images, values, &mut first, |mean| mean)),
        };
        Some(Self { images: Arc::clone(images), first: first.into(), smaller })
    }

    /// Bytes beside those of the images.
    pub(in super::super) fn bytes(&self) -> u64 {
        (self.smaller.bytes() + size_of_val(&*self.first)) as u64
    }

    pub(super) fn channels(&self) -> usize {
        self.images.channels
    }

    #[inline]
    pub(super) fn face(&self, face: u32) -> Option<&Face> {
        self.images.faces.get(face as usize)
    }

    pub(super) fn size_log2(&self, face: u32) -> Option<[u32; 2]> {
        self.face(face).map(|face| face.size_log2.map(u32::from))
    }

    /// The pixel that holds a place, at the largest size that has no more pixels than the place asks for.
    pub(super) fn texel(&self, place: &Place) -> [f32; 3] {
        let Some(face) = self.face(place.face) else { return [0.0; 3] };
        let channels = self.images.channels;
        if face.is_constant {
            return read(&self.images.texels, face.first as usize, channels);
        }
        let log2 = face.size_log2.map(u32::from);
        let excess = [0, 1].map(|axis| (log2[axis] as i32 - place.grid[axis]).max(0).unsigned_abs());
        let level = excess[0].max(excess[1]).min(log2[0].max(log2[1]));
        let size = |level: u32| log2.map(|log| 1_usize << log.saturating_sub(level));
        let [width, height] = size(level);
        let index = |x: f32, count: usize| ((x * count as f32) as usize).min(count - 1);
        let pixel = index(place.uv.y, height) * width + index(place.uv.x, width);
        if level == 0 {
            return read(&self.images.texels, face.first as usize + pixel * channels, channels);
        }
        let before: usize = (1..level).map(|level| size(level).iter().product::<usize>()).sum();
        read(&self.smaller, self.first[place.face as usize] + (before + pixel) * channels, channels)
    }
}

#[inline]
fn read(texels: &FaceTexels, index: usize, channels: usize) -> [f32; 3] {
    if channels == 1 {
        [texels.value(index), 0.0, 0.0]
    } else {
        [texels.value(index), texels.value(index + 1), texels.value(index + 2)]
    }
}

/// The smaller sizes of all faces; where those of each begin goes to `first`.
fn smaller<T: Copy + Into<f32>>(
    images: &FaceImages,
    values: &[T],
    first: &mut Vec<usize>,
    store: impl Fn(f32) -> T,
) -> Arc<[T]> {
    let channels = images.channels;
    let mut all = Vec::new();
    for face in images.faces.iter() {
        first.push(all.len());
        if face.is_constant {
            continue;
        }
        let mut size = face.size_log2.map(|log| 1_usize << log);
        let stored = &values[face.first as usize..][..size[0] * size[1] * channels];
        let mut level: Vec<f32> = stored.iter().map(|&value| value.into()).collect();
        while size != [1, 1] {
            (level, size) = halved(&level, size, channels);
            all.extend(level.iter().map(|&mean| store(mean)));
        }
    }
    all.into()
}

/// Means of two by two pixels, or of two along a side of one.
fn halved(values: &[f32], [width, height]: [usize; 2], channels: usize) -> (Vec<f32>, [usize; 2]) {
    let [half_width, half_height] = [width, height].map(|n| (n / 2).max(1));
    let [columns, rows] = [width / half_width, height / half_height];
    let weight = 1.0 / (columns * rows) as f32;
    let mut means = Vec::with_capacity(half_width * half_height * channels);
    for y in 0..half_height {
        for x in 0..half_width {
            for channel in 0..channels {
                let pixels =
                    (0..rows).flat_map(|j| (0..columns).map(move |i| [x * columns + i, y * rows + j]));
                let sum: f32 = pixels.map(|[x, y]| values[(y * width + x) * channels + channel]).sum();
                means.push(sum * weight);
            }
        }
    }
    (means, [half_width, half_height])
}
