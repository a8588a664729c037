//! The statistic itself: counts against expectations.

use std::fmt::Write;

use crate::stats::{chi_squared_tail, per_test, poisson_upper_tail};

/// Bins that expect fewer are pooled: the chi² distribution is a poor approximation for rare counts (Cochran 1954).
const MIN_EXPECTED: f64 = 5.0;
/// The share of samples that may fall where the density is zero: rounding moves a sample across the edge of a support.
const ROUNDING_SHARE: f64 = 2e-6;
/// How many of the worst bins a failure lists.
const WORST: usize = 6;

/// The outcome of one comparison of counts with expectations.
#[derive(Clone, Debug, PartialEq)]
pub struct Pearson {
    /// `Σ (observed − expected)² / expected` over the pooled bins.
    pub statistic: f64,
    /// Pooled bins less one: the total is given.
    pub degrees: usize,
    /// Probability of a statistic at least as large if the samples follow the density.
    pub p: f64,
    /// Count and expectation of the bins too rare to join any pool, which are tested as one Poisson number.
    pub rest: (u64, f64),
    /// Probability of a count in `rest` at least as large.
    pub p_rest: f64,
}

/// Compares counts with expectations; both hold a bin each, in the same order.
///
/// Bins are taken in the order of their expectations and pooled until a pool expects five. What remains below that
/// (it is all there is when the density is zero in those bins) is tested apart, for an excess only.
pub fn pearson(observed: &[u64], expected: &[f64]) -> Pearson {
    assert_eq!(observed.len(), expected.len(), "as many counts as expectations");
    let mut order: Vec<usize> = (0..expected.len()).collect();
    order.sort_by(|&a, &b| expected[b].total_cmp(&expected[a]).then(a.cmp(&b)));
    let (mut statistic, mut pools) = (0.0, 0_usize);
    let mut rest = (0_u64, 0.0_f64);
    for bin in order {
        rest.0 += observed[bin];
        rest.1 += expected[bin];
        if rest.1 >= MIN_EXPECTED {
            let difference = rest.0 as f64 - rest.1;
            statistic += difference * difference / rest.1;
            pools += 1;
            rest = (0, 0.0);
        }
    }
    let degrees = pools.saturating_sub(1);
    let total: u64 = observed.iter().sum();
    let allowed = rest.1 + ROUNDING_SHARE * total as f64;
    Pearson {
        statistic,
        degrees,
        p: chi_squared_tail(statistic, degrees),
        rest,
        p_rest: poisson_upper_tail(rest.0, allowed),
    }
}

/// One view of a table of bins: its name, its counts and expectations, and the name of each bin.
pub(super) struct View<'a> {
    pub(super) name: &'a str,
    pub(super) observed: Vec<u64>,
    pub(super) expected: Vec<f64>,
    pub(super) label: &'a dyn Fn(usize) -> String,
}

/// Tests each view, sharing the significance among them and among `tests` tests of the caller.
pub(super) fn verdict(views: &[View], significance: f64, tests: usize) -> Result<(), String> {
    // Each view asks two questions: the pools, and the rest.
    let threshold = per_test(significance, tests.max(1) * views.len() * 2);
    for view in views {
        let outcome = pearson(&view.observed, &view.expected);
        if !(outcome.p >= threshold && outcome.p_rest >= threshold) {
            return Err(describe(view, &outcome, threshold));
        }
    }
    Ok(())
}

/// The message of a failed view: the figures, and the bins that contribute most.
fn describe(view: &View, outcome: &Pearson, threshold: f64) -> String {
    let mut text = format!(
        "chi2 over {}: p = {:.3e} is below {threshold:.3e} (chi2 = {:.2}, {} degrees of freedom)",
        view.name, outcome.p, outcome.statistic, outcome.degrees
    );
    if outcome.p >= threshold {
        let (count, mean) = outcome.rest;
        text = format!(
            "chi2 over {}: {count} samples where the density expects {mean:.4} (p = {:.3e}, threshold {threshold:.3e})",
            view.name, outcome.p_rest
        );
    }
    let term = |bin: usize| {
        let difference = view.observed[bin] as f64 - view.expected[bin];
        difference * difference / view.expected[bin].max(ROUNDING_SHARE)
    };
    let mut bins: Vec<usize> = (0..view.observed.len()).collect();
    bins.sort_by(|&a, &b| term(b).total_cmp(&term(a)).then(a.cmp(&b)));
    for bin in bins.into_iter().take(WORST).filter(|&bin| term(bin) > 1.0) {
        let name = (view.label)(bin);
        // Writing to a string can't fail.
        let _ =
            write!(text, "\n  {name}: observed {}, expected {:.2}", view.observed[bin], view.expected[bin]);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Rng;

    #[test]
    fn the_statistic_is_the_textbook_one() {
        // A die thrown 60 times.
        let outcome = pearson(&[5, 8, 9, 8, 10, 20], &[10.0; 6]);
        assert!((outcome.statistic - 13.4).abs() < 1e-12);
        assert_eq!(outcome.degrees, 5);
        assert!((outcome.p - 0.019_9).abs() < 0.000_1, "{}", outcome.p);
    }

    #[test]
    fn rare_bins_are_pooled_and_the_remainder_is_tested_apart() {
        let outcome = pearson(&[50, 3, 2, 1, 0], &[48.0, 3.0, 3.0, 1.0, 1.0]);
        assert_eq!((outcome.degrees, outcome.rest), (1, (1, 2.0)));
        assert!((outcome.statistic - (4.0 / 48.0 + 1.0 / 6.0)).abs() < 1e-12);
        assert!(pearson(&[1_000_000, 40], &[1_000_000.0, 0.0]).p_rest < 1e-9);
        assert!(pearson(&[1_000_000, 2], &[1_000_000.0, 0.0]).p_rest > 0.1);
    }

    #[test]
    fn p_values_of_right_densities_are_uniform() {
        let mut rng = Rng::new(11);
        let expected = [400.0, 300.0, 200.0, 60.0, 30.0, 6.0, 2.0, 1.0, 1.0];
        let mut deciles = [0_u64; 10];
        for _ in 0..3000 {
            let mut observed = [0_u64; 9];
            for _ in 0..1000 {
                let mut u = rng.next_f64() * 1000.0;
                let bin = expected.iter().position(|e| {
                    u -= e;
                    u < 0.0
                });
                observed[bin.unwrap_or(0)] += 1;
            }
            let p = pearson(&observed, &expected).p;
            deciles[((p * 10.0) as usize).min(9)] += 1;
        }
        let outcome = pearson(&deciles, &[300.0; 10]);
        assert!(outcome.p > 1e-4, "{deciles:?}");
    }

    #[test]
    fn a_failure_names_the_worst_bins() {
        let label = |bin: usize| format!("bin {bin}");
        let view =
            View { name: "letters", observed: vec![100, 300], expected: vec![200.0, 200.0], label: &label };
        let message = verdict(&[view], 0.01, 1).unwrap_err();
        assert!(message.starts_with("chi2 over letters: p = "), "{message}");
        assert!(message.contains("chi2 = 100.00, 1 degrees of freedom"), "{message}");
        assert!(message.contains("bin 0: observed 100, expected 200.00"), "{message}");
    }
}
