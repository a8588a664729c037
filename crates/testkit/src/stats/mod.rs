//! The statistics behind the checks: special functions, distribution tails, moments, two-sample tests.

mod moments;
mod special;

pub use moments::{Running, welch};
pub use special::{
    beta_regularized, chi_squared_tail, gamma_lower, gamma_upper, ln_gamma, normal_cdf, poisson_upper_tail,
    student_two_sided, two_sided,
};

/// The significance of each of `tests` independent tests, so that all pass with probability `1 − alpha` when there is
/// nothing to find: `1 − (1 − alpha)^(1 / tests)`.
///
/// Zero tests count as one.
///
/// Source: Šidák, *Rectangular Confidence Regions for the Means of Multivariate Normal Distributions*, JASA 62, 1967.
pub fn per_test(alpha: f64, tests: usize) -> f64 {
    -((-alpha).ln_1p() / tests.max(1) as f64).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_family_keeps_its_significance() {
        assert_eq!(per_test(0.01, 1), per_test(0.01, 0));
        assert!((per_test(0.01, 1) - 0.01).abs() < 1e-15);
        for tests in [2, 50, 1_000_000] {
            let alpha = per_test(0.01, tests);
            let family = -(tests as f64 * (-alpha).ln_1p()).exp_m1();
            assert!((family - 0.01).abs() < 1e-12, "{tests} tests: {family}");
        }
    }
}
