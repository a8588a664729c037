//! Gamma and beta functions, and the tails of the normal, chi², Student and Poisson distributions.

use std::f64::consts::{PI, SQRT_2};

/// Terms of a series or a continued fraction after which it counts as converged: the loops below need about the square
/// root of their argument, so that this covers a million degrees of freedom.
const MAX_TERMS: usize = 100_000;
/// Stands for zero in Lentz's algorithm, which divides by its running terms.
const TINY: f64 = 1e-300;

/// `ln Γ(x)` for `x > 0`, with a relative error of some 1e-14.
///
/// Stirling's series, after the recurrence has carried the argument above 10. Source: Abramowitz and Stegun,
/// *Handbook of Mathematical Functions*, 1964, 6.1.40 and 6.1.15.
pub fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut factor) = (x, 1.0);
    while x < 10.0 {
        factor *= x;
        x += 1.0;
    }
    let r = 1.0 / (x * x);
    let series = 1.0 / 12.0 - r * (1.0 / 360.0 - r * (1.0 / 1260.0 - r * (1.0 / 1680.0 - r / 1188.0)));
    (x - 0.5) * x.ln() - x + 0.5 * (2.0 * PI).ln() + series / x - factor.ln()
}

/// The regularised lower incomplete gamma function `P(a, x)`, for `a > 0` and `x ≥ 0`.
pub fn gamma_lower(a: f64, x: f64) -> f64 {
    if x < a + 1.0 { gamma_series(a, x) } else { 1.0 - gamma_fraction(a, x) }
}

/// The regularised upper incomplete gamma function `Q(a, x) = 1 − P(a, x)`, accurate where it is small.
pub fn gamma_upper(a: f64, x: f64) -> f64 {
    if x < a + 1.0 { 1.0 - gamma_series(a, x) } else { gamma_fraction(a, x) }
}

/// `xᵃ e⁻ˣ / Γ(a)`: what the series and the fraction have in common.
fn gamma_prefix(a: f64, x: f64) -> f64 {
    (a * x.ln() - x - ln_gamma(a)).exp()
}

/// `P(a, x)` by its power series (Abramowitz and Stegun 6.5.29), which converges fast for `x < a + 1`.
fn gamma_series(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let mut term = 1.0 / a;
    let mut sum = term;
    for n in 1..MAX_TERMS {
        term *= x / (a + n as f64);
        sum += term;
        if term < sum * f64::EPSILON {
            break;
        }
    }
    sum * gamma_prefix(a, x)
}

/// `Q(a, x)` by its continued fraction (Abramowitz and Stegun 6.5.31), which converges fast for `x > a + 1`.
fn gamma_fraction(a: f64, x: f64) -> f64 {
    if x.is_infinite() {
        return 0.0;
    }
    let step = |n: f64| (n * (a - n), x + 2.0 * n + 1.0 - a);
    gamma_prefix(a, x) / lentz(x + 1.0 - a, step)
}

/// `b0 + a1 / (b1 + a2 / (b2 + ...))`, where `step(n)` gives `(aₙ, bₙ)`.
///
/// Source: Lentz, *Generating Bessel Functions in Mie Scattering Calculations Using Continued Fractions*, Applied
/// Optics 15(3), 1976, as modified by Thompson and Barnett 1986.
fn lentz(b0: f64, step: impl Fn(f64) -> (f64, f64)) -> f64 {
    let away_from_zero = |v: f64| if v.abs() < TINY { TINY } else { v };
    let mut value = away_from_zero(b0);
    let (mut numerator, mut denominator) = (value, 0.0);
    for n in 1..MAX_TERMS {
        let (a, b) = step(n as f64);
        denominator = 1.0 / away_from_zero(b + a * denominator);
        numerator = away_from_zero(b + a / numerator);
        let change = numerator * denominator;
        value *= change;
        if (change - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    value
}

/// The regularised incomplete beta function `I_x(a, b)`, for `a, b > 0` and `x` in [0, 1].
///
/// Source: Abramowitz and Stegun 26.5.8 (continued fraction) and 26.5.2 (symmetry, for the side that converges fast).
pub fn beta_regularized(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta_regularized(b, a, 1.0 - x);
    }
    let prefix = (ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * x.ln() + b * (-x).ln_1p()).exp() / a;
    let step = |n: f64| {
        let m = (n / 2.0).floor();
        let numerator = if n % 2.0 == 0.0 {
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
        } else {
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0))
        };
        (numerator, 1.0)
    };
    prefix / lentz(1.0, step)
}

/// The probability that a standard normal number is below `z`.
pub fn normal_cdf(z: f64) -> f64 {
    let tail = 0.5 * two_sided(z);
    if z < 0.0 { tail } else { 1.0 - tail }
}

/// The probability that a standard normal number is farther from zero than `z`: the two-sided p-value of a z score.
///
/// NaN counts as certain failure, zero.
pub fn two_sided(z: f64) -> f64 {
    if z.is_nan() {
        return 0.0;
    }
    let x = z.abs() / SQRT_2;
    gamma_upper(0.5, x * x)
}

/// The probability that a chi² number with `degrees` degrees of freedom exceeds `statistic`; one without any degree.
pub fn chi_squared_tail(statistic: f64, degrees: usize) -> f64 {
    if degrees == 0 { 1.0 } else { gamma_upper(degrees as f64 / 2.0, statistic / 2.0) }
}

/// The probability that a Poisson count of mean `mean` is at least `count`.
pub fn poisson_upper_tail(count: u64, mean: f64) -> f64 {
    if count == 0 { 1.0 } else { gamma_lower(count as f64, mean) }
}

/// The probability that a Student number with `degrees` degrees of freedom is farther from zero than `t`.
pub fn student_two_sided(t: f64, degrees: f64) -> f64 {
    if t.is_nan() {
        return 0.0;
    }
    if t.is_infinite() || degrees.is_infinite() {
        return two_sided(t);
    }
    beta_regularized(degrees / 2.0, 0.5, degrees / (degrees + t * t))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn assert_near(value: f64, expected: f64, relative: f64) {
        assert!((value - expected).abs() <= relative * expected.abs(), "{value} instead of {expected}");
    }

    #[test]
    fn ln_gamma_gives_factorials_and_the_half() {
        let mut factorial = 1.0_f64;
        for n in 1..30 {
            factorial *= f64::from(n);
            assert!(
                (ln_gamma(f64::from(n) + 1.0) - factorial.ln()).abs() < 1e-12 * factorial.ln().max(1.0),
                "{n}"
            );
        }
        assert_near(ln_gamma(0.5), PI.sqrt().ln(), 1e-13);
    }

    #[test]
    fn tails_agree_with_tables() {
        // Abramowitz and Stegun, tables 26.1 (normal), 26.8 (chi²) and 26.10 (Student).
        assert_near(normal_cdf(1.0), 0.841_344_746_068_543, 1e-12);
        assert_near(normal_cdf(-3.0), 0.001_349_898_031_630_09, 1e-12);
        assert_near(two_sided(1.959_963_984_540_054), 0.05, 1e-12);
        assert_near(chi_squared_tail(3.841_458_820_694_124, 1), 0.05, 1e-10);
        assert_near(chi_squared_tail(18.307_038_053_275_14, 10), 0.05, 1e-10);
        assert_near(student_two_sided(2.228_138_851_964_939, 10.0), 0.05, 1e-10);
        assert_near(student_two_sided(12.706_204_736_432_1, 1.0), 0.05, 1e-10);
    }

    #[test]
    fn closed_forms_are_met() {
        for x in [0.01, 0.5, 1.0, 3.0, 30.0] {
            assert_near(gamma_upper(1.0, x), (-x).exp(), 1e-12);
            assert_near(chi_squared_tail(x, 2), (-x / 2.0).exp(), 1e-12);
            assert_near(poisson_upper_tail(1, x), -(-x).exp_m1(), 1e-12);
            assert_near(student_two_sided(x, 1.0), 1.0 - 2.0 / PI * x.atan(), 1e-10);
        }
        for x in [0.1, 0.4, 0.9] {
            assert_near(beta_regularized(2.0, 1.0, x), x * x, 1e-12);
            assert_near(beta_regularized(1.0, 3.0, x), 1.0 - (1.0 - x).powi(3), 1e-12);
        }
    }

    #[test]
    fn a_million_degrees_of_freedom_converge_to_the_normal() {
        let degrees = 1_000_000;
        let n = f64::from(degrees);
        for z in [-2.0, 0.0, 2.0] {
            let tail = chi_squared_tail(n + z * (2.0 * n).sqrt(), degrees as usize);
            assert!((tail - normal_cdf(-z)).abs() < 1e-3, "z {z}: {tail}");
        }
    }

    #[test]
    fn extremes_are_the_limits() {
        assert_eq!(two_sided(f64::NAN), 0.0);
        assert_eq!(two_sided(f64::INFINITY), 0.0);
        assert_eq!(two_sided(0.0), 1.0);
        assert_eq!(chi_squared_tail(f64::INFINITY, 4), 0.0);
        assert_eq!(chi_squared_tail(5.0, 0), 1.0);
        assert_eq!(poisson_upper_tail(0, 3.0), 1.0);
        assert_eq!(poisson_upper_tail(2, 0.0), 0.0);
    }
}
