//! How far from where light enters a half space it leaves again.
//!
//! Design decision: the radial profile depends on the albedo and on the distance in mean free paths, for a given index and a given
//! phase function. It is computed when the scene is built, for a hundred albedos and 64 distances, which are those of pbrt-v4, and
//! interpolated by splines.
//!
//! Source: Habel, Christensen, Jarosz, *Photon Beam Diffusion: A Hybrid Monte Carlo Method for Subsurface Scattering*, EGSR 2013; Pharr,
//! Jakob, Humphreys, *Physically Based Rendering*, 3rd ed., 2016, section 15.5. Deviation: moments of the Fresnel reflectance are
//! integrated, where pbrt-v4 has polynomials that were fitted to them; and profiles that would give back more light than they got are
//! scaled down.

use std::f64::consts::{FRAC_1_PI, TAU};

use super::spline::{Segment, Weights, invert};
use crate::bsdf::fresnel;

const ALBEDOS: usize = 100;
const RADII: usize = 64;

/// Places along the beam at which light is scattered.
const BEAM_STEPS: u32 = 100;

/// Steps of the integral of a moment of the reflectance.
const MOMENT_STEPS: u32 = 4096;

/// Radial profiles of the light that leaves a half space lit by a beam at right angles, for all albedos.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DiffusionTable {
    albedos: Vec<f32>,
    /// In mean free paths.
    radii: Vec<f32>,
    /// 2 π r times the light that leaves per area, for each albedo and radius.
    profile: Vec<f32>,
    /// Its integral up to each radius.
    cdf: Vec<f32>,
    /// For each albedo the share of light that leaves anywhere.
    effective: Vec<f32>,
}

/// ∫ F(μ) μⁿ dμ, the reflectance at an interface with the relative index `eta`.
pub(super) fn fresnel_moment(eta: f32, power: i32) -> f64 {
    let steps = f64::from(MOMENT_STEPS);
    let term = |i| {
        let mu = (f64::from(i) + 0.5) / steps;
        f64::from(fresnel::dielectric(mu as f32, eta).reflectance) * mu.powi(power) / steps
    };
    (0..MOMENT_STEPS).map(term).sum()
}

/// The matter in a half space, per mean free path.
struct Matter {
    albedo: f64,
    g: f64,
    eta: f32,
    /// First and second moment of the reflectance from inside.
    moments: [f64; 2],
}

/// Depths that follow the density exp(−z), one for each step.
fn depths() -> impl Iterator<Item = f64> {
    (0..BEAM_STEPS).map(|i| -(1.0 - (f64::from(i) + 0.5) / f64::from(BEAM_STEPS)).ln())
}

impl Matter {
    /// Light per area that leaves at distance `r` after one scattering.
    fn single(&self, r: f64) -> f64 {
        let eta = f64::from(self.eta);
        // Nearer to the surface, light to this distance is reflected back entirely.
        let critical = r * (eta * eta - 1.0).max(0.0).sqrt();
        let term = |z: f64| {
            let t = critical + z;
            let d = r.hypot(t);
            let cos = t / d;
            let passed = 1.0 - f64::from(fresnel::dielectric(cos as f32, 1.0 / self.eta).reflectance);
            let shape = 1.0 + self.g * self.g + 2.0 * self.g * cos;
            let phase = 0.5 / TAU * (1.0 - self.g * self.g) / (shape * shape.sqrt());
            self.albedo * (-(d + critical)).exp() / (d * d) * phase * passed * cos
        };
        depths().map(term).sum::<f64>() / f64::from(BEAM_STEPS)
    }

    /// Light per area that leaves at distance `r` after more scatterings: dipoles along the beam.
    fn multiple(&self, r: f64) -> f64 {
        let (absorbed, scattered) = (1.0 - self.albedo, self.albedo * (1.0 - self.g));
        let reduced = absorbed + scattered;
        if reduced == 0.0 {
            return 0.0;
        }
        let albedo = scattered / reduced;
        let diffusion = (2.0 * absorbed + scattered) / (3.0 * reduced * reduced);
        let falloff = (absorbed / diffusion).sqrt();
        let [m1, m2] = self.moments;
        let extrapolated = -2.0 * diffusion * (1.0 + 3.0 * m2) / (1.0 - 2.0 * m1);
        let (of_fluence, of_flux) = (0.25 * (1.0 - 2.0 * m1), 0.5 * (1.0 - 3.0 * m2));
        let term = |z: f64| {
            let real = z / reduced;
            let mirrored = 2.0 * extrapolated - real;
            let [to_real, to_mirrored] = [real, mirrored].map(|z| r.hypot(z));
            let [e_real, e_mirrored] = [to_real, to_mirrored].map(|d| (-falloff * d).exp());
            let fluence = (e_real / to_real - e_mirrored / to_mirrored) / diffusion;
            let flux = real * (1.0 + falloff * to_real) * e_real / to_real.powi(3)
                - mirrored * (1.0 + falloff * to_mirrored) * e_mirrored / to_mirrored.powi(3);
            // Takes back what the dipole has too much of near the beam.
            let kept = 1.0 - (-2.0 * reduced * (to_real + real)).exp();
            kept * albedo * albedo * (fluence * of_fluence + flux * of_flux) * 0.25 * FRAC_1_PI
        };
        depths().map(term).sum::<f64>() / f64::from(BEAM_STEPS)
    }
}

impl DiffusionTable {
    /// The profiles of matter with the relative index `eta`, scattering with the mean cosine `g`.
    pub(crate) fn new(g: f32, eta: f32) -> Self {
        let mut radii = vec![0.0, 2.5e-3];
        while radii.len() < RADII {
            radii.push(radii[radii.len() - 1] * 1.2);
        }
        let last = (ALBEDOS - 1) as f64;
        // Denser toward one, where little absorption changes much.
        let albedo = |i: usize| (1.0 - (-8.0 * i as f64 / last).exp()) / (1.0 - (-8.0_f64).exp());
        let mut table = Self {
            albedos: (0..ALBEDOS).map(|i| albedo(i) as f32).collect(),
            radii,
            profile: Vec::with_capacity(ALBEDOS * RADII),
            cdf: Vec::with_capacity(ALBEDOS * RADII),
            effective: Vec::with_capacity(ALBEDOS),
        };
        let moments = [1, 2].map(|power| fresnel_moment(1.0 / eta, power));
        for i in 0..ALBEDOS {
            table.push(&Matter { albedo: albedo(i), g: f64::from(g), eta, moments });
        }
        table
    }

    fn push(&mut self, matter: &Matter) {
        let first = self.profile.len();
        for &r in &self.radii {
            let r = f64::from(r);
            self.profile.push((TAU * r * (matter.single(r) + matter.multiple(r))).max(0.0) as f32);
        }
        let mut sum = 0.0;
        self.cdf.push(0.0);
        for i in 0..RADII - 1 {
            let segment = Segment::new(&self.radii, i, |i| self.profile[first + i]);
            sum += f64::from((self.radii[i + 1] - self.radii[i]) * segment.integral());
            self.cdf.push(sum as f32);
        }
        // Diffusion gives back more than it got where nothing is absorbed, by two per cent at most for water.
        if sum > 1.0 {
            for value in self.profile[first..].iter_mut().chain(&mut self.cdf[first..]) {
                *value = (f64::from(*value) / sum) as f32;
            }
        }
        self.effective.push(sum.min(1.0) as f32);
    }

    /// The profile for matter of the given albedo.
    #[inline]
    pub(super) fn profile(&self, albedo: f32) -> Profile<'_> {
        let weights = Weights::at(&self.albedos, albedo.clamp(0.0, 1.0));
        let weights = weights.or_else(|| Weights::at(&self.albedos, self.albedos[ALBEDOS - 1]));
        Profile { table: self, weights }
    }

    /// The albedo of matter that scatters the share `reflectance` of light back: the nearest, if none does.
    pub(crate) fn albedo_of(&self, reflectance: f32) -> f32 {
        invert(&self.albedos, &self.effective, reflectance)
    }
}

/// The radial profile for one albedo.
#[derive(Clone, Copy, Debug)]
pub(super) struct Profile<'a> {
    table: &'a DiffusionTable,
    /// `None` only where the albedo is not a number.
    weights: Option<Weights>,
}

impl Profile<'_> {
    #[inline]
    fn mixed(&self, values: &[f32], radius: usize) -> f32 {
        self.weights.map_or(0.0, |weights| weights.sum(|albedo| values[albedo * RADII + radius]))
    }

    /// The share of light that leaves anywhere.
    #[inline]
    pub(super) fn effective_albedo(&self) -> f32 {
        self.weights.map_or(0.0, |weights| weights.sum(|albedo| self.table.effective[albedo]))
    }

    /// 2 π r times the light that leaves per area at `r` mean free paths; zero beyond the table.
    #[inline]
    pub(super) fn radial(&self, r: f32) -> f32 {
        let weights = Weights::at(&self.table.radii, r);
        weights.map_or(0.0, |weights| weights.sum(|radius| self.mixed(&self.table.profile, radius))).max(0.0)
    }

    /// Draws a distance in mean free paths in proportion to [`Profile::radial`].
    #[inline]
    pub(super) fn sample(&self, u: f32) -> f32 {
        let (table, target) = (self.table, u * self.effective_albedo());
        let begins = |i: usize| self.mixed(&table.cdf, i);
        let (mut first, mut rest) = (0, RADII - 1);
        while rest > 1 {
            let half = rest / 2;
            if begins(first + half) <= target {
                first += half;
                rest -= half;
            } else {
                rest = half;
            }
        }
        let width = table.radii[first + 1] - table.radii[first];
        let segment = Segment::new(&table.radii, first, |i| self.mixed(&table.profile, i));
        table.radii[first] + width * segment.solve((target - begins(first)) / width)
    }
}
