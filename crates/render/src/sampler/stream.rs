//! Numbers without end, for walks whose number of steps nobody knows.

use sahl_math::Vec2;

use super::hash::{GOLDEN_STEP, mix, to_unit};

/// Independent uniform numbers in [0, 1), as many as are asked for.
///
/// A walk through a medium takes a number for each tentative collision. Were they dimensions of the sampler, the dimensions
/// of the bounces that follow would depend on how many there were.
///
/// Source: Steele, Lea, Flood, *Fast Splittable Pseudorandom Number Generators*, OOPSLA 2014.
#[derive(Clone, Copy, Debug)]
pub struct Stream {
    state: u64,
}

impl Stream {
    /// A stream for those that need none.
    pub(crate) const EMPTY: Self = Self { state: 0 };

    /// The stream that a point of the sampler stands for: as independent of others as the points are.
    #[inline]
    pub fn new(u: Vec2) -> Self {
        Self { state: mix(u64::from(u.x.to_bits()) << 32 | u64::from(u.y.to_bits())) }
    }

    /// The next number.
    #[inline]
    pub fn next_1d(&mut self) -> f32 {
        self.state = self.state.wrapping_add(GOLDEN_STEP);
        to_unit((mix(self.state) >> 32) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_uniform_and_differ() {
        let (mut one, mut other) = (Stream::new(Vec2::ZERO), Stream::new(Vec2::new(0.0, 0.5)));
        let n = 100_000;
        let (mut mean, mut square, mut product) = (0.0, 0.0, 0.0);
        for _ in 0..n {
            let (a, b) = (f64::from(one.next_1d()), f64::from(other.next_1d()));
            mean += a / f64::from(n);
            square += a * a / f64::from(n);
            product += (a - 0.5) * (b - 0.5) / f64::from(n);
        }
        // Five standard deviations.
        assert!((mean - 0.5).abs() < 5.0 * 0.2887 / 316.0, "{mean}");
        assert!((square - 1.0 / 3.0).abs() < 5.0 * 0.2981 / 316.0, "{square}");
        assert!(product.abs() < 5.0 / 12.0 / 316.0, "{product}");
    }
}
