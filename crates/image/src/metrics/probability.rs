//! The few functions of probability that the tests need.

use std::f64::consts::PI;

/// The complementary error function `2/√π ∫ₓ^∞ exp(−t²) dt`; relative error below 1e-12 until it underflows at 27.
///
/// `erfc(|z| / √2)` is the two-sided p-value of a normal deviate `z`.
///
/// Source: Abramowitz, Stegun 1964, equations 7.1.6 (series, small arguments) and 7.1.14 (continued fraction).
pub fn erfc(x: f64) -> f64 {
    if x.is_nan() {
        return x;
    }
    if x < 0.0 {
        return 2.0 - erfc(-x);
    }
    if x < 2.0 {
        let (mut term, mut sum, mut n) = (x, x, 0.0);
        while term > sum * 1e-17 {
            n += 1.0;
            term *= 2.0 * x * x / (2.0 * n + 1.0);
            sum += term;
        }
        return 1.0 - 2.0 / PI.sqrt() * (-x * x).exp() * sum;
    }
    // Evaluated from the inside out; at 2, the slowest argument, 100 terms are more than enough.
    let mut fraction = x;
    for n in (1..=100).rev() {
        fraction = x + 0.5 * f64::from(n) / fraction;
    }
    (-x * x).exp() / (PI.sqrt() * fraction)
}

/// The probability that the smallest of `count` independent p-values is at most `p`: `1 − (1 − p)^count`.
///
/// Source: Šidák 1967, *Rectangular confidence regions for the means of multivariate normal distributions*.
pub fn sidak(p: f64, count: usize) -> f64 {
    -(count as f64 * (-p).ln_1p()).exp_m1()
}

/// The probability that a χ² variable of `2 a` degrees of freedom exceeds `2 x`: the regularised incomplete gamma
/// function Q(a, x), by the cube-root normal approximation.
///
/// Source: Wilson, Hilferty 1931, *The distribution of chi-square*.
pub(super) fn gamma_q(a: f64, x: f64) -> f64 {
    let spread = 1.0 / (9.0 * a);
    let deviate = ((x / a).cbrt() - (1.0 - spread)) / spread.sqrt();
    0.5 * erfc(deviate / 2.0_f64.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn erfc_has_its_tabled_values() {
        // From Python's `math.erfc`.
        let table = [
            (0.0, 1.0),
            (0.5, 0.479_500_122_186_953_5),
            (1.0, 0.157_299_207_050_285_13),
            (1.999_999, 4.677_755_648_073_953e-3),
            (2.0, 4.677_734_981_047_265e-3),
            (3.0, 2.209_049_699_858_543_8e-5),
            (5.0, 1.537_459_794_428_035_1e-12),
            (10.0, 2.088_487_583_762_545e-45),
        ];
        for (x, expected) in table {
            assert!((erfc(x) / expected - 1.0).abs() < 1e-12, "erfc({x}) = {}", erfc(x));
            assert!((erfc(-x) - (2.0 - expected)).abs() < 1e-15);
        }
        assert_eq!(erfc(f64::INFINITY), 0.0);
        assert_eq!(erfc(f64::NEG_INFINITY), 2.0);
        assert!(erfc(f64::NAN).is_nan());
    }

    #[test]
    fn sidak_is_exact_for_small_and_large_p() {
        assert!((sidak(0.5, 2) - 0.75).abs() < 1e-15);
        assert!((sidak(1e-20, 1000) / 1e-17 - 1.0).abs() < 1e-12);
        assert_eq!(sidak(1.0, 3), 1.0);
        assert_eq!(sidak(0.3, 0), 0.0);
    }

    #[test]
    fn gamma_q_is_close_to_tabled_chi_squares() {
        // 95 % points of χ² with 10, 100 and 1000 degrees of freedom.
        for (degrees, point) in [(10.0, 18.307), (100.0, 124.342), (1000.0, 1074.679)] {
            let p = gamma_q(degrees / 2.0, point / 2.0);
            assert!((p - 0.05).abs() < 5e-4, "{degrees}: {p}");
        }
    }
}
