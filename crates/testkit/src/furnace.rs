//! Energy and symmetry of scattering: directional albedo two ways, the white furnace, reciprocity.
//!
//! The closures follow the convention of Sahl's BSDFs: local frame with the normal along +z, `eval` gives
//! `f(wo, wi) |cos θi|`, `sample` gives the weight `f |cos θi| / pdf`. A caller tests one lane of a spectrum at a time.
//!
//! The albedo is estimated by the mean weight of samples and by quadrature of `eval`. The two share no code below the
//! formula of `f`, so that their agreement ties `sample`, `pdf` and `eval` together, as three estimates do in
//! RenderMan's PxrValidateBxdf.

use sahl_math::Vec3;

use crate::quadrature::integrate_sphere;
use crate::random::Rng;
use crate::stats::{Running, per_test, two_sided};

/// The seed of all samples and directions: verdicts repeat.
const SEED: u64 = 0xF0A2_4ACE;
/// The error aimed at by quadrature, of an albedo.
const QUADRATURE_ERROR: f64 = 1e-5;
/// The least standard error of an albedo: what rounding and quadrature leave even where sampling has no noise.
const LEAST_ERROR: f64 = 5e-5;

/// The mean weight of `samples` samples, with its spread. A failed sample (`None`) has weight zero.
pub fn albedo_by_sampling(mut sample: impl FnMut([f32; 3]) -> Option<f32>, samples: usize) -> Running {
    let mut rng = Rng::new(SEED);
    (0..samples).map(|_| f64::from(sample(rng.uniform()).unwrap_or(0.0))).collect()
}

/// The integral of `eval(wi) = f |cos θi|` over the sphere.
///
/// Reliable for lobes wider than a few degrees; a narrower one can slip through the first cut.
pub fn albedo_by_quadrature(eval: impl Fn(Vec3) -> f32) -> f64 {
    integrate_sphere(eval, QUADRATURE_ERROR)
}

/// The checks on one direction `wo` of one surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Furnace {
    /// How many samples estimate the albedo.
    pub samples: usize,
    /// Probability that a family of `tests` right tests fails.
    pub significance: f64,
    /// How many tests share the significance.
    pub tests: usize,
}

impl Default for Furnace {
    fn default() -> Self {
        Self { samples: 200_000, significance: 0.01, tests: 1 }
    }
}

impl Furnace {
    /// Checks that the albedo by sampling agrees with the albedo by quadrature; returns the latter.
    ///
    /// Not for surfaces with delta lobes, of which quadrature sees nothing.
    pub fn agreement(
        &self,
        sample: impl FnMut([f32; 3]) -> Option<f32>,
        eval: impl Fn(Vec3) -> f32,
    ) -> Result<f64, String> {
        let exact = albedo_by_quadrature(eval);
        self.expect_albedo(sample, exact)?;
        Ok(exact)
    }

    /// Checks that the albedo by sampling is `exact`: one for the white furnace of a surface without losses.
    pub fn expect_albedo(
        &self,
        sample: impl FnMut([f32; 3]) -> Option<f32>,
        exact: f64,
    ) -> Result<(), String> {
        let sampled = albedo_by_sampling(sample, self.samples);
        let z = (sampled.mean() - exact) / standard_error(&sampled);
        let (p, threshold) = (two_sided(z), per_test(self.significance, self.tests));
        if p >= threshold {
            return Ok(());
        }
        Err(format!(
            "the albedo by sampling is {:.6}, expected {exact:.6}: z = {z:.2}, p = {p:.3e} is below {threshold:.3e}",
            sampled.mean()
        ))
    }

    /// Checks that the albedo by sampling is at most one; returns it.
    pub fn no_gain(&self, sample: impl FnMut([f32; 3]) -> Option<f32>) -> Result<f64, String> {
        let sampled = albedo_by_sampling(sample, self.samples);
        let z = (sampled.mean() - 1.0) / standard_error(&sampled);
        let threshold = per_test(self.significance, self.tests);
        // One-sided: half of the two-sided p-value.
        if !sampled.mean().is_finite() || (z > 0.0 && 0.5 * two_sided(z) < threshold) {
            return Err(format!(
                "the albedo by sampling is {:.6}, more than one: z = {z:.2}",
                sampled.mean()
            ));
        }
        Ok(sampled.mean())
    }
}

/// The standard error of the mean, never below what rounding leaves.
fn standard_error(sampled: &Running) -> f64 {
    sampled.variance_of_mean().sqrt().max(LEAST_ERROR)
}

/// The reciprocity of a surface over random pairs of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reciprocity {
    /// How many pairs.
    pub pairs: usize,
    /// The largest relative difference of the two values.
    pub tolerance: f32,
    /// Index of refraction below the surface (z < 0) over the one above; one for surfaces that transmit nothing.
    ///
    /// Radiance is compressed by refraction: `f(wo, wi) / η(wo)² = f(wi, wo) / η(wi)²`, where `η(w)` is the index on the
    /// side of `w`. Source: Veach, *Robust Monte Carlo Methods for Light Transport Simulation*, 1997, equation 5.14.
    pub eta: f32,
}

impl Default for Reciprocity {
    fn default() -> Self {
        Self { pairs: 10_000, tolerance: 1e-3, eta: 1.0 }
    }
}

impl Reciprocity {
    /// Checks `eval(wo, wi) = f |cos θi|` over pairs uniform on the sphere, grazing ones (`|cos θ| < 0.01`) excluded.
    ///
    /// Fails also on values that are negative or not finite, and when no pair scatters at all.
    pub fn check(&self, eval: impl Fn(Vec3, Vec3) -> f32) -> Result<(), String> {
        let mut rng = Rng::new(SEED);
        let mut scattering = 0;
        for _ in 0..self.pairs {
            let (wo, wi) = (rng.direction(), rng.direction());
            if wo.z.abs() < 0.01 || wi.z.abs() < 0.01 {
                continue;
            }
            let side = |w: Vec3| if w.z < 0.0 { self.eta * self.eta } else { 1.0 };
            let there = eval(wo, wi) / (wi.z.abs() * side(wo));
            let back = eval(wi, wo) / (wo.z.abs() * side(wi));
            let scale = there.abs().max(back.abs());
            let fine = there >= 0.0 && back >= 0.0 && scale.is_finite();
            if !fine || (there - back).abs() > self.tolerance * scale {
                return Err(format!("f is {there} from {wi:?} to {wo:?}, and {back} the other way"));
            }
            scattering += usize::from(scale > 0.0);
        }
        if scattering == 0 {
            return Err(format!("none of {} pairs of directions scatters", self.pairs));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::{FRAC_1_PI, TAU};

    use super::*;
    use sahl_math::safe_sqrt;

    /// Uniform on the upper hemisphere, density 1 / 2π.
    fn upper(u: [f32; 3]) -> Vec3 {
        let (sin, cos) = (TAU * u[1]).sin_cos();
        let r = safe_sqrt(1.0 - u[0] * u[0]);
        Vec3::new(r * cos, r * sin, u[0])
    }

    /// A diffuse surface, `f |cos|`.
    fn diffuse(albedo: f32) -> impl Fn(Vec3) -> f32 {
        move |wi| albedo * FRAC_1_PI * wi.z.max(0.0)
    }

    #[test]
    fn a_diffuse_surface_agrees_with_itself() {
        let sample = |u| Some(diffuse(0.7)(upper(u)) * TAU);
        let albedo = Furnace::default().agreement(sample, diffuse(0.7)).unwrap();
        assert!((albedo - 0.7).abs() < 1e-5, "{albedo}");
        Furnace::default().expect_albedo(|_| Some(1.0), 1.0).unwrap();
        assert_eq!(Furnace::default().no_gain(|_| Some(1.0)), Ok(1.0));
    }

    #[test]
    fn a_hundredth_of_energy_lost_or_won_is_seen() {
        let sample = |u| Some(diffuse(0.7)(upper(u)) * TAU);
        let furnace = Furnace { tests: 100, ..Furnace::default() };
        furnace.agreement(sample, diffuse(0.707)).unwrap_err();
        furnace.agreement(sample, diffuse(0.693)).unwrap_err();
        furnace.expect_albedo(|u| if u[0] < 0.01 { None } else { Some(1.0) }, 1.0).unwrap_err();
        furnace.no_gain(|u| Some(2.02 * u[0])).unwrap_err();
        furnace.no_gain(|_| Some(f32::NAN)).unwrap_err();
    }

    #[test]
    fn reciprocity_holds_for_a_symmetric_function_alone() {
        let check = Reciprocity::default();
        check.check(|wo, wi| if wo.z * wi.z > 0.0 { FRAC_1_PI * wi.z.abs() } else { 0.0 }).unwrap();
        check.check(|wo, wi| wi.z.abs() * (1.0 + 0.01 * wo.x)).unwrap_err();
        // A missing cosine: the commonest slip.
        check.check(|_, _| FRAC_1_PI).unwrap_err();
        assert!(check.check(|_, _| 0.0).unwrap_err().contains("none of"));
        assert!(check.check(|_, _| -1.0).is_err());
    }

    #[test]
    fn refraction_scales_radiance() {
        let eta = 1.5_f32;
        let check = Reciprocity { eta, ..Reciprocity::default() };
        // A diffuse transmitter; light that leaves the denser side loses eta² of its radiance.
        let f = |wo: Vec3| if wo.z < 0.0 { eta * eta } else { 1.0 };
        check.check(|wo, wi| if wo.z * wi.z < 0.0 { f(wo) * wi.z.abs() } else { 0.0 }).unwrap();
        check.check(|wo, wi| if wo.z * wi.z < 0.0 { wi.z.abs() } else { 0.0 * f(wo) }).unwrap_err();
    }
}
