//! Phase functions: where light goes that a medium scatters.

use std::f32::consts::{PI, TAU};

use sahl_math::{Frame, Vec2, Vec3, safe_sqrt};

/// The phase function of Henyey and Greenstein, for directions that both point away from the point:
///
/// p(wo, wi) = (1 − g²) / (4π (1 + g² + 2 g cos θ)^{3/2}), cos θ = wo · wi, per steradian.
///
/// g is the mean of −cos θ: forward scattering, where wi is opposite to wo, is found at positive g. The integral over the
/// sphere is one, and samples follow the function exactly, so that their weight is one.
///
/// Source: Henyey and Greenstein, *Diffuse Radiation in the Galaxy*, 1941.
///
/// In a scene file: `MakeNamedMedium "fog" "string type" "homogeneous" "float g" .8`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HenyeyGreenstein {
    g: f32,
}

/// A direction drawn by [`HenyeyGreenstein::sample`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseSample {
    /// The direction from which light comes.
    pub wi: Vec3,
    /// Its density per steradian, which is the phase function.
    pub pdf: f32,
}

impl HenyeyGreenstein {
    /// The phase function with mean cosine `g`, above −1 and below 1.
    pub fn new(g: f32) -> Self {
        Self { g }
    }

    /// The phase function per steradian, which is the density of [`HenyeyGreenstein::sample`] as well.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.at(wo.dot(wi))
    }

    #[inline]
    fn at(&self, cos: f32) -> f32 {
        let g = self.g;
        // Rounding must not make it negative where |g| is nearly one.
        let base = (1.0 + g * g + 2.0 * g * cos).max((1.0 - g.abs()) * (1.0 - g.abs()));
        (1.0 - g * g) / (4.0 * PI * base * base.sqrt())
    }

    /// Draws `wi` given `wo` by `u`, uniform in [0, 1)².
    ///
    /// The cosine is the inverse of the cumulative distribution, with the factor g cancelled: the usual form divides zero
    /// by zero for isotropic scattering.
    #[inline]
    pub fn sample(&self, wo: Vec3, u: Vec2) -> PhaseSample {
        let (g, x) = (self.g, 1.0 - 2.0 * u.x);
        let denominator = 1.0 + g * x;
        let numerator = 2.0 * x * (1.0 + g * g) + g * (x * x + 3.0) + g * g * g * (x * x - 1.0);
        let forward = (numerator / (2.0 * denominator * denominator)).clamp(-1.0, 1.0);
        let sin = safe_sqrt(1.0 - forward * forward);
        let (sin_phi, cos_phi) = (TAU * u.y).sin_cos();
        let local = Vec3::new(sin * cos_phi, sin * sin_phi, forward);
        let wi = Frame::from_z(-wo).to_world(local);
        PhaseSample { wi, pdf: self.at(-forward) }
    }
}
