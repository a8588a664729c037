//! Lights at a point, and parallel light.

use std::f32::consts::PI;

use sahl_math::{Bounds3, Vec3, safe_acos};

use super::{Cone, LightBounds, LightSample};
use crate::spectrum::{SpectralCurve, Spectrum, Wavelengths};

/// A quantity of emission: a curve with its magnitude.
#[derive(Clone, Debug)]
pub(crate) struct Emission {
    pub(crate) curve: SpectralCurve,
    pub(crate) scale: f32,
}

impl Emission {
    /// The value in each lane.
    #[inline]
    pub(crate) fn at(&self, wavelengths: &Wavelengths) -> Spectrum {
        self.curve.at(wavelengths) * self.scale
    }

    /// Its size, for comparison with other emission: the mean of the lanes in RGB.
    pub(crate) fn mean(&self) -> f32 {
        self.at(&Wavelengths::Rgb).average()
    }

    /// Whether there is no light at any wavelength.
    pub(crate) fn is_black(&self) -> bool {
        // Light of any wavelength has a colour.
        self.at(&Wavelengths::Rgb).is_zero()
    }
}

/// A point that shines alike in all directions.
#[derive(Clone, Debug)]
pub(crate) struct PointLight {
    pub(crate) position: Vec3,
    /// Radiant intensity in W/sr.
    pub(crate) intensity: Emission,
}

impl PointLight {
    #[inline]
    pub(super) fn sample(&self, from: Vec3, wavelengths: &Wavelengths) -> Option<LightSample> {
        toward_point(self.position, self.intensity.at(wavelengths), from)
    }

    pub(super) fn power(&self, wavelengths: &Wavelengths) -> Spectrum {
        self.intensity.at(wavelengths) * (4.0 * PI)
    }
}

/// A point that shines into a cone with a soft border: full intensity up to the inner angle, none from the outer one
/// on, and a cubic step in the cosine between them (pbrt-v4's).
#[derive(Clone, Debug)]
pub(crate) struct SpotLight {
    pub(crate) position: Vec3,
    /// Unit axis.
    pub(crate) direction: Vec3,
    /// Radiant intensity along the axis in W/sr.
    pub(crate) intensity: Emission,
    /// Cosine of the angle at which the border begins.
    pub(crate) cos_inner: f32,
    /// Cosine of the angle at which it ends.
    pub(crate) cos_outer: f32,
}

impl SpotLight {
    #[inline]
    pub(super) fn sample(&self, from: Vec3, wavelengths: &Wavelengths) -> Option<LightSample> {
        let sample = toward_point(self.position, self.intensity.at(wavelengths), from)?;
        let falloff = self.falloff(-sample.wi.dot(self.direction));
        (falloff > 0.0).then(|| LightSample { radiance: sample.radiance * falloff, ..sample })
    }

    fn falloff(&self, cos: f32) -> f32 {
        if cos >= self.cos_inner {
            return 1.0;
        }
        let t = ((cos - self.cos_outer) / (self.cos_inner - self.cos_outer)).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }

    /// The solid angle that would take the flux at full intensity: the cubic step averages to a half.
    pub(crate) fn effective_solid_angle(&self) -> f32 {
        2.0 * PI * ((1.0 - self.cos_inner) + 0.5 * (self.cos_inner - self.cos_outer))
    }

    pub(super) fn power(&self, wavelengths: &Wavelengths) -> Spectrum {
        self.intensity.at(wavelengths) * self.effective_solid_angle()
    }

    /// The inner cone is what the light faces, and its border what it reaches beyond.
    pub(super) fn bounds(&self) -> LightBounds {
        LightBounds {
            bounds: Bounds3::from_points([self.position]),
            facing: Cone { axis: self.direction, cos: self.cos_inner },
            cos_reach: (safe_acos(self.cos_outer) - safe_acos(self.cos_inner)).cos(),
            two_sided: false,
            intensity: self.intensity.mean(),
        }
    }
}

/// Parallel light.
#[derive(Clone, Debug)]
pub(crate) struct DistantLight {
    /// Unit direction in which the light goes.
    pub(crate) direction: Vec3,
    /// On a surface that faces the light, in W/m².
    pub(crate) irradiance: Emission,
}

impl DistantLight {
    #[inline]
    pub(super) fn sample(&self, wavelengths: &Wavelengths) -> LightSample {
        LightSample {
            radiance: self.irradiance.at(wavelengths),
            wi: -self.direction,
            pdf: 1.0,
            is_delta: true,
            end: None,
        }
    }
}

#[inline]
pub(super) fn toward_point(position: Vec3, intensity: Spectrum, from: Vec3) -> Option<LightSample> {
    let to_light = position - from;
    let wi = to_light.try_normalize()?;
    Some(LightSample {
        radiance: intensity / to_light.length_squared(),
        wi,
        pdf: 1.0,
        is_delta: true,
        end: Some((position, Vec3::ZERO, Vec3::ZERO)),
    })
}
