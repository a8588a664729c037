//! Four lanes as an array: the specification of the vector type.
#![cfg_attr(
    all(target_arch = "x86_64", not(test)),
    expect(
        dead_code,
        reason = "on this processor the specification is what the vector unit is tested against"
    )
)]

use std::ops::{Add, Mul, Sub};

/// Four `f32`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F32x4([f32; 4]);

impl F32x4 {
    #[inline(always)]
    pub(crate) fn splat(value: f32) -> Self {
        Self([value; 4])
    }

    #[inline(always)]
    pub(crate) fn load(lanes: &[f32; 4]) -> Self {
        Self(*lanes)
    }

    #[inline(always)]
    pub(crate) fn to_array(self) -> [f32; 4] {
        self.0
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|lane| f(self.0[lane], other.0[lane])))
    }

    /// The smaller of each pair; the second where either is NaN.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    /// The larger of each pair; the second where either is NaN.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    /// The absolute values.
    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self(self.0.map(f32::abs))
    }

    /// `1 / x`, rounded as a division.
    #[inline(always)]
    pub(crate) fn reciprocal(self) -> Self {
        Self(self.0.map(|x| 1.0 / x))
    }

    #[inline(always)]
    fn bits(self, other: Self, f: impl Fn(&f32, &f32) -> bool) -> u32 {
        (0..4).map(|lane| u32::from(f(&self.0[lane], &other.0[lane])) << lane).sum()
    }

    /// One bit a lane: whether `self < other`; false for NaN.
    #[inline(always)]
    pub(crate) fn less(self, other: Self) -> u32 {
        self.bits(other, f32::lt)
    }

    /// One bit a lane: whether `self <= other`; false for NaN.
    #[inline(always)]
    pub(crate) fn less_or_equal(self, other: Self) -> u32 {
        self.bits(other, f32::le)
    }

    /// One bit a lane: whether `self == other`; false for NaN.
    #[inline(always)]
    pub(crate) fn equal(self, other: Self) -> u32 {
        self.bits(other, f32::eq)
    }
}

impl Add for F32x4 {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for F32x4 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for F32x4 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

#[cfg(test)]
mod tests {
    /// Values that tell implementations apart: signed zeros, infinities, NaN, subnormals, neighbours of one.
    const NASTY: [f32; 12] = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        1.000_000_1,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
        f32::MIN_POSITIVE,
        1e-45,
        f32::MAX,
        -3.7,
    ];

    #[test]
    fn the_vector_unit_agrees_with_the_specification() {
        use super::F32x4 as Specified;
        use crate::kernel::F32x4 as Vector;
        for a in NASTY {
            for b in NASTY {
                let (left, right) = ([a, b, a, 2.0], [b, a, 0.5, b]);
                let (x, y) = (Vector::load(&left), Vector::load(&right));
                let (p, q) = (Specified::load(&left), Specified::load(&right));
                let same = |x: Vector, p: Specified| {
                    let (x, p) = (x.to_array(), p.to_array());
                    (0..4).all(|i| x[i].to_bits() == p[i].to_bits() || x[i].is_nan() && p[i].is_nan())
                };
                assert!(same(x + y, p + q) && same(x - y, p - q) && same(x * y, p * q), "{a} {b}");
                assert!(same(x.min(y), p.min(q)) && same(x.max(y), p.max(q)), "{a} {b}");
                assert!(same(x.reciprocal(), p.reciprocal()) && same(x.abs(), p.abs()), "{a} {b}");
                assert_eq!(
                    [x.less(y), x.less_or_equal(y), x.equal(y)],
                    [p.less(q), p.less_or_equal(q), p.equal(q)],
                    "{a} {b}"
                );
                assert!(same(Vector::splat(a), Specified::splat(a)));
            }
        }
    }
}
