//! From positions to bins.

use super::bins::MAX_BINS;
use super::reference::{Box8, Reference};

/// From a doubled centre to bins: the integral part of `(center − origin) · scale`.
#[derive(Clone, Copy)]
pub(super) struct Mapping {
    origin: [f32; 4],
    scale: [f32; 4],
}

/// Adding it to a number from 0 to 16 rounds that to 1 / 2^[`FRACTION_BITS`] and leaves it in the lowest bits.
const ROUNDING: f32 = (1 << (23 - FRACTION_BITS)) as f32;
const FRACTION_BITS: u32 = 6;

impl Mapping {
    pub(super) fn new(bounds: &Box8, bins: usize) -> Self {
        // So much below the number of bins that rounding does not reach it.
        let last = bins as f32 - 1.0 / (1 << FRACTION_BITS) as f32;
        // An axis without extent, or one that overflows, sends everything to bin 0 and is never split.
        let scale = bounds.diagonal().map(|extent| {
            let scale = last / extent;
            if extent > 0.0 && scale.is_finite() { scale } else { 0.0 }
        });
        let [x, y, z, _] = bounds.min();
        Self { origin: [x, y, z, 0.0], scale: [scale[0], scale[1], scale[2], 0.0] }
    }

    /// The same bins, for doubled positions.
    pub(super) fn doubled(&self) -> Self {
        Self { origin: self.origin.map(|x| x * 2.0), scale: self.scale.map(|x| x * 0.5) }
    }

    #[inline(always)]
    pub(super) fn bin(&self, position: f32, axis: usize) -> u32 {
        let position = (position - self.origin[axis]) * self.scale[axis] + ROUNDING;
        (position.to_bits() >> FRACTION_BITS) % MAX_BINS as u32
    }

    /// Where bin `bin` begins.
    #[inline(always)]
    pub(super) fn position(&self, bin: usize, axis: usize) -> f32 {
        self.origin[axis] + bin as f32 / self.scale[axis]
    }

    /// The bins of a reference on the three axes.
    #[inline(always)]
    pub(super) fn bins(&self, reference: &Reference) -> [u32; 3] {
        let center = reference.doubled_center();
        let bins: [u32; 4] = std::array::from_fn(|axis| self.bin(center[axis], axis));
        [bins[0], bins[1], bins[2]]
    }
}
