//! Owen-scrambled Sobol' points whose error is blue noise on the screen.

use sahl_math::Vec2;

use super::hash::{GOLDEN_STEP, mix, morton_code, owen_scramble, owen_scramble_digits, to_unit};

/// Bits of an index into the Sobol' sequence.
const INDEX_BITS: u32 = 32;
/// At least this many bits tell pixels apart, however many samples a pixel has: tiles of 16 × 16 pixels.
const MIN_PIXEL_BITS: u32 = 8;

/// Points of the two-dimensional Sobol' sequence, Owen-scrambled, with one random piece for each pair of dimensions.
///
/// The samples of all pixels together are the points of a single (0, 2)-sequence, dealt out along the Z curve: a pixel
/// has one aligned run of it, neighbours have neighbouring runs, and so every square of 2^k × 2^k pixels on the grid is
/// well distributed as a whole. What a pixel's estimate misses, its neighbours tend to make up for: the error of the
/// image is blue noise. For each pair of dimensions the order in which runs are given to pixels is shuffled in base 4
/// on the curve's digits, and the order of a pixel's samples in base 2; both keep the strata.
///
/// For each pair of dimensions, the first 2^k samples of a pixel are a (0, k, 2)-net in base 2: one lies in each of the
/// 2^k equal boxes of any dyadic shape. The error of an average of N = 2^k smooth samples falls as N^−3/2.
///
/// Source: Ahmed, Wonka, *Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of
/// Pixels*, ACM TOG 39(6), 2020; Burley, *Practical Hash-based Owen Scrambling*, JCGT 9(4), 2020. Deviations: both
/// shuffles are one hash instead of a loop over digits; samples are shuffled in base 2, so that net prefixes hold for
/// odd powers of two also; indices have 32 bits, and where pixels and samples need more, the image is divided into
/// square blocks with sequences of their own.
#[derive(Clone, Copy, Debug)]
pub struct Sobol {
    seed: u64,
    /// Bits of the index that count the samples of a pixel.
    sample_bits: u32,
    /// Bits of the index that tell the pixels of a block apart; even.
    pixel_bits: u32,
    /// The even bits of the pixels' digits in a reversed index.
    digits: u32,
    /// Hash of the seed and of what does not fit into an index.
    key: u64,
    /// Position in the block's sequence before shuffling, in reverse order: bit 0 is the most significant.
    reversed_index: u32,
    dimension: u32,
}

impl Sobol {
    /// The sampler for `seed`, at sample 0 of pixel (0, 0).
    ///
    /// `samples` a pixel are balanced against those of its neighbours, in an image of `resolution` pixels. Other
    /// numbers of samples work too: the prefix of a pixel's samples is well distributed in itself.
    pub fn new(seed: u64, samples: u32, resolution: [u32; 2]) -> Self {
        let ceil_log2 = |n: u32| u32::BITS - n.saturating_sub(1).leading_zeros();
        let sample_bits = ceil_log2(samples).min(INDEX_BITS - MIN_PIXEL_BITS);
        let pixel_bits =
            (2 * ceil_log2(resolution[0].max(resolution[1]))).min((INDEX_BITS - sample_bits) & !1);
        let seed = mix(seed.wrapping_add(GOLDEN_STEP));
        let digits = (0x5555_5555 & ((1_u64 << pixel_bits) - 1)) as u32;
        let mut sampler =
            Self { seed, sample_bits, pixel_bits, digits, key: 0, reversed_index: 0, dimension: 0 };
        sampler.start([0, 0], 0, 0);
        sampler
    }

    /// See [`super::Sampler::start`].
    #[inline]
    pub fn start(&mut self, pixel: [u32; 2], index: u32, dimension: u32) {
        let code = morton_code(pixel);
        let (block, place) = (code >> self.pixel_bits, code & ((1 << self.pixel_bits) - 1));
        let (round, sample) = (index >> self.sample_bits, index & ((1 << self.sample_bits) - 1));
        self.key = if block == 0 && round == 0 {
            self.seed
        } else {
            mix(self.seed ^ mix(block.wrapping_mul(GOLDEN_STEP) ^ u64::from(round) << 32))
        };
        let index = (place << self.sample_bits) as u32 | sample;
        self.reversed_index = (u64::from(index.reverse_bits()) >> (INDEX_BITS - self.index_bits())) as u32;
        self.dimension = dimension;
    }

    #[inline]
    fn index_bits(&self) -> u32 {
        self.sample_bits + self.pixel_bits
    }

    /// The position in the sequence for the next dimension, and a fresh hash.
    #[inline]
    fn next(&mut self, dimensions: u32) -> (u32, u64) {
        let hash = mix(self.key.wrapping_add(u64::from(self.dimension).wrapping_mul(GOLDEN_STEP)));
        self.dimension = self.dimension.wrapping_add(dimensions);
        let shuffled = owen_scramble_digits(self.reversed_index, hash as u32, self.digits);
        // The shift drops what the hash left above the bits in use, and works for none in use, too.
        let index = (u64::from(shuffled.reverse_bits()) << self.index_bits() >> INDEX_BITS) as u32;
        (index, hash)
    }

    /// See [`super::Sampler::next_1d`].
    #[inline]
    pub fn next_1d(&mut self) -> f32 {
        let (index, hash) = self.next(1);
        to_unit(owen_scramble(index, (hash >> 32) as u32).reverse_bits())
    }

    /// See [`super::Sampler::next_2d`].
    #[inline]
    pub fn next_2d(&mut self) -> Vec2 {
        let (index, hash) = self.next(2);
        let x = owen_scramble(index, (hash >> 32) as u32);
        let y = owen_scramble(pascal(index), (hash.wrapping_mul(GOLDEN_STEP) >> 32) as u32);
        // One reversal of 64 bits reverses both and swaps them.
        let both = (u64::from(x) << 32 | u64::from(y)).reverse_bits();
        Vec2::new(to_unit(both as u32), to_unit((both >> 32) as u32))
    }
}

/// The second coordinate of point `index` of the Sobol' sequence, bits in reverse order; the first is `index` itself.
///
/// Its generator matrix is Pascal's triangle modulo 2. By Lucas' theorem, bit i of the result is the sum of all bits j
/// of the index such that the binary digits of i are among those of j; five steps, one for each digit of i, add them.
///
/// Source: Ahmed, *An Implementation Algorithm of 2D Sobol Sequence Fast, Elegant, and Compact*, EGSR 2024.
#[inline]
fn pascal(mut index: u32) -> u32 {
    index ^= (index >> 1) & 0x5555_5555;
    index ^= (index >> 2) & 0x3333_3333;
    index ^= (index >> 4) & 0x0F0F_0F0F;
    index ^= (index >> 8) & 0x00FF_00FF;
    index ^ index >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pascal_is_the_second_sobol_dimension() {
        // Direction numbers by their recurrence (Bratley, Fox 1988): v_k = v_{k-1} xor (v_{k-1} >> 1), as fractions.
        let mut direction = 1_u32 << 31;
        for bit in 0..32 {
            assert_eq!(pascal(1 << bit).reverse_bits(), direction, "bit {bit}");
            direction ^= direction >> 1;
        }
        assert_eq!(pascal(0b1011), pascal(1) ^ pascal(2) ^ pascal(8));
    }

    #[test]
    fn index_bits_are_shared_out() {
        let bits = |samples, resolution| {
            let sampler = Sobol::new(0, samples, resolution);
            (sampler.sample_bits, sampler.pixel_bits)
        };
        assert_eq!(bits(1, [1, 1]), (0, 0));
        assert_eq!(bits(0, [0, 0]), (0, 0));
        assert_eq!(bits(16, [1280, 720]), (4, 22));
        assert_eq!(bits(17, [1025, 1]), (5, 22));
        assert_eq!(bits(1024, [3840, 2160]), (10, 22));
        assert_eq!(bits(u32::MAX, [8192, 8192]), (24, 8));
    }
}
