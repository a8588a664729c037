//! Textures of space: noise that a surface cuts through.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 3rd ed., 2016, sections 10.5 and 10.6, and pbrt-v4, whose values
//! these are.
//!
//! In a scene file: `Texture "stone" "spectrum" "marble" "float scale" 4 "float variation" .4`.

use std::f32::consts::TAU;

use sahl_math::{Transform, Vec3};
use sahl_scene::SolidNoise;

use super::TexturePoint;
use super::noise::{Octaves, noise_2d};
use crate::warp::sin_cos_turns;

/// A pattern of noise, and from where in the world to its space.
#[derive(Clone, Debug)]
pub(super) struct SolidNode {
    to_texture: Transform,
    pattern: Pattern,
}

#[derive(Clone, Copy, Debug)]
enum Pattern {
    Fbm(Octaves),
    Wrinkled(Octaves),
    Windy,
    Marble { octaves: Octaves, scale: f32, variation: f32 },
}

/// What a pattern gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum SolidValue {
    Number(f32),
    /// A reflectance in linear sRGB.
    Color([f32; 3]),
}

/// Where noise is evaluated, and how far the footprint of a pixel reaches there.
#[derive(Clone, Copy)]
struct Place {
    p: Vec3,
    dp_dx: Vec3,
    dp_dy: Vec3,
}

impl Place {
    fn scaled(&self, factor: f32) -> Self {
        Self { p: self.p * factor, dp_dx: self.dp_dx * factor, dp_dy: self.dp_dy * factor }
    }

    fn fbm(&self, octaves: &Octaves) -> f32 {
        octaves.fbm(self.p, self.dp_dx, self.dp_dy)
    }
}

fn octaves(noise: &SolidNoise) -> Octaves {
    Octaves { count: noise.octaves.min(SolidNoise::MOST_OCTAVES), roughness: noise.roughness }
}

impl SolidNode {
    pub(super) fn fbm(noise: &SolidNoise) -> Self {
        Self { to_texture: noise.world_to_texture, pattern: Pattern::Fbm(octaves(noise)) }
    }

    pub(super) fn wrinkled(noise: &SolidNoise) -> Self {
        Self { to_texture: noise.world_to_texture, pattern: Pattern::Wrinkled(octaves(noise)) }
    }

    pub(super) fn windy(world_to_texture: &Transform) -> Self {
        Self { to_texture: *world_to_texture, pattern: Pattern::Windy }
    }

    pub(super) fn marble(noise: &SolidNoise, scale: f32, variation: f32) -> Self {
        let pattern = Pattern::Marble { octaves: octaves(noise), scale, variation };
        Self { to_texture: noise.world_to_texture, pattern }
    }

    pub(super) fn value(&self, at: &TexturePoint) -> SolidValue {
        let place = Place {
            p: self.to_texture.point(at.p),
            dp_dx: self.to_texture.vector(at.footprint.dp_dx),
            dp_dy: self.to_texture.vector(at.footprint.dp_dy),
        };
        match &self.pattern {
            Pattern::Fbm(octaves) => SolidValue::Number(place.fbm(octaves)),
            Pattern::Wrinkled(octaves) => {
                SolidValue::Number(octaves.turbulence(place.p, place.dp_dx, place.dp_dy))
            }
            Pattern::Windy => {
                // Gusts, ten times as wide as the waves, say how high these are.
                let gust = place.scaled(0.1).fbm(&Octaves { count: 3, roughness: 0.5 });
                let wave = place.fbm(&Octaves { count: 6, roughness: 0.5 });
                SolidValue::Number(gust.abs() * wave)
            }
            Pattern::Marble { octaves, scale, variation } => {
                let place = place.scaled(*scale);
                let layer = place.p.y + variation * place.fbm(octaves);
                SolidValue::Color(marble(0.5 + 0.5 * sine(layer)))
            }
        }
    }
}

fn sine(radians: f32) -> f32 {
    let turns = radians / TAU;
    sin_cos_turns(turns - turns.round()).0
}

/// The colour of marble at `t` in [0, 1]: a spline of cubic pieces, which do not meet exactly, in pbrt's colours.
fn marble(t: f32) -> [f32; 3] {
    const PALE: [f32; 3] = [0.58, 0.58, 0.6];
    const COLORS: [[f32; 3]; 9] =
        [PALE, PALE, PALE, [0.5, 0.5, 0.5], [0.6, 0.59, 0.58], PALE, PALE, [0.2, 0.2, 0.33], PALE];
    const PIECES: usize = COLORS.len() - 3;
    const BRIGHTNESS: f32 = 1.5;
    let place = t * PIECES as f32;
    let first = (place.floor() as usize).min(PIECES - 1);
    let t = place - first as f32;
    let s = 1.0 - t;
    let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
    std::array::from_fn(|channel| {
        let bezier: f32 = (0..4).map(|i| weights[i] * COLORS[first + i][channel]).sum();
        BRIGHTNESS * bezier
    })
}

/// Whether (s, t) lies in a dot: a disk of radius 0.35 somewhere in its unit square, if noise gives the square one.
pub(super) fn is_in_dot(s: f32, t: f32) -> bool {
    const RADIUS: f32 = 0.35;
    const REACH: f32 = 0.5 - RADIUS;
    let (s_cell, t_cell) = ((s + 0.5).floor(), (t + 0.5).floor());
    if noise_2d(s_cell + 0.5, t_cell + 0.5) <= 0.0 {
        return false;
    }
    let ds = s - (s_cell + REACH * noise_2d(s_cell + 1.5, t_cell + 2.8));
    let dt = t - (t_cell + REACH * noise_2d(s_cell + 4.5, t_cell + 9.8));
    ds * ds + dt * dt < RADIUS * RADIUS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marble_stays_a_reflectance() {
        for i in 0..=1000 {
            let color = marble(i as f32 / 1000.0);
            assert!(color.iter().all(|x| (0.0..=1.0).contains(x)), "{color:?}");
        }
        // The first control point of the first piece, and the last of the last.
        assert_eq!(marble(0.0), [0.58, 0.58, 0.6].map(|x| 1.5 * x));
        assert_eq!(marble(1.0), [0.58, 0.58, 0.6].map(|x| 1.5 * x));
    }

    #[test]
    fn sines_of_large_angles_are_sines() {
        for x in [0.0, 1.0, -2.5, 100.0, 1e4] {
            assert!((sine(x) - x.sin()).abs() < 1e-3, "{x}");
        }
        assert!(sine(1e30).is_finite());
    }

    #[test]
    fn dots_cover_their_share() {
        let n = 600;
        let covered = (0..n * n)
            .filter(|i| is_in_dot((i % n) as f32 * 0.11 - 20.0, (i / n) as f32 * 0.11 - 20.0))
            .count();
        let share = covered as f32 / (n * n) as f32;
        // A disk of radius 0.35 in half of the squares.
        assert!((share - 0.5 * 0.385).abs() < 0.05, "{share}");
    }

    #[test]
    fn the_space_is_that_of_the_transform() {
        let noise = SolidNoise {
            world_to_texture: Transform::scale(4.0, 4.0, 4.0).unwrap(),
            octaves: 3,
            roughness: 0.6,
        };
        let at = |p| SolidNode::fbm(&noise).value(&TexturePoint { p, ..Default::default() });
        let octaves = Octaves { count: 3, roughness: 0.6 };
        let expected = octaves.fbm(Vec3::new(0.8, 2.0, -1.2), Vec3::ZERO, Vec3::ZERO);
        let SolidValue::Number(found) = at(Vec3::new(0.2, 0.5, -0.3)) else { panic!("a colour") };
        assert!((found - expected).abs() < 1e-5);
    }
}
