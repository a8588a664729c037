//! A point whose intensity by direction is an image: a measured lamp.
//!
//! In a scene file: `LightSource "goniometric" "string filename" "lamp.exr" "rgb I" [ 2 2 2.4 ]`.

use std::f32::consts::PI;

use sahl_image::Image;
use sahl_math::{Transform, Vec2, Vec3};

use super::environment::{orthonormal_axes, to_axes};
use super::kinds::toward_point;
use super::{Emission, LightBounds, LightSample, SphereMap};
use crate::spectrum::{Spectrum, Wavelengths};

/// A point that shines by a table of factors over directions, constant within a pixel, as pbrt-v4's.
#[derive(Clone, Debug)]
pub(crate) struct GoniometricLight {
    position: Vec3,
    /// Axes of the table's space in the world, orthonormal.
    axes: [Vec3; 3],
    /// Radiant intensity in W/sr where the factor is one.
    pub(crate) intensity: Emission,
    /// Factors on an equal-area square of `side` pixels.
    factors: Vec<f32>,
    side: usize,
    mean_factor: f32,
}

impl GoniometricLight {
    /// The light whose factors are the means of the colours of a square equal-area image; `None` if the image has no
    /// pixels or is not square. Values that are negative or not finite count as zero.
    pub(crate) fn new(image: &Image, intensity: Emission, light_to_world: &Transform) -> Option<Self> {
        let side = image.width;
        if side == 0 || image.height != side {
            return None;
        }
        let factor = |i: usize| {
            let [r, g, b, _] = image.pixel(i % side, i / side);
            let mean = (r + g + b) / 3.0;
            if mean.is_finite() { mean.max(0.0) } else { 0.0 }
        };
        let factors: Vec<f32> = (0..side * side).map(factor).collect();
        let sum: f64 = factors.iter().map(|&factor| f64::from(factor)).sum();
        Some(Self {
            position: light_to_world.point(Vec3::ZERO),
            axes: orthonormal_axes(light_to_world),
            intensity,
            mean_factor: (sum / factors.len() as f64) as f32,
            factors,
            side,
        })
    }

    /// The solid angle that would take the flux at the intensity of factor one: that of the sphere by the mean factor.
    pub(crate) fn effective_solid_angle(&self) -> f32 {
        4.0 * PI * self.mean_factor
    }

    #[inline]
    pub(super) fn sample(&self, from: Vec3, wavelengths: &Wavelengths) -> Option<LightSample> {
        let sample = toward_point(self.position, self.intensity.at(wavelengths), from)?;
        let factor = self.factor(-sample.wi);
        (factor > 0.0).then(|| LightSample { radiance: sample.radiance * factor, ..sample })
    }

    /// The factor for light that goes along the unit vector `w`.
    fn factor(&self, w: Vec3) -> f32 {
        let Vec2 { x, y } = SphereMap::EqualArea.uv(to_axes(&self.axes, w));
        let place = |t: f32| ((t * self.side as f32) as usize).min(self.side - 1);
        self.factors[place(y) * self.side + place(x)]
    }

    pub(super) fn power(&self, wavelengths: &Wavelengths) -> Spectrum {
        self.intensity.at(wavelengths) * self.effective_solid_angle()
    }

    /// Those of a point that shines alike in all directions, as in pbrt-v4.
    pub(super) fn bounds(&self) -> LightBounds {
        LightBounds::point(self.position, self.intensity.mean() * self.mean_factor)
    }
}
