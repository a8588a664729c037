//! Running moments, and Welch's test of two means.

use super::student_two_sided;

/// Count, mean and variance of numbers given one at a time.
///
/// Source: Welford, *Note on a Method for Calculating Corrected Sums of Squares and Products*, Technometrics 4(3),
/// 1962; the merge is that of Chan, Golub, LeVeque 1979.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Running {
    count: u64,
    mean: f64,
    squares: f64,
}

impl Running {
    /// Takes one number in.
    pub fn add(&mut self, value: f64) {
        self.count += 1;
        let before = value - self.mean;
        self.mean += before / self.count as f64;
        self.squares += before * (value - self.mean);
    }

    /// Takes in all numbers that `other` has seen.
    pub fn merge(&mut self, other: &Self) {
        let count = self.count + other.count;
        if count == 0 {
            return;
        }
        let difference = other.mean - self.mean;
        let share = other.count as f64 / count as f64;
        self.mean += difference * share;
        self.squares += other.squares + difference * difference * self.count as f64 * share;
        self.count = count;
    }

    /// How many numbers.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Their mean; zero without any.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// The unbiased estimate of the variance of the distribution they come from; zero for fewer than two.
    pub fn variance(&self) -> f64 {
        if self.count < 2 { 0.0 } else { self.squares / (self.count - 1) as f64 }
    }

    /// The estimated variance of [`Running::mean`] itself; zero for fewer than two.
    pub fn variance_of_mean(&self) -> f64 {
        if self.count < 2 { 0.0 } else { self.variance() / self.count as f64 }
    }
}

impl Extend<f64> for Running {
    fn extend<T: IntoIterator<Item = f64>>(&mut self, values: T) {
        values.into_iter().for_each(|value| self.add(value));
    }
}

impl FromIterator<f64> for Running {
    fn from_iter<T: IntoIterator<Item = f64>>(values: T) -> Self {
        let mut running = Self::default();
        running.extend(values);
        running
    }
}

/// The two-sided p-value that `a` and `b` have the same mean, whatever their variances.
///
/// One when both are constant and equal; zero when constant and different. Each side needs two numbers.
///
/// Source: Welch, *The Generalization of 'Student's' Problem when Several Different Population Variances are
/// Involved*, Biometrika 34, 1947. Used on renders by Jung, Hanika, Dachsbacher, JCGT 9(2), 2020.
pub fn welch(a: &Running, b: &Running) -> f64 {
    let (variance_a, variance_b) = (a.variance_of_mean(), b.variance_of_mean());
    let variance = variance_a + variance_b;
    let difference = a.mean() - b.mean();
    if variance == 0.0 {
        return if difference == 0.0 { 1.0 } else { 0.0 };
    }
    let part = |v: f64, count: u64| if count < 2 { 0.0 } else { v * v / (count - 1) as f64 };
    let degrees = variance * variance / (part(variance_a, a.count()) + part(variance_b, b.count()));
    student_two_sided(difference / variance.sqrt(), degrees)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Rng;

    #[test]
    fn moments_survive_a_large_offset() {
        let values = [1e9 + 4.0, 1e9 + 7.0, 1e9 + 13.0, 1e9 + 16.0];
        let running: Running = values.into_iter().collect();
        assert_eq!((running.count(), running.mean(), running.variance()), (4, 1e9 + 10.0, 30.0));
        assert_eq!(running.variance_of_mean(), 7.5);
    }

    #[test]
    fn merging_is_adding() {
        let mut rng = Rng::new(3);
        let values: Vec<f64> = (0..1000).map(|_| rng.next_f64()).collect();
        let whole: Running = values.iter().copied().collect();
        let mut merged: Running = values[..137].iter().copied().collect();
        merged.merge(&values[137..].iter().copied().collect());
        merged.merge(&Running::default());
        assert_eq!(merged.count(), whole.count());
        assert!((merged.mean() - whole.mean()).abs() < 1e-14);
        assert!((merged.variance() - whole.variance()).abs() < 1e-14);
    }

    #[test]
    fn welch_agrees_with_a_worked_example() {
        let a: Running = [3.0, 4.0, 5.0, 6.5].into_iter().collect();
        let b: Running = [5.0, 9.0, 7.0, 8.0, 10.5].into_iter().collect();
        // t = −2.7509 with 6.9644 degrees of freedom.
        assert!((welch(&a, &b) - 0.028_608_643_5).abs() < 1e-8, "{}", welch(&a, &b));
        assert_eq!(welch(&a, &b), welch(&b, &a));
    }

    #[test]
    fn welch_of_equal_means_is_uniform_and_of_different_means_small() {
        let mut rng = Rng::new(4);
        let mut below = 0;
        for _ in 0..2000 {
            let a: Running = (0..10).map(|_| rng.normal()).collect();
            let b: Running = (0..25).map(|_| 3.0 * rng.normal()).collect();
            below += usize::from(welch(&a, &b) < 0.1);
        }
        assert!((140..=260).contains(&below), "{below} of 2000 below 0.1");
        let a: Running = (0..100).map(|_| rng.normal()).collect();
        let b: Running = (0..100).map(|_| 2.0 + rng.normal()).collect();
        assert!(welch(&a, &b) < 1e-12);
    }

    #[test]
    fn constants_are_compared_exactly() {
        let a: Running = [2.0, 2.0].into_iter().collect();
        let b: Running = [3.0, 3.0].into_iter().collect();
        assert_eq!((welch(&a, &a), welch(&a, &b)), (1.0, 0.0));
    }
}
