//! Densities over directions.

use std::f64::consts::{PI, TAU};

use sahl_math::Vec3;

use super::SEED;
use super::plane::Table;
use crate::quadrature::{Cell, spherical};
use crate::random::Rng;

/// How far from one the squared length of a sampled direction may be.
const UNIT_TOLERANCE: f32 = 1e-3;

/// The test of directions against a density per steradian.
///
/// The bins are uniform in the polar angle `theta` from +z and the azimuth `phi`. With an even number of `theta_bins`
/// the equator is an edge of bins. More bins see narrower errors, more samples see smaller ones: a relative error `e`
/// of the density everywhere adds about `samples × e²` to a chi² whose own spread is the square root of twice the
/// number of bins.
///
/// ```
/// use sahl_math::{Vec3, safe_sqrt};
/// use sahl_testkit::chi2::SphereTest;
///
/// let uniform = |u: [f32; 3]| {
///     let z = 1.0 - 2.0 * u[0];
///     let (sin, cos) = (std::f32::consts::TAU * u[1]).sin_cos();
///     let r = safe_sqrt(1.0 - z * z);
///     Some(Vec3::new(r * cos, r * sin, z))
/// };
/// SphereTest::default().run(uniform, |_| 0.25 / std::f32::consts::PI).unwrap();
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereTest {
    /// Bins of the polar angle.
    pub theta_bins: usize,
    /// Bins of the azimuth.
    pub phi_bins: usize,
    /// How many directions are drawn.
    pub samples: usize,
    /// Probability that a family of `tests` right tests fails.
    pub significance: f64,
    /// How many tests share the significance.
    pub tests: usize,
}

impl Default for SphereTest {
    fn default() -> Self {
        Self { theta_bins: 32, phi_bins: 64, samples: 1_000_000, significance: 0.01, tests: 1 }
    }
}

impl SphereTest {
    /// Draws directions from triples of uniform numbers in [0, 1) and compares them with `pdf`.
    ///
    /// `None` is a failed draw; the density may integrate to less than one accordingly. Fails on directions that are
    /// not of unit length, on a negative or not finite density, and on an integral above one.
    pub fn run(
        &self,
        mut sample: impl FnMut([f32; 3]) -> Option<Vec3>,
        pdf: impl Fn(Vec3) -> f32,
    ) -> Result<(), String> {
        let region = Cell { low: [0.0; 2], high: [PI, TAU] };
        let mut table = Table::new(region, [self.theta_bins, self.phi_bins], ["theta", "phi"]);
        let mut rng = Rng::new(SEED);
        for _ in 0..self.samples {
            match sample(rng.uniform()) {
                None => table.failed += 1,
                Some(w) if (w.length_squared() - 1.0).abs() <= UNIT_TOLERANCE => table.add(angles(w)),
                Some(w) => return Err(format!("sampled {w:?}, which is not of unit length")),
            }
        }
        let density = |theta: f64, phi: f64| f64::from(pdf(spherical(theta, phi))) * theta.sin();
        table.test(density, self.significance, self.tests)
    }
}

/// Polar angle in [0, π] and azimuth in [0, 2π) of a direction.
fn angles(w: Vec3) -> [f64; 2] {
    let [x, y, z] = [w.x, w.y, w.z].map(f64::from);
    [x.hypot(y).atan2(z), y.atan2(x).rem_euclid(TAU)]
}

#[cfg(test)]
mod tests {
    use std::f32::consts::{FRAC_1_PI, TAU};

    use super::*;
    use sahl_math::safe_sqrt;

    /// Directions of density `(n + 1) / 2π · cosⁿ θ`, from the first two numbers.
    fn power_cosine(n: f32) -> impl Fn([f32; 3]) -> Option<Vec3> {
        move |u| {
            let z = (1.0 - u[0]).powf(1.0 / (n + 1.0));
            let (sin, cos) = (TAU * u[1]).sin_cos();
            let r = safe_sqrt(1.0 - z * z);
            Some(Vec3::new(r * cos, r * sin, z))
        }
    }

    fn power_cosine_pdf(n: f32) -> impl Fn(Vec3) -> f32 {
        move |w| if w.z > 0.0 { (n + 1.0) / TAU * w.z.powf(n) } else { 0.0 }
    }

    #[test]
    fn right_densities_pass() {
        for n in [0.0, 1.0, 20.0, 3000.0] {
            let test = SphereTest { tests: 4, ..SphereTest::default() };
            test.run(power_cosine(n), power_cosine_pdf(n)).unwrap_or_else(|e| panic!("n = {n}: {e}"));
        }
    }

    #[test]
    fn an_exponent_off_by_a_hundredth_fails() {
        let message = SphereTest::default().run(power_cosine(1.0), power_cosine_pdf(1.02)).unwrap_err();
        assert!(message.contains("degrees of freedom"), "{message}");
        SphereTest::default().run(power_cosine(100.0), power_cosine_pdf(101.0)).unwrap_err();
    }

    #[test]
    fn a_normalisation_off_by_a_thousandth_fails_either_way() {
        let scaled = |factor: f32| move |w: Vec3| factor * FRAC_1_PI * w.z.max(0.0);
        let test = SphereTest::default();
        assert!(test.run(power_cosine(1.0), scaled(0.999)).unwrap_err().contains("failed samples"));
        assert!(test.run(power_cosine(1.0), scaled(1.001)).unwrap_err().contains("more than one"));
    }

    #[test]
    fn an_azimuth_modulated_by_two_hundredths_fails() {
        let pdf =
            |w: Vec3| FRAC_1_PI * w.z.max(0.0) * (1.0 + 0.02 * w.x / safe_sqrt(1.0 - w.z * w.z).max(1e-6));
        SphereTest::default().run(power_cosine(1.0), pdf).unwrap_err();
    }

    #[test]
    fn the_usual_mistakes_fail() {
        let test = SphereTest::default();
        let cosine = |w: Vec3| FRAC_1_PI * w.z.max(0.0);
        // A missing Jacobian, a lobe about the wrong axis, directions below the horizon.
        test.run(power_cosine(0.0), cosine).unwrap_err();
        let turned = |u: [f32; 3]| power_cosine(1.0)(u).map(|w| Vec3::new(w.z, w.x, w.y));
        test.run(turned, cosine).unwrap_err();
        let below = |u: [f32; 3]| power_cosine(1.0)(u).map(|w| if u[2] < 1e-4 { -w } else { w });
        assert!(test.run(below, cosine).unwrap_err().contains("where the density expects"));
    }

    #[test]
    fn refused_directions_are_the_missing_mass() {
        // Tilted by 60 degrees, and refused below the horizon.
        let tilt =
            |w: Vec3| Vec3::new(0.5 * w.x + 0.75_f32.sqrt() * w.z, w.y, 0.5 * w.z - 0.75_f32.sqrt() * w.x);
        let untilt =
            |w: Vec3| Vec3::new(0.5 * w.x - 0.75_f32.sqrt() * w.z, w.y, 0.5 * w.z + 0.75_f32.sqrt() * w.x);
        let sample = |u: [f32; 3]| power_cosine(20.0)(u).map(tilt).filter(|w| w.z > 0.0);
        let pdf = |w: Vec3| if w.z > 0.0 { power_cosine_pdf(20.0)(untilt(w)) } else { 0.0 };
        SphereTest::default().run(sample, pdf).unwrap();
        let unfiltered = |u: [f32; 3]| power_cosine(20.0)(u).map(tilt);
        SphereTest::default().run(unfiltered, pdf).unwrap_err();
    }

    #[test]
    fn nonsense_is_told() {
        let test = SphereTest { samples: 100, ..SphereTest::default() };
        assert!(test.run(|_| Some(Vec3::splat(f32::NAN)), |_| 1.0).unwrap_err().contains("unit length"));
        assert!(test.run(|_| Some(Vec3::ZERO), |_| 1.0).unwrap_err().contains("unit length"));
        assert!(test.run(power_cosine(1.0), |_| f32::INFINITY).unwrap_err().contains("not finite"));
    }
}
