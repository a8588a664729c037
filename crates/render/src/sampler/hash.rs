//! Hashes: mixers of integers, and permutations of binary fractions that keep their strata.

/// The odd integer nearest 2⁶⁴ over the golden ratio: the step between the keys of consecutive dimensions.
pub(crate) const GOLDEN_STEP: u64 = 0x9E37_79B9_7F4A_7C15;

/// A bijection of 64 bits in which each input bit changes half of the output bits.
///
/// Source: Steele, Lea, Flood, *Fast Splittable Pseudorandom Number Generators*, OOPSLA 2014 (SplitMix64).
#[inline]
pub(crate) fn mix(mut bits: u64) -> u64 {
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    bits ^ (bits >> 31)
}

/// Owen scrambling, base 2, of a fraction whose bits are in reverse order: bit 0 halves the unit interval.
///
/// Bit k of the result is bit k of `n`, flipped by a hash of `seed` and the bits below k.
///
/// Source: the structure is that of Laine and Karras, *Stratified Sampling for Stochastic Transparency*, 2011; the
/// constants are Vegdahl's, *Building a Better LK Hash*, 2021; the use is that of Burley, *Practical Hash-based Owen
/// Scrambling*, JCGT 9(4), 2020.
#[inline]
pub(super) fn owen_scramble(n: u32, seed: u32) -> u32 {
    owen_scramble_digits(n, seed, 0)
}

/// Owen scrambling of a fraction with reversed bits, in base 4 where `digits` says so and in base 2 elsewhere.
///
/// `digits` marks the even bit of each base-4 digit, that is the more significant one, since the order is reversed.
/// Swapping halves at each level permutes the four values of a digit in 8 of 24 ways; the two lines that use `digits`
/// supply the other ones, by also swapping one pair of opposite quarters depending on a bit of the digit before.
///
/// Source: Vegdahl, *A Fast Hash For Base-4 Owen Scrambling*, 2022.
#[inline]
pub(super) fn owen_scramble_digits(mut n: u32, seed: u32, digits: u32) -> u32 {
    n ^= n.wrapping_mul(0x3D20_ADEA);
    n ^= (n >> 1) & (n << 1) & digits;
    n = n.wrapping_add(seed);
    n = n.wrapping_mul((seed >> 16) | 1);
    n ^= (n >> 1) & (n << 1) & digits;
    n ^= n.wrapping_mul(0x0552_6C56);
    n ^ n.wrapping_mul(0x53A2_2864)
}

/// The bits of x and y interleaved, x in the even places: the position of a pixel on the Z curve.
#[inline]
pub(super) fn morton_code([x, y]: [u32; 2]) -> u64 {
    spread(x) | spread(y) << 1
}

/// Moves bit k to bit 2k.
#[inline]
fn spread(x: u32) -> u64 {
    let mut x = u64::from(x);
    x = (x | x << 16) & 0x0000_FFFF_0000_FFFF;
    x = (x | x << 8) & 0x00FF_00FF_00FF_00FF;
    x = (x | x << 4) & 0x0F0F_0F0F_0F0F_0F0F;
    x = (x | x << 2) & 0x3333_3333_3333_3333;
    (x | x << 1) & 0x5555_5555_5555_5555
}

/// The number in [0, 1) whose leading binary digits are the upper 24 of `bits`.
///
/// All 24 fit the mantissa, so that nothing rounds up to one.
#[inline]
pub(crate) fn to_unit(bits: u32) -> f32 {
    (bits >> 8) as i32 as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scrambling_permutes_and_keeps_lower_bits_apart() {
        for seed in [0, 1, 0x9E37_79B9, u32::MAX] {
            for digits in [0, 0x55, 0x5555_5555] {
                let mut seen = [false; 256];
                for n in 0..256 {
                    // Bits above the eighth must not reach the lower eight.
                    let scrambled = owen_scramble_digits(n, seed, digits) & 0xFF;
                    assert_eq!(scrambled, owen_scramble_digits(n | 0xABCD_E100, seed, digits) & 0xFF);
                    seen[scrambled as usize] = true;
                }
                assert!(seen.iter().all(|&seen| seen), "seed {seed}");
            }
        }
    }

    #[test]
    fn base_4_digits_stay_together_and_take_every_order() {
        let mut orders = std::collections::BTreeSet::new();
        for seed in 0..4096_u32 {
            let seed = mix(u64::from(seed)) as u32;
            // The third digit, below the first two.
            for parent in 0..16 {
                let order: Vec<u32> = (0..4)
                    .map(|digit| owen_scramble_digits(digit << 4 | parent, seed, 0x5555_5555) >> 4 & 3)
                    .collect();
                orders.insert(order);
            }
        }
        assert_eq!(orders.len(), 24);
    }

    #[test]
    fn morton_interleaves() {
        assert_eq!(morton_code([0b101, 0b011]), 0b01_10_11);
        assert_eq!(morton_code([u32::MAX, 0]), 0x5555_5555_5555_5555);
        assert_eq!(morton_code([0, u32::MAX]), 0xAAAA_AAAA_AAAA_AAAA);
    }

    #[test]
    fn the_largest_number_is_below_one() {
        assert_eq!(to_unit(u32::MAX), 1.0 - f32::EPSILON / 2.0);
        assert_eq!(to_unit(0), 0.0);
        assert_eq!(to_unit(1 << 31), 0.5);
    }
}
