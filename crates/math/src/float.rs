//! Scalars: rounding-error bounds, accurate small expressions, and a stable quadratic solver.

/// Half the distance from one to the next larger `f32`: the largest relative error of one rounding.
const UNIT_ROUNDOFF: f32 = f32::EPSILON * 0.5;

/// γₙ = n u / (1 − n u): bounds the relative error of `n` rounded operations in a row.
///
/// Source: Higham, *Accuracy and Stability of Numerical Algorithms*, 2002, lemma 3.1.
#[inline]
pub const fn gamma(n: u32) -> f32 {
    let nu = n as f32 * UNIT_ROUNDOFF;
    nu / (1.0 - nu)
}

/// The smallest `f32` greater than `x`; infinity and NaN stay.
#[inline]
pub fn next_float_up(x: f32) -> f32 {
    x.next_up()
}

/// The largest `f32` less than `x`; minus infinity and NaN stay.
#[inline]
pub fn next_float_down(x: f32) -> f32 {
    x.next_down()
}

/// `a b − c d` without catastrophic cancellation.
///
/// A product of two `f32` is exact in `f64`, so that only the subtraction and the final conversion round: the error is
/// below 1 ulp of the result. Kahan's fused form gives 1.5 ulp, and is slow where the processor baseline has no FMA.
#[inline]
pub fn difference_of_products(a: f32, b: f32, c: f32, d: f32) -> f32 {
    (f64::from(a) * f64::from(b) - f64::from(c) * f64::from(d)) as f32
}

/// Linear interpolation: `a` at `t = 0` and `b` at `t = 1`, both exactly.
#[inline]
pub fn lerp(t: f32, a: f32, b: f32) -> f32 {
    (1.0 - t) * a + t * b
}

/// The square root, zero for arguments that rounding made slightly negative.
#[inline]
pub fn safe_sqrt(x: f32) -> f32 {
    x.max(0.0).sqrt()
}

/// The arc sine, in radians, of `x` clamped to [−1, 1].
#[inline]
pub fn safe_asin(x: f32) -> f32 {
    x.clamp(-1.0, 1.0).asin()
}

/// The arc cosine, in radians, of `x` clamped to [−1, 1].
#[inline]
pub fn safe_acos(x: f32) -> f32 {
    x.clamp(-1.0, 1.0).acos()
}

/// The real roots of `a t² + b t + c = 0` in ascending order, without cancellation; `None` if there is none.
///
/// A linear equation (`a = 0`) gives its root twice. Source: Press et al., *Numerical Recipes*, 2007, section 5.6.
#[inline]
pub fn solve_quadratic(a: f64, b: f64, c: f64) -> Option<(f64, f64)> {
    if a == 0.0 {
        return (b != 0.0).then(|| (-c / b, -c / b));
    }
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 || !discriminant.is_finite() {
        return None;
    }
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    if q == 0.0 {
        return Some((0.0, 0.0));
    }
    let (t0, t1) = (q / a, c / q);
    Some(if t0 <= t1 { (t0, t1) } else { (t1, t0) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadratic_keeps_the_small_root() {
        let (t0, t1) = solve_quadratic(1.0, -1e8, 1.0).unwrap();
        assert!((t0 - 1e-8).abs() < 1e-22, "{t0}");
        assert!((t1 - 1e8).abs() < 1e-6);
        assert_eq!(solve_quadratic(1.0, 0.0, 1.0), None);
        assert_eq!(solve_quadratic(0.0, 2.0, -4.0), Some((2.0, 2.0)));
        assert_eq!(solve_quadratic(0.0, 0.0, 1.0), None);
        assert_eq!(solve_quadratic(2.0, 0.0, 0.0), Some((0.0, 0.0)));
    }

    #[test]
    fn difference_of_products_is_exact_where_f32_cancels() {
        let a = 1.0 + f32::EPSILON;
        assert_eq!(difference_of_products(a, a, 1.0, 1.0 + 2.0 * f32::EPSILON), f32::EPSILON * f32::EPSILON);
    }

    #[test]
    fn gamma_bounds_a_sum() {
        let n = 1000;
        let sum: f32 = (0..n).map(|_| 0.1_f32).sum();
        let exact = f64::from(0.1_f32) * f64::from(n);
        assert!((f64::from(sum) - exact).abs() <= f64::from(gamma(n)) * exact);
    }
}
