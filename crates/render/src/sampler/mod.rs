//! Sources of sample points.
//!
//! Design decision: a coordinate is a pure function of (seed, pixel, sample index, dimension), computed by hashing and
//! without tables. [`Sampler::start`] fixes pixel, index and first dimension; each further call takes the next
//! dimensions. Any sample can therefore be drawn again on its own, on any machine and in any order.
//!
//! Deliberately absent: state that outlives a sample. Only a [`Stream`] must be advanced step by step: it is for walks of
//! unknown length within a sample.
//!
//! In a scene file: `Sampler "zsobol" "integer pixelsamples" 64 "integer seed" 3`.

pub(crate) mod hash;
mod independent;
mod sobol;
mod stream;

pub(crate) use hash::{mix, to_unit};
use sahl_math::Vec2;
use sahl_scene::SamplerKind;

pub use independent::Independent;
pub use sobol::Sobol;
pub use stream::Stream;

/// A source of sample points in [0, 1), addressed by pixel, sample index and dimension.
#[derive(Clone, Debug)]
pub enum Sampler {
    /// Owen-scrambled Sobol' points whose error is blue noise on the screen.
    Sobol(Sobol),
    /// Independent uniform points.
    Independent(Independent),
}

impl Sampler {
    /// The sampler a scene asks for, for an image of `resolution` pixels (width, height).
    ///
    /// Pixels outside the resolution and indices beyond the declared number of samples are valid too: their points are
    /// as well distributed, but not stratified against the others.
    pub fn new(description: &sahl_scene::Sampler, resolution: [u32; 2]) -> Self {
        match description.kind {
            SamplerKind::Sobol => Self::Sobol(Sobol::new(description.seed, description.samples, resolution)),
            SamplerKind::Independent => Self::Independent(Independent::new(description.seed)),
        }
    }

    /// Turns to sample `index` of `pixel`; the next coordinate is that of `dimension`.
    #[inline]
    pub fn start(&mut self, pixel: [u32; 2], index: u32, dimension: u32) {
        match self {
            Self::Sobol(sobol) => sobol.start(pixel, index, dimension),
            Self::Independent(independent) => independent.start(pixel, index, dimension),
        }
    }

    /// The coordinate of the next dimension, in [0, 1).
    #[inline]
    pub fn next_1d(&mut self) -> f32 {
        match self {
            Self::Sobol(sobol) => sobol.next_1d(),
            Self::Independent(independent) => independent.next_1d(),
        }
    }

    /// The coordinates of the next two dimensions, in [0, 1)²: stratified together.
    #[inline]
    pub fn next_2d(&mut self) -> Vec2 {
        match self {
            Self::Sobol(sobol) => sobol.next_2d(),
            Self::Independent(independent) => independent.next_2d(),
        }
    }

    /// The coordinates of a point in the pixel, in [0, 1)²: what importance-samples the pixel filter.
    ///
    /// They take two dimensions like any others, since samples do not leave their pixel.
    #[inline]
    pub fn pixel_2d(&mut self) -> Vec2 {
        self.next_2d()
    }
}

#[cfg(test)]
mod tests;
