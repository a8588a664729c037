//! Choices among finitely many outcomes.

use super::SEED;
use super::pearson::{View, verdict};
use crate::random::Rng;

/// The test of a choice against its probabilities: alias tables, lobes, lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscreteTest {
    /// How many choices are drawn.
    pub samples: usize,
    /// Probability that a family of `tests` right tests fails.
    pub significance: f64,
    /// How many tests share the significance.
    pub tests: usize,
}

impl Default for DiscreteTest {
    fn default() -> Self {
        Self { samples: 1_000_000, significance: 0.01, tests: 1 }
    }
}

impl DiscreteTest {
    /// Draws choices from uniform numbers in [0, 1) and compares them with `probabilities`.
    ///
    /// `None` is a failed draw; the probabilities may sum to less than one accordingly. Fails on an index beyond the
    /// probabilities, on a negative probability or NaN, and on a sum above one.
    pub fn run(
        &self,
        mut sample: impl FnMut(f32) -> Option<usize>,
        probabilities: &[f32],
    ) -> Result<(), String> {
        if let Some(i) = probabilities.iter().position(|p| !(p.is_finite() && *p >= 0.0)) {
            return Err(format!("probability {i} is {}", probabilities[i]));
        }
        let total: f64 = probabilities.iter().map(|&p| f64::from(p)).sum();
        if total > 1.0 + 1e-5 {
            return Err(format!("the probabilities sum to {total}"));
        }
        let mut observed = vec![0_u64; probabilities.len() + 1];
        let mut rng = Rng::new(SEED);
        for _ in 0..self.samples {
            let choice = sample(rng.next_f32());
            match choice {
                Some(i) if i >= probabilities.len() => {
                    return Err(format!("sampled {i} of {}", probabilities.len()));
                }
                _ => observed[choice.unwrap_or(probabilities.len())] += 1,
            }
        }
        let n = self.samples as f64;
        let mut expected: Vec<f64> = probabilities.iter().map(|&p| f64::from(p) * n).collect();
        expected.push((1.0 - total).max(0.0) * n);
        let label =
            |i: usize| if i < probabilities.len() { format!("outcome {i}") } else { "failed draws".into() };
        verdict(
            &[View { name: "outcomes", observed, expected, label: &label }],
            self.significance,
            self.tests,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PROBABILITIES: [f32; 4] = [0.5, 0.25, 0.0, 0.15];

    /// Inverts the distribution; the last tenth fails.
    fn choose(mut u: f32, probabilities: &[f32]) -> Option<usize> {
        probabilities.iter().position(|p| {
            u -= p;
            u < 0.0
        })
    }

    #[test]
    fn right_probabilities_pass() {
        DiscreteTest::default().run(|u| choose(u, &PROBABILITIES), &PROBABILITIES).unwrap();
    }

    #[test]
    fn wrong_probabilities_fail() {
        let test = DiscreteTest::default();
        let off_by_a_hundredth = [0.505, 0.245, 0.0, 0.15];
        test.run(|u| choose(u, &off_by_a_hundredth), &PROBABILITIES).unwrap_err();
        let scaled = PROBABILITIES.map(|p| p * 1.01);
        test.run(|u| choose(u, &PROBABILITIES), &scaled).unwrap_err();
        let impossible = |u: f32| if u < 1e-4 { Some(2) } else { choose(u, &PROBABILITIES) };
        test.run(impossible, &PROBABILITIES).unwrap_err();
    }

    #[test]
    fn nonsense_is_told() {
        let test = DiscreteTest { samples: 10, ..DiscreteTest::default() };
        assert_eq!(test.run(|_| Some(4), &PROBABILITIES), Err("sampled 4 of 4".into()));
        assert_eq!(test.run(|_| None, &[0.5, f32::NAN]), Err("probability 1 is NaN".into()));
        assert_eq!(test.run(|_| None, &[1.0, 0.5]), Err("the probabilities sum to 1.5".into()));
    }
}
