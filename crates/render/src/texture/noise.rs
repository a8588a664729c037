//! Gradient noise and sums of it.
//!
//! Source: Perlin, *Improving Noise*, SIGGRAPH 2002; Pharr, Jakob, Humphreys, *Physically Based Rendering*, 3rd ed., 2016,
//! section 10.6. The values are those of pbrt-v4, to the last bits: scenes that were made there look the same.

use sahl_math::{Vec3, lerp};

/// Perlin's order of the numbers 0 to 255.
static PERMUTATION: &[u8; 256] = include_bytes!("../../../../data/noise/permutation.bin");

/// The frequency of an octave over that of the one before: not quite two, so that zeros of the octaves do not coincide.
const LACUNARITY: f32 = 1.99;

/// Noise with gradients at the points of the unit lattice: zero there, within about ±1 between, and 256 in period.
pub(crate) fn noise(p: Vec3) -> f32 {
    // Far away floats have no fractions; the remainder keeps the cell's number in an i32.
    let p = p.map(|x| x % (1 << 30) as f32);
    let cell = p.map(f32::floor);
    let d = p - cell;
    let [ix, iy, iz] = [cell.x, cell.y, cell.z].map(|x| x as i32);
    let corner = |x: i32, y: i32, z: i32| {
        let offset = Vec3::new(x as f32, y as f32, z as f32);
        gradient([ix + x, iy + y, iz + z], d - offset)
    };
    let weight = d.map(|t| {
        let cube = t * t * t;
        6.0 * cube * t * t - 15.0 * cube * t + 10.0 * cube
    });
    let along_x = |y, z| lerp(weight.x, corner(0, y, z), corner(1, y, z));
    let along_y = |z| lerp(weight.y, along_x(0, z), along_x(1, z));
    lerp(weight.z, along_y(0), along_y(1))
}

/// Noise in the plane z = ½.
pub(super) fn noise_2d(x: f32, y: f32) -> f32 {
    noise(Vec3::new(x, y, 0.5))
}

/// The product of `d` with one of the twelve directions to the edges of a cube, which the lattice point chooses.
fn gradient(lattice: [i32; 3], d: Vec3) -> f32 {
    let mut hash = 0_u8;
    for coordinate in lattice {
        // The lowest eight bits of the sum, whatever the sign.
        hash = PERMUTATION[usize::from(hash.wrapping_add(coordinate as u8))];
    }
    let hash = hash & 15;
    let u = if hash < 8 || hash == 12 || hash == 13 { d.x } else { d.y };
    let v = if hash < 4 || hash == 12 || hash == 13 { d.y } else { d.z };
    (if hash & 1 != 0 { -u } else { u }) + (if hash & 2 != 0 { -v } else { v })
}

/// Octaves of noise: how many, and the factor from the weight of one to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Octaves {
    pub(super) count: u32,
    pub(super) roughness: f32,
}

impl Octaves {
    /// How many octaves are no finer than the footprint, and the weight of the next one, which fades in.
    fn visible(&self, dp_dx: Vec3, dp_dy: Vec3) -> (u32, f32) {
        let squared = dp_dx.length_squared().max(dp_dy.length_squared());
        let count = (-1.0 - 0.5 * squared.log2()).clamp(0.0, self.count as f32);
        let whole = count.floor();
        (whole as u32, smooth_step(count - whole, 0.3, 0.7))
    }

    /// Fractional Brownian motion: Σ ωⁱ noise(1.99ⁱ p), without what is finer than the footprint.
    pub(super) fn fbm(&self, p: Vec3, dp_dx: Vec3, dp_dy: Vec3) -> f32 {
        let (whole, partial) = self.visible(dp_dx, dp_dy);
        let (mut sum, mut frequency, mut weight) = (0.0, 1.0, 1.0);
        for _ in 0..whole {
            sum += weight * noise(p * frequency);
            frequency *= LACUNARITY;
            weight *= self.roughness;
        }
        if partial > 0.0 {
            sum += weight * partial * noise(p * frequency);
        }
        sum
    }

    /// Turbulence: Σ ωⁱ |noise(1.99ⁱ p)|. Octaves finer than the footprint count with the mean of |noise|, 0.2.
    pub(super) fn turbulence(&self, p: Vec3, dp_dx: Vec3, dp_dy: Vec3) -> f32 {
        const MEAN: f32 = 0.2;
        let (whole, partial) = self.visible(dp_dx, dp_dy);
        let (mut sum, mut frequency, mut weight) = (0.0, 1.0, 1.0);
        for _ in 0..whole {
            sum += weight * noise(p * frequency).abs();
            frequency *= LACUNARITY;
            weight *= self.roughness;
        }
        // pbrt counts the mean of the octave that fades in twice; scenes are tuned to that.
        sum += weight * lerp(partial, MEAN, noise(p * frequency).abs());
        for _ in whole..self.count {
            sum += weight * MEAN;
            weight *= self.roughness;
        }
        sum
    }
}

/// Zero below `low`, one above `high`, with a cubic between.
fn smooth_step(x: f32, low: f32, high: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_permutation_is_perlins() {
        let mut sorted = *PERMUTATION;
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, &value)| i == usize::from(value)));
        let checksum = PERMUTATION.iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, &byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        assert_eq!(checksum, CHECKSUM);
    }

    #[test]
    fn noise_is_zero_on_the_lattice_and_smooth_between() {
        let mut largest = 0.0_f32;
        let mut sum = 0.0_f64;
        let mut sum_of_magnitudes = 0.0_f64;
        let n = 40;
        for i in 0..n * n * n {
            let step = 0.237;
            let p =
                Vec3::new((i % n) as f32, (i / n % n) as f32, (i / n / n) as f32) * step - Vec3::splat(4.1);
            let value = noise(p);
            largest = largest.max(value.abs());
            sum += f64::from(value);
            sum_of_magnitudes += f64::from(value.abs());
            let moved = noise(p + Vec3::splat(1e-3));
            assert!((moved - value).abs() < 6e-3, "{p:?}");
            assert!((noise(p + Vec3::splat(256.0)) - value).abs() < 1e-3);
            assert_eq!(noise(p.map(f32::floor)), 0.0);
        }
        let count = f64::from(n * n * n);
        assert!(largest > 0.7 && largest <= 1.04, "{largest}");
        assert!((sum / count).abs() < 0.01);
        // What turbulence takes for the mean of |noise|.
        assert!((sum_of_magnitudes / count - 0.2).abs() < 0.06, "{}", sum_of_magnitudes / count);
        assert!(noise(Vec3::splat(3e38)).is_finite());
    }

    #[test]
    fn gradients_are_those_of_the_reference() {
        // At (½, 0, 0) only the two ends of an edge have a say; the lattice point (x, 0, 0) hashes to p[p[p[x]]].
        let hash = |x: u8| (0..3).fold(x, |hash, _| PERMUTATION[usize::from(hash)]) & 15;
        let along_x = |h: u8, d: f32| match h {
            0..8 | 12 | 13 if h & 1 != 0 => -d,
            0..8 | 12 | 13 => d,
            _ => 0.0,
        };
        let expected = 0.5 * along_x(hash(0), 0.5) + 0.5 * along_x(hash(1), -0.5);
        assert_eq!(noise(Vec3::new(0.5, 0.0, 0.0)), expected);
    }

    #[test]
    fn octaves_finer_than_the_footprint_are_left_out() {
        let octaves = Octaves { count: 8, roughness: 0.5 };
        let at = |size: f32| octaves.visible(Vec3::X * size, Vec3::Y * (0.3 * size));
        assert_eq!(at(0.0), (8, 0.0));
        assert_eq!(at(1.0), (0, 0.0));
        assert_eq!(at(0.125), (2, 0.0));
        assert_eq!(at(2.0_f32.powf(-3.9)), (2, 1.0));
        assert_eq!(at(1e30), (0, 0.0));
        let (p, wide) = (Vec3::new(0.3, 1.7, -2.2), Vec3::X * 10.0);
        assert_eq!(octaves.fbm(p, wide, wide), 0.0);
        let all = Octaves { count: 3, roughness: 0.5 };
        let expected = noise(p) + 0.5 * noise(p * 1.99) + 0.25 * noise(p * (1.99 * 1.99));
        assert!((all.fbm(p, Vec3::ZERO, Vec3::ZERO) - expected).abs() < 1e-6);
        // One, a half and a quarter of the mean, and the first of them twice.
        assert!((all.turbulence(p, wide, wide) - 0.2 * 2.75).abs() < 1e-6);
    }

    const CHECKSUM: u64 = 0xa4d5_c624_dc06_c7d5;
}
