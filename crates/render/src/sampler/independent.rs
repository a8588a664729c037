//! Independent uniform points.

use sahl_math::Vec2;

use super::hash::{GOLDEN_STEP, mix, morton_code, to_unit};

/// Uniform points without any structure: the baseline that other samplers are measured against.
///
/// The error of an average of N of them falls as N^−½.
#[derive(Clone, Copy, Debug)]
pub struct Independent {
    seed: u64,
    /// Hash of seed, pixel and index.
    key: u64,
    dimension: u32,
}

impl Independent {
    /// The sampler for `seed`, at sample 0 of pixel (0, 0).
    pub fn new(seed: u64) -> Self {
        let mut sampler = Self { seed: mix(seed ^ GOLDEN_STEP), key: 0, dimension: 0 };
        sampler.start([0, 0], 0, 0);
        sampler
    }

    /// See [`super::Sampler::start`].
    #[inline]
    pub fn start(&mut self, pixel: [u32; 2], index: u32, dimension: u32) {
        let pixel = mix(self.seed.wrapping_add(morton_code(pixel).wrapping_mul(GOLDEN_STEP)));
        self.key = mix(pixel.wrapping_add(u64::from(index).wrapping_mul(GOLDEN_STEP)));
        self.dimension = dimension;
    }

    #[inline]
    fn bits(&mut self, dimensions: u32) -> u64 {
        let bits = mix(self.key.wrapping_add(u64::from(self.dimension).wrapping_mul(GOLDEN_STEP)));
        self.dimension = self.dimension.wrapping_add(dimensions);
        bits
    }

    /// See [`super::Sampler::next_1d`].
    #[inline]
    pub fn next_1d(&mut self) -> f32 {
        to_unit((self.bits(1) >> 32) as u32)
    }

    /// See [`super::Sampler::next_2d`].
    #[inline]
    pub fn next_2d(&mut self) -> Vec2 {
        let bits = self.bits(2);
        Vec2::new(to_unit((bits >> 32) as u32), to_unit(bits as u32))
    }
}
