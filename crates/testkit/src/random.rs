//! Random numbers for tests: counter-based, the same on every machine.

use std::f32::consts::TAU;

use sahl_math::{Vec3, safe_sqrt};

/// The odd integer nearest 2⁶⁴ over the golden ratio: the step of the Weyl sequence under SplitMix64.
const GOLDEN_STEP: u64 = 0x9E37_79B9_7F4A_7C15;

/// A generator whose `n`-th number is a hash of the key and `n`, so that a failing case can be addressed directly.
///
/// Source: Steele, Lea, Flood, *Fast Splittable Pseudorandom Number Generators*, OOPSLA 2014 (SplitMix64).
#[derive(Clone, Debug)]
pub struct Rng {
    key: u64,
    counter: u64,
}

impl Rng {
    /// The generator of a seed.
    pub fn new(seed: u64) -> Self {
        Self::stream(seed, 0)
    }

    /// One of 2⁶⁴ independent generators of a seed: one for each case of a table, say.
    pub fn stream(seed: u64, stream: u64) -> Self {
        Self { key: mix(mix(seed.wrapping_add(GOLDEN_STEP)) ^ stream.wrapping_mul(GOLDEN_STEP)), counter: 0 }
    }

    /// The next 64 random bits.
    pub fn next_u64(&mut self) -> u64 {
        self.counter = self.counter.wrapping_add(1);
        mix(self.key.wrapping_add(self.counter.wrapping_mul(GOLDEN_STEP)))
    }

    /// The next 32 random bits.
    pub fn next_u32(&mut self) -> u32 {
        (self.next_u64() >> 32) as u32
    }

    /// A uniform integer below `n`, which must not be zero.
    ///
    /// The bias of the multiplication method, below `n / 2⁶⁴`, is far beyond what a test can see.
    pub fn below(&mut self, n: usize) -> usize {
        assert!(n > 0, "no integer is below zero");
        ((u128::from(self.next_u64()) * n as u128) >> 64) as usize
    }

    /// Uniform in [0, 1), with 24 bits.
    pub fn next_f32(&mut self) -> f32 {
        (self.next_u64() >> 40) as f32 * (1.0 / 16_777_216.0)
    }

    /// Uniform in [0, 1), with 53 bits.
    pub fn next_f64(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// `N` independent uniform numbers in [0, 1).
    pub fn uniform<const N: usize>(&mut self) -> [f32; N] {
        std::array::from_fn(|_| self.next_f32())
    }

    /// Uniform between `low` (included) and `high` (excluded, up to rounding).
    pub fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.next_f32()
    }

    /// A point uniform in the box between two corners.
    pub fn point(&mut self, low: Vec3, high: Vec3) -> Vec3 {
        let u: [f32; 3] = self.uniform();
        low + (high - low).zip(u.into(), |size, t| size * t)
    }

    /// A direction uniform on the unit sphere.
    pub fn direction(&mut self) -> Vec3 {
        let z = 1.0 - 2.0 * self.next_f32();
        let (sin, cos) = (TAU * self.next_f32()).sin_cos();
        let radius = safe_sqrt(1.0 - z * z);
        Vec3::new(radius * cos, radius * sin, z)
    }

    /// A direction uniform on the hemisphere about +z.
    pub fn hemisphere(&mut self) -> Vec3 {
        let direction = self.direction();
        Vec3::new(direction.x, direction.y, direction.z.abs())
    }

    /// A normally distributed number of mean zero and variance one (Box and Muller 1958).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.next_f64()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.next_f64()).cos()
    }
}

/// The finaliser of SplitMix64: a bijection of 64 bits in which each input bit changes half of the output bits.
fn mix(mut bits: u64) -> u64 {
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    bits ^ (bits >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::Running;

    #[test]
    fn a_seed_gives_the_same_numbers_and_streams_differ() {
        let draw = |mut rng: Rng| -> Vec<u64> { (0..8).map(|_| rng.next_u64()).collect() };
        assert_eq!(draw(Rng::new(7)), draw(Rng::new(7)));
        assert_ne!(draw(Rng::new(7)), draw(Rng::new(8)));
        assert_ne!(draw(Rng::stream(7, 0)), draw(Rng::stream(7, 1)));
    }

    #[test]
    fn moments_are_those_of_the_distributions() {
        let mut rng = Rng::new(1);
        let (mut uniform, mut normal, mut z) = (Running::default(), Running::default(), Running::default());
        for _ in 0..200_000 {
            uniform.add(rng.next_f64());
            normal.add(rng.normal());
            z.add(f64::from(rng.direction().z));
        }
        for (running, mean, variance) in [(uniform, 0.5, 1.0 / 12.0), (normal, 0.0, 1.0), (z, 0.0, 1.0 / 3.0)]
        {
            let error = 5.0 * running.variance_of_mean().sqrt();
            assert!((running.mean() - mean).abs() < error, "{running:?}");
            assert!((running.variance() / variance - 1.0).abs() < 0.02, "{running:?}");
        }
    }

    #[test]
    fn ranges_are_kept() {
        let mut rng = Rng::new(2);
        for _ in 0..10_000 {
            assert!((0.0..1.0).contains(&rng.next_f32()));
            assert!(rng.below(3) < 3);
            assert!(rng.hemisphere().z >= 0.0);
            let p = rng.point(Vec3::new(-1.0, 2.0, 5.0), Vec3::new(1.0, 3.0, 5.0));
            assert!(p.x.abs() <= 1.0 && (2.0..=3.0).contains(&p.y) && p.z == 5.0);
        }
    }
}
