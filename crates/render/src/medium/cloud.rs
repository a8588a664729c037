//! A cloud: a density made of noise.
//!
//! In a scene file: `MakeNamedMedium "cloud" "string type" "cloud" "float wispiness" 2`.

use std::iter;

use sahl_math::Vec3;
use sahl_scene::{CloudMedium, Diagnostics, Span};

use super::coefficients::Coefficients;
use super::grid::{Frame, clip_to_cube};
use super::walk::{self, Collision, Next, Stretch};
use super::{HenyeyGreenstein, Properties, Way};
use crate::sampler::Stream;
use crate::spectrum::Spectrum;
use crate::texture::noise::noise;

/// The frequency of an octave over that of the one before.
const LACUNARITY: f32 = 1.99;

/// A cloud that is dense at the bottom, y = 0, and thins out to the top, y = 1. The density is at most one.
///
/// Source: the density is that of pbrt-v4's `cloud`, by its file format; the noise Perlin's.
#[derive(Clone, Debug)]
pub(crate) struct Cloud {
    coefficients: Coefficients,
    frame: Frame,
    density: f32,
    wispiness: f32,
    frequency: f32,
    pub(super) phase: HenyeyGreenstein,
}

impl Cloud {
    /// The medium of a scene; `span` is what messages point at.
    pub(crate) fn new(description: &CloudMedium, span: Option<Span>, diagnostics: &mut Diagnostics) -> Self {
        let CloudMedium { coefficients, region, density, wispiness, frequency } = description;
        let coefficients = Coefficients::new(coefficients, span, diagnostics);
        let phase = coefficients.phase;
        let frame = Frame::new(region);
        Self { coefficients, frame, density: *density, wispiness: *wispiness, frequency: *frequency, phase }
    }

    pub(super) fn walk(
        &self,
        way: &Way,
        u: f32,
        stream: &mut Stream,
        visit: impl FnMut(&Collision) -> Next,
    ) -> Spectrum {
        let (sigma_a, sigma_s) = self.coefficients.at(&way.wavelengths);
        let inside = clip_to_cube(&self.frame.ray_to_cube(&way.ray), way.length);
        let majorant = sigma_a + sigma_s;
        let stretches = inside.map(|[from, to]| Stretch { from, to, majorant });
        let properties = |p| {
            let density = self.density(self.frame.to_medium(p));
            Properties { sigma_a: sigma_a * density, sigma_s: sigma_s * density, emission: Spectrum::ZERO }
        };
        walk::walk(way, u, stream, stretches.into_iter(), properties, visit)
    }

    /// The density at a point of the medium's own space, at most one.
    fn density(&self, p: Vec3) -> f32 {
        let mut place = p * self.frequency;
        if self.wispiness > 0.0 {
            // Wisps: the noise is looked up where other noise leads.
            let (mut weight, mut frequency) = (0.05 * self.wispiness, 10.0);
            for _ in 0..2 {
                place += noise_gradient(place * frequency) * weight;
                weight *= 0.5;
                frequency *= LACUNARITY;
            }
        }
        let octaves = iter::successors(Some((0.5, 1.0)), |(weight, frequency)| {
            Some((0.5 * weight, LACUNARITY * frequency))
        });
        let sum: f32 = octaves.take(5).map(|(weight, frequency)| weight * noise(place * frequency)).sum();
        let thinning = ((1.0 - p.y) * 4.5 * self.density * sum).clamp(0.0, 1.0);
        (thinning + 2.0 * (0.5 - p.y).max(0.0)).clamp(0.0, 1.0)
    }
}

/// The gradient of noise by differences over a hundredth, which pbrt-v4 uses: the shape of the wisps depends on it.
fn noise_gradient(p: Vec3) -> Vec3 {
    const DELTA: f32 = 0.01;
    let here = noise(p);
    let along = |axis: Vec3| (noise(p + axis * DELTA) - here) / DELTA;
    Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z))
}
