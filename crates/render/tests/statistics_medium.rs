//! Every phase function: samples follow the density, which integrates to one and is the same both ways round.

use sahl_math::{Vec2, Vec3};
use sahl_render::medium::{HenyeyGreenstein, PhaseSample};
use sahl_testkit::chi2::SphereTest;
use sahl_testkit::random::Rng;

/// Isotropic, the two sides of it, and peaks forward and back.
const ASYMMETRIES: [f32; 8] = [0.0, 1e-6, -1e-3, 0.3, -0.5, 0.85, -0.95, 0.99];

#[test]
fn phase_functions_are_sampled_by_their_values() {
    for (row, g) in ASYMMETRIES.into_iter().enumerate() {
        let phase = HenyeyGreenstein::new(g);
        let mut rng = Rng::new(row as u64);
        let wo = rng.direction();
        let test = SphereTest { samples: 400_000, tests: ASYMMETRIES.len(), ..SphereTest::default() };
        test.run(|[x, y, _]| Some(phase.sample(wo, Vec2::new(x, y)).wi), |wi| phase.eval(wo, wi))
            .unwrap_or_else(|e| panic!("g = {g}: {e}"));
    }
}

#[test]
fn the_mean_cosine_of_the_deflection_is_g() {
    for g in ASYMMETRIES {
        let phase = HenyeyGreenstein::new(g);
        let wo = Vec3::Z;
        let n = 1 << 14;
        // Equidistant points in the middle of their strata: the sum is an integral.
        let cosine = |i: i32| f64::from(-phase.sample(wo, Vec2::new((i as f32 + 0.5) / n as f32, 0.25)).wi.z);
        let mean = (0..n).map(cosine).sum::<f64>() / f64::from(n);
        assert!((mean - f64::from(g)).abs() < 2e-4, "g = {g}: {mean}");
    }
}

#[test]
fn samples_know_their_density_and_directions_can_be_exchanged() {
    let mut rng = Rng::new(7);
    for g in ASYMMETRIES {
        let phase = HenyeyGreenstein::new(g);
        for _ in 0..1000 {
            let wo = rng.direction();
            let PhaseSample { wi, pdf } = phase.sample(wo, Vec2::from(rng.uniform()));
            assert!(pdf > 0.0 && pdf.is_finite() && (wi.length() - 1.0).abs() < 1e-5);
            assert_eq!(phase.eval(wo, wi), phase.eval(wi, wo));
            // Near a peak the density doubles within the rounding of the cosine.
            let slack = 1e-6 / ((1.0 - g.abs()) * (1.0 - g.abs()));
            assert!((phase.eval(wo, wi) / pdf - 1.0).abs() < 1e-4 + 4.0 * slack, "g = {g}");
        }
    }
}
