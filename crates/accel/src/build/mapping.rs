//! From positions to bins.

use super::bins::MAX_BINS;
use super::reference::{Box8, Reference};
use crate::kernel::{Isa, Lanes, Row};

/// From a doubled centre to bins: the integral part of `(center − origin) · scale`.
#[derive(Clone, Copy)]
pub(super) struct Mapping {
    origin: Row,
    scale: Row,
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
        let ([x, y, z, _], [sx, sy, sz]) = (bounds.min(), scale);
        // One in the free lanes: what a reference has there is subnormal, and would be slow to multiply.
        Self {
            origin: Row([x, y, z, 1.0, 0.0, 0.0, 0.0, 1.0]),
            scale: Row([sx, sy, sz, 0.0, 0.0, 0.0, 0.0, 0.0]),
        }
    }

    /// The same bins, for doubled positions.
    pub(super) fn doubled(&self) -> Self {
        Self { origin: Row(self.origin.0.map(|x| x * 2.0)), scale: Row(self.scale.0.map(|x| x * 0.5)) }
    }

    #[inline(always)]
    pub(super) fn bin(&self, position: f32, axis: usize) -> usize {
        bin_of(self.on(axis).rounded(position))
    }

    /// The mapping on one axis.
    #[inline(always)]
    pub(super) fn on(&self, axis: usize) -> AxisMapping {
        AxisMapping { origin: self.origin.0[axis], scale: self.scale.0[axis] }
    }

    /// Where bin `bin` begins.
    #[inline(always)]
    pub(super) fn position(&self, bin: usize, axis: usize) -> f32 {
        self.origin.0[axis] + bin as f32 / self.scale.0[axis]
    }

    /// The bins of a reference on the three axes.
    #[inline(always)]
    pub(super) fn bins<I: Isa>(&self, isa: I, reference: &Reference) -> [usize; 3] {
        let center = reference.doubled_center_on(isa);
        let rounded = (center - isa.load(&self.origin)) * isa.load(&self.scale) + isa.splat(ROUNDING);
        let [x, y, z, ..] = rounded.to_array();
        [bin_of(x), bin_of(y), bin_of(z)]
    }
}

/// [`Mapping`] on one axis.
#[derive(Clone, Copy)]
pub(super) struct AxisMapping {
    origin: f32,
    scale: f32,
}

impl AxisMapping {
    /// A position in bins, rounded. It does not fall where the position grows; NaN stands for bin 0.
    #[inline(always)]
    pub(super) fn rounded(self, position: f32) -> f32 {
        (position - self.origin) * self.scale + ROUNDING
    }
}

/// The bin in which a position lies, by [`AxisMapping::rounded`].
#[inline(always)]
fn bin_of(rounded: f32) -> usize {
    (rounded.to_bits() >> FRACTION_BITS) as usize % MAX_BINS
}

/// The largest [`AxisMapping::rounded`] of the positions in `bin`.
pub(super) fn border_of(bin: u32) -> f32 {
    f32::from_bits(ROUNDING.to_bits() + ((bin + 1) << FRACTION_BITS) - 1)
}

#[cfg(test)]
mod tests {
    use sahl_math::{Bounds3, Vec3};

    use super::*;

    #[test]
    fn the_border_of_a_bin_parts_what_bins_part() {
        let extent = Bounds3 { min: Vec3::new(-3.0, 0.1, 7.0), max: Vec3::new(11.0, 0.100_001, 7.0) };
        for bins in [2, 7, MAX_BINS] {
            let mapping = Mapping::new(&Box8::new(&extent), bins);
            for axis in 0..3 {
                let span = extent.max[axis] - extent.min[axis];
                for step in 0..=4096 {
                    let position = extent.min[axis] + span * step as f32 / 4096.0;
                    let bin = mapping.bin(position, axis);
                    assert!(bin < bins, "{position} falls into bin {bin} of {bins}");
                    for border in 0..bins {
                        let goes_right = mapping.on(axis).rounded(position) > border_of(border as u32);
                        assert_eq!(goes_right, bin > border, "{position}, bin {bin}, border {border}");
                    }
                }
            }
            for position in [f32::NAN, f32::INFINITY] {
                let goes_right = mapping.on(2).rounded(position) > border_of(0);
                assert_eq!(goes_right, mapping.bin(position, 2) > 0, "{position} on an axis without extent");
            }
        }
    }
}
