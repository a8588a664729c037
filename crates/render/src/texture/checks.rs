//! Checkerboards, smoothed over the footprint of a pixel.
//!
//! Fields of one alternate with fields of minus one along each axis, and the sign of their product tells even fields from odd
//! ones. Along each axis the alternation is averaged with the weights of a triangle as wide as the footprint to either side, which
//! takes its second integral. As in pbrt-v4, whose width this is. Deviation: in double precision, for differences of second integrals
//! lose the digits of a narrow filter.

use sahl_math::{Vec2, Vec3};

use super::Footprint;
use super::mapping::Differentials;

/// Widths of a filter over the change of coordinates to the next pixel.
const WIDTH: f32 = 1.5;

/// How far the filter reaches along s and t.
pub(super) fn reach(differentials: &Differentials) -> [f32; 2] {
    let Vec2 { x, y } = differentials.dx.abs().max(differentials.dy.abs());
    [x * WIDTH, y * WIDTH]
}

/// How far it reaches along the axes of a space; `to_texture` leads there from directions in the world.
pub(super) fn solid_reach(footprint: &Footprint, to_texture: impl Fn(Vec3) -> Vec3) -> [f32; 3] {
    let [dx, dy] = [footprint.dp_dx, footprint.dp_dy].map(|dp| <[f32; 3]>::from(to_texture(dp)));
    std::array::from_fn(|i| dx[i].abs().max(dy[i].abs()) * WIDTH)
}

/// The share of odd fields about a place: those in which the integer parts of the coordinates have an odd sum.
#[inline]
pub(super) fn odd_share<const N: usize>(place: [f32; N], reach: [f32; N]) -> f32 {
    let product: f32 = place.into_iter().zip(reach).map(|(x, reach)| alternation(x, reach)).product();
    0.5 - 0.5 * product
}

/// The mean about `x` of what is one in [0, 1), minus one in [1, 2), and so on.
#[inline]
fn alternation(x: f32, reach: f32) -> f32 {
    if !(reach > 0.0 && reach.is_finite()) || (x - reach).floor() == (x + reach).floor() {
        // Casts saturate.
        return if x.floor() as i64 & 1 == 0 { 1.0 } else { -1.0 };
    }
    let (x, r) = (f64::from(x).rem_euclid(2.0), f64::from(reach));
    ((second_integral(x + r) - 2.0 * second_integral(x) + second_integral(x - r)) / (r * r)) as f32
}

/// A function whose second derivative is the alternation.
#[inline]
fn second_integral(x: f64) -> f64 {
    let y = 0.5 * x - (0.5 * x).floor() - 0.5;
    0.5 * x + y * (1.0 - 2.0 * y.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_see_the_field_they_are_in() {
        for (place, odd) in [([0.3, 0.9], 0.0), ([1.3, 0.9], 1.0), ([-0.3, 0.9], 1.0), ([-0.3, -7.9], 1.0)] {
            assert_eq!(odd_share(place, [0.0; 2]), odd);
            assert_eq!(odd_share(place, [0.05; 2]), odd, "no border is near");
        }
        assert_eq!(odd_share([1e30, f32::INFINITY], [f32::NAN, 0.0]), 0.0);
        assert_eq!(odd_share([0.5; 3], [0.0; 3]), 0.0);
    }

    #[test]
    fn the_filter_is_a_triangle() {
        for (x, reach) in [(0.1_f32, 0.3_f32), (1.0, 0.01), (-3.2, 0.7), (5.4, 2.6), (1000.999, 0.002)] {
            let n = 20_000;
            let mean = (0..n).map(|i| {
                let offset = 2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0;
                let at = f64::from(x) + offset * f64::from(reach);
                2.0 * (1.0 - offset.abs()) / f64::from(n)
                    * if at.floor().rem_euclid(2.0) < 1.0 { 1.0 } else { -1.0 }
            });
            let expected: f64 = mean.sum();
            let found = f64::from(alternation(x, reach));
            assert!((found - expected).abs() < 2e-3, "{x} {reach}: {found} instead of {expected}");
        }
    }

    #[test]
    fn wide_footprints_see_grey_and_none_changes_the_mean() {
        assert!((odd_share([0.3, 0.4], [1e4, 0.0]) - 0.5).abs() < 1e-6);
        assert!((odd_share([0.3], [1e30]) - 0.5).abs() < 1e-6);
        let n = 1000_u16;
        let mean = |reach| {
            let sum: f32 = (0..n).map(|i| odd_share([2.0 * f32::from(i) / f32::from(n)], [reach])).sum();
            sum / f32::from(n)
        };
        assert!([0.0, 0.05, 0.4, 1.7].into_iter().all(|reach| (mean(reach) - 0.5).abs() < 2e-3));
    }
}
