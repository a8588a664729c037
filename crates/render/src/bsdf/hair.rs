//! Fibres: hair and fur.
//!
//! Design decision: light leaves a fibre after p = 0, 1, 2 passes through it, or more; each of these four ways has a
//! longitudinal, an azimuthal and an attenuation factor, of which the first two integrate to one. A fibre that absorbs
//! nothing therefore scatters all light, and sampling in proportion to the product has weights near one.
//!
//! Deliberately absent: reciprocity, which the model gives up for energy: scales tilt the cone of one direction only.

use std::f32::consts::{FRAC_1_PI, LN_2, PI, TAU};

use sahl_math::{Vec2, Vec3, safe_asin, safe_sqrt};

use super::{BsdfSample, Reach, Scatter, ScatterKind, fresnel};
use crate::spectrum::Spectrum;
use crate::warp;

/// Ways with a factor of their own; the last one of [`LOBES`] is for all longer ones.
const PASSES: usize = 3;
const LOBES: usize = PASSES + 1;

/// Light scattered by a dielectric fibre with rough, tilted scales.
///
/// f |cos θi| = Σp Mp(θo, θi) Ap(ωo) Np(φ), in the frame whose x is the axis of the fibre: θ is the angle to the plane
/// perpendicular to it, φ the azimuth in that plane.
///
/// Source: Chiang, Bitterli, Tappan, Burley, *A Practical and Controllable Hair and Fur Model for Production Path
/// Tracing*, CGF 35(2), 2016; d'Eon et al., *An Energy-Conserving Hair Reflectance Model*, EGSR 2011, for Mp; with the
/// choices of pbrt-v4.
///
/// In a scene file: `Material "hair" "float eumelanin" .3 "float beta_m" .25`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hair {
    /// Offset of the ray from the axis, over the radius: from −1 to 1.
    h: f32,
    eta: f32,
    sigma_a: Spectrum,
    /// Longitudinal variance of each way.
    v: [f32; LOBES],
    /// Scale of the azimuthal logistic distribution.
    s: f32,
    /// Sine and cosine of the tilt of scales, doubled 0, 1 and 2 times.
    tilt: [[f32; 2]; 3],
}

/// The appearance of a fibre, before what depends on the place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HairShape {
    /// Index of refraction.
    pub eta: f32,
    /// Longitudinal roughness, in [0, 1].
    pub beta_m: f32,
    /// Azimuthal roughness, in [0, 1].
    pub beta_n: f32,
    /// Tilt of the scales, in radians.
    pub alpha: f32,
}

/// What does not depend on `wi`.
struct Outgoing {
    sin: f32,
    cos: f32,
    phi: f32,
    gamma_o: f32,
    gamma_t: f32,
    attenuation: [Spectrum; LOBES],
}

impl Hair {
    /// A fibre that is hit at the offset `h` from its axis, over its radius; `sigma_a` is the absorption per radius.
    pub fn new(h: f32, shape: &HairShape, sigma_a: Spectrum) -> Self {
        let limited = |x: f32, low: f32, high: f32| if x.is_nan() { low } else { x.clamp(low, high) };
        // A variance of zero would be a delta function.
        let (m, n) = (limited(shape.beta_m, 1e-2, 1.0), limited(shape.beta_n, 1e-2, 1.0));
        let root = 0.726 * m + 0.812 * m * m + 3.7 * m.powi(20);
        let v = root * root;
        let (mut sin, mut cos) = shape.alpha.sin_cos();
        let tilt = std::array::from_fn(|_| {
            let this = [sin, cos];
            (sin, cos) = (2.0 * sin * cos, cos * cos - sin * sin);
            this
        });
        Self {
            h: limited(h, -1.0, 1.0),
            eta: if shape.eta > 0.0 && shape.eta.is_finite() { shape.eta } else { 1.0 },
            sigma_a: sigma_a.clamp(0.0, f32::MAX),
            v: [v, 0.25 * v, 4.0 * v, 4.0 * v],
            s: (PI / 8.0).sqrt() * (0.265 * n + 1.194 * n * n + 5.372 * n.powi(22)),
            tilt,
        }
    }

    fn outgoing(&self, wo: Vec3) -> Outgoing {
        let (sin, cos) = (wo.x, safe_sqrt(1.0 - wo.x * wo.x));
        let cos_t = safe_sqrt(1.0 - (sin / self.eta) * (sin / self.eta));
        // Bravais: the index that the projection perpendicular to the axis sees.
        let eta = safe_sqrt(self.eta * self.eta - sin * sin) / cos;
        let sin_gamma_t = (self.h / eta).clamp(-1.0, 1.0);
        let cos_gamma_t = safe_sqrt(1.0 - sin_gamma_t * sin_gamma_t);
        // Grazing the axis, the way through is endless where anything absorbs, and any length where nothing does.
        let length = if cos_t > 0.0 { 2.0 * cos_gamma_t / cos_t } else { f32::MAX };
        let transmitted = (self.sigma_a * -length).map(|x| if x.is_nan() { 0.0 } else { x }).exp();
        Outgoing {
            sin,
            cos,
            phi: wo.z.atan2(wo.y),
            gamma_o: safe_asin(self.h),
            gamma_t: safe_asin(sin_gamma_t),
            attenuation: self.attenuation(cos, transmitted),
        }
    }

    /// Ap: the share of light that takes each way.
    fn attenuation(&self, cos_theta_o: f32, transmitted: Spectrum) -> [Spectrum; LOBES] {
        let cos = cos_theta_o * safe_sqrt(1.0 - self.h * self.h);
        let f = fresnel::dielectric(cos, self.eta).reflectance;
        let once = (1.0 - f) * (1.0 - f) * transmitted;
        let twice = once * transmitted * f;
        // The geometric series of all longer ways; its sum has no value where nothing gets in or lost, and none is needed.
        let rest =
            twice.zip(transmitted, |twice, t| if t * f < 1.0 { twice * t * f / (1.0 - t * f) } else { 0.0 });
        [Spectrum::splat(f), once, twice, rest]
    }

    /// The probabilities with which ways are sampled.
    fn pmf(outgoing: &Outgoing) -> [f32; LOBES] {
        let means = outgoing.attenuation.map(Spectrum::average);
        let sum: f32 = means.iter().sum();
        if sum > 0.0 { means.map(|mean| mean / sum) } else { [1.0, 0.0, 0.0, 0.0] }
    }

    /// Sine and cosine of the outgoing angle as the scales tilt it for way `p`.
    fn tilted(&self, outgoing: &Outgoing, p: usize) -> [f32; 2] {
        let ([sin_tilt, cos_tilt], sign) = match p {
            0 => (self.tilt[1], -1.0),
            1 => (self.tilt[0], 1.0),
            2 => (self.tilt[2], 1.0),
            _ => ([0.0, 1.0], 1.0),
        };
        let Outgoing { sin, cos, .. } = *outgoing;
        [sin * cos_tilt + sign * cos * sin_tilt, (cos * cos_tilt - sign * sin * sin_tilt).abs()]
    }

    /// Np and Mp of every way toward `wi`.
    fn factors(&self, outgoing: &Outgoing, wi: Vec3) -> [f32; LOBES] {
        let (sin, cos) = (wi.x, safe_sqrt(1.0 - wi.x * wi.x));
        let phi = wi.z.atan2(wi.y) - outgoing.phi;
        std::array::from_fn(|p| {
            let [sin_o, cos_o] = self.tilted(outgoing, p);
            let along = longitudinal(cos * cos_o, sin * sin_o, self.v[p]);
            let around = if p < PASSES { self.azimuthal(outgoing, phi, p) } else { 0.5 * FRAC_1_PI };
            along * around
        })
    }

    fn azimuthal(&self, outgoing: &Outgoing, phi: f32, p: usize) -> f32 {
        let difference = phi - deflection(outgoing, p);
        let turns = (difference / TAU).round();
        trimmed_logistic(difference - turns * TAU, self.s)
    }
}

/// The azimuth by which a smooth fibre deflects light on way `p`.
fn deflection(outgoing: &Outgoing, p: usize) -> f32 {
    let p = p as f32;
    2.0 * p * outgoing.gamma_t - 2.0 * outgoing.gamma_o + p * PI
}

/// Mp of the product of cosines and that of sines; d'Eon et al. 2011, equation 7.
fn longitudinal(coscos: f32, sinsin: f32, v: f32) -> f32 {
    let (a, b) = (coscos / v, sinsin / v);
    if v <= 0.1 {
        (log_bessel(a) - b - 1.0 / v + LN_2 + (1.0 / (2.0 * v)).ln()).exp()
    } else {
        (-b).exp() * bessel(a) / ((1.0 / v).sinh() * 2.0 * v)
    }
}

/// The modified Bessel function I₀ for arguments up to about twelve, by its power series.
fn bessel(x: f32) -> f32 {
    let quarter = 0.25 * x * x;
    let (mut sum, mut term) = (1.0, 1.0);
    for i in 1..20_u8 {
        let i = f32::from(i);
        term *= quarter / (i * i);
        sum += term;
    }
    sum
}

/// ln I₀: by the asymptotic series for large arguments.
fn log_bessel(x: f32) -> f32 {
    if x > 12.0 { x + 0.5 * (-TAU.ln() + (1.0 / x).ln() + 1.0 / (4.0 * x)) } else { bessel(x).ln() }
}

/// The logistic distribution function.
fn logistic_cdf(x: f32, s: f32) -> f32 {
    1.0 / (1.0 + (-x / s).exp())
}

/// The density of the logistic distribution of scale `s`, cut to [−π, π].
fn trimmed_logistic(x: f32, s: f32) -> f32 {
    let e = (-x.abs() / s).exp();
    let whole = e / (s * (1.0 + e) * (1.0 + e));
    whole / (2.0 * logistic_cdf(PI, s) - 1.0)
}

/// Draws from [`trimmed_logistic`].
fn sample_trimmed_logistic(u: f32, s: f32) -> f32 {
    let low = logistic_cdf(-PI, s);
    let cdf = low + u * (1.0 - 2.0 * low);
    (-s * (1.0 / cdf - 1.0).ln()).clamp(-PI, PI)
}

impl Scatter for Hair {
    fn eval(&self, wo: Vec3, wi: Vec3) -> Spectrum {
        if wo.z == 0.0 || wi.z == 0.0 {
            return Spectrum::ZERO;
        }
        let outgoing = self.outgoing(wo);
        let mut sum = Spectrum::ZERO;
        for (attenuation, factor) in outgoing.attenuation.into_iter().zip(self.factors(&outgoing, wi)) {
            sum += attenuation * factor;
        }
        sum
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z == 0.0 || wi.z == 0.0 {
            return 0.0;
        }
        let outgoing = self.outgoing(wo);
        let factors = self.factors(&outgoing, wi);
        Self::pmf(&outgoing).into_iter().zip(factors).map(|(pmf, factor)| pmf * factor).sum()
    }

    fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let outgoing = self.outgoing(wo);
        let pmf = Self::pmf(&outgoing);
        // Choose a way; what is left of the number chooses the azimuth.
        let (mut p, mut left) = (0, u_lobe);
        while p + 1 < LOBES && left >= pmf[p] {
            left -= pmf[p];
            p += 1;
        }
        let u_azimuth = (left / pmf[p]).clamp(0.0, 1.0 - f32::EPSILON / 2.0);
        // The cosine about the tilted direction follows an exponential.
        let [sin_o, cos_o] = self.tilted(&outgoing, p);
        let v = self.v[p];
        let cos = (1.0 + v * (u.x + (1.0 - u.x) * (-2.0 / v).exp()).ln()).clamp(-1.0, 1.0);
        let sin = safe_sqrt(1.0 - cos * cos);
        let (_, cos_phi) = warp::sin_cos_turns(u.y);
        let sin_i = (-cos * sin_o + sin * cos_phi * cos_o).clamp(-1.0, 1.0);
        let cos_i = safe_sqrt(1.0 - sin_i * sin_i);
        let turned = if p < PASSES {
            deflection(&outgoing, p) + sample_trimmed_logistic(u_azimuth, self.s)
        } else {
            TAU * u_azimuth
        };
        let (sin_phi, cos_phi) = (outgoing.phi + turned).sin_cos();
        let wi = Vec3::new(sin_i, cos_i * cos_phi, cos_i * sin_phi);
        let (pdf, value) = (self.pdf(wo, wi), self.eval(wo, wi));
        let kind =
            if wo.z * wi.z < 0.0 { ScatterKind::GLOSSY_TRANSMISSION } else { ScatterKind::GLOSSY_REFLECTION };
        let weight = value / pdf;
        (pdf > 0.0 && pdf.is_finite() && weight.is_finite()).then_some(BsdfSample {
            wi,
            weight,
            pdf,
            kind,
            eta: 1.0,
        })
    }

    #[inline]
    fn is_specular(&self) -> bool {
        false
    }

    #[inline]
    fn reach(&self) -> Reach {
        Reach::Everywhere
    }

    fn albedo(&self, wo: Vec3) -> Spectrum {
        let mut sum = Spectrum::ZERO;
        for attenuation in self.outgoing(wo).attenuation {
            sum += attenuation;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use sahl_testkit::quadrature::integrate_sphere;

    use super::*;

    #[test]
    fn longitudinal_factors_integrate_to_one() {
        for v in [0.02, 0.09, 0.11, 0.5, 2.0] {
            for sin_o in [-0.9_f32, 0.0, 0.5] {
                let cos_o = safe_sqrt(1.0 - sin_o * sin_o);
                let density = |w: Vec3| {
                    longitudinal(safe_sqrt(1.0 - w.x * w.x) * cos_o, w.x * sin_o, v) * 0.5 * FRAC_1_PI
                };
                let total = integrate_sphere(density, 1e-4);
                assert!((total - 1.0).abs() < 5e-3, "{v} {sin_o}: {total}");
            }
        }
    }

    #[test]
    fn the_azimuth_is_drawn_from_its_density() {
        for s in [0.02, 0.2, 1.0] {
            let steps = 10_000;
            let width = TAU / steps as f32;
            let mut cdf = 0.0;
            for i in 0..steps {
                cdf += trimmed_logistic(-PI + (i as f32 + 0.5) * width, s) * width;
                let x = -PI + (i + 1) as f32 * width;
                if cdf > 0.01 && cdf < 0.99 {
                    assert!((sample_trimmed_logistic(cdf, s) - x).abs() < 0.01 * s + width, "{s} {x}");
                }
            }
            assert!((cdf - 1.0).abs() < 1e-3, "{s}: {cdf}");
        }
    }
}
