//! The rays of the workloads: the same for everybody, made beforehand.

use std::f32::consts::TAU;

use sahl_accel::Accel;
use sahl_math::{Frame, Ray, Vec3};

use super::models::{Light, Model, View};

/// The rays of one model.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rays {
    /// Through the centres of the pixels, in the order of [`morton`].
    pub(crate) primary: Vec<Ray>,
    /// From each camera ray's hit, in the order of the hits.
    pub(crate) bounce: Vec<Ray>,
    /// From each camera ray's hit whose light sample lies in front of it, to that sample.
    pub(crate) occlusion: Vec<Ray>,
}

impl Rays {
    /// The rays of an image of `size × size` pixels; a power of two.
    pub(crate) fn new(model: &Model, accel: &Accel, size: u32) -> Self {
        let mut rays = Self { primary: camera(model.view, size), ..Self::default() };
        let mut random = Random::new(1);
        for ray in &rays.primary {
            let Some(hit) = accel.intersect(ray) else { continue };
            let point = accel.surface_point(ray, &hit);
            let n = point.n.face_forward(-ray.direction);
            let direction = Frame::from_z(n).to_world(cosine_hemisphere(&mut random));
            rays.bounce.push(Ray::spawn(point.p, point.p_error, point.n, direction));
            let sample = model.light.sample(&mut random);
            if (sample - point.p).dot(n) > 0.0 {
                let from = (point.p, point.p_error, point.n);
                rays.occlusion.push(Ray::spawn_to(from, (sample, Vec3::ZERO, Vec3::ZERO)));
            }
        }
        rays
    }
}

impl Light {
    /// A point, uniform over the area.
    fn sample(&self, random: &mut Random) -> Vec3 {
        self.corner + self.edges[0] * random.unit() + self.edges[1] * random.unit()
    }
}

fn camera(view: View, size: u32) -> Vec<Ray> {
    let forward = (view.target - view.eye).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let extent = (0.5 * view.field.to_radians()).tan();
    let at = |i: u32| extent * ((2 * i + 1) as f32 / size as f32 - 1.0);
    (0..size * size)
        .map(|index| {
            let [x, y] = morton(index);
            Ray::new(view.eye, (forward + right * at(x) - up * at(y)).normalize())
        })
        .collect()
}

/// The pixel of a place along the Z-order curve: 16 places that follow a multiple of 16 are a tile of 4 × 4, 64 one of 8 × 8.
///
/// Source: Morton, *A Computer Oriented Geodetic Data Base*, 1966.
pub(crate) fn morton(index: u32) -> [u32; 2] {
    [0, 1].map(|axis| (0..16).map(|bit| (index >> (2 * bit + axis) & 1) << bit).sum())
}

/// A direction about +z, its density proportional to the cosine.
fn cosine_hemisphere(random: &mut Random) -> Vec3 {
    let (r, phi) = (random.unit().sqrt(), TAU * random.unit());
    Vec3::new(r * phi.cos(), r * phi.sin(), (1.0 - r * r).max(0.0).sqrt())
}

/// A generator with a fixed seed.
///
/// Source: O'Neill, *PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms*, 2014: PCG-XSH-RR 64/32.
#[derive(Clone, Debug)]
pub(crate) struct Random {
    state: u64,
    increment: u64,
}

impl Random {
    /// The generator of one of 2⁶³ sequences.
    pub(crate) fn new(sequence: u64) -> Self {
        let mut random = Self { state: 0, increment: sequence << 1 | 1 };
        random.bits();
        random.state = random.state.wrapping_add(0x853c_49e6_748f_ea9b);
        random.bits();
        random
    }

    pub(crate) fn bits(&mut self) -> u32 {
        let old = self.state;
        self.state = old.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(self.increment);
        let shifted = (((old >> 18) ^ old) >> 27) as u32;
        shifted.rotate_right((old >> 59) as u32)
    }

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / (1_u32 << 24) as f32
    }

    /// Less than `limit`, which must be positive.
    pub(crate) fn below(&mut self, limit: usize) -> usize {
        ((u64::from(self.bits()) * limit as u64) >> 32) as usize
    }

    /// Uniform on the unit sphere.
    pub(crate) fn direction(&mut self) -> Vec3 {
        let z = 1.0 - 2.0 * self.unit();
        let (r, phi) = ((1.0 - z * z).max(0.0).sqrt(), TAU * self.unit());
        Vec3::new(r * phi.cos(), r * phi.sin(), z)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn sixteen_in_a_row_are_a_tile() {
        for side in [4, 8] {
            for tile in 0..16 {
                let pixels: HashSet<[u32; 2]> =
                    (0..side * side).map(|i| morton(tile * side * side + i)).collect();
                assert_eq!(pixels.len() as u32, side * side);
                let tiles: HashSet<[u32; 2]> = pixels.iter().map(|p| p.map(|x| x / side)).collect();
                assert_eq!(tiles.len(), 1, "tile {tile} of side {side}");
            }
        }
    }

    #[test]
    fn the_curve_visits_each_pixel_once() {
        let pixels: HashSet<[u32; 2]> = (0..64 * 64).map(morton).collect();
        assert_eq!(pixels.len(), 64 * 64);
        assert!(pixels.iter().flatten().all(|&x| x < 64));
    }

    #[test]
    fn the_camera_looks_at_its_target() {
        let view = View { eye: Vec3::new(3.0, 1.0, 2.0), target: Vec3::ZERO, field: 90.0 };
        let rays = camera(view, 64);
        let forward = (view.target - view.eye).normalize();
        let mean = rays.iter().fold(Vec3::ZERO, |sum, ray| sum + ray.direction).normalize();
        assert!((mean - forward).length() < 1e-4);
        // The outermost pixels' centres lie half a pixel within the field.
        let corner = Vec3::new(1.0, 1.0, 0.0) * (63.0 / 64.0) + Vec3::Z;
        let expected = corner.normalize().z;
        let least = rays.iter().map(|ray| ray.direction.dot(forward)).fold(1.0, f32::min);
        assert!((least - expected).abs() < 1e-5, "{least} {expected}");
    }

    #[test]
    fn cosine_directions_have_the_right_mean() {
        let mut random = Random::new(3);
        let sum: f32 = (0..100_000).map(|_| cosine_hemisphere(&mut random).z).sum();
        assert!((sum / 1e5 - 2.0 / 3.0).abs() < 3e-3, "{sum}");
    }
}
